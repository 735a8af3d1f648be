"""Free driving times of robots, along the routes that they take, with the turns at their ends."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

from desim_warehouse.layout.layout import Edge, Layout
from desim_warehouse.layout.oracle import Cost, RouteOracle
from desim_warehouse.layout.turning import heading, quarters, turn_times, turning

if TYPE_CHECKING:
    import networkx as nx


MANY = 10_000
"""Entries of a table from which on turns are computed for all at once; runs ask for smaller tables, repeatedly."""
SORTED = 5_000
"""Number of origins for which nodes are kept sorted by driving time."""


@lru_cache(maxsize=4)
def travel_on(
    layout: Layout,
    speed: float,
    node_time: float,
    cost: Cost,
    hubs: tuple[str, ...],
    turn_time: float = 0.0,
    node_times: tuple[tuple[str, float], ...] = (),
    slowness: float = 0.0,
) -> FreeTravel:
    """Return the travel times of a layout, shared by the runs of a study: they do not depend on earlier requests."""
    times = dict(node_times)
    return FreeTravel(layout.graph, speed, node_time, cost, hubs, turn_time, times, slowness)


class FreeTravel:
    """Distances and free driving times on the Highways: `distance` by the shortest route, `time` by the fastest.

    `ways` is the oracle of the routing policy in force: lengths and times along the routes that robots drive. A robot
    spends `node_time` at every node, or the node's own time in `node_times`.

    If robots accelerate and brake, `slowness` is the time that a stop costs for each unit of speed. A stop counts in
    full (`stop_time`) at every node where time is spent or a robot turns, and as a part of `half_turn` where a drive
    begins. This overestimates short drives. Slower lanes on the way are not counted.
    """

    def __init__(
        self,
        highways: nx.DiGraph,
        speed: float,
        node_time: float,
        cost: Cost = "time",
        hubs: Iterable[str] = (),
        turn_time: float = 0.0,
        node_times: Mapping[str, float] | None = None,
        slowness: float = 0.0,
    ) -> None:
        self.highways = highways
        self.speed = speed
        self.stop_time = speed * slowness
        self.node_time = self._with_stop(node_time)
        self.node_times = {node: self._with_stop(time) for node, time in (node_times or {}).items()}
        self.cost = cost
        self.hubs = frozenset(hubs)
        self.turn_time = turn_time
        self._given = node_time, node_times, slowness
        self._joints: dict[tuple[str, Edge, bool], float] = {}
        self._oracles: dict[str, RouteOracle] = {}
        self.by_time = lru_cache(SORTED)(self._by_time)

    def _with_stop(self, time: float) -> float:
        return time + self.stop_time if time else time

    def at(self, speed: float) -> FreeTravel:
        """Return the travel times of robots at another speed."""
        node_time, node_times, slowness = self._given
        ways = self.highways, speed, node_time, self.cost, (), self.turn_time, node_times, slowness
        return FreeTravel(*ways)

    def oracle(self, cost: Cost) -> RouteOracle:
        """Return the oracle of the routes that are cheapest by `cost`."""
        oracle = self._oracles.get(cost)
        if oracle is None:
            oracle = self._oracles[cost] = RouteOracle(
                self.highways,
                cost,
                self.speed,
                self.node_time,
                self.hubs,
                self.turn_time,
                self.node_times,
                self.stop_time,
            )
        return oracle

    @property
    def half_turn(self) -> float:
        """The time of the longest turn of a robot on the node where it sets out, and of stopping and starting."""
        return 2 * self.turn_time + self.stop_time

    def to_edge(self, node: str, edge: Edge) -> float:
        """Return the time from a node to the start of a good's edge, including the turn into the edge.

        For a good at a node, the time to that node.
        """
        return self.ways.time(node, edge[0]) + (self._joint(node, edge, first=False) if self.turn_time else 0.0)

    def from_edge(self, edge: Edge, node: str) -> float:
        """Return the time from the end of a good's edge to a node, including the turn out of the edge.

        From a good at a node the turn counts only if a single edge leads to that node.
        """
        return self.ways.time(edge[1], node) + (self._joint(node, edge, first=True) if self.turn_time else 0.0)

    def to_edges(self, nodes: Sequence[str], edges: Sequence[Edge]) -> Any:
        """Return `to_edge` from every node (rows) to every edge (columns)."""
        return self.between(nodes, edges)

    def between(self, origins: Sequence[Edge | str], goals: Sequence[Edge | str]) -> Any:
        """Return times from nodes and ends of goods' edges (rows) to nodes and starts of goods' edges (columns).

        The turns out of the edges and into them are included.
        """
        table = self.times(*_ends(origins, goals))
        if not (self.turn_time and table.size):
            return table
        if table.size <= MANY:
            return table + [[self._turn(origin, goal) for goal in goals] for origin in origins]
        return table + self._turns(origins, goals, table)

    def _turn(self, origin: Edge | str, goal: Edge | str) -> float:
        """Return the time of the turns between a route and the edges at which it begins and ends."""
        if isinstance(origin, str):
            return 0.0 if isinstance(goal, str) else self._joint(origin, goal, first=False)
        if isinstance(goal, str):
            return self._joint(goal, origin, first=True)
        if origin[1] == goal[0] and origin[0] != origin[1] and goal[0] != goal[1]:
            return float(turn_times(turning(self.highways, origin, goal), self.turn_time, self.stop_time))
        return self._joint(goal[0], origin, first=True) + self._joint(origin[1], goal, first=False)

    def _turns(self, origins: Sequence[Edge | str], goals: Sequence[Edge | str], times: Any) -> Any:
        """Return `_turn` from every origin (rows) to every goal (columns); `times` is inf where there is no route."""
        import numpy as np

        ways, places = self.ways, self.highways.nodes
        starts, ends = _ends(origins, goals)
        points = np.array([complex(places[name]["x"], places[name]["y"]) for name in ways.names])
        start, end = (points[[ways.index[name] for name in names]] for names in (starts, ends))
        second, last = (points[nodes] for nodes in ways.beside_all(starts, ends))
        before, after = (
            np.array([np.nan if edge is None else heading(self.highways, edge) for edge in edges])
            for edges in ([_edge_to(self.highways, place) for place in origins], [_edge_from(place) for place in goals])
        )
        is_edge = np.array([_edge_from(origin) is not None for origin in origins])
        meets = np.equal.outer(np.array(starts, dtype=object), np.array(ends, dtype=object))
        drives = ~meets & np.isfinite(times)
        turns = (
            np.where(drives, before[:, None] - np.angle(second - start[:, None]), np.nan),
            np.where(drives, np.angle(end - last) - after, np.nan),
            np.where(meets & is_edge[:, None], before[:, None] - after, np.nan),
        )
        return sum(turn_times(np.nan_to_num(quarters(turn)), self.turn_time, self.stop_time) for turn in turns)

    def _joint(self, node: str, edge: Edge, *, first: bool) -> float:
        """Return the time of the turn between an edge and a route: from the edge (`first`), or to it."""
        key = node, edge, first
        if key not in self._joints:
            quarters = self._quarters(node, edge, first=first)
            self._joints[key] = float(turn_times(quarters, self.turn_time, self.stop_time))
        return self._joints[key]

    def _quarters(self, node: str, edge: Edge, *, first: bool) -> float:
        end = edge[1] if first else edge[0]
        if node == end or math.isinf(self.ways.time(*((end, node) if first else (node, end)))):
            return 0.0
        beside = _edge_to(self.highways, edge) if first else _edge_from(edge)
        if beside is None:
            return 0.0
        second, last = self.ways.beside(*((end, node) if first else (node, end)))
        return turning(self.highways, beside, (end, second) if first else (last, end))

    def along(self, edge: tuple[str, str], offset: float) -> tuple[float, float]:
        """Return the times from the start of a good's edge to the good, and on to the edge's end with its node time."""
        if edge[0] == edge[1]:
            return 0.0, 0.0
        data = self.highways.edges[edge]
        pace = min(self.speed, data["speed"])
        return offset / pace, (data["length"] - offset) / pace + self.time_at(edge[1])

    def time_at(self, node: str) -> float:
        """Return the time that a robot spends at a node that it reaches."""
        return self.node_times.get(node, self.node_time)

    @cached_property
    def ways(self) -> RouteOracle:
        """The oracle of the routes that robots drive."""
        return self.oracle(self.cost)

    def distance(self, origin: str, goal: str) -> float:
        """Return the length of the shortest route."""
        return self.oracle("length").length(origin, goal)

    def time(self, origin: str, goal: str) -> float:
        """Return the free driving time of the fastest route: node times and speed limits count, waiting does not."""
        return self.oracle("time").time(origin, goal)

    def _by_time(self, origin: str, nodes: tuple[str, ...]) -> tuple[str, ...]:
        """Sort nodes by driving time from `origin`, the nearest first; ties keep their order."""
        times = self.times([origin], nodes)[0]
        return tuple(nodes[i] for i in times.argsort(kind="stable").tolist())

    def way(self, origin: str, goal: str) -> list[str]:
        """Return the nodes of the route that a robot drives, both ends included."""
        return self.ways.way(origin, goal)

    def times(self, origins: Sequence[str], goals: Sequence[str]) -> Any:
        """Return free driving times of the routes that robots drive: one row per origin, one column per goal."""
        return self.ways.matrix(origins, goals, "time")

    def lengths(self, origins: Sequence[str], goals: Sequence[str]) -> Any:
        """Return lengths of the routes that robots drive: one row per origin, one column per goal."""
        return self.ways.matrix(origins, goals, "length")


def _ends(origins: Iterable[Edge | str], goals: Iterable[Edge | str]) -> tuple[list[str], list[str]]:
    """Return the nodes at which routes begin and end: ends of the goods' edges at origins, starts of them at goals."""
    return (
        [origin if isinstance(origin, str) else origin[1] for origin in origins],
        [goal if isinstance(goal, str) else goal[0] for goal in goals],
    )


def _edge_to(highways: nx.DiGraph, place: Edge | str) -> Edge | None:
    """Return the edge by which a robot came to the end of a place; None for a node.

    It is the good's edge, or for a good at a node the only edge that leads there, None if there are several.
    """
    if isinstance(place, str) or place[0] != place[1]:
        return None if isinstance(place, str) else place
    before = list(highways.predecessors(place[1]))
    return (before[0], place[1]) if len(before) == 1 else None


def _edge_from(place: Edge | str) -> Edge | None:
    """Return the edge onto which a robot drives from a place; None for a node and for a good at a node."""
    return None if isinstance(place, str) or place[0] == place[1] else place
