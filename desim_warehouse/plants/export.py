"""Export of a model's layout to the formats that `read_layout` reads, with remarks on losses.

For `desim export`.
"""

from __future__ import annotations

import csv
import io
import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal, get_args
from xml.sax.saxutils import escape, quoteattr

from desim_warehouse.errors import ReportError, did_you_mean, got, reason
from desim_warehouse.folders import make_folder
from desim_warehouse.layout.layout import Edge, Layout
from desim_warehouse.model import Model, Source, as_model
from desim_warehouse.plants.checks import distance, length_of
from desim_warehouse.plants.plant import Area, Link, Location, Plant, Remark, Vehicle, Waypoint, claim, unique
from desim_warehouse.plants.tables import EDGES_FILE, NODES_FILE
from desim_warehouse.plants.write import one_line
from desim_warehouse.values.fields import Part

_AT_THE_END = 0.01
"""Distance in metres from the end of a lane up to which a storage place counts as at the node there."""
Row = dict[str, str | float | bool]
_DIGITS = 6  # of metres and metres a second
_EQUAL = 1e-6
_NODE_COLUMNS = ("name", "x", "y", "role", "station")
_EDGE_COLUMNS = ("from", "to", "length", "speed", "speed_back", "two_way", "side_by_side")
LayoutFormat = Literal["lif", "opentcs", "graphml", "csv", "rmf"]
LAYOUT_FORMATS: tuple[str, ...] = get_args(LayoutFormat)


def write_layout(model: Source, path: str | Path, format: str) -> tuple[Remark, ...]:  # noqa: A002 - as pandas and others
    """Write the layout of a model to a file for other programs, in metres and seconds.

    Args:
        model: the model.
        path: the file; for csv the folder for nodes.csv and edges.csv.
        format: lif (Layout Interchange Format of VDMA, 1.0.0), opentcs (a plant model, 7.0.0), graphml, csv or rmf (a
            building map of Open-RMF).

    Returns:
        Remarks on parts of the model that the format cannot represent, or that are changed.

    Raises:
        ReportError: another format, or a path that cannot be written.
        LayoutError: a layout that cannot be built, such as two bays at one node.
    """
    if format not in LAYOUT_FORMATS:
        hint = did_you_mean(format, LAYOUT_FORMATS)
        raise ReportError(f"format {got(format)}: expected one of {', '.join(LAYOUT_FORMATS)}{hint}")
    path, plant = Path(path), drawn(as_model(model))
    plain_names(plant)
    texts = _texts(plant, format)
    try:
        make_folder(path if format == "csv" else path.parent)
        for name, text in texts.items():
            (path / name if name else path).write_text(text, encoding="utf-8")
    except (OSError, ValueError) as error:
        raise ReportError(f"{path}: cannot be written ({reason(error)})") from None
    return tuple(plant.remarks)


def _texts(plant: Plant, form: str) -> dict[str, str]:
    """Return the texts to write by file name in the folder; a single file has the name ""."""
    if form == "rmf":
        from desim_warehouse.plants.to_rmf import rmf

        return {"": rmf(plant)}
    if form == "lif":
        from desim_warehouse.plants.to_lif import lif

        return {"": lif(plant)}
    lifts_as_lanes(plant)
    if form == "csv":
        return tables(plant)
    if form == "graphml":
        return {"": graphml(plant)}
    from desim_warehouse.plants.to_opentcs import opentcs

    return {"": opentcs(plant)}


def lifts_as_lanes(plant: Plant) -> None:
    """Replace lifts by lanes from floor to floor, for formats without levels; the change is noted in the plant."""
    for stops in plant.lifts.values():
        plant.links += [Link(f"{a}>{b}", a, b, None, math.inf, math.inf) for a, b in itertools.pairwise(stops)]
    plant.note("changed", "lift", plant.lifts, "a lane from floor to floor, on which several robots drive")


def drawn(model: Model) -> Plant:
    """Return the plant of a model, in metres and seconds, with remarks on losses.

    A storage place beside a lane becomes a point of the lane. Links are called `A>B`; a two-way lane by its first edge.

    Raises:
        LayoutError: a layout that cannot be built, such as two bays at one node.
    """
    plant = Plant(model.name, f"model '{model.name}'")
    metre = model.units.metre
    if metre is None:
        plant.note("changed", "unit", [model.units.length], "of unknown size, so taken for a metre")
        metre = 1.0
    return _Drawing(model, plant, model.floor, metre).plant


