"""Lanes of a floor that can be turned, grouped in units between junctions and in aisles."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, TypeAlias

from desim_warehouse.layout.blocks import Blocks, highways
from desim_warehouse.layout.layout import Edge, Layout
from desim_warehouse.layout.naming import block_nodes
from desim_warehouse.layout.orient import Aisles

if TYPE_CHECKING:
    from random import Random

    import networkx as nx


Way: TypeAlias = Literal["along", "back", "both", "rather along", "rather back"]
"""The direction of a lane: as listed, opposite, both ways, or both with a preferred direction."""
AGAINST = 2.0
"""Factor on the length of a lane in the choice of routes, if it is driven against its preferred direction."""
_MIRRORED: Mapping[Way, Way] = {
    "along": "back",
    "back": "along",
    "both": "both",
    "rather along": "rather back",
    "rather back": "rather along",
}


def mirrored(way: Way) -> Way:
    """Return the direction of a lane as seen from its other end."""
    return _MIRRORED[way]


@dataclass(frozen=True)
class Turnable:
    """Units of a floor whose direction can be changed, each alone or together with its aisle.

    A unit is a chain of lanes without a junction between them. `ways`: the possible directions of each unit, its
    present one first. `aisles`: the units of each aisle, each with its direction that leads along the aisle. `fixed`:
    the edges that cannot be turned.
    """

    units: tuple[tuple[Edge, ...], ...]
    ways: tuple[tuple[Way, ...], ...]
    aisles: tuple[tuple[tuple[int, Way], ...], ...]
    fixed: tuple[Edge, ...]
    nodes: tuple[str, ...]

    @property
    def drawn(self) -> tuple[Way, ...]:
        """The directions of the units as drawn."""
        return tuple(ways[0] for ways in self.ways)

    def is_connected(self, design: Sequence[Way]) -> bool:
        """Return whether every node can still be reached from every other."""
        import networkx as nx

        graph = nx.DiGraph(self.fixed)
        graph.add_nodes_from(self.nodes)
        for lanes, way in zip(self.units, design, strict=True):
            if way != "back":
                graph.add_edges_from(lanes)
            if way != "along":
                graph.add_edges_from(lane[::-1] for lane in lanes)
        return bool(nx.is_strongly_connected(graph))

    def neighbours(self, design: tuple[Way, ...]) -> Iterator[tuple[Way, ...]]:
        """Yield the designs that differ in the direction of one aisle, then those that differ in one unit."""
        seen = {design}
        for aisle in self.aisles:
            for way in dict.fromkeys(way for unit, _ in aisle for way in self.ways[unit]):
                yield from _new(self._with(design, aisle, way), seen)
        for unit, ways in enumerate(self.ways):
            for way in ways:
                yield from _new((*design[:unit], way, *design[unit + 1 :]), seen)

    def step(self, design: tuple[Way, ...], random: Random) -> tuple[Way, ...]:
        """Return a design in which a random aisle or unit has a random direction, possibly its own."""
        number = random.randrange(len(self.aisles) + len(self.units))
        if number < len(self.aisles):
            aisle = self.aisles[number]
            return self._with(design, aisle, random.choice(self.ways[aisle[0][0]]))
        unit = number - len(self.aisles)
        return (*design[:unit], random.choice(self.ways[unit]), *design[unit + 1 :])

    def _with(self, design: Sequence[Way], aisle: Iterable[tuple[int, Way]], way: Way) -> tuple[Way, ...]:
        """Return a design with each unit of an aisle driven `way`, as seen along the aisle, if the unit allows it."""
        turned_design = list(design)
        for unit, along in aisle:
            turned = way if along == "along" else mirrored(way)
            if turned in self.ways[unit]:
                turned_design[unit] = turned
        return tuple(turned_design)

    def lanes(self, design: Sequence[Way]) -> dict[Edge, Way]:
        """Return the direction of every lane that can be turned."""
        return {lane: way for lanes, way in zip(self.units, design, strict=True) for lane in lanes}

    def turned(self, design: Sequence[Way]) -> list[str]:
        """Return the units whose direction differs from the drawn one, in words: `A>B>C`, `A-B-C both ways`."""
        return [
            _in_words(lanes, way)
            for lanes, way, drawn in zip(self.units, design, self.drawn, strict=True)
            if way != drawn
        ]


def turnable(layout: Layout) -> Turnable:
    """Return the lanes of a floor that can be turned: two-way lanes, and one-way lanes without an opposite edge.

    Bridges, which alone join two parts of the floor, stay as they are. Only the largest strongly connected part counts.
    """
    import networkx as nx

    graph = layout.graph.subgraph(max(nx.strongly_connected_components(layout.graph), key=len))
    bridges = {frozenset(edge) for edge in nx.bridges(graph.to_undirected(as_view=True))}
    free = [
        lane
        for lane in layout.lanes
        if lane in graph.edges
        and frozenset(lane) not in bridges
        and (graph.edges[lane].get("two_way") or not graph.has_edge(*lane[::-1]))
    ]
    units = list(_chains(graph, free))
    taken = {edge for lane in free for edge in (lane, lane[::-1])}
    ways: list[tuple[Way, ...]] = [
        ("both", "along", "back", "rather along", "rather back")
        if graph.edges[unit[0]].get("two_way")
        else ("along", "back")
        for unit in units
    ]
    return Turnable(
        tuple(units),
        tuple(ways),
        tuple(_aisles(graph, units)),
        tuple(edge for edge in graph.edges if edge not in taken),
        tuple(graph),
    )


def turnable_blocks(blocks: Blocks) -> Turnable:
    """Return the units of blocks that can be turned: every row and every column of aisles as a whole.

    All floors are alike, so the directions of the ground floor apply to each.
    """
    graph = highways(blocks.model_copy(update={"floors": 1}))
    names = block_nodes(blocks.columns, blocks.rows)
    lines = [tuple(pairwise(line)) for line in (*names, *zip(*names, strict=True))]
    units = tuple(
        line if graph.has_edge(*line[0]) else tuple((head, tail) for tail, head in reversed(line)) for line in lines
    )
    both = [graph.has_edge(*line[0]) and graph.has_edge(*line[0][::-1]) for line in units]
    ways: list[tuple[Way, ...]] = [("both", "along", "back") if two_way else ("along", "back") for two_way in both]
    return Turnable(units, tuple(ways), (), (), tuple(graph))


def _chains(graph: nx.DiGraph, lanes: Sequence[Edge]) -> Iterator[tuple[Edge, ...]]:
    """Yield chains of lanes through nodes without a further lane: the lanes of a chain turn only together."""
    lanes_at: dict[str, list[Edge]] = {}
    for lane in lanes:
        for node in lane:
            lanes_at.setdefault(node, []).append(lane)

    def beyond(node: str, lane: Edge) -> Edge | None:
        """Return the lane that continues another beyond a node, listed in its direction; None at a junction."""
        around = {*graph.pred[node], *graph.succ[node]}
        here = [other for other in lanes_at[node] if other != lane and other != lane[::-1]]
        if len(around) != 2 or len(here) != 1:  # noqa: PLR2004 - one lane before and one after
            return None
        other = here[0]
        if bool(graph.edges[other].get("two_way")) != bool(graph.edges[lane].get("two_way")):
            return None
        return other if (other[0] == node) == (lane[1] == node) else other[::-1]

    done: set[frozenset[str]] = set()
    for lane in lanes:
        if frozenset(lane) in done:
            continue
        chain = [lane]
        done.add(frozenset(lane))
        for forward in (True, False):
            while True:
                end = chain[-1] if forward else chain[0]
                following = beyond(end[1] if forward else end[0], end)
                if following is None or frozenset(following) in done:
                    break
                done.add(frozenset(following))
                chain.insert(len(chain) if forward else 0, following)
        yield tuple(chain)


def _aisles(graph: nx.DiGraph, units: Sequence[tuple[Edge, ...]]) -> Iterator[tuple[tuple[int, Way], ...]]:
    """Yield the aisles of several units, each unit with its direction towards larger x or y."""
    lanes = [lane for unit in units for lane in unit]
    if not lanes:
        return
    unit_of = [number for number, unit in enumerate(units) for _ in unit]
    aisles = Aisles.of(graph, lanes)
    for group in aisles.groups():
        aisle: dict[int, Way] = {unit_of[lane]: "along" if aisles.upwards[lane] else "back" for lane in group}
        if len(aisle) > 1:
            yield tuple(aisle.items())


def _new(design: tuple[Way, ...], seen: set[tuple[Way, ...]]) -> Iterator[tuple[Way, ...]]:
    if design not in seen:
        seen.add(design)
        yield design


def _in_words(lanes: Sequence[Edge], way: Way) -> str:
    nodes = [lanes[0][0], *(head for _, head in lanes)]
    if way.endswith("back"):
        nodes.reverse()
    if way == "both":
        return f"{'-'.join(nodes)} both ways"
    return f"{'rather ' if way.startswith('rather') else ''}{'>'.join(nodes)}"
