"""The distance oracle: directed distances and driving times between nodes, worked out when asked for.

One search a row (scipy.sparse.csgraph.dijkstra towards a goal or from an origin, or Algorithm 1's breadth-first
search from an origin), kept for the rows used last; so memory stays within KEPT numbers, also on layouts of
10,000 nodes. Ways that end at a hub (a station, a bay) are searched towards it, ways that only begin at one from
it: robots drive between hubs and storage, so a row for each hub serves nearly all ways.
"""

from __future__ import annotations

import math
from array import array
from collections import OrderedDict, deque
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import networkx as nx

    from desim_warehouse.layout.layout import Layout

Cost = Literal["hops", "length", "time"]
KEPT = 8_000_000
"""Numbers of each kind that an oracle keeps: rows times nodes (64 MB of times, as much of lengths)."""


class RouteOracle:
    """The cheapest ways on the Highways for one cost of an edge, with their lengths and free driving times.

    `hops` counts nodes and breaks ties by the successors' order from the origin, as the paper's Algorithm 1
    does; `length` is in length units; `time` includes node times and edge speed limits, waiting not. Times of
    a way are at `speed`, whatever the cost that chose it.
    """

    def __init__(
        self, highways: nx.DiGraph, cost: Cost, speed: float, node_time: float, hubs: Iterable[str] = ()
    ) -> None:
        self.cost = cost
        self.names = list(highways)
        self.index = {name: i for i, name in enumerate(self.names)}
        self._next: list[list[tuple[int, float, float]]] = [
            [
                (self.index[target], data["length"], data["length"] / min(speed, data["speed"]) + node_time)
                for target, data in highways[name].items()
            ]
            for name in self.names
        ]
        self._hubs = frozenset(hubs)
        self._keep = max(KEPT // max(len(self.names), 1), 1)
        self._rows: OrderedDict[tuple[int, bool], tuple[Any, Any, Any]] = OrderedDict()
        self._edges: Any = None

    def length(self, origin: str, goal: str) -> float:
        """Length of the way; inf where there is none."""
        row, at = self._row_of(origin, goal)
        return float(row[0][at])

    def time(self, origin: str, goal: str) -> float:
        """Free driving time of the way; inf where there is none."""
        row, at = self._row_of(origin, goal)
        return float(row[1][at])

    def way(self, origin: str, goal: str) -> list[str]:
        """Nodes of the way, both ends included; empty where there is none."""
        forward = self._forward(origin, goal)
        (lengths, _, steps), at = self._row_of(origin, goal)
        if math.isinf(lengths[at]):
            return []
        names, root = self.names, self.index[origin if forward else goal]
        way = [names[at]]
        while at != root:
            at = steps[at]
            way.append(names[at])
        return way[::-1] if forward else way

    def matrix(self, origins: Sequence[str], goals: Sequence[str], what: Literal["length", "time"]) -> Any:
        """Lengths or times from every origin (rows) to every goal (columns), a numpy array."""
        import numpy as np

        part = 0 if what == "length" else 1
        starts, ends = list(dict.fromkeys(origins)), list(dict.fromkeys(goals))
        start, end = (np.array([self.index[name] for name in names], dtype=np.intp) for names in (starts, ends))
        table = np.empty((len(starts), len(ends)))
        hub = np.array([self._forward(name, "") for name in starts])
        plain = np.array([self.cost == "hops" or name not in self._hubs for name in ends])
        for i in np.flatnonzero(hub):
            row = np.frombuffer(self._row(int(start[i]), forward=True)[part])
            table[i, plain] = row[end[plain]]
        for j in range(len(ends)):
            others = ~hub if plain[j] else np.ones_like(hub)
            if others.any():
                row = np.frombuffer(self._row(int(end[j]), forward=False)[part])
                table[others, j] = row[start[others]]
        rank, place = ({name: i for i, name in enumerate(names)} for names in (starts, ends))
        return table[np.ix_([rank[name] for name in origins], [place[name] for name in goals])]

    def _forward(self, origin: str, goal: str) -> bool:
        """Whether a way is searched from its origin."""
        return self.cost == "hops" or (origin in self._hubs and goal not in self._hubs)

    def _row_of(self, origin: str, goal: str) -> tuple[tuple[Any, Any, Any], int]:
        if self._forward(origin, goal):
            return self._row(self.index[origin], forward=True), self.index[goal]
        return self._row(self.index[goal], forward=False), self.index[origin]

    def _row(self, root: int, *, forward: bool) -> tuple[Any, Any, Any]:
        """Lengths, times and next nodes (towards the root) of all nodes."""
        key = root, forward
        row = self._rows.get(key)
        if row is None:
            row = self._breadth_first(root) if self.cost == "hops" else self._dijkstra(root, forward=forward)
            self._rows[key] = row
            if len(self._rows) > self._keep:
                self._rows.popitem(last=False)
        elif len(self._rows) == self._keep:
            self._rows.move_to_end(key)
        return row

    def _breadth_first(self, root: int) -> tuple[Any, Any, Any]:
        size = len(self.names)
        lengths, times = array("d", [math.inf]) * size, array("d", [math.inf]) * size
        before = array("i", range(size))
        lengths[root] = times[root] = 0.0
        seen, line = {root}, deque([root])
        while line:
            here = line.popleft()
            for there, length, time in self._next[here]:
                if there not in seen:
                    seen.add(there)
                    before[there] = here
                    lengths[there] = lengths[here] + length
                    times[there] = times[here] + time
                    line.append(there)
        return lengths, times, before

    def _dijkstra(self, root: int, *, forward: bool) -> tuple[Any, Any, Any]:
        import numpy as np
        from scipy.sparse.csgraph import dijkstra

        if self._edges is None:
            self._edges = self._matrices()
        graph, keys, other = self._edges
        search: Any = dijkstra
        costs, steps = search(graph if forward else graph.T, indices=root, return_predecessors=True)
        here = np.arange(len(costs))
        steps = np.where(steps < 0, here, steps)
        first = np.where(np.isinf(costs), np.inf, 0.0)
        moved = steps != here
        source, target = (steps, here) if forward else (here, steps)
        edges = np.searchsorted(keys[0], source[moved] * len(costs) + target[moved])
        first[moved] = other[keys[1][edges]]
        along = _along(steps, first)
        lengths, times = (costs, along) if self.cost == "length" else (along, costs)
        return tuple(
            array(kind, row.astype(kind).tobytes()) for kind, row in zip("ddi", (lengths, times, steps), strict=True)
        )  # type: ignore[return-value]

    def _matrices(self) -> tuple[Any, Any, Any]:
        """The Highways with their costs; edges by (from, to) in order; the edges' other cost."""
        import numpy as np
        from scipy.sparse import csr_array

        size = len(self.names)
        edges = [(i, *edge) for i, row in enumerate(self._next) for edge in row]
        source, target, length, time = (np.array(column) for column in zip(*edges, strict=True))
        cost, other = (length, time) if self.cost == "length" else (time, length)
        keys = source * size + target
        order = np.argsort(keys)
        return csr_array((cost, (source, target)), shape=(size, size)), (keys[order], order), other


def _along(steps: Any, first: Any) -> Any:
    """Sum of `first` along the chains of `steps`, each of which ends in a node that leads to itself."""
    total = first
    while True:
        further = steps[steps]
        total = total + total[steps]
        if (further == steps).all():
            return total
        steps = further


@lru_cache(maxsize=4)
def travel_on(layout: Layout, speed: float, node_time: float, cost: Cost, hubs: tuple[str, ...]) -> FreeTravel:
    """The travel times of a layout; runs of a study share them, as they do not depend on who asked before."""
    return FreeTravel(layout.graph, speed, node_time, cost, hubs)


class FreeTravel:
    """Distances and free driving times on the Highways: `distance` by the shortest way, `time` by the fastest.

    `ways` is the oracle of the routing policy in force: lengths and times along the ways that robots do drive.
    """

    def __init__(
        self, highways: nx.DiGraph, speed: float, node_time: float, cost: Cost = "time", hubs: Iterable[str] = ()
    ) -> None:
        self.highways = highways
        self.speed = speed
        self.node_time = node_time
        self.cost = cost
        self.hubs = frozenset(hubs)
        self._oracles: dict[str, RouteOracle] = {}

    def oracle(self, cost: Cost) -> RouteOracle:
        """The oracle for ways that are cheapest by a cost."""
        found = self._oracles.get(cost)
        if found is None:
            found = self._oracles[cost] = RouteOracle(self.highways, cost, self.speed, self.node_time, self.hubs)
        return found

    def along(self, edge: tuple[str, str], offset: float) -> tuple[float, float]:
        """Times from the start of a good's edge to the good, and from there to the end, its node time included."""
        if edge[0] == edge[1]:
            return 0.0, 0.0
        data = self.highways.edges[edge]
        pace = min(self.speed, data["speed"])
        return offset / pace, (data["length"] - offset) / pace + self.node_time

    @property
    def ways(self) -> RouteOracle:
        """The oracle of the ways that robots drive."""
        return self.oracle(self.cost)

    def distance(self, origin: str, goal: str) -> float:
        """Length of the shortest way."""
        return self.oracle("length").length(origin, goal)

    def time(self, origin: str, goal: str) -> float:
        """Time of the fastest way: node times and speed limits included, waiting not."""
        return self.oracle("time").time(origin, goal)

    def way(self, origin: str, goal: str) -> list[str]:
        """The nodes that a robot drives from origin to goal, both included."""
        return self.ways.way(origin, goal)

    def times(self, origins: Sequence[str], goals: Sequence[str]) -> Any:
        """Free driving times of the ways that robots drive: a row for each origin, a column for each goal."""
        return self.ways.matrix(origins, goals, "time")

    def lengths(self, origins: Sequence[str], goals: Sequence[str]) -> Any:
        """Lengths of the ways that robots drive: a row for each origin, a column for each goal."""
        return self.ways.matrix(origins, goals, "length")
