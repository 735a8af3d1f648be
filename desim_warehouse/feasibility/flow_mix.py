"""Free driving where the work is flows: from many kinds of places to many others, at one speed.

Flows that are always open take what time is left, so their tasks are not in the mean task unless there are no others.
Of more than `POINTS` places a systematic sample stands for all.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from desim_warehouse.feasibility.cycle import Cycle, free_travel
from desim_warehouse.model.facts.demand import flow_rates
from desim_warehouse.model.facts.destinations import destinations
from desim_warehouse.model.facts.places import place_shares
from desim_warehouse.model.facts.stations import flow_times, own_times
from desim_warehouse.model.sections.flows import StorageEnd
from desim_warehouse.values.distributions import mean_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from desim_warehouse.layout import Layout
    from desim_warehouse.layout.layout import Edge
    from desim_warehouse.model import Model
    from desim_warehouse.model.sections.flows import FlowSpec, Route

POINTS = 300
LOAD, UNLOAD = 0, 1


@dataclass(frozen=True)
class Points:
    """Where tasks begin or end: the nodes of stations, or the edges of storage places.

    `before` and `after` are the times from an edge's start to the place and from there to its end; `weights` add up
    to 1. `names` tell one from another; nan: each stands for several places.
    """

    names: Any
    places: Sequence[Edge | str]
    before: Any
    after: Any
    weights: Any


@dataclass(frozen=True)
class Leg:
    """The drives with a load on one route of a flow: `share` is its part of all tasks, `times` of pick by drop.

    `of` is the part of the pairs of pick and drop, `stops` how often a task stops at a node on its way.
    """

    flow: str
    route: Route
    share: float
    picks: Points
    drops: Points
    times: Any
    of: Any
    stops: Mapping[str, float]


class FlowMix:
    """What the flows of a model come to in free flow, at one speed."""

    def __init__(self, model: Model, layout: Layout, speed: float, slowness: float = 0.0) -> None:
        self.model = model
        self.layout = layout
        self.stations = destinations(model, layout)
        self.travel = free_travel(model, layout, speed, slowness)
        self.own = own_times(model, layout)
        self.rates = flow_rates(model)
        self.legs = list(self._legs())

    def cycle(self) -> Cycle:
        """The mean task, tasks taken as they come."""
        import numpy as np

        legs = [leg for leg in self.legs if leg.share]
        picks = [place for leg in legs for place in leg.picks.places]
        drops = [place for leg in legs for place in leg.drops.places]
        to = np.concatenate([leg.share * leg.picks.weights for leg in legs])
        ends = [leg.share * leg.of.sum(axis=0) for leg in legs]
        empty = np.concatenate(ends) @ self.travel.between(drops, picks) @ to
        empty += sum(leg.share * (leg.picks.weights @ leg.picks.before) for leg in legs)
        empty += sum(end @ leg.drops.after for leg, end in zip(legs, ends, strict=True))
        loaded = sum(leg.share * (leg.of * leg.times).sum() for leg in legs)
        load, unload, visits = (sum(leg.share * self._handled(leg)[i] for leg in legs) for i in (0, 1, 2))
        stop = self.travel.stop_time
        stops = stop * (1 + sum(leg.share * sum(leg.stops.values()) for leg in legs))
        clear = self.model.tasks.clear_time
        return Cycle(float(empty) + stop, float(load), float(loaded) + stops, float(unload + visits), clear)

    def to_edges(self, nodes: Sequence[str]) -> Any:
        """Times from nodes (rows) to all places where tasks are picked (columns)."""
        return self.travel.between(nodes, list(dict.fromkeys(at for leg in self.legs for at in leg.picks.places)))

    def _handled(self, leg: Leg) -> tuple[float, float, float]:
        """As `handling`, with the times of stations that have their own."""
        load, unload, visits = self.handling(leg.flow)
        if self.own:
            picks, drops = leg.picks, leg.drops
            load = sum(
                part * self._at(place, LOAD, load) for place, part in zip(picks.places, picks.weights, strict=True)
            )
            unload = sum(
                part * self._at(place, UNLOAD, unload)
                for place, part in zip(drops.places, leg.of.sum(axis=0), strict=True)
            )
        return load, unload, visits

    def _at(self, place: Edge | str, which: int, usual: float) -> float:
        """The mean time of loading or unloading (`which`) where tasks begin or end."""
        own = self.own.get(place, (None, None))[which] if isinstance(place, str) else None
        return usual if own is None else own

    def least_handling(self, leg: Leg) -> float:
        """The mean handling of a task of a leg at those of its stations that are quickest."""
        load, unload, visits = self.handling(leg.flow)
        return (
            visits
            + min(self._at(place, LOAD, load) for place in leg.picks.places)
            + min(self._at(place, UNLOAD, unload) for place in leg.drops.places)
        )

    def handling(self, flow: str) -> tuple[float, float, float]:
        """The mean times of loading and unloading a task of a flow, and of all its stops on the way."""
        spec = self.model.tasks.flows[flow]
        return (*flow_times(self.model.tasks, spec), len(spec.via) * mean_of(spec.stop_time))

    def _legs(self) -> Iterator[Leg]:
        import numpy as np

        total = sum(self.rates.values())
        for name, flow in self.model.tasks.flows.items():
            for route in flow.routes:
                picks, drops = self._points(route.source), self._points(route.target)
                times, stops = self._times(flow, picks, drops)
                to = _other_places(picks, drops)
                if not isinstance(route.target, StorageEnd) and self.model.tasks.station_choice in {"each", "nearest"}:
                    to = np.eye(len(drops.places))[np.where(to > 0, times, np.inf).argmin(axis=1)]
                of = picks.weights[:, None] * to
                yield Leg(name, route, self.rates[name] / total * route.share, picks, drops, times, of, stops)

    def sides(self, leg: Leg) -> list[Leg]:
        """A leg, and where its picks or drops are on two-way lanes the same with these come to from the other end."""
        flow = self.model.tasks.flows[leg.flow]
        return [
            replace(leg, picks=picks, drops=drops, times=self._times(flow, picks, drops)[0])
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

    def _times(self, flow: FlowSpec, picks: Points, drops: Points) -> tuple[Any, dict[str, float]]:
        """The times from each pick to each drop, and at which nodes a task stops on its way, how often."""
        at, after, stops = self._over(flow, picks)
        return self.travel.between(at, drops.places) + after[:, None] + drops.before, stops

    def _over(self, flow: FlowSpec, picks: Points) -> tuple[Sequence[Edge | str], Any, dict[str, float]]:
        """Where a task from each place goes on to its end, the time until then, and at which nodes it stopped."""
        import numpy as np

        at, times, stops = picks.places, picks.after, defaultdict[str, float](float)
        for name in flow.via:
            nodes = self.layout.nodes_of(name)
            table = self.travel.between(at, nodes)
            nearest = table.argmin(axis=1)
            times = times + table[np.arange(len(at)), nearest]
            at = [nodes[i] for i in nearest]
            for i, part in zip(nearest, picks.weights, strict=True):
                stops[nodes[i]] += float(part)
        return at, times, dict(stops)

    def _points(self, places: StorageEnd | tuple[str, ...]) -> Points:
        import numpy as np

        if not isinstance(places, StorageEnd):
            nodes, none = list(places), np.zeros(len(places))
            return Points(np.array(nodes, dtype=object), nodes, none, none, np.full(len(nodes), 1 / len(nodes)))
        storage = self.layout.storage
        weights = place_shares(self.model, self.layout, places)
        weights = np.full(len(storage), 1 / len(storage)) if weights is None else weights
        names = there = np.flatnonzero(weights)
        weights = weights[there]
        if len(there) > POINTS:
            at = np.searchsorted(np.cumsum(weights), (np.arange(POINTS) + 0.5) / POINTS * weights.sum())
            there, weights = there[np.minimum(at, len(there) - 1)], np.full(POINTS, 1 / POINTS)
            names = np.full(POINTS, np.nan)
        some = [storage[number] for number in there]
        times = [self.travel.along(place.edge, place.offset) for place in some]
        before, after = (np.array(part) for part in zip(*times, strict=True))
        return Points(names, [place.edge for place in some], before, after, weights)


def _other_places(picks: Points, drops: Points) -> Any:
    """The part of each pick's tasks (rows) that goes to each drop: none to the same place, where there are others."""
    import numpy as np

    same = picks.names[:, None] == drops.names
    to = np.where(same, 0.0, drops.weights)
    to[~to.any(axis=1)] = drops.weights
    return to / to.sum(axis=1, keepdims=True) if same.any() else to
