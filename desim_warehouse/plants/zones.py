"""Areas of a plant that robots use one at a time, or in one direction at a time, as zones of a model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from desim_warehouse.layout.zones import examine
from desim_warehouse.model import load

if TYPE_CHECKING:
    from collections.abc import Mapping

    from desim_warehouse.plants.plant import Area, Plant


def zones_of(plant: Plant, content: Mapping[str, Any]) -> dict[str, Any]:
    """The zones section of a model of a plant; areas that cannot be zones there are noted, with the reason."""
    if not plant.areas:
        return {}
    edges = {frozenset((edge["from"], edge["to"])) for edge in content["layout"]["edges"]}
    ends = {link.name: [link.source, link.target] for link in plant.links}
    zones: dict[str, Any] = {}
    empty: list[Area] = []
    ends_too: list[Area] = []
    lost = []
    for area in plant.areas:
        members = _members(area, plant, ends, edges)
        lost += [f"{name} of {area.name}" for name in area.members if name not in members]
        if members:
            zones[area.name] = {"members": list(members.values()), "rule": area.rule}
            ends_too += [area] if area.rule == "one-robot" and not {*ends}.isdisjoint(members) else []
        else:
            empty.append(area)
    positions = {area.name: area.position for area in plant.areas}
    node = next(iter(content["layout"]["nodes"]))
    any_work = {"goods": [0], "unload_at": [node], "load_time": 0, "unload_time": 0}  # those of orders are in a file
    model = load({**content, "tasks": any_work, "traffic": {"zones": zones}}) if zones else None
    if model is not None:
        for finding in examine(model.floor, model.traffic.zones, model.fleet.contact, "auto"):
            name = finding.place.removeprefix("traffic.zones.")
            if finding.level == "error" and zones.pop(name, None):
                plant.note("left out", "block", [name], finding.text, [positions[name]])
    plant.note_parts("left out", "block", empty, "none of its members is a point or path of the model")
    plant.note("left out", "member", lost, "of a block: no point or path of the model")
    kept = [area for area in ends_too if area.name in zones]
    plant.note_parts("changed", "block", kept, "the points at the ends of its paths belong to it, too")
    return zones


def _members(area: Area, plant: Plant, ends: Mapping[str, list[str]], edges: set[frozenset[str]]) -> dict[str, Any]:
    """Members by name as a model has them: nodes by name, edges as pairs."""
    found: dict[str, Any] = {}
    for name in area.members:
        if name in plant.points:
            found[name] = name
        elif name in ends and frozenset(ends[name]) in edges:
            found[name] = ends[name]
    return found
