"""Lanes shorter than D or 2 D: what is checked is what robots drive on, to the last digit."""

import pytest

import desim_warehouse as dw
from desim_warehouse.layout.short import exact_length, is_short, joins, waited_for
from desim_warehouse.layout.zones import edges_inside, intersections
from desim_warehouse.world import World

D = 1.0


@pytest.mark.parametrize(
    ("length", "exact", "short", "joined"),
    [
        (0.5, 0.5, True, True),
        (0.9999995, 1.0, True, False),
        (1.0000005, 1.0, True, False),
        (1.5, 1.5, True, False),
        (1.9999995, 2.0, False, False),
        (2.5, 2.5, False, False),
    ],
)
def test_lengths_within_the_tolerance_of_a_limit_have_reached_it(length, exact, short, joined):
    assert (exact_length(length, D), is_short(length, D), joins(length, D)) == (exact, short, joined)
    assert waited_for(length, D) is (short and not joined)


@pytest.mark.parametrize("length", [0.5, 0.9999989, 0.999999, 0.9999991, 1.0, 1.999999, 2.0])
def test_the_edges_that_checks_call_inside_are_those_on_which_robots_cannot_wait(length):
    """0.999999 is 1 less the tolerance but for rounding: a closed lane there was neither refused nor kept closed."""
    ring = {"A": "B", "B": "C", "C": "D", "D": "A"}
    edges = [{"from": a, "to": b, "length": length if a == "B" else 10} for a, b in ring.items()]
    model = dw.load(
        {
            "layout": {
                "nodes": {"A": [0, 0], "B": [10, 0], "C": [10, 1], "D": [0, 10]},
                "edges": edges,
                "storage": [{"edge": ["D", "A"], "offset": 5}],
                "bays": {"home": {"at": ["A"]}},
            },
            "fleet": {"size": 1, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1}},
            "tasks": {"goods": [0], "unload_at": ["D"], "load_time": 0, "unload_time": 0},
        }
    )
    traffic = World(model, 0).traffic
    assert edges_inside(model.floor, D, ()) == {edge for edge, lane in traffic.lanes.items() if lane.inside}
    nodes = {name: tuple(node.nodes) for name, node in traffic.nodes.items()}
    assert intersections(model.floor, D, ()) == nodes
