"""The keys of LIF files: version 1.0 as in the guideline's JSON schema, and version 2.0 translated to it.

For the reader of LIF, `plants.lif`.

Sources: VDMA, Layout Interchange Format (LIF), version 1.0.0, 2024, and version 2.0.0, 2026. Keys that are not listed
here are allowed there, too. New keys of 2.0 without a counterpart in version 1 stay as they are and are reported as
left out, as is everything that models do not hold.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from desim_warehouse.plants.keyed import POSITION, Each, Flag, Number, Text, section
from desim_warehouse.plants.plant import Link, Plant

Item = dict[str, Any]
_BACKWARDS = 0.1  # rad from pi
_DEGREES = "beyond a full turn in rad; probably in degrees"
_TURNS = Text(("NONE", "CCW", "CW", "BOTH"))

ACTION = section(
    {
        "actionType": Text(),
        "actionDescription": Text(),
        "requirementType": Text(("REQUIRED", "CONDITIONAL", "OPTIONAL")),
        "blockingType": Text(("NONE", "SOFT", "HARD")),
        "actionParameters": Each(section({"key": Text(), "value": Text()}, "key value")),
    },
    "actionType blockingType",
)
TRAJECTORY = section(
    {
        "degree": Number(least=1),
        "knotVector": Each(Number(least=0, most=1)),
        "controlPoints": Each(section({"x": Number(), "y": Number(), "weight": Number(least=1)}, "x y")),
    },
    "knotVector controlPoints",
)
ON_EDGE = section(
    {
        "vehicleTypeId": Text(),
        "vehicleOrientation": Number(),
        "orientationType": Text(("GLOBAL", "TANGENTIAL")),
        "rotationAllowed": Flag(),
        "rotationAtStartNodeAllowed": _TURNS,
        "rotationAtEndNodeAllowed": _TURNS,
        "maxSpeed": Number(),
        "maxRotationSpeed": Number(),
        "minHeight": Number(),
        "maxHeight": Number(),
        "loadRestriction": section(
            {"unloaded": Flag(), "loaded": Flag(), "loadSetNames": Each(Text())}, "unloaded loaded"
        ),
        "actions": Each(ACTION),
        "trajectory": TRAJECTORY,
        "physicalLineGuidedProperty": section({"direction": Text(), "length": Number(least=0)}),
        "reentryAllowed": Flag(),
    },
    "vehicleTypeId rotationAllowed",
)
ON_NODE = section({"vehicleTypeId": Text(), "theta": Number(), "actions": Each(ACTION)}, "vehicleTypeId")
NODE = section(
    {
        "nodeId": Text(),
        "nodeName": Text(),
        "nodeDescription": Text(),
        "mapId": Text(),
        "nodePosition": section({"x": Number(), "y": Number()}, "x y", "x y"),
        "vehicleTypeNodeProperties": Each(ON_NODE),
    },
    "nodeId nodePosition vehicleTypeNodeProperties",
    "nodeId nodePosition",
)
EDGE = section(
    {
        "edgeId": Text(),
        "edgeName": Text(),
        "edgeDescription": Text(),
        "startNodeId": Text(),
        "endNodeId": Text(),
        "vehicleTypeEdgeProperties": Each(ON_EDGE),
    },
    "edgeId startNodeId endNodeId vehicleTypeEdgeProperties",
    "startNodeId endNodeId",
)
STATION = section(
    {
        "stationId": Text(),
        "interactionNodeIds": Each(Text()),
        "stationName": Text(),
        "stationType": Text(),
        "stationDescription": Text(),
        "stationHeight": Number(least=0),
        "stationPosition": section({"x": Number(), "y": Number(), "theta": Number()}, "x y"),
    },
    "stationId interactionNodeIds",
    "stationId",
)
LAYOUT = section(
    {
        "layoutId": Text(),
        "layoutName": Text(),
        "layoutVersion": Text(),
        "layoutLevelId": Text(),
        "layoutDescription": Text(),
        "nodes": Each(NODE),
        "edges": Each(EDGE),
        "stations": Each(STATION),
    },
    "layoutId layoutVersion nodes edges stations",
    "nodes",
)
META = section(
    {"projectIdentification": Text(), "creator": Text(), "exportTimestamp": Text(), "lifVersion": Text()},
    "projectIdentification creator exportTimestamp lifVersion",
)
FILE = section({"metaInformation": META, "layouts": Each(LAYOUT)}, "metaInformation layouts", "layouts")

RELEASED = ("2.0", "2.0.0")
_RENAMED = {
    "maximumSpeed": "maxSpeed",
    "maximumRotationSpeed": "maxRotationSpeed",
    "minimumLoadHandlingDeviceHeight": "minHeight",
    "maximumMobileRobotHeight": "maxHeight",
    "actionDescriptor": "actionDescription",
    "nodeDescriptor": "nodeDescription",
    "edgeDescriptor": "edgeDescription",
    "stationDescriptor": "stationDescription",
    "layoutDescriptor": "layoutDescription",
    "lifId": "projectIdentification",
}
_SAID = {"mobileRobotTypes", "mobileRobotTypeId", "mobileRobotOrientations", "requiredActions", "feasibleActions"}
"""Keys of properties for which version 1 has another form."""
TOP = ("metaInformation", "origins", "layouts")


def _load(item: Item) -> Item:
    made: Item = item.get("loadRestriction", {})
    return made


def _backwards(item: Item) -> bool:
    angle = float(item.get("vehicleOrientation", 0.0))
    angle = math.radians(angle) if _is_degrees(angle) else angle
    tangential = item.get("orientationType", "TANGENTIAL") == "TANGENTIAL"
    return tangential and abs(abs(angle) - math.pi) < _BACKWARDS


def _is_degrees(angle: float) -> bool:
    return abs(angle) > 2 * math.pi


_EDGES: tuple[tuple[str, Callable[[Item], Any], str], ...] = (
    ("direction of driving", _backwards, "backwards, which is as fast here as forwards"),
    (
        "vehicle angle",
        lambda item: item.get("orientationType") == "GLOBAL" and "vehicleOrientation" in item,
        "robots may drive in any direction here",
    ),
    (
        "rotation",
        lambda item: any(item.get(f"rotationAt{end}NodeAllowed", "BOTH") != "BOTH" for end in ("Start", "End")),
        "not free at the nodes of the edge; robots may turn at all nodes here",
    ),
    ("rotation speed", lambda item: "maxRotationSpeed" in item, "turning takes traffic.turn_time, the same everywhere"),
    ("height", lambda item: "minHeight" in item or "maxHeight" in item, "robots have no height here"),
    (
        "load restriction",
        lambda item: not _load(item).get("loaded", True),
        "only for robots without a load; open to all robots here",
    ),
    (
        "load restriction",
        lambda item: not _load(item).get("unloaded", True),
        "only for robots with a load; open to all robots here",
    ),
    ("load set", lambda item: _load(item).get("loadSetNames"), "only for some loads; all loads are the same here"),
    ("edge action", lambda item: item.get("actions"), "robots only drive on edges"),
    ("re-entry", lambda item: item.get("reentryAllowed") is False, "robots do not leave edges here"),
)


def note_edges(plant: Plant, edges: Sequence[tuple[Link, Item]]) -> None:
    """Note properties of edges that a model cannot hold; `edges`: links, each with its properties in the file."""
    for kind, has, why in _EDGES:
        plant.note_parts("left out", kind, [link for link, item in edges if has(item)], why)
    odd = [link for link, item in edges if _is_degrees(item.get("vehicleOrientation", 0.0))]
    plant.note_parts("doubtful", "vehicle angle", odd, _DEGREES)


def note_nodes(plant: Plant, nodes: Sequence[tuple[str, Item]], stations: Sequence[Item]) -> None:
    """Note properties of nodes and stations that a model cannot hold; `nodes`: names, each with its properties."""
    turned = [plant.points[name] for name, item in nodes if "theta" in item]
    plant.note_parts("left out", "vehicle angle", turned, "robots may stand at a node in any direction")
    odd = [plant.points[name] for name, item in nodes if _is_degrees(item.get("theta", 0.0))]
    plant.note_parts("doubtful", "vehicle angle", odd, _DEGREES)
    high = [station for station in stations if station.get("stationHeight")]
    names, positions = [station["stationId"] for station in high], [station[POSITION] for station in high]
    plant.note("left out", "station height", names, "handling takes the same time at every height", positions)


def is_2(data: Item, content: bytes) -> bool:
    """Return whether a file has the keys of version 2, whatever version it states."""
    return "origins" in data or b'"mobileRobotType' in content


def layouts_of(data: Item) -> Iterator[tuple[str, str, Item]]:
    """Yield the layouts of a file: the position, the origin and the content of each."""
    for rank, layout in enumerate(_items(data, "layouts")):
        yield f"layouts[{rank}]", "", _layout(layout)
    for number, origin in enumerate(_items(data, "origins")):
        for rank, layout in enumerate(_items(origin, "layouts")):
            yield f"origins[{number}].layouts[{rank}]", str(origin.get("originId", number)), _layout(layout)


def _layout(layout: Item) -> Item:
    nodes = [_with(node, "Node") for node in _items(layout, "nodes")]
    edges = [_with(edge, "Edge") for edge in _items(layout, "edges")]
    stations = {"stations": [*map(renamed, _items(layout, "stations"))]} if "stations" in layout else {}
    return {**renamed(layout), "nodes": nodes, "edges": edges, **stations}


def renamed(item: Item) -> Item:
    """Return an object of version 2 with the keys of version 1."""
    return {_RENAMED.get(key, key): value for key, value in item.items()}


def _with(item: Item, what: str) -> Item:
    key = f"Type{what}Properties"
    entries = _items(item, f"mobileRobot{key}") or _items(item, f"vehicle{key}")
    others = {name: value for name, value in renamed(item).items() if name != f"mobileRobot{key}"}
    return {**others, f"vehicle{key}": [made for entry in entries for made in _properties(entry)]}


def _properties(item: Item) -> Iterator[Item]:
    """Yield the properties once for each vehicle type, in the form of version 1."""
    types = [
        f"{kind.get('manufacturer', '')} {kind.get('seriesName', '')}".strip()
        for kind in _items(item, "mobileRobotTypes")
    ]
    actions = [
        renamed(action) for key in ("actions", "requiredActions", "feasibleActions") for action in _items(item, key)
    ]
    orientations = item.get("mobileRobotOrientations")
    one_way = orientations[0] if isinstance(orientations, list) and len(orientations) == 1 else None
    by_name: list[Any] = [item.get("mobileRobotTypeId", item.get("vehicleTypeId"))]
    others = {key: value for key, value in renamed(item).items() if key not in _SAID}
    for name in types or by_name:
        made = {**others, "actions": [{**action, "blockingType": "HARD"} for action in actions]}
        yield {
            key: value
            for key, value in {**made, "vehicleTypeId": name, "vehicleOrientation": one_way}.items()
            if value is not None
        }


def _items(item: Item, key: str) -> list[Item]:
    """Return the objects in the list at a key; empty if there is no list."""
    value = item.get(key)
    return [entry for entry in value if isinstance(entry, dict)] if isinstance(value, list) else []
