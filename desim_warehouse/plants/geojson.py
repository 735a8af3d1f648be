"""GeoJSON: lanes as LineString and MultiLineString, marks as Point, with properties.

- Degrees are projected onto a plane that touches the globe in their middle. What lies within half a unit is in degrees,
  anything larger in metres: no plant is 50 km wide, and none half a metre.
- Lines are two-way unless they say `oneway` or `two_way`, and may have a `speed`. A place has a `role` (or `layer`) and
  a `name`, and belongs to the nearest point of a lane up to 2 m off.
- A floor is flat: where lines cross or end on another they are joined. Ends within 5 cm of each other are one point.
- Corners are points. Curves become chords up to 25 cm beside them, with the length of the curve.

Source: RFC 7946.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from desim_warehouse.errors import ModelError, got
from desim_warehouse.model.json_text import read_json
from desim_warehouse.plants import globe
from desim_warehouse.plants.lines import Line, Mark, Spot, join
from desim_warehouse.plants.plant import Plant
from desim_warehouse.plants.tables import EDGE, NODE, Columns, TableRecord
from desim_warehouse.values.fields import LIMITS

EXPECTED = "lines (GeoJSON)"
_WIDEST = 0.5  # degrees
_LANE = {**{key: EDGE[key] for key in ("name", "speed", "two_way")}, "one_way": ("one_way", "oneway")}
_PLACE = {"name": NODE["name"], "role": (*NODE["role"], "layer"), "station": NODE["station"]}
_KINDS = {"LineString": 1, "MultiLineString": 2, "Point": 0, "MultiPoint": 1}
"""Geometries that are read, by how deep the lists of positions are."""


def looks(path: Path, start: bytes) -> bool:
    """Whether a file may be GeoJSON: by its ending, or what it says it is."""
    return path.suffix.lower() == ".geojson" or b'"FeatureCollection"' in start


def read(path: Path, content: bytes, *, lanes: str | tuple[str, ...] = ()) -> Plant:
    """Read a plant from GeoJSON.

    Args:
        path: the file.
        content: what stands in it.
        lanes: layers (the property layer) whose lines are lanes; default: all lines.

    Raises:
        ModelError: where it cannot be read, with the feature.
    """
    plant = Plant(path.stem, f"{path.name} (GeoJSON)")
    found = _Reader(path, plant, (lanes,) if isinstance(lanes, str) else lanes)
    found.read(read_json(path, content, EXPECTED))
    lines, marks = found.in_metres()
    join(plant, lines, marks)
    return plant


class _Reader:
    """The lines and marks of a file, at first in its own coordinates."""

    def __init__(self, path: Path, plant: Plant, layers: tuple[str, ...]) -> None:
        self.path = path
        self.plant = plant
        self.layers = {layer.casefold() for layer in layers}
        self.lines: list[tuple[Line, list[Spot]]] = []
        self.marks: list[tuple[Mark, Spot]] = []

    def read(self, data: Any) -> None:
        """Read all features of the collection."""
        if not isinstance(data, dict) or data.get("type") != "FeatureCollection":
            self.refuse("the top level", f"not a FeatureCollection (got {got(data)}), expected one")
        features = data.get("features")
        if not isinstance(features, list):
            self.refuse("features", f"not a list (got {got(features)}), expected features")
        others: dict[str, list[str]] = {}
        unread: dict[str, None] = {}
        aside: list[str] = []
        for rank, feature in enumerate(features):
            where = f"features[{rank}]"
            if not isinstance(feature, dict) or not isinstance(feature.get("properties") or {}, dict):
                self.refuse(where, f"not a feature (got {got(feature)}), expected one")
            geometry = feature.get("geometry")
            if geometry is None:
                others.setdefault("nothing", []).append(where)
                continue
            kind = geometry.get("type") if isinstance(geometry, dict) else None
            if not isinstance(kind, str):
                self.refuse(f"{where}.geometry", f"not a geometry (got {got(geometry)}), expected one with a type")
            if kind not in _KINDS:
                others.setdefault(kind, []).append(where)
                continue
            properties = feature.get("properties") or {}
            layer = str(_value(properties, "layer") or "")
            if kind.endswith("LineString") and self.layers and layer.casefold() not in self.layers:
                aside.append(where)
                continue
            each = self.positions(geometry.get("coordinates"), f"{where}.geometry.coordinates", _KINDS[kind])
            record = self.record(properties, where, _LANE if kind.endswith("LineString") else _PLACE)
            unread.update(dict.fromkeys(record.columns.unread))
            (self.line if kind.endswith("LineString") else self.mark)(record, where, each)
        for kind, positions in others.items():
            self.plant.note("left out", "feature", positions, f"{kind}, expected lines and points")
        self.plant.note("left out", "feature", aside, "a line on another layer than those of lanes")
        unread.pop("layer", None)
        self.plant.note("left out", "property", list(unread), "nothing that a layout has")

    def record(self, properties: Mapping[str, Any], where: str, known: Mapping[str, tuple[str, ...]]) -> TableRecord:
        position = f"{self.path}: {where}"
        columns = Columns.of(properties, known, position)
        return TableRecord(columns, properties, position, where)

    def line(self, record: TableRecord, where: str, each: list[list[Spot]]) -> None:
        """A lane, in both directions unless it says otherwise."""
        speed, two_way, one_way = record.above_0("speed") or math.inf, record.flag("two_way"), record.get("one_way")
        backwards = str(one_way).strip() in {"-1", "reverse"}
        if two_way is None:
            two_way = True if one_way is None or backwards else not record.flag("one_way")
        name = where if record.get("name") is None else record.text("name")
        for points in each:
            back = speed if two_way and not backwards else 0.0
            self.lines.append((Line(name, (), speed, back, where), points[::-1] if backwards else points))

    def mark(self, record: TableRecord, where: str, each: list[list[Spot]]) -> None:
        """A mark beside a lane."""
        role = record.get("role")
        operations = tuple(filter(None, (one.strip() for one in str(role).split("+")))) if role is not None else ()
        name = record.get("station") or record.get("name") or where
        self.marks += [(Mark(str(name), (0, 0), operations, where), at) for points in each for at in points]

    def positions(self, value: Any, where: str, depth: int) -> list[list[Spot]]:
        """Lists of positions, whatever the kind of geometry."""
        if depth == 0:
            return [[self.position(value, where)]]
        if not isinstance(value, list):
            self.refuse(where, f"not a list (got {got(value)}), expected coordinates")
        if depth == 1:
            return [[self.position(at, f"{where}[{rank}]") for rank, at in enumerate(value)]]
        return [spots for rank, one in enumerate(value) for spots in self.positions(one, f"{where}[{rank}]", depth - 1)]

    def position(self, value: Any, where: str) -> Spot:
        """A position in the coordinates of the file; a height is not read."""
        most = LIMITS["number"][0]
        fits = isinstance(value, list) and len(value) > 1 and all(type(one) in (int, float) for one in value[:2])
        if not fits or not all(abs(one) <= most for one in value[:2]):
            self.refuse(where, f"not a position (got {got(value)}), expected two numbers")
        return float(value[0]), float(value[1])

    def refuse(self, where: str, text: str) -> NoReturn:
        raise ModelError([f"{self.path}: {where}: {text}"])

    def in_metres(self) -> tuple[list[Line], list[Mark]]:
        """Lines and marks in metres, y downwards."""
        to_metres = self.projection()
        lines = [
            Line(line.name, tuple(map(to_metres, points)), line.speed, line.speed_back, line.position)
            for line, points in self.lines
        ]
        return lines, [Mark(mark.name, to_metres(at), mark.operations, mark.position) for mark, at in self.marks]

    def projection(self) -> Callable[[Spot], Spot]:
        """From the coordinates of the file to metres, by how far they reach."""
        spots = [at for _, points in self.lines for at in points]
        if not spots:
            self.refuse("features", "no line, expected lanes drawn as lines")
        west, east = min(x for x, _ in spots), max(x for x, _ in spots)
        south, north = min(y for _, y in spots), max(y for _, y in spots)
        if max(east - west, north - south) > _WIDEST:
            self.plant.assume("units.length", "m; coordinates reach further than degrees of one plant would")
            return lambda at: (at[0], -at[1])
        if max(abs(west), abs(east)) > 360 or max(abs(south), abs(north)) > 90:  # noqa: PLR2004 - degrees
            text = f"from {got([west, south])} to {got([east, north])}, neither degrees nor metres of a plant"
            self.refuse("coordinates", text)
        return globe.plane(spots, self.plant)


def _value(properties: Mapping[str, Any], name: str) -> Any:
    return next((value for key, value in properties.items() if key.casefold() == name), None)
