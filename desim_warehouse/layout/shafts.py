"""Lifts as parts of the graph: rides between their nodes, and cabins side by side, each with its own lanes."""

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
"""Number of directions, from a node in front of the doors, in which a cabin may be drawn."""


def stand_cabins(graph: nx.DiGraph, specs: Mapping[str, LiftSpec]) -> None:
    """Add the cabin nodes of lifts given by the nodes in front of their doors, each with a lane in and a lane out.

    Raises:
        LayoutError: the name of such a node is already taken.
    """
    for name, spec in specs.items():
        for front, node in zip(spec.fronts, spec.stops(name), strict=False):
            assert spec.lane is not None
            _is_new(graph, f"layout.lifts.{name}.at", node)
            place = _roomiest(graph, front, [spec.lane * turn for turn in _turns(0)])
            graph.add_node(node, x=place.real, y=place.imag)
            for edge in ((front, node), (node, front)):
                graph.add_edge(*edge, length=spec.lane, speed=math.inf, two_way=False)


def add_lifts(graph: nx.DiGraph, specs: Mapping[str, LiftSpec]) -> tuple[Lift, ...]:
    """Add the further cabins and the rides of lifts to a graph, and return the lifts; each cabin is a lift of its own.

    Raises:
        LayoutError: an edge already joins two floors of a lift, or the name of a cabin's node is already taken.
    """
    lifts = tuple(lift for name, spec in specs.items() for lift in _cabins(graph, name, spec))
    for lift in lifts:
        _add_rides(graph, lift)
    return lifts


def _cabins(graph: nx.DiGraph, name: str, spec: LiftSpec) -> Iterator[Lift]:
    people = spec.people and spec.people.model_copy(update={"per_hour": spec.people.per_hour / spec.cabins})
    stops = spec.stops(name)
    rank = None if spec.rests is None else (spec.fronts or spec.nodes).index(spec.rests)
    for number in range(1, spec.cabins + 1):
        nodes = stops if number == 1 else tuple(_beside(graph, name, node, f"{node} {number}") for node in stops)
        title, rests = name if number == 1 else f"{name} {number}", None if rank is None else nodes[rank]
        yield Lift(title, nodes, spec.ride, spec.doors, rests, people, spec.outages, name)


def _beside(graph: nx.DiGraph, lift: str, node: str, another: str) -> str:
    """Add the node of a further cabin, with lanes as at `node`, where there is most room round its front."""
    _is_new(graph, f"layout.lifts.{lift}.cabins", another)
    lanes = [*graph.in_edges(node, data=True), *graph.out_edges(node, data=True)]
    front = next((end for a, b, _ in lanes for end in (a, b) if end != node), node)
    arm = _point(graph, node) - _point(graph, front)
    place = _roomiest(graph, front, [arm * turn for turn in _turns(1)])
    graph.add_node(another, x=place.real, y=place.imag)
    for a, b, data in lanes:
        graph.add_edge(another if a == node else a, another if b == node else b, **data)
    return another


def _is_new(graph: nx.DiGraph, key: str, node: str) -> None:
    if node in graph:
        raise LayoutError([f"{key}: node {node!r} is there already; rename it"])


def _point(graph: nx.DiGraph, node: str) -> complex:
    return complex(graph.nodes[node]["x"], graph.nodes[node]["y"])


def _turns(first: int) -> list[complex]:
    """Return the rotations by multiples of a part of a circle, as complex numbers, from the multiple `first` on."""
    return [cmath.rect(1, 2 * math.pi * part / DIRECTIONS) for part in range(first, DIRECTIONS)]


def _roomiest(graph: nx.DiGraph, front: str, arms: list[complex]) -> complex:
    """Return the end of one of the arms that is farthest from other nodes and from the lanes of `front`.

    `arms`: vectors of equal length from `front`, as complex numbers.
    """
    origin, reach = _point(graph, front), abs(arms[0])
    others = [_point(graph, name) for name in graph if name != front]
    for name in (*graph.successors(front), *graph.predecessors(front)):
        way = _point(graph, name) - origin
        others.append(origin + way / abs(way) * reach)
    spots = [origin + arm for arm in arms]
    return max(spots, key=lambda spot: round(min(abs(spot - other) for other in others), 6))


def _add_rides(graph: nx.DiGraph, lift: Lift) -> None:
    """Join the nodes of a lift by an edge for each ride, with its mean time, including the wait for the cabin."""
    for start, end in permutations(lift.nodes, 2):
        if graph.has_edge(start, end):
            text = f"the edge {start}>{end} leads from floor to floor, as its rides do; leave it out of layout.edges"
            raise LayoutError([f"layout.lifts.{lift.name}: {text}"])
        takes = lift.mean_call(start) + lift.carrying(start, end)
        graph.add_edge(start, end, length=0.0, speed=math.inf, two_way=False, takes=takes)
