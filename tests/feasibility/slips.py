"""Slips of planners that used to run without a word, as data: a change of a warehouse, and what must be said of it.

`KNOWN` are those that newcomers made; `OURS` are neighbours of them. Of each: the base, the changes, the code or the
kind of error, and a word of the cure.
"""

from pathlib import Path

PLANNER = Path(__file__).with_name("planner.yaml")
SETTLED = {"fleet.start_energy": "settled"}
GOODS_IN = {"from": "dock", "to": "storage", "arrivals": {"poisson": 30}}
PICKS = {"from": "storage", "to": "packing", "arrivals": {"poisson": 100}, "due_within": "15 min"}
FLOWS = {
    **SETTLED,
    "layout.stations": {
        "packing": {"at": ["R", "T"], "places": 6, "servers": 2},
        "dock": {"at": ["V"], "places": 6, "servers": 2},
    },
    "tasks": {"flows": {"goods in": GOODS_IN, "picks": PICKS}, "load_time": 15, "unload_time": 30},
}
BASES = {"goods": SETTLED, "flows": FLOWS}

BREAKS = "fleet.robot.breakdowns"
EVERY_2_H = {"every": "2 h", "repair": "15 min"}
CLOSED = {"members": [["J", "K"]], "hours": "closed"}
MONEY = {"currency": "EUR", "hours": 4000, "robot": 5000, "charger": 600, "station_hour": 35, "late_order": 8}
KIND = {"radius": 0.5}


def flow(**changes):
    return {"tasks.flows.picks": {**PICKS, **changes}}


def due_at(*times):
    without = {key: value for key, value in PICKS.items() if key != "due_within"}
    return {"tasks.flows.picks": {**without, "due_at": list(times)}}


def schedule(*times):
    return {"tasks.flows.goods in": {**GOODS_IN, "arrivals": {"schedule": [{"at": at, "tasks": 30} for at in times]}}}


def closed(calendar):
    return {"calendars": {"closed": calendar}, "traffic.closures": {"aisle": CLOSED}}


def kinds(size, *counts):
    of_kinds = {f"k{rank}": {**KIND, "count": n} for rank, n in enumerate(counts)}
    return {"fleet.size": size, "fleet.kinds": of_kinds, "layout.bays.parking.places": 4}


def draws(standing, empty, loaded, handling):
    return {"battery.consumption": {"standing": standing, "empty": empty, "loaded": loaded, "handling": handling}}


def people(**what):
    return {"people": {"pickers": {"per_hour": 20, **what}}}


def prices(**what):
    return {"prices": {**MONEY, **what}}


KNOWN = {
    "repair in minutes": ("goods", {BREAKS: {"every": "2 h", "repair": 40}}, "UNUSUAL", "40 min"),
    "clear longer than repair": ("goods", {BREAKS: {**EVERY_2_H, "clear": "40 min"}}, "UNUSUAL", "until it is off"),
    "clear in minutes": ("goods", {BREAKS: {**EVERY_2_H, "clear": 5}}, "UNUSUAL", "5 min"),
    "no time to load": ("goods", {"tasks.load_time": 0}, "UNUSUAL", "load_time: 10 s"),
    "no time to unload": ("goods", {"tasks.unload_time": 0}, "UNUSUAL", "unload_time: 10 s"),
    "rates by the minute": (
        "goods",
        {"battery.consumption": 0.3, "battery.threshold": 40, "battery.charge_rate": 1.2},
        "BATTERY_RATES",
        "per s",
    ),
    "nothing draws energy": ("goods", {"battery.consumption": 0}, "CHANGES_NOTHING", "without battery"),
    "a load saves energy": ("goods", draws(0.001, 0.005, 0.003, 0.002), "BATTERY_RATES", "at least as much as empty"),
    "a run of 20 minutes": ("goods", {"run": {"length": "20 min"}}, "SHORT_RUN", "hundred tasks"),
    "a robot for 6 a year": ("goods", prices(robot=6), "UNUSUAL", "years of use"),
    "wages of a year by the hour": ("goods", prices(station_hour=35_000), "UNUSUAL", "hours worked"),
    "late orders of a year": ("goods", prices(late_order=4_000), "UNUSUAL", "one order"),
    "from packing to packing": ("flows", flow(**{"from": "packing"}), "SAME_ENDS", "from: storage"),
    "released at 8": ("flows", schedule(8), "UNUSUAL", "8 h"),
    "closed from 2 to 4": ("goods", closed({"between": [[2, 4]]}), "UNUSUAL", "4 h"),
    "due at 14 and 18": ("flows", due_at(14, 18), "UNUSUAL", "18 h"),
    "6 + 6 of 14": ("goods", kinds(14, 6, 6), "KINDS_AND_SIZE", "fleet.size: 12"),
    "5 + 5 of 12": ("goods", kinds(12, 5, 5), "KINDS_AND_SIZE", "fleet.size: 10"),
    "30 % more is a third": ("goods", {"tasks.demand": "30 %"}, "UNUSUAL", "1.3"),
    "0.3 more is a third": ("flows", {"tasks.demand": 0.3}, "UNUSUAL", "1.3"),
    "aisles as wide as robots": ("goods", {"layout.blocks.aisle_width": 1.1}, "NARROW_AISLES", "half of its width"),
    "five minutes at nearly every node": (
        "goods",
        {"fleet.robot.delays": {"share": 0.95, "time": "5 min"}},
        "UNUSUAL",
        "smaller share",
    ),
    "work in minutes": ("goods", {"layout.stations.packing.work_time": 0.5}, "UNUSUAL", "0.5 min"),
    "people stay for 5": ("goods", people(stay=5), "UNUSUAL", "5 min"),
}

