"""Sixty and more further slips, written without a look at the checks: by kind, the base and the changes of each.

They measure; the checks were not made from them, and the bank is not fitted: what stays silent is counted.
"""

from tests.feasibility.slips import BREAKS, GOODS_IN, PICKS, closed, draws, flow, kinds, people, prices

PACKING = "layout.stations.packing"


def arrivals(**what):
    return flow(arrivals=what)


def hours(calendar, key="fleet.hours"):
    return {"calendars": {"shift": calendar}, key: "shift"}


def battery(**what):
    return {f"battery.{key}": value for key, value in what.items()}


def classes(*pairs):
    return {"tasks.popularity": {"classes": [{"share": share, "demand": demand} for share, demand in pairs]}}


SLIPS = {
    "a plain number for minutes or hours": {
        "at work from 6 to 14": ("goods", hours({"between": [[6, 14]]})),
        "a pause of half an hour every 8": ("goods", hours({"every": 8, "lasts": 0.5}, f"{PACKING}.hours")),
        "closed from minute 120 to 240": ("goods", closed({"between": [[120, 240]]})),
        "work of 1 to 4 minutes": ("goods", {f"{PACKING}.work_time": {"triangular": [1, 2, 4]}}),
        "picking takes a quarter of a minute": ("goods", {"tasks.load_time": {"lognormal": {"mean": 0.25, "cv": 0.5}}}),
        "due within 15 minutes": ("flows", flow(due_within=15)),
        "due within 2 hours": ("flows", flow(due_within=2)),
        "lorries at minutes 840 and 1080": (
            "flows",
            {"tasks.flows.picks": {**{k: v for k, v in PICKS.items() if k != "due_within"}, "due_at": [840, 1080]}},
        ),
        "people stay for 2 to 5 minutes": ("goods", people(stay={"uniform": [2, 5]})),
        "breaks down after some 50 hours": (
            "goods",
            {BREAKS: {"every": {"weibull": {"shape": 2, "scale": 50}}, "repair": "15 min"}},
        ),
        "chargers are mended in some 45 minutes": (
            "goods",
            {"layout.bays.chargers.outages": {"every": "50 h", "repair": {"lognormal": {"mean": 45, "cv": 0.5}}}},
        ),
        "towed away in 3 to 8 minutes": (
            "goods",
            {BREAKS: {"every": "8 h", "repair": "1 h", "clear": {"uniform": [3, 8]}}},
        ),
        "a run of 8 hours": ("goods", {"run": {"length": 8, "warm_up": 1}}),
        "a warm-up of 30 minutes": ("goods", {"run": {"length": "8 h", "warm_up": 30}}),
        "a rate for each hour": ("flows", arrivals(profile={"per_hour": [50, 100, 150, 100], "every": 1})),
        "batches of a quarter of an hour": (
            "goods",
            {"policies.batching": {"name": "time-window", "window": 15}, "fleet.robot.capacity": 3},
        ),
        "waves at minutes 0, 60 and 120": (
            "flows",
            {
                "tasks.flows.picks": {
                    **PICKS,
                    "arrivals": {"schedule": [{"at": at, "tasks": 90} for at in (0, 60, 120)]},
                }
            },
        ),
    },
    "rates of another unit of time": {
        "charged by the minute": ("goods", battery(charge_rate=1.2)),
        "drawn by the hour": ("goods", battery(consumption=18)),
        "driving drawn by the minute": ("goods", draws(0.002, 0.3, 0.35, 0.1)),
        "a kind's battery by the minute": (
            "goods",
            {
                "fleet.kinds": {
                    "new": {
                        "count": 4,
                        "battery": {"capacity": 100, "threshold": 40, "consumption": 0.3, "charge_rate": 1.2},
                    }
                }
            },
        ),
        "metres a minute": ("goods", {"fleet.robot.speed": 90}),
        "km/h": ("goods", {"fleet.robot.speed": 5.4}),
        "orders by the minute": ("goods", {"tasks.goods.poisson": 3.3}),
        "rates of a profile by the minute": ("flows", arrivals(profile={"per_hour": [1.2, 2.5, 1.5]})),
        "people by the day": ("goods", people(per_hour=900, stay="1 min")),
    },
    "prices by year, hour and piece": {
        "a robot as it is bought": ("goods", prices(robot=35_000)),
        "a charger as it is bought, in cents": ("goods", prices(charger=250_000)),
        "hours of a day": ("goods", prices(hours=16)),
        "days of a year": ("goods", prices(hours=250)),
        "wages by the minute": ("goods", prices(station_hour=0.58)),
        "late orders in thousands": ("goods", prices(late_order=0.008)),
        "energy by the MWh": (
            "goods",
            {
                **prices(energy=300),
                "battery.capacity": 5,
                **battery(threshold=1.25, consumption=2.5e-4, charge_rate=1e-3),
            },
        ),
        "a robot by the day": ("goods", prices(robot=14)),
    },
    "totals that do not add up": {
        "8 + 8 of 12": ("goods", kinds(12, 8, 8)),
        "4 + 6 of 12": ("goods", kinds(12, 4, 6)),
        "ABC of 80 % and 15 %": ("goods", classes((0.2, 0.8), (0.3, 0.15))),
        "priorities of 30 % and 60 %": (
            "flows",
            {
                **flow(priority=[{"priority": 1, "share": 0.3}, {"priority": 0, "share": 0.6}]),
                "policies.allocation": "earliest-due",
            },
        ),
        "chances of 70 % and 20 %": (
            "goods",
            {"tasks.unload_time": {"discrete": {"values": [20, 60], "weights": [0.7, 0.2]}}},
        ),
        "more chargers than places": (
            "goods",
            {"layout.bays.chargers": {"at": ["A", "C", "F", "H"], "places": 1, "chargers": 2}},
        ),
        "more servers than places": ("goods", {f"{PACKING}.servers": 6}),
        "fewer slots than robots": ("goods", {"fleet.size": 30}),
    },
    "words that mean two things": {
        "5 % more": ("goods", {"tasks.demand": "5 %"}),
        "20 for 20 % more": ("flows", {"tasks.demand": 20}),
        "a deviation of 12 s as cv": ("goods", {"tasks.unload_time": {"lognormal": {"mean": 30, "cv": 12}}}),
        "a rate for a mean": ("goods", {"tasks.unload_time": {"exponential": 0.033}}),
        "failures by the second for a mean": (
            "goods",
            {BREAKS: {"every": {"exponential": 3.5e-5}, "repair": "15 min"}},
        ),
        "a threshold as a share": ("goods", battery(threshold=0.25)),
        "a charge of 80": ("goods", {"fleet.start_energy": 80}),
        "the whole distance as margin": ("goods", {"fleet.robot.margin": 1.2}),
        "5 for 5 % of nodes": ("goods", {"fleet.robot.delays": {"share": 5, "time": 3}}),
    },
    "the two ends swapped": {
        "from packing to storage": ("flows", flow(**{"from": "packing", "to": "storage"})),
        "picks brought to goods-in": ("flows", flow(to="dock")),
        "goods-in from storage": ("flows", {"tasks.flows.goods in": {**GOODS_IN, "from": "storage", "to": "dock"}}),
        "draws what it should charge": ("goods", battery(consumption=0.02, charge_rate=0.005)),
        "loaded faster than empty": ("goods", {"fleet.robot.speed": 1, "fleet.robot.speed_loaded": 1.5}),
        "most and least": ("goods", {"tasks.load_time": {"uniform": [20, 10]}}),
        "from 4 to 2": ("goods", closed({"between": [["4 h", "2 h"]]})),
        "warm-up and length": ("goods", {"run": {"length": "1 h", "warm_up": "8 h"}}),
    },
}
TARGETS = (
    "orders_on_time <= 98 %",
    "tardiness_mean >= 60 s",
    "share_waiting >= 5 %",
    "cycle_time_mean > 4 min",
    "on_time >= 95",
    "on_time >= 0.95 %",
)
ZONES = (
    ("on_time >= 95 %", 0.25),
    ("on_time >= 95 %", 95),
    ("cycle_time_mean <= 4 min", 240),
    ("throughput_per_hour >= 200", 100),
)
NAMES = {
    "on time >= 95 %": "on_time",
    "OnTime >= 95 %": "on_time",
    "charger_utilization <= 80 %": "charger_utilisation",
    "throughput >= 200": "throughput_per_hour",
    "cycle_time <= 4 min": "cycle_time_mean",
    "lateness <= 60 s": "tardiness_mean",
    "p95_cycle_time <= 5 min": "cycle_time_p95",
}
KEYS = {
    "battery.charging_rate": "charge_rate",
    "tasks.unloading_time": "unload_time",
    "fleet.robots": "size",
    "policies.dispatching": "allocation",
    "policies.allocation=closest-robot": "nearest",
    "policies.routing=a-star": "shortest",
    "policies.charging=4-thresholds": "four-thresholds",
    "policies.parking=closest": "nearest",
    "run.warmup": "warm_up",
    "fleet.robot.max_speed": "speed",
}
