"""Plant models of openTCS for `desim import`: XML, versions 0.0.2 to 7.0.0, in mm and mm/s, y upwards.

- A path with a reverse velocity is used in both directions. If the reverse velocity is less than a tenth of the speed,
  the path is reported, as it is usually meant to be one-way. A velocity of 0 forbids a direction, and locked paths are
  not used at all.
- Blocks are zones for one robot or one direction at a time. A block for one vehicle includes the points at the ends of
  its paths.
- In a transport order, loading and then unloading make a task, by way of the stops in between, with the deadline of the
  order.

Source: the XML schemas of openTCS and its user's guide.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from desim_warehouse.errors import got
from desim_warehouse.plants.plant import Area, Link, Location, Plant, Rule, Vehicle, Waypoint, What
from desim_warehouse.plants.xml import Element, read_xml

EXPECTED = "a plant model of openTCS (XML)"
_MM = 0.001
_NEWEST = 7
_POINT = "xPosition yPosition zPosition positionX positionY positionZ"
_BOX = "height length width referenceOffsetX referenceOffsetY"
_LOOK = "xPosition yPosition xLabelOffset yLabelOffset labelOffsetX labelOffsetY layerId color locationRepresentation"
_ATTRIBUTES = {
    "point": f"name type vehicleOrientationAngle {_POINT}",
    "path": "name sourcePoint destinationPoint length routingCost maxVelocity maxReverseVelocity locked",
    "location": f"name type locked {_POINT}",
    "vehicle": "name type length maxVelocity maxReverseVelocity envelopeKey energyLevelCritical energyLevelGood "
    "energyLevelSufficientlyRecharged energyLevelFullyRecharged",
    "block": "name type",
    "link": "point",
    **dict.fromkeys(("boundingBox", "maxVehicleBoundingBox"), _BOX),
    **dict.fromkeys(("pointLayout", "locationLayout", "locationTypeLayout", "vehicleLayout", "blockLayout"), _LOOK),
    "pathLayout": "connectionType layerId",
    "peripheralOperation": "name locationName executionTrigger completionRequired",
    "property": "name value",
    "vehicleEnvelope": "key",
    **dict.fromkeys(("vertex", "controlPoint"), "x y"),
    "visualLayout": "name scaleX scaleY",
    "modelLayoutElement": "layer visualizedObjectName",
    "layer": "id ordinal visible name groupId",
    "layerGroup": "id name visible",
    **dict.fromkeys(
        ("allowedOperation", "allowedPeripheralOperation", "outgoingPath", "member", "group", "locationType"), "name"
    ),
}
_KNOWN = {tag: frozenset(names.split()) for tag, names in _ATTRIBUTES.items()}
"""The attributes of elements in any version of the format."""
_START = ("loopback:initialPosition", "tcs:initialPosition")
RULES: dict[str, Rule] = {"SINGLE_VEHICLE_ONLY": "one-robot", "SAME_DIRECTION_ONLY": "one-direction"}
"""Rules of the types of blocks."""

_IN_ORDER = (
    ("energyLevelCritical", "energyLevelGood"),
    ("energyLevelSufficientlyRecharged", "energyLevelFullyRecharged"),
)
"""Pairs of energy levels of a vehicle, the first of which should be below the second."""


def read(path: Path, content: bytes) -> Plant:
    """Read a plant model.

    Raises:
        ModelError: a file that cannot be read, with the line.
    """
    root = read_xml(path, content, EXPECTED)
    if root.tag != "model":
        text = "not a plant model of openTCS, whose root element is model, and of no other program that is known"
        root.refuse(f"{text}; desim import --help names the formats that can be read")
    version = root.text("version")
    if not version.split(".")[0].isdecimal() or int(version.split(".")[0]) > _NEWEST:
        root.refuse(f"version {got(version)} is not known, expected 0.0.2 to {_NEWEST}.x")
    plant = Plant(root.attributes.get("name", path.stem), f"{path.name} (openTCS plant model, version {version})")
    _points(root, plant)
    _paths(root, plant)
    types = {item.text("name"): item for item in root.all("locationType")}
    _locations(root, plant, types)
    plant.vehicles = [_vehicle(item, plant) for item in root.all("vehicle")]
    _energy(root, plant)
    _blocks(root, plant)
    _losses(root, plant)
    _unknown(root, plant)
    return plant


def _points(root: Element, plant: Plant) -> None:
    for item in root.all("point"):
        name = item.text("name")
        if name in plant.points:
            item.refuse("a point of this name stands before, expected every name once")
        x, y = item.number("positionX", "xPosition", default=0.0), item.number("positionY", "yPosition", default=0.0)
        parking = item.attributes.get("type") == "PARK_POSITION"
        plant.points[name] = Waypoint(name, x * _MM, -y * _MM if y else 0.0, parking, item.position)


def _paths(root: Element, plant: Plant) -> None:
    locked: list[Element] = []
    closed: list[Element] = []
    names: set[str] = set()
    for item in root.all("path"):
        name, ends = item.text("name"), (item.text("sourcePoint"), item.text("destinationPoint"))
        if name in names:
            item.refuse("a path of this name stands before, expected every name once")
        names.add(name)
        for end in ends:
            if end not in plant.points:
                item.refuse(f"leads to no point of the plant (got {got(end)}), expected the name of a point")
        length = item.number("length", default=0.0) * _MM
        speeds = _speed(item, "maxVelocity"), _speed(item, "maxReverseVelocity")
        if item.attributes.get("locked") == "true":
            locked.append(item)
        elif not any(speeds):
            closed.append(item)
        else:
            plant.links.append(Link(name, *ends, length if length > 0 else None, *speeds, position=item.position))
    _note(plant, "left out", "path", locked, "locked")
    _note(plant, "left out", "path", closed, "closed in both directions by a velocity of 0")


def _note(plant: Plant, what: What, kind: str, items: Sequence[Element], why: str) -> None:
    plant.note(what, kind, [item.text("name") for item in items], why, [item.position for item in items])


def _speed(item: Element, name: str) -> float:
    speed = item.number(name, default=0.0) * _MM
    if speed < 0:
        item.refuse(f"{name}: below 0 (got {got(item.attributes[name])}), expected 0 or more")
    return speed


def _locations(root: Element, plant: Plant, types: Mapping[str, Element]) -> None:
    locked: list[Element] = []
    peripheral: list[Element] = []
    for item in root.all("location"):
        name, kind = item.text("name"), item.text("type")
        if kind not in types:
            item.refuse(f"of a type that the plant does not have (got {got(kind)}), expected the name of one")
        usual = _operations(types[kind])
        operations = {}
        for link in item.all("link"):
            point = link.text("point")
            if point not in plant.points:
                item.refuse(f"linked to no point of the plant (got {got(point)}), expected the name of a point")
            operations[point] = _operations(link) or usual
        if item.attributes.get("locked") == "true":
            locked.append(item)
        elif not operations and not usual:
            peripheral.append(item)
        else:
            plant.locations.append(Location(name, operations, item.position))
    _note(plant, "left out", "location", locked, "locked")
    _note(plant, "left out", "location", peripheral, "a peripheral device, at which no vehicle stops")


def _operations(item: Element) -> tuple[str, ...]:
    return tuple(operation.text("name") for operation in item.all("allowedOperation"))


def _vehicle(item: Element, plant: Plant) -> Vehicle:
    boxes = [item, *item.all("boundingBox")]
    sizes = [box.number(side, default=0.0) * _MM for box in boxes for side in ("length", "width")]
    properties = {entry.attributes.get("name"): entry.attributes.get("value") for entry in item.all("property")}
    start = next((properties[name] for name in _START if properties.get(name) in plant.points), None)
    return Vehicle(
        item.text("name"),
        max(sizes) or None,
        item.number("maxVelocity", default=0.0) * _MM or None,
        start,
        item.number("energyLevelCritical", default=0.0) / 100 or None,
        item.position,
    )


def _energy(root: Element, plant: Plant) -> None:
    for lower, upper in _IN_ORDER:
        wrong = [
            item
            for item in root.all("vehicle")
            if {lower, upper} <= item.attributes.keys() and item.number(lower) > item.number(upper)
        ]
        _note(plant, "doubtful", "vehicle", wrong, f"{lower} is above {upper}")


def _blocks(root: Element, plant: Plant) -> None:
    empty: list[Element] = []
    for item in root.all("block"):
        members = tuple(member.text("name") for member in item.all("member"))
        rule = item.attributes.get("type", "SINGLE_VEHICLE_ONLY")
        if rule not in RULES:
            item.refuse(f"type: not known (got {got(rule)}), expected {' or '.join(RULES)}")
        if members:
            plant.areas.append(Area(item.text("name"), members, RULES[rule], item.position))
        else:
            empty.append(item)
    _note(plant, "left out", "block", empty, "no members")


def _unknown(item: Element, plant: Plant) -> None:
    """Record the elements, and attributes of elements, that no version of the format has."""
    for child in item.children:
        if child.tag not in _KNOWN:
            plant.see_keys([child.tag], (), child.position)
            continue
        plant.see_keys(child.attributes, _KNOWN[child.tag], child.position, child.tag)
        _unknown(child, plant)


def _losses(root: Element, plant: Plant) -> None:
    """Note the parts that models cannot represent: peripheral operations, vehicle angles, heights."""
    doors = [item for item in root.all("path") if any(item.all("peripheralOperation"))]
    why = "a device such as a door on a path, which takes no time here"
    _note(plant, "left out", "peripheral operation", doors, why)
    angle, height = "vehicleOrientationAngle", ("positionZ", "zPosition")
    turned = [item for item in root.all("point") if item.attributes.get(angle, "NaN") not in {"NaN", ""}]
    _note(plant, "left out", "vehicle angle", turned, "robots may stand at a point in any direction")
    raised = [item for item in root.all("point") if item.number(*height, default=0.0)]
    _note(plant, "left out", "height", raised, "all points are on one floor")
