"""What must fit together within the layout section: known nodes, edges once, places within their edge."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.layout.naming import block_nodes
from desim_warehouse.layout.spec import Directions
from desim_warehouse.model.outline import nearest, spoken
from desim_warehouse.model.problems import Problem, got

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from desim_warehouse.layout.spec import Edge, LayoutSpec
    from desim_warehouse.model.places import Keys
    from desim_warehouse.model.schema import Model

_SHOWN = 12  # node names in a message
_COMPARED = 1000  # node names in which one like another is looked for


def node_names(layout: LayoutSpec) -> tuple[str, ...]:
    """The names of all nodes, in order."""
    if layout.blocks is None:
        return tuple(layout.nodes)
    return tuple(name for row in block_nodes(layout.blocks.columns, layout.blocks.rows) for name in row)


def storage_places(layout: LayoutSpec) -> int:
    """How many storage places the layout has."""
    blocks = layout.blocks
    if blocks is None:
        return len(layout.storage)
    return blocks.columns * blocks.rows * blocks.block_width * blocks.block_depth


def node_problems(layout: LayoutSpec, keys: Keys, named: Iterable[str]) -> Iterator[Problem]:
    """The names in a list that no node has."""
    known: dict[str, None] | None = None
    for rank, name in enumerate(named):
        known = dict.fromkeys(node_names(layout)) if known is None else known
        if known and name not in known:
            yield Problem.of((*keys, rank), "no such node", name, _a_node(name, tuple(known)))


def _a_node(name: str, names: tuple[str, ...]) -> str:
    if len(names) <= _SHOWN:
        said = f"one of {spoken(names, 'or')}"
    else:
        said = f"one of the {len(names)} nodes, {names[0]} to {names[-1]}"
    near = nearest(name, names) if len(names) <= _COMPARED else None
    return f"{said}; did you mean '{near}'?" if near else said


def _kind(model: Model) -> Iterator[Problem]:
    layout = model.layout
    if layout.blocks is None:
        if not layout.nodes:
            yield Problem(("layout",), "neither blocks nor nodes, expected one of the two")
            return
        for key in ("edges", "storage"):
            if not getattr(layout, key):
                yield Problem(("layout", key), f"a layout of nodes without {key}, expected at least one entry")
        return
    for key in ("nodes", "edges", "storage"):
        if getattr(layout, key):
            wrong = f"blocks make their own {key}, expected either blocks, or nodes with edges and storage"
            yield Problem(("layout", key), wrong, at_key=True)


def _directions(model: Model) -> Iterator[Problem]:
    blocks = model.layout.blocks
    if blocks is None or not isinstance(blocks.directions, Directions):
        return
    for key in ("rows", "columns"):
        given, wanted = len(getattr(blocks.directions, key)), getattr(blocks, key) + 1
        if given != wanted:
            yield Problem(
                ("layout", "blocks", "directions", key),
                f"{given} given for {wanted} {key} of nodes, expected one for each: blocks and one more",
            )


def _same_place(model: Model) -> Iterator[Problem]:
    seen: dict[tuple[float, float], str] = {}
    for name, at in model.layout.nodes.items():
        first = seen.setdefault(at, name)
        if first != name:
            wrong = f"at the same place as node '{first}'"
            yield Problem.of(("layout", "nodes", name), wrong, list(at), "a place of its own")


def _edges(model: Model) -> Iterator[Problem]:
    layout = model.layout
    if layout.blocks is not None or not layout.nodes:
        return
    seen: dict[tuple[str, str], int] = {}
    for rank, edge in enumerate(layout.edges):
        keys: Keys = ("layout", "edges", rank)
        unknown = False
        for place, name in (("from", edge.source), ("to", edge.target)):
            if name not in layout.nodes:
                unknown = True
                expected = _a_node(name, tuple(layout.nodes))
                yield Problem.of((*keys, place), "no such node", name, expected)
        if unknown:
            continue
        way = (edge.source, edge.target)
        if edge.source == edge.target:
            yield Problem.of(keys, "from a node to itself", list(way), "two nodes")
        elif way in seen:
            expected = "every edge once"
            yield Problem.of(keys, f"the same edge as entry {seen[way]}", list(way), expected)
        seen.setdefault(way, rank)


def _storage(model: Model) -> Iterator[Problem]:
    layout = model.layout
    if layout.blocks is not None or not layout.edges:
        return
    edges = {(edge.source, edge.target): edge for edge in layout.edges}
    for rank, place in enumerate(layout.storage):
        keys: Keys = ("layout", "storage", rank)
        if place.edge not in edges:
            turned = place.edge[::-1] in edges
            expected = f"an edge of the layout{', such as the one the other way' if turned else ''}"
            yield Problem.of((*keys, "edge"), "no such edge", list(place.edge), expected)
            continue
        length = _length(layout, edges[place.edge])
        if length is not None and place.offset >= length:
            expected = f"an offset below the edge's length, {got(length)}"
            yield Problem.of((*keys, "offset"), "beyond the end of its edge", place.offset, expected)


def _length(layout: LayoutSpec, edge: Edge) -> float | None:
    if edge.length is not None:
        return edge.length
    if edge.source in layout.nodes and edge.target in layout.nodes:
        return math.dist(layout.nodes[edge.source], layout.nodes[edge.target])
    return None


def _bays(model: Model) -> Iterator[Problem]:
    for name, bay in model.layout.bays.items():
        if bay.places is not None and bay.chargers is not None and bay.chargers > bay.places:
            expected = f"at most one for each of the {bay.places} places"
            yield Problem.of(("layout", "bays", name, "chargers"), "too many", bay.chargers, expected)
        if bay.chargers is not None and bay.total_chargers is not None:
            keys: Keys = ("layout", "bays", name, "total_chargers")
            yield Problem.of(keys, "both this and chargers", bay.total_chargers, "one of the two (chargers: a node)")
    for name, station in model.layout.stations.items():
        if station.servers > station.places:
            expected = f"at most one for each of the {station.places} places"
            yield Problem.of(("layout", "stations", name, "servers"), "too many", station.servers, expected)


def _where(model: Model) -> Iterator[Problem]:
    for group in ("bays", "stations"):
        for name, places in getattr(model.layout, group).items():
            keys: Keys = ("layout", group, name)
            if not places.at and places.along is None:
                yield Problem(keys, "at no node, expected at (a list of nodes) or along (a side)")
            if places.every > 1 and places.along is None:
                expected = "along (a side) beside it"
                yield Problem.of((*keys, "every"), "every n-th node of no side", places.every, expected)
            yield from node_problems(model.layout, (*keys, "at"), places.at)


NODES = ("layout.blocks.columns", "layout.blocks.rows", "layout.nodes")
STORAGE_PLACES = (
    "layout.blocks.columns",
    "layout.blocks.rows",
    "layout.blocks.block_width",
    "layout.blocks.block_depth",
    "layout.storage",
)
CHECKS: tuple[tuple[Callable[[Model], Iterator[Problem]], tuple[str, ...]], ...] = (
    (_kind, ("layout.blocks", "layout.nodes", "layout.edges", "layout.storage")),
    (_directions, ("layout.blocks.columns", "layout.blocks.rows", "layout.blocks.directions")),
    (_same_place, ("layout.nodes",)),
    (_edges, ("layout.nodes", "layout.edges", "layout.blocks.columns")),
    (_storage, ("layout.storage", "layout.edges", "layout.nodes")),
    (_bays, ("layout.bays", "layout.stations")),
    (_where, ("layout.bays", "layout.stations", *NODES)),
)
"""Every check of the layout section with the keys it needs to be right."""
