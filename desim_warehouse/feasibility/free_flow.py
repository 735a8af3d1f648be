"""Free driving: how long robots of one speed take to the goods and from them, without traffic."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

from desim_warehouse.feasibility.cycle import Cycle, free_travel
from desim_warehouse.feasibility.flow_mix import FlowMix
from desim_warehouse.model.facts.demand import demand, listed
from desim_warehouse.model.facts.destinations import destinations, own_destinations
from desim_warehouse.model.facts.stations import own_times

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model

AT_ONCE = 64
"""Stations whose ways to all goods are looked up together: large floors have no memory for those of every station."""
ROWS = 4_000
"""Edges whose goods are shared among the stations together."""


class FreeFlow:
    """Driving times between nodes and the edges of the goods in demand, at one speed.

    `edges` are these edges, `share` the share of demand of each. On its edge a good is `before` the start
    and `after` the end, in time units: means over its goods, the end's node time included.
    """

    def __init__(self, model: Model, layout: Layout, speed: float, slowness: float = 0.0) -> None:
        import numpy as np

        self.model = model
        self.layout = layout
        self.stations = destinations(model, layout)
        self.own = own_destinations(model, layout)
        self.travel = free_travel(model, layout, speed, slowness)
        weights = demand(model, layout)
        self.goods = np.flatnonzero(weights)
        places = [layout.storage[good] for good in self.goods]
        self.weights = weights[self.goods]
        self.edges = list(dict.fromkeys(place.edge for place in places))
        rank = {edge: i for i, edge in enumerate(self.edges)}
        self.edge_of = np.array([rank[place.edge] for place in places])
        self.share = np.bincount(self.edge_of, self.weights, minlength=len(self.edges))
        offsets = np.array([place.offset for place in places])
        self.before, self.after = self.travel.all_along(self.edges, self.edge_of, offsets)

    def to_edges(self, nodes: Sequence[str]) -> Any:
        """Times from nodes (rows) to the starts of the edges (columns)."""
        return self.travel.to_edges(nodes, self.edges)

    @property
    def to_stations(self) -> Any:
        """Times from the ends of the edges (rows) to `stations` (columns)."""
        return self._ways[1]

    @cached_property
    def _ways(self) -> tuple[Any, Any]:
        """The mean time from each of `stations` to the edges, and the table of times from the edges to them.

        A route to a station is searched towards it, also where an edge of goods begins there: both are asked for while
        the search is kept.
        """
        import numpy as np

        travel, stations = self.travel, self.stations
        out, onward = np.zeros(len(stations)), np.empty((len(self.edges), len(stations)))
        beginning: dict[str, list[int]] = {}
        for i, edge in enumerate(self.edges):
            beginning.setdefault(edge[0] if edge[0] in travel.hubs else "", []).append(i)
        elsewhere = beginning.pop("", [])
        for first in range(0, len(stations), AT_ONCE):
            some = slice(first, first + AT_ONCE)
            onward[:, some] = travel.from_edges(self.edges, stations[some])
            out += self._mean_to([i for node in stations[some] for i in beginning.pop(node, ())], stations)
            out[some] += self._mean_to(elsewhere, stations[some])
        out += self._mean_to([i for rest in beginning.values() for i in rest], stations)
        return out, onward

    def _mean_to(self, some: list[int], nodes: Sequence[str]) -> Any:
        """The part of the mean time from each node to the edges that some of these have."""
        if not some:
            return 0.0
        return self.travel.to_edges(nodes, [self.edges[i] for i in some]) @ self.share[some]

    def station_shares(self) -> Any:
        """Which share of the goods of each edge (rows) goes to which of `stations` (columns), without queues."""
        import numpy as np

        common = self._shared_among(self.model.tasks.unload_at)
        if not any(self.own):
            return common
        by = {nodes: self._shared_among(nodes) if nodes else common for nodes in dict.fromkeys(self.own)}
        edge_of = dict(zip(self.goods.tolist(), self.edge_of.tolist(), strict=True))
        found = np.zeros_like(common)
        for good, nodes in zip(listed(self.model), self.own, strict=True):
            found[edge_of[good]] += by[nodes][edge_of[good]]
        return found / found.sum(axis=1, keepdims=True)

    def _in_parts(self) -> Iterator[tuple[slice, Any]]:
        """Some of the edges after the other with their `station_shares`: all at once would be another large table."""
        if any(self.own):
            yield slice(None), self.station_shares()
            return
        for first in range(0, len(self.edges), ROWS):
            some = slice(first, first + ROWS)
            yield some, self._shared_among(self.model.tasks.unload_at, some)

    def _shared_among(self, nodes: tuple[str, ...], some: slice = slice(None)) -> Any:
        """Which part of the goods of some edges goes to which of `stations`, if they are brought to some of these."""
        import numpy as np

        tasks = self.model.tasks
        alone = self.model.fleet.size == 1
        at = np.array([self.stations.index(node) for node in dict.fromkeys(nodes)])
        by_distance = tasks.station_choice == "nearest" or (tasks.station_choice == "least-loaded" and alone)
        if by_distance or (tasks.station_choice == "each" and nodes is not tasks.unload_at):
            nearest = at[self.to_stations[some, at].argmin(axis=1)]
            return np.equal.outer(nearest, np.arange(len(self.stations))).astype(float)
        even = np.array([nodes.count(node) / len(nodes) for node in self.stations])
        return np.broadcast_to(even, (len(self.edges[some]), len(even)))

    def cycle(self) -> Cycle:
        """The mean task, with goods in the order of demand."""
        import numpy as np

        tasks, (out, onward) = self.model.tasks, self._ways
        empty = self.station_demand() @ out + self.weights @ self.before
        times = [np.einsum("ij,ij->i", shares, onward[some]) for some, shares in self._in_parts()]
        loaded = self.share @ np.concatenate(times) + self.weights @ self.after
        stop, unload = self.travel.stop_time, self._mean_unload()
        return Cycle(float(empty) + stop, tasks.mean_load, float(loaded) + stop, unload, tasks.clear_time)

    def _mean_unload(self) -> float:
        own, usual = own_times(self.model, self.layout), self.model.tasks.mean_unload
        if not own:
            return usual
        times = [own.get(node, (None, None))[1] for node in self.stations]
        parts = zip(times, self.station_demand().tolist(), strict=True)
        return float(sum(part * (usual if time is None else time) for time, part in parts))

    def station_demand(self) -> Any:
        """Each station's share of all tasks."""
        return sum(self.share[some] @ shares for some, shares in self._in_parts())


def free_flow(model: Model, layout: Layout, speed: float, *, at_once: bool = False) -> FreeFlow | FlowMix:
    """Free driving in a model at a speed; runs of one model share it. `at_once`: starts and stops take no time."""
    return _shared(model, layout, speed, 0.0 if at_once else model.fleet.slowness)


@lru_cache(maxsize=8)
def _shared(model: Model, layout: Layout, speed: float, slowness: float) -> FreeFlow | FlowMix:
    return (FlowMix if model.tasks.flows else FreeFlow)(model, layout, speed, slowness)


def mean_task(model: Model, layout: Layout, speed: float, loaded_speed: float) -> Cycle:
    """The mean task of a robot with these speeds."""
    cycle = free_flow(model, layout, speed).cycle()
    if loaded_speed == speed:
        return cycle
    return replace(cycle, loaded=free_flow(model, layout, loaded_speed).cycle().loaded)


def least_task(model: Model, layout: Layout) -> Cycle:
    """The mean task at the fastest, where nothing is lost by starts and stops."""
    return free_flow(model, layout, model.fleet.fastest, at_once=True).cycle()
