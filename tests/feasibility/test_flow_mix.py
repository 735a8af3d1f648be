"""The quick estimate of flows, worked out on a ring of 20 to a side, and what `desim check` finds in them."""

import math

import pytest

import desim_warehouse as dw
from desim_warehouse.feasibility.loads import loads
from desim_warehouse.feasibility.rules import warnings
from desim_warehouse.model.facts.workers import groups, peak_factor
from desim_warehouse.questions.check import check
from desim_warehouse.run.quick import measured
from desim_warehouse.run.together import together
from tests.world.test_flows import RING, first

pytestmark = pytest.mark.usefixtures("brief_probes")

HOUR = {"run.length": 3 * 3600}


def checked(flows, **changes):
    flows = flows if "from" not in flows else {"flow": flows}
    changes = {key.replace("__", "."): value for key, value in changes.items()}
    return check(dw.load(RING, {"tasks.flows": flows, **HOUR, **changes}))


def found(report):
    return {item.code: item for item in report.findings if item.level != "note"}


def test_a_task_between_stations_has_the_parts_worked_by_hand():
    report = checked({"from": "dock", "to": "pack", "arrivals": {"poisson": 20}})
    # pack at D to dock at B: 40; B to D: 40; 4 and 6 to load and unload
    cycle = report.calculation.cycle
    assert (cycle.empty, cycle.load, cycle.loaded, cycle.unload) == pytest.approx((40, 4, 40, 6))
    assert report.calculation.robots_busy == pytest.approx(20 * 90 / 3600)
    assert report.calculation.fleet_capacity * 3600 == pytest.approx(40)
    # each is one of two handlings of every task; unloading at pack takes 6 of 180 s
    busy = {item.node: item.busy for item in report.calculation.stations}
    assert busy == pytest.approx({"B": 20 * 4 / 3600, "D": 20 * 6 / 3600})


def test_a_task_between_storage_places_drives_as_worked_by_hand():
    report = checked({"from": first(1), "to": first(0), "arrivals": {"poisson": 20}})
    # from offset 5 of C>D: 15 to D, 40 to B, 10 along B>C: 65; with the load 10 to C, 5 along C>D: 15
    assert (report.calculation.cycle.empty, report.calculation.cycle.loaded) == pytest.approx((65, 15))


@pytest.mark.usefixtures("whole_probes")
def test_several_flows_are_mixed_by_their_rates():
    flows = {
        "over": {"from": "dock", "to": "pack", "arrivals": {"poisson": 30}, "load_time": 8},
        "back": {"from": "pack", "to": "dock", "arrivals": {"poisson": 10}},
        "more": {"from": "storage", "to": "storage", "arrivals": {"saturated": 2}},
    }
    cycle = checked(flows).calculation.cycle
    # loads 40 either way; empty: from D to B 40 or from B to D 40, 3/4 x 3/4 and 1/4 x 1/4 of the tasks, else nothing
    assert cycle.loaded == pytest.approx(40)
    assert cycle.empty == pytest.approx(40 * (9 / 16 + 1 / 16), rel=0.03)
    assert cycle.load == pytest.approx(0.75 * 8 + 0.25 * 4, rel=0.01)


def test_a_flow_that_ends_with_the_run_has_its_whole_share_in_the_mix():
    """Tasks come both ways, 30 an hour each: once by the hour, and then for just the three hours of the run."""
    ends = {"from": "pack", "to": "dock"}
    flows = [
        {**ends, "arrivals": {"poisson": 30}},
        {**ends, "arrivals": {"poisson": 30}, "hours": "today"},
        {**ends, "arrivals": {"schedule": [{"at": at, "tasks": 15} for at in range(900, 10_800, 1800)]}},
    ]
    over = {"over": {"from": "dock", "to": "pack", "arrivals": {"poisson": 30}}}
    changes = {**HOUR, "fleet.size": 2, "calendars": {"today": {"between": [[0, 3 * 3600]]}}}
    models = [dw.load(RING, {"tasks.flows": {**over, "back": back}, **changes}) for back in flows]
    measured = [together(model, 2).many for model in models]
    # loaded both ways, a robot does a task in half a round of 80 and 10 at stations, and without loads back in 90
    assert 80 < measured[0].rate * 3600 < 2 * 72
    assert measured[1:] == [measured[0]] * 2


def test_the_busiest_hour_is_worked_out_apart():
    report = checked({"from": "dock", "to": "pack", "arrivals": {"profile": {"per_hour": [10, 60, 10]}}})
    assert report.calculation.rate * 3600 == pytest.approx(80 / 3)
    assert report.calculation.peak * 3600 == pytest.approx(60)
    assert "the 60 of the busiest hour need 1.5" in " ".join(report.lines)
    assert found(report).keys() >= {"PEAK_ABOVE_FLEET"}
    quarter = {"from": "dock", "to": "pack", "arrivals": {"profile": {"per_hour": [0, 40, 80, 40, 0], "every": 900}}}
    assert checked(quarter, run__length=4500).calculation.peak * 3600 == pytest.approx(40)


