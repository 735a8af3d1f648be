"""How far people walk, by hand, and how places are shared out among zones."""

import math

import pytest

import desim_warehouse as dw
from desim_warehouse.layout.walking import Walking, zones_of
from tests.world.test_pickers import AROUND, RING


def floor(*storage, edges=(("A", "B"), ("B", "C"), ("C", "D"), ("D", "A"))):
    layout = {**RING["layout"], "edges": [*edges], "storage": [*storage]}
    return dw.load({**RING, "layout": layout}).floor


def spots(layout):
    return [(place.edge, place.offset) for place in layout.storage]


def test_people_walk_against_the_lane_and_by_the_shorter_way():
    """From 5 on A>B to 10 on C>D: back over A and D, 5 + 10 + 10, not 15 + 10 + 10 along the lanes."""
    layout = floor(*AROUND, {"edge": ["A", "B"], "offset": 15})
    first, far, near, beside = spots(layout)
    walking = Walking(layout)
    assert walking.distance(first, beside) == walking.distance(beside, first) == 10
    assert walking.distance(first, far) == walking.distance(far, first) == 25
    assert walking.distance(first, near) == 10


def test_lane_back_is_beside_the_lane_where_both_are_alike():
    """5 from A on either is the same place in the aisle; where one is longer people go round its end."""
    there, back = {"from": "A", "to": "B", "side_by_side": True}, {"from": "B", "to": "A", "side_by_side": True}
    places = {"edge": ["A", "B"], "offset": 5}, {"edge": ["B", "A"], "offset": 15}
    layout = floor(*places, edges=(there, back, ["B", "C"], ["C", "D"], ["D", "A"]))
    assert Walking(layout).distance(*spots(layout)) == 0
    longer = floor(*places, edges=({**there, "length": 20}, {**back, "length": 25}, ["B", "C"], ["C", "D"], ["D", "A"]))
    assert Walking(longer).distance(*spots(longer)) == 5 + 10


def test_place_on_a_node_has_one_way_out():
    layout = floor({"node": "C"}, AROUND[0])
    assert Walking(layout).distance(*spots(layout)) == 15 + 10


@pytest.mark.parametrize(
    ("zones", "sizes"), [(1, [4]), (2, [2, 2]), (3, [1, 1, 2]), (4, [1, 1, 1, 1]), (9, [1, 1, 1, 1])]
)
def test_zones_are_parts_of_the_lanes_in_their_order(zones, sizes):
    layout = floor({"edge": ["A", "B"], "offset": 15}, *AROUND)
    parts = zones_of(layout, zones)
    assert [len(part) for part in parts] == sizes
    assert sum(parts, ()) == ((("A", "B"), 5.0), (("A", "B"), 15.0), (("C", "D"), 10.0), (("D", "A"), 5.0))


def test_distance_between_parts_that_are_not_joined_is_infinite():
    walking = Walking(floor(*AROUND))
    assert walking._between("A", "elsewhere") == math.inf


def test_nodes_of_a_way_are_those_passed_in_order():
    """From 5 on A>B back over A and D to 10 on C>D; none on one lane, and the node itself where a place is on it."""
    layout = floor(*AROUND, {"edge": ["A", "B"], "offset": 15}, {"node": "C"})
    first, far, near, beside, corner = spots(layout)
    walking = Walking(layout)
    assert walking.nodes(first, far) == ["A", "D"]
    assert walking.nodes(first, near) == ["A"]
    assert walking.nodes(first, beside) == []
    assert walking.nodes(corner, first) == ["C", "B"]
