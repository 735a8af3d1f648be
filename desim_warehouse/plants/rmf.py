"""Maps of Open-RMF for `desim import`: building maps of the traffic editor, and navigation graphs; YAML.

- Building maps are in pixels, y downwards; in metres, y upwards, as are navigation graphs; or in degrees. The mean of
  the measured distances converts pixels to metres; a measurement that differs by more than 5 % is reported as doubtful.
- One map may hold lanes of several fleets, told apart by graph_idx. The graph with most lanes is read, on the level
  with most lanes and the levels to which its lifts lead; `--graph N` reads another graph, `--layout NAME` one level.
- Vertices in the cabin of one lift on several levels become a lift, and levels that lie over each other are drawn side
  by side. No map says how long a ride takes.
- A bidirectional lane is one two-way lane. A mutex group is a zone for one robot.
- Robots begin where the map spawns them, and there are as many of them. Chargers and parking spots are bays; robots
  load at dispensers and unload at ingestors. Other places are mapped by name: `--operation lounge=unload`.
- Doors and docking take no time, and are reported as left out.

Source: the formats of rmf_traffic_editor (`.building.yaml`) and rmf_building_map_tools (`nav_graphs/*.yaml`).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from desim_warehouse.errors import ModelError, did_you_mean, got
from desim_warehouse.model.messages import Keys, report
from desim_warehouse.model.parse import Document, read_yaml
from desim_warehouse.plants import globe
from desim_warehouse.plants.levels import draw_apart
from desim_warehouse.plants.plant import Area, Link, Location, Plant, Vehicle, Waypoint, unique
from desim_warehouse.values.fields import LIMITS

EXPECTED = "a map of Open-RMF (YAML with levels)"
OPTIONS = ("layout", "graph")
LARGEST, _MOST = 1_000_000, 200_000  # bytes and values: YAML is slow to read
_DIFFER = 0.05  # of the mean: scales that differ by more are doubtful
_PAIR = 2
_DOOR = "it takes no time to drive through a door here"
_UNNAMED = {"", "building", "site"}
"""Names that traffic editors give to a map without a name."""
_WORK = {"pickup_dispenser": "pickup", "dropoff_ingestor": "dropoff"}
Spot = tuple[float, float]


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


_OF_LANES = _words(
    "bidirectional is_bidirectional graph_idx orientation orientation_constraint speed_limit mutex "
    "demo_mock_floor_name demo_mock_lift_name door_name dock_name"
)
_OF_VERTICES = _words(
    "name is_parking_spot is_charger is_holding_point is_passthrough_point is_cleaning_zone dock_name pickup_dispenser "
    "dropoff_ingestor spawn_robot_name spawn_robot_type human_goal_set_name lift_cabin lift mutex merge_radius"
)
_OF_LEVELS = _words(
    "vertices lanes measurements doors lifts walls floors models drawing layers features constraints fiducials "
    "human_lanes holes environments elevation flattened_x_offset flattened_y_offset x_meters y_meters"
)
_OF_MAPS = _words(
    "name building_name levels lifts doors graphs crowd_sim coordinate_system parameters reference_level_name "
    "map_version"
)


def looks(path: Path, start: bytes) -> bool:
    """Return whether a file may be a map, as it is YAML."""
    return path.suffix.lower() in {".yaml", ".yml"} or b"\nlevels:" in b"\n" + start


def read(path: Path, content: bytes, *, layout: str | None = None, graph: int | None = None) -> Plant:
    """Read a building map or a navigation graph.

    Args:
        path: the file.
        content: its bytes.
        layout: the level to read; default: the level with most lanes.
        graph: the graph_idx of the lanes to read; default: the graph with most lanes.

    Raises:
        ModelError: the file cannot be read, with the line.
    """
    try:
        document = read_yaml(content.decode("utf-8-sig"), str(path), _MOST)
    except UnicodeDecodeError:
        raise ModelError([f"{path}: not UTF-8 text, expected {EXPECTED}"]) from None
    if document.problems:
        raise ModelError(report(document.problems[:1], document.positions))
    return plant_of(path, document, layout, graph)


def plant_of(path: Path, document: Document, layout: str | None, graph: int | None) -> Plant:
    """Return the plant of a map in any of its formats; see `read`."""
    return _Map(path, document).plant_of(layout, graph)


class _Lane(NamedTuple):
    source: int
    target: int
    about: dict[str, Any]
    line: str


class _Map:
    """A map while it is read; `plant` is the result."""

    def __init__(self, path: Path, document: Document) -> None:
        self.path = path
        self.document = document
        data = document.data if isinstance(document.data, dict) else {}
        self.data: dict[str, Any] = data
        if not isinstance(data.get("levels"), dict) or not data["levels"]:
            if data.get("levels", ()) in ({}, None):
                self.refuse(("levels",), "a map of Open-RMF without levels: nothing is drawn yet")
            text = "no levels, as a map of Open-RMF has, and of no other program that is known"
            self.refuse((), f"{text}; desim import --help names the formats that can be read")
        name = str(data.get("name") or data.get("building_name") or "")
        self.plant = Plant(path.name.partition(".")[0] if name in _UNNAMED else name, "")
        self.cabins: dict[str, dict[str, str]] = {}
        """By lift, its point on each level that is read."""
        self.groups: dict[str, Area] = {}

    def plant_of(self, asked: str | None, graph: int | None) -> Plant:
        levels = self.lanes(asked, graph)
        read = f"level{'s' * (len(levels) > 1)} {', '.join(levels)}"
        for name, lanes in levels.items():
            kind = self.level(name, lanes, several=len(levels) > 1)
            self.plant.source = self.plant.source or f"{self.path.name} (Open-RMF {kind}, {read})"
        self.plant.areas = list(self.groups.values())
        self.plant.levels = tuple(sorted(levels, key=self.elevation))
        self.lifts()
        draw_apart(self.plant)
        self.plant.note("left out", "door", _names(self.data.get("doors")), _DOOR)
        self.plant.see_keys(self.data, _OF_MAPS, "line 1")
        return self.plant

    def level(self, name: str, lanes: list[_Lane], *, several: bool) -> str:
        """Add a level, as far as lanes lead, and return the kind of its map; if `several`, points get their level."""
        level = self.data["levels"][name]
        vertices = self.items(level, "vertices", ("levels", name))
        used = sorted({end for lane in lanes for end in (lane.source, lane.target)})
        for lane in lanes:
            for end in (lane.source, lane.target):
                if not end < len(vertices):
                    text = f"{lane.line}: a lane to vertex {end}, expected one from 0 to {len(vertices) - 1}"
                    raise ModelError([f"{self.path}: {text}"])
        thirds = [vertex[_PAIR] for vertex in vertices if isinstance(vertex, list) and len(vertex) > _PAIR]
        nav = any(isinstance(third, dict) for third in thirds) or bool(vertices and not thirds)
        kind = "navigation graph" if nav else "building map"
        to_metres = self.projection(name, nav, [vertices[rank] for rank in used])
        abouts: dict[int, dict[str, Any]] = {}
        names: dict[int, str] = {}
        for rank in used:
            keys: Keys = ("levels", name, "vertices", rank)
            x, y, title, abouts[rank] = self.vertex(vertices[rank], keys)
            self.plant.see_keys(abouts[rank], _OF_VERTICES, self.line(keys), "vertex")
            names[rank] = unique(title or f"vertex {rank}", self.plant.points)
            parking = bool(abouts[rank].get("is_parking_spot"))
            x, y = to_metres((x, y))
            self.plant.points[names[rank]] = Waypoint(names[rank], x, y or 0.0, parking, self.line(keys))
            if several:
                self.plant.level_of[names[rank]] = name
            if lift := _cabin(abouts[rank]):
                self.cabins.setdefault(lift, {})[name] = names[rank]
            self.place(names[rank], bool(title) and not lift, abouts[rank])
        self.links(lanes, names)
        self.areas(lanes, names, abouts)
        self.losses(level, lanes, names, abouts)
        self.plant.see_keys(level, _OF_LEVELS, self.line(("levels", name)), "level")
        return kind

    def lifts(self) -> None:
        """Add the lifts with cabins on several levels that are read, from the lowest up; note the others."""
        for lift, stops in self.cabins.items():
            if len(stops) > 1:
                order = sorted(stops, key=self.elevation)
                self.plant.lifts[lift] = tuple(stops[level] for level in order)
        lifts = dict.fromkeys([*_names(self.data.get("lifts")), *self.cabins])
        others = [name for name in lifts if name not in self.plant.lifts]
        self.plant.note("left out", "lift", others, "no lanes lead to the cabin on two of the levels that are read")

    def elevation(self, level: str) -> float:
        """Return the height of a level; levels without one are in the order of the map."""
        height = self.data["levels"][level].get("elevation")
        return float(height) if _is_number(height) else float(list(self.data["levels"]).index(level))

    # What is read

    def lanes(self, asked: str | None, graph: int | None) -> dict[str, list[_Lane]]:
        """Return the lanes of a graph by level: of the level with most of them, and of levels that lifts join to it.

        If a level is asked for, only its lanes are returned.
        """
        levels = self.data["levels"]
        if asked is not None and asked not in levels:
            hint = did_you_mean(asked, levels)
            self.refuse(("levels",), f"no level {got(asked)}, expected one of {', '.join(levels)}{hint}")
        listed = {name: self.lanes_of(name) for name in levels if asked in {None, name}}
        counts = Counter(index for lanes in listed.values() for index, _ in lanes)
        index = graph if graph is not None else min(counts, key=lambda number: (-counts[number], number), default=0)
        if index not in counts and counts:
            self.refuse(
                ("levels",), f"no lanes of graph {index}, expected one of {', '.join(map(str, sorted(counts)))}"
            )
        mine = {name: [lane for its, lane in lanes if its == index] for name, lanes in listed.items()}
        level = max(mine, key=lambda title: len(mine[title]))
        joined = self.joined(level, mine) if asked is None else [level]
        here = {(name, lane.source, lane.target) for name in joined for lane in mine[name]}
        others = [
            (f"{lane.source} - {lane.target} of graph {its}", lane.line)
            for name in joined
            for its, lane in listed[name]
            if its != index and (name, lane.source, lane.target) not in here
        ]
        why = f"of other graphs; graph {index} is read, --graph reads another"
        self.plant.note("left out", "lane", [name for name, _ in others], why, [line for _, line in others])
        apart = [title for title in levels if title not in joined]
        why = f"no lift leads there from level {level}, which is read" if asked is None else f"level {level} is read"
        self.plant.note("left out", "level", apart, f"{why}; --layout reads another")
        return {name: mine[name] for name in levels if name in joined}

    def joined(self, level: str, lanes: Mapping[str, list[_Lane]]) -> list[str]:
        """Return the levels that robots can reach from a level by lifts, including it."""
        lifts = {name: self.lifts_at(name, its) for name, its in lanes.items()}
        joined = [level]
        for name in joined:
            joined += [other for other in lifts if other not in joined and lifts[other] & lifts[name]]
        return joined

    def lifts_at(self, name: str, lanes: list[_Lane]) -> set[str]:
        """Return the lifts whose cabins lanes of a level reach."""
        vertices = self.items(self.data["levels"][name], "vertices", ("levels", name))
        ends = {end for lane in lanes for end in (lane.source, lane.target) if end < len(vertices)}
        cabins = (_cabin(self.vertex(vertices[end], ("levels", name, "vertices", end))[-1]) for end in ends)
        return set(filter(None, cabins))

    def lanes_of(self, name: str) -> list[tuple[int, _Lane]]:
        """Return the lanes of a level, each with its graph."""
        level, lanes = self.data["levels"][name], []
        for rank, item in enumerate(self.items(level, "lanes", ("levels", name))):
            keys: Keys = ("levels", name, "lanes", rank)
            if not isinstance(item, list) or len(item) < _PAIR or not all(map(_is_rank, item[:_PAIR])):
                self.refuse(keys, f"not a lane (got {got(item)}), expected [vertex, vertex, {{...}}]")
            about = self.about(item[_PAIR] if len(item) > _PAIR else {}, keys)
            self.plant.see_keys(about, _OF_LANES, self.line(keys), "lane")
            index = about.get("graph_idx", 0)
            if not _is_rank(index):
                self.refuse(keys, f"graph_idx: not a whole number (got {got(index)}), expected one")
            lanes.append((index, _Lane(item[0], item[1], about, self.line(keys))))
        return lanes

    def vertex(self, item: Any, keys: Keys) -> tuple[float, float, str, dict[str, Any]]:
        """Return x, y, name and parameters of a vertex.

        It is `[x, y, z, name, {...}]` in a building map, and `[x, y, {name: ..., ...}]` in a navigation graph.
        """
        if not isinstance(item, list) or len(item) < _PAIR:
            self.refuse(keys, f"not a vertex (got {got(item)}), expected [x, y, ...]")
        x, y = (self.number(entry, keys) for entry in item[:_PAIR])
        about = self.about(item[-1] if isinstance(item[-1], dict) else {}, keys)
        name = next((entry for entry in item[_PAIR:] if isinstance(entry, str)), about.get("name", ""))
        return x, y, str(name), about

    def projection(self, name: str, nav: bool, used: list[Any]) -> Callable[[Spot], Spot]:
        """Return the projection of a level's coordinates to metres, y downwards; `used`: the vertices on lanes."""
        system = self.data.get("coordinate_system", "reference_image")
        if nav or system == "cartesian_meters":
            return lambda spot: (spot[0], -spot[1])
        if system == "wgs84":
            keys: Keys = ("levels", name, "vertices")
            spots = [self.vertex(item, keys)[:2] for item in used]
            if not all(abs(x) <= globe.TURN and abs(y) <= globe.TURN / 4 for x, y in spots):
                self.refuse(("coordinate_system",), "wgs84, but some vertices are no degrees, expected all to be")
            return globe.plane(spots, self.plant)
        if system != "reference_image":
            expected = "reference_image, cartesian_meters or wgs84"
            self.refuse(("coordinate_system",), f"not known (got {got(system)}), expected {expected}")
        scale = self.scale(name)
        return lambda spot: (spot[0] * scale, spot[1] * scale)

    def scale(self, name: str) -> float:
        """Return the scale of a level in metres per pixel: the mean over its measurements."""
        scales = self.measured(name)
        if not scales:
            others = [title for title in self.data["levels"] if title != name]
            level, scales = next(((title, its) for title in others if (its := self.measured(title))), ("", []))
            if not scales:
                text = "no measurements, so nobody knows how long a pixel is, expected one at least"
                self.refuse(("levels", name), text)
            self.plant.note("doubtful", "scale", [level], "of another level, as this one has no measurements")
        mean = sum(scales) / len(scales)
        apart = [f"{size:.4g} m a pixel" for size in scales if abs(size - mean) > _DIFFER * mean]
        why = f"a measured distance that differs from the others; their mean counts, {mean:.4g} m a pixel"
        self.plant.note("doubtful", "scale", apart, why)
        return mean

    def measured(self, name: str) -> list[float]:
        """Return the scale by each distance measured on a level, in metres per pixel."""
        level, scales = self.data["levels"][name], []
        vertices = self.items(level, "vertices", ("levels", name))
        for rank, item in enumerate(self.items(level, "measurements", ("levels", name))):
            keys: Keys = ("levels", name, "measurements", rank)
            ends = item[:_PAIR] if isinstance(item, list) else []
            if len(ends) < _PAIR or not all(_is_rank(end) and end < len(vertices) for end in ends):
                self.refuse(keys, f"not a measurement (got {got(item)}), expected [vertex, vertex, {{distance: ...}}]")
            about = self.about(item[_PAIR] if len(item) > _PAIR else {}, keys)
            metres = self.number(about.get("distance"), keys)
            a, b = (self.vertex(vertices[end], ("levels", name, "vertices", end)) for end in ends)
            pixels = math.hypot(b[0] - a[0], b[1] - a[1])
            if not (metres > 0 and pixels > 0):
                self.refuse(keys, f"not a distance (got {got(metres)}), expected one above 0 between two places")
            scales.append(metres / pixels)
        return scales

    # What it becomes

    def place(self, point: str, named: bool, about: dict[str, Any]) -> None:
        """Add the locations and vehicles at a vertex; its name is its operation if it has no other."""
        plant, line = self.plant, self.plant.points[point].position
        if robot := about.get("spawn_robot_name"):
            plant.vehicles.append(Vehicle(str(robot), start=point, position=line))
        if about.get("is_charger"):
            plant.locations.append(Location(point, {point: ("charge",)}, line))
        work = [(str(about[key]), does) for key, does in _WORK.items() if about.get(key)]
        for name, does in work:
            plant.locations.append(Location(name, {point: (does,)}, line))
        if named and not work and not about.get("is_charger") and not about.get("is_parking_spot"):
            plant.locations.append(Location(point, {point: (point,)}, line))

    def links(self, lanes: Iterable[_Lane], names: dict[int, str]) -> None:
        for lane in lanes:
            limit = lane.about.get("speed_limit", 0)
            if not _is_number(limit):
                raise ModelError(
                    [f"{self.path}: {lane.line}: speed_limit: not a number (got {got(limit)}), expected one"]
                )
            speed = float(limit) if limit > 0 else math.inf
            both = bool(lane.about.get("bidirectional") or lane.about.get("is_bidirectional"))
            ends = names[lane.source], names[lane.target]
            link = Link(_title(lane, names), *ends, None, speed, speed if both else 0.0, lane.line)
            self.plant.links.append(link)

    def areas(self, lanes: Iterable[_Lane], names: dict[int, str], abouts: dict[int, dict[str, Any]]) -> None:
        """Add the groups of lanes and vertices (mutex) that one robot uses at a time, as areas."""
        for group, member, line in (
            *((lane.about.get("mutex"), _title(lane, names), lane.line) for lane in lanes),
            *(
                (about.get("mutex"), names[rank], self.plant.points[names[rank]].position)
                for rank, about in abouts.items()
            ),
        ):
            if group:
                before = self.groups.get(str(group), Area(str(group), (), "one-robot", line))
                self.groups[before.name] = replace(before, members=tuple(dict.fromkeys((*before.members, member))))

    def losses(
        self, level: dict[str, Any], lanes: list[_Lane], names: dict[int, str], abouts: dict[int, dict[str, Any]]
    ) -> None:
        """Note the parts of a level that models cannot represent: orientations, lifts on lanes, doors, docks."""
        plant, titles = self.plant, [(_title(lane, names), lane) for lane in lanes]
        for kind, keys, why in (
            ("orientation", ("orientation", "orientation_constraint"), "robots may drive in any direction"),
            ("lift", ("demo_mock_lift_name",), "a lift on a lane, which takes no time here"),
            ("door", ("door_name",), "a door on a lane, which takes no time here"),
            ("dock", ("dock_name",), "docking takes no time here"),
        ):
            marked = [(title, lane) for title, lane in titles if any(lane.about.get(key) for key in keys)]
            plant.note("left out", kind, [title for title, _ in marked], why, [lane.line for _, lane in marked])
        points = [plant.points[names[rank]] for rank, about in abouts.items() if about.get("dock_name")]
        plant.note_parts("left out", "dock", points, "docking takes no time here")
        plant.note("left out", "door", _names(level.get("doors")), _DOOR)

    # Values

    def items(self, level: Any, key: str, keys: Keys) -> list[Any]:
        """Return the list at a key of a level; empty where the key is missing."""
        if not isinstance(level, dict):
            self.refuse(keys, f"not a level (got {got(level)}), expected vertices and lanes")
        items = level.get(key, [])
        if not isinstance(items, list):
            self.refuse((*keys, key), f"not a list (got {got(items)}), expected {key}")
        return items

    def about(self, value: Any, keys: Keys) -> dict[str, Any]:
        """Return the parameters of a part, without the type codes of building maps."""
        if not isinstance(value, dict):
            self.refuse(keys, f"not parameters (got {got(value)}), expected {{name: [type, value]}}")
        typed = {key: item[1] if isinstance(item, list) and len(item) == _PAIR else item for key, item in value.items()}
        return {key: item for key, item in typed.items() if not isinstance(item, list | dict)}

    def number(self, value: Any, keys: Keys) -> float:
        if not _is_number(value):
            self.refuse(keys, f"not a number (got {got(value)}), expected one")
        return float(value)

    def line(self, keys: Keys) -> str:
        position = self.document.positions.of(keys)
        return f"line {position.line}" if position.line else position.text.removeprefix(f"{self.path}: ")

    def refuse(self, keys: Keys, text: str) -> NoReturn:
        raise ModelError([f"{self.document.positions.line(keys)[1]}: {text}"])


def _cabin(about: dict[str, Any]) -> str:
    """Return the lift in whose cabin a vertex is; empty if it is in none."""
    return str(about.get("lift_cabin") or about.get("lift") or "")


def _is_rank(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LIMITS["number"][0]


def _title(lane: _Lane, names: dict[int, str]) -> str:
    return f"{names[lane.source]} - {names[lane.target]}"


def _names(parts: Any) -> list[str]:
    """Return the names of lifts (by name) or doors (`[vertex, vertex, {name: [1, ...]}]`)."""
    if isinstance(parts, dict):
        return list(parts)
    names = []
    for part in parts if isinstance(parts, list) else ():
        about = part[-1] if isinstance(part, list) and part else {}
        name = about.get("name", "") if isinstance(about, dict) else ""
        names.append(str(name[-1] if isinstance(name, list) and name else name))
    return names
