"""GeoJSON for `desim import`: lanes as LineString and MultiLineString, marks as Point, with properties.

- A file whose lines name their ends, by `startid` and `endid` as in route graphs of Nav2 or by `from` and `to`, is a
graph: its points are the nodes, by their `id`, and edges lead from one node to another, one-way unless they have
`two_way`. Edges meet only at nodes, and need no coordinates.
- Degrees are projected onto a plane that touches the globe in their middle. A file that lies within half a unit is in
degrees, a larger file in metres: no plant is 50 km wide, and none half a metre. If `crs` names web Mercator
(EPSG:3857), coordinates are metres times cosh(y / 6378137), and are divided by that factor.
- In all other files, lines are two-way unless they have `oneway` or `two_way`. A place has a `role` (or `layer`) and a
`name`, and belongs to the nearest point of a lane up to 2 m away.
- `speed` is in m/s, `maxspeed` in km/h, as in OpenStreetMap.
- Floors are flat: lines that cross, or end on another, are joined. Ends within 5 cm of each other are one point;
within 50 cm they are doubtful.
- Corners are points. Curves become chords up to 25 cm off, with the length of the curve.

Source: RFC 7946; crs: The GeoJSON Format Specification 1.0 (2008), section 3; Nav2, Route Server: graph file formats.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, NoReturn

from desim_warehouse.errors import ModelError, got
from desim_warehouse.model.json_text import read_json
from desim_warehouse.plants import globe
from desim_warehouse.plants.lines import Line, Mark, Spot, join
from desim_warehouse.plants.plant import Plant
from desim_warehouse.plants.tables import EDGE, NODE, OSM, Columns, TableRecord, fill, of_maps
from desim_warehouse.values.fields import LIMITS
from desim_warehouse.values.headings import heading

EXPECTED = "lines (GeoJSON)"
_WIDEST = 0.5  # degrees
_LANE = {key: EDGE[key] for key in ("name", "speed", "two_way", "one_way")}
_PLACE = {"name": NODE["name"], "role": (*NODE["role"], "layer"), "station": NODE["station"]}
_ENDS = {"from": ("start_id", *EDGE["from"]), "to": ("end_id", *EDGE["to"])}
_EDGE = {**{key: EDGE[key] for key in ("length", "speed_back", "side_by_side")}, **_LANE, **_ENDS}
_ID = ("id", "node_id", "node", "point", "name")
_NODE = {**_PLACE, "name": _ID}
_MERCATOR = re.compile(r"(3857|900913|102100|3785)$")
_DEGREES = re.compile(r"(4326|CRS84|4258)$")
_NEARLY_ONE = 0.9999
"""Scale of web Mercator from which on coordinates stay as they are: near its equator Nav2 writes positions in a hall.
"""
_RADIUS = 6_378_137.0
"""Radius of the sphere of web Mercator, in metres."""
_KINDS = {"LineString": 1, "MultiLineString": 2, "Point": 0, "MultiPoint": 1}
"""Geometries that are read, with the depth of their lists of positions."""


def looks(path: Path, start: bytes) -> bool:
    """Return whether a file may be GeoJSON, by its ending or its type."""
    return path.suffix.lower() == ".geojson" or b'"FeatureCollection"' in start


def read(path: Path, content: bytes, *, lanes: str | tuple[str, ...] = ()) -> Plant:
    """Read a plant from GeoJSON.

    Args:
        path: the file.
        content: its bytes.
        lanes: layers (the property layer) whose lines are lanes; default: all lines.

    Raises:
        ModelError: the file cannot be read, with the feature.
    """
    plant = Plant(path.stem, f"{path.name} (GeoJSON)")
    reader = _Reader(path, plant, (lanes,) if isinstance(lanes, str) else lanes)
    features = reader.features(read_json(path, content, EXPECTED))
    if _is_graph(features):
        reader.graph(features)
    else:
        reader.read(features)
        join(plant, *reader.in_metres())
    for title in reader.of_maps:
        plant.assume("layout.edges", of_maps(title))
    return plant


def _is_graph(features: list[Any]) -> bool:
    """Return whether the lines of a file name their end nodes, by the words of Nav2 or by the names of points."""
    ids = {str(_own_id(feature)) for feature in features if _kind_of(feature) == "Point"} - {"None"}
    for feature in features:
        properties = feature.get("properties") if isinstance(feature, dict) else None
        if not isinstance(properties, dict) or _kind_of(feature) in {"Point", "MultiPoint"}:
            continue
        ends = Columns.of(properties, _ENDS, "").named
        if len(ends) == len(_ENDS):
            names = {key: str(properties[title]) for key, title in ends.items()}
            if heading(ends["from"])[0] == "startid" or set(names.values()) <= ids:
                return True
    return False


def _kind_of(feature: Any) -> Any:
    geometry = feature.get("geometry") if isinstance(feature, dict) else None
    return geometry.get("type") if isinstance(geometry, dict) else None


def _own_id(feature: Mapping[str, Any]) -> Any:
    """Return the id of a feature, from its properties or its own key."""
    properties = feature.get("properties")
    named = Columns.of(properties, {"name": _ID}, "").named if isinstance(properties, dict) else {}
    return properties[named["name"]] if named else feature.get("id")  # type: ignore[index]


class _Reader:
    """The lines and marks of a file, at first in the file's coordinates."""

    def __init__(self, path: Path, plant: Plant, layers: tuple[str, ...]) -> None:
        self.path = path
        self.plant = plant
        self.layers = {layer.casefold() for layer in layers}
        self.lines: list[tuple[Line, list[Spot]]] = []
        self.marks: list[tuple[Mark, Spot]] = []
        self.crs = ""
        self.of_maps: dict[str, None] = {}

    def features(self, data: Any) -> list[Any]:
        """Return the features of the collection, and keep its coordinate reference system."""
        if not isinstance(data, dict) or data.get("type") != "FeatureCollection":
            self.refuse("the top level", f"not a FeatureCollection (got {got(data)}), expected one")
        features = data.get("features")
        if not isinstance(features, list):
            self.refuse("features", f"not a list (got {got(features)}), expected features")
        crs = data.get("crs")
        named = crs.get("properties") if isinstance(crs, dict) else None
        self.crs = str(named.get("name") or "") if isinstance(named, dict) else ""
        return features

    def graph(self, features: list[Any]) -> None:
        """Read a file whose lines name their end nodes."""
        nodes: list[tuple[str, dict[str, Any], Spot]] = []
        edges: list[tuple[str, dict[str, Any], list[Spot]]] = []
        others: dict[str, list[str]] = {}
        for rank, feature in enumerate(features):
            where = f"features[{rank}]"
            if not isinstance(feature, dict) or not isinstance(feature.get("properties") or {}, dict):
                self.refuse(where, f"not a feature (got {got(feature)}), expected one")
            kind, properties = _kind_of(feature), dict(feature.get("properties") or {})
            place = f"{where}.geometry.coordinates"
            if kind == "Point":
                if not Columns.of(properties, {"name": _ID}, where).named:
                    properties["id"] = feature.get("id")
                nodes.append((where, properties, self.position(feature["geometry"].get("coordinates"), place)))
            elif kind in {None, "LineString", "MultiLineString"}:
                each = (
                    [] if kind is None else self.positions(feature["geometry"].get("coordinates"), place, _KINDS[kind])
                )
                edges.append((where, properties, [spot for points in each for spot in points]))
            else:
                others.setdefault(str(kind), []).append(where)
        self.fill(nodes, edges)
        for kind, positions in others.items():
            self.plant.note("left out", "feature", positions, f"{kind}, expected lines and points")

    def fill(
        self, nodes: list[tuple[str, dict[str, Any], Spot]], edges: list[tuple[str, dict[str, Any], list[Spot]]]
    ) -> None:
        """Add nodes and edges to the plant, each with its position in the file, its properties and its coordinates."""
        to_metres = self.projection([spot for *_, spot in nodes])
        unread: dict[str, None] = {}
        points, links, aside = [], [], []
        for where, properties, spot in nodes:
            x, y = to_metres(spot)
            texts = {key: value for key, value in properties.items() if not isinstance(value, dict | list)}
            unread.update(dict.fromkeys(properties.keys() - texts.keys()))
            columns = Columns.of(texts, _NODE, f"{self.path}: {where}")
            unread.update(dict.fromkeys(columns.unread))
            own = Columns({**columns.named, "x": "\0x", "y": "\0y"}, columns.units, ())
            points.append(TableRecord(own, {**texts, "\0x": x, "\0y": y}, f"{self.path}: {where}", where))
        for where, properties, spots in edges:
            record = self.record(properties, where, _EDGE)
            unread.update(dict.fromkeys(record.columns.unread))
            if record.get("from") is None and record.get("to") is None:
                aside.append(where)
                continue
            links.append(_with_length(record, [to_metres(spot) for spot in spots]))
        fill(self.plant, points, links)
        self.plant.note("left out", "feature", aside, "a line that does not name its ends, as the others do")
        self.plant.note("left out", "property", sorted(unread), "nothing that a layout has")

    def read(self, features: list[Any]) -> None:
        """Read all features of a file that is no graph."""
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

    def record(self, properties: Mapping[str, Any], where: str, headings: Mapping[str, tuple[str, ...]]) -> TableRecord:
        position = f"{self.path}: {where}"
        columns = Columns.of(properties, headings, position, OSM)
        if columns.named.get("speed") in OSM:
            self.of_maps[columns.named["speed"]] = None
        return TableRecord(columns, properties, position, where)

    def line(self, record: TableRecord, where: str, each: list[list[Spot]]) -> None:
        """Add a lane, in both directions unless its properties say otherwise."""
        speed, two_way, one_way = record.above_0("speed") or math.inf, record.flag("two_way"), record.get("one_way")
        backwards = str(one_way).strip() in {"-1", "reverse"}
        if two_way is None:
            two_way = True if one_way is None or backwards else not record.flag("one_way")
        name = where if record.get("name") is None else record.text("name")
        for points in each:
            back = speed if two_way and not backwards else 0.0
            self.lines.append((Line(name, (), speed, back, where), points[::-1] if backwards else points))

    def mark(self, record: TableRecord, where: str, each: list[list[Spot]]) -> None:
        """Add the marks of points beside lanes."""
        role = record.get("role")
        operations = (
            tuple(filter(None, (operation.strip() for operation in str(role).split("+")))) if role is not None else ()
        )
        name = record.get("station") or record.get("name") or where
        self.marks += [(Mark(str(name), (0, 0), operations, where), spot) for points in each for spot in points]

    def positions(self, value: Any, where: str, depth: int) -> list[list[Spot]]:
        """Return the coordinates of a geometry as lists of positions; `depth`: the depth of lists in the file."""
        if depth == 0:
            return [[self.position(value, where)]]
        if not isinstance(value, list):
            self.refuse(where, f"not a list (got {got(value)}), expected coordinates")
        if depth == 1:
            return [[self.position(item, f"{where}[{rank}]") for rank, item in enumerate(value)]]
        return [
            spots for rank, item in enumerate(value) for spots in self.positions(item, f"{where}[{rank}]", depth - 1)
        ]

    def position(self, value: Any, where: str) -> Spot:
        """Return a position in the coordinates of the file, without its height."""
        most = LIMITS["number"][0]
        fits = isinstance(value, list) and len(value) > 1 and all(type(number) in (int, float) for number in value[:2])
        if not fits or not all(abs(number) <= most for number in value[:2]):
            self.refuse(where, f"not a position (got {got(value)}), expected two numbers")
        return float(value[0]), float(value[1])

    def refuse(self, where: str, text: str) -> NoReturn:
        raise ModelError([f"{self.path}: {where}: {text}"])

    def in_metres(self) -> tuple[list[Line], list[Mark]]:
        """Return the lines and marks in metres, y downwards."""
        to_metres = self.projection([spot for _, points in self.lines for spot in points])
        lines = [
            Line(line.name, tuple(map(to_metres, points)), line.speed, line.speed_back, line.position)
            for line, points in self.lines
        ]
        return lines, [Mark(mark.name, to_metres(spot), mark.operations, mark.position) for mark, spot in self.marks]

    def projection(self, spots: list[Spot]) -> Callable[[Spot], Spot]:
        """Return the projection of the file's coordinates to metres, chosen by its reference system and its extent."""
        if not spots:
            self.refuse("features", "no line, expected lanes drawn as lines")
        west, east = min(x for x, _ in spots), max(x for x, _ in spots)
        south, north = min(y for _, y in spots), max(y for _, y in spots)
        if _MERCATOR.search(self.crs):
            shrunk = 1 / math.cosh((south + north) / 2 / _RADIUS)
            self.plant.assume("units.length", f"m; web Mercator ({self.crs}), of which a metre is {shrunk:.4g} m here")
            left, top = (west, north) if shrunk < _NEARLY_ONE else (0.0, 0.0)
            return lambda spot: (round((spot[0] - left) * shrunk, 4), round((top - spot[1]) * shrunk, 4))
        if max(east - west, north - south) > _WIDEST:
            if _DEGREES.search(self.crs):
                why = "it says degrees, and coordinates reach further than those of one plant would: taken for metres"
                self.plant.note("doubtful", "crs", [self.crs], why)
            self.plant.assume("units.length", "m; coordinates reach further than degrees of one plant would")
            return lambda spot: (spot[0], -spot[1])
        if max(abs(west), abs(east)) > 360 or max(abs(south), abs(north)) > 90:  # noqa: PLR2004 - degrees
            text = f"from {got([west, south])} to {got([east, north])}, neither degrees nor metres of a plant"
            self.refuse("coordinates", text)
        return globe.plane(spots, self.plant)


def _with_length(record: TableRecord, spots: list[Spot]) -> TableRecord:
    """Return an edge with the length along its corners if it states none."""
    named, values = dict(record.columns.named), dict(record.values)
    if record.get("length") is None and len(spots) > 2:  # noqa: PLR2004 - with corners
        named["length"], values["\0length"] = "\0length", sum(math.dist(a, b) for a, b in pairwise(spots))
    units = {key: size for key, size in record.columns.units.items() if not named[key].startswith("\0")}
    return TableRecord(Columns(named, units, ()), values, record.where, record.position)


def _value(properties: Mapping[str, Any], name: str) -> Any:
    return next((value for key, value in properties.items() if key.casefold() == name), None)
