"""Findings on slow routes: places between which the shortest route takes far longer than the fastest.

For `desim check`.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, pairwise
from typing import Any

from desim_warehouse.errors import number_of
from desim_warehouse.findings import Finding, amount
from desim_warehouse.layout import Layout
from desim_warehouse.model import Model
from desim_warehouse.model.facts.places import destinations

FAR_SLOWER = 1.5
"""Ratio of the times of the shortest and the fastest route above which there is a warning."""
MOST = 40
"""Number of nodes between which routes are compared."""


def slow_ways(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find robots whose shortest route is far slower than another, because lanes have speed limits."""
    fastest = model.fleet.fastest
    limits = (data["speed"] for _, _, data in layout.graph.edges(data=True))
    if model.policies.routing.name != "shortest" or all(limit >= fastest for limit in limits):
        return
    slow = sorted(_compared(model, layout, fastest), key=lambda way: way[1] / way[0])
    if not slow:
        return
    short, quick, origin, goal = slow[0]
    unit = model.units.time
    text = f"from {origin} to {goal} the shortest way takes {amount(short)} {unit}, where {amount(quick)} {unit} do"
    if len(slow) > 1:
        text += f"; {number_of(len(slow), 'way')} between places of work and bays are that slow"
    yield Finding("SLOW_WAY", "policies.routing", text, "routing: fastest, which goes by time")


def _compared(model: Model, layout: Layout, speed: float) -> Iterator[tuple[float, float, str, str]]:
    """Yield pairs of places with a far faster route: times of the shortest and the fastest route, origin and goal."""
    import networkx as nx

    picked = (place.edge[1] for place in layout.storage)
    nodes = list(islice(dict.fromkeys((*destinations(model, layout), *layout.bays, *picked)), MOST))
    graph = layout.graph

    def length(_: str, __: str, data: Any) -> float:
        return float(data["length"] * data.get("counts", 1.0))

    def time(_: str, __: str, data: Any) -> float:
        return float(data["length"] / min(speed, data["speed"]) + data.get("takes", 0.0))

    for origin in nodes:
        paths = nx.single_source_dijkstra_path(graph, origin, weight=length)
        quickest = nx.single_source_dijkstra_path_length(graph, origin, weight=time)
        for goal in nodes:
            if goal == origin or goal not in paths:
                continue
            way = paths[goal]
            takes = sum(time(a, b, graph.edges[a, b]) for a, b in pairwise(way))
            if takes > FAR_SLOWER * quickest[goal]:
                yield takes, float(quickest[goal]), origin, goal
