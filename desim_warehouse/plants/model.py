"""Models of plants for `desim import`: the layout as drawn, with marked assumptions for what drawings lack.

- Lengths are those of the drawing, not straight distances. Two points on one spot are drawn 1 cm apart.
- Two opposite edges between two points are a two-way lane, unless their lengths differ by more than 5 %: then they are
two lanes side by side. Each direction has its own speed (`speed_back`).
- Places where robots load become storage places, places where they unload become stations, and chargers and parking
positions become bays. Bays and stations stand beside their points, so a robot there lets others pass.
- If no parking is drawn, robots park where they work; if no work is drawn, they work where they park, or else
everywhere. Stations have room for all robots. All of this is marked as assumed.
- Points on several levels that a lift joins are the nodes of a lift, with assumed times. If robots work or pass at such
a point, the cabin stands beside it.
- Accelerations and angles are not read.
- Areas for one robot at a time, or one direction at a time, are zones.

A file with the keys `robot` and `battery` of a model may describe the robots, which drawings do not.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations
from pathlib import Path
from typing import Any

from desim_warehouse.errors import LayoutError, ModelError, number_of, shown
from desim_warehouse.layout.zones import examine
from desim_warehouse.model import Model, load
from desim_warehouse.model.messages import Keys, Outline
from desim_warehouse.model.parse import from_file, valid
from desim_warehouse.model.sections.fleet import BatterySpec, RobotSpec
from desim_warehouse.model.sections.flows import STORAGE
from desim_warehouse.plants.checks import DIGITS, distance, floor_of, put_right
from desim_warehouse.plants.lanes import DrawnLane, lanes_of
from desim_warehouse.plants.levels import DOORS, RIDE, make_room_for_cabins
from desim_warehouse.plants.plant import Area, Plant, Remark, Vehicle, unique
from desim_warehouse.plants.stops import Stops, stops_of
from desim_warehouse.plants.write import apart, are_orders, kept, orders_beside, orders_text, written
from desim_warehouse.values.arguments import is_whole
from desim_warehouse.values.fields import Part

Content = dict[str, Any]

_SIZE, _SPEED = 1.0, 1.0  # of a vehicle without them in the drawing: metres, m/s
_HANDLING = 15
_SHIFT = 8 * 3600
_ROOM = 2  # slots in all stations together for each point of the plant, more than the robots that could drive there
_LASTS, _CHARGES = 8 * 3600, 2 * 3600  # seconds from full to empty, and from empty to full
_CRITICAL = 0.3
_LONGEST = 500  # letters about losses in a message, at most
_EQUAL = 1e-3  # lengths that differ by less are the straight distance


@dataclass(frozen=True)
class Imported:
    """A model made from a plant.

    Attributes:
        plant: the content of the file.
        content: the model, in the form of a model file.
        comments: comments on its keys: assumptions, and names of storage places.
        orders: the file of its tasks (CSV); empty if they are in the model itself.
    """

    plant: Plant
    content: Content
    comments: Mapping[Keys, str]
    orders: str = ""

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """Remarks on parts left out, changed or out of reach, and on assumptions."""
        return tuple(self.plant.remarks)

    @cached_property
    def model(self) -> Model:
        """The model, checked as a file is; a file of its orders is kept until the process ends."""
        whole = self.with_orders(kept(self.orders, f"{id(self)}.csv")) if self.orders else self.content
        return _buildable(whole, self.plant)

    def in_short(self) -> str:
        """Return the sizes of the layout in one line; a floor of implausible size reveals a wrong unit."""
        layout = self.model.layout
        counts = zip((layout.nodes, layout.edges), ("node", "edge"), strict=True)
        sides = " x ".join(f"{round(side, 1):,g}" for side in floor_of(self.plant))
        stations, robots = number_of(len(layout.stations), "station"), number_of(self.model.fleet.size, "robot")
        return ", ".join([*(number_of(len(items), kind) for items, kind in counts), f"{sides} m", stations, robots])

    def text(self) -> str:
        """Return the model as a file: readable YAML, with the remarks on top and comments at assumptions."""
        return self._text(self.content)

    def files(self, path: Path) -> dict[Path, str]:
        """Return the texts of the model's files by path: the model at `path`, large parts in files beside it."""
        orders = orders_beside(path)
        content, files = apart(self.with_orders(Path(orders.name)), path)
        return {path: self._text(content), **files, **({orders: self.orders} if self.orders else {})}

    def with_orders(self, path: Path) -> Content:
        """Return the content with its orders, if there are any, read from the file at `path`."""
        if not self.orders:
            return self.content
        flows = {"orders": {"from": "storage", "to": "storage", "arrivals": {"orders": {"file": str(path)}}}}
        return {**self.content, "tasks": {"flows": flows, **self.content["tasks"]}}

    def _text(self, content: Content) -> str:
        head = [f"Made from {self.plant.source}."]
        head += [str(remark) for remark in self.remarks if remark.what != "assumed"]
        head.append("What the drawing does not say is marked 'assumed': look at it first.")
        return written(content, self.comments, head)


