"""Zones: one robot at a time in a part of the floor, and one direction at a time in a line of two-way lanes."""

from itertools import pairwise

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.check import check
from desim_warehouse.world.traffic.avoidance import Avoidance
from desim_warehouse.world.traffic.zones import ZoneDirection
from tests.auditor import audit
from tests.laws.features import warehouse

LOOP = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [30, 0], "D": [40, 0], "E": [20, 20]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "E"], ["E", "A"]],
        "storage": [{"edge": ["E", "A"], "offset": 10.0}],
        "bays": {"home": {"at": ["A"], "places": 3}},
        "stations": {"packing": {"at": ["D"], "places": 3, "servers": 3}},
    },
    "fleet": {"size": 3, "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {"goods": [0, 0, 0], "unload_at": ["packing"], "load_time": 0, "unload_time": 1},
    "policies": {"routing": "shortest"},
}


def on(run, edge):
    """When robots were on an edge: pairs of when each came and left, in order."""
    stays, since = [], {}
    for time, kind, robot, _, _, where, *_ in run.record.rows:
        if kind == "enter" or kind in {"parked", "docked"}:
            if robot in since:
                stays.append((since.pop(robot), time))
            if where == edge:
                since[robot] = time
    return sorted(stays)


def zone(*members, rule="one-robot"):
    return {"traffic.zones": {"narrow": {"members": list(members), "rule": rule}}}


def test_the_next_robot_waits_before_a_zone_until_the_one_in_it_is_out():
    """B>C is 20 long; the next one drives onto B as the first leaves C, where it has been held up D before B."""
    first, second = on(dw.simulate(dw.load(LOOP)), ("B", "C"))[:2]
    assert second[0] < first[1]
    one_by_one = on(dw.simulate(dw.load(LOOP, zone(["B", "C"]))), ("B", "C"))
    for before, then in pairwise(one_by_one):
        assert then[0] >= before[1] + 1 - 1e-9
    assert one_by_one[0] == first
    assert one_by_one[1] == pytest.approx((first[1] + 1, first[1] + 21))


SPINE = {
    "layout": {
        "nodes": {"W": [0, 0], "P": [10, 0], "Q": [20, 0], "E": [30, 0], "p": [10, 10], "q": [20, 10]},
        "edges": [
            {"from": a, "to": b, "two_way": True}
            for a, b in (("W", "P"), ("P", "Q"), ("Q", "E"), ("P", "p"), ("Q", "q"))
        ],
        "storage": [{"edge": ["P", "p"], "offset": 5}, {"edge": ["Q", "q"], "offset": 5}],
        "bays": {"home": {"at": ["W", "E"], "places": 2}},
    },
    "fleet": {"size": 2, "start": ["W", "E"], "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {"goods": [0, 1], "unload_at": ["p", "q"], "load_time": 1, "unload_time": 1},
    "policies": {"routing": "shortest", "parking": "home"},
}
LINE = zone(["W", "P"], ["P", "Q"], ["E", "Q"], rule="one-direction")


def test_robots_from_both_ends_enter_a_line_at_once_unless_it_is_a_zone_of_one_direction():
    """Robot 0 from the west to the first spur, robot 1 from the east to the second: neither is in the other's way."""
    free = dw.simulate(dw.load(SPINE))
    assert [on(free, edge)[0] for edge in (("W", "P"), ("E", "Q"))] == [(0, 10), (0, 10)]
    run = dw.simulate(dw.load(SPINE, LINE))
    (came, _), (went, _) = on(run, ("W", "P"))[0], on(run, ("E", "Q"))[0]
    assert (came, went) == (0, 10)  # as the first one is on its spur
    assert audit(run) == []
    run = dw.simulate(dw.load(SPINE, {**LINE, "traffic.node_time": 3}))
    assert on(run, ("E", "Q"))[0][0] == 10 + 3  # which it takes after the time on the node
    assert audit(run) == []


def test_the_auditor_sees_what_the_zone_prevents(monkeypatch):
    monkeypatch.setattr(Avoidance, "_enter_zones", lambda *_: True)
    run = dw.simulate(dw.load(SPINE, LINE))
    assert [line for line in audit(run) if "are both in zone narrow" in line]
    # A zone of one robot is an intersection: to break it the model is exchanged for one that has it.
    without = dw.simulate(dw.load(LOOP))
    without.model = dw.load(LOOP, zone(["B", "C"]))
    assert [line for line in audit(without) if "are both in zone narrow" in line]


def test_robots_follow_each_other_in_a_zone_of_one_direction():
    through = {
        "fleet.start": ["W", "W"],
        "tasks.goods": [0, 0],
        "tasks.unload_at": ["E"],
        "layout.storage": [{"edge": ["P", "Q"], "offset": 5}],
        "layout.stations": {"packing": {"at": ["E"]}},
        "policies.parking": "nearest",
    }
    visits = on(dw.simulate(dw.load(SPINE, {**LINE, **through})), ("W", "P"))
    assert visits[1][0] < visits[0][1]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (zone(["W", "P"], ["Q", "E"], rule="one-direction"), "its edges are no line, so they have no two directions"),
        (zone(["W", "P"], ["P", "Q"], ["P", "p"], rule="one-direction"), "its edges are no line"),
        (zone(["W", "P"], "Q", rule="one-direction"), "node Q is on none of its edges; leave it out"),
        ({**LINE, "traffic.gridlock": "stop"}, "could get stuck under traffic.gridlock: stop; say auto or avoid"),
        ({**LINE, "fleet.robot.radius": 6}, "P-Q is shorter than 24 \\(2 D\\)"),
        (
            {
                "traffic.zones": {
                    "one": {"members": ["P"], "rule": "one-robot"},
                    "line": {"members": [["W", "P"], ["P", "Q"]], "rule": "one-direction"},
                }
            },
            "shares node P with zone one, so a robot could hold the one while it waits for the other; leave it out",
        ),
    ],
)
def test_a_zone_that_cannot_be_safe_is_refused_with_its_name_and_a_cure(changes, message):
    with pytest.raises(dw.LayoutError, match=message):
        dw.simulate(dw.load(SPINE, changes))


