"""Export of a plant to a plant model of openTCS, version 7.0.0: whole mm and mm/s, y upwards.

A two-way lane is one path with a reverse velocity, so that it is one resource.

Source: the XML schema of openTCS 7.0.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from xml.sax.saxutils import quoteattr

from desim_warehouse.plants.checks import distance, length_of
from desim_warehouse.plants.lanes import ALIKE
from desim_warehouse.plants.opentcs import RULES
from desim_warehouse.plants.plant import Link, Plant, Vehicle, claim

_MM = 1000
_EXACT = 1e-6
_ROUNDED = 0.001  # metres: difference of lengths from rounding to mm
_TYPES = {"load": "goods", "unload": "station", "charge": "charger"}
_SIGNS = {"load": "LOAD_TRANSFER_GENERIC", "unload": "WORKING_GENERIC", "charge": "RECHARGE_GENERIC"}
_TYPE_OF_RULE = {rule: kind for kind, rule in RULES.items()}
_BOX = {"length": 1000, "width": 1000, "height": 1000, "referenceOffsetX": 0, "referenceOffsetY": 0}
_LAYER = {"labelOffsetX": -10, "labelOffsetY": -20, "layerId": 0}


def opentcs(plant: Plant) -> str:
    """Return the text of a plant model; losses are noted in the plant."""
    names = _Names(plant)
    lines = [
        '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>',
        *_tag("model", version="7.0.0", name=plant.name),
    ]
    fastest = max((vehicle.speed or 0.0 for vehicle in plant.vehicles), default=0.0) or 1.0
    lines += _points(plant)
    lines += _paths(plant, names, fastest)
    lines += [line for vehicle in plant.vehicles for line in _vehicle(vehicle, names.own("vehicle", vehicle.name))]
    lines += _locations(plant, names)
    for area in plant.areas:
        lines += _tag("block", 1, name=names.own("block", area.name), type=_TYPE_OF_RULE[area.rule])
        lines += [_empty("member", 2, name=names.links.get(member, member)) for member in area.members]
        lines.append("    </block>")
    lines += [
        *_tag("visualLayout", 1, name="VLayout", scaleX="50.0", scaleY="50.0"),
        _empty("layer", 2, id=0, ordinal=0, visible="true", name="Default layer", groupId=0),
        _empty("layerGroup", 2, id=0, name="Default layer group", visible="true"),
        "    </visualLayout>",
        "</model>",
        "",
    ]
    names.note()
    return "\n".join(lines)


class _Names:
    """Names that are unique in the whole plant model, as openTCS requires."""

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self.taken = set(plant.points)
        self.links: dict[str, str] = {}
        self.changed: list[str] = []
        for link in plant.links:
            self.links[link.name] = self.own("path", link.name)

    def own(self, kind: str, name: str) -> str:
        made = claim(name, self.taken)
        if made != name:
            self.changed.append(f"{kind} {name}")
        return made

    def note(self) -> None:
        self.plant.note("changed", "name", self.changed, "taken by another object of the plant, so a number is added")


def _points(plant: Plant) -> Iterable[str]:
    moved = []
    for point in plant.points.values():
        x, y = round(point.x * _MM), -round(point.y * _MM)
        if math.dist((x, -y), (point.x * _MM, point.y * _MM)) > _EXACT * _MM:
            moved.append(point.name)
        kind = "PARK_POSITION" if point.parking else "HALT_POSITION"
        yield from _tag("point", 1, name=point.name, positionX=x, positionY=y, positionZ=0, type=kind)
        yield _empty("maxVehicleBoundingBox", 2, **_BOX)
        yield _empty("pointLayout", 2, **_LAYER)
        yield "    </point>"
    plant.note("changed", "point", moved, "rounded to whole millimetres")


def _paths(plant: Plant, names: _Names, fastest: float) -> Iterable[str]:
    unlimited, rounded, beside = [], [], []
    for link in plant.links:
        length = length_of(plant, link)
        millimetres = max(round(length * _MM), 1)
        limits = [link.speed, link.speed_back]
        speeds = [speed if math.isfinite(speed) else fastest for speed in limits]
        velocities = [max(round(speed * _MM), 1) if speed else 0 for speed in speeds]
        if not all(map(math.isfinite, limits)):
            unlimited.append(link.name)
        off = [abs(velocity / _MM - speed) for velocity, speed in zip(velocities, speeds, strict=True)]
        if max(abs(millimetres / _MM - length), *off) > _EXACT:
            rounded.append(link.name)
        if link.side_by_side:
            beside.append(link)
        yield from _tag(
            "path",
            1,
            name=names.links[link.name],
            sourcePoint=link.source,
            destinationPoint=link.target,
            length=millimetres,
            maxVelocity=velocities[0],
            maxReverseVelocity=velocities[1],
            locked="false",
        )
        yield _empty("pathLayout", 2, connectionType="DIRECT", layerId=0)
        yield "    </path>"
    why = f"without a speed limit, so it has the speed of the fastest robot, {fastest:g} m/s"
    plant.note("changed", "path", unlimited, why)
    plant.note("changed", "path", rounded, "length or speed rounded to whole mm or mm/s")
    joined(plant, beside)


def joined(plant: Plant, beside: Iterable[Link], *, straight: bool = False) -> None:
    """Note lanes side by side of nearly equal length, which readers take for a two-way lane.

    `straight`: compare straight distances instead of lengths.
    """
    lengths = {
        (link.source, link.target): distance(plant, link.source, link.target) if straight else length_of(plant, link)
        for link in beside
    }
    alike = [
        f"{a}>{b}"
        for (a, b), length in lengths.items()
        if (b, a) in lengths and abs(length - lengths[b, a]) <= ALIKE * max(length, lengths[b, a]) + _ROUNDED
    ]
    plant.note("changed", "lane", alike, "beside one back that is as long, so read again they are one two-way lane")


def _vehicle(vehicle: Vehicle, name: str) -> Iterable[str]:
    size, velocity = round((vehicle.length or 1.0) * _MM), round((vehicle.speed or 1.0) * _MM)
    critical = min(round(100 * (vehicle.critical or 0.0)), 99)
    yield from _tag(
        "vehicle",
        1,
        name=name,
        energyLevelCritical=critical,
        energyLevelGood=max(critical, 90),
        energyLevelFullyRecharged=100,
        energyLevelSufficientlyRecharged=max(critical, 90),
        maxVelocity=velocity,
        maxReverseVelocity=velocity,
    )
    yield _empty("boundingBox", 2, **{**_BOX, "length": size, "width": size})
    yield "    </vehicle>"


def _locations(plant: Plant, names: _Names) -> Iterable[str]:
    kinds = {operation for location in plant.locations for ops in location.operations.values() for operation in ops}
    types = {operation: names.own("location type", _TYPES[operation]) for operation in _TYPES if operation in kinds}
    for operation, name in types.items():
        yield from _tag("locationType", 1, name=name)
        yield _empty("allowedOperation", 2, name=operation)
        yield _empty("locationTypeLayout", 2, locationRepresentation=_SIGNS[operation])
        yield "    </locationType>"
    for location in plant.locations:
        first = plant.points[next(iter(location.operations))]
        [operation] = {operation for allowed in location.operations.values() for operation in allowed}
        yield from _tag(
            "location",
            1,
            name=names.own("location", location.name),
            positionX=round(first.x * _MM),
            positionY=-round(first.y * _MM),
            positionZ=0,
            type=types[operation],
            locked="false",
        )
        yield from (_empty("link", 2, point=point) for point in location.operations)
        yield _empty("locationLayout", 2, **_LAYER, locationRepresentation="DEFAULT")
        yield "    </location>"


def _tag(tag: str, depth: int = 0, **attributes: object) -> Iterable[str]:
    yield _empty(tag, depth, **attributes)[:-2] + ">"


def _empty(tag: str, depth: int, **attributes: object) -> str:
    text = "".join(f" {name}={quoteattr(str(value))}" for name, value in attributes.items())
    return f"{'    ' * depth}<{tag}{text}/>"
