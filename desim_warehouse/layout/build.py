"""Construction of a Layout from the layout section of a model file."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

from desim_warehouse.errors import LayoutError, number_of
from desim_warehouse.layout import blocks as generator
from desim_warehouse.layout.aisles import width_of
from desim_warehouse.layout.layout import BayPlaces, Edge, Layout, StationPlaces, StoragePlace
from desim_warehouse.layout.naming import named_by
from desim_warehouse.layout.shafts import add_lifts, stand_cabins
from desim_warehouse.layout.spec import BaySpec, LayoutSpec, NodeStorage, PlacesSpec, Storage
from desim_warehouse.layout.zones import Members, edges_along, edges_of

if TYPE_CHECKING:
    import networkx as nx


@lru_cache(maxsize=4)
def build(spec: LayoutSpec, *limits: tuple[Members, float]) -> Layout:
    """Return the Layout that a layout section describes.

    `limits`: parts of the floor, each with its speed limit in length units per second (`Model.floor` passes those of
    its slow zones). The runs of a study share the result, so it must not be changed.

    Raises:
        LayoutError: two bays, stations or lifts at one node, or parts that contradict each other.
    """
    import networkx as nx

    if spec.blocks is not None:
        graph = generator.highways(spec.blocks)
        if spec.edges or spec.blocks.two_way:
            _draw(graph, spec)
        storage = generator.storage(spec.blocks, graph)
        size = spec.blocks.goods_size
    else:
        graph = nx.DiGraph()
        for name, (x, y) in spec.nodes.items():
            graph.add_node(name, x=x, y=y)
        _draw(graph, spec)
        storage = tuple(_place(graph, number, item) for number, item in enumerate(spec.storage))
        size = 0.0
    stand_cabins(graph, spec.lifts)
    bays = {bay.node: bay for name, item in spec.bays.items() for bay in _bays(name, item, places_of(graph, item))}
    stations = {
        node: StationPlaces(name, node, station.places, station.servers)
        for name, station in spec.stations.items()
        for node in places_of(graph, station)
    }
    for bay in bays.values():
        if bay.in_lane:
            graph.nodes[bay.node]["in_lane"] = True
    for members, speed in limits:
        for edge in edges_of(Layout(graph, (), {}, {}), members):
            graph.edges[edge]["speed"] = min(graph.edges[edge]["speed"], speed)
    _only_once("lift", [node for lift in spec.lifts.values() for node in lift.nodes])
    lifts = add_lifts(graph, spec.lifts)
    nx.freeze(graph)
    _only_once("bay", [node for bay in spec.bays.values() for node in places_of(graph, bay)])
    _only_once("station", [node for item in spec.stations.values() for node in places_of(graph, item)])
    widths = _widths(graph, spec)
    layout = Layout(graph, storage, bays, stations, size, _names(spec, storage), lifts, widths, spec.floors)
    _one_label_each(layout)
    _one_name_each(layout)
    _places_apart(layout)
    return layout


def _one_label_each(layout: Layout) -> None:
    """Raise LayoutError for two edges with the same label, by which logs and tables could not tell them apart."""
    edges: dict[str, Edge] = {}
    for label, edge in layout.labels:
        other = edges.setdefault(label, edge)
        if other != edge:
            both = " and ".join(f"[{', '.join(ends)}]" for ends in (other, edge))
            raise LayoutError([f"layout: edges {both} have one name in tables, {label}; rename one of their nodes"])


def _one_name_each(layout: Layout) -> None:
    """Raise LayoutError for a floor with two names."""
    names: dict[int, str] = {}
    for name, nodes in layout.floor_nodes.items():
        for node in nodes:
            if names.setdefault(layout.floors[node], name) != name:
                other = names[layout.floors[node]]
                text = f"node {node} is on floor {other!r}, from where robots drive there; give the floor one name"
                raise LayoutError([f"layout.floors.{name}: {text}"])


def _widths(graph: nx.DiGraph, spec: LayoutSpec) -> dict[Edge, float]:
    """Return the widths of aisles that are not narrow throughout, by edge; inf means wide."""
    if isinstance(spec.aisles, Mapping):
        floor, widths = Layout(graph, (), {}, {}), dict[Edge, float]()
        for name, aisles in spec.aisles.items():
            for line in aisles.along:
                off = [(a, b) for a, b in pairwise(line) if not graph.has_edge(a, b) and not graph.has_edge(b, a)]
                if off:
                    text = f"no edge between {off[0][0]} and {off[0][1]}, expected nodes along edges"
                    raise LayoutError([f"layout.aisles.{name}: {text}"])
                for edge in edges_along(floor, line):
                    if widths.setdefault(edge, width_of(aisles.width)) != width_of(aisles.width):
                        text = f"{edge[0]}>{edge[1]} has another width in aisles before it; give it one"
                        raise LayoutError([f"layout.aisles.{name}: {text}"])
        return widths
    width = width_of(spec.aisles)
    return dict.fromkeys(graph.edges, width) if width else {}


def _places_apart(layout: Layout) -> None:
    """Refuse storage places with the name of a node or station, by which rows of orders mean that one."""
    others = {*layout.graph, *(station.zone for station in layout.stations.values())}
    if both := [name for name in layout.place_names if name in others]:
        text = f"{both[0]!r} is also a node or station, which orders then mean; expected names of their own"
        raise LayoutError([f"layout.storage_names: {text}"])


def _names(spec: LayoutSpec, storage: tuple[StoragePlace, ...]) -> dict[str, int]:
    """Return the numbers of storage places by their names."""
    names = spec.storage_names
    if names is None:
        return {}
    if names.pattern is not None:
        pairs = list(named_by(names.pattern, names.levels, storage))
        doubled = [name for name, number in Counter(name for name, _ in pairs).items() if number > 1]
        if doubled:
            text = f"{len(doubled)} names are those of several places, such as {doubled[0]!r}; add a field to it"
            raise LayoutError([f"layout.storage_names.pattern: {text}"])
        return dict(pairs)
    beyond = [name for name, number in names.places.items() if number >= len(storage)]
    if beyond:
        text = f"{beyond[0]!r} is place {names.places[beyond[0]]}, expected 0 to {len(storage) - 1}"
        raise LayoutError([f"layout.storage_names: {text}"])
    return dict(names.places)


def _bays(name: str, bay: BaySpec, nodes: list[str]) -> Iterator[BayPlaces]:
    """Yield the bays of a zone; total_chargers are dealt out to its nodes round-robin, in their order."""
    total = bay.total_chargers
    if total is not None and bay.places is not None and not bay.grows and total > bay.places * len(nodes):
        at_each = f"{number_of(len(nodes), 'node')} with {number_of(bay.places, 'place')} each"
        most = f"{at_each}, expected at most {bay.places * len(nodes)}"
        raise LayoutError([f"layout.bays.{name}.total_chargers: too many (got {total}); {most}"])
    for rank, node in enumerate(nodes):
        chargers = bay.chargers if total is None else total // len(nodes) + (rank < total % len(nodes))
        places = 1 if bay.in_lane else bay.places
        yield BayPlaces(name, node, places, chargers, bay.in_lane, bay.outages, total is not None, bay.grows, bay.kinds)


def places_of(graph: nx.DiGraph, places: PlacesSpec) -> list[str]:
    """Return the nodes of a zone of bays or stations: those listed by name, then every n-th along a side of the floor.

    A side is counted from west to east, or from north to south.
    """
    return places.nodes({name: (data["x"], data["y"]) for name, data in graph.nodes(data=True)})


def _only_once(what: str, nodes: list[str]) -> None:
    doubled = sorted(node for node, number in Counter(nodes).items() if number > 1)
    if doubled:
        raise LayoutError([f"layout: node {node} has more than one {what}; give it one" for node in doubled])


def _draw(graph: nx.DiGraph, spec: LayoutSpec) -> None:
    """Add the listed edges to the nodes, or to the aisles of blocks."""
    beside = {frozenset((edge.source, edge.target)) for edge in spec.edges if edge.side_by_side}
    points = {name: (data["x"], data["y"]) for name, data in graph.nodes(data=True)}
    for edge in spec.edges:
        length, speed = edge.length or math.dist(points[edge.source], points[edge.target]), edge.speed or math.inf
        graph.add_edge(edge.source, edge.target, length=length, speed=speed)
        if edge.two_way:
            graph.add_edge(edge.target, edge.source, length=length, speed=edge.speed_back or speed)
    _backwards(spec)
    _join_twins(graph, beside)
    _prefer(graph, spec)


def _backwards(spec: LayoutSpec) -> None:
    """Raise LayoutError for a speed limit back on an edge that is not two-way."""
    wrong = [
        f"layout.edges[{rank}].speed_back: {edge.source}>{edge.target} is not two-way; say two_way: true, or give the "
        "edge back a speed of its own"
        for rank, edge in enumerate(spec.edges)
        if edge.speed_back is not None and not edge.two_way
    ]
    if wrong:
        raise LayoutError(wrong)


def _prefer(graph: nx.DiGraph, spec: LayoutSpec) -> None:
    """Record the factor by which an edge against a preferred direction counts in the choice of routes."""
    wrong = []
    for rank, edge in enumerate(spec.edges):
        if edge.against == 1:
            continue
        where = f"layout.edges[{rank}].against"
        back = graph.edges.get((edge.target, edge.source))
        if back is None:
            wrong.append(
                f"{where}: nobody drives from {edge.target} to {edge.source}, as {edge.source}>{edge.target} leads one "
                "way; leave it out, or say two_way: true"
            )
        elif "counts" in graph.edges[edge.source, edge.target]:
            wrong.append(f"{where}: both {edge.source}>{edge.target} and the edge back have it; leave out one of them")
        else:
            back["counts"] = edge.against
    if wrong:
        raise LayoutError(wrong)


def _join_twins(graph: nx.DiGraph, beside: set[frozenset[str]]) -> None:
    """Mark two opposite edges as one two-way lane, unless they are side by side."""
    unequal = []
    for source, target, data in graph.edges(data=True):
        back = graph.edges.get((target, source))
        data["two_way"] = back is not None and frozenset((source, target)) not in beside
        if data["two_way"] and source < target and back["length"] != data["length"]:
            unequal.append(
                f"layout: edges {source}>{target} and {target}>{source} differ in length, but are one two-way "
                "lane; make them equal, or set side_by_side: true where there are two lanes"
            )
    if unequal:
        raise LayoutError(unequal)


def _place(graph: nx.DiGraph, number: int, item: Storage | NodeStorage) -> StoragePlace:
    edge, offset = ((item.node, item.node), 0.0) if isinstance(item, NodeStorage) else (item.edge, item.offset)
    x, y = Layout(graph, (), {}, {}).position(edge, offset)
    return StoragePlace(number, edge, offset, x, y, item.popularity)