def imported(
    plant: Plant,
    operations: Mapping[str, str] | None = None,
    robots: int | None = None,
    robot: Mapping[str, Any] | None = None,
) -> Imported:
    """Make a model of a plant.

    Args:
        plant: the plant; further remarks are added to it.
        operations: what robots do at locations that allow an operation: load, unload, charge, park or none; by default
            as the names of operations suggest.
        robots: size of the fleet; default: the number of vehicles drawn.
        robot: the sections robot (as below fleet) and battery; default: as drawn, or assumed.

    Raises:
        ModelError: robots could do nothing on such a plant, or the mapping does not fit.
    """
    if robots is not None and not is_whole(robots, 1):
        raise ModelError([f"{plant.source}: robots {shown(robots):.60}: expected a whole number above 0"])
    put_right(plant)
    if plant.lifts:
        make_room_for_cabins(plant, _contact(plant, robot or {}))
    lanes = lanes_of(plant)
    reachable = _main_part(plant, lanes)
    reachable -= {cabin for stops in plant.lifts.values() for cabin in stops}
    stops = stops_of(plant, reachable, operations or {})
    if not stops.load or not stops.unload:
        text = "no location in reach where robots load or unload, expected one at least"
        raise ModelError([f"{plant.source}: {text}{_why(plant)}"])
    if plant.transports and not stops.tasks:
        text = "no transport order in which a load is fetched and then brought, both in reach, expected one at least"
        raise ModelError([f"{plant.source}: {text}{_why(plant)}"])
    made = _Maker(plant, lanes, stops, robot or {})
    content = made.content(robots)
    if zones := zones_of(plant, content):
        content["traffic"] = {"zones": zones}
    content["description"] = _summary(plant)
    assumed = [remark for remark in plant.remarks if remark.what == "assumed"]
    comments: dict[Keys, str] = {tuple(remark.kind.split(".")): f"assumed: {remark.why}" for remark in assumed}
    orders = orders_text(stops.tasks) if are_orders(stops.tasks) else ""
    return Imported(plant, content, {**comments, **made.named}, orders)


def _summary(plant: Plant) -> str:
    """Return the description of the model: its source, the parts left out, and the assumptions."""
    lost = [remark for remark in plant.remarks if remark.what in {"left out", "unreachable"}]
    counts = ", ".join(number_of(len(remark.names), remark.kind) for remark in lost)
    assumed = ", ".join(remark.kind for remark in plant.remarks if remark.what == "assumed")
    return f"From {plant.source}. {f'Left out or unreachable: {counts}. ' if lost else ''}Assumed: {assumed}."


def _why(plant: Plant) -> str:
    """Return the parts lost so far, in brackets; empty if none are lost."""
    lost = "; ".join(str(remark) for remark in plant.remarks if remark.what in {"left out", "unreachable"})
    return f" ({lost[:_LONGEST]}{' ...' * (len(lost) > _LONGEST)})" if lost else ""