PACKED = {"layout.stations.pack": {"at": ["D"], "places": 4, "work_time": 60}, "layout.stations.dock.places": 4}
"""A packer does 60 loads an hour, whatever comes in at the dock."""


def by_the_hour(orders, goods_in):
    ends = {"orders": ("storage", "pack", orders), "in": ("dock", "storage", goods_in)}
    flows = {
        name: {"from": begin, "to": end, "arrivals": {"profile": {"per_hour": rates}}}
        for name, (begin, end, rates) in ends.items()
    }
    model = dw.load(RING, {"tasks.flows": flows, "fleet.size": 4, **HOUR, **PACKED})
    (packers,) = [group for group in groups(model) if group.kind == "people"]
    return model, packers


def of_packers(model):
    """The load of packers in their busiest hour, the estimate of the busiest hour, and the codes that are found."""
    quick = measured(model)
    (packers,) = [load for load in loads(model, quick) if load.group.kind == "people"]
    assert packers.mean == pytest.approx(0.75, rel=0.05)
    return packers.peak, quick.busiest_hour, {item.code for item in warnings(model, model.floor, quick)}


def test_packers_have_no_busiest_hour_when_goods_come_in_that_they_never_see():
    """45 orders an hour are 75 % of their time in each hour, also in that in which 60 loads come in."""
    peak, busiest, codes = of_packers(by_the_hour([45, 45, 45], [5, 60, 5])[0])
    assert peak == pytest.approx(0.75, rel=0.05)
    assert busiest.rate * 3600 == pytest.approx(105)
    # one packer for 45 of 105 tasks: 140 of such tasks in an hour
    assert busiest.places_limit["work at D"] * 3600 == pytest.approx(60 / 45 * 105, rel=0.05)
    assert "PEAK_ABOVE_FLEET" not in codes


def test_packers_are_short_in_their_busiest_hour_when_fewer_goods_come_in_then():
    """110 tasks come in each hour, of which 100 are theirs in one: 167 % of what they can do."""
    peak, busiest, codes = of_packers(by_the_hour([17.5, 100, 17.5], [92.5, 10, 92.5])[0])
    assert peak == pytest.approx(100 / 60, rel=0.05)
    assert busiest.rate * 3600 == pytest.approx(110)
    assert busiest.places_limit["work at D"] * 3600 == pytest.approx(66, rel=0.05)
    assert busiest.robots_needed == math.inf
    assert "PEAK_ABOVE_FLEET" in codes


def test_the_busiest_hour_of_a_run_is_one_that_counts():
    """Of 100, 20 and 45 orders an hour the first are of the warm-up: 45 are 38 % more than the mean of the others."""
    model, packers = by_the_hour([100, 20, 45], [10, 90, 65])
    assert peak_factor(model, packers) == pytest.approx(100 / 55)
    assert peak_factor(model, packers, 3600) == pytest.approx(45 / 32.5)


def test_slots_that_more_robots_do_not_relieve_are_named_instead_of_their_number():
    """The way round takes 144 s, with 60 s at the server of pack: 58 tasks an hour need 58 x 144 / 3600 = 2.3 robots.

    With 2 slots at pack 2 of 4 robots work, and do 50; with 8 slots the server does 60, and a third robot is enough.
    """
    flow = {"from": "dock", "to": "pack", "unload_time": 60}
    rates = {"PEAK_ABOVE_FLEET": {"profile": {"per_hour": [20, 58, 20]}}, "DEMAND_ABOVE_FLEET": {"poisson": 58}}
    warnings = {
        (size, slots, code): found(
            checked({**flow, "arrivals": arrivals}, fleet__size=size, layout__stations__pack__places=slots)
        )[code]
        for code, arrivals in rates.items()
        for size, slots in ((4, 2), (2, 8))
    }
    for code in rates:
        full = warnings[4, 2, code]
        assert "with the number of slots at the stations as the limit, 4 robots can do " in full.text
        assert full.cure == "no number of robots keeps up"  # the limit is named once
    assert warnings[2, 8, "PEAK_ABOVE_FLEET"].cure == "at least 3 robots are needed to keep up with it"
    assert warnings[2, 8, "DEMAND_ABOVE_FLEET"].cure == "at least 3 robots are needed, each with a place at a station"


def test_more_than_the_fleet_can_do():
    report = checked({"from": "dock", "to": "pack", "arrivals": {"poisson": 50}})
    assert found(report)["DEMAND_ABOVE_FLEET"].place == "tasks.flows"
    assert "50 tasks an hour" in found(report)["DEMAND_ABOVE_FLEET"].text
    assert "DEMAND_ABOVE_FLEET" not in found(checked({"from": "dock", "to": "pack", "arrivals": {"poisson": 30}}))
    twice = checked({"from": "dock", "to": "pack", "arrivals": {"poisson": 30}}, tasks__demand=2)
    assert "60 tasks an hour" in found(twice)["DEMAND_ABOVE_FLEET"].text


