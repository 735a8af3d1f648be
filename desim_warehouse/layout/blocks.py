"""The block generator: blocks of goods with one-way aisles around each (the paper's section II)."""

from __future__ import annotations

import math
from itertools import pairwise, product
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator

from desim_warehouse.layout.layout import StoragePlace
from desim_warehouse.layout.naming import block_nodes
from desim_warehouse.values.fields import (
    SECTION,
    Count,
    Forms,
    Length,
    Part,
    Usual,
    at_most,
    by_type,
    form,
    known,
    wrong,
)

if TYPE_CHECKING:
    import networkx as nx


Rule = Literal["alternating", "ring", "two-way"]
_LINES = Forms("'ring', 'alternating', 'two-way', or a list of directions", pick=by_type(rule=str, list=(list, tuple)))


class Directions(Part):
    """Directions of the rows and columns of aisles: by a rule, or listed one by one."""

    rows: Annotated[
        Annotated[Rule, form("rule")] | Annotated[tuple[Literal["east", "west", "two-way"], ...], form("list")], _LINES
    ] = Field(description="a rule, or one for each row of nodes, top first: east, west or two-way")
    columns: Annotated[
        Annotated[Rule, form("rule")] | Annotated[tuple[Literal["north", "south", "two-way"], ...], form("list")],
        _LINES,
    ] = Field(description="a rule, or one for each column of nodes, left first: north, south or two-way")


class Blocks(Part):
    """Blocks of goods with one-way aisles around each: nodes where aisles cross, edges between neighbours."""

    columns: Count = Field(description="blocks side by side")
    rows: Count = Field(description="blocks one below the other")
    floors: Annotated[Count, Usual(1, 20)] = Field(
        1,
        title="floors of blocks",
        validate_default=True,
        description="floors with such blocks, one above the other and drawn side by side; `layout.lifts` join them",
    )
    block_width: Annotated[int, Field(strict=True, ge=1, le=2)] = Field(2, description="goods across a block: 1 or 2")
    block_depth: Count = Field(description="goods in a block's depth")
    goods_size: Annotated[Length, Usual("10 cm", "10 m")] = Field(description="side of a good's square")
    aisle_width: Annotated[Length, Usual("20 cm", "20 m")] = Field(description="width of the aisles (columns)")
    cross_aisle_width: Annotated[Length | None, Usual("20 cm", "50 m")] = Field(
        None, description="width of the rows; default: aisle_width"
    )
    directions: Annotated[
        Annotated[Rule, form("rule")] | Annotated[Directions, form("hand")],
        Forms(
            "'ring', 'alternating', 'two-way', or a section with rows and columns", pick=by_type(rule=str, hand=SECTION)
        ),
    ] = Field(
        "ring",
        description="ring: outer aisles clockwise, inner ones alternating; alternating; two-way: one lane for both "
        "directions; or rows and columns separately, each by a rule or a list",
    )

    @property
    def two_way(self) -> bool:
        """Whether any of the aisles is one lane for both directions."""
        chosen = self.directions
        lines = (chosen.rows, chosen.columns) if isinstance(chosen, Directions) else (chosen,)
        return any("two-way" in line for line in lines)

    @property
    def nodes(self) -> int:
        """The number of nodes on all floors."""
        return self.floors * (self.columns + 1) * (self.rows + 1)

    @property
    def places(self) -> int:
        """The number of storage places on all floors."""
        return self.floors * self.columns * self.rows * self.block_width * self.block_depth

    @field_validator("floors")
    @classmethod
    def _names(cls, floors: int, info: ValidationInfo) -> int:
        if {"columns", "rows"} <= info.data.keys():
            columns, rows = info.data["columns"], info.data["rows"]
            at_most("nodes", floors * (columns + 1) * (rows + 1))
            known(info).nodes = {
                name: (floor * (columns + 2) + c, r)
                for floor in range(floors)
                for r, row in enumerate(block_nodes(columns, rows, floor))
                for c, name in enumerate(row)
            }
        return floors

    @field_validator("block_depth")
    @classmethod
    def _places(cls, depth: int, info: ValidationInfo) -> int:
        data = info.data
        if {"columns", "rows", "floors", "block_width"} <= data.keys():
            places = data["floors"] * data["columns"] * data["rows"] * data["block_width"] * depth
            at_most("places", places)
            known(info).places = places
        return depth

    @field_validator("directions")
    @classmethod
    def _one_each(cls, directions: str | Directions, info: ValidationInfo) -> str | Directions:
        if isinstance(directions, Directions) and {"columns", "rows"} <= info.data.keys():
            nodes = info.data["rows"] + 1, info.data["columns"] + 1
            listed = zip((directions.rows, directions.columns), nodes, strict=True)
            numbers = tuple(number if isinstance(lines, str) else len(lines) for lines, number in listed)
            if numbers != nodes:
                text = "{} rows and {} columns given for {} rows and {} columns of nodes".format(*numbers, *nodes)
                raise wrong(f"{text}, expected one for each: blocks and one more")
        return directions


def directions(blocks: Blocks) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the direction of every row (top first) and every column (left first): east, west, north, south or two-way.

    `alternating`: east, west, east, ... and north, south, north, ...
    `ring`: the outer aisles run clockwise round the warehouse: top row east, right column south, bottom row west, left
    column north. Inner rows alternate from the bottom up, inner columns from the left. So the Highways are strongly
    connected, however many rows and columns they have.
    `two-way`: every aisle is one lane for both directions.
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
    """Return the Highways between the blocks; each node's successor in its row precedes the successor in its column.

    Floors are drawn from west to east, with room for two blocks between them.
    """
    cross = blocks.cross_aisle_width or blocks.aisle_width
    dx = blocks.block_width * blocks.goods_size + blocks.aisle_width
    dy = blocks.block_depth * blocks.goods_size + cross
    rows, columns = directions(blocks)
    import networkx as nx

    graph = nx.DiGraph()
    for floor in range(blocks.floors):
        names, west = block_nodes(blocks.columns, blocks.rows, floor), floor * (blocks.columns + 3)
        for r, row in enumerate(names):
            for c, name in enumerate(row):
                graph.add_node(name, x=blocks.aisle_width / 2 + (west + c) * dx, y=cross / 2 + r * dy)
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
    """Return all storage places, numbered floor by floor, block by block, and row by row within a block.

    Blocks are numbered down each column of blocks. A good in the left half of its block is picked from the aisle on the
    left, a good in the right half from the aisle on the right, at the height of its own centre. A block that is one
    good wide is picked from its left.
    """
    cross = blocks.cross_aisle_width or blocks.aisle_width
    places: list[StoragePlace] = []
    for floor, column in product(range(blocks.floors), range(blocks.columns)):
        names = block_nodes(blocks.columns, blocks.rows, floor)
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
