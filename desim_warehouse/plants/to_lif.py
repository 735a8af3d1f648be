"""Export of a plant to the Layout Interchange Format of VDMA, version 1.0.0: metres and metres per second, y upwards.

A two-way lane becomes two edges. The operations of robots at a node are actions with their names in VDA 5050; parking
has none there, so its action is our own. Floors are layouts of one level each, and the rides of a lift are edges
between them with the lift's name.

Source: VDMA, Layout Interchange Format (LIF) 1.0.0, and its JSON schema.
"""

from __future__ import annotations

import datetime as dt
import json
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from desim_warehouse._version import __version__
from desim_warehouse.plants.checks import distance, length_of
from desim_warehouse.plants.plant import Plant, claim
from desim_warehouse.plants.to_opentcs import joined

_ACTIONS = {"load": "pick", "unload": "drop", "charge": "startCharging", "park": "park"}
_TYPE = "robot"
_EQUAL = 1e-3
_DIGITS = 6


def lif(plant: Plant) -> str:
    """Return the text of a LIF file; losses are noted in the plant."""
    nodes, edges, stations = _nodes(plant), [*_edges(plant), *_rides(plant)], _stations(plant)
    name, level_of = plant.name or "layout", plant.level_of
    layouts = []
    for level in plant.levels or ("",):
        title = f"{name} {level}" if level else name
        layouts.append(
            {
                "layoutId": title,
                "layoutName": title,
                "layoutVersion": "1",
                **({"layoutLevelId": level} if level else {}),
                "nodes": [node for node in nodes if level_of.get(node["nodeId"], "") == level],
                "edges": [edge for edge in edges if level_of.get(edge["startNodeId"], "") == level],
                "stations": [
                    station for station in stations if level_of.get(station["interactionNodeIds"][0], "") == level
                ],
            }
        )
    head = {
        "projectIdentification": plant.name or "layout",
        "creator": f"desim-warehouse {__version__}",
        "exportTimestamp": dt.datetime.now(dt.UTC).strftime("%Y-%m-%dT%H:%M:%S.00Z"),
        "lifVersion": "1.0.0",
    }
    plant.note("left out", "vehicle", [vehicle.name for vehicle in plant.vehicles], "a LIF file has no fleet")
    plant.note("left out", "zone", [area.name for area in plant.areas], "a LIF file has no traffic rules")
    return json.dumps({"metaInformation": head, "layouts": layouts}, indent=1, ensure_ascii=False) + "\n"


def _nodes(plant: Plant) -> list[dict[str, Any]]:
    work, nodes = plant.work(), []
    for point in plant.points.values():
        allowed = [
            {"actionType": _ACTIONS[operation], "requirementType": "OPTIONAL", "blockingType": "HARD"}
            for operation in work.get(point.name, ())
        ]
        nodes.append(
            {
                "nodeId": point.name,
                "mapId": "map",
                "nodePosition": {"x": round(point.x, _DIGITS), "y": round(-point.y, _DIGITS) + 0.0},
                "vehicleTypeNodeProperties": [{"vehicleTypeId": _TYPE, **({"actions": allowed} if allowed else {})}],
            }
        )
    return nodes


def _edges(plant: Plant) -> list[dict[str, Any]]:
    edges, longer, taken = [], [], set[str]()
    for link in plant.links:
        if abs(length_of(plant, link) - distance(plant, link.source, link.target)) > _EQUAL:
            longer.append(link.name)
        for start, end, speed in (
            (link.source, link.target, link.speed),
            (link.target, link.source, link.speed_back),
        ):
            if speed:
                limit = {"maxSpeed": round(speed, _DIGITS)} if speed < float("inf") else {}
                name = claim(f"{start}>{end}", taken)
                properties = {"vehicleTypeId": _TYPE, "rotationAllowed": False, **limit}
                edges.append(
                    {"edgeId": name, "startNodeId": start, "endNodeId": end, "vehicleTypeEdgeProperties": [properties]}
                )
    plant.note("changed", "lane", longer, "as long as the straight line between its points: LIF has no lengths")
    joined(plant, [link for link in plant.links if link.side_by_side], straight=True)
    return edges


def _rides(plant: Plant) -> Iterator[dict[str, Any]]:
    """Yield the edges from floor to floor, in both directions, with the name of their lift."""
    for lift, stops in plant.lifts.items():
        for low, high in pairwise(stops):
            for start, end in ((low, high), (high, low)):
                properties = {"vehicleTypeId": _TYPE, "rotationAllowed": False}
                yield {
                    "edgeId": f"{start}>{end}",
                    "edgeName": lift,
                    "startNodeId": start,
                    "endNodeId": end,
                    "vehicleTypeEdgeProperties": [properties],
                }


def _stations(plant: Plant) -> list[dict[str, Any]]:
    """Return a station for every location, at most one at a node; operations are actions of the nodes."""
    taken: set[str] = set()
    served: set[str] = set()
    places = [(location.name, list(location.operations)) for location in plant.locations]
    places += [(f"parking {point.name}", [point.name]) for point in plant.points.values() if point.parking]
    stations = []
    for wanted, points in places:
        nodes = [point for point in points if point not in served]
        if nodes:
            name = claim(wanted, taken)
            served |= {*nodes}
            stations.append({"stationId": name, "interactionNodeIds": nodes, "stationName": name})
    return stations