class _Drawing:
    """Converter of a model to a plant; `pieces` maps each lane to its links and points."""

    def __init__(self, model: Model, plant: Plant, layout: Layout, metre: float) -> None:
        self.model = model
        self.plant = plant
        self.layout = layout
        self.metre = metre
        self.pieces: dict[frozenset[str], list[str]] = {}
        self.loads: dict[str, int] = {}
        self.points()
        self.lanes()
        self.locations()
        self.fleet()
        self.zones()
        self.losses()

    def points(self) -> None:
        parking = {bay.node for bay in self.layout.bays.values() if bay.chargers == 0}
        for name, data in self.layout.graph.nodes(data=True):
            self.plant.points[name] = Waypoint(name, data["x"] * self.metre, data["y"] * self.metre, name in parking)
        if self.layout.lifts:
            names = self.layout.floor_names
            self.plant.level_of = {node: names[floor] for node, floor in self.layout.floors.items()}
            self.plant.levels = tuple(dict.fromkeys(names.values()))

    def lanes(self) -> None:
        """Add every lane as a link, or as several links with a point at each place where robots load."""
        stops: dict[Edge, dict[float, int]] = {edge: {} for edge in self.layout.lanes}
        for place in self.layout.storage:
            if place.edge[0] == place.edge[1]:
                self.loads[place.edge[0]] = self.loads.get(place.edge[0], 0) + 1
                continue
            edge, offset = place.edge, place.offset
            if edge not in stops:
                edge, offset = edge[::-1], self.layout.length(edge) - offset
            metres = round(offset * self.metre, 3)
            stops[edge][metres] = stops[edge].get(metres, 0) + 1
        for edge, counts in stops.items():
            if edge not in self.layout.rides:
                self.lane(edge, counts)
        self.plant.lifts = {lift.name: lift.nodes for lift in self.layout.lifts}
        added = [name for names in self.pieces.values() for name in names if name not in self.layout.graph]
        added = [name for name in added if name in self.plant.points]
        self.plant.note("changed", "point", added, "where robots load beside a lane, which is two links there")

    def lane(self, edge: Edge, stops: dict[float, int]) -> None:
        (a, b), data = edge, self.layout.graph.edges[edge]
        seconds = self.model.units.seconds
        length, speed = data["length"] * self.metre, data["speed"] * self.metre / seconds
        back = self.layout.graph.edges[b, a]["speed"] * self.metre / seconds if data.get("two_way") else 0.0
        beside = not data.get("two_way") and (b, a) in self.layout.graph.edges
        chain, names = [(a, 0.0)], []
        for metres, count in sorted(stops.items()):
            if not _AT_THE_END < metres < length - _AT_THE_END:
                end = a if metres <= _AT_THE_END else b
                self.loads[end] = self.loads.get(end, 0) + count
                continue
            name = unique(f"{a}-{b} {metres:g}", self.plant.points)
            x, y = self.layout.position(edge, metres / self.metre)
            self.plant.points[name] = Waypoint(name, x * self.metre, y * self.metre)
            if a in self.plant.level_of:
                self.plant.level_of[name] = self.plant.level_of[a]
            self.loads[name] = count
            chain.append((name, metres))
        chain.append((b, length))
        for (source, begin), (target, stop) in itertools.pairwise(chain):
            self.plant.links.append(
                Link(f"{source}>{target}", source, target, stop - begin, speed, back, side_by_side=beside)
            )
            names += [f"{source}>{target}", target]
        self.pieces[frozenset(edge)] = self.pieces.get(frozenset(edge), []) + names[:-1]

    def locations(self) -> None:
        stations: dict[str, dict[str, tuple[str, ...]]] = {}
        chargers: dict[str, dict[str, tuple[str, ...]]] = {}
        for node, station in self.layout.stations.items():
            stations.setdefault(station.zone, {})[node] = ("unload",)
        for node, bay in self.layout.bays.items():
            if bay.chargers != 0:
                chargers.setdefault(bay.zone, {})[node] = ("charge",)
        goods: dict[str, dict[str, tuple[str, ...]]] = {f"goods at {point}": {point: ("load",)} for point in self.loads}
        taken: set[str] = set()
        for wanted, operations in (*stations.items(), *chargers.items(), *goods.items()):
            self.plant.locations.append(Location(claim(wanted, taken), operations))

    def fleet(self) -> None:
        battery, fleet, seconds = self.model.battery, self.model.fleet, self.model.units.seconds
        critical = battery.threshold / battery.capacity if battery else None
        counts: dict[str, int] = {}
        for robot, kind in zip(fleet.robots(), fleet.kinds_of_robots(), strict=True):
            kind = kind or "robot"  # noqa: PLW2901 - ordinary robots have no kind
            counts[kind] = counts.get(kind, 0) + 1
            size, speed = 2 * robot.radius * self.metre, robot.speed * self.metre / seconds
            self.plant.vehicles.append(Vehicle(f"{kind} {counts[kind]}", size, speed, critical=critical))

    def zones(self) -> None:
        for name, zone in self.model.traffic.zones.items():
            members: list[str] = []
            for member in zone.members:
                members += [member] if isinstance(member, str) else self.pieces[frozenset(member)]
            self.plant.areas.append(Area(name, tuple(members), zone.rule))

    # What a plant does not have

    def losses(self) -> None:
        note, layout = self.plant.note, self.layout
        several = [point for point, count in self.loads.items() if count > 1]
        note("changed", "place", several, "several storage places, one when it is read again")
        popular = [str(place.number) for place in layout.storage if place.popularity != 1]
        names = [lift.name for lift in layout.lifts]
        note("left out", "lift", names, "only where it leads: times of rides and doors, people and outages are lost")
        note("left out", "popularity", popular, "of storage places: how often they are asked for")
        names = list(dict.fromkeys(station.zone for station in layout.stations.values()))
        note("left out", "station", names, "only where it is: places, servers, workers, hours and times are lost")
        names = list(dict.fromkeys(bay.zone for bay in layout.bays.values()))
        note("left out", "bay", names, "only where it is: how many slots and chargers it has is lost")
        names = [bay.node for bay in layout.bays.values() if bay.in_lane]
        note("left out", "bay in the lane", names, "that robots park on the node itself, and no route leads through it")
        counted = [">".join(edge) for *edge, times in layout.graph.edges(data="counts") if times]
        note("left out", "preferred direction", counted, "routes lead either way")
        note("left out", "section", list(self.sections()), "a layout has no work, policies or energy")

    def sections(self) -> Iterable[str]:
        """Yield what a layout cannot hold: the tasks, and sections, or parts of them, that differ from defaults."""
        model = self.model
        for key in ("calendars", "tasks", "battery", "people", "policies", "run", "cost", "prices", "accept"):
            if key == "tasks" or getattr(model, key) != type(model).model_fields[key].default:
                yield key
        if _unusual(model.traffic, {"zones"}):
            yield "traffic (but zones)"
        robots = any(_unusual(robot, {"radius", "speed"}) for robot in model.fleet.distinct())
        if robots or _unusual(model.fleet, {"size", "robot", "kinds"}):
            yield "fleet (but size, radius and speed of robots)"


