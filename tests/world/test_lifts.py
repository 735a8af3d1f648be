"""Lifts, worked out by hand: when the cabin comes, how long a ride takes, who waits for whom, and what is counted.

Robots keep D = 2 apart and drive 1. From hall and ward it is 10 to the doors, the stop line is at 8. The cabin takes 12
from floor to floor, its doors 4.
"""

import pytest

import desim_warehouse as dw
from desim_warehouse.run.quick import estimate
from desim_warehouse.study.suspects import suspects
from desim_warehouse.world.traffic.motion import Motion
from tests.auditor import audit
from tests.world.floor import PARK, Floor

pytestmark = pytest.mark.usefixtures("brief_probes")

near = pytest.approx
UP, DOWN = "hall lift0 lift1 ward", "ward lift1 lift0 hall"
ALONE = 8 + 4 + 2 + 4 + 12 + 4 + 10
"""To the stop line, doors open, in, doors close, ride, doors open, out to the ward: 44."""


def house(**lift):
    settings = {key: lift.pop(key) for key in ("node_time", "turn_time") if key in lift}
    nodes = {"hall": (0, 0), "lift0": (10, 0), "lift1": (10, 50), "ward": (0, 50), "lift2": (10, 90), "roof": (0, 90)}
    lanes = ["hall>lift0", "lift0>hall", "ward>lift1", "lift1>ward", "roof>lift2", "lift2>roof"]
    main = {"nodes": ("lift0", "lift1", "lift2"), "ride": 12, "doors": 4, **lift}
    return Floor(nodes, lanes, lifts={"main": main}, **settings)


def test_a_robot_alone_waits_for_the_doors_and_rides():
    floor = house()
    robot = floor.robot(UP)
    floor.run()
    assert floor.there(robot) == [ALONE]
    # in the cabin at 8 + 4 + 2 = 14, out of it at 14 + 4 + 12 + 4 = 34
    assert floor.enters(robot) == {"hall>lift0": 0, "lift0>lift1": 14, "lift1>ward": 34}
    assert robot.waited_apart == {"in_lift": 4 + 20}
    assert (floor.S, robot.waited, robot.distance(floor.env.now)) == (0, 24, 20)


def test_the_cabin_comes_from_where_it_was_left():
    floor = house()
    robot = floor.robot(UP, PARK, 100, DOWN, PARK, 100, DOWN.replace("ward lift1", "roof lift2"))
    floor.run()
    # down it is there; then it comes from the ground to the roof, two floors, and takes two down
    first = ALONE, ALONE + 100 + ALONE
    assert floor.there(robot) == [*first, first[1] + 100 + ALONE + 24 + 12]


def test_the_cabin_is_called_down_and_back_up_for_each_of_a_queue():
    floor = house()
    robots = [floor.robot(UP, PARK, start=4 * n) for n in range(4)]
    floor.run()
    # from one leaving the cabin to the next: D, doors, down, doors, in, doors, up, doors
    each = 2 + 4 + 12 + 4 + 2 + 4 + 12 + 4
    assert [floor.there(robot) for robot in robots] == [[near(ALONE + n * each)] for n in range(4)]
    assert [robot.crossings for robot in robots] == [0, 1, 1, 1]


def test_an_empty_cabin_goes_to_where_it_rests():
    for rests, later in ((None, 12), ("lift0", 0), ("lift2", 24)):
        floor = house(rests=rests)
        first, second = floor.robot(UP, PARK), floor.robot(UP, start=300)
        floor.run()
        call = 24 if rests == "lift2" else 0
        assert floor.there(first) == [ALONE + call]
        assert floor.there(second) == [300 + ALONE + later]


def test_called_on_its_way_to_rest_it_turns_back_from_there():
    floor = house(rests="lift0")
    floor.robot(UP, PARK)
    second = floor.robot(DOWN, start=46 - 8)
    floor.run()
    # the first left the cabin at 34, is D beyond at 36, doors closed at 40; at 46 the cabin is 6 below, so 6 back up
    assert floor.there(second) == [38 + ALONE + 6]


def test_of_two_that_meet_one_waits_until_the_doors_have_closed_behind_the_other():
    floor = house()
    first, second = floor.robot(UP), floor.robot(DOWN)
    floor.run()
    # the first leaves at 34, is D beyond at 36; the doors have closed at 40, open at 44, and so on
    assert floor.there(first) == [ALONE]
    assert floor.there(second) == [40 + 4 + 2 + 4 + 12 + 4 + 10]
    assert floor.waits(second) == [("lift0", 8, 40, first.number)]
    assert (second.waited, second.waited_apart) == (32 + 24, {"in_lift": 24})


def test_the_cabin_is_not_called_before_there_is_room_beyond():
    floor = house()
    blocker = floor.robot(UP, 100, PARK)
    ahead = [floor.robot(UP, PARK) for _ in range(4)]
    floor.run()
    # the ward is taken from 44 to 144; four stand D apart on the lane before it, at 8, 6, 4 and (the last) 2
    leaves = [floor.enters(robot)["lift1>ward"] for robot in ahead]
    assert leaves == [near(34 + 44 * n) for n in range(1, 5)]
    assert blocker.waited == 24


