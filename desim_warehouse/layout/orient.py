"""Orientation of two-way lanes wherever the floor stays connected: Highways from a plan without directions.

A lane can be made one-way unless it is a bridge (Robbins 1939; with additional one-way edges: Boesch and Tindell 1980,
who also show that lanes may be oriented one by one in any order). A good choice of directions is another matter: here
parallel aisles alternate at first, and a local search improves on them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from desim_warehouse.layout.layout import Edge

if TYPE_CHECKING:
    import networkx as nx
    from scipy.sparse import csr_array

_TRIALS = 2000
_HUBS, _TRIPS = 32, 200_000
"""On a large floor, the least number of hubs from which trips are measured, and the number of such trips."""
_WORK = 200_000_000
"""Largest product of nodes, hubs and trials: about a minute."""
_ALL, _ANNEALED = 16, 500
"""The most lanes for which all orientations are compared, and the most for which simulated annealing is used."""
_COOLING, _HEAT, _COLD, _AISLES = 4, 0.01, 0.01, 0.2
"""Parameters of annealing: its trials as a multiple of the descent's, the first temperature as a share of the mean
trip, the last as a share of the first, and the share of trials that turn a whole aisle.
"""
_SAME = 1e-9
"""Relative difference below which a mean trip does not count as shorter."""

_AS_LISTED, _TURNED, _BOTH = 1, 2, 3
"""The open directions of a lane: as listed, the opposite one, or both; bits, so that they can be masked."""


@dataclass(frozen=True)
class Orientation:
    """The direction that each two-way lane keeps (`kept`), and the `bridges`, which stay two-way.

    `stretch`: the mean trip between the ends of flows, divided by the mean trip on the two-way floor. If there are more
    than about 200,000 such trips, both are estimated from a sample of hubs.
    """

    kept: tuple[Edge, ...]
    bridges: tuple[Edge, ...]
    stretch: float


def orient_lanes(
    graph: nx.DiGraph,
    lanes: Sequence[Edge],
    ends: Mapping[str, float],
    hubs: Sequence[str],
    cost: Callable[[Edge], float],
    trials: int = _TRIALS,
) -> Orientation:
    """Choose directions for two-way `lanes` of a strongly connected digraph with node coordinates x and y.

    The directions keep trips short between `hubs` (stations) and `ends` (nodes of goods, by weight); `cost` returns the
    time on an edge. The search starts from each of the four ways in which directions of parallel aisles can alternate,
    and improves the best by turning whole aisles, then single lanes, while the mean trip gets shorter and the floor
    stays strongly connected. With up to 16 free lanes all orientations are compared instead, and with up to 500
    simulated annealing goes on from there. `trials` limits the number of turns that are tried; large floors get fewer.
    The result is deterministic.
    """
    most = max(_HUBS, _TRIPS // len(graph))
    if len(hubs) > most:
        hubs = [hubs[rank] for rank in sorted(np.random.default_rng(0).choice(len(hubs), most, replace=False))]
    floor = _Floor(graph, lanes, ends, hubs, cost)
    trials = min(trials, _WORK // (len(graph) * len(hubs)))
    before = floor.mean_trip()
    aisles = Aisles.of(graph, lanes)
    starts = [floor.oriented(aisles.alternating(*first)) for first in itertools.product((0, 1), (0, 1))]
    best = floor.best(min(starts, key=floor.mean_trip_of), aisles.groups(), trials)
    kept, bridges = [], []
    for lane, way in zip(lanes, best, strict=True):
        if way == _BOTH:
            bridges.append(lane)
        else:
            kept.append(lane if way == _AS_LISTED else lane[::-1])
    return Orientation(tuple(kept), tuple(bridges), floor.mean_trip_of(best) / before)


class _Floor:
    """The edges of a floor as arrays; an orientation leaves one of the two edges of each lane."""

    def __init__(
        self,
        graph: nx.DiGraph,
        lanes: Sequence[Edge],
        ends: Mapping[str, float],
        hubs: Sequence[str],
        cost: Callable[[Edge], float],
    ) -> None:
        rank = {node: number for number, node in enumerate(graph)}
        twins = {edge for lane in lanes for edge in (lane, lane[::-1])}
        arcs = [*lanes, *(lane[::-1] for lane in lanes), *(edge for edge in graph.edges if edge not in twins)]
        self.size = len(rank)
        self.lanes = len(lanes)
        self.tails = np.array([rank[tail] for tail, _ in arcs], dtype=np.int32)
        self.heads = np.array([rank[head] for _, head in arcs], dtype=np.int32)
        self.costs = np.array([cost(arc) for arc in arcs])
        self.hubs = np.array([rank[node] for node in hubs], dtype=np.int32)
        self.ends = np.array([rank[node] for node in ends], dtype=np.int32)
        weights = np.array(list(ends.values()), dtype=float)
        self.weights = weights / weights.sum()

    def network(self, ways: np.ndarray) -> csr_array:
        """Return the open edges as a sparse matrix of costs."""
        from scipy.sparse import csr_array

        is_open = np.ones(len(self.tails), dtype=bool)
        is_open[: self.lanes] = ways & _AS_LISTED
        is_open[self.lanes : 2 * self.lanes] = ways & _TURNED
        pairs = self.tails[is_open], self.heads[is_open]
        return csr_array((self.costs[is_open], pairs), shape=(self.size, self.size))

    def mean_trip(self) -> float:
        """Return the mean trip on the floor with all lanes two-way."""
        return self.mean_trip_of(np.full(self.lanes, _BOTH))

    def mean_trip_of(self, ways: np.ndarray) -> float:
        """Return the mean cost from a hub to an end and back; inf if the floor is not strongly connected."""
        from scipy.sparse.csgraph import dijkstra

        network = self.network(ways)
        total = 0.0
        for graph in (network, network.T.tocsr()):
            distances = dijkstra(graph, indices=self.hubs)
            if not np.isfinite(distances).all():
                return np.inf
            total += float(distances[:, self.ends].mean(axis=0) @ self.weights)
        return total

    def oriented(self, preferred: np.ndarray) -> np.ndarray:
        """Return for each lane the directions left open after closing every direction that the floor can do without.

        At first all lanes are as preferred. Lanes between parts that this cuts off from each other become two-way
        again, and are decided one by one: on a grid a few of many thousand.
        """
        from scipy.sparse.csgraph import connected_components

        _, part = connected_components(self.network(preferred), connection="strong")
        apart = np.flatnonzero(part[self.tails[: self.lanes]] != part[self.heads[: self.lanes]])
        ways = preferred.copy()
        ways[apart] = _BOTH
        onward: list[set[int]] = [set() for _ in range(self.size)]
        open_arcs = self.network(ways).tocoo()
        for tail, head in zip(open_arcs.row.tolist(), open_arcs.col.tolist(), strict=True):
            onward[tail].add(head)
        for lane in apart.tolist():
            ends = int(self.tails[lane]), int(self.heads[lane])
            for way in (preferred[lane], preferred[lane] ^ _BOTH):
                tail, head = ends[::-1] if way == _AS_LISTED else ends  # ends of the direction to close
                onward[tail].discard(head)
                if _reaches(onward, tail, head):
                    ways[lane] = way
                    break
                onward[tail].add(head)
        return ways

    def best(self, ways: np.ndarray, aisles: Sequence[Sequence[int]], trials: int) -> np.ndarray:
        """Return the best orientation reached from a given one; on a small floor the best of all."""
        free = np.flatnonzero(ways != _BOTH)
        if len(free) <= _ALL:
            return self._shortest(ways, free)
        ways = self.improved(ways, aisles, trials)
        if len(free) > _ANNEALED:
            return ways
        return self.improved(self._annealed(ways, free, aisles, _COOLING * trials), aisles, trials)

    def _shortest(self, ways: np.ndarray, free: np.ndarray) -> np.ndarray:
        """Return the orientation with the shortest mean trip, of all orientations of the `free` lanes."""
        shortest, best = ways, self.mean_trip_of(ways)
        turned = (np.arange(2 ** len(free))[:, None] >> np.arange(len(free)) & 1).astype(bool)
        for turns in turned[self._without_dead_ends(ways, free, turned)]:
            other = ways.copy()
            other[free] = np.where(turns, _TURNED, _AS_LISTED)
            mean = self.mean_trip_of(other) if self._is_connected(other) else np.inf
            if mean < best * (1 - _SAME):
                shortest, best = other, mean
        return shortest

    def _without_dead_ends(self, ways: np.ndarray, free: np.ndarray, turned: np.ndarray) -> np.ndarray:
        """Return which rows of `turned` leave every node a way in and a way out: a quick filter of many thousands."""
        others = ways.copy()
        others[free] = 0
        fixed = self.network(others)
        has_in, has_out = (np.asarray(fixed.sum(axis=axis)).ravel() > 0 for axis in (0, 1))
        has_none = np.ones(len(turned), dtype=bool)
        for node in range(self.size):
            begins, ends = self.tails[free] == node, self.heads[free] == node
            if not has_out[node]:
                has_none &= (~turned[:, begins]).any(axis=1) | turned[:, ends].any(axis=1)
            if not has_in[node]:
                has_none &= turned[:, begins].any(axis=1) | (~turned[:, ends]).any(axis=1)
        return has_none

    def _annealed(self, ways: np.ndarray, free: np.ndarray, aisles: Sequence[Sequence[int]], trials: int) -> np.ndarray:
        """Return an orientation with a short mean trip, found by simulated annealing: random aisles and lanes turn.

        Source: Kirkpatrick, Gelatt and Vecchi (1983).
        """
        random = np.random.default_rng(0)
        groups = [[lane for lane in group if ways[lane] != _BOTH] for group in aisles]
        groups = [group for group in groups if len(group) > 1]
        shortest, ways = ways.copy(), ways.copy()
        now = best = self.mean_trip_of(ways)
        for heat in best * _HEAT * np.geomspace(1, _COLD, trials):
            is_aisle = groups and random.random() < _AISLES
            lanes = groups[random.integers(len(groups))] if is_aisle else [random.choice(free)]
            ways[lanes] ^= _BOTH
            mean = self.mean_trip_of(ways) if self._is_connected(ways) else np.inf
            if mean < now or random.random() < np.exp((now - mean) / heat):
                now = mean
                if now < best * (1 - _SAME):
                    shortest, best = ways.copy(), now
            else:
                ways[lanes] ^= _BOTH
        return shortest

    def _is_connected(self, ways: np.ndarray) -> bool:
        """Whether the floor is strongly connected; checked first, as it is cheaper than an infinite mean trip."""
        from scipy.sparse.csgraph import connected_components

        parts, _ = connected_components(self.network(ways), connection="strong")
        return bool(parts == 1)

    def improved(self, ways: np.ndarray, aisles: Sequence[Sequence[int]], trials: int) -> np.ndarray:
        """Turn whole aisles, then single lanes, one at a time, as long as the mean trip gets shorter."""
        best = self.mean_trip_of(ways)
        for groups in (aisles, [[lane] for lane in range(self.lanes)]):
            waiting = list(groups)
            while waiting and trials:
                is_shorter = False
                for group in waiting:
                    if not trials:
                        break
                    lanes = [lane for lane in group if ways[lane] != _BOTH]
                    if not lanes:
                        continue
                    trials -= 1
                    ways[lanes] ^= _BOTH
                    mean = self.mean_trip_of(ways)
                    if mean < best * (1 - _SAME):
                        best, is_shorter = mean, True
                    else:
                        ways[lanes] ^= _BOTH
                if not is_shorter:
                    break
        return ways


def _reaches(onward: Sequence[set[int]], start: int, goal: int) -> bool:
    """Return whether there is a path from one node to another."""
    seen, layer = {start}, [start]
    while layer:
        following = set().union(*(onward[node] for node in layer)) - seen
        if goal in following:
            return True
        seen |= following
        layer = list(following)
    return False


@dataclass(frozen=True)
class Aisles:
    """The aisle of each lane: its axis, its rank among parallel aisles, and the lane's direction along the axis.

    Lanes along x whose centres have about equal y, within half the median length of such lanes, are one aisle.
    `upwards`: the lane, as listed, leads towards larger x or y.
    """

    along_x: np.ndarray
    rank: np.ndarray
    upwards: np.ndarray

    @classmethod
    def of(cls, graph: nx.DiGraph, lanes: Sequence[Edge]) -> Aisles:
        """Return the aisles of a floor."""
        points = {node: (data["x"], data["y"]) for node, data in graph.nodes(data=True)}
        tails = np.array([points[tail] for tail, _ in lanes], dtype=float).reshape(-1, 2)
        heads = np.array([points[head] for _, head in lanes], dtype=float).reshape(-1, 2)
        spans, middles = heads - tails, (heads + tails) / 2
        along_x = np.abs(spans[:, 0]) >= np.abs(spans[:, 1])
        rank = np.zeros(len(lanes), dtype=int)
        for axis in (0, 1):
            numbers = np.flatnonzero(along_x == (axis == 0))
            if len(numbers):
                across = middles[numbers, 1 - axis]
                order = np.argsort(across, kind="stable")
                gap = np.median(np.abs(spans[numbers, axis])) / 2
                rank[numbers[order]] = np.cumsum(np.diff(across[order], prepend=across[order[0]]) > gap)
        return cls(along_x, rank, np.where(along_x, spans[:, 0], spans[:, 1]) >= 0)

    def alternating(self, rows: int, columns: int) -> np.ndarray:
        """Return an orientation whose directions alternate from aisle to aisle, beginning upwards where 0 is given.

        `rows` and `columns`: 0 if the first aisle along x, or along y, leads upwards; 1 if downwards.
        """
        is_up = (self.rank + np.where(self.along_x, rows, columns)) % 2 == 0
        return np.where(is_up == self.upwards, _AS_LISTED, _TURNED)

    def groups(self) -> list[list[int]]:
        """Return the lanes of every aisle."""
        lanes_by_aisle: dict[tuple[bool, int], list[int]] = {}
        for lane, aisle in enumerate(zip(self.along_x.tolist(), self.rank.tolist(), strict=True)):
            lanes_by_aisle.setdefault(aisle, []).append(lane)
        return list(lanes_by_aisle.values())
