"""Free driving: how long robots of one speed take to goods, between places of flows and to stations, without traffic.

Of more than `POINTS` places of a flow a systematic sample stands for all.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from desim_warehouse.model.facts.ahead import free_travel, handling_of
from desim_warehouse.model.facts.demand import demand, flow_rates
from desim_warehouse.model.facts.places import destinations, place_shares
from desim_warehouse.model.sections.flows import StorageEnd

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from desim_warehouse.layout import Layout
    from desim_warehouse.layout.layout import Edge
    from desim_warehouse.model import Model
    from desim_warehouse.model.sections.flows import FlowSpec, Route

AT_ONCE = 8
"""Stations whose ways to all goods are looked up together."""
POINTS = 300


class FreeFlow:
    """Driving times between nodes and the edges of the goods in demand, at one speed.

    `edges` are these edges. On its edge a good is `before` the start and `after` the end, in time units, the end's node
    time included.
    """

    def __init__(self, model: Model, layout: Layout, speed: float, *, at_once: bool) -> None:
        import numpy as np

        self.stations = destinations(model, layout)
        self.travel = free_travel(model, layout, speed, at_once=at_once, estimate=True)
        self.goods = np.flatnonzero(demand(model, layout))
        places = [layout.storage[good] for good in self.goods]
        self.edges = list(dict.fromkeys(place.edge for place in places))
        rank = {edge: i for i, edge in enumerate(self.edges)}
        self.edge_of = np.array([rank[place.edge] for place in places])
        self.before, self.after = self.travel.all_along(
            self.edges, self.edge_of, np.array([place.offset for place in places])
        )

    def to_edges(self, nodes: Sequence[str]) -> Any:
        """Times from nodes (rows) to the starts of the edges (columns)."""
        return self.travel.to_edges(nodes, self.edges)

    def least_onward(self, rate: float, beyond: Sequence[float]) -> Any:
        """From the end of each edge by the cheapest of `stations`: `rate` for each time unit there, and then `beyond`.

        A few stations at a time, as large floors have no memory for the ways to all of them.
        """
        import numpy as np

        least = np.full(len(self.edges), np.inf)
        for first in range(0, len(self.stations), AT_ONCE):
            some = slice(first, first + AT_ONCE)
            costs = rate * self.travel.from_edges(self.edges, self.stations[some]) + np.asarray(beyond[some])
            np.minimum(least, costs.min(axis=1), out=least)
        return least


@dataclass(frozen=True)
class Points:
    """Where tasks begin or end: the nodes of stations, or the edges of storage places.

    `before` and `after` are the times from an edge's start to the place and from there to its end; `weights` add up
    to 1.
    """

    places: Sequence[Edge | str]
    before: Any
    after: Any
    weights: Any


@dataclass(frozen=True)
class Leg:
    """The drives with a load on one route of a flow: `share` is its part of all tasks, `times` of pick by drop."""

    flow: str
    route: Route
    share: float
    picks: Points
    drops: Points
    times: Any


class FlowMix:
    """What the flows of a model come to in free flow, at one speed."""

    def __init__(self, model: Model, layout: Layout, speed: float, *, at_once: bool) -> None:
        self.model = model
        self.layout = layout
        self.stations = destinations(model, layout)
        self.travel = free_travel(model, layout, speed, at_once=at_once, estimate=True)
        self.stops = handling_of(model, layout).means()
        self.rates = flow_rates(model)
        self.legs = list(self._legs())

    def to_edges(self, nodes: Sequence[str]) -> Any:
        """Times from nodes (rows) to all places where tasks are picked (columns)."""
        return self.travel.between(nodes, list(dict.fromkeys(at for leg in self.legs for at in leg.picks.places)))

    def least_handling(self, leg: Leg) -> float:
        """The mean handling of a task of a leg at those of its stations that are quickest."""
        at_stop, flow = self.stops.at_stop, leg.flow
        return (
            self.handling(flow)[2]
            + min(at_stop("load", flow, place if isinstance(place, str) else None) for place in leg.picks.places)
            + min(at_stop("unload", flow, place if isinstance(place, str) else None) for place in leg.drops.places)
        )

    def handling(self, flow: str) -> tuple[float, float, float]:
        """The mean times of loading and unloading a task of a flow, and of all its stops on the way."""
        at_stop, visits = self.stops.at_stop, len(self.model.tasks.flows[flow].via)
        return at_stop("load", flow), at_stop("unload", flow), visits * at_stop("visit", flow)

    def _legs(self) -> Iterator[Leg]:
        total = sum(self.rates.values())
        for name, flow in self.model.tasks.flows.items():
            for route in flow.routes:
                picks, drops = self._points(route.source), self._points(route.target)
                times = self._times(flow, picks, drops)
                yield Leg(name, route, self.rates[name] / total * route.share, picks, drops, times)

    def sides(self, leg: Leg) -> list[Leg]:
        """A leg, and where its picks or drops are on two-way lanes the same with these come to from the other end."""
        flow = self.model.tasks.flows[leg.flow]
        return [
            replace(leg, picks=picks, drops=drops, times=self._times(flow, picks, drops))
            for picks in self._both_ways(leg.picks)
            for drops in self._both_ways(leg.drops)
        ]

    def _both_ways(self, points: Points) -> list[Points]:
        """Places come to by the edges that the model names, and by those back, where there are any of two-way lanes."""
        import numpy as np

        two_way = {edge for lane in self.layout.two_way for edge in (lane, lane[::-1])}
        if two_way.isdisjoint(points.places):
            return [points]
        at = self.travel.time_at
        rows = [
            (place[::-1], after - at(place[1]), before + at(place[0])) if place in two_way else (place, before, after)
            for place, before, after in zip(points.places, points.before, points.after, strict=True)
        ]
        places, before, after = zip(*rows, strict=True)
        return [points, replace(points, places=places, before=np.array(before), after=np.array(after))]

    def _times(self, flow: FlowSpec, picks: Points, drops: Points) -> Any:
        """The times from each pick to each drop, by the nearest of the stops on the way."""
        at, times = picks.places, picks.after
        for name in flow.via:
            nodes = self.layout.nodes_of(name)
            table = self.travel.between(at, nodes)
            nearest = table.argmin(axis=1)
            times = times + table.min(axis=1)
            at = [nodes[i] for i in nearest]
        return self.travel.between(at, drops.places) + times[:, None] + drops.before

    def _points(self, places: StorageEnd | tuple[str, ...]) -> Points:
        import numpy as np

        if not isinstance(places, StorageEnd):
            nodes, none = list(places), np.zeros(len(places))
            return Points(nodes, none, none, np.full(len(nodes), 1 / len(nodes)))
        storage = self.layout.storage
        weights = place_shares(self.model, self.layout, places)
        weights = np.full(len(storage), 1 / len(storage)) if weights is None else weights
        there = np.flatnonzero(weights)
        weights = weights[there]
        if len(there) > POINTS:
            at = np.searchsorted(np.cumsum(weights), (np.arange(POINTS) + 0.5) / POINTS * weights.sum())
            there, weights = there[np.minimum(at, len(there) - 1)], np.full(POINTS, 1 / POINTS)
        some = [storage[number] for number in there]
        times = [self.travel.along(place.edge, place.offset) for place in some]
        before, after = (np.array(part) for part in zip(*times, strict=True))
        return Points([place.edge for place in some], before, after, weights)


@lru_cache(maxsize=8)
def free_flow(model: Model, layout: Layout, speed: float, *, at_once: bool = False) -> FreeFlow | FlowMix:
    """Free driving in a model at a speed; runs of one model share it. `at_once`: starts and stops take no time."""
    return (FlowMix if model.tasks.flows else FreeFlow)(model, layout, speed, at_once=at_once)