def test_with_one_place_beyond_the_next_is_called_for_when_it_is_free():
    nodes = {"hall": (0, 0), "lift0": (10, 0), "lift1": (10, 50), "ward": (6, 50)}
    lanes = ["hall>lift0", "lift0>hall", "ward>lift1", "lift1>ward"]
    floor = Floor(nodes, lanes, lifts={"main": {"nodes": ("lift0", "lift1"), "ride": 12, "doors": 4}})
    floor.robot(UP, 200, PARK)
    second, third = floor.robot(UP, PARK), floor.robot(UP, PARK)
    floor.run()
    # one is in the ward from 34 + 4 = 38 to 238, and the second stands before it. The third moves up when that drives
    # into the cabin, at 40 + 12 + 4, waits until the second goes on at 238, and only then the cabin comes down to it
    assert floor.enters(second)["lift1>ward"] == near(34 + 44)
    assert floor.waits(third)[-1][1:3] == (near(56 + 2), near(238))
    assert floor.there(third) == [near(238 + 12 + 4 + 2 + 4 + 12 + 4 + 4)]


def test_a_robot_that_is_recalled_before_or_in_a_lift_rides_on():
    for recalled in (1.0, 9.0, 20.0):
        floor = house()
        robot = floor.robot(UP + " lift1 lift0")
        robot.recall_from(recalled)
        floor.run()
        assert (floor.there(robot), robot.held.name) == ([ALONE], "ward")


def test_a_robot_turns_in_the_cabin_before_it_rides():
    floor = house(turn_time=3.0)
    robot = floor.robot(UP)
    floor.run()
    # it drives in eastwards and out westwards, two quarters of a turn, wherever the other floor is drawn
    assert floor.there(robot) == [ALONE + 2 * 3]


def test_the_time_at_nodes_is_spent_in_the_cabin_on_both_floors():
    floor = house(node_time=1.0)
    robot = floor.robot(UP)
    floor.run()
    assert floor.there(robot) == [ALONE + 3 * 1]


@pytest.mark.parametrize("looks_ahead", [False, True])
def test_a_robot_that_gathers_speed_stops_before_the_doors_and_in_the_cabin(looks_ahead):
    floor = house()
    robot = floor.robot(UP, motion=Motion(1.0, 1.0), looks_ahead=looks_ahead)
    floor.run()
    # 1/2 for each start, in the hall, before the doors and in the cabin, and for each stop in the cabin and the ward;
    # it brakes before the doors while the cabin comes
    assert floor.there(robot) == [near(ALONE + 3 / 2 + 2 / 2)]


def test_a_fast_robot_waits_for_a_slower_one_to_be_clear_of_the_doors():
    floor = house()
    slow, fast = floor.robot(UP, PARK, speed=0.5), floor.robot(DOWN, speed=2.0)
    floor.run()
    # the fast one is first: at its stop line at 4, cabin up 12, doors 4, in 1, doors, ride, doors: it leaves at 41
    # and is D beyond at 42; doors closed at 46, open at 50, the slow one in at 54, up at 74, in the ward at 94
    assert floor.there(fast) == [46]
    assert floor.there(slow) == [94]


# Whole runs

TWO = {
    "layout": {
        "nodes": {
            "home": [0, 0],
            "hall": [10, 0],
            "lift0": [20, 0],
            "lift1": [20, 30],
            "ward": [10, 30],
            "far": [0, 30],
        },
        "edges": [
            {"from": a, "to": b, "two_way": True}
            for a, b in (("home", "hall"), ("hall", "lift0"), ("lift1", "ward"), ("ward", "far"))
        ],
        "storage": [{"node": "hall"}],
        "lifts": {"main": {"nodes": ["lift0", "lift1"], "ride": 12, "doors": 4}},
        "bays": {"home": {"at": ["home"], "places": 4}},
        "stations": {"wards": {"at": ["far"], "places": 4, "servers": 4}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1}},
    "tasks": {"goods": [0], "unload_at": ["wards"], "load_time": 5, "unload_time": 7},
    "log": "all",
}


def test_time_at_lifts_is_counted_apart_and_the_account_adds_up():
    run = dw.simulate(TWO)
    # 10 to the hall, 5 loading, 9 + 4 + 1 + 20 + 20 to the far end, 7 unloading, and 20 + 9 + 4 + 1 + 20 + 20 - 10 back
    assert run.kpis["T"] == 10 + 5 + 54 + 7 + 64
    assert run.kpis["in_lift"] == 2 * (4 + 20)
    assert run.kpis["share_in_lift"] == 48 / 140
    assert (run.kpis["S"], run.kpis["share_waiting"]) == (0, 0)
    account = run.account("robot").loc[0]
    assert account["in_lift"] == 48
    assert account.sum() == 140