def _unusual(part: Part, carried: set[str]) -> bool:
    """Return whether a section differs from its defaults in keys that a plant does not hold."""
    keys = type(part).model_fields
    return any(getattr(part, key) != description.default for key, description in keys.items() if key not in carried)


def plain_names(plant: Plant) -> None:
    """Rename a plant and its parts if their names are not plain; changes are noted in the plant."""
    points, positions = _plain(plant.points), _plain(location.name for location in plant.locations)
    links, areas = _plain(link.name for link in plant.links), _plain(area.name for area in plant.areas)
    plant.name = _trimmed(plant.name) or "layout"
    plant.points = {points[name]: replace(point, name=points[name]) for name, point in plant.points.items()}
    plant.links = [
        replace(link, name=links[link.name], source=points[link.source], target=points[link.target])
        for link in plant.links
    ]
    plant.locations = [
        Location(
            positions[location.name],
            {points[name]: allowed for name, allowed in location.operations.items()},
            location.position,
        )
        for location in plant.locations
    ]
    plant.lifts = {new: tuple(points[point] for point in plant.lifts[old]) for old, new in _plain(plant.lifts).items()}
    plant.level_of = {points[name]: level for name, level in plant.level_of.items()}
    members = {**links, **points}
    plant.areas = [
        replace(area, name=areas[area.name], members=tuple(members[name] for name in area.members))
        for area in plant.areas
    ]
    vehicles = _plain(vehicle.name for vehicle in plant.vehicles)
    plant.vehicles = [replace(vehicle, name=vehicles[vehicle.name]) for vehicle in plant.vehicles]
    changed = [
        f"{new} from {old!r}" for names in (points, positions, areas) for old, new in names.items() if old != new
    ]
    plant.note("changed", "name", changed, "with characters that not every file can hold, or blanks around it")


