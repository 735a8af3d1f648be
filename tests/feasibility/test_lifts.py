"""Lifts in the quick estimate, by hand: what they can do where robots choose their tasks, and where routes see queues.

Two rings of 40 m are joined by lifts in front of whose doors they pass. A robot of D = 1 m and 1 m/s has a lift for a
ride of 30 s at the least: doors 4 s, 1 m in, doors 4 s, ride 12 s, doors 4 s, 1 m out, doors 4 s.
"""

from __future__ import annotations

import pytest

import desim_warehouse as dw
from desim_warehouse.feasibility.loads import loads
from desim_warehouse.run.quick import estimate, measured

near = pytest.approx
HOUR = 3600
RIDE = {"ride": 12, "doors": 4}


def building(per_hour, routing="fastest", flows=("up", "down"), lanes=(("b", 5),), calendars=None, **of_lifts):
    """Return two stations on two floors: goods are carried from one to the other."""
    ends = {"up": ("below", "above"), "down": ("above", "below")}
    rings = [("a", "b"), ("b", "c"), ("c", "d"), ("d", "a")]
    return dw.load(
        {
            "name": "two floors",
            "calendars": calendars or {},
            "layout": {
                "nodes": {
                    f"{name}{floor}": [100 * floor + x, y]
                    for floor in (0, 1)
                    for name, x, y in (("a", 0, 0), ("b", 10, 0), ("c", 10, 10), ("d", 0, 10))
                },
                "edges": [[f"{a}{floor}", f"{b}{floor}"] for floor in (0, 1) for a, b in rings],
                "lifts": {
                    f"at {node}": {"at": [f"{node}0", f"{node}1"], "lane": lane, **RIDE, **of_lifts.get(node, {})}
                    for node, lane in lanes
                },
                "bays": {"dock": {"at": ["a0"], "places": 16}},
                "stations": {
                    name: {"at": [f"d{floor}"], "places": 16, "servers": 3}
                    for floor, name in enumerate(("below", "above"))
                },
            },
            "fleet": {"size": 8, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1}},
            "tasks": {
                "load_time": 2,
                "unload_time": 2,
                "flows": {
                    flow: {"from": ends[flow][0], "to": ends[flow][1], "arrivals": {"poisson": per_hour / len(flows)}}
                    for flow in flows
                },
            },
            "policies": {"allocation": "nearest", "routing": routing},
            "run": {"length": 3 * HOUR, "warm_up": 1200},
        }
    )


def test_robots_that_choose_among_loads_up_and_down_ride_once_for_each():
    # alone a robot fetches the next load from where it comes: half of them lie on the other floor, 1.5 rides a load, so
    # 80 loads an hour; where loads wait on both floors it brings one up and the next down, a ride each: 120
    model = building(100)
    now = measured(model)
    (lift,) = now.lifts
    assert lift.share == near(1.5, abs=0.05)
    assert lift.least == near(30, abs=0.5)
    assert now.limits["lift at b"] * HOUR == near(120, abs=2)
    assert dw.simulate(model, seed=1).kpis["throughput_per_hour"] > 95
    report = dw.check(model)
    assert not {one.code for one in report.findings} & {"DEMAND_ABOVE_LIFT", "DEMAND_ABOVE_FLEET"}
    assert "lift at b: it can do 120 rides an hour, at 1.50" in report.details
    assert ", or 101.4 if robots choose among many tasks" in report.details


def test_what_no_choice_makes_possible_is_still_refused():
    report = dw.check(building(130))
    (high,) = [str(one) for one in report.findings if one.code == "DEMAND_ABOVE_LIFT"]
    assert (
        "layout.lifts.at b: it can do 120 rides an hour, but 131.8 are needed" in high
    )  # the first rides are of empty robots


def test_a_lift_that_robots_queue_for_is_as_busy_as_it_can_be():
    model = building(100)
    now = measured(model)
    (lift,) = (load for load in loads(model, now) if load.group.kind == "lifts")
    assert lift.mean == 1.0  # 125 % by rides of robots that take what comes, 83 % of those that choose
    assert now.lifts[0].busy(40 / HOUR) == near(0.5, abs=0.02)
    assert now.lifts[0].busy(132 / HOUR) == near(1.1, abs=0.02)


@pytest.mark.usefixtures("brief_probes")
def test_the_loads_of_a_plan_know_that_robots_choose():
    # a plan does not simulate all robots before it begins: it does where a lift has more to do than it can
    (lift,) = estimate(building(90)).lifts
    assert lift.busy(90 / HOUR) == 1.0
    assert estimate(building(40)).lifts[0].crowd is None


@pytest.mark.parametrize(
    ("cabins", "near"), [(2, 0.06), *(pytest.param(cabins, 0.03, marks=pytest.mark.long) for cabins in (1, 2))]
)
@pytest.mark.usefixtures("brief_probes")
def test_a_fleet_waits_for_people_who_ride(cabins, near):
    # people have each cabin for 22 % of the time: with two of them robots were said to do 144 to 161, and do 119
    people = {"per_hour": 20 * cabins, "transfer": 3}
    model = building(400, "congestion-aware", b={"cabins": cabins, "people": people})
    least, _, most = measured(model).measured
    done = dw.simulate(model, 1).kpis["throughput_per_hour"] / HOUR
    assert (1 - near) * least <= done <= (1 + near) * most


@pytest.mark.usefixtures("brief_probes")
def test_people_who_never_ride_while_robots_work_hold_up_nobody():
    shut = {"b": {"people": {"per_hour": 20, "transfer": 3, "hours": "night"}}}
    never = building(400, **shut, calendars={"night": {"open": ["22:00-23:00"]}})
    assert measured(never).measured == measured(building(400)).measured


@pytest.mark.usefixtures("brief_probes")
def test_routes_that_see_queues_share_lifts_of_two_names_to_the_same_floors():
    # a load up and the way back for the next are two rides: a lift does 60 loads an hour, and both do 120
    model = building(90, "congestion-aware", flows=("up",), lanes=(("b", 3), ("c", 3)))
    assert {load.name: load.share for load in estimate(model).lifts} == {"at b": near(1.0), "at c": near(1.0)}
    assert measured(model).limits["lifts at b and at c"] * HOUR == near(120, abs=1)
    assert "DEMAND_ABOVE_LIFT" not in {one.code for one in dw.check(model).findings}
    one = building(90, "fastest", flows=("up",), lanes=(("b", 3), ("c", 3)))
    assert [load.share for load in estimate(one).lifts] == [near(2.0)]
    assert "DEMAND_ABOVE_LIFT" in {one.code for one in dw.check(one).findings}


@pytest.mark.usefixtures("brief_probes")
def test_of_two_lifts_the_faster_takes_more():
    # 22 s to the next floor: 40 s for a ride instead of 30 s, so that it takes three of seven rides
    model = building(90, "congestion-aware", flows=("up",), lanes=(("b", 3), ("c", 3)), c={"ride": 22})
    shares = {load.name: load.share for load in estimate(model).lifts}
    assert shares == {"at b": near(2 * 4 / 7), "at c": near(2 * 3 / 7)}