def test_a_run_that_ends_in_the_cabin_counts_what_has_happened():
    for level in ("all", "tasks"):
        tasks = {**TWO["tasks"], "goods": {"saturated": 1}}
        run = dw.simulate({**TWO, "tasks": tasks, "run": {"length": 40}, "log": level})
        # it waits for the doors from 24 to 28, and is in the cabin from 29 on
        assert run.kpis["in_lift"] == 4 + 11
        assert run.kpis["share_loaded"] == (9 + 1) / 40


def building(lifts, routing, per_hour=150.0):
    """Six robots that carry loads from the home on one floor to the far end of the other, by lifts side by side."""
    nodes = {"home": [0, 0], "hall": [20, 0], "ward": [20, 100], "far": [0, 100]}
    streets, shafts = [("home", "hall"), ("ward", "far")], {}
    for number in range(lifts):
        nodes |= {f"a{number}": [40, 10 * number], f"b{number}": [40, 100 + 10 * number]}
        streets += [("hall", f"a{number}"), (f"b{number}", "ward")]
        shafts[f"lift{number}"] = {"nodes": [f"a{number}", f"b{number}"], "ride": 12, "doors": 4}
    lanes = [{"from": a, "to": b, "side_by_side": True, "length": 20} for s in streets for a, b in (s, s[::-1])]
    return {
        "layout": {
            "nodes": nodes,
            "edges": lanes,
            "storage": [{"node": "home"}],
            "lifts": shafts,
            "bays": {"home": {"at": ["home"], "places": 6}},
            "stations": {"wards": {"at": ["far"], "places": 6, "servers": 6}},
        },
        "fleet": {"size": 6, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1.0}},
        "tasks": {"goods": {"poisson": per_hour}, "unload_at": ["wards"], "load_time": 5, "unload_time": 7},
        "policies": {"routing": routing},
        "run": {"length": 3 * 3600, "warm_up": 1800},
        "log": "all",
    }


def test_of_two_lifts_side_by_side_congestion_aware_takes_both():
    one, same, both = (
        dw.simulate(building(*lifts), 1) for lifts in ((1, "fastest"), (2, "fastest"), (2, "congestion-aware"))
    )
    # up and down in turn the cabin drives with a robot each time: doors, in, doors, ride, doors, out, doors are 30 s
    assert one.kpis["throughput_per_hour"] == same.kpis["throughput_per_hour"] == near(60, abs=0.5)
    assert one.kpis["lift_utilisation"] == near(1, abs=0.01)
    assert same.kpis["lift_utilisation"] == near(0.5, abs=0.01)
    assert both.kpis["throughput_per_hour"] > 80
    assert both.kpis["share_waiting"] < 0.06
    assert same.kpis["share_waiting"] > 0.35
    assert "lift lift0 was the busiest, with" in str(one).lower()


@pytest.mark.usefixtures("brief_probes")
def test_robots_take_all_cabins_of_a_lift_where_routes_see_the_queue():
    one, both = (
        dw.simulate(dw.load(building(1, routing), {"layout.lifts.lift0.cabins": 2, "log": "all"}), 1)
        for routing in ("fastest", "congestion-aware")
    )
    assert one.kpis["throughput_per_hour"] == near(60, abs=0.5)
    assert both.kpis["throughput_per_hour"] > 80
    assert audit(both) == []
    loads = {item.name: item.share for item in estimate(both.model).lifts}
    assert loads == {"lift0": 1.0, "lift0 2": 1.0}  # of the two rides of a load
    unused = [one for one in dw.check(one.model).findings if one.code == "LIFT_UNUSED"]
    assert len(unused) == 1
    assert "which can do 120 rides an hour, and none takes lift lift0" in str(unused[0])


@pytest.mark.slow
def test_check_says_what_a_lift_can_do_and_that_another_stands_unused():
    report = dw.check(building(2, "fastest"))
    high, unused = (str(one) for one in report.findings if one.code in {"DEMAND_ABOVE_LIFT", "LIFT_UNUSED"})
    taken, other = ("lift0", "lift1") if "lifts.lift0" in high else ("lift1", "lift0")
    assert f"layout.lifts.{taken}: it can do 120 rides an hour, but 300 are needed: its queue grows" in high
    assert f"all robots take lift {taken}, which can do 120 rides an hour, and none takes lift {other}" in unused
    assert "congestion-aware takes both, which can do about 240" in unused
    assert f"Lift {taken} is busiest: demand is 250 % of its capacity" in str(report)
    assert not [one for one in dw.check(building(2, "congestion-aware")).findings if one.code == "LIFT_UNUSED"]


def test_why_tries_a_faster_lift_first_where_robots_wait_for_it():
    tried = suspects(dw.simulate(building(1, "fastest"), 1))
    assert tried[0].relief == "lift lift0 twice as fast"
    assert tried[0].overrides == {"layout.lifts.lift0.ride": 6, "layout.lifts.lift0.doors": 2}
    assert tried[1].relief == "one cabin more beside lift lift0, routes by congestion-aware"
    assert tried[1].overrides == {"layout.lifts.lift0.cabins": 2, "policies.routing": "congestion-aware"}
    assert tried[1].scale == near(0.1)
    assert not [one for one in tried if one.name.startswith("intersection a0")]
