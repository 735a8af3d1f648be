"""What tasks draw from a battery at least: from a charger or a start to the good, the station, and a charger."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from heapq import heapify, heappop, heappush
from operator import itemgetter
from typing import TYPE_CHECKING, Any

from desim_warehouse.feasibility.free_flow import FlowMix, free_flow
from desim_warehouse.model.facts.ahead import handling_of
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.model.facts.demand import asked_for, demand, listed
from desim_warehouse.model.facts.places import destinations, own_destinations
from desim_warehouse.model.sections.fleet import Consumption
from desim_warehouse.model.sections.flows import StorageEnd

if TYPE_CHECKING:
    from collections.abc import Mapping

    from desim_warehouse.layout import Layout
    from desim_warehouse.layout.layout import Edge
    from desim_warehouse.model import Model

ONE: dict[str, Any] = {"size": 1, "start": (), "start_on_lanes": ()}
TIME = Consumption(standing=1.0, empty=1.0, loaded=1.0, handling=1.0)
"""With this consumption what tasks draw is the time that they take."""


@dataclass(frozen=True)
class Needs:
    """The least that tasks draw from a battery: `most` for the worst task, `reach` up to the edge of a good.

    `mean` is for the mean task. `of`: both for each task of a list, by its good and its own destinations; else empty.
    """

    worst: str
    most: float
    reach: float
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
    return _least_needs(model, layout, draws, tuple(begun.items()), tuple(ends), anywhere=anywhere)


# The sums of one shortest path after another, which need each other's tables.
@lru_cache(maxsize=8)
def _least_needs(
    model: Model,
    layout: Layout,
    draws: Consumption,
    begun: tuple[tuple[str, float], ...],
    ends: tuple[str, ...],
    *,
    anywhere: bool,
) -> Needs:
    """`begun`: what has been drawn where robots come from; `ends`: where they go."""
    tasks, node_time, special = model.tasks, model.traffic.node_time, dict(model.traffic.node_times)
    speed = model.fleet.fastest
    paces = {edge: min(speed, data["speed"]) for edge, data in layout.graph.edges.items()}
    times = {
        edge: data["length"] / paces[edge] + special.get(edge[1], node_time)
        for edge, data in layout.graph.edges.items()
    }
    back_in_time = {(target, source): time for (source, target), time in times.items()}
    if tasks.flows:
        flow = free_flow(model, layout, speed, at_once=True)
        assert isinstance(flow, FlowMix)
        return _needs_of_flows(flow, draws, None if anywhere else (dict(begun), list(ends)))
    reach = least_costs(times, draws.empty, dict(begun))
    back = least_costs(back_in_time, draws.empty, dict.fromkeys(ends, 0.0))
    cleared = {node: back[node] + draws.empty * tasks.clear_time for node in destinations(model, layout)}
    own = list(zip(listed(model), own_destinations(model, layout), strict=True))
    work = dict.fromkeys(own) or dict.fromkeys((number, ()) for number in asked_for(model, layout))
    beyond = {
        nodes: least_costs(back_in_time, draws.loaded, {node: cleared[node] for node in nodes or tasks.unload_at})
        for nodes in dict.fromkeys(nodes for _, nodes in work)
    }
    stops = handling_of(model, layout).means()
    unload = min(stops.at_stop("unload", station=node) for node in (None, *layout.stations))
    handling = draws.handling * (stops.at_stop("load") + unload)
    most, far = [], []
    for number, nodes in work:
        place = layout.storage[number]
        sides = layout.approaches(place.edge, place.offset)
        needs = []
        for edge, offset in sides:
            needs.append(reach[edge[0]] + beyond[nodes][edge[1]] + handling)
            if edge in paces:  # else it is at a node
                to_good = offset / paces[edge]
                needs[-1] += draws.empty * to_good + draws.loaded * (times[edge] - to_good)
        most.append(min(needs))
        far.append(min(reach[edge[0]] for edge, _ in sides))
    worst = max(zip(most, work, strict=True), key=itemgetter(0), default=(0.0, (0, ())))
    of = dict(zip(work, zip(most, far, strict=True), strict=True)) if own else {}
    shares = demand(model, layout)
    every = [1 / len(own) * of[task][0] for task in own] or [
        float(shares[number]) * need for (number, _), need in zip(work, most, strict=True)
    ]
    return Needs(f"good {worst[1][0]}", worst[0], max(far, default=0.0), math.fsum(every), of)


def _needs_of_flows(flow: FlowMix, draws: Consumption, between: tuple[Mapping[str, float], list[str]] | None) -> Needs:
    """The same for flows: of storage places the worst, of stations the nearest that serves.

    `between`: where robots come from, with what they have drawn then, and where they go; None: neither counts.
    """
    import numpy as np

    worst, most, farthest, mean = "", 0.0, 0.0, 0.0
    for leg in flow.legs:
        reaches, needs = [], []
        for side in flow.sides(leg):
            picks, drops = side.picks, side.drops
            reach, back = np.zeros(len(picks.places)), drops.after + flow.model.tasks.clear_time
            if between is not None:
                begins, ends = between
                out = np.array(list(begins.values()))[:, None]
                reach = (out + draws.empty * flow.travel.between(list(begins), picks.places)).min(axis=0)
                back = back + flow.travel.between(drops.places, ends).min(axis=1)
            reaches.append(reach)
            needs.append((reach + draws.empty * picks.before)[:, None] + draws.loaded * side.times + draws.empty * back)
        least, handled = np.min(needs, axis=0), draws.handling * flow.least_handling(leg)
        is_put_away = isinstance(leg.route.target, StorageEnd)
        on_average = least @ leg.drops.weights if is_put_away else least.min(axis=1)
        mean += leg.share * (float(leg.picks.weights @ on_average) + handled)
        need = float((least.max(axis=1) if is_put_away else least.min(axis=1)).max()) + handled
        farthest = max(farthest, float(np.min(reaches, axis=0).max()))
        if need > most:
            worst, most = f"a task of flow '{leg.flow}'", need
    return Needs(worst, most, farthest, mean, {})


def least_costs(times: Mapping[Edge, float], rate: float, begins: Mapping[str, float]) -> dict[str, float]:
    """The least cost of every node: of a beginning, and `rate` for each time unit on the way (Dijkstra)."""
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
    return costs
