"""Export of a plant to a building map of Open-RMF's traffic editor (`.building.yaml`), in metres, y upwards, graph 0.

A lane of the map leads both ways at one speed. Places where robots load are dispensers, and places where they unload
are ingestors, each with the name of its location. Cabins of lifts are vertices on several levels.

Source: the format of rmf_traffic_editor, with its type codes for numbers (3), whole numbers (2), texts (1) and flags
(4).
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from desim_warehouse.plants.checks import distance, length_of
from desim_warehouse.plants.plant import Link, Plant
from desim_warehouse.plants.to_opentcs import joined

_TEXT, _WHOLE, _NUMBER, _FLAG = 1, 2, 3, 4
_PLACES = {"load": "pickup_dispenser", "unload": "dropoff_ingestor"}
_FLAGS = {"charge": "is_charger", "park": "is_parking_spot"}
_EQUAL = 1e-3
_DIGITS = 6
_STOREY = 3.0  # metres from level to level
_ONLY = "L1"
"""Name of the level of a plant with only one."""
Item = dict[str, list[Any]]


def rmf(plant: Plant) -> str:
    """Return the text of a building map; losses are noted in the plant."""
    levels = plant.levels or (_ONLY,)
    cabins = {point: lift for lift, stops in plant.lifts.items() for point in stops}
    groups = _groups(plant)
    lines = ["coordinate_system: cartesian_meters", "levels:"]
    for height, level in enumerate(levels):
        points = [name for name in plant.points if plant.level_of.get(name, level) == level]
        rank = {name: number for number, name in enumerate(points)}
        links = [link for link in plant.links if link.source in rank]
        lanes = [[rank[a], rank[b], about] for link in links for a, b, about in _ways(link, groups)]
        lines += [f"  {_flow(level)}:", f"    elevation: {_STOREY * height:g}"]
        lines += _listed("lanes", lanes)
        lines += _listed("vertices", [_vertex(plant, name, cabins, groups) for name in points])
    lowest = {lift: {"lowest_floor": plant.level_of[stops[0]]} for lift, stops in plant.lifts.items()}
    lines.append(f"lifts: {_flow(lowest)}")
    lines.append(f"name: {_flow(plant.name)}")
    _losses(plant)
    return "\n".join([*lines, ""])


def _vertex(plant: Plant, name: str, cabins: Mapping[str, str], groups: Mapping[str, str]) -> list[Any]:
    """Return a vertex: coordinates, height, name, and parameters."""
    point, about = plant.points[name], dict[str, list[Any]]()
    for location in plant.locations:
        for operation in location.operations.get(name, ()):
            if operation in _PLACES:
                about[_PLACES[operation]] = [_TEXT, location.name]
            elif operation in _FLAGS:
                about[_FLAGS[operation]] = [_FLAG, True]
    if point.parking:
        about[_FLAGS["park"]] = [_FLAG, True]
    if name in cabins:
        about["lift_cabin"] = [_TEXT, cabins[name]]
    if name in groups:
        about["mutex"] = [_TEXT, groups[name]]
    return [round(point.x, _DIGITS), round(-point.y, _DIGITS) + 0.0, 0, name, about]


def _ways(link: Link, groups: Mapping[str, str]) -> Iterator[tuple[str, str, Item]]:
    """Yield a lane for both directions, or one for each open direction if their speeds differ."""
    both = link.speed == link.speed_back
    for a, b, speed in ((link.source, link.target, link.speed), (link.target, link.source, link.speed_back)):
        if speed > 0:
            about: Item = {"bidirectional": [_FLAG, both], "graph_idx": [_WHOLE, 0]}
            if speed < float("inf"):
                about["speed_limit"] = [_NUMBER, round(speed, _DIGITS)]
            if link.name in groups:
                about["mutex"] = [_TEXT, groups[link.name]]
            yield a, b, about
        if both:
            return


def _groups(plant: Plant) -> dict[str, str]:
    """Return mutex groups by the names of their members, each in one group; zones of one direction are left out."""
    groups: dict[str, str] = {}
    for area in plant.areas:
        if area.rule == "one-robot":
            for member in area.members:
                groups.setdefault(member, area.name)
    return groups


def _losses(plant: Plant) -> None:
    ends = {end for link in plant.links for end in (link.source, link.target)}
    alone = [point for point in plant.points if point not in ends]
    plant.note("left out", "point", alone, "no lane leads there, so readers of maps leave it out")
    longer = [
        link.name
        for link in plant.links
        if abs(length_of(plant, link) - distance(plant, link.source, link.target)) > _EQUAL
    ]
    plant.note("changed", "lane", longer, "as long as the straight line between its points: maps have no lengths")
    joined(plant, [link for link in plant.links if link.side_by_side], straight=True)
    plant.note("left out", "vehicle", [vehicle.name for vehicle in plant.vehicles], "a building map has no fleet")
    directed = [area.name for area in plant.areas if area.rule != "one-robot"]
    plant.note("left out", "zone", directed, "a building map has no zones of one direction")


def _listed(key: str, items: list[Any]) -> list[str]:
    """Return the lines of a list of a level, one for each item."""
    return [f"    {key}:", *(f"      - {_flow(item)}" for item in items)] if items else [f"    {key}: []"]


def _flow(value: Any) -> str:
    """Return a part as text in one line: JSON, which is also YAML."""
    return json.dumps(value, ensure_ascii=False)
