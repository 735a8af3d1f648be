"""Blocks whose rows and columns of aisles are two-way, and edges beside blocks: the same as a floor drawn by hand."""

from itertools import pairwise

import pytest

import desim_warehouse as dw
from desim_warehouse.layout.naming import block_nodes
from desim_warehouse.study.designs.directions import Floor

BLOCKS = {"columns": 3, "rows": 2, "block_depth": 3, "goods_size": 2, "aisle_width": 4}
MODEL = {
    "layout": {
        "blocks": BLOCKS,
        "bays": {"rest": {"along": "north", "total_chargers": 3, "grows": True}},
        "stations": {"pack": {"along": "south", "every": 2}},
    },
    "fleet": {"size": 3, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1}},
    "tasks": {
        "goods": {"poisson": 60},
        "unload_at": ["pack"],
        "station_choice": "nearest",
        "load_time": 10,
        "unload_time": 20,
    },
    "battery": {"capacity": 100, "threshold": 30, "consumption": 0.02, "charge_rate": 0.1},
    "policies": {"allocation": "nearest"},
    "run": {"length": 7200},
}


def edges(model):
    return {f"{a}{b}" for a, b in model.floor.graph.edges}


def by_hand(model, lines):
    """The floor of a model of blocks drawn by hand: its nodes, its places, and `lines` of nodes with their rules."""
    graph = model.floor.graph
    drawn = [
        {"from": a, "to": b, "length": length, "two_way": rule == "two-way"}
        for line, rule, length in lines
        for a, b in pairwise(line[::-1] if rule in {"west", "north"} else line)
    ]
    storage = [{"edge": list(place.edge), "offset": place.offset} for place in model.floor.storage]
    nodes = {name: [data["x"], data["y"]] for name, data in graph.nodes(data=True)}
    layout = {**MODEL["layout"], "nodes": nodes, "edges": drawn, "storage": storage}
    return dw.load({**MODEL, "layout": {key: part for key, part in layout.items() if key != "blocks"}})


@pytest.mark.parametrize(
    ("rows", "columns"),
    [
        (["two-way"] * 3, ["two-way"] * 4),
        (["east", "two-way", "west"], ["north", "south", "north", "south"]),
        (["east", "west", "west"], ["two-way"] * 4),
    ],
    ids=["all two-way", "the main cross aisle two-way", "columns two-way"],
)
def test_two_way_blocks_are_the_same_floor_drawn_by_hand_log_for_log(rows, columns):
    model = dw.load(MODEL, {"layout.blocks.directions": {"rows": rows, "columns": columns}})
    names = block_nodes(3, 2)
    lines = [
        *((row, rule, 8.0) for row, rule in zip(names, rows, strict=True)),
        *((column, rule, 10.0) for column, rule in zip(zip(*names, strict=True), columns, strict=True)),
    ]
    drawn = by_hand(model, lines)

    ours, theirs = dw.simulate(model, 1).log, dw.simulate(drawn, 1).log

    assert len(ours) > 1000
    assert ours.equals(theirs)


def test_a_rule_in_a_word_is_the_list_that_it_stands_for():
    ring = dw.load(MODEL)
    columns = dw.load(MODEL, {"layout.blocks.directions.columns": "two-way"})
    listed = {"rows": ["east", "east", "west"], "columns": ["two-way"] * 4}

    assert edges(columns) == edges(dw.load(MODEL, {"layout.blocks.directions": listed}))
    assert columns.layout.blocks.directions.rows == "ring"  # one --set leaves the rows as they were
    assert edges(ring) == edges(dw.load(MODEL, {"layout.blocks.directions": {"rows": "ring", "columns": "ring"}}))
    assert edges(dw.load(MODEL, {"layout.blocks.directions": "two-way"})) == {
        *edges(ring),
        *(f"{b}{a}" for a, b in edges(ring)),
    }


def test_two_way_blocks_can_be_turned():
    both = dw.load(MODEL, {"layout.blocks.directions": {"rows": "ring", "columns": "two-way"}})

    assert both.layout.two_way
    assert not dw.load(MODEL).layout.two_way
    floor = Floor(both)
    one_way = floor.changes(("along",) * 7)
    assert "both" in floor.drawn
    assert not both.replace(one_way).layout.two_way
    with pytest.raises(dw.ModelError, match="lead one way from end to end, expected a search"):
        dw.orient(both)


def test_edges_beside_blocks_are_added_to_their_aisles():
    # E to B leads back along the aisle B>E or E>B of the ring, so it is one lane for both directions with it
    back = next((b, a) for a, b in dw.load(MODEL).floor.graph.edges if {a, b} == {"B", "F"})
    short_cut = dw.load(MODEL, {"layout.edges": [["A", "F"], list(back)]})
    graph = short_cut.floor.graph

    assert edges(short_cut) - edges(dw.load(MODEL)) == {"AF", "".join(back)}
    assert graph.edges["A", "F"]["length"] == pytest.approx((8**2 + 10**2) ** 0.5)
    assert graph.edges[back]["two_way"]
    assert short_cut.layout.two_way
    beside = {"from": back[0], "to": back[1], "side_by_side": True}
    assert not dw.load(MODEL, {"layout.edges": [["A", "F"], beside]}).layout.two_way


def test_other_sections_may_name_the_aisles_of_blocks_that_have_edges_beside_them():
    calendar = {"calendars": {"noon": {"every": 3600, "lasts": 600}}}
    closed = {"traffic.closures": {"works": {"members": [["A", "B"]], "hours": "noon"}}}

    assert dw.load(MODEL, {"layout.edges": [["A", "F"]], **calendar, **closed})
    with pytest.raises(dw.ModelError, match="the same edge as one before"):
        dw.load(MODEL, {"layout.edges": [["A", "B"]]})
