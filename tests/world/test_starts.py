"""Robots that start on the lanes: a ring A > B > C > D > A of edges of 10, speed 1, D = 1; and a two-way street."""

import pytest

import desim_warehouse as dw
from desim_warehouse.outcome.positions import Positions
from desim_warehouse.questions.check import check
from tests.auditor import audit
from tests.world.ring import RING

STREET = {
    **RING,
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [20, 0], "D": [30, 0]},
        "edges": [{"from": a, "to": b, "two_way": True} for a, b in ("AB", "BC", "CD")],
        "storage": [{"node": "C"}],
        "bays": {"home": {"at": ["A"]}},
    },
    "tasks": {**RING["tasks"], "unload_at": ["D"]},
}


def on_edge(edge, offset):
    return {"edge": list(edge), "offset": offset}


def simulated(*places, model=RING, **changes):
    changes = {key.replace("__", "."): value for key, value in changes.items()}
    return dw.simulate(dw.load(model, {"fleet.start_on_lanes": list(places), **changes}))


def when(run, kind):
    return [(row.time, row.robot, row.node) for row in run.history.rows(kind)]


def test_one_that_starts_on_the_way_gets_the_task_and_drives_on():
    """From A>B at 4 it is 6 to the good at B; the other rests in its bay."""
    run = simulated(on_edge("AB", 4))
    assert when(run, "loading") == [(6, 0, "B")]
    assert run.robots["distance"].tolist() == [36, 0]
    assert when(run, "parked") == [(44, 0, "A")]
    assert audit(run) == []


def test_one_without_a_task_goes_home():
    run = simulated({"node": "B"}, {"node": "C"})
    assert when(run, "loading") == [(0, 0, "B")]
    assert when(run, "parked") == [(20, 1, "A"), (38, 0, "A")]
    assert audit(run) == []


def test_a_decision_shows_them_where_they_come_to_next():
    """They are out already: the way out of a bay, 3, is not before them."""
    places = [on_edge("AB", 4), {"node": "D"}]
    steps = dw.steps(dw.load(RING, {"fleet.start_on_lanes": places, "fleet.exit_time": 3}))
    decision = next(steps)
    assert [(robot.node, robot.free_in, robot.home) for robot in decision.robots] == [("B", 6, "A"), ("D", 0, "A")]


def test_figures_and_history_begin_where_they_stand():
    run = simulated(on_edge("AB", 4), {"node": "D"})
    at = Positions(run.history)
    assert at.points(0).tolist() == [[4, 0], [0, 10]]
    assert at.points(2).tolist() == [[6, 0], [0, 8]]
    assert [stays[0].edge for stays in run.history.stays] == [("A", "B"), None]
    assert [spans[0].node for spans in run.history.changes] == ["B", "D"]


def test_a_lane_full_of_them_drives_off_in_order():
    places = [on_edge("AB", offset) for offset in (1, 2, 3, 4, 5, 6, 7, 8, 9)]
    run = simulated(*places, fleet__size=9)
    assert [robot for _, robot, _ in when(run, "parked")] == [8, 7, 6, 5, 4, 3, 2, 1, 0]
    assert audit(run) == []


def test_a_full_ring_turns():
    places = [on_edge(edge, offset) for edge in ("AB", "BC", "CD", "DA") for offset in range(1, 10)]
    nodes = [{"node": node} for node in "ABCD"]
    run = simulated(*places, *nodes, fleet__size=40, tasks__goods={"random": 60}, tasks__unload_at=["C"])
    assert run.kpis["tasks"] == 60
    assert run.kpis["rotations"] > 0
    assert audit(run) == []


def test_two_that_come_out_of_a_two_way_street_one_after_the_other():
    run = simulated(on_edge("BA", 4), on_edge("DC", 3), model=STREET)
    assert run.kpis["tasks"] == 1
    assert audit(run) == []


@pytest.mark.parametrize(
    ("places", "text"),
    [
        ([{"node": "B"}, {"node": "B"}], r"\.1: robot 1 on node B is on the same intersection as robot 0 on node B"),
        ([on_edge("AB", 0.5)], r"\.0: robot 0 on A>B at 0.5 is nearer than 1 \(D\) to a node; an offset from 1 to 9"),
        ([on_edge("AB", 5), on_edge("AB", 5.5)], r"\.1: robot 1 on A>B at 5.5 is nearer than 1 \(D\) to robot 0"),
    ],
    ids=["one node", "near a node", "one lane"],
)
def test_places_that_are_not_free_are_refused(places, text):
    with pytest.raises(dw.CheckError, match=text):
        simulated(*places)


def test_robots_that_face_each_other_are_refused():
    with pytest.raises(dw.CheckError, match=r"robot 1 on C>B at 3 faces robot 0 on B>C at 4"):
        simulated(on_edge("BC", 4), on_edge("CB", 3), model=STREET)


def test_robots_in_each_others_way_home_are_refused():
    """Robot 0 is to turn at C, where robot 1 stands; that one has to pass it."""
    with pytest.raises(dw.CheckError, match=r"robots 0 on B>C at 4, 1 on node C stand in each other's way home"):
        simulated(on_edge("BC", 4), {"node": "C"}, model=STREET)
    findings = check(dw.load(STREET, {"fleet.start_on_lanes": [on_edge("BC", 4), {"node": "C"}]})).errors
    assert [item.code for item in findings] == ["START_STUCK"]


def test_more_places_than_robots_are_refused():
    with pytest.raises(dw.ModelError, match=r"fleet.start_on_lanes: 3 places for fleet.size, 2"):
        simulated({"node": "B"}, {"node": "C"}, {"node": "D"})


TWO_HOMES = {
    "layout.bays": {"home": {"at": ["A", "C"], "places": 1}},
    "traffic.gridlock": "avoid",
    "fleet.start_on_lanes": [on_edge("AB", 4), on_edge("CD", 4)],
}
"""Robot 0 has to pass C>D on its way home to A, and robot 1 A>B on its way to C."""


def test_robots_in_each_others_way_home_may_start_where_one_can_make_way():
    """Either follows the other on a one-way lane: full rings do not turn here, but these can go on."""
    run = dw.simulate(dw.load(RING, TWO_HOMES))
    assert run.kpis["tasks"] == 1
    assert audit(run) == []


STREET_TO_RING = {
    **RING,
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [20, 0], "D": [20, 10]},
        "edges": [{"from": "A", "to": "B", "two_way": True}, ["B", "C"], ["C", "D"], ["D", "B"]],
        "storage": [{"node": "D"}],
        "bays": {"home": {"at": ["C", "A"], "places": 1}},
    },
    "tasks": {**RING["tasks"], "unload_at": ["A"]},
}


@pytest.mark.parametrize("ahead", [0, 1])
def test_on_a_lane_the_one_ahead_is_first_whatever_its_number(ahead):
    """The one behind turns at B and drives back; the one ahead drives on."""
    offsets, homes = [4, 2], ["C", "A"]
    if ahead == 1:
        offsets, homes = offsets[::-1], homes[::-1]
    starts = [on_edge("AB", offset) for offset in offsets]
    run = simulated(*starts, model=STREET_TO_RING, fleet__start=homes, tasks__goods=[{"good": 0, "release": 100}])
    assert run.kpis["tasks"] == 1
    assert audit(run) == []