def _main_part(plant: Plant, lanes: Iterable[DrawnLane]) -> set[str]:
    """Return the points of the largest strongly connected part."""
    import networkx as nx

    graph = nx.DiGraph()
    graph.add_nodes_from(plant.points)
    for lane in lanes:
        graph.add_edge(lane.source, lane.target)
        if lane.two_way:
            graph.add_edge(lane.target, lane.source)
    for stops in plant.lifts.values():
        graph.add_edges_from(permutations(stops, 2))
    main: set[str] = max(
        nx.strongly_connected_components(graph), key=lambda part: (len(part), sorted(part)), default=set()
    )
    if len(main) < 2:  # noqa: PLR2004 - there and back
        text = "nowhere can robots drive from one point to another and back, expected lanes that lead back, too"
        if not graph.edges:
            text = "no lanes, expected some on which robots drive"
        elif "two_way" in plant.options and not all(link.speed_back for link in plant.links):
            text += "; if each is meant in both directions, choose two-way (--two-way)"
        raise ModelError([f"{plant.source}: {text}{_why(plant)}"])
    outside = [point for point in plant.points.values() if point.name not in main]
    plant.note_parts("unreachable", "point", outside, "robots cannot get there and back")
    return main


def _contact(plant: Plant, robot: Mapping[str, Any]) -> float:
    """Return the distance that robots keep on a plant, by their size as drawn or as in a file about a robot."""
    if "robot" in robot:
        any_floor = {"nodes": {"A": [0, 0], "B": [_ROOM, 0]}, "edges": [["A", "B"]], "storage": [{"node": "A"}]}
        any_work = {"goods": [0], "unload_at": ["A"], "load_time": 0, "unload_time": 0}
        return load(
            {"layout": any_floor, "fleet": {"size": 1, "robot": robot["robot"]}, "tasks": any_work}
        ).fleet.contact
    return max([vehicle.length or _SIZE for vehicle in plant.vehicles] or [plant.cell or _SIZE])


