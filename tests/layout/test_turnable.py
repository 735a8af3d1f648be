"""What of a floor can be turned, and which designs keep all of it within reach."""

import pytest

import desim_warehouse as dw
from desim_warehouse.layout.turnable import turnable, turnable_blocks
from desim_warehouse.model.oriented import changes

RING = {
    "name": "a ring with a chord and a spur",
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [20, 0], "D": [20, 10], "E": [10, 10], "F": [0, 10], "G": [30, 10]},
        "edges": [
            ["A", "B"],
            ["B", "C"],
            ["C", "D"],
            ["D", "E"],
            ["E", "F"],
            ["F", "A"],
            {"from": "B", "to": "E", "two_way": True},
            {"from": "D", "to": "G", "two_way": True},
        ],
        "storage": [{"edge": ["A", "B"], "offset": 3}, {"edge": ["B", "E"], "offset": 4}],
        "bays": {"home": {"at": ["C"], "places": 2}},
        "stations": {"pack": {"at": ["G"]}},
    },
    "fleet": {"size": 2, "robot": {"radius": 0.3, "speed": 1, "margin": 0.1}},
    "tasks": {"goods": {"saturated": 4}, "unload_at": ["pack"], "load_time": 2, "unload_time": 2},
    "run": {"length": 3600},
}


@pytest.fixture
def model():
    return dw.load(RING)


def test_lanes_between_two_junctions_are_one_unit_and_a_spur_is_none(model):
    choices = turnable(model.floor)
    chains = {frozenset(frozenset(lane) for lane in unit) for unit in choices.units}
    sides = [["EF", "FA", "AB"], ["BC", "CD"], ["DE"], ["BE"]]
    assert chains == {frozenset(frozenset(lane) for lane in side) for side in sides}
    assert sorted(map(len, choices.ways)) == [2, 2, 2, 5]
    assert set(choices.fixed) == {("D", "G"), ("G", "D")}


def test_a_design_is_connected_or_not(model):
    choices = turnable(model.floor)
    assert choices.is_connected(choices.drawn)
    place = {frozenset(unit[0]): number for number, unit in enumerate(choices.units)}
    one = list(choices.drawn)
    one[place[frozenset("DE")]] = "back"  # D is entered by C and E, and left for nowhere
    assert not choices.is_connected(one)
    for number, ways in enumerate(choices.ways):  # turned as a whole, and the chord closed one way
        one[number] = "back" if len(ways) == 2 else "along"
    assert choices.is_connected(one)


def test_goods_of_a_turned_lane_stay_where_they_are(model):
    choices = turnable(model.floor)
    back = tuple("back" for _ in choices.units)
    turned = model.replace(changes(model, choices.lanes(back)))
    assert {("B", "A"), ("E", "B"), ("D", "C")} <= set(turned.floor.graph.edges)
    assert not {("A", "B"), ("B", "E")} & set(turned.floor.graph.edges)
    for old, new in zip(model.floor.storage, turned.floor.storage, strict=True):
        assert model.floor.position(old.edge, old.offset) == turned.floor.position(new.edge, new.offset)
    assert sorted(choices.turned(back)) == ["B>A>F>E", "D>C>B", "E>B", "E>D"]


@pytest.mark.parametrize(("way", "edges"), [("along", 1), ("back", 1), ("both", 2), ("rather along", 2)])
def test_a_two_way_lane_has_all_ways(model, way, edges):
    choices = turnable(model.floor)
    (lane,) = (unit[0] for unit, ways in zip(choices.units, choices.ways, strict=True) if len(ways) > 2)
    graph = model.replace(changes(model, {lane: way})).floor.graph
    both = [edge for edge in (lane, lane[::-1]) if edge in graph.edges]
    assert len(both) == edges
    assert [graph.edges[edge].get("counts", 1.0) for edge in both] == (
        [1.0, 2.0] if way == "rather along" else [1.0] * edges
    )


def test_rows_and_columns_of_blocks_are_turned_as_a_whole():
    model = dw.load("models/tutorial.yaml")
    choices = turnable_blocks(model.layout.blocks)
    assert len(choices.units) == 2 + 3
    assert set(turnable_blocks(model.layout.blocks).drawn) == {"along"}
    assert model.replace(changes(model, choices.lanes(choices.drawn))).floor.graph.edges == model.floor.graph.edges
    middle = next(n for n, unit in enumerate(choices.units) if unit[0] in {("B", "E"), ("E", "B")})
    design = tuple("back" if number == middle else "along" for number in range(5))
    turned = model.replace(changes(model, choices.lanes(design)))
    assert set(turned.floor.graph.edges) ^ set(model.floor.graph.edges) == {("B", "E"), ("E", "B")}


def test_a_floor_of_one_spur_has_nothing_to_turn():
    spur = {**RING, "layout": {**RING["layout"], "edges": [{"from": "A", "to": "B", "two_way": True}]}}
    spur["layout"] |= {"nodes": {"A": [0, 0], "B": [10, 0]}, "storage": [{"edge": ["A", "B"], "offset": 3}]}
    spur["layout"] |= {"bays": {"home": {"at": ["A"], "places": 2}}, "stations": {"pack": {"at": ["B"]}}}
    assert turnable(dw.load(spur).floor).units == ()