OURS = {
    # a plain number for minutes or hours
    "outage repaired in minutes": (
        "goods",
        {"layout.bays.chargers.outages": {"every": "20 h", "repair": 30}},
        "UNUSUAL",
        "30 min",
    ),
    "outage every so many hours": (
        "goods",
        {"layout.bays.chargers.outages": {"every": 200, "repair": "30 min"}},
        "UNUSUAL",
        "200 h",
    ),
    "breaks down every so many hours": ("goods", {BREAKS: {"every": 40, "repair": "15 min"}}, "UNUSUAL", "40 h"),
    "repair that varies, in minutes": (
        "goods",
        {BREAKS: {"every": "8 h", "repair": {"exponential": 20}}},
        "UNUSUAL",
        "did you mean 20 min",
    ),
    "cleared in minutes, repaired in hours": (
        "goods",
        {BREAKS: {"every": "8 h", "repair": "2 h", "clear": {"triangular": [5, 10, 15]}}},
        "UNUSUAL",
        "did you mean 10 min",
    ),
    "a rate for each 15": (
        "flows",
        flow(arrivals={"profile": {"per_hour": [50, 100], "every": 15}}),
        "UNUSUAL",
        "15 min",
    ),
    "closed every 4 for 1": ("goods", closed({"every": 4, "lasts": 1}), "UNUSUAL", "4 h"),
    "closed for 30": ("goods", closed({"every": "4 h", "lasts": 30}), "UNUSUAL", "30 min"),
    "closed from 2 on": ("goods", closed({"every": "4 h", "lasts": "1 h", "first": 2}), "UNUSUAL", "2 h"),
    "closed from 0 to 30": ("goods", closed({"between": [[0, 30]]}), "UNUSUAL", "30 min"),
    "people come at 9 and 12": ("goods", {"people": {"p": {"times": [9, 12], "stay": "1 min"}}}, "UNUSUAL", "12 min"),
    "lorries at 30 and 50": ("flows", schedule(30, 50), "UNUSUAL", "50 min"),
    "due at 60, 120, 180 minutes": ("flows", due_at(60, 120, 180), "NEVER_LATE", "on to its end"),
    "unloading for half a minute": ("goods", {"tasks.unload_time": 0.5}, "UNUSUAL", "0.5 min"),
    "loading for half a minute at a station": ("goods", {"layout.stations.packing.unload_time": 0.5}, "UNUSUAL", "min"),
    "stops for a quarter of a minute": ("flows", flow(via=["dock"], stop_time=0.25), "UNUSUAL", "0.25 min"),
    "decisions in ms": ("goods", {"policies.interval": 5000}, "UNUSUAL", "5,000 ms"),
    "a run of 10 minutes": ("goods", {"run": {"length": 600}}, "SHORT_RUN", "hour has 3600"),
    "counted for 20 minutes": ("goods", {"run": {"length": "2 h", "warm_up": "100 min"}}, "SHORT_RUN", "hundred tasks"),
    "a window of 2": (
        "goods",
        {"policies.batching": {"name": "time-window", "window": 2}, "fleet.robot.capacity": 3},
        "UNUSUAL",
        "2 min",
    ),
    "half a swap": ("goods", {"policies.charging": {"name": "swap", "time": 3}}, "UNUSUAL", "3 min"),
    # rates by the minute, states
    "states by the minute": (
        "goods",
        {**draws(0.1, 0.3, 0.36, 0.2), "battery.threshold": 40},
        "BATTERY_RATES",
        "per s",
    ),
    "standing draws most": ("goods", draws(0.02, 0.005, 0.006, 0.005), "BATTERY_RATES", "at most as much as empty"),
    "no state draws": ("goods", draws(0, 0, 0, 0), "CHANGES_NOTHING", "without battery"),
    "both rates by the hour": ("goods", {"battery.consumption": 18, "battery.charge_rate": 72}, "FAST_CHARGE", ""),
    # prices
    "wages in thousands": ("goods", prices(station_hour=0.035), "UNUSUAL", "hours worked"),
    "a kind in thousands": ("goods", {**kinds(12, 4), **prices(kinds={"k0": 8})}, "UNUSUAL", "years of use"),
    "a charger by the hour": ("goods", prices(charger=0.1), "UNUSUAL", "years of use"),
    "energy by the kWh, capacity in Wh": (
        "goods",
        {**prices(energy=0.3), "battery": {"capacity": 2000, "threshold": 500, "consumption": 0.1, "charge_rate": 0.4}},
        "UNUSUAL",
        "one unit of battery.capacity",
    ),
    "hours a week": ("goods", prices(hours=80), "UNUSUAL", "2,000"),
    # totals
    "10 + 2 of 14": ("goods", kinds(14, 10, 2), "KINDS_AND_SIZE", "fleet.size: 12"),
    # words that mean two things
    "130 for 130 %": ("goods", {"tasks.demand": 130}, "UNUSUAL", "130 %"),
    # swapped
    "packed things go back": (
        "flows",
        {**flow(**{"from": "packing", "to": "storage"}), "layout.stations.packing.work_time": 30},
        "CHANGES_NOTHING",
        "not from",
    ),
    "storage both ways at the stations": ("flows", flow(**{"from": ["R", "V"], "to": ["V", "R"]}), "SAME_ENDS", "to"),
    "every and repair swapped": ("goods", {BREAKS: {"every": "1 h", "repair": "2 d"}}, "UNUSUAL", "times are in s"),
    "robots with full width for radius": (
        "goods",
        {"fleet.robot.radius": 1.45, "fleet.robot.margin": 0},
        "NARROW_AISLES",
        "half of its width",
    ),
    # delays
    "an hour at a node in a hundred": (
        "goods",
        {"fleet.robot.delays": {"share": 0.01, "time": "1 h"}},
        "UNUSUAL",
        "shorter time",
    ),
    "three minutes at every fifth node": (
        "goods",
        {"fleet.robot.delays": {"share": 0.2, "time": {"lognormal": {"mean": 180, "cv": 0.4}}}},
        "UNUSUAL",
        "shorter time",
    ),
}