def test_a_zone_of_one_way_lanes_has_its_direction_already():
    with pytest.raises(dw.LayoutError, match="narrow: A>B is not two-way, so its direction is given"):
        dw.simulate(dw.load(LOOP, zone(["A", "B"], rule="one-direction")))


@pytest.mark.parametrize(
    ("members", "message"),
    [
        (["X"], "no such node"),
        ([["A", "C"]], "no such edge"),
        ([], "members"),
        ([3], "the name of a node, or an edge as"),
    ],
)
def test_members_must_be_there(members, message):
    with pytest.raises(dw.ModelError, match=message):
        dw.load(LOOP, zone(*members))


@pytest.mark.parametrize(
    ("start", "zones"),
    [({"node": "P"}, zone("P")), ({"edge": ["P", "Q"], "offset": 5}, LINE), ({"edge": ["Q", "P"], "offset": 5}, LINE)],
)
def test_no_robot_starts_in_a_zone(start, zones):
    with pytest.raises(dw.CheckError, match="is in zone narrow; start it outside, or in a bay"):
        dw.simulate(dw.load(SPINE, {**zones, "fleet.start_on_lanes": [start]}))


def test_zones_that_share_a_node_are_one_and_check_says_so():
    zones = {
        name: {"members": members, "rule": "one-robot"} for name, members in (("one", ["A", "B"]), ("two", ["B", "C"]))
    }
    findings = check(dw.load(LOOP, {"traffic.zones": zones})).findings
    assert [item.code for item in findings if item.level == "warning" and "zone" in item.place] == ["ZONES_JOINED"]


def test_nobody_asks_again_and_again_when_a_robot_that_is_held_up_on_a_node_will_leave_a_zone(monkeypatch):
    """Robot 13, due to break down, stands on the node at the end of the zone at 468.8, and is delayed by 0.5."""
    times = []
    is_in = ZoneDirection.is_in
    monkeypatch.setattr(ZoneDirection, "is_in", lambda self, robot, now: times.append(now) or is_in(self, robot, now))
    mapping = warehouse(19, "zones breakdowns", "bridges")
    run = dw.simulate(dw.load({**mapping, "run": {"length": 480}}), 19)
    [entered] = [row for row in run.record.rows if row[:3:2] == (pytest.approx(469.3459), 13) and row[1] == "enter"]
    assert entered[5] == ("c0.0", "c2.1")
    assert 0 < sum(468 < time < 470 for time in times) < 10
