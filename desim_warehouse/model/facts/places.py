"""Places of goods: how often each storage place is asked for, where goods are unloaded, what handling takes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from desim_warehouse.layout.layout import Layout
from desim_warehouse.layout.spec import StationSpec
from desim_warehouse.model.schema import Model, reading
from desim_warehouse.model.sections.flows import StorageEnd, ends_of_storage
from desim_warehouse.model.sections.goods import Good, Popularity, only, shares
from desim_warehouse.model.sections.orders import files_of, nodes_named, summary
from desim_warehouse.values.distributions import mean_of


def place_shares(model: Model, layout: Layout, end: StorageEnd | None = None) -> Any:
    """Return the share of every storage place in the demand (of a flow's `end`), a numpy array.

    None stands for equal shares.
    """
    popularity = model.tasks.popularity if end is None or end.popularity is None else end.popularity
    by = popularity.by if isinstance(popularity, Popularity) else None
    order: Sequence[int] | None = None
    if by == "distance":
        flows = model.tasks.flows
        ends, to_ends = ends_of_storage(flows.values()) if flows else (model.tasks.unload_at, True)
        order = by_distance(layout, ends, to_ends=to_ends)
    elif by == "random":
        order = _scattered(len(layout.storage))
    return shares(popularity, layout.storage, order)


def only_place(model: Model, layout: Layout, end: StorageEnd | None = None) -> int | None:
    """Return the storage place that all demand for drawn goods is for; None if for several, so that chance decides."""
    return 0 if len(layout.storage) == 1 else only(place_shares(model, layout, end))


@lru_cache(maxsize=8)
def by_distance(layout: Layout, ends: tuple[str, ...], *, to_ends: bool) -> tuple[int, ...]:
    """Return the numbers of the storage places, nearest first, equally far ones by number.

    Args:
        layout: the floor.
        ends: nodes of stations.
        to_ends: whether loads are driven from the places to the nearest of `ends`, else from `ends` to the places.

    The way is the shortest along the lanes in their directions, and through no bay in a lane. Places without
    a way are last.
    """
    import networkx as nx

    through = layout.graph.subgraph([node for node in layout.graph if node not in layout.in_lane or node in ends])
    graph = through.reverse(copy=False) if to_ends else through
    far = nx.multi_source_dijkstra_path_length(graph, set(ends), weight="length")

    def way(edge: tuple[str, str], offset: float) -> float:
        beyond = layout.length(edge) - offset if to_ends else offset
        return float(far.get(edge[1] if to_ends else edge[0], float("inf"))) + beyond

    ways = [min(way(*approach) for approach in layout.approaches(place.edge, place.offset)) for place in layout.storage]
    return tuple(sorted(range(len(ways)), key=lambda number: (round(ways[number], 9), number)))


@lru_cache(maxsize=8)
def _scattered(size: int) -> Sequence[int]:
    import numpy as np

    order: list[int] = np.random.default_rng(0).permutation(size).tolist()
    return order


def own_destinations(model: Model, layout: Layout) -> list[tuple[str, ...]]:
    """Return for every task of the list the nodes it goes to, empty for tasks.unload_at; [] for drawn goods."""
    goods = model.tasks.goods
    if not isinstance(goods, tuple):
        return []
    named: dict[str | None, tuple[str, ...]] = {None: ()}
    targets = []
    for item in goods:
        name = item.to if isinstance(item, Good) else None
        if name not in named:
            named[name] = layout.nodes_of(str(name))
        targets.append(named[name])
    return targets


def destinations(model: Model, layout: Layout) -> tuple[str, ...]:
    """Return all nodes where goods are unloaded, tasks.unload_at first; with flows also where they are loaded.

    Nodes where goods stop on their way are among them, nodes that only a file of orders names are not.
    """
    if model.tasks.flows:
        routes = [route for flow in model.tasks.flows.values() for route in flow.routes]
        ends = [end for route in routes for end in (route.source, route.target)]
        ends += [layout.nodes_of(name) for flow in model.tasks.flows.values() for name in flow.via]
        return tuple(dict.fromkeys(node for end in ends if isinstance(end, tuple) for node in end))
    own = (node for nodes in dict.fromkeys(own_destinations(model, layout)) for node in nodes)
    return tuple(dict.fromkeys((*model.tasks.unload_at, *own)))


def ends_in_stations(model: Model, layout: Layout) -> tuple[str, ...]:
    """Return the nodes of stations where tasks end; empty where any task ends elsewhere and so needs no slot.

    With pods tasks end where the pod is put down again.
    """
    if model.pods is not None:
        return ()
    ends = destinations(model, layout)
    if model.tasks.flows:
        targets = [route.target for flow in model.tasks.flows.values() for route in flow.routes]
        if files := files_of(model.tasks.flows):
            how = reading(model, layout)
            targets += [nodes_named(files, how, layout)]
            targets += [StorageEnd() for file in files if summary(file, how).stored]
        if any(isinstance(end, StorageEnd) for end in targets):
            return ()
        ends = tuple(dict.fromkeys(node for end in targets if isinstance(end, tuple) for node in end))
    return ends if all(node in layout.stations for node in ends) else ()


def slots(model: Model, layout: Layout) -> int | None:
    """Return how many tasks may be in hand at once, as each needs a slot where it ends; None without such a limit."""
    return sum(layout.stations[node].places for node in ends_in_stations(model, layout)) or None


def handling(model: Model, layout: Layout) -> dict[str, str]:
    """Return the work at nodes of flows where it is not unloading alone: `loading`, or `loading and unloading`."""
    routes = [route for flow in model.tasks.flows.values() for route in flow.routes]
    unloads = {node for route in routes if isinstance(route.target, tuple) for node in route.target}
    unloads.update(node for flow in model.tasks.flows.values() for name in flow.via for node in layout.nodes_of(name))
    return {node: "loading and unloading" if node in unloads else "loading" for node in model.tasks.picked_at}


def specs(model: Model, layout: Layout) -> dict[str, StationSpec]:
    """Return the section of the model for each station, by its node."""
    return {node: model.layout.stations[item.zone] for node, item in layout.stations.items()}


def worked_capacity(spec: StationSpec) -> float:
    """Return the load units per time unit that the workers of an open station get done; inf without such work."""
    time = 0.0 if spec.work_time is None else mean_of(spec.work_time)
    return spec.workers / time if time else math.inf
