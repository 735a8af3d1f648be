"""Lifts as parts of the graph: rides between their nodes, and cabins side by side, each with lanes of its own."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Mapping
from itertools import permutations
from typing import TYPE_CHECKING

from desim_warehouse.errors import LayoutError
from desim_warehouse.layout.layout import Lift

if TYPE_CHECKING:
    import networkx as nx

    from desim_warehouse.layout.spec import LiftSpec

DIRECTIONS = 24
"""Directions from a node in front of the doors in which another cabin may be drawn."""


def add_lifts(graph: nx.DiGraph, specs: Mapping[str, LiftSpec]) -> tuple[Lift, ...]:
    """Add what lifts are to a graph and return them, with each of several cabins as a lift of its own.

    Raises:
        LayoutError: where a node or edge stands in the way.
    """
    lifts = tuple(lift for name, spec in specs.items() for lift in _cabins(graph, name, spec))
    for lift in lifts:
        _add_rides(graph, lift)
    return lifts


def _cabins(graph: nx.DiGraph, name: str, spec: LiftSpec) -> Iterator[Lift]:
    people = spec.people and spec.people.model_copy(update={"per_hour": spec.people.per_hour / spec.cabins})
    yield Lift(name, spec.nodes, spec.ride, spec.doors, spec.rests, people, spec.outages, name)
    for number in range(2, spec.cabins + 1):
        nodes = tuple(_beside(graph, name, node, f"{node} {number}") for node in spec.nodes)
        rests = None if spec.rests is None else nodes[spec.nodes.index(spec.rests)]
        yield Lift(f"{name} {number}", nodes, spec.ride, spec.doors, rests, people, spec.outages, name)


def _beside(graph: nx.DiGraph, lift: str, node: str, another: str) -> str:
    """Add the node of another cabin, with the lanes of a node, turned about its neighbour to where most room is."""
    if another in graph:
        raise LayoutError([f"layout.lifts.{lift}.cabins: node {another!r} is there already; rename it"])
    points = {name: complex(data["x"], data["y"]) for name, data in graph.nodes(data=True)}
    lanes = [*graph.in_edges(node, data=True), *graph.out_edges(node, data=True)]
    front = next((end for a, b, _ in lanes for end in (a, b) if end != node), node)
    spots = [
        points[front] + (points[node] - points[front]) * cmath.rect(1, 2 * math.pi * part / DIRECTIONS)
        for part in range(1, DIRECTIONS)
    ]
    others = [spot for name, spot in points.items() if name != front] + [
        points[front]
        + (points[name] - points[front]) / abs(points[name] - points[front]) * abs(points[node] - points[front])
        for name in (*graph.successors(front), *graph.predecessors(front))
    ]
    place = max(spots, key=lambda spot: round(min(abs(spot - other) for other in others), 6))
    graph.add_node(another, x=place.real, y=place.imag)
    for a, b, data in lanes:
        graph.add_edge(another if a == node else a, another if b == node else b, **data)
    return another


def _add_rides(graph: nx.DiGraph, lift: Lift) -> None:
    """Join the nodes of a lift by an edge for each ride, with the mean time that the ride takes, call included."""
    for start, end in permutations(lift.nodes, 2):
        if graph.has_edge(start, end):
            text = f"the edge {start}>{end} leads from floor to floor, as its rides do; leave it out of layout.edges"
            raise LayoutError([f"layout.lifts.{lift.name}: {text}"])
        takes = lift.mean_call(start) + lift.carrying(start, end)
        graph.add_edge(start, end, length=0.0, speed=math.inf, two_way=False, takes=takes)
