"""What tasks draw from a battery at least: from a charger or a start to the good, the station, and a charger."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from dataclasses import dataclass
from functools import lru_cache
from heapq import heapify, heappop, heappush
from operator import add
from typing import TYPE_CHECKING, Any, NamedTuple

from desim_warehouse.model.facts.ahead import handling_of
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.model.facts.demand import asked_for, demand, flow_rates, listed
from desim_warehouse.model.facts.places import own_destinations, place_shares
from desim_warehouse.model.sections.fleet import Consumption
from desim_warehouse.model.sections.flows import StorageEnd

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from desim_warehouse.layout import Layout
    from desim_warehouse.layout.layout import Edge
    from desim_warehouse.model import Model

ONE: dict[str, Any] = {"size": 1, "start": (), "start_on_lanes": ()}
TIME = Consumption(standing=1.0, empty=1.0, loaded=1.0, handling=1.0)
"""With this consumption what tasks draw is the time that they take."""
WITH_LOAD = Consumption(standing=0.0, empty=0.0, loaded=1.0, handling=1.0)
"""With this consumption what tasks draw is the time from the good to its delivery."""


@dataclass(frozen=True)
class Needs:
    """The least that tasks draw from a battery.

    Attributes:
        worst: the task that draws most, in words, and `most` what it draws.
        reach: up to the edge of a good, where that is the most.
        rest: from the edge of a good to a charger, where that is the most.
        least: from the edge of a good on, for the quickest task of each flow ("" without flows).
        mean: for the mean task.
        of: the whole and the reach for each task of a list, by its good and its own destinations; else empty.
    """

    worst: str
    most: float
    reach: float
    rest: float
    least: Mapping[str, float]
    mean: float
    of: Mapping[tuple[int, tuple[str, ...]], tuple[float, float]]


def least_needs(
    model: Model, layout: Layout, draws: Consumption, *, again: bool = False, anywhere: bool = False
) -> Needs:
    """What tasks draw at least, by the fastest robot and routes, the nearest charger and the nearest station.

    Where work ends, a task may also begin at a robot's start and end in any bay: it may be the robot's only one.
    `again`: not so for a battery that has been charged. `anywhere`: nothing is drawn before the edge of the good and
    after the delivery.
    """
    fleet = model.fleet
    begins = ends = list(chargers_at(model, layout))
    if not begins or not (model.tasks.never_end or again):
        begins, ends = [*begins, *fleet.homes(layout.bays)], list(layout.bays)
    out = draws.empty * (fleet.exit_time if again else min(fleet.exit_time, fleet.first_exit_time))
    if anywhere:
        begins, ends, out = list(layout.graph), list(layout.graph), 0.0
    stands = () if again else fleet.starts(layout.bays)
    begun = {**dict.fromkeys(begins, out), **{start.node: 0.0 for start in stands if start.on_lanes}}
    if not fleet.kinds:  # fleets of all sizes draw the same
        model = model.model_copy(update={"fleet": fleet.model_copy(update=ONE)})
    return _least_needs(model, layout, draws, tuple(begun.items()), tuple(ends))


@lru_cache(maxsize=8)
def _least_needs(
    model: Model, layout: Layout, draws: Consumption, begun: tuple[tuple[str, float], ...], ends: tuple[str, ...]
) -> Needs:
    """`begun`: what has been drawn where robots come from; `ends`: where they go."""
    floor = _Floor(model, layout, draws, dict(begun), ends)
    worst, most, reach, rest, mean = "", 0.0, 0.0, 0.0, 0.0
    least: dict[str, float] = defaultdict(lambda: math.inf)
    of: dict[tuple[int, tuple[str, ...]], tuple[float, float]] = {}
    for job in jobs(model, layout):
        for place, need, to_edge, onward in floor.tasks(job):
            mean += place.weight * need
            reach, rest = max(reach, to_edge), max(rest, onward)
            least[job.flow] = min(least[job.flow], onward)
            if need > most:
                worst, most = f"a task of flow '{job.flow}'" if job.flow else f"good {place.number}", need
            if isinstance(model.tasks.goods, tuple):
                of[place.number, job.own] = need, to_edge
    return Needs(worst, most, reach, rest, least, mean, of)


class Place(NamedTuple):
    """Where a load is picked or put down: a storage place or a station, and the part of all tasks that is for it.

    `sides` are the edges by which robots come to it, and how far along them it is; a node is an edge to itself.
    """

    number: int
    sides: Sequence[tuple[Edge, float]]
    weight: float
    station: str | None = None


class Job(NamedTuple):
    """Tasks of one flow ("": without flows) from any of `picks` over nodes of each of `via` to any of `drops`.

    Each of the picks is asked for, and a robot goes to the nearest drop; where `stores`, each drop is, from the
    nearest pick. `own`: the destinations of tasks of a list.
    """

    flow: str
    picks: Sequence[Place]
    via: Sequence[Sequence[str]]
    drops: Sequence[Place]
    stores: bool = False
    own: tuple[str, ...] = ()


def jobs(model: Model, layout: Layout) -> Iterator[Job]:
    """All tasks of a model, those from the same places to the same together."""
    return _jobs_of_flows(model, layout) if model.tasks.flows else _jobs_of_goods(model, layout)


def _at_nodes(nodes: Sequence[str], weight: float = 0.0) -> list[Place]:
    """Stations as places, among which tasks are shared evenly."""
    return [Place(-1, [((node, node), 0.0)], weight / len(nodes), node) for node in nodes]


def _in_storage(layout: Layout, weights: Mapping[int, float]) -> list[Place]:
    storage = layout.storage
    return [Place(i, layout.approaches(storage[i].edge, storage[i].offset), share) for i, share in weights.items()]


def _jobs_of_goods(model: Model, layout: Layout) -> Iterator[Job]:
    """The goods, by their own destinations where they are listed."""
    own = Counter(zip(listed(model), own_destinations(model, layout), strict=True))
    shares = demand(model, layout)
    drawn = {} if own else {(): {number: float(shares[number]) for number in asked_for(model, layout)}}
    for (number, nodes), count in own.items():
        drawn.setdefault(nodes, {})[number] = count / own.total()
    for nodes, weights in drawn.items():
        yield Job("", _in_storage(layout, weights), (), _at_nodes(nodes or model.tasks.unload_at), own=nodes)


def _jobs_of_flows(model: Model, layout: Layout) -> Iterator[Job]:
    """The routes of the flows; of those into storage each station that they come from apart."""

    def places(end: StorageEnd | tuple[str, ...], weight: float) -> list[Place]:
        if not isinstance(end, StorageEnd):
            return _at_nodes(end, weight)
        shares, size = place_shares(model, layout, end), len(layout.storage)
        each = [1 / size] * size if shares is None else shares.tolist()
        return _in_storage(layout, {number: weight * share for number, share in enumerate(each) if share})

    rates = flow_rates(model)
    total = math.fsum(rates.values())
    for name, flow in model.tasks.flows.items():
        via = [layout.nodes_of(stop) for stop in flow.via]
        for route in flow.routes:
            weight, stores = rates[name] / total * route.share, isinstance(route.target, StorageEnd)
            one_by_one = stores and not isinstance(route.source, StorageEnd)
            for source in [(node,) for node in route.source] if one_by_one else [route.source]:
                part = weight / len(route.source) if one_by_one else weight
                yield Job(name, places(source, part), via, places(route.target, part), stores)


class _Floor:
    """Least costs on a floor: of coming to its nodes from where robots begin, of tasks, and of driving back."""

    def __init__(
        self, model: Model, layout: Layout, draws: Consumption, begun: Mapping[str, float], ends: Sequence[str]
    ) -> None:
        node_time, special = model.traffic.node_time, dict(model.traffic.node_times)
        speed, edges = model.fleet.fastest, layout.graph.edges
        self._paces = {edge: min(speed, data["speed"]) for edge, data in edges.items()}
        self._times = {
            edge: data["length"] / self._paces[edge] + special.get(edge[1], node_time) for edge, data in edges.items()
        }
        self._back_in_time = {edge[::-1]: time for edge, time in self._times.items()}
        self._draws, self._clear = draws, draws.empty * model.tasks.clear_time
        self._stops = handling_of(model, layout).means()
        self._reach = least_costs(self._times, draws.empty, begun)
        self._back = least_costs(self._back_in_time, draws.empty, dict.fromkeys(ends, 0.0))

    def tasks(self, job: Job) -> Iterator[tuple[Place, float, float, float]]:
        """Each place that is asked for, what a task for it draws at least, up to the edge of the good, and from there.

        Where both ends are in storage the way to the edge is to the farthest, and the whole begins at the nearest.
        """
        return self._put_away(job) if job.stores else self._fetched(job)

    def _fetched(self, job: Job) -> Iterator[tuple[Place, float, float, float]]:
        """Tasks for each pick, to the cheapest drop: least costs to go, back in time from there."""
        drops = {end.station: self._handled(job, "unload", end) for end in job.drops if end.station is not None}
        costs = {node: self._back[node] + self._clear + handled for node, handled in drops.items()}
        to_go = self._loaded(job, self._back_in_time, costs, job.via[::-1])
        for pick in job.picks:
            load = self._handled(job, "load", pick)
            reaches, rests = self._reaches(pick), []
            for edge, offset in pick.sides:
                before, after = self._along(edge, offset)
                rests.append(self._draws.empty * before + load + self._draws.loaded * after + to_go[edge[1]])
            yield pick, min(map(add, reaches, rests)), min(reaches), min(rests)

    def _put_away(self, job: Job) -> Iterator[tuple[Place, float, float, float]]:
        """Tasks for each drop, from the cheapest pick: least costs so far, from the edges of the picks on."""
        so_far: dict[str, float] = {}
        for pick in job.picks:
            load = self._handled(job, "load", pick)
            for edge, offset in pick.sides:
                before, after = self._along(edge, offset)
                cost = self._draws.empty * before + load + self._draws.loaded * after
                so_far[edge[1]] = min(so_far.get(edge[1], math.inf), cost)
        reaches = [min(self._reaches(pick)) for pick in job.picks]
        costs = self._loaded(job, self._times, so_far, job.via)
        for drop in job.drops:
            unload = self._handled(job, "unload", drop)
            rests = []
            for edge, offset in drop.sides:
                before, after = self._along(edge, offset)
                back = self._draws.empty * after + self._clear + self._back[edge[1]]
                rests.append(costs[edge[0]] + self._draws.loaded * before + unload + back)
            yield drop, min(reaches) + min(rests), max(reaches), min(rests)

    def _reaches(self, place: Place) -> list[float]:
        """What is drawn up to the edge of a place, from each side."""
        return [self._reach[edge[0]] for edge, _ in place.sides]

    def _handled(self, job: Job, act: Any, place: Place) -> float:
        return self._draws.handling * self._stops.at_stop(act, job.flow, place.station)

    def _along(self, edge: Edge, offset: float) -> tuple[float, float]:
        """The times from the start of an edge to a place on it, and from there over the node at its end."""
        if edge not in self._paces:  # a place at a node
            return 0.0, 0.0
        before = offset / self._paces[edge]
        return before, self._times[edge] - before

    def _loaded(
        self, job: Job, times: Mapping[Edge, float], costs: Mapping[str, float], via: Sequence[Sequence[str]]
    ) -> dict[str, float]:
        """The least costs of driving on with a load over the cheapest node of each stop on the way."""
        least = least_costs(times, self._draws.loaded, costs)
        for nodes in via:
            stop = self._draws.handling * self._stops.at_stop("visit", job.flow)
            least = least_costs(times, self._draws.loaded, {node: least[node] + stop for node in nodes})
        return least


def least_costs(times: Mapping[Edge, float], rate: float, begins: Mapping[str, float]) -> dict[str, float]:
    """The least cost of every node: of a beginning, and `rate` for each time unit on the way (Dijkstra); else inf."""
    onward: dict[str, list[tuple[str, float]]] = {}
    for (source, target), time in times.items():
        onward.setdefault(source, []).append((target, rate * time))
    costs: dict[str, float] = {}
    heap = [(cost, node) for node, cost in begins.items()]
    heapify(heap)
    while heap:
        cost, node = heappop(heap)
        if node not in costs:
            costs[node] = cost
            for target, more in onward.get(node, ()):
                if target not in costs:
                    heappush(heap, (cost + more, target))
    return defaultdict(lambda: math.inf, costs)
