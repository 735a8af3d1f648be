"""Free driving where robots take time to turn on nodes: the cost of a route depends on which edges follow each other.

So the fastest route is searched over edges, not over nodes, towards a goal or from an origin. Each step is an edge with
the turn from the one before. Turns before the first edge and after the last are not in the time of a route, as a node
alone does not say where a robot faces there. `FreeTravel` adds them where they are known.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from desim_warehouse.layout.layout import Edge

if TYPE_CHECKING:
    import networkx as nx


def turning(highways: nx.DiGraph, edge: Edge, other: Edge) -> float:
    """Return the quarters of a turn from the heading of one edge to the heading of another, drawn straight."""
    return float(quarters(heading(highways, edge) - heading(highways, other)))


def heading(highways: nx.DiGraph, edge: Edge) -> float:
    """Return the angle of an edge, drawn straight."""
    (x0, y0), (x1, y1) = ((highways.nodes[node]["x"], highways.nodes[node]["y"]) for node in edge)
    return math.atan2(y1 - y0, x1 - x0)


def quarters(angle: Any) -> Any:
    """Return the quarters of a turn by an angle, a number or an array of them."""
    return abs((angle + math.pi) % (2 * math.pi) - math.pi) / (math.pi / 2)


def turn_times(quarters: Any, turn_time: float, stop_time: float) -> Any:
    """Return how long turns take, and the stops for them: by quarters of a turn, a number or an array of them."""
    return turn_time * quarters + stop_time * (quarters > 0)


class Turns:
    """The turns on all nodes of some Highways; edges are given by node numbers, with the costs of routes.

    No route leads through a node that is `closed`. Besides, each turn takes `stop_time`: a robot stops for it.
    """

    def __init__(
        self,
        highways: nx.DiGraph,
        edges: Sequence[tuple[int, int, float, float, float]],
        turn_time: float,
        closed: Iterable[int] = (),
        stop_time: float = 0.0,
    ) -> None:
        import numpy as np

        self.turn_time = turn_time
        self.stop_time = stop_time
        self.size = len(highways)
        self.at = np.array([complex(data["x"], data["y"]) for _, data in highways.nodes(data=True)])
        self.source, self.target, self.length, self.time, self.cost = (
            np.array(column) for column in zip(*edges, strict=True)
        )
        self.heading = np.angle(self.at[self.target] - self.at[self.source])
        self.closed = list(closed)
        self._graphs: dict[bool, Any] = {}

    def between(self, steps: Any) -> Any:
        """Return the time of the turn between the first two edges of every chain of nodes; 0 for shorter chains."""
        import numpy as np

        here, further = np.arange(len(steps)), steps[steps]
        incoming, outgoing = np.angle(self.at[steps] - self.at[here]), np.angle(self.at[further] - self.at[steps])
        return np.where((steps != here) & (further != steps), self._times(incoming - outgoing), 0.0)

    def _times(self, angles: Any) -> Any:
        """Return how long turns by some angles take."""
        return turn_times(quarters(angles), self.turn_time, self.stop_time)

    def fastest(self, root: int, *, forward: bool) -> tuple[Any, Any, Any, Any]:
        """Return lengths and times from a node to all (or to it), the steps towards it, and the costs.

        Steps are over states: the nodes, then the edges. The step of a node is the edge of its route at this end. The
        step of an edge is the edge that follows on the way to the root or, after the last, the root.
        """
        import numpy as np
        from scipy.sparse.csgraph import dijkstra

        search: Any = dijkstra
        costs, before = search(self._graph(forward=forward), indices=root, return_predecessors=True)
        size, count = self.size, len(self.source)
        here = np.arange(size + count)
        steps = np.where(before < 0, here, before)
        onward = steps[size:] - size
        turn = np.where(onward >= 0, self._times(self.heading - self.heading[onward]), 0.0)
        is_reached = np.isfinite(costs[size:])
        node = self.target if forward else self.source
        order = np.lexsort((np.arange(count), costs[size:], node))
        first = np.minimum(np.searchsorted(node[order], np.arange(size)), count - 1)
        best = order[first]
        has = (node[best] == np.arange(size)) & is_reached[best] & (np.arange(size) != root)
        steps[:size] = np.where(has, size + best, here[:size])
        sums = []
        for first_of in (self.length, self.time + turn):
            along = np.concatenate([np.zeros(size), np.where(is_reached, first_of, 0.0)])
            sums.append(np.where(has, sums_along(steps, along)[:size], np.inf))
            sums[-1][root] = 0.0
        costs = np.where(has, costs[size + best], np.inf)
        costs[root] = 0.0
        return sums[0], sums[1], steps, costs

    def far_ends(self, *, forward: bool) -> Any:
        """Return the node at the root's side of every edge."""
        return self.source if forward else self.target

    def _graph(self, *, forward: bool) -> Any:
        import numpy as np
        from scipy.sparse import csr_array

        if forward not in self._graphs:
            size, count = self.size, len(self.source)
            begin, end = (self.source, self.target) if forward else (self.target, self.source)
            order = np.argsort(begin, kind="stable")
            low, high = (np.searchsorted(begin[order], end, side=side) for side in ("left", "right"))
            edge = np.repeat(np.arange(count), high - low)
            rank = np.arange(len(edge)) - np.repeat(np.cumsum(high - low) - (high - low), high - low)
            following = order[np.repeat(low, high - low) + rank]
            passing = ~np.isin(end[edge], self.closed)
            edge, following = edge[passing], following[passing]
            turn = self._times(self.heading[edge] - self.heading[following])
            rows = np.concatenate([begin, size + edge])
            columns = np.concatenate([size + np.arange(count), size + following])
            values = np.concatenate([self.cost, turn + self.cost[following]])
            self._graphs[forward] = csr_array((values, (rows, columns)), shape=(size + count, size + count))
        return self._graphs[forward]


def sums_along(steps: Any, first: Any) -> Any:
    """Return the sum of `first` along each chain of `steps`; a chain ends where it leads to itself, with 0 there."""
    total = first
    while True:
        further = steps.take(steps)
        total = total + total.take(steps)
        if (further == steps).all():
            return total
        steps = further


def last_steps(steps: Any, root: int) -> Any:
    """Return the node before the root on every chain of `steps`; the node itself on chains that do not lead there."""
    import numpy as np

    last = np.where(steps == root, np.arange(len(steps)), steps)
    while True:
        further = last[last]
        if (further == last).all():
            return last
        last = further