TARGETS = {
    "on_time <= 95 %": "more on_time is better",
    "cycle_time_p95 >= 5 min": "less cycle_time_p95 is better",
    "throughput_per_hour <= 150": "more throughput_per_hour is better",
    "backlog > 3": "less backlog is better",
    "annual_cost >= 100000": "less annual_cost is better",
}
"""Targets the wrong way round."""
ZONES = {
    ("on_time >= 95 %", 1.0): "1 %",
    ("on_time >= 95 %", 10.0): "10 %",
    ("on_time >= 95 %", 0.3): "20%",
    ("cycle_time_p95 <= 300", 100.0): "60",
}
"""Indifference zones in which nearly all designs lie; a word of the answer."""
NAMES = {
    "on-time >= 95 %": "on_time",
    "service_level >= 95 %": "on_time",
    "cycle-time-p95 <= 5 min": "cycle_time_p95",
    "p95 <= 5 min": "cycle_time_p95",
    "lead_time <= 5 min": "cycle_time_mean",
    "makespan <= 1 h": "T",
}
"""Indicators by other names."""
KEYS = {
    "run.duration": "run.length",
    "fleet.count": "fleet.size",
    "fleet.robot.velocity": "fleet.robot.speed",
    "fleet.robot.diameter": "fleet.robot.radius",
    "policies.allocation=closest": "nearest",
    "policies.allocation=fifo": "in-order",
    "policies.routing=dijkstra": "shortest",
    "layout.blocks.directions=two_way": "did you mean 'two-way'",
}
"""Keys and values by other names, and what is meant."""
