"""Chains of waits, worked out by hand, and their sums on any floor."""

import math

import pytest

import desim_warehouse as dw
from desim_warehouse.outcome import chains
from desim_warehouse.outcome.chains import Root
from desim_warehouse.outcome.pieces import Piece
from desim_warehouse.outcome.records import Wait
from tests.world.test_hours import SQUARE


class Floor:
    """A history made by hand: what each robot does from second to second, and its waits."""

    def __init__(self, fleet, waits, two_way=()):
        import networkx as nx

        graph = nx.DiGraph()
        for a, b in ("AB", "BC", "CD", "DA"):
            graph.add_edge(a, b)
        for a, b in two_way:
            graph.add_edge(a, b, two_way=True)
            graph.add_edge(b, a, two_way=True)
        self.fleet = [[Piece(robot, *span) for span in spans] for robot, spans in enumerate(fleet)]
        self.waits = waits
        storage = [type("Place", (), {"edge": ("D", "A")})]
        self.layout = type("Layout", (), {"graph": graph, "two_way": list(two_way), "storage": storage})
        self.begin = 0.0

    def counts(self, time):
        return time >= self.begin


@pytest.fixture
def lost_to(monkeypatch):
    monkeypatch.setattr(chains, "pieces", lambda history: history.fleet)

    def of(floor):
        return {root: time for root, (time, _) in chains.lost_to(floor).items()}

    return of


EIGHT = (0.0, 10.0, "before_intersection", None, "B")
"""The first of three robots waits all the time, before B, for the second."""
FIRST = Wait(0, 1, 0.0, 10.0, "B", None, ("A", "B"))
SECOND = Wait(1, 2, 0.0, 8.0, None, ("B", "C"), ("B", "C"))
"""The second waits behind the third for 8 s, and drives on."""
BEHIND = [(0.0, 8.0, "behind_robot", "B>C", None), (8.0, 10.0, "loaded", "B>C", None)]


def test_a_chain_ends_at_the_station_where_the_last_is_served(lost_to):
    # the third queues for 5 s and unloads for 3 s; then the second drives, and the first waits for the crossing alone
    third = [
        (0.0, 5.0, "queueing_server", None, "R"),
        (5.0, 8.0, "unloading", None, "R"),
        (8.0, 10.0, "empty", "C>D", None),
    ]
    floor = Floor([[EIGHT], BEHIND, third], [FIRST, SECOND])
    assert lost_to(floor) == {
        Root("queueing_server", "R"): 5 + 5 + 5,
        Root("unloading", "R"): 3 + 3,
        Root("crossing", "B"): 2,
    }
    assert chains.roots(floor) == [Root("queueing_server", "R"), Root("queueing_server", "R")]


def test_a_chain_ends_at_the_charger_that_the_last_queues_for(lost_to):
    third = [(0.0, 10.0, "queueing_charger", None, "P")]
    floor = Floor([[EIGHT], BEHIND, third], [FIRST, SECOND])
    assert lost_to(floor) == {Root("queueing_charger", "P"): 8 + 8 + 10, Root("crossing", "B"): 2}


def test_a_chain_ends_at_the_closure_that_keeps_the_last_out(lost_to):
    third = [(0.0, 9.0, "waiting_closed", None, "C"), (9.0, 10.0, "loaded", "C>D", None)]
    shut = Wait(2, -1, 0.0, 9.0, "C", None, ("B", "C"), "waiting_closed", ("C", "D"))
    floor = Floor([[EIGHT], BEHIND, third], [FIRST, SECOND, shut])
    assert lost_to(floor) == {Root("waiting_closed", "C>D"): 8 + 8 + 9, Root("crossing", "B"): 2}
    assert chains.roots(floor)[2] == Root("waiting_closed", "C>D")


def test_a_chain_ends_at_the_two_way_lane_on_which_the_last_comes(lost_to):
    third = [(0.0, 6.0, "loaded", "D>C", None), (6.0, 10.0, "loading", "C>D", None)]
    floor = Floor([[EIGHT], BEHIND, third], [FIRST, SECOND], two_way=[("C", "D")])
    assert lost_to(floor) == {Root("two_way_lane", "C-D"): 6 + 6, Root("loading", "D"): 2 + 2, Root("crossing", "B"): 2}


def test_a_chain_ends_at_the_lane_beside_which_the_last_loads_not_at_the_station_ahead(lost_to):
    third = [
        (0.0, 6.0, "loading", "D>A", None),
        (6.0, 8.0, "unloading", "D>A", None),
        (8.0, 10.0, "empty", "A>B", None),
    ]
    floor = Floor([[EIGHT], BEHIND, third], [FIRST, SECOND])
    lost = lost_to(floor)
    assert (lost[Root("loading", "D>A")], lost[Root("unloading", "A")]) == (6 + 6, 2 + 2)


def test_robots_that_wait_for_each_other_are_a_ring_until_one_moves(lost_to):
    fleet = [[EIGHT], [(0.0, 4.0, "before_intersection", None, "C"), (4.0, 10.0, "empty", "C>D", None)]]
    floor = Floor(fleet, [FIRST, Wait(1, 0, 0.0, 4.0, "C", None, ("B", "C"))])
    assert lost_to(floor) == {Root("ring", "C"): 4, Root("ring", "B"): 4, Root("crossing", "B"): 6}


def test_only_counted_time_is_lost(lost_to):
    first = [(0.0, 4.0, *EIGHT[2:]), (4.0, 10.0, *EIGHT[2:])]
    second = [(0.0, 4.0, *BEHIND[0][2:]), (4.0, 8.0, *BEHIND[0][2:]), BEHIND[1]]
    floor = Floor([first, second, [(0.0, 10.0, "charging", None, "P")]], [FIRST, SECOND])
    floor.begin = 4.0
    assert lost_to(floor) == {Root("charging", "P"): 4 + 4, Root("crossing", "B"): 2}


CLOSED = {
    "calendars": {"wash": {"every": 900, "lasts": 200}},
    "traffic.closures": {"gate": {"members": [["A", "B"]], "hours": "wash"}},
    "tasks.goods": {"poisson": 60},
    "run.length": 7200,
}


@pytest.mark.parametrize(
    ("file", "changes"),
    [
        ("models/tutorial.yaml", {}),
        ("models/multibots.yaml", {"tasks.goods": {"saturated": 20}, "run": {"length": 4000, "warm_up": 500}}),
        (SQUARE, CLOSED),
        ("tests/golden/models/two_way_zones.yaml", {}),
    ],
)
def test_the_sums_over_roots_are_all_waiting(file, changes):
    run = dw.simulate(dw.load(file, {**changes, "log": "all"}), seed=3)
    table = run.account("robot")
    waits = [part for part in table if part in {*chains.TRAFFIC, *chains.QUEUES} or part.startswith("waiting_")]
    assert math.fsum(run.lost_time["time"]) == pytest.approx(math.fsum(table[waits].to_numpy().ravel()), abs=1e-9)
    assert run.lost_time["time"].is_monotonic_decreasing
    assert run.waits["root"].notna().all()
    assert (run.waits["root_at"] != "").all()
