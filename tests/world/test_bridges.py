"""Two-way bridges between one-way streets: robots make way for others on the streets, so the bridges carry."""

from types import SimpleNamespace

import pytest
import simpy

import desim_warehouse as dw
from benchmarks.two_way import core_model
from desim_warehouse.questions.check import check
from desim_warehouse.world.traffic.avoidance import Avoidance
from tests.auditor import audit


def halls(robots):
    """Two one-way triangles joined by one two-way bridge of 20 m; work is behind it."""
    return {
        "layout": {
            "nodes": {"A": [0, 0], "B": [20, 0], "A1": [-20, -10], "A2": [-20, 10], "B1": [40, -10], "B2": [40, 10]},
            "edges": [
                {"from": "A", "to": "B", "two_way": True},
                *(
                    list(edge)
                    for edge in (("A", "A1"), ("A1", "A2"), ("A2", "A"), ("B", "B1"), ("B1", "B2"), ("B2", "B"))
                ),
            ],
            "storage": [{"edge": ["B1", "B2"], "offset": 10}],
            "bays": {"bay": {"at": ["A1"], "places": robots}},
            "stations": {"st": {"at": ["A2"], "places": robots, "servers": robots}},
        },
        "fleet": {"size": robots, "robot": {"radius": 0.5, "speed": 1}},
        "tasks": {"goods": {"saturated": 60}, "unload_at": ["st"], "load_time": 0, "unload_time": 0},
        "policies": {"routing": "shortest"},
        "run": {"length": 6000, "warm_up": 2000},
        "log": "all",
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robots", "least", "length"),
    [
        (2, 43, 6000),
        (8, 165, 2000),
        *(pytest.param(*each, 6000, marks=pytest.mark.long) for each in ((4, 86), (8, 165), (24, 500))),
    ],
)
def test_a_bridge_between_two_halls_carries_nearly_what_robots_do_that_never_wait(robots, least, length):
    """A round takes 167 s: two robots do 43 an hour, eight 172. One at a time on the bridge they would do 33 in all."""
    run = dw.simulate(dw.load(halls(robots), {"run.length": length, "run.warm_up": length / 3}), 0)
    assert run.kpis["throughput_per_hour"] >= least
    assert audit(run) == []


def test_check_says_on_how_many_lanes_robots_make_way():
    notes = [item.text for item in check(dw.load(halls(2))).findings if item.code == "TWO_WAY"]
    assert notes[0].endswith("(traffic.gridlock: avoid); robots make way for others on 6 one-way lanes")


def core(robots, length, seed=0):
    model = dw.load(core_model("one-way core, two-way bridges", robots))
    return dw.simulate(model.replace({"run.length": length, "run.warm_up": length / 3}), seed)


@pytest.mark.slow
@pytest.mark.parametrize(
    "length", [300.0, *(pytest.param(each, marks=pytest.mark.long) for each in (600.0, 1800.0, 5400.0))]
)
def test_a_one_way_core_with_twenty_bridges_has_no_knee_at_a_hundred_robots(length):
    run = core(100, length)
    assert run.kpis["throughput_per_hour"] >= 1450
    assert run.kpis["share_waiting"] < 0.1


@pytest.mark.long
def test_two_hundred_robots_on_the_core_go_on_working():
    run = core(200, 3600.0)
    assert run.kpis["throughput_per_hour"] >= 1450


class Robot:
    """A robot that stands on its way and is in working order."""

    broken, blocker, claim = False, None, None


@pytest.mark.parametrize(
    ("waited", "on_its_way", "elsewhere"), [(9, False, False), (11, True, False), (51, True, True)]
)
def test_a_robot_that_waits_holds_back_departures_into_its_way_and_when_desperate_all(waited, on_its_way, elsewhere):
    """Its patience is 10; it is desperate after five times as long."""
    env = simpy.Environment()
    guard, oldest = Avoidance(env, 10.0), Robot()
    guard.declared.users["its stand"][oldest] = None
    guard.wait_begins(SimpleNamespace(robot=oldest, begun=0.0, via="lane"))
    env.run(waited)
    held_back = [guard._held_back_by(Robot(), stand) is oldest for stand in ("its stand", "another stand")]
    assert held_back == [on_its_way, elsewhere]
