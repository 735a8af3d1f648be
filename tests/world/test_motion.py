"""Robots that gather speed and brake: the time of each start and stop, exactly. In most stories D = 2."""

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import desim_warehouse as dw
from desim_warehouse.questions.check import check
from desim_warehouse.world.traffic.motion import Motion, Stretch
from tests.auditor import audit
from tests.world import ring
from tests.world.closed_form import drive_time
from tests.world.floor import PARK, Floor, line

pytestmark = pytest.mark.usefixtures("brief_probes")

near = pytest.approx
HALF = Motion(2.0, 2.0)
"""Half a length unit per time unit squared, up and down: 1 is gathered in 2, over a length of 1."""


# One robot, worked out by hand


def test_a_start_and_a_stop_cost_half_the_time_that_gathering_and_losing_the_speed_take():
    floor = line("A B", 10)
    robot = floor.robot("A B", motion=HALF)
    floor.run()
    # 2 to gather 1, over 1; 8 at 1; 2 to brake, over 1
    assert floor.there(robot) == [near(12, abs=1e-12)]


def test_on_a_short_drive_it_never_gets_to_its_speed():
    floor = line("A B", 0.5, D=0.2)
    robot = floor.robot("A B", motion=HALF)
    floor.run()
    # 0.25 up and 0.25 down, each sqrt(2 * 0.25 / 0.5) = 1
    assert floor.there(robot) == [near(2, abs=1e-12)]


def test_without_a_stop_nothing_is_lost_on_the_way():
    floor = line("A B C D", 10, 10, 10)
    robot = floor.robot("A B C D", motion=HALF)
    floor.run()
    assert floor.there(robot) == [near(32, abs=1e-12)]
    # what gathering speed takes is spent before it sets out
    assert floor.enters(robot) == {"A>B": near(1), "B>C": near(11), "C>D": near(21)}


def test_it_brakes_before_a_slower_lane_and_gathers_speed_after_it():
    floor = line("A B C D", 10, 10, 10, limits=[None, 0.5, None])
    robot = floor.robot("A B C D", motion=HALF)
    floor.run()
    # from 1 to 0.5, or back, takes 1 over 0.75: 0.25 more than at 1
    assert floor.there(robot) == [near(10 + 20 + 10 + 1 + 1 + 2 * 0.25, abs=1e-12)]


# One robot, any route


@st.composite
def routes(draw):
    """Edges with limits, times at nodes and turns, and where the robot stops on them."""
    edges = draw(
        st.lists(
            st.tuples(
                st.sampled_from((0.3, 0.7, 1.0, 1.5, 2.0, 2.5, 4.0, 15.0)),
                st.sampled_from((None, None, 0.3, 0.8, 5.0)),
                st.sampled_from((0.0, 0.0, 0.5, -0.5)),  # quarters turned before it
                st.sampled_from((0.0, 0.0, 1.5)),  # time at its end
                st.none() | st.floats(0, 1),  # a stop on it, as a part of its length
            ),
            min_size=1,
            max_size=10,
        )
    )
    return edges, draw(st.sampled_from((0.0, 2.0)))


rates = st.sampled_from((0.05, 0.3, 1.0, 2.5))


