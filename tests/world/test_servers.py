"""A server keeps a robot until it has handled all that it came for: worked out by hand, on the ring of `test_flows`.

Robots carry two loads, leave A one after the other, and are at the dock B from 20 and 21 on. One load takes 4 there.
"""

import pytest

import desim_warehouse as dw
from tests.auditor import audit
from tests.world.test_flows import RING
from tests.world.test_tours import ring

FLOW = {"from": "dock", "to": "pack"}
TWO = {"fleet__size": 2, "traffic__collision_angle": 0}


def turns(run, kind):
    return [(row.robot, row.time) for row in run.history.rows(kind)]


def pack(**spec):
    return {"layout__stations": {"dock": {"at": ["B"], "places": 2}, "pack": {"at": ["D"], "places": 2, **spec}}}


def test_loads_of_one_robot_are_loaded_and_unloaded_before_those_of_the_next():
    run = ring({**FLOW}, (0, 4), **TWO)
    assert turns(run, "loading") == [(0, 20), (0, 24), (1, 28), (1, 32)]
    # 40 to D: at 68 and 76. Unloading takes 6
    assert turns(run, "unloading") == [(0, 68), (0, 74), (1, 80), (1, 86)]
    assert turns(run, "queueing") == [(1, 21), (1, 76)]
    assert run.robots["queueing"].tolist() == [0, 7 + 4]


def test_each_of_several_servers_keeps_its_robot():
    stations = {"dock": {"at": ["B"], "places": 3, "servers": 3}, "pack": {"at": ["D"], "places": 3, "servers": 2}}
    run = ring({**FLOW}, (0, 6), **TWO | {"fleet__size": 3}, layout__stations=stations)
    assert turns(run, "unloading") == [(0, 68), (1, 69), (0, 74), (1, 75), (2, 80), (2, 86)]


def test_it_waits_for_room_in_the_buffer_at_its_server():
    """Room for one, worked on for 10 from 74 to 84, then from 90 to 100: only then the second robot begins, at 100."""
    run = ring({**FLOW}, (0, 4), **TWO, **pack(work_time=10, buffer=1))
    assert turns(run, "unloading") == [(0, 68), (0, 84), (1, 100), (1, 116)]
    assert turns(run, "queueing") == [(1, 21), (0, 74), (1, 76), (1, 106)]


@pytest.mark.parametrize(("at_close", "begun"), [("finish", (200, 206, 212)), ("pause", (202, 208, 214))])
def test_as_the_station_closes_it_keeps_its_server_until_the_morning(at_close, begun):
    """Closed from 72 to 200, in the midst of the first load: that is finished at 74, or 2 after the opening."""
    over = {"calendars": {"day": {"between": [[0, 72], [200, 900]]}}}
    run = ring({**FLOW}, (0, 4), **TWO, **over, **pack(hours="day", at_close=at_close))
    first, *then = [row for row in turns(run, "unloading") if row[1] != 200 or at_close == "finish"]
    assert first == (0, 68)
    assert then == [(0, begun[0]), (1, begun[1]), (1, begun[2])]


def test_what_is_handed_over_and_then_unloaded_in_one_station_is_one_turn():
    """Single loads, at D at 64 and 68: 30 to hand over, 6 to unload."""
    run = ring({**FLOW, "via": ["pack"], "stop_time": 30}, (0, 2), **TWO, policies__batching="single")
    assert turns(run, "unloading") == [(0, 64), (0, 94), (1, 100), (1, 130)]


def test_a_robot_that_leaves_and_comes_back_takes_its_turn_again():
    """Single loads that are handed over at D, brought round to B, and unloaded at D: 30 to hand over."""
    flow = {**FLOW, "via": ["pack", "dock"], "stop_time": 30}
    run = ring(flow, (0, 2), **TWO, policies__batching="single")
    # B 20 to 24, D 64 to 94, B 134 to 164, D 204 to 210; the other: B to 28, D 94 to 124, B 164 to 194, D 234 to 240
    assert turns(run, "unloading") == [(0, 64), (1, 94), (0, 134), (1, 164), (0, 204), (1, 234)]


def round_trips(time, length):
    """Three robots that carry three loads: 6 to load each, 60 to the station, 20 to unload each, 90 back."""
    model = {
        **RING,
        "layout": {
            "nodes": {"A": [0, 0], "B": [100, 0], "C": [100, 50], "E": [0, 50]},
            "edges": [["A", "B"], ["B", "C"], ["C", "E"], ["E", "A"]],
            "storage": [{"edge": ["A", "B"], "offset": 30}],
            "bays": {"home": {"at": ["C"], "places": 3}},
            "stations": {"pack": {"at": ["C"], "places": 3, "servers": 1}},
        },
        "fleet": {"size": 3, "robot": {"radius": 0.01, "speed": 2, "capacity": 3}},
        "tasks": {"goods": {"saturated": 12}, "unload_at": ["pack"], "load_time": 6, "unload_time": time},
        "policies": {"batching": "fixed-size"},
        "run": {"length": length, "warm_up": length / 10},
    }
    return dw.simulate(dw.load(model), 1)


def test_robots_that_come_in_time_never_queue():
    """A round takes 18 + 60 + 60 + 90 = 228, of which 60 at the server: three robots, once apart, are never in the way.

    Served in turn, load by load, they come back together and queue for ever: 132.5 an hour where loads are many.
    """
    run = round_trips(20, 22_800)
    assert run.kpis["tasks"] == pytest.approx(22_800 * 0.9 / 228 * 9, abs=9)
    assert [row.time for row in run.history.rows("queueing") if row.time > 1000] == []


@pytest.mark.parametrize("time", [{"exponential": 20}, {"lognormal": {"mean": 20, "cv": 2}}])
def test_with_times_that_vary_each_robot_is_served_in_turn(time):
    """The auditor works out by recursion when each turn is due: after the one before, and all of its loads."""
    run = round_trips(time, 20_000)
    assert run.kpis["share_queueing"] > 0.02
    assert audit(run) == []
