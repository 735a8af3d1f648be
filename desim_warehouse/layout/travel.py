"""The distance oracle: directed distances and times between nodes, worked out when asked for.

One Dijkstra (scipy.sparse.csgraph) per goal on the reversed Highways, kept for the goals used last; so memory
stays within `keep` rows of one number a node, also on layouts of 10,000 nodes.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    import networkx as nx


class Oracle:
    """Costs of the cheapest ways on the Highways, for one cost of an edge."""

    def __init__(self, highways: nx.DiGraph, cost: Callable[[dict[str, float]], float], keep: int = 2000) -> None:
        import numpy as np
        from scipy.sparse import csr_array

        self.names = list(highways)
        self.index = {name: i for i, name in enumerate(self.names)}
        edges = list(highways.edges(data=True))
        rows = [self.index[target] for _, target, _ in edges]
        columns = [self.index[source] for source, _, _ in edges]
        size = len(self.names)
        self._reversed = csr_array(
            (np.array([cost(data) for _, _, data in edges]), (rows, columns)), shape=(size, size)
        )
        self._keep = keep
        self._rows: OrderedDict[str, tuple[Any, Any]] = OrderedDict()

    def _towards(self, goal: str) -> tuple[Any, Any]:
        row = self._rows.get(goal)
        if row is None:
            from array import array

            from scipy.sparse.csgraph import dijkstra

            costs, nexts = dijkstra(self._reversed, indices=self.index[goal], return_predecessors=True)
            row = array("d", costs.tobytes()), array("i", nexts.astype("int32").tobytes())
            self._rows[goal] = row
            if len(self._rows) > self._keep:
                self._rows.popitem(last=False)
        else:
            self._rows.move_to_end(goal)
        return row

    def cost(self, origin: str, goal: str) -> float:
        """Cost of the cheapest way; inf where there is none."""
        return float(self._towards(goal)[0][self.index[origin]])

    def way(self, origin: str, goal: str) -> list[str]:
        """Nodes of the cheapest way, both ends included; empty where there is none."""
        costs, nexts = self._towards(goal)
        i, last = self.index[origin], self.index[goal]
        if math.isinf(costs[i]):
            return []
        way = [origin]
        while i != last:
            i = nexts[i]
            way.append(self.names[i])
        return way


class Travel:
    """Distances by the shortest way, times by the fastest (edge speed limits and node times included)."""

    def __init__(self, highways: nx.DiGraph, speed: float, node_time: float) -> None:
        self._highways = highways
        self._speed = speed
        self._node_time = node_time
        self._lengths: Oracle | None = None
        self._times: Oracle | None = None

    @property
    def lengths(self) -> Oracle:
        """The oracle of lengths."""
        if self._lengths is None:
            self._lengths = Oracle(self._highways, lambda edge: edge["length"])
        return self._lengths

    @property
    def times(self) -> Oracle:
        """The oracle of free driving times."""
        if self._times is None:
            speed, pause = self._speed, self._node_time
            self._times = Oracle(self._highways, lambda edge: edge["length"] / min(speed, edge["speed"]) + pause)
        return self._times

    def distance(self, origin: str, goal: str) -> float:
        """Length of the shortest way."""
        return self.lengths.cost(origin, goal)

    def time(self, origin: str, goal: str) -> float:
        """Time of the fastest way: node times and speed limits included, waiting not."""
        return self.times.cost(origin, goal)
