"""Layouts in the VDMA's LIF for `desim import`: JSON, versions 1.0 and 2.0, in m and rad, y upwards.

- A file contains no batteries, fleets or tasks. Many files break the schema, so reading is lenient: clear errors, such
as a number written as text or a missing list of stations, are corrected and reported under `changed`. `--strict`
refuses them instead.
- An edge is one-way, and two opposite edges are a two-way aisle; `--two-way` makes every edge lead both ways.
- A vehicle type may not use edges or nodes that do not list it. The type with most edges is read, or `--vehicle-type
NAME`.
- Several layouts are read together: an edge between levels is a lift, in both directions, and an edge between layouts
of one level is a ramp. Levels that lie over each other are drawn side by side. `--layout NAME` reads one layout.
- An edge with a trajectory is as long as its curve. If the curve is invalid, or leads elsewhere, the edge is taken to
be straight and reported as doubtful, as are angles beyond a full turn and links of hundreds of metres (degrees, or
millimetres?).
- The actions of a station's nodes (`pick`, `drop`, `startCharging`, ...), or else the station's name, tell what robots
do there. `--operation` maps either.
- Directions of driving, rotation, heights and loads are reported as left out: robots turn at nodes and may use every
lane, loaded or not.

Source: VDMA, Layout Interchange Format (LIF), version 1.0.0, 2024.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from desim_warehouse.errors import did_you_mean, got
from desim_warehouse.model.json_text import read_json
from desim_warehouse.plants import lif_keys
from desim_warehouse.plants.checks import distance
from desim_warehouse.plants.keyed import POSITION, Reader
from desim_warehouse.plants.levels import draw_apart
from desim_warehouse.plants.plant import Link, Location, Plant, Waypoint, claim, unique
from desim_warehouse.plants.stops import NONE, sounds_like

Item = dict[str, Any]

EXPECTED = "a layout in LIF (JSON)"
OPTIONS = ("layout", "vehicle_type", "two_way", "strict")
_MOST = 3_000_000  # values: LIF has many words for an edge
_LETTER = "to the letter of LIF 1.0"
_OPEN = "lists no vehicle type, which says that none may use it; taken to be open to all"
_TYPES = 1000  # types of vehicles, at most
_FIT = 0.05  # of the distance between the nodes: if the ends of a trajectory are off by more, it belongs elsewhere
_RAMP = 1.0  # metres, the least length of a ramp

_STEEPEST = 30  # degree
_NODES = 16  # of the quadrature
_AGREE = 1e-9  # of the length
_HALVED = 20  # times at most: a cusp converges slowly


def looks(path: Path, start: bytes) -> bool:
    """Return whether a file may be in LIF, by its name or its first keys."""
    named = path.name.lower().endswith((".lif", ".lif.json"))
    keys = (b'"metaInformation"', b'"lifVersion"', b'"layouts"', b'"origins"')
    return named or (start.startswith(b"{") and any(key in start for key in keys))


def read(
    path: Path,
    content: bytes,
    *,
    layout: str | None = None,
    vehicle_type: str | None = None,
    two_way: bool = False,
    strict: bool = False,
) -> Plant:
    """Read a plant from a LIF file.

    Args:
        path: the file.
        content: its bytes.
        layout: the only layout to read, by layoutId or layoutName; default: all.
        vehicle_type: the vehicle type whose nodes and edges are read; default: the type that may use most edges.
        two_way: whether every edge is meant in both directions, as some programs write it.
        strict: whether deviations from the schema of version 1.0 are errors.

    Raises:
        ModelError: the file cannot be read, with the JSON path.
    """
    data = read_json(path, content, EXPECTED, _MOST)
    second = not strict and isinstance(data, dict) and lif_keys.is_2(data, content)
    reader = Reader(str(path), strict, complete=not second)
    if second:
        about = data.get("metaInformation", {})
        about = lif_keys.renamed(about) if isinstance(about, dict) else about
        about = reader.read(about, lif_keys.META, "metaInformation")
        reader.unknown.append((tuple(key for key in data if key not in lif_keys.TOP), "the top level"))
        layouts = [
            _Layout(reader.read(item, lif_keys.LAYOUT, position), origin)
            for position, origin, item in lif_keys.layouts_of(data)
        ]
    else:
        made = reader.read(data, lif_keys.FILE, "")
        about, layouts = made.get("metaInformation", {}), [_Layout(item, "") for item in made["layouts"]]
    version = about.get("lifVersion", "")
    plant = Plant(about.get("projectIdentification") or path.name.partition(".")[0] or "plant", "")
    plant.source = f"{path.name} (LIF{f', version {version}' if version else ''})"
    drawn = _Drawn(reader, plant, layouts, layout)
    reader.finish(plant, _LETTER)
    if second and version not in lif_keys.RELEASED:
        plant.note("doubtful", "version", [version or "none"], "keys of LIF 2; read as version 2.0.0")
    elif not second and version and version.split(".")[0] not in {"0", "1"}:
        plant.note("doubtful", "version", [version], "not known; read as version 1.0")
    drawn.fill(vehicle_type)
    if two_way:
        plant.links = [replace(link, speed_back=link.speed) for link in plant.links]
    return plant


class _Layout(NamedTuple):
    """A layout as it was read, and the origin of its coordinates."""

    item: Item
    origin: str

    @property
    def name(self) -> str:
        return str(self.item.get("layoutId") or self.item[POSITION])

    @property
    def level(self) -> str:
        return " ".join(filter(None, (self.origin, self.item.get("layoutLevelId"))))


class _Node(NamedTuple):
    item: Item
    layout: _Layout
    types: frozenset[str] | None  # of vehicles that may use it; None: all


class _Edge(NamedTuple):
    name: str
    item: Item
    source: str
    target: str
    types: frozenset[str] | None


class _Drawn:
    """The layouts that are read, combined: nodes by names that are unique in the plant, edges, and stations."""

    def __init__(self, reader: Reader, plant: Plant, layouts: Sequence[_Layout], asked: str | None) -> None:
        self.reader = reader
        self.plant = plant
        self.nodes: dict[str, _Node] = {}
        self.edges: list[_Edge] = []
        self.stations: list[tuple[Item, list[str]]] = []
        chosen = [
            layout for layout in layouts if asked in {None, layout.item.get("layoutId"), layout.item.get("layoutName")}
        ]
        if not chosen:
            expected, hint = _one_of(asked or "", [layout.name for layout in layouts])
            reader.refuse("layouts", f"no layout {got(asked)}, expected {expected}{hint}")
        others = [layout for layout in layouts if layout not in chosen]
        plant.note("left out", "layout", [layout.name for layout in others], "another one is asked for")
        own = [self.add_nodes(layout) for layout in chosen]
        everywhere = {key: name for names in reversed(own) for key, name in names.items()}
        elsewhere = {node["nodeId"] for layout in others for node in layout.item["nodes"]} - everywhere.keys()
        for layout, here in zip(chosen, own, strict=True):
            names = {**everywhere, **here} if len(chosen) > 1 else here
            self.add_edges(layout, names, elsewhere)
            for station in layout.item.get("stations", ()):
                keys = station.get("interactionNodeIds", [])
                self.stations.append((station, [names[key] for key in keys if key in names]))
                for key in keys:
                    if key not in names and key not in elsewhere:
                        reader.wrong(station[POSITION], f"no node {got(key)}", "left out")

    def add_nodes(self, layout: _Layout) -> dict[str, str]:
        """Add the nodes of a layout, and return their names in the plant by nodeId."""
        names: dict[str, str] = {}
        for node in layout.item["nodes"]:
            key = node["nodeId"]
            if key in names:
                self.reader.wrong(node[POSITION], f"a node {got(key)} stands before", "left out")
                continue
            names[key] = key if key not in self.nodes else unique(f"{layout.name} {key}", self.nodes)
            if names[key] != key:
                self.reader.wrong(node[POSITION], f"a node {got(key)} stands before, in another layout", "renamed")
            self.nodes[names[key]] = _Node(node, layout, _types(node.get("vehicleTypeNodeProperties")))
        return names

    def add_edges(self, layout: _Layout, nodes: dict[str, str], elsewhere: set[str]) -> None:
        """Add the edges of a layout between `nodes` (names by nodeId); note edges that lead elsewhere."""
        left = []
        for edge in layout.item.get("edges", ()):
            ends = edge["startNodeId"], edge["endNodeId"]
            name = edge.get("edgeId") or " - ".join(ends)
            unknown = [end for end in ends if end not in nodes]
            if not unknown:
                types = _types(edge.get("vehicleTypeEdgeProperties"))
                self.edges.append(_Edge(name, edge, nodes[ends[0]], nodes[ends[1]], types))
            elif all(end in elsewhere for end in unknown):
                left.append((name, edge[POSITION]))
            else:
                self.reader.wrong(edge[POSITION], f"no node {got(unknown[0])}", "left out")
        names, positions = [name for name, _ in left], [position for _, position in left]
        self.plant.note("left out", "transition", names, "to a layout that is not read", positions)

    def vehicle_type(self, asked: str | None) -> str | None:
        """Return the vehicle type to read, by default the type with most edges; None if the file has no types."""
        parts: list[_Node | _Edge] = [*self.nodes.values(), *self.edges]
        every = dict.fromkeys(kind for part in parts for kind in sorted(part.types or ()))
        if len(every) > _TYPES:
            self.reader.refuse("layouts", f"too many types of vehicles, expected {_TYPES:,} at most")
        if asked is not None and asked not in every:
            expected, hint = _one_of(asked, list(every))
            self.reader.refuse("layouts", f"no vehicle type {got(asked)}, expected {expected}{hint}")
        counts: Counter[str] = Counter()
        for edge in self.edges:
            ends = [self.nodes[end].types for end in (edge.source, edge.target)]
            counts.update(kind for kind in edge.types or every if all(types is None or kind in types for types in ends))
        chosen = asked or max(every, key=lambda kind: counts[kind], default=None)
        others = [kind for kind in every if kind != chosen]
        why = f"one is read, '{chosen}'; --vehicle-type reads another"
        self.plant.note("left out", "vehicle type", others, why)
        return chosen

    def fill(self, asked: str | None) -> None:
        """Fill the plant with the nodes, edges and stations that a vehicle type may use."""
        plant, kind = self.plant, self.vehicle_type(asked)
        nodes, edges = self.allowed(kind)
        for name, node in nodes.items():
            x, y = (node.item["nodePosition"][axis] for axis in "xy")
            plant.points[name] = Waypoint(name, x, -y if y else 0.0, position=node.item[POSITION])
        kept = self.add_links(nodes, edges, kind)
        open_ = [plant.points[name] for name, node in nodes.items() if node.item.get("vehicleTypeNodeProperties") == []]
        plant.note_parts("changed", "node", open_, _OPEN)
        empty = {edge.item[POSITION] for edge in edges if edge.item.get("vehicleTypeEdgeProperties") == []}
        plant.note_parts("changed", "edge", [link for link in plant.links if link.position in empty], _OPEN)
        on_nodes = [(name, _of(node.item.get("vehicleTypeNodeProperties"), kind)) for name, node in nodes.items()]
        self.add_locations(dict(on_nodes))
        lif_keys.note_edges(plant, kept)
        lif_keys.note_nodes(plant, on_nodes, [station for station, _ in self.stations])
        plant.level_of = {name: node.layout.level for name, node in nodes.items()}
        plant.levels = _in_order(dict.fromkeys(plant.level_of.values()))
        draw_apart(plant)

    def add_links(self, nodes: dict[str, _Node], edges: list[_Edge], kind: str | None) -> list[tuple[Link, Item]]:
        """Add the edges as links; return the added links, each with its properties for the vehicle type."""
        plant = self.plant
        kept: list[tuple[Link, Item]] = []
        closed: list[Link] = []
        ramps: list[Link] = []
        rides: list[Link] = []
        called: dict[str, str] = {}
        odd: dict[str, list[Link]] = {}
        for edge in edges:
            item = _of(edge.item.get("vehicleTypeEdgeProperties"), kind)
            length, wrong = _length(plant, edge, item)
            speed, carried = item.get("maxSpeed", math.inf), item.get("loadRestriction", {})
            if nodes[edge.source].layout is not nodes[edge.target].layout:
                length = max(distance(plant, edge.source, edge.target) if length is None else length, _RAMP)
            link = Link(edge.name, edge.source, edge.target, length, speed, position=edge.item[POSITION])
            if speed <= 0 or not (carried.get("unloaded", True) or carried.get("loaded", True)):
                closed.append(link)
                continue
            if wrong:
                odd.setdefault(wrong, []).append(link)
            if nodes[edge.source].layout.level != nodes[edge.target].layout.level:
                rides.append(link)
                called[link.name] = edge.item.get("edgeName", "")
                continue
            if nodes[edge.source].layout is not nodes[edge.target].layout:
                ramps.append(link)
            kept.append((link, item))
        plant.links = [link for link, _ in kept]
        plant.note_parts("left out", "edge", closed, "closed, by a speed of 0 or for robots with and without a load")
        why = f"to another layout of the level by a ramp, which takes as long as driving there, {_RAMP:g} m or more"
        plant.note_parts("changed", "transition", ramps, why)
        self.add_lifts(rides, called, {name: node.layout.level for name, node in nodes.items()})
        for why, links in odd.items():
            plant.note_parts("doubtful", "trajectory", links, why)
        return kept

    def add_lifts(self, rides: list[Link], called: Mapping[str, str], level_of: Mapping[str, str]) -> None:
        """Add a lift for nodes on several levels that edges join, or one per pair of them if a level has two of them.

        The name of a lift is the name of its first edge (`called`), or else its ends.
        """
        import networkx as nx

        order = _in_order(dict.fromkeys(level_of.values()))
        joined = nx.Graph([(link.source, link.target) for link in rides])
        for part in list(nx.connected_components(joined)):
            levels = [level_of[name] for name in part]
            one_each = len(set(levels)) == len(levels)
            for stops in [part] if one_each else [{*pair} for pair in joined.subgraph(part).edges]:
                nodes = sorted(stops, key=lambda name: order.index(level_of[name]))
                name = next((called[link.name] for link in rides if {link.source, link.target} <= stops), "")
                self.plant.lifts[unique(name or f"lift {nodes[0]} - {nodes[-1]}", self.plant.lifts)] = tuple(nodes)
        why = "to another level: a lift for one robot at a time, in both directions"
        self.plant.note_parts("changed", "transition", rides, why)

    def add_locations(self, on_nodes: dict[str, Item]) -> None:
        """Add stations, and nodes with actions that belong to no station.

        The actions of its nodes tell what robots do at a station, and its type if that is a word for it; if both are
        missing, its name.
        """
        plant = self.plant
        served: set[str] = set()
        outside: list[Item] = []
        taken: set[str] = set()
        for station, nodes in self.stations:
            name = claim(station["stationId"], taken)
            here = {point: _actions(on_nodes[point]) for point in nodes if point in on_nodes}
            served |= here.keys()
            if nodes and not here:
                outside.append(station)
                continue
            kind = station.get("stationType", "")
            own = (kind,) if sounds_like(kind) != NONE else ()
            usual = () if any(here.values()) else own or (station.get("stationName") or name,)
            doing = {point: tuple(dict.fromkeys((*actions, *own))) or usual for point, actions in here.items()}
            plant.locations.append(Location(name, doing, station[POSITION]))
        names, positions = [station["stationId"] for station in outside], [station[POSITION] for station in outside]
        plant.note("left out", "station", names, "only at nodes that are left out", positions)
        for point, item in on_nodes.items():
            if point not in served and (actions := _actions(item)):
                plant.locations.append(Location(point, {point: actions}, plant.points[point].position))

    def allowed(self, kind: str | None) -> tuple[dict[str, _Node], list[_Edge]]:
        """Return the nodes and edges that a vehicle type may use; the others are noted as left out."""
        nodes = {name: node for name, node in self.nodes.items() if node.types is None or kind in node.types}
        edges: list[_Edge] = []
        closed: list[_Edge] = []
        for edge in self.edges:
            free = (edge.types is None or kind in edge.types) and edge.source in nodes and edge.target in nodes
            (edges if free else closed).append(edge)
        others = {name: node for name, node in self.nodes.items() if name not in nodes}
        why = f"not for vehicle type '{kind}'"
        self.plant.note("left out", "node", others, why, [node.item[POSITION] for node in others.values()])
        why += ", or from or to a node that is not"
        self.plant.note(
            "left out", "edge", [edge.name for edge in closed], why, [edge.item[POSITION] for edge in closed]
        )
        return nodes, edges


def _in_order(levels: Iterable[str]) -> tuple[str, ...]:
    """Sort levels from the lowest up: by their numbers if all have numbers, else in the order of the file."""
    listed = tuple(levels)
    try:
        return tuple(sorted(listed, key=float))
    except ValueError:
        return listed


def _types(properties: Sequence[Item] | None) -> frozenset[str] | None:
    """Return the vehicle types that a node or edge lists; None (all types) if it lists none or a nameless one."""
    listed = [entry.get("vehicleTypeId") for entry in properties or ()]
    return frozenset(kind for kind in listed if kind is not None) if listed and None not in listed else None


def _of(properties: Sequence[Item] | None, kind: str | None) -> Item:
    """Return the properties of a node or edge for a vehicle type; empty if it lists none."""
    return next((entry for entry in properties or () if entry.get("vehicleTypeId") in {None, kind}), {})


def _actions(item: Item) -> tuple[str, ...]:
    return tuple(dict.fromkeys(action["actionType"] for action in item.get("actions", ()) if action.get("actionType")))


def _one_of(asked: str, names: list[str]) -> tuple[str, str]:
    """Return words for an unknown name: the expected names, and a hint at the nearest."""
    return f"one of {', '.join(names)}" if names else "none", did_you_mean(asked, names)


def _length(plant: Plant, edge: _Edge, item: Item) -> tuple[float | None, str]:
    """Return the length of an edge along its trajectory (None: straight), and words for a faulty trajectory."""
    trajectory = item.get("trajectory")
    if trajectory is None:
        return item.get("physicalLineGuidedProperty", {}).get("length") or None, ""
    points = [(point.get("x", math.nan), point.get("y", math.nan)) for point in trajectory.get("controlPoints", ())]
    weights = [point.get("weight", 1.0) for point in trajectory.get("controlPoints", ())]
    try:
        if any(math.isnan(x) or math.isnan(y) for x, y in points):
            raise ValueError("a control point without x or y")  # noqa: TRY301 - said with the others
        degree = trajectory.get("degree", 1.0)
        if not degree.is_integer():
            raise ValueError(f"of degree {degree:g}")  # noqa: TRY301
        length = arc_length(int(degree), trajectory.get("knotVector", ()), points, weights)
    except ValueError as error:
        return None, f"not a curve ({error}), so the edge is taken to be straight"
    straight, chord = distance(plant, edge.source, edge.target), math.dist(points[0], points[-1])
    if abs(straight - chord) > _FIT * max(straight, chord) or not length > 0:
        return None, "does not lead from one node of its edge to the other, so the edge is taken to be straight"
    return length, ""


def arc_length(
    degree: int, knots: Sequence[float], points: Sequence[tuple[float, float]], weights: Sequence[float]
) -> float:
    """Return the length of a non-uniform rational B-spline (NURBS), from its first knot of full support to its last.

    Source: L. Piegl, W. Tiller, The NURBS Book (2nd ed., Springer 1997): a rational curve is a B-spline in homogeneous
    coordinates, divided by its weight. The length is integrated with Gauss-Legendre quadrature between the knots; parts
    are halved until the halves agree with the whole.

    Args:
        degree: degree of the pieces, from 1 to 30.
        knots: knots in ascending order, as many as points plus degree + 1.
        points: control points, at least degree + 1.
        weights: weights of the control points, above 0.

    Raises:
        ValueError: these values define no curve, with the reason.
    """
    count = len(points)
    if not 1 <= degree <= _STEEPEST:
        raise ValueError(f"of degree {degree}")
    if count <= degree or len(knots) != count + degree + 1:
        raise ValueError(f"{count} control points and {len(knots)} knots for degree {degree}")
    if any(b < a for a, b in pairwise(knots)) or knots[degree] == knots[count]:
        raise ValueError("knots that fall, or are all the same")
    if min(weights) <= 0:
        raise ValueError("weights that are not above 0")
    if degree == 1:  # along a straight line weights change only the speed
        return sum(math.dist(a, b) for a, b in pairwise(points))
    return _integrated(degree, knots, points, weights)


def _integrated(
    degree: int, knots: Sequence[float], points: Sequence[tuple[float, float]], weights: Sequence[float]
) -> float:
    import numpy as np
    from scipy.interpolate import BSpline

    scale = np.asarray(weights, dtype=float)[:, None]
    curve = BSpline(np.asarray(knots, dtype=float), np.hstack([points * scale, scale]), degree)
    nodes, share = np.polynomial.legendre.leggauss(_NODES)

    def lengths(starts: Any, ends: Any) -> Any:
        """Return the lengths of parts of the curve, each inside one span of the knots."""
        half = (ends - starts) / 2
        where = starts[:, None] + half[:, None] * (nodes + 1)
        (x, y, weight), (dx, dy, change) = (np.moveaxis(curve(where, nu), -1, 0) for nu in (0, 1))
        return np.hypot(dx * weight - x * change, dy * weight - y * change) / weight**2 @ share * half

    corners = np.unique(knots[degree : len(points) + 1])
    starts, ends = corners[:-1], corners[1:]
    parts = lengths(starts, ends)
    tolerance = _AGREE * max(float(parts.sum()), 1e-12)
    whole = 0.0
    for _ in range(_HALVED):
        middles = (starts + ends) / 2
        left, right = lengths(starts, middles), lengths(middles, ends)
        again = np.abs(left + right - parts) > tolerance / max(len(parts), 1)
        whole += float((left + right)[~again].sum())
        starts, ends = np.r_[starts[again], middles[again]], np.r_[middles[again], ends[again]]
        parts = np.r_[left[again], right[again]]
    return whole + float(parts.sum())
