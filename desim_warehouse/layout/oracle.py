"""Shortest-path oracle: directed distances and driving times between nodes, computed on demand.

Each row is one search: scipy.sparse.csgraph.dijkstra towards a goal or from an origin, or Algorithm 1's breadth-first
search from an origin. Only the most recently used rows are kept, so memory is bounded by `KEPT` numbers even on layouts
of 10,000 nodes. A route that ends at a hub (a station or bay) is searched towards the hub, and a route that only begins
at one is searched from it. Robots drive between hubs and storage, so one row for each hub serves nearly all routes.
"""

from __future__ import annotations

import math
from array import array
from collections import OrderedDict, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, Literal

from desim_warehouse.layout.turning import Turns, last_steps, sums_along

if TYPE_CHECKING:
    import networkx as nx


Cost = Literal["hops", "length", "time"]
Row = tuple[Any, Any, Any, Any]
Tree = tuple["array[float]", "array[float]", "array[int]"]
KEPT = 24_000_000
"""Largest count of numbers of each kind in an oracle: rows times nodes (192 MB of times, as much of lengths).

A decision asks for a row for each open task. If fewer rows are kept than there are open tasks, every decision searches
all of them again: on 42,000 nodes, 8 million numbers were 190 rows, and a run with 200 open tasks took ten times as
long.
"""
WAYS = 5_000
"""Routes that an oracle keeps, for runs of a small model that ask for them again and again."""
TIMES = 10_000
"""Times of routes that an oracle keeps by their ends: robots drive between few nodes, and each decision asks anew."""
FEW = 24
"""Entries of a table up to which they are looked up one by one, as this is faster than preparing whole rows."""
TIE = 1e-9
"""Relative difference up to which lengths or times of routes count as equal, since their sums are rounded."""