@pytest.mark.slow
@given(routes(), st.sampled_from((0.5, 1.0, 2.0)), rates, rates, st.sampled_from((0.0, 2.5)))
@settings(deadline=None, max_examples=max(35, settings.default.max_examples))
def test_any_route_with_stops_takes_the_closed_form_of_the_fastest_drives_between_them(
    route, speed, acceleration, deceleration, pause
):
    edges, turn_time = route
    floor, names = _street(edges, turn_time)
    steps, pieces, expected = [], [], 0.0

    def stop(spent):
        nonlocal pieces, expected
        expected += drive_time(pieces, acceleration, deceleration) + spent if pieces else spent
        pieces = []

    way = names[:1]
    for i, (length, limit, _, node_time, part) in enumerate(edges):
        way.append(names[i + 1])
        lane, pace, at = floor.traffic.lanes[names[i], names[i + 1]], min(speed, limit or math.inf), 0.0
        if part is not None:
            at = lane.clear_stop(part * length)
            steps += [(" ".join(way), at), pause]
            way = way[-1:]
            pieces.append((at, pace))
            stop(pause)
        if length > at:
            pieces.append((length - at, pace))
        last = i + 1 == len(edges)
        spent = node_time + (0.0 if last else lane.turn_to(floor.traffic.lanes[names[i + 1], names[i + 2]]))
        if last:
            steps.append(" ".join(way))
        if spent or last:
            stop(spent)
    robot = floor.robot(*steps, speed=speed, motion=Motion(1 / acceleration, 1 / deceleration))
    floor.run()
    assert floor.there(robot)[-1] == near(expected, abs=1e-9)


def _street(edges, turn_time):
    """Edges in a row, each turned against the one before; an extra name at the end takes the last step to its node."""
    names, points, heading = [f"n{i}" for i in range(len(edges) + 1)], [(0.0, 0.0)], 0.0
    for length, _, turned, _, _ in edges:
        heading += turned * math.pi / 2
        x, y = points[-1]
        points.append((x + length * math.cos(heading), y + length * math.sin(heading)))
    drawn = [(f"{a}>{b}", length, limit) for (a, b), (length, limit, *_) in zip(pairwise(names), edges, strict=True)]
    node_times = {name: edge[3] for name, edge in zip(names[1:], edges, strict=True)}
    floor = Floor(dict(zip(names, points, strict=True)), drawn, D=1.0, turn_time=turn_time, node_times=node_times)
    return floor, names


# Several robots


def test_a_robot_that_comes_to_its_last_lane_at_speed_brakes_from_there():
    """Speed 1 is gathered over 4 and lost over 1. Of 0.2 from a stand it brakes over a fifth, after 20 and 2 over 1.

    After a lane at 0.5, a speed gathered over 1, it may gather more over 3: it brakes over a fifth of 3 + 1. After one
    at 0.9 it is at full speed in time, and brakes over 1.
    """
    stand = Stretch(Motion(8.0, 2.0))
    assert stand.further(0.2, 1.0)[1].braking_distance(1.0) == near(0.04)
    _, fast = stand.further(20.0, 0.9)[1].further(2.0, 1.0)
    assert fast.braking_distance(1.0) == 1.0
    _, slow = stand.further(20.0, 0.5)[1].further(3.0, 1.0)
    assert slow.braking_distance(1.0) == near((1 + 3) / 5)


def test_those_that_wait_in_a_row_start_together_and_flow_as_one():
    """The first loads at 20 until 40, the others stand 2 and 4 behind it; it is at B at 51, and they follow."""
    floor = line("A B C", 30, 60)
    robots = [floor.robot(("A B", 20), 18, "B C", PARK, motion=HALF)]
    robots += [floor.robot("A B C", PARK, start=4.0 * i, motion=HALF) for i in (1, 2)]
    floor.run()
    assert floor.there(robots[0])[0] == near(22)
    assert [floor.enters(robot)["B>C"] for robot in robots] == [near(51), near(53), near(55)]
    # a start that waits for another to gather speed is part of gathering it: no further wait
    assert [[wait[1:3] for wait in floor.waits(robot) if wait[0] == "A>B"] for robot in robots] == [
        [],
        [(near(4 + 1 + 18), near(40))],
        [(near(8 + 1 + 16), near(40))],
    ]