class _Maker:
    """Maker of the sections of a model; `named` holds the names of storage places by key."""

    def __init__(self, plant: Plant, lanes: list[DrawnLane], stops: Stops, robot: Mapping[str, Any]) -> None:
        self.plant = plant
        self.lanes = lanes
        self.stops = stops
        self.robot = robot
        self.named: dict[Keys, str] = {}

    def content(self, robots: int | None) -> Content:
        """Return all sections of the model."""
        layout, fleet = self.layout(), self.fleet(robots)
        layout["bays"] = self.bays()
        layout["stations"] = self.stations()
        if self.plant.lifts:
            layout["lifts"] = self.lifts()
            layout["floors"] = self.floors()
        self.starts(fleet, layout["bays"])
        battery = self.battery(layout["bays"])
        charging = {}
        if battery and not self.stops.tasks:
            charging = {"charging": "four-thresholds"}
            fleet["start_energy"] = "settled"
            self.plant.assume("fleet.start_energy", "batteries as in the long run: the shift before is not simulated")
        charge = ", charging between tasks" if charging else ""
        self.plant.assume("policies", f"nearest robot, fastest route, nearest free parking{charge}")
        if not self.stops.tasks:
            self.plant.assume("run.length", "a shift of 8 h")
        return {
            "name": self.plant.name,
            "description": "",
            "layout": layout,
            "fleet": fleet,
            "tasks": self.tasks(layout["stations"]),
            **({"battery": battery} if battery else {}),
            "policies": {"allocation": "nearest", "routing": "fastest", **charging, "parking": "nearest"},
            **({} if self.stops.tasks else {"run": {"length": _SHIFT}}),
        }

    # The layout

    def layout(self) -> Content:
        nodes = {point.name: [_round(point.x), _round(point.y)] for point in self.plant.points.values()}
        return {"nodes": nodes, "edges": [self.edge(lane) for lane in self.lanes], "storage": self.storage()}

    def edge(self, lane: DrawnLane) -> Content:
        straight = distance(self.plant, lane.source, lane.target)
        edge: Content = {"from": lane.source, "to": lane.target}
        if abs(lane.length - straight) > _EQUAL:
            edge["length"] = _above_0(lane.length)
        if lane.speed < float("inf"):
            edge["speed"] = _above_0(lane.speed)
        if lane.speed_back not in (None, lane.speed):
            edge["speed_back"] = _above_0(lane.speed_back)
        edge.update({key: True for key in ("two_way", "side_by_side") if getattr(lane, key)})
        if lane.against != 1:
            edge["against"] = _round(lane.against)
        return edge

    def storage(self) -> list[Content]:
        """Return a storage place at every point where robots load."""
        common = Counter(name for names in self.stops.load.values() for name in names)
        for rank, (point, names) in enumerate(self.stops.load.items()):
            if names != [point] and any(common[name] == 1 for name in names):  # a name that all share tells nothing
                self.named["layout", "storage", rank] = " + ".join(names)
        return [{"node": point} for point in self.stops.load]

    def bays(self) -> Content:
        """Return the bays: chargers and parking points or, if none are drawn, the points where robots work.

        Each has room for one vehicle, as drawn, and for as many as start there in a larger fleet.
        """
        chargers, parks = list(self.stops.charge), [name for name in self.stops.park if name not in self.stops.charge]
        if not chargers and not parks:
            parks = list(dict.fromkeys([*self.stops.unload, *self.stops.load]))
            self.plant.assume("layout.bays", "no parking is drawn, so robots park beside the points where they work")
        bays: Content = {}
        for wanted, points, each in (("chargers", chargers, 1), ("parking", parks, 0)):
            if points:
                name = self.named_apart(wanted, points, bays)
                bays[name] = {"at": points, "places": 1, "grows": True, "chargers": each}
        for name in bays:
            self.plant.assume(f"layout.bays.{name}.grows", "room for one vehicle, and for all that start there")
        return bays

    def stations(self) -> Content:
        """Return the stations beside the points where robots unload; points of the same locations share a station.

        A robot takes a task only if its station has a free slot. With a slot for one vehicle each, stations would
        therefore keep a larger fleet in its bays, whatever the lanes can carry. The number of slots does not depend on
        the fleet, so that fleets are comparable.
        """
        places = max(-(-_ROOM * len(self.plant.points) // len(self.stops.unload)), _ROOM)
        # With one slot each, 8 robots of a plant did 134 tasks an hour, with two slots 242. Room that depends on the
        # fleet would give each fleet another floor.
        self.plant.assume("layout.stations", f"room beside them for {places} robots at each point, whatever the fleet")
        groups: dict[tuple[str, ...], list[str]] = {}
        for point, names in self.stops.unload.items():
            groups.setdefault(tuple(names) if any(names) else ("", point), []).append(point)
        stations: Content = {}
        for locations, points in groups.items():
            name = " + ".join(filter(None, locations)) or points[0]
            stations[self.named_apart(name, points, stations)] = {"at": points, "places": places}
        return stations

    def named_apart(self, wanted: str, points: list[str], taken: Iterable[str]) -> str:
        """Return a name for a bay or station that no other has, nor a point except the only one that it is at."""
        others = {point for point in self.plant.points if points != [point]}
        return unique(wanted, {*taken, *others, STORAGE})

    def lifts(self) -> Content:
        """Return the lifts, with assumed times, as no drawing states them."""
        why = f"{RIDE:g} s from level to level, and {DOORS:g} s for the doors to open or close"
        self.plant.assume("layout.lifts", why, self.plant.lifts)
        return {
            name: {"nodes": list(stops), "ride": _round(RIDE), "doors": _round(DOORS)}
            for name, stops in self.plant.lifts.items()
        }

    def floors(self) -> Content:
        """Return for each level by name a node on it, or a node of each of its parts if only lifts join these."""
        import networkx as nx

        lanes = nx.Graph((lane.source, lane.target) for lane in self.lanes)
        lanes.add_nodes_from(self.plant.points)
        part_of = {node: rank for rank, part in enumerate(nx.connected_components(lanes)) for node in part}
        floors: Content = {}
        for level in filter(None, self.plant.levels):
            firsts: dict[int, str] = {}
            for node in self.plant.points:
                if self.plant.level_of.get(node) == level:
                    firsts.setdefault(part_of[node], node)
            if firsts:
                floors[level] = list(firsts.values())
        return floors

    # Everything else

    def fleet(self, robots: int | None) -> Content:
        vehicles = self.plant.vehicles or [Vehicle("robot", self.plant.cell, self.plant.cell)]
        shapes: dict[tuple[float, float], list[str]] = {}
        for vehicle in vehicles:
            shapes.setdefault((vehicle.length or _SIZE, vehicle.speed or _SPEED), []).append(vehicle.name)
        (length, speed), _ = max(shapes.items(), key=lambda item: len(item[1]))
        self.unsaid(vehicles)
        fleet: Content = {
            "size": robots or len(vehicles),
            "robot": self.robot.get("robot") or {"radius": _above_0(length / 2), "speed": _above_0(speed)},
        }
        if len(shapes) > 1 and fleet["size"] == len(vehicles) and "robot" not in self.robot:
            fleet["kinds"] = {
                names[0]: {"count": len(names), "radius": _above_0(size / 2), "speed": _above_0(pace)}
                for (size, pace), names in shapes.items()
                if (size, pace) != (length, speed)
            }
        if not self.plant.vehicles and robots is None:
            self.plant.assume("fleet.size", "no vehicle is drawn")
        elif robots not in {None, len(self.plant.vehicles)}:
            self.plant.assume("fleet.size", f"as asked for; {len(self.plant.vehicles)} are drawn")
        return fleet

    def starts(self, fleet: Content, bays: Content) -> None:
        """Let robots start where their vehicles are drawn, if these points have bays; otherwise note the loss."""
        placed = [vehicle for vehicle in self.plant.vehicles if vehicle.start is not None]
        if {vehicle.start for vehicle in placed} <= {node for bay in bays.values() for node in bay["at"]}:
            if len(placed) == fleet["size"] and "kinds" not in fleet:
                fleet["start"] = [vehicle.start for vehicle in placed]
        else:
            self.plant.note_parts("left out", "vehicle", placed, "the point where it begins: robots begin in bays")

    def unsaid(self, vehicles: list[Vehicle]) -> None:
        if "robot" in self.robot:
            return
        if any(vehicle.length is None for vehicle in vehicles):
            self.plant.assume("fleet.robot.radius", "the drawing has no size of vehicles")
        if any(vehicle.speed is None for vehicle in vehicles):
            self.plant.assume("fleet.robot.speed", "the drawing has no speed of vehicles")

    def tasks(self, stations: Content) -> Content:
        if not self.stops.tasks:
            why = "always as many tasks open as there are robots: what the plant can do at most"
            self.plant.assume("tasks.goods", why)
            self.plant.assume("tasks.station_choice", "any station, drawn for every task")
        handling = self.plant.handling
        if handling is None:
            handling = _HANDLING
            for key in ("tasks.load_time", "tasks.unload_time"):
                self.plant.assume(key, f"{_HANDLING:g} s")
        times = {"load_time": handling, "unload_time": handling}
        if are_orders(self.stops.tasks):
            return times
        return {
            "goods": self.goods(stations) or {"saturated": "fleet"},
            "unload_at": list(stations),
            "station_choice": "random",
            **times,
        }

    def goods(self, stations: Content) -> list[Content]:
        """Return the transports that the plant lists as tasks of a model."""
        storage = {point: rank for rank, point in enumerate(self.stops.load)}
        named = {item["at"][0]: name for name, item in stations.items() if len(item["at"]) == 1}
        tasks = []
        for transport in self.stops.tasks:
            task: Content = {
                "good": storage[transport.source],
                "to": named.get(transport.target, transport.target),
            }
            task.update({"release": _round(transport.release)} if transport.release else {})
            task.update({"due": _round(transport.due)} if transport.due is not None else {})
            tasks.append(task)
        return tasks

    def battery(self, bays: Content) -> Content | None:
        if "battery" in self.robot:
            if not self.stops.charge:
                for name, bay in bays.items():
                    del bay["chargers"]
                    self.plant.assume(f"layout.bays.{name}.chargers", "no chargers in reach, so every slot has one")
            return dict(self.robot["battery"])
        if not self.stops.charge:
            self.plant.assume("battery", "no chargers in reach, so robots never need charging")
            return None
        critical = max((vehicle.critical for vehicle in self.plant.vehicles if vehicle.critical), default=None)
        if critical is None or not 0 < critical < 1:
            self.plant.assume("battery.threshold", "30 %")
        self.plant.assume("battery.consumption", "a full battery lasts for 8 h")
        self.plant.assume("battery.charge_rate", "an empty battery is full in 2 h")
        return {
            "capacity": 100,
            "threshold": _round(100 * (critical if critical and critical < 1 else _CRITICAL)),
            "consumption": _round(100 / _LASTS, 5),
            "charge_rate": _round(100 / _CHARGES, 5),
        }


def _above_0(value: float) -> float | int:
    """Return a number rounded as in `_round`, but never 0."""
    return _round(max(value, 10**-DIGITS))


def _round(value: float, digits: int = DIGITS) -> float | int:
    """Return a number rounded to the precision of a drawing."""
    rounded = round(float(value), digits)
    return int(rounded) if rounded.is_integer() else rounded


class RobotFile(Part):
    """A robot and its battery; missing sections are as drawn, or assumed."""

    robot: RobotSpec | None = None
    battery: BatterySpec | None = None


_OUTLINE = Outline(RobotFile)


def read_robot(path: str | Path) -> dict[str, Any]:
    """Read the sections of a file about a robot, as they stand in it.

    Args:
        path: a YAML file with `robot` as below `fleet`, `battery`, or both, in metres and seconds or with units.

    Raises:
        ModelError: every problem of the file, in order.
    """
    document = from_file(Path(path), str(path), "a robot with robot or battery", _OUTLINE)
    valid(document, RobotFile, _OUTLINE)
    return {key: value for key, value in document.data.items() if value is not None}


def zones_of(plant: Plant, content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the zones section of a model; areas that cannot be zones are noted, with the reason."""
    if not plant.areas:
        return {}
    edges = {frozenset((edge["from"], edge["to"])) for edge in content["layout"]["edges"]}
    ends = {link.name: [link.source, link.target] for link in plant.links}
    zones: dict[str, Any] = {}
    empty: list[Area] = []
    ends_too: list[Area] = []
    lost = []
    for area in plant.areas:
        members = _members(area, plant, ends, edges)
        lost += [f"{name} of {area.name}" for name in area.members if name not in members]
        if members:
            zones[area.name] = {"members": list(members.values()), "rule": area.rule}
            ends_too += [area] if area.rule == "one-robot" and not {*ends}.isdisjoint(members) else []
        else:
            empty.append(area)
    positions = {area.name: area.position for area in plant.areas}
    node = next(iter(content["layout"]["nodes"]))
    any_work = {
        "goods": [0],
        "unload_at": [node],
        "load_time": 0,
        "unload_time": 0,
    }  # tasks from orders stand in a file
    model = _buildable({**content, "tasks": any_work, "traffic": {"zones": zones}}, plant) if zones else None
    if model is not None:
        for finding in examine(model.floor, model.traffic.zones, model.fleet.contact, "auto"):
            name = finding.place.removeprefix("traffic.zones.")
            if finding.level == "error" and zones.pop(name, None):
                plant.note("left out", "block", [name], finding.text, [positions[name]])
    plant.note_parts("left out", "block", empty, "none of its members is a point or path of the model")
    plant.note("left out", "member", lost, "of a block: no point or path of the model")
    kept = [area for area in ends_too if area.name in zones]
    plant.note_parts("changed", "block", kept, "the points at the ends of its paths belong to it, too")
    return zones


def _buildable(content: Content, plant: Plant) -> Model:
    """Return the model with this content; raises ModelError, naming the source, if its layout cannot be built."""
    model = load(content)
    try:
        model.floor  # noqa: B018 - the layout
    except LayoutError as error:
        raise ModelError([f"{plant.source}: {problem}" for problem in error.problems]) from None
    return model


def _members(area: Area, plant: Plant, ends: Mapping[str, list[str]], edges: set[frozenset[str]]) -> dict[str, Any]:
    """Return the members of an area by name, in the form of a model: a node as its name, an edge as a pair of nodes."""
    members: dict[str, Any] = {}
    for name in area.members:
        if name in plant.points:
            members[name] = name
        elif name in ends and frozenset(ends[name]) in edges:
            members[name] = ends[name]
    return members