def test_due_before_it_can_be_delivered():
    flow = {"from": "dock", "to": "pack", "arrivals": {"poisson": 10}}
    assert found(checked({**flow, "due_within": 49}))["DUE_TOO_SOON"].place == "tasks.flows.flow.due_within"
    assert "DUE_TOO_SOON" not in found(checked({**flow, "due_within": 51}))


def test_a_battery_that_does_not_last_for_a_task_of_a_flow():
    battery = {"capacity": 80, "threshold": 5, "consumption": 1, "charge_rate": 5}
    flow = {"from": "dock", "to": "pack", "arrivals": {"poisson": 10}}
    # 20 to the dock, 4, 40, 6, and 20 to the charger at A: 90
    small = found(checked(flow, battery=battery))["BATTERY_TOO_SMALL"]
    assert small.text.startswith("a task of flow 'flow' draws at least 90")
    assert "BATTERY_TOO_SMALL" not in found(checked(flow, battery={**battery, "capacity": 95}))


def test_turns_and_nodes_of_their_own_time_are_counted():
    flow = {"from": "dock", "to": "pack", "arrivals": {"poisson": 20}}
    # out of a station a robot faces its way: it turns at A with nothing, at C with its load
    cycle = checked(flow, traffic__turn_time=3).calculation.cycle
    assert (cycle.empty, cycle.loaded) == pytest.approx((43, 43))
    cycle = checked(flow, traffic__nodes={"C": {"time": 7}}).calculation.cycle
    assert (cycle.empty, cycle.loaded) == pytest.approx((40, 47))
    # from C>D to B>C it turns at D, A and B, and back, with its load, at C
    flow = {"from": first(1), "to": first(0), "arrivals": {"poisson": 20}}
    cycle = checked(flow, traffic__turn_time=3).calculation.cycle
    assert (cycle.empty, cycle.loaded) == pytest.approx((65 + 9, 15 + 3))
    # over the dock it drives on from there, and faces its way
    flow = {"from": first(0), "to": first(1), "via": ["dock"], "arrivals": {"poisson": 20}}
    cycle = checked(flow, traffic__turn_time=3).calculation.cycle
    assert (cycle.empty, cycle.loaded) == pytest.approx((15 + 3, 65 + 6))


@pytest.mark.usefixtures("whole_probes")
def test_no_task_goes_from_a_place_to_itself():
    report = checked({"from": "storage", "to": "storage", "arrivals": {"poisson": 20}})
    # with the load from one of the two places to the other: 65 or 15; empty also round to the same: 80
    cycle = report.calculation.cycle
    assert (cycle.empty, cycle.loaded) == pytest.approx(((80 + 80 + 65 + 15) / 4, 40), rel=0.03)
    flow = {"from": ["dock", "pack"], "to": ["dock", "pack"], "arrivals": {"poisson": 20}}
    for choice in ("random", "nearest"):
        cycle = checked(flow, tasks__station_choice=choice).calculation.cycle
        assert (cycle.empty, cycle.loaded) == pytest.approx((20, 40), rel=0.05)


ENDS = {"unload": ("storage", "pack"), "relocate": ("storage", "storage"), "back and forth": (first(1), first(0))}
TRAFFIC = ({}, {"turn_time": 3}, {"nodes": {"C": {"time": 7}}})
PAIRS = [
    pytest.param(ends, traffic, id=f"{name} {rank}", marks=[pytest.mark.long] if row != rank else [])
    for row, (name, ends) in enumerate(ENDS.items())
    for rank, traffic in enumerate(TRAFFIC)
]
"""Every day each of the ends, and each traffic."""


@pytest.mark.parametrize(("ends", "traffic"), PAIRS)
def test_the_estimate_is_what_an_unhurried_robot_does(ends, traffic):
    """A lone robot that always has a task: its throughput is that of the estimate."""
    flows = {"all": {"from": ends[0], "to": ends[1], "arrivals": {"saturated": 1}}}
    changes = {"tasks.flows": flows, "traffic": traffic, "run.length": 20 * 3600, "log": "tasks"}
    model = dw.load(RING, changes)
    by_hand = check(model).calculation.fleet_capacity * 3600
    assert dw.simulate(model).kpis["throughput_per_hour"] == pytest.approx(by_hand, rel=0.03)


def test_a_schedule_has_its_part_among_flows_at_random_whatever_the_demand():
    flows = {
        "over": {"from": "dock", "to": "pack", "arrivals": {"poisson": 30}, "load_time": 8},
        "back": {"from": "pack", "to": "dock", "arrivals": {"schedule": [{"at": 0, "tasks": 30}]}},
    }
    # 90 and 30 in three hours
    cycle = checked(flows).calculation.cycle
    assert cycle.load == pytest.approx(0.75 * 8 + 0.25 * 4, rel=0.01)
    assert checked(flows, tasks__demand=2).calculation.cycle == cycle
