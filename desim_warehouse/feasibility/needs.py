"""Least energy of tasks: from a charger or a start to the good, the station, and a charger.

For the findings of `desim check` on batteries and on the starts of robots.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from heapq import heapify, heappop, heappush
from typing import Any, NamedTuple

from desim_warehouse.layout import Layout
from desim_warehouse.layout.layout import Edge
from desim_warehouse.model import Model
from desim_warehouse.model.facts.ahead import handling_of
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.model.facts.demand import demand, flow_rates, listed
from desim_warehouse.model.facts.places import own_destinations, place_shares
from desim_warehouse.model.sections.fleet import Consumption
from desim_warehouse.model.sections.flows import StorageEnd

ONE: dict[str, Any] = {"size": 1, "start": (), "start_on_lanes": ()}
TIME = Consumption(standing=1.0, empty=1.0, loaded=1.0, handling=1.0)
"""With this consumption, the energy of a task is its time."""
WITH_LOAD = Consumption(standing=0.0, empty=0.0, loaded=1.0, handling=1.0)
"""With this consumption, the energy of a task is its time from the good to the delivery."""


@dataclass(frozen=True)
class Needs:
    """The least energy that tasks draw from a battery, in the model's unit.

    Attributes:
        worst: the task that draws most, in words.
        most: the energy that this task draws.
        reach: energy to get to the edge of a good, for the task with the farthest good.
        rest: energy from the edge of a good to a charger, for the task with the largest.
        least: energy from the edge of a good on, for the quickest task of each flow ("" without flows).
        mean: energy of the mean task.
        of: for tasks of a list, by good and destinations: the energy of the whole task, and up to the good's edge.
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
    """Return the least energy that tasks draw: by the fastest robot and routes, with the nearest charger and station.

    If the work ends, a task may also begin at a robot's start and end in any bay, as it may be the robot's only task.
    With `again` it may not: the battery has been charged before. `anywhere`: the drive to the good's edge, and the
    drive after the delivery, draw nothing.
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
    if not fleet.kinds:  # a task draws alike in fleets of all sizes
        model = model.model_copy(update={"fleet": fleet.model_copy(update=ONE)})
    return _least_needs(model, layout, draws, tuple(begun.items()), tuple(ends))


@lru_cache(maxsize=8)
def _least_needs(
    model: Model, layout: Layout, draws: Consumption, begun: tuple[tuple[str, float], ...], ends: tuple[str, ...]
) -> Needs:
    """Compute `least_needs`; `begun`: energy already drawn at the nodes robots come from, `ends`: nodes they go to."""
    floor = _Floor(model, layout, draws, dict(begun), ends)
    worst, most, reach, rest, mean = "", 0.0, 0.0, 0.0, 0.0
    least: dict[str, float] = {}
    of_listed: dict[tuple[int, tuple[str, ...]], tuple[float, float]] = {}
    for job in jobs(model, layout):
        needs, reaches, onward = floor.put_away(job) if job.stores else floor.fetched(job)
        asked = job.drops if job.stores else job.picks
        mean += float(asked.weights @ needs)
        reach, rest = max(reach, float(reaches.max())), max(rest, float(onward.max()))
        least[job.flow] = min(least.get(job.flow, math.inf), float(onward.min()))
        if needs.max() > most:
            worst = f"a task of flow '{job.flow}'" if job.flow else f"good {asked.numbers[int(needs.argmax())]}"
            most = float(needs.max())
        if isinstance(model.tasks.goods, tuple):
            both = zip(needs.tolist(), reaches.tolist(), strict=True)
            of_listed.update(zip(((number, job.own) for number in asked.numbers), both, strict=True))
    return Needs(worst, most, reach, rest, least, mean, of_listed)


class Places(NamedTuple):
    """Storage places by `numbers`, or stations by `nodes`, with the share of all tasks that each has."""

    numbers: Sequence[int]
    nodes: Sequence[str]
    weights: Any

    def edges(self, layout: Layout) -> list[Edge]:
        """Return the edge of each place; the edge of a station leads from its node to itself."""
        return [layout.storage[number].edge for number in self.numbers] or [(node, node) for node in self.nodes]


class Job(NamedTuple):
    """Tasks of one flow ("" without flows) with equal places: from any of `picks`, over `via`, to any of `drops`.

    Each pick has tasks, and a robot goes to the nearest drop. With `stores` each drop has tasks, fetched from the
    nearest pick. `via`: stops on the way, each with its nodes. `own`: the destinations of tasks of a list.
    """

    flow: str
    picks: Places
    via: Sequence[Sequence[str]]
    drops: Places
    stores: bool = False
    own: tuple[str, ...] = ()


def jobs(model: Model, layout: Layout) -> Iterator[Job]:
    """Yield all tasks of a model; tasks with equal origins and destinations are one job."""
    return _jobs_of_flows(model, layout) if model.tasks.flows else _jobs_of_goods(model, layout)


def _places(end: Sequence[str] | None, shares: Any, weight: float) -> Places:
    """Return stations among which tasks are shared evenly, or storage places with their shares."""
    import numpy as np

    if end is not None:
        return Places((), end, np.full(len(end), weight / len(end)))
    numbers = np.flatnonzero(shares)
    return Places(numbers.tolist(), (), weight * shares[numbers])


def _jobs_of_goods(model: Model, layout: Layout) -> Iterator[Job]:
    """Yield the jobs of goods, one for each set of destinations if goods are listed with their own."""
    import numpy as np

    goods, own = listed(model), own_destinations(model, layout)
    for nodes in dict.fromkeys(own or [()]):
        if own:
            drawn = [good for good, targets in zip(goods, own, strict=True) if targets == nodes]
            shares = np.bincount(drawn, minlength=len(layout.storage)) / len(goods)
        else:
            shares = demand(model, layout)
        yield Job("", _places(None, shares, 1.0), (), _places(nodes or model.tasks.unload_at, None, 0.0), own=nodes)


def _jobs_of_flows(model: Model, layout: Layout) -> Iterator[Job]:
    """Yield a job for each route of each flow."""
    import numpy as np

    def places(end: StorageEnd | tuple[str, ...], weight: float) -> Places:
        if not isinstance(end, StorageEnd):
            return _places(end, None, weight)
        shares, size = place_shares(model, layout, end), len(layout.storage)
        return _places(None, np.full(size, 1 / size) if shares is None else shares, weight)

    rates = flow_rates(model)
    total = math.fsum(rates.values())
    for name, flow in model.tasks.flows.items():
        via = [layout.nodes_of(stop) for stop in flow.via]
        for route in flow.routes:
            weight, stores = rates[name] / total * route.share, isinstance(route.target, StorageEnd)
            yield Job(name, places(route.source, weight), via, places(route.target, weight), stores)


class _Floor:
    """Least energy on a floor: from the beginnings of robots to its nodes, for tasks, and to a charger."""

    def __init__(
        self, model: Model, layout: Layout, draws: Consumption, begun: Mapping[str, float], ends: Sequence[str]
    ) -> None:
        self._paces = paces(model, layout)
        self._times = edge_times(model, layout)
        self._back_in_time = {edge[::-1]: time for edge, time in self._times.items()}
        self._layout, self._draws, self._clear = layout, draws, draws.empty * model.tasks.clear_time
        self._stops = handling_of(model, layout).means()
        self._reach = least_costs(self._times, draws.empty, begun)
        self._back = least_costs(self._back_in_time, draws.empty, dict.fromkeys(ends, 0.0))

    def fetched(self, job: Job) -> tuple[Any, Any, Any]:
        """Return the energy of tasks for each pick: in all, up to the good's edge, and then on to the cheapest drop."""
        handled = self._handled(job, "unload", job.drops)
        goals = {node: self._back[node] + self._clear + handled[i] for i, node in enumerate(job.drops.nodes)}
        to_go = self._loaded(job, self._back_in_time, goals, job.via[::-1])
        starts, ends, before, after = self._sides(job.picks)
        load = self._handled(job, "load", job.picks)
        rest = self._draws.empty * before + load + self._draws.loaded * after + _costs(to_go, ends)
        reach = _costs(self._reach, starts)
        return (reach + rest).min(axis=0), reach.min(axis=0), rest.min(axis=0)

    def put_away(self, job: Job) -> tuple[Any, Any, Any]:
        """Return the energy of tasks for each drop, by the cheapest pick: in all, up to the pick's edge, and after."""
        starts, ends, before, after = self._sides(job.picks)
        reach = _costs(self._reach, starts).min(axis=0)
        picked = self._draws.empty * before + self._handled(job, "load", job.picks) + self._draws.loaded * after
        begun: dict[str, float] = {}
        for node, cost in zip([node for side in ends for node in side], picked.ravel().tolist(), strict=True):
            begun[node] = min(begun.get(node, math.inf), cost)
        so_far = self._loaded(job, self._times, begun, job.via)
        starts, ends, before, after = self._sides(job.drops)
        back = self._draws.empty * after + self._clear + _costs(self._back, ends)
        rest = _costs(so_far, starts) + self._draws.loaded * before + self._handled(job, "unload", job.drops) + back
        rest = rest.min(axis=0)
        return reach.min() + rest, reach, rest

    def _handled(self, job: Job, act: Any, places: Places) -> Any:
        """Return the energy of handling at each station; at storage places a single number."""
        import numpy as np

        times = [self._stops.at_stop(act, job.flow, node) for node in places.nodes or (None,)]
        return self._draws.handling * np.array(times)

    def _sides(self, places: Places) -> tuple[list[list[str]], list[list[str]], Any, Any]:
        """Return start and end nodes of the edges beside which places lie, and the times before and after the place.

        The four tables have a row for each side from which a robot may come, two if lanes are two-way, and a column for
        each place. The third has the time from the start of the edge to the place, the fourth from the place to the
        end.
        """
        import numpy as np

        edges, storage = places.edges(self._layout), self._layout.storage
        offsets = [storage[number].offset for number in places.numbers] or [0.0] * len(edges)
        sides = [list(zip(edges, offsets, strict=True))]
        if self._layout.two_way:
            sides.append([self._layout.approaches(*place)[-1] for place in sides[0]])
        before = [[offset / self._paces.get(edge, math.inf) for edge, offset in side] for side in sides]
        whole = [[self._times.get(edge, 0.0) for edge, _ in side] for side in sides]
        starts, ends = ([[edge[end] for edge, _ in side] for side in sides] for end in (0, 1))
        return starts, ends, np.array(before), np.array(whole) - np.array(before)

    def _loaded(
        self, job: Job, times: Mapping[Edge, float], costs: Mapping[str, float], via: Sequence[Sequence[str]]
    ) -> dict[str, float]:
        """Return the least energy at each node of driving there with a load, through a node of each stop on the way."""
        least = least_costs(times, self._draws.loaded, costs)
        for nodes in via:
            stop = self._draws.handling * self._stops.at_stop("visit", job.flow)
            least = least_costs(times, self._draws.loaded, {node: least[node] + stop for node in nodes})
        return least


def _costs(least: Mapping[str, float], sides: Sequence[Sequence[str]]) -> Any:
    import numpy as np

    return np.array([[least[node] for node in side] for side in sides])


def paces(model: Model, layout: Layout) -> dict[Edge, float]:
    """Return the speed of the fastest robot on each edge."""
    return {edge: min(model.fleet.fastest, data["speed"]) for edge, data in layout.graph.edges.items()}


def edge_times(model: Model, layout: Layout) -> dict[Edge, float]:
    """Return the time that the fastest robot takes for each edge and the node at its end, without turns."""
    node_time, special, speed = model.traffic.node_time, dict(model.traffic.node_times), paces(model, layout)
    return {
        edge: data["length"] / speed[edge] + data.get("takes", 0.0) + special.get(edge[1], node_time)
        for edge, data in layout.graph.edges.items()
    }


def least_costs(times: Mapping[Edge, float], rate: float, begins: Mapping[str, float]) -> dict[str, float]:
    """Return the least cost of every node: the cost at its start and `rate` per time unit on the way (Dijkstra).

    Nodes that cannot be reached have cost inf.
    """
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