def test_a_robot_that_waits_at_a_node_brakes_and_gathers_speed_again():
    """At right angles, D = 2: the first is on X at 1 + 10; the other at its stop line at 2 + 1 + 8, and waits there."""
    nodes = {"W": (0, 10), "X": (10, 10), "E": (20, 10), "N": (10, 0), "S": (10, 20)}
    floor = Floor(nodes, ["W>X", "X>E", "N>X", "X>S"])
    floor.robot("W X E", PARK, motion=HALF)
    second = floor.robot("N X S", PARK, start=2, motion=HALF)
    floor.run()
    ((_, begin, end, _),) = floor.waits(second)
    assert begin == near(11)
    # it has braked by 12; from there 1 to gather speed, 12 to drive, 1 to brake
    assert floor.there(second) == [near(max(end, 12) + 1 + 12 + 1)]


def test_a_ring_that_closes_as_its_robots_come_to_their_stop_lines_turns_when_they_have_braked():
    """3 to the stop line and 1 to gather speed: seen at 4, braked at 5, on the move at 6, at the next node at 13."""
    corners = {"A": (0, 0), "B": (10, 0), "C": (10, 10), "D": (0, 10)}
    floor = Floor(corners, [(f"{a}>{b}", 5) for a, b in pairwise("ABCDA")])
    robots = [floor.robot(" ".join("ABCDABC"[k : k + 3]), PARK, motion=HALF) for k in range(4)]
    floor.run()
    assert [time for time, *_ in floor.log.rings] == [near(4)]
    assert [floor.there(robot) for robot in robots] == [[near(6 + 2 + 5 + 1)]] * 4  # and to a stand


def test_a_ring_of_waiting_robots_turns_when_the_last_has_gathered_speed():
    fleet = {**ring.RING["fleet"], "size": 40, "robot": {**ring.RING["fleet"]["robot"], "acceleration": 0.5}}
    places = [{"edge": list(edge), "offset": offset} for edge in ("AB", "BC", "CD", "DA") for offset in range(1, 10)]
    fleet["start_on_lanes"] = [*places, *({"node": node} for node in "ABCD")]
    run = dw.simulate(dw.load(ring.RING, {"fleet": fleet, "tasks.goods": {"random": 60}, "tasks.unload_at": ["C"]}))
    assert run.kpis["tasks"] == 60
    assert run.kpis["rotations"] > 0
    assert audit(run) == []


# Whole models


def simulated(**changes):
    named = {key.replace("__", "."): value for key, value in changes.items()}
    return dw.simulate(dw.load(ring.RING, {"fleet.size": 1, "tasks.goods": [1], **named}))


def when(run, kind):
    return [row.time for row in run.history.rows(kind)]


def test_with_a_load_it_drives_at_another_speed():
    """A ring of edges of 10: good 1 lies on C>D at 5; 25 at 1, 5 to load, 5 at 0.5 to D, 3 to unload, 10 home at 1."""
    run = simulated(fleet__robot__speed_loaded=0.5)
    assert when(run, "loaded") == [30]
    assert when(run, "unloading") == [40]
    assert run.T == 53
    assert audit(run) == []


def test_a_task_takes_its_starts_and_stops():
    """The same with a load at 0.5, and 0.5 per time unit to gather and to brake: 25 + 2, 5, 5 / 0.5 + 1, 3, 10 + 2."""
    run = simulated(fleet__robot__speed_loaded=0.5, fleet__robot__acceleration=0.5)
    assert when(run, "loading") == [27]
    assert when(run, "unloading") == [27 + 5 + 11]
    assert run.T == 27 + 5 + 11 + 3 + 12
    assert audit(run) == []


def test_kinds_have_their_own():
    fleet = dw.load(
        ring.RING,
        {
            "fleet.size": 4,
            "fleet.robot.acceleration": "0.5 m/s^2",
            "fleet.robot.speed_loaded": 0.8,
            "fleet.kinds": {
                "lift": {"count": 1, "acceleration": 0.25},
                "tug": {"count": 1, "deceleration": 2, "speed": 2},
                "cart": {"count": 1, "speed_loaded": 0.4},
            },
        },
    ).fleet
    assert [(one.speed, one.loaded_speed, *one.motion) for one in fleet.robots()] == [
        (1, 0.8, 4, 4),
        (2, 2, 2, 0.5),
        (1, 0.4, 2, 2),
        (1, 0.8, 2, 2),
    ]


