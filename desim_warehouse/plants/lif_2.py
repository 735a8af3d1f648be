"""Drafts of LIF 2 translated to version 1: origins that hold layouts, and robot types by maker and series.

Source: the drafts of LIF 2.0 that the VDMA has published; what is new there and does not bear on a model is left out.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

Item = dict[str, Any]


def is_draft(data: Item, content: bytes) -> bool:
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
    return {**layout, "nodes": nodes, "edges": edges}


def _with(item: Item, what: str) -> Item:
    key = f"Type{what}Properties"
    given = _items(item, f"mobileRobot{key}") or _items(item, f"vehicle{key}")
    return {**item, f"vehicle{key}": [made for one in given for made in _properties(one)]}


def _properties(item: Item) -> Iterator[Item]:
    """What version 1 says once for each type."""
    types = [
        f"{one.get('manufacturer', '')} {one.get('seriesName', '')}".strip() for one in _items(item, "mobileRobotTypes")
    ]
    actions = [one for key in ("actions", "requiredActions", "feasibleActions") for one in _items(item, key)]
    orientations = item.get("mobileRobotOrientations")
    one_way = orientations[0] if isinstance(orientations, list) and len(orientations) == 1 else None
    by_name: list[Any] = [item.get("mobileRobotTypeId", item.get("vehicleTypeId"))]
    for name in types or by_name:
        made = {**item, "actions": [{**one, "blockingType": "HARD"} for one in actions]}
        yield {
            key: value
            for key, value in {**made, "vehicleTypeId": name, "vehicleOrientation": one_way}.items()
            if value is not None
        }


def _items(item: Item, key: str) -> list[Item]:
    """The objects of a list."""
    value = item.get(key)
    return [one for one in value if isinstance(one, dict)] if isinstance(value, list) else []
