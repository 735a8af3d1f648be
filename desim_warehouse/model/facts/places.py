"""Where goods lie and go: how often each storage place is asked for, where goods are unloaded, what handling takes."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from desim_warehouse.model.sections.flows import ends_of_storage
from desim_warehouse.model.sections.goods import Good, Popularity, only, shares
from desim_warehouse.values.distributions import mean_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.layout.layout import Layout
    from desim_warehouse.layout.spec import StationSpec
    from desim_warehouse.model.schema import Model
    from desim_warehouse.model.sections.flows import StorageEnd


def place_shares(model: Model, layout: Layout, of: StorageEnd | None = None) -> Any:
    """The share of every storage place in the demand (`of` an end of a flow), a numpy array; None: equal shares."""
    popularity = model.tasks.popularity if of is None or of.popularity is None else of.popularity
    by = popularity.by if isinstance(popularity, Popularity) else None
    order: Sequence[int] | None = None
    if by == "distance":
        flows = model.tasks.flows
        ends, there = ends_of_storage(flows.values()) if flows else (model.tasks.unload_at, True)
        order = by_distance(layout, ends, there=there)
    elif by == "random":
        order = _scattered(len(layout.storage))
    return shares(popularity, layout.storage, order)


def only_place(model: Model, layout: Layout, of: StorageEnd | None = None) -> int | None:
    """The storage place that all demand for drawn goods is for; None: it is for several, so that chance decides."""
    return 0 if len(layout.storage) == 1 else only(place_shares(model, layout, of))


@lru_cache(maxsize=8)
def by_distance(layout: Layout, ends: tuple[str, ...], *, there: bool) -> tuple[int, ...]:
    """The numbers of the storage places, nearest first, those equally far by number.

    Args:
        layout: the floor.
        ends: nodes of stations.
        there: whether loads are driven from the places to the nearest of `ends`, else from there to the places.

    The way is the shortest along the lanes in their directions, and through no bay in a lane. Places from which there
    is none are last.
    """
    import networkx as nx

    through = layout.graph.subgraph([node for node in layout.graph if node not in layout.in_lane or node in ends])
    graph = through.reverse(copy=False) if there else through
    far = nx.multi_source_dijkstra_path_length(graph, set(ends), weight="length")

    def way(edge: tuple[str, str], offset: float) -> float:
        beyond = layout.length(edge) - offset if there else offset
        return float(far.get(edge[1] if there else edge[0], float("inf"))) + beyond

    ways = [min(way(*one) for one in layout.approaches(place.edge, place.offset)) for place in layout.storage]
    return tuple(sorted(range(len(ways)), key=lambda number: (round(ways[number], 9), number)))


@lru_cache(maxsize=8)
def _scattered(size: int) -> Sequence[int]:
    import numpy as np

    found: list[int] = np.random.default_rng(0).permutation(size).tolist()
    return found


def own_destinations(model: Model, layout: Layout) -> list[tuple[str, ...]]:
    """For every task of the list the nodes of which one it goes to, empty for tasks.unload_at; [] for drawn goods."""
    goods = model.tasks.goods
    if not isinstance(goods, tuple):
        return []
    named: dict[str | None, tuple[str, ...]] = {None: ()}
    found = []
    for item in goods:
        name = item.to if isinstance(item, Good) else None
        if name not in named:
            named[name] = layout.nodes_of(str(name))
        found.append(named[name])
    return found


def destinations(model: Model, layout: Layout) -> tuple[str, ...]:
    """All nodes where goods are unloaded, those of tasks.unload_at first. With flows also where goods are loaded.

    And those where they stop on their way. Nodes that only a file of orders names are not among them.
    """
    if model.tasks.flows:
        routes = [route for flow in model.tasks.flows.values() for route in flow.routes]
        ends = [end for route in routes for end in (route.source, route.target)]
        ends += [layout.nodes_of(name) for flow in model.tasks.flows.values() for name in flow.via]
        return tuple(dict.fromkeys(node for end in ends if isinstance(end, tuple) for node in end))
    own = (node for nodes in dict.fromkeys(own_destinations(model, layout)) for node in nodes)
    return tuple(dict.fromkeys((*model.tasks.unload_at, *own)))


def handling(model: Model, layout: Layout) -> dict[str, str]:
    """What is done at the nodes of flows where it is not unloading alone: `loading`, or `loading and unloading`."""
    routes = [route for flow in model.tasks.flows.values() for route in flow.routes]
    loads = {node for route in routes if isinstance(route.source, tuple) for node in route.source}
    unloads = {node for route in routes if isinstance(route.target, tuple) for node in route.target}
    unloads.update(node for flow in model.tasks.flows.values() for name in flow.via for node in layout.nodes_of(name))
    return {node: "loading and unloading" if node in unloads else "loading" for node in loads}


def specs(model: Model, layout: Layout) -> dict[str, StationSpec]:
    """What the model says of each station, by its node."""
    return {node: model.layout.stations[item.zone] for node, item in layout.stations.items()}


def open_share(model: Model, spec: StationSpec) -> float:
    """The part of a run in which a station is open."""
    return model.hours(spec.hours).share(0.0, model.run.end)


def worked_capacity(spec: StationSpec) -> float:
    """Load units per time unit that the workers of an open station get done; inf where there is no such work."""
    time = 0.0 if spec.work_time is None else mean_of(spec.work_time)
    return spec.workers / time if time else math.inf
