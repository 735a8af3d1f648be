"""Traffic as a flow: what a lane and an intersection can carry, and how a ring fills up.

Robots keep D apart, so at speed v nothing lets more than v / D of them pass; who turns or crosses needs more.
"""

import math
from itertools import pairwise

import pytest

import desim_warehouse as dw

D, SPEED = 1.0, 2.0
ROBOT = {"radius": 0.4, "margin": 0.2, "speed": SPEED}


def oval(around, robots, *, node_time=0.0, unload_time=0.0, length=None):
    """A closed ring of four nodes; every robot goes round it for ever, a good in each round."""
    side = around / 4
    length = length or 60 * around / SPEED
    return {
        "layout": {
            "nodes": {"A": [0, 0], "B": [side, 0], "C": [side, side], "E": [0, side]},
            "edges": [["A", "B"], ["B", "C"], ["C", "E"], ["E", "A"]],
            "storage": [{"edge": ["B", "C"], "offset": side / 2}],
            "bays": {"home": {"at": ["A"]}},
        },
        "fleet": {"size": robots, "robot": ROBOT},
        "tasks": {"goods": {"saturated": robots}, "unload_at": ["E"], "load_time": 0, "unload_time": unload_time},
        "traffic": {"node_time": node_time},
        "run": {"length": length, "warm_up": length / 2},
        "log": "moves",
    }


def simulated(model):
    return dw.simulate(dw.load(model), 0)


def per_time(run):
    return run.kpis["tasks"] / (run.T - run.model.run.warm_up)


def headway_of_a_turn(angle, theta, node_time=0.0):
    """Time between two robots that turn off one after the other.

    The next sets out from D before the node once it will never be nearer than D to the one ahead and look at it
    within theta of its heading: when that one is g - D beyond, g = D cos(angle/2 - a) / cos(angle/2), a at most theta.
    """
    a = min(theta, angle / 2)
    beyond = D * math.cos(angle / 2 - a) / math.cos(angle / 2) - D
    return (D + beyond) / SPEED + node_time


@pytest.mark.parametrize("robots", [1, 5, 20, 50, 60, 70])
def test_a_ring_carries_what_is_on_it_up_to_what_its_corners_let_through(robots):
    """Free flow: n robots pass a point n times a round, until the corners are the bottleneck (from 59 robots on)."""
    around = 80 * D
    most = 1 / headway_of_a_turn(math.pi / 2, math.radians(30))
    assert per_time(simulated(oval(around, robots))) == pytest.approx(min(robots * SPEED / around, most), rel=0.01)


@pytest.mark.parametrize("robots", [20, 40, 60])
def test_time_spent_at_a_corner_adds_to_its_headway(robots):
    pause = 3.0
    headway = headway_of_a_turn(math.pi / 2, math.radians(30), pause)
    assert per_time(simulated(oval(80 * D, robots, node_time=pause))) == pytest.approx(1 / headway, rel=0.01)


def test_unloading_in_the_lane_takes_the_lane():
    """One robot at a time: it drives the last D, unloads, and sets off as the next one comes up the bend."""
    unload = 5.0
    run = simulated(oval(80 * D, 30, unload_time=unload))
    assert per_time(run) == pytest.approx(1 / (unload + headway_of_a_turn(math.pi / 2, math.radians(30))), rel=0.02)


def test_a_lane_carries_a_robot_every_d_and_a_corner_somewhat_fewer():
    """Robots leave a bay D apart and stay so along a straight street: v / D of them a time unit."""
    nodes = {"A": [0, 0], "B": [40, 0], "C": [80, 0], "E": [80, 40], "F": [0, 40]}
    model = {
        "layout": {
            "nodes": nodes,
            "edges": [*pairwise(nodes), ("F", "A")],
            "storage": [{"edge": ["E", "F"], "offset": 40}],
            "bays": {"home": {"at": ["A"]}},
        },
        "fleet": {"size": 30, "robot": ROBOT},
        "tasks": {"goods": [0] * 30, "unload_at": ["A"], "load_time": 0, "unload_time": 0},
        "log": "moves",
    }
    rows = simulated(model).record.rows
    turn = headway_of_a_turn(math.pi / 2, math.radians(30))
    for lane, headway in ((("A", "B"), D / SPEED), (("B", "C"), D / SPEED), (("C", "E"), turn), (("E", "F"), turn)):
        times = [row[0] for row in rows if row[1] == "enter" and row[5] == lane]
        assert [b - a for a, b in pairwise(times)] == pytest.approx([headway] * 29)


def crossing(robots):
    """Two rings that cross in X at right angles; every robot keeps to its own, as its goods are nearer there."""
    far = 20 * D
    return {
        "layout": {
            "nodes": {
                "X": [0, 0],
                "E1": [far, 0],
                "E2": [far, -far],
                "E3": [-far, -far],
                "E4": [-far, 0],
                "S1": [0, far],
                "S2": [far * 1.5, far],
                "S3": [far * 1.5, -far * 1.5],
                "S4": [0, -far * 1.5],
            },
            "edges": [
                *pairwise(["X", "E1", "E2", "E3", "E4", "X"]),
                *pairwise(["X", "S1", "S2", "S3", "S4", "X"]),
            ],
            "storage": [{"edge": ["E1", "E2"], "offset": far / 2}, {"edge": ["S1", "S2"], "offset": far / 2}],
            "bays": {"east": {"at": ["E1"]}, "south": {"at": ["S1"]}},
        },
        "fleet": {"size": 2 * robots, "robot": ROBOT},
        "tasks": {
            "goods": {"saturated": 8 * robots},
            "unload_at": ["E1", "S1"] * robots,
            "load_time": 0,
            "unload_time": 0,
        },
        "policies": {"allocation": "nearest"},
        "run": {"length": 2000, "warm_up": 500},
        "log": "moves",
    }


def test_an_intersection_lets_two_streams_through_in_turn():
    """First come, first served: the streams alternate, each robot when the one before it has cleared the crossing."""
    run = simulated(crossing(60))
    through = [row for row in run.record.rows if row[1] == "enter" and row[5][0] == "X" and row[0] > 500]
    turned = sum(1 for row in through if row[5] not in {("X", "E1"), ("X", "S1")})
    assert turned == 0
    headway = headway_of_a_turn(math.pi / 2, math.radians(30))
    assert len(through) / 1500 == pytest.approx(1 / headway, rel=0.02)
