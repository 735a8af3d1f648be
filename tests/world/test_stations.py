"""Stations beside a node: places are reserved before a robot is sent, so that their queue never stands in a lane.

A > B > C > D > A, 20 apart, D = 1, speed 1; good 0 is 10 beyond A; the station is at C.
"""

from collections import Counter

import pytest

from desim_warehouse import load, simulate
from tests.auditor import audit

near = pytest.approx


def play(places, servers, robots, goods, **changes):
    model = {
        "layout": {
            "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 20], "D": [0, 20]},
            "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
            "storage": [{"edge": ["A", "B"], "offset": 10}],
            "bays": {"home": {"at": ["A"]}},
            "stations": {"packing": {"at": ["C"], "places": places, "servers": servers}},
        },
        "fleet": {"size": robots, "robot": {"radius": 0.5, "speed": 1}},
        "tasks": {"goods": [0] * goods, "unload_at": ["C"], "load_time": 0, "unload_time": 100},
        "traffic": {"collision_angle": 0},  # so that robots follow each other D apart round corners too
    }
    return simulate(load(model, changes))


def times(run, kind):
    return [row[0] for row in run.record.rows if row[1] == kind]


def test_one_server_serves_one_after_the_other():
    run = play(places=3, servers=1, robots=3, goods=3)
    # robots leave A 1 apart, at 0, 1, 2, and are in the station 40 later; served 100 each, from 40 on
    assert times(run, "docked") == [near(40), near(41), near(42)]
    assert times(run, "unloading") == [near(40), near(140), near(240)]
    assert times(run, "delivered") == [near(140), near(240), near(340)]


def test_servers_serve_at_the_same_time():
    run = play(places=3, servers=2, robots=3, goods=3)
    assert times(run, "unloading") == [near(40), near(41), near(140)]


def test_the_queue_is_in_the_station_and_not_in_the_lane():
    run = play(places=3, servers=1, robots=3, goods=3)
    # nobody waits in traffic but robots 1 and 2 in the bay, 1 and 2 time units, for the one before to leave
    assert [(row[4], row[6]) for row in run.record.rows if row[1] == "collision"] == [("A", near(1)), ("A", near(2))]
    assert run.nodes.loc["C", "waits"] == 0
    assert run.robots["queueing"].tolist() == [0, near(99), near(198)]
    # at home from 180, 280 and 380 on, until the last one is there
    assert run.robots["idle"].tolist() == [near(200), near(100), near(0)]


def test_no_task_is_given_out_for_a_station_without_a_free_place():
    run = play(places=2, servers=1, robots=3, goods=3)
    # the first robot has unloaded at 140; only then is the third task given out, to it: C D A B C are 80. Robot 2 stays
    assert times(run, "assigned") == [0, 0, near(140)]
    assert times(run, "docked")[2] == near(140 + 80)
    assert run.robots["idle"][2] == run.T
    inside = 0
    for row in run.record.rows:
        inside += (row[1] == "docked") - (row[1] == "delivered")
        assert inside <= 2


@pytest.mark.parametrize(("places", "servers"), [(1, 1), (2, 1), (4, 2), (4, 4)])
def test_never_more_robots_than_places_nor_unloading_than_servers(places, servers):
    run = play(places, servers, robots=6, goods=20)
    assert run.kpis["tasks"] == 20
    assert audit(run) == []
    state, most = Counter(), Counter()
    for row in run.record.rows:
        if row[1] in {"docked", "unloading", "delivered"}:
            state["inside"] += {"docked": 1, "unloading": 0, "delivered": -1}[row[1]]
            state["served"] += {"docked": 0, "unloading": 1, "delivered": -1}[row[1]]
            most |= state
    assert most == {"inside": places, "served": servers}


def test_a_node_in_the_lane_is_used_by_one_robot_at_a_time():
    """Without a station robots unload on the node: the next one waits D = 1 before it."""
    run = play(
        places=1, servers=1, robots=2, goods=2, **{"layout.stations": {}, "tasks.unload_time": 10, "tasks.load_time": 5}
    )
    # robot 0 loads at 10 until 15 and is on C at 45, until 55. Robot 1, from A at 1, waits at 9 from 10 to 15 for the
    # good, is at 10 at 16, loads until 21 and is at its stop line, 39 from A, at 50: it waits until 55
    assert [(row[4], row[5], row[0] - row[6], row[0]) for row in run.record.rows if row[1] == "collision"] == [
        ("A", None, near(0), near(1)),
        (None, ("A", "B"), near(10), near(15)),
        ("C", None, near(50), near(55)),
    ]
    assert times(run, "delivered") == [near(55), near(66)]


@pytest.mark.parametrize("gridlock", ["rotate", "avoid"])
def test_who_queues_for_a_server_draws_also_where_its_bay_has_a_charger(gridlock):
    """Bay and station are beside C: 80 round, then 99 in the queue at 0.5; the charger is not where it queues."""
    battery = {"capacity": 2000, "threshold": 10, "charge_rate": 1}
    battery["consumption"] = {"standing": 0.5, "empty": 1, "loaded": 1, "handling": 0}
    own = {"layout.bays.home.at": ["C"], "battery": battery, "traffic.gridlock": gridlock}
    run = play(places=3, servers=1, robots=2, goods=2, **own)
    begun = [row.value for row in run.history.rows("queueing", "unloading") if row.robot == 1]
    assert begun == [near(2000 - 80 - 0.5), near(2000 - 80 - 0.5 - 99 * 0.5)]  # 0.5: it waits 1 to leave after robot 0
