"""What LIF says of edges, nodes and stations that models do not hold."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from desim_warehouse.plants.keyed import POSITION

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from desim_warehouse.plants.plant import Link, Plant

Item = dict[str, Any]
_BACKWARDS = 0.1  # rad from pi
_DEGREES = "beyond a full turn in rad; probably in degrees"


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
    """Note what is said of edges; each with what the file says of it."""
    for kind, has, why in _EDGES:
        plant.note_parts("left out", kind, [link for link, item in edges if has(item)], why)
    odd = [link for link, item in edges if _is_degrees(item.get("vehicleOrientation", 0.0))]
    plant.note_parts("doubtful", "vehicle angle", odd, _DEGREES)


def note_nodes(plant: Plant, nodes: Sequence[tuple[str, Item]], stations: Sequence[Item]) -> None:
    """Note what is said of nodes, each with what the file says of it, and of stations."""
    turned = [plant.points[name] for name, item in nodes if "theta" in item]
    plant.note_parts("left out", "vehicle angle", turned, "robots may stand at a node in any direction")
    odd = [plant.points[name] for name, item in nodes if _is_degrees(item.get("theta", 0.0))]
    plant.note_parts("doubtful", "vehicle angle", odd, _DEGREES)
    high = [one for one in stations if one.get("stationHeight")]
    names, positions = [one["stationId"] for one in high], [one[POSITION] for one in high]
    plant.note("left out", "station height", names, "handling takes the same time at every height", positions)
