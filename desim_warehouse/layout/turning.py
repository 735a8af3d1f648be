"""Free driving where robots take time to turn on nodes, so that the cost of a route depends on consecutive edges.

The fastest route is therefore searched over edges, not over nodes, towards a goal or from an origin. Each step is an
edge with the turn from the edge before. The time of a route excludes turns before its first edge and after its last, as
the heading of a robot at these nodes is unknown here; `FreeTravel` adds these turns.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from desim_warehouse.layout.layout import Edge

if TYPE_CHECKING:
    import networkx as nx


def turning(highways: nx.DiGraph, edge: Edge, other: Edge) -> float:
    """Return the turn between the directions of two edges, drawn straight, in quarter turns."""
    return float(quarters(heading(highways, edge) - heading(highways, other)))


def heading(highways: nx.DiGraph, edge: Edge) -> float:
    """Return the direction of an edge, drawn straight, in radians."""
    (x0, y0), (x1, y1) = ((highways.nodes[node]["x"], highways.nodes[node]["y"]) for node in edge)
    return math.atan2(y1 - y0, x1 - x0)


def quarters(angle: Any) -> Any:
    """Return the size of a turn by an angle in radians, in quarter turns; a number or an array."""
    return abs((angle + math.pi) % (2 * math.pi) - math.pi) / (math.pi / 2)


def turn_times(quarters: Any, turn_time: float, stop_time: float) -> Any:
    """Return the times of turns, including the stops for them, by quarter turns; a number or an array."""
    return turn_time * quarters + stop_time * (quarters > 0)


class Turns:
    """The turns at all nodes of the Highways; edges are tuples of two node numbers, length, time and cost.

    No route leads through a `closed` node. Each turn costs `stop_time` in addition, as a robot stops for it.
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
        """Return the times of turns by angles in radians."""
        return turn_times(quarters(angles), self.turn_time, self.stop_time)

    def fastest(self, root: int, *, forward: bool) -> tuple[Any, Any, Any, Any]:
        """Return lengths, times, steps and costs of the routes from a node to all (`forward`), or from all to it.

        Steps are over states: the nodes, then the edges. The step of a node is the edge of its route at this node. The
        step of an edge is the next edge on the way to the root or, for the last edge, the root.
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
        """Return for every edge its node on the side of the root."""
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
    """Return the sum of `first` along each chain of `steps`; a chain ends at an entry that leads to itself, with 0."""
    total = first
    while True:
        further = steps.take(steps)
        total = total + total.take(steps)
        if (further == steps).all():
            return total
        steps = further


def last_steps(steps: Any, root: int) -> Any:
    """Return the node before the root on every chain of `steps`; the last node of a chain that does not lead there."""
    import numpy as np

    last = np.where(steps == root, np.arange(len(steps)), steps)
    while True:
        further = last[last]
        if (further == last).all():
            return last
        last = further