class RouteOracle:
    """The cheapest routes on the Highways for one cost of an edge, with their lengths and free driving times.

    `hops` counts nodes, and breaks ties by the order of successors from the origin, as the paper's Algorithm 1 does.
    `length` is in length units. `time` includes node times, speed limits of edges and rides, but no waiting. Driving
    times are at `speed`, whichever cost chose the route. The factor `counts` of an edge applies where routes are
    compared by length or time; the lengths and times returned are those driven.
    """

    def __init__(
        self,
        highways: nx.DiGraph,
        cost: Cost,
        speed: float,
        node_time: float,
        hubs: Iterable[str] = (),
        turn_time: float = 0.0,
        node_times: Mapping[str, float] | None = None,
        stop_time: float = 0.0,
    ) -> None:
        own = node_times or {}
        self.cost = cost
        self._from_origin = cost == "hops"
        self.names = list(highways)
        self.index = {name: i for i, name in enumerate(self.names)}
        self._next: list[list[tuple[int, float, float]]] = [
            [
                (
                    self.index[target],
                    data["length"],
                    data["length"] / min(speed, data["speed"]) + data.get("takes", 0.0) + own.get(target, node_time),
                )
                for target, data in highways[name].items()
            ]
            for name in self.names
        ]
        self._counts = [[data.get("counts", 1.0) for data in highways[name].values()] for name in self.names]
        self._counted = cost != "hops" and any(count != 1 for row in self._counts for count in row)
        self._closed = frozenset(i for i, name in enumerate(self.names) if highways.nodes[name].get("in_lane"))
        edges = self._every_edge() if turn_time else []
        self._turns = Turns(highways, edges, turn_time, self._closed, stop_time) if turn_time else None
        self._beside: dict[tuple[int, bool], tuple[Any, Any]] = {}
        self._hubs = frozenset(hubs)
        self._keep = max(KEPT // max(len(self.names), 1), 1)
        self._rows: OrderedDict[tuple[int, bool], Row] = OrderedDict()
        self._way = lru_cache(WAYS)(self._searched)
        self._time = lru_cache(TIMES)(self._looked_up)
        self._edges: Any = None
        self._open: dict[tuple[int, bool], Any] = {}
        self._steps: dict[bool, list[list[tuple[int, float, float, float]]]] = {}

    def length(self, origin: str, goal: str) -> float:
        """Return the length of the route; inf if there is no route."""
        row, node = self._row_of(origin, goal)
        return float(row[0][node])

    def time(self, origin: str, goal: str) -> float:
        """Return the free driving time of the route; inf if there is no route."""
        return self._time(origin, goal)

    def _looked_up(self, origin: str, goal: str) -> float:
        row, node = self._row_of(origin, goal)
        return float(row[1][node])

    def counted(self, origin: str, goal: str) -> float:
        """Return the cost by which a route is compared; driving against a preferred direction makes it larger."""
        row, node = self._row_of(origin, goal)
        return float(row[3][node])

    def way(self, origin: str, goal: str, tie: int = 0) -> list[str]:
        """Return the nodes of the route, both ends included; empty if there is no route.

        Where several routes have equal cost, length and time, `tie` selects among them, unless turns take time.
        """
        return list(self._way(origin, goal, tie))

    def _searched(self, origin: str, goal: str, tie: int) -> Sequence[str]:
        forward = self._forward(origin, goal)
        row, node = self._row_of(origin, goal)
        if math.isinf(row[0][node]):
            return ()
        names, root, steps = self.names, self.index[origin if forward else goal], row[2]
        way = [names[node]]
        if self._is_over_edges:
            assert self._turns is not None
            ends, size = self._turns.far_ends(forward=forward), len(names)
            while (node := steps[node]) >= size:
                way.append(names[ends[node - size]])
        while node != root:
            tied = tie and self._turns is None
            node = self._tied(row, node, root, tie, forward=forward) if tied else steps[node]
            way.append(names[node])
        return way[::-1] if forward else way

    @property
    def _is_over_edges(self) -> bool:
        """Whether routes are searched over edges, because turns between edges count."""
        return self._turns is not None and self.cost == "time"

    def beside(self, origin: str, goal: str) -> tuple[str, str]:
        """Return the second node and the last node but one of a route with at least two nodes, where turns count."""
        forward = self._forward(origin, goal)
        root, node = map(self.index.__getitem__, (origin, goal) if forward else (goal, origin))
        near, far = (self.names[nodes[node]] for nodes in self._besides(root, forward=forward))
        return (far, near) if forward else (near, far)

    def beside_all(self, origins: Sequence[str], goals: Sequence[str]) -> tuple[Any, Any]:
        """Return `beside` from every origin (rows) to every goal (columns), as two tables of node numbers."""
        import numpy as np

        second = self._table(origins, goals, lambda root, forward: self._besides(root, forward=forward)[forward])
        last = self._table(origins, goals, lambda root, forward: self._besides(root, forward=forward)[not forward])
        return second.astype(np.intp), last.astype(np.intp)

    def _besides(self, root: int, *, forward: bool) -> tuple[Any, Any]:
        """Return for every node the next node towards the root, and the last node before the root, as arrays."""
        import numpy as np

        steps = self._row(root, forward=forward)[2]
        if (root, forward) not in self._beside:
            self._beside[root, forward] = self._next_to(np.frombuffer(steps, dtype=np.intc), root, forward=forward)
        return self._beside[root, forward]

    def _next_to(self, steps: Any, root: int, *, forward: bool) -> tuple[Any, Any]:
        import numpy as np

        last, size, turns = last_steps(steps, root), len(self.names), self._turns
        if not self._is_over_edges:
            return steps, last
        assert turns is not None
        far, near = turns.far_ends(forward=forward), turns.far_ends(forward=not forward)
        here = np.arange(size)
        return (
            np.where(steps[:size] >= size, far[steps[:size] - size], here),
            np.where(last[:size] >= size, near[last[:size] - size], here),
        )

    def _every_edge(self) -> list[tuple[int, int, float, float, float]]:
        """Return all edges as numbers of their two nodes, length, time, and the time by which routes are compared."""
        return [
            (source, target, length, time, count * time)
            for source, (edges, counts) in enumerate(zip(self._next, self._counts, strict=True))
            for (target, length, time), count in zip(edges, counts, strict=True)
        ]

    def _tied(self, row: Row, node: int, root: int, tie: int, *, forward: bool) -> int:
        """Return the next node towards the root on a route drawn from the routes of equal cost, length and time."""
        lengths, times, _, costs = row
        length, time, cost = lengths[node] * TIE, times[node] * TIE, costs[node] * TIE
        nexts = [
            neighbour
            for neighbour, long, lasts, counts in self._towards(forward=forward)[node]
            if costs[neighbour] < costs[node]
            and (neighbour == root or neighbour not in self._closed)
            and abs(costs[neighbour] + counts - costs[node]) <= cost
            and abs(lengths[neighbour] + long - lengths[node]) <= length
            and abs(times[neighbour] + lasts - times[node]) <= time
        ]
        return nexts[_drawn(tie, node, root) % len(nexts)] if nexts else int(row[2][node])

    def _towards(self, *, forward: bool) -> list[list[tuple[int, float, float, float]]]:
        """Return for each node its neighbours one edge closer to the root, with the edge's length, time and cost.

        With `forward`, routes begin at the root, and the neighbours are the node's predecessors; otherwise routes end
        at the root, and the neighbours are its successors.
        """
        if forward not in self._steps:
            neighbours: list[list[tuple[int, float, float, float]]] = [[] for _ in self.names]
            for source, (edges, counts) in enumerate(zip(self._next, self._counts, strict=True)):
                for (target, length, time), count in zip(edges, counts, strict=True):
                    cost = 1.0 if self.cost == "hops" else count * (length if self.cost == "length" else time)
                    node, following = (target, source) if forward else (source, target)
                    neighbours[node].append((following, length, time, cost))
            self._steps[forward] = neighbours
        return self._steps[forward]

    def matrix(self, origins: Sequence[str], goals: Sequence[str], what: Literal["length", "time"]) -> Any:
        """Return the lengths or times from every origin (rows) to every goal (columns), as a numpy array."""
        import numpy as np

        if len(origins) * len(goals) <= FEW:
            look = self.length if what == "length" else self.time
            cells = np.array([look(origin, goal) for origin in origins for goal in goals])
            return cells.reshape(len(origins), len(goals))
        part = 0 if what == "length" else 1
        return self._table(origins, goals, lambda root, forward: np.frombuffer(self._row(root, forward=forward)[part]))

    def _table(self, origins: Sequence[str], goals: Sequence[str], read: Callable[[int, bool], Any]) -> Any:
        """Return a matrix with a row for each origin and a column for each goal, from as few searches as possible.

        `read(root, forward)` returns the values of all nodes for the routes that begin at the root (`forward`: the root
        is an origin) or end there (the root is a goal).
        """
        import numpy as np

        starts: dict[str, int] = {}
        ends: dict[str, int] = {}
        rows = [starts.setdefault(name, len(starts)) for name in origins]
        columns = [ends.setdefault(name, len(ends)) for name in goals]
        start, end = (np.array([self.index[name] for name in names], dtype=np.intp) for names in (starts, ends))
        table = np.empty((len(starts), len(ends)))
        hub = np.array([self._forward(name, "") for name in starts])
        plain = np.array([self._from_origin or name not in self._hubs for name in ends])
        for i in np.flatnonzero(hub) if plain.any() else ():
            table[i, plain] = read(int(start[i]), True)[end[plain]]
        for some, others in ((plain, np.flatnonzero(~hub)), (~plain, slice(None))):
            sources, targets = start[others], np.flatnonzero(some)
            for column, goal in zip(targets.tolist(), end[some].tolist(), strict=True) if len(sources) else ():
                table[others, column] = read(goal, False)[sources]
        return table if table.shape == (len(rows), len(columns)) else table[np.ix_(rows, columns)]

    def _forward(self, origin: str, goal: str) -> bool:
        """Return whether a route is searched from its origin."""
        return self._from_origin or (origin in self._hubs and goal not in self._hubs)

    def _row_of(self, origin: str, goal: str) -> tuple[Row, int]:
        if self._forward(origin, goal):
            return self._row(self.index[origin], forward=True), self.index[goal]
        return self._row(self.index[goal], forward=False), self.index[origin]

    def _row(self, root: int, *, forward: bool) -> Row:
        """Return by node the lengths and times of routes, the next nodes towards the root, and the costs of routes."""
        key = root, forward
        row = self._rows.get(key)
        if row is None:
            row = self._breadth_first(root) if self._from_origin else self._dijkstra(root, forward=forward)
            self._rows[key] = row
            if len(self._rows) > self._keep:
                self._beside.pop(self._rows.popitem(last=False)[0], None)
        elif len(self._rows) == self._keep:
            self._rows.move_to_end(key)
        return row

    def _breadth_first(self, root: int) -> Row:
        lengths, times, before = self._from(root)
        if self._turns is not None:
            import numpy as np

            first = self._turns.between(np.frombuffer(before, dtype=np.intc))
            turned = sums_along(np.frombuffer(before, dtype=np.intc), first)
            times = array("d", (np.frombuffer(times) + turned).tobytes())
        return lengths, times, before, lengths

    def _from(self, root: int) -> Tree:
        """Search with Algorithm 1 (breadth first): each node is reached from the first visited node leading to it."""
        size = len(self.names)
        lengths, times = array("d", [math.inf]) * size, array("d", [math.inf]) * size
        before = array("i", range(size))
        lengths[root] = times[root] = 0.0
        seen, line = {root}, deque([root])
        while line:
            here = line.popleft()
            if here != root and here in self._closed:
                continue
            for neighbour, length, time in self._next[here]:
                if neighbour not in seen:
                    seen.add(neighbour)
                    before[neighbour] = here
                    lengths[neighbour] = lengths[here] + length
                    times[neighbour] = times[here] + time
                    line.append(neighbour)
        return lengths, times, before

    @cached_property
    def _columns(self) -> tuple[Any, ...]:
        """The start node, end node, length and time of every edge as arrays, sorted by start node."""
        import numpy as np

        edges = [(source, *edge) for source, edges in enumerate(self._next) for edge in edges]
        return tuple(np.array(column) for column in zip(*edges, strict=True))

    def _cheapest(self, root: int, *, forward: bool) -> tuple[Any, Any]:
        """Return the cost of every node from or to a root, and the next node towards it; negative if there is none."""
        from scipy.sparse.csgraph import dijkstra

        if self._edges is None:
            self._edges = self._matrices()
        search: Any = dijkstra
        towards = self._edges[forward][0]
        if self._closed:
            towards = self._without_passing(self._edges[True][0], root, forward=forward)
        tree: tuple[Any, Any] = search(towards, indices=root, return_predecessors=True)
        return tree

    def _dijkstra(self, root: int, *, forward: bool) -> Row:
        import numpy as np

        if self._is_over_edges:
            assert self._turns is not None
            rows = self._turns.fastest(root, forward=forward)
            made = [array(kind, row.astype(kind).tobytes()) for kind, row in zip("ddid", rows, strict=True)]
            return made[0], made[1], made[2], made[3]
        costs, steps = self._cheapest(root, forward=forward)
        _, begins, beside, columns = self._edges[forward]
        here = np.arange(len(costs))
        steps = np.where(steps < 0, here, steps)
        edges, moved = begins.copy(), np.flatnonzero(steps != here)
        left = moved  # nodes still without the edge that their route takes; each has few edges to try
        while len(left := left[beside[edges[left]] != steps[left]]):
            edges[left] += 1

        def along(what: Cost) -> Any:
            """Return the lengths or times of the cheapest routes."""
            if what == self.cost and not self._counted:
                return costs
            first = np.where(np.isinf(costs), np.inf, 0.0)
            first[moved] = columns[what][edges[moved]]
            if what == "time" and self._turns is not None:
                first += self._turns.between(steps)
            return sums_along(steps, first)

        lengths, times, before = (
            array(kind, row.astype(kind).tobytes())
            for kind, row in zip("ddi", (along("length"), along("time"), steps), strict=True)
        )
        if self._counted:
            return lengths, times, before, array("d", costs.tobytes())
        return lengths, times, before, lengths if self.cost == "length" else times

    def _without_passing(self, graph: Any, root: int, *, forward: bool) -> Any:
        """Return the graph of costs without the edges that lead on beyond a bay in the lane, unless it is the root."""
        import numpy as np
        from scipy.sparse import csr_array

        key = root if root in self._closed else -1, forward
        if key not in self._open:
            edges = graph.tocoo()
            begin, end = (edges.row, edges.col) if forward else (edges.col, edges.row)
            kept = ~np.isin(begin, list(self._closed - {root}))
            self._open[key] = csr_array((edges.data[kept], (begin[kept], end[kept])), shape=graph.shape)
        return self._open[key]

    def _matrices(self) -> dict[bool, tuple[Any, Any, Any, dict[str, Any]]]:
        """Return graphs of the costs of edges, for routes from a node (True) and to a node (False).

        With each graph come the first edge by which a route comes to (or goes on from) each node, the other node of
        each edge, and the edges' lengths and times, all sorted by node.
        """
        import numpy as np
        from scipy.sparse import csr_array

        size = len(self.names)
        source, target, length, time = self._columns
        cost = length if self.cost == "length" else time
        if self._counted:
            cost = cost * np.concatenate([np.array(row) for row in self._counts])
        matrices = {}
        for forward, (far, near) in ((True, (source, target)), (False, (target, source))):
            order = np.argsort(near, kind="stable")
            columns = {"length": length[order], "time": time[order]}
            graph = csr_array((cost, (far, near)), shape=(size, size))
            matrices[forward] = graph, np.searchsorted(near[order], np.arange(size)), far[order], columns
        return matrices


def _drawn(tie: int, node: int, root: int) -> int:
    """Return a pseudo-random number that depends only on the arguments (a multiplicative hash: Knuth, TAOCP 3, 6.4)."""
    mixed = (tie * 0x9E3779B1 ^ root * 0x85EBCA77 ^ node) * 0xC2B2AE3D & 0xFFFFFFFF
    return mixed >> 15 ^ mixed >> 7