def test_a_battery_lasts_for_the_starts_and_stops():
    """27 to the good and 5 there, 11 to D, 3 there and 12 home are 58; a robot that has less would not set out."""
    changes = {"fleet__robot__speed_loaded": 0.5, "fleet__robot__acceleration": 0.5}
    charging = {"name": "reach-aware", "margin": 0.0}

    def with_battery(capacity):
        battery = {"capacity": capacity, "threshold": 0, "consumption": 1, "charge_rate": 100}
        return simulated(**changes, battery=battery, policies__charging=charging)

    assert with_battery(58.01).kpis["tasks"] == 1
    with pytest.raises(dw.errors.WarehouseError, match=r"no battery seems to last|draws at least|lasts for task"):
        with_battery(57.9)


def test_what_a_stop_costs_is_said_beforehand():
    model = dw.load(ring.RING, {"fleet.robot.acceleration": 0.5, "fleet.robot.deceleration": 0.25})
    assert "a stop on the way costs up to 3 s of braking and acceleration" in check(model).facts
    assert not any("a stop on the way" in fact for fact in check(dw.load(ring.RING)).facts)


def test_the_hand_calculation_counts_a_start_and_a_stop_of_each_drive():
    model = dw.load(
        ring.RING,
        {"fleet.size": 1, "fleet.robot.acceleration": 0.5, "fleet.robot.speed_loaded": 0.5, "run.length": 6000}
        | {"layout.storage": [ring.RING["layout"]["storage"][1]], "tasks.goods": {"saturated": 1}, "run.warm_up": 600},
    )
    cycle = check(model).calculation.cycle
    assert (cycle.empty, cycle.loaded, cycle.time) == near((35 + 2, 10 + 1, 56))
    assert dw.simulate(model).kpis["tasks"] == near(5400 / 56, abs=1)


SHAPES = [(1, 0.5, 1.5), (0.4, 0.5, 1), (1.3, 0.3, 1), (2, 0.5, 1)]


@pytest.mark.parametrize(("headway", "acceleration", "speed"), SHAPES)
def test_a_queue_moves_up_from_stand_to_stand(headway, acceleration, speed):
    """Behind one that has stood for 40 at 30 along: each next one is at B as long after it as driving D takes."""
    motion = Motion(1 / acceleration, 1 / acceleration)
    floor = line("A B", 60, D=headway)
    first = floor.robot(("A B", 30), 40, "B", PARK, speed=speed, motion=motion)
    others = [floor.robot("A B", PARK, speed=speed, motion=motion) for _ in range(3)]
    floor.run()
    there = [floor.there(robot)[-1] for robot in (first, *others)]
    assert [later - one for one, later in pairwise(there)] == [near(2 * math.sqrt(headway / acceleration))] * 3


@pytest.mark.parametrize("looks_ahead", [False, True])
@pytest.mark.parametrize(("headway", "acceleration", "speed"), SHAPES)
def test_out_of_a_bay_they_start_as_far_apart_as_at_full_speed(headway, acceleration, speed, looks_ahead):
    """D at full speed and what gathering it takes: too long where D < v² / 2a, as `world.traffic.motion` says."""
    motion = Motion(1 / acceleration, 1 / acceleration)
    floor = line("A B", 60, D=headway)
    robots = [floor.robot("A B", PARK, speed=speed, motion=motion, looks_ahead=looks_ahead) for _ in range(3)]
    floor.run()
    begun = [floor.enters(robot)["A>B"] for robot in robots]
    gap = headway / speed + speed / (2 * acceleration)
    assert [later - one for one, later in pairwise(begun)] == [near(gap)] * 2