def _plain(names: Iterable[str]) -> dict[str, str]:
    """Return a mapping of names to unique plain forms."""
    plain = {name: _trimmed(name) for name in names}
    taken = {name for name, trimmed in plain.items() if trimmed == name}
    return {name: name if trimmed == name else claim(trimmed or "unnamed", taken) for name, trimmed in plain.items()}


def _trimmed(name: str) -> str:
    return " ".join(one_line(name).split())


def tables(plant: Plant) -> dict[str, str]:
    """Return the tables of nodes and edges by file name; losses are noted in the plant."""
    _losses(plant)
    edges = [{"from": link.source, "to": link.target, **_edge(plant, link)} for link in plant.links]
    return {NODES_FILE: _csv(_NODE_COLUMNS, list(_nodes(plant))), EDGES_FILE: _csv(_columns(edges), edges)}


def _columns(edges: list[Row]) -> tuple[str, ...]:
    """Return the columns of the table of edges, with speed_back only if an edge has one."""
    return tuple(name for name in _EDGE_COLUMNS if name != "speed_back" or any(name in row for row in edges))


def graphml(plant: Plant) -> str:
    """Return the text of a GraphML file; a two-way lane becomes two edges, as in any directed graph."""
    _losses(plant)
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', '<graphml xmlns="http://graphml.graphdrawing.org/xmlns">']
    kinds = {"x": "double", "y": "double", "role": "string", "station": "string"}
    lines += [f'  <key id="{name}" for="node" attr.name="{name}" attr.type="{kind}"/>' for name, kind in kinds.items()]
    kinds = {"length": "double", "speed": "double", "side_by_side": "boolean"}
    lines += [f'  <key id="{name}" for="edge" attr.name="{name}" attr.type="{kind}"/>' for name, kind in kinds.items()]
    lines.append(f'  <graph id={quoteattr(plant.name)} edgedefault="directed">')
    for row in _nodes(plant):
        name = row.pop("name")
        lines.append(f"    <node id={quoteattr(str(name))}>{_data(row)}</node>")
    for link in plant.links:
        row = _edge(plant, link)
        ways = [(link.source, link.target, row)]
        if row.pop("two_way", False):
            back = row.pop("speed_back", None)
            ways.append((link.target, link.source, row if back is None else {**row, "speed": back}))
        for a, b, data in ways:
            lines.append(f"    <edge source={quoteattr(a)} target={quoteattr(b)}>{_data(data)}</edge>")
    return "\n".join([*lines, "  </graph>", "</graphml>", ""])


def _nodes(plant: Plant) -> Iterator[Row]:
    roles, stations = plant.work(), dict[str, str]()
    for location in plant.locations:
        stations |= {name: location.name for name, operations in location.operations.items() if "unload" in operations}
    for point in plant.points.values():
        row: Row = {"name": point.name, "x": round(point.x, _DIGITS), "y": round(point.y, _DIGITS)}
        if point.name in roles:
            row["role"] = " + ".join(roles[point.name])
        if point.name in stations:
            row["station"] = stations[point.name]
        yield row


def _edge(plant: Plant, link: Link) -> Row:
    row: Row = {}
    length = length_of(plant, link)
    if abs(length - distance(plant, link.source, link.target)) > _EQUAL:
        row["length"] = round(length, _DIGITS)
    if link.speed < float("inf"):
        row["speed"] = round(link.speed, _DIGITS)
    if link.speed_back not in (0, link.speed):
        row["speed_back"] = round(link.speed_back, _DIGITS) if link.speed_back < float("inf") else "inf"
    if link.speed_back:
        row["two_way"] = True
    if link.side_by_side:
        row["side_by_side"] = True
    return row


def _losses(plant: Plant) -> None:
    plant.note("left out", "vehicle", [vehicle.name for vehicle in plant.vehicles], "such a table has no fleet")
    plant.note("left out", "zone", [area.name for area in plant.areas], "such a table has no traffic rules")


def _csv(columns: tuple[str, ...], rows: list[Row]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([["yes" if row.get(name) is True else row.get(name, "") for name in columns] for row in rows])
    return text.getvalue()


def _data(row: Row) -> str:
    return "".join(
        f'<data key="{name}">{escape(str(value).lower() if value is True else str(value))}</data>'
        for name, value in row.items()
    )
