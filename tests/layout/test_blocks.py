"""The block generator: names, positions, one-way rules and the goods of every proportion of warehouse."""

import math
from itertools import product

import networkx as nx
import pytest

from desim_warehouse.layout import build
from desim_warehouse.layout.spec import LayoutSpec

SIZES = list(product(range(1, 6), range(1, 5)))


def blocks(columns, rows, **more):
    section = {"columns": columns, "rows": rows, "block_depth": 3, "goods_size": 2, "aisle_width": 4, **more}
    return build(LayoutSpec.model_validate({"blocks": section}))


def edges(layout):
    return {f"{a}{b}" for a, b in layout.graph.edges}


def test_nodes_are_letters_row_by_row_at_the_crossings_of_the_aisles():
    layout = blocks(2, 1)
    # from column to column two goods of 2 and an aisle of 4: 8; from row to row three goods and an aisle: 10
    assert {name: (data["x"], data["y"]) for name, data in layout.graph.nodes(data=True)} == {
        "A": (2, 2),
        "B": (10, 2),
        "C": (18, 2),
        "D": (2, 12),
        "E": (10, 12),
        "F": (18, 12),
    }
    assert {data["length"] for *_, data in layout.graph.edges(data=True)} == {8, 10}
    assert {data["speed"] for *_, data in layout.graph.edges(data=True)} == {math.inf}


def test_where_letters_run_out_nodes_are_named_by_row_and_column():
    # 5 x 5 nodes are 25 letters; 6 x 5 are 30
    assert list(blocks(4, 4).graph)[-1] == "Y"
    names = list(blocks(5, 4).graph)
    assert (names[0], names[5], names[6], names[-1]) == ("r0c0", "r0c5", "r1c0", "r4c5")


def test_cross_aisles_may_have_another_width():
    layout = blocks(1, 2, cross_aisle_width=6)
    # rows are 3 goods of 2 and 6 apart: 12, the first at 6 / 2; columns as before
    assert [(data["x"], data["y"]) for _, data in layout.graph.nodes(data=True)] == [
        (2, 3),
        (10, 3),
        (2, 15),
        (10, 15),
        (2, 27),
        (10, 27),
    ]
    # the first good is 1 below the edge of its block, 3 + 1 below the node
    assert layout.storage[0].y == 3 + 3 + 1


def test_the_ring_rule_runs_clockwise_round_the_warehouse():
    # A B C over D E F: top row east, bottom row west, left column north, right column south, the middle one south
    assert edges(blocks(2, 1)) == {"AB", "BC", "FE", "ED", "DA", "BE", "CF"}
    # A B C, D E F, G H I: the middle row east
    assert edges(blocks(2, 2)) == {"AB", "BC", "DE", "EF", "IH", "HG", "GD", "DA", "BE", "EH", "CF", "FI"}


def test_rows_and_columns_alternate_by_the_alternating_rule():
    # rows east, west, east; columns north, south, north
    assert edges(blocks(2, 2, directions="alternating")) == {
        *("AB", "BC", "FE", "ED", "GH", "HI"),
        *("GD", "DA", "BE", "EH", "IF", "FC"),
    }


def test_directions_may_be_listed():
    rule = {"rows": ["west", "east"], "columns": ["south", "north", "north"]}
    assert edges(blocks(2, 1, directions=rule)) == {"CB", "BA", "DE", "EF", "AD", "EB", "FC"}


@pytest.mark.parametrize(("columns", "rows"), SIZES)
def test_every_size_is_strongly_connected_by_the_ring_rule(columns, rows):
    graph = blocks(columns, rows).graph
    assert len(graph) == (columns + 1) * (rows + 1)
    assert graph.number_of_edges() == columns * (rows + 1) + rows * (columns + 1)
    assert nx.is_strongly_connected(graph)


def test_at_every_node_the_way_along_the_row_comes_first():
    graph = blocks(4, 3).graph
    for node in graph:
        along = [graph.nodes[node]["y"] == graph.nodes[other]["y"] for other in graph.successors(node)]
        assert along == sorted(along, reverse=True)


@pytest.mark.parametrize(("columns", "rows"), SIZES)
@pytest.mark.parametrize("width", [1, 2])
@pytest.mark.parametrize("rule", ["ring", "alternating"])
def test_goods_lie_beside_the_point_where_they_are_picked(columns, rows, width, rule):
    layout = blocks(columns, rows, block_width=width, directions=rule)
    assert len(layout.storage) == columns * rows * width * 3
    centres = set()
    for number, place in enumerate(layout.storage):
        x, y = layout.position(place.edge, place.offset)
        # picked at the height of the good's centre, half an aisle and half a good away from the middle of the aisle
        assert place.number == number
        assert (abs(place.x - x), place.y) == (pytest.approx(3), pytest.approx(y))
        assert 0 < place.offset < layout.graph.edges[place.edge]["length"]
        centres.add((place.x, place.y))
    assert len(centres) == len(layout.storage)


def test_goods_are_numbered_down_the_columns_and_left_to_right_in_a_block():
    layout = blocks(2, 2)
    numbers = {(place.x, place.y): place.number for place in layout.storage}
    # the first block: from x = 4 to 8 and y = 4 to 10; the one below it begins 10 farther down, the next column 8 right
    assert [numbers[x, y] for y in (5, 7, 9) for x in (5, 7)] == [0, 1, 2, 3, 4, 5]
    assert numbers[5, 15] == 6
    assert numbers[13, 5] == 12
    assert numbers[15, 19] == 23


def test_a_block_one_good_wide_is_picked_from_its_left():
    layout = blocks(1, 1, block_width=1)
    assert {place.edge for place in layout.storage} == {("C", "A")}
    # the aisle runs up; the first good's centre is 2 + 1 below A, 10 - 3 above C
    assert [place.offset for place in layout.storage] == [7, 5, 3]
