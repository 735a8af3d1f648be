"""Walking distances of people, along the lanes in either direction, past robots and past each other."""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import networkx as nx

    from desim_warehouse.layout.layout import Edge, Layout

Spot: TypeAlias = "tuple[Edge, float]"
"""A position as an edge and the distance from its start; for a spot on a node, the node as both ends, and 0."""


class Walking:
    """Walking distances between spots of a layout, by the shortest way; each node is searched from only once."""

    def __init__(self, layout: Layout) -> None:
        import networkx as nx

        self._length = layout.length
        self._lanes: nx.Graph[str] = nx.Graph()
        self._lanes.add_nodes_from(layout.graph)
        for a, b, length in layout.graph.edges(data="length"):
            if not self._lanes.has_edge(a, b) or length < self._lanes.edges[a, b]["length"]:
                self._lanes.add_edge(a, b, length=length)
        self._ends = {end for place in layout.storage for end in place.edge}
        self._rows: dict[str, dict[str, float]] = {}
        self._paths: dict[str, dict[str, list[str]]] = {}

    def distance(self, start: Spot, goal: Spot) -> float:
        """Return the length of the shortest way between two spots of storage places; inf if there is none."""
        edge, offset = start
        other, beyond = self._as_beside(edge, goal)
        if edge == other:
            return abs(beyond - offset)
        return min(
            near + self._between(node, end) + far
            for node, near in self._ways_out(edge, offset)
            for end, far in self._ways_out(other, beyond)
        )

    def nodes(self, start: Spot, goal: Spot) -> list[str]:
        """Return the nodes on the shortest way between two spots of storage places; empty if both are on one lane."""
        import networkx as nx

        edge, offset = start
        other, beyond = self._as_beside(edge, goal)
        if edge == other:
            return []
        node, end = min(
            ((node, end) for node, _ in self._ways_out(edge, offset) for end, _ in self._ways_out(other, beyond)),
            key=lambda ends: self._from(start, ends[0]) + self._between(*ends) + self._from(goal, ends[1]),
        )
        if node not in self._paths:
            self._paths[node] = nx.single_source_dijkstra_path(self._lanes, node, weight="length")
        return self._paths[node][end]

    def _from(self, spot: Spot, node: str) -> float:
        return dict(self._ways_out(*spot))[node]

    def _as_beside(self, edge: Edge, spot: Spot) -> Spot:
        """Return a spot on the edge opposite to `edge` as a spot on `edge`, which is beside it or the same lane."""
        other, beyond = spot
        if other == edge[::-1] and math.isclose(self._length(other), self._length(edge), rel_tol=1e-6):
            return edge, self._length(other) - beyond
        return spot

    def _ways_out(self, edge: Edge, offset: float) -> tuple[tuple[str, float], ...]:
        """Return both ends of an edge with their distances from a spot; a spot on a node has only this node."""
        start, end = edge
        return ((start, 0.0),) if start == end else ((start, offset), (end, self._length(edge) - offset))

    def _between(self, node: str, other: str) -> float:
        import networkx as nx

        if node not in self._rows:
            row = nx.single_source_dijkstra_path_length(self._lanes, node, weight="length")
            self._rows[node] = {end: row[end] for end in self._ends if end in row}
        return self._rows[node].get(other, math.inf)


@lru_cache(maxsize=4)
def walking_on(layout: Layout) -> Walking:
    """Return the walking distances of a layout, shared by the runs of a study."""
    return Walking(layout)


@lru_cache(maxsize=16)
def zones_of(layout: Layout, zones: int) -> tuple[tuple[Spot, ...], ...]:
    """Divide the spots of storage places into zones of nearly equal size, in the order of their lanes.

    Spots on both lanes of an aisle stand together, in the order along the aisle. If there are fewer spots than `zones`,
    each spot is a zone.
    """
    aisles: dict[tuple[str, ...], set[Spot]] = {}
    for place in layout.storage:
        aisles.setdefault(tuple(sorted(place.edge)), set()).add((place.edge, place.offset))

    def along(spot: Spot) -> tuple[float, Edge]:
        edge, offset = spot
        return offset if edge[0] <= edge[1] else layout.length(edge) - offset, edge

    spots = [spot for aisle in aisles.values() for spot in sorted(aisle, key=along)]
    parts = min(zones, len(spots))
    bounds = [rank * len(spots) // parts for rank in range(parts + 1)]
    return tuple(tuple(spots[begin:end]) for begin, end in pairwise(bounds))


def at_start(count: int, zones: Sequence[Sequence[Spot]]) -> Iterator[tuple[int, Spot]]:
    """Yield the zone and spot of each of `count` people, dealt out to zones in turn and spread evenly in each."""
    for number in range(count):
        zone, rank = number % len(zones), number // len(zones)
        spots, of_zone = zones[zone], len(range(zone, count, len(zones)))
        yield zone, spots[(2 * rank + 1) * len(spots) // (2 * of_zone)]
