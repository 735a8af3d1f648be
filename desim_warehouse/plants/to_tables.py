"""A plant as two tables: nodes.csv and edges.csv, or as a graph (GraphML) with the same columns as attributes."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape, quoteattr

from desim_warehouse.plants.checks import distance, length_of
from desim_warehouse.plants.tables import EDGES_FILE, NODES_FILE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from desim_warehouse.plants.plant import Link, Plant

Row = dict[str, str | float | bool]
_DIGITS = 6  # of metres and metres a second
_EQUAL = 1e-6


def tables(plant: Plant) -> dict[str, str]:
    """The two tables by the names of their files; what they cannot hold is noted in the plant."""
    _losses(plant)
    edges = [{"from": link.source, "to": link.target, **_edge(plant, link)} for link in plant.links]
    return {NODES_FILE: _csv(_NODE_COLUMNS, list(_nodes(plant))), EDGES_FILE: _csv(_columns(edges), edges)}


_NODE_COLUMNS = ("name", "x", "y", "role", "station")
_EDGE_COLUMNS = ("from", "to", "length", "speed", "speed_back", "two_way", "side_by_side")


def _columns(edges: list[Row]) -> tuple[str, ...]:
    """Those of edges: a speed back only where one differs."""
    return tuple(name for name in _EDGE_COLUMNS if name != "speed_back" or any(name in row for row in edges))


def graphml(plant: Plant) -> str:
    """The text of a GraphML file; a two-way lane is two edges there, as graphs with directions have them."""
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
