"""The block generator: blocks of goods with one-way aisles around each (the paper's section II)."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

from desim_warehouse.layout.layout import StoragePlace
from desim_warehouse.layout.naming import block_nodes
from desim_warehouse.layout.spec import Blocks, Directions

if TYPE_CHECKING:
    import networkx as nx


def directions(blocks: Blocks) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """How every row (top first) and every column (left first) is driven: east, west, north, south or two-way.

    `alternating`: east, west, east, ... and north, south, north, ...
    `ring`: the outer aisles run clockwise round the warehouse: top row east, right column south, bottom row west, left
    column north. Inner rows alternate from the bottom up, inner columns from the left. So every size is strongly
    connected.
    `two-way`: all of them are one lane for both directions.
    """
    high, wide = blocks.rows + 1, blocks.columns + 1
    by_rule = {
        "alternating": (("west" if r % 2 else "east" for r in range(high)), _columns(wide)),
        "ring": (
            ["east", *("west" if (high - 1 - r) % 2 == 0 else "east" for r in range(1, high))],
            [*_columns(wide)[:-1], "south"],
        ),
        "two-way": (["two-way"] * high, ["two-way"] * wide),
    }
    chosen = blocks.directions
    rows, columns = (chosen.rows, chosen.columns) if isinstance(chosen, Directions) else (chosen, chosen)
    return (
        tuple(by_rule[rows][0] if isinstance(rows, str) else rows),
        tuple(by_rule[columns][1] if isinstance(columns, str) else columns),
    )


def _columns(wide: int) -> list[str]:
    return ["south" if c % 2 else "north" for c in range(wide)]


def highways(blocks: Blocks) -> nx.DiGraph:
    """The Highways between the blocks; at every node the row's successor comes before the column's."""
    names = block_nodes(blocks.columns, blocks.rows)
    cross = blocks.cross_aisle_width or blocks.aisle_width
    dx = blocks.block_width * blocks.goods_size + blocks.aisle_width
    dy = blocks.block_depth * blocks.goods_size + cross
    rows, columns = directions(blocks)
    import networkx as nx

    graph = nx.DiGraph()
    for r, row in enumerate(names):
        for c, name in enumerate(row):
            graph.add_node(name, x=blocks.aisle_width / 2 + c * dx, y=cross / 2 + r * dy)
    for row, along in zip(names, rows, strict=True):
        _chain(graph, row[::-1] if along == "west" else row, dx, two_way=along == "two-way")
    for column, down in zip(zip(*names, strict=True), columns, strict=True):
        _chain(graph, column[::-1] if down == "north" else column, dy, two_way=down == "two-way")
    return graph


def _chain(graph: nx.DiGraph, names: tuple[str, ...], length: float, *, two_way: bool) -> None:
    for source, target in pairwise(names):
        for edge in ((source, target), (target, source))[: 1 + two_way]:
            graph.add_edge(*edge, length=float(length), speed=math.inf)


def storage(blocks: Blocks, graph: nx.DiGraph) -> tuple[StoragePlace, ...]:
    """All goods, numbered block by block (down a block column, then the next), in a block row by row.

    A good on the left of its block is picked from the aisle on that side, one on the right from the aisle on the
    right, at the height of its own centre. A block one good wide is picked from its left.
    """
    names = block_nodes(blocks.columns, blocks.rows)
    cross = blocks.cross_aisle_width or blocks.aisle_width
    places: list[StoragePlace] = []
    for column in range(blocks.columns):
        for row in range(blocks.rows):
            aisles = []
            for side in range(blocks.block_width):
                upper, lower = names[row][column + side], names[row + 1][column + side]
                top, away = graph.nodes[upper], (0.5 - side) * blocks.goods_size + (0.5 - side) * blocks.aisle_width
                length = graph.nodes[lower]["y"] - top["y"]
                aisles.append((upper, lower, graph.has_edge(upper, lower), length, top["x"] + away, top["y"]))
            for deep in range(blocks.block_depth):
                down = cross / 2 + (deep + 0.5) * blocks.goods_size
                for upper, lower, leads_down, length, x, y in aisles:
                    edge, offset = ((upper, lower), down) if leads_down else ((lower, upper), length - down)
                    places.append(StoragePlace(len(places), edge, offset, x, y + down))
    return tuple(places)
