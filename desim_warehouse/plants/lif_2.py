"""LIF 2.0 and its drafts translated to version 1: origins that hold layouts, robot types by maker and series.

Source: VDMA, Layout Interchange Format (LIF), version 2.0.0, 2026. What is new there and has no key in version 1 stays
as it is, and is told as a key that is left out.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

Item = dict[str, Any]
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
"""Keys of properties that version 1 says otherwise."""


TOP = ("metaInformation", "origins", "layouts")


def is_2(data: Item, content: bytes) -> bool:
    """Whether a file has the keys of version 2, whatever version it says it is."""
    return "origins" in data or b'"mobileRobotType' in content


def layouts_of(data: Item) -> Iterator[tuple[str, str, Item]]:
    """The layouts of a file: the position, the origin and the content of each."""
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
    """An object with the keys of version 1, where it has them under other names."""
    return {_RENAMED.get(key, key): value for key, value in item.items()}


def _with(item: Item, what: str) -> Item:
    key = f"Type{what}Properties"
    given = _items(item, f"mobileRobot{key}") or _items(item, f"vehicle{key}")
    others = {name: value for name, value in renamed(item).items() if name != f"mobileRobot{key}"}
    return {**others, f"vehicle{key}": [made for one in given for made in _properties(one)]}


def _properties(item: Item) -> Iterator[Item]:
    """What version 1 says once for each type."""
    types = [
        f"{one.get('manufacturer', '')} {one.get('seriesName', '')}".strip() for one in _items(item, "mobileRobotTypes")
    ]
    actions = [renamed(one) for key in ("actions", "requiredActions", "feasibleActions") for one in _items(item, key)]
    orientations = item.get("mobileRobotOrientations")
    one_way = orientations[0] if isinstance(orientations, list) and len(orientations) == 1 else None
    by_name: list[Any] = [item.get("mobileRobotTypeId", item.get("vehicleTypeId"))]
    others = {key: value for key, value in renamed(item).items() if key not in _SAID}
    for name in types or by_name:
        made = {**others, "actions": [{**one, "blockingType": "HARD"} for one in actions]}
        yield {
            key: value
            for key, value in {**made, "vehicleTypeId": name, "vehicleOrientation": one_way}.items()
            if value is not None
        }


def _items(item: Item, key: str) -> list[Item]:
    """The objects of a list."""
    value = item.get(key)
    return [one for one in value if isinstance(one, dict)] if isinstance(value, list) else []
