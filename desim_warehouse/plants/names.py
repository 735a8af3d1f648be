"""Names that every file can hold: one line of printable characters, without blanks around them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from desim_warehouse.plants.plant import Location, claim
from desim_warehouse.plants.write import one_line

if TYPE_CHECKING:
    from collections.abc import Iterable

    from desim_warehouse.plants.plant import Plant


def plain_names(plant: Plant) -> None:
    """Change what a plant and its parts are called where it is not plain; what is changed is noted there."""
    points, positions = _plain(plant.points), _plain(location.name for location in plant.locations)
    links, areas = _plain(link.name for link in plant.links), _plain(area.name for area in plant.areas)
    plant.name = _trimmed(plant.name) or "layout"
    plant.points = {points[name]: replace(point, name=points[name]) for name, point in plant.points.items()}
    plant.links = [
        replace(link, name=links[link.name], source=points[link.source], target=points[link.target])
        for link in plant.links
    ]
    plant.locations = [
        Location(positions[one.name], {points[name]: allowed for name, allowed in one.operations.items()}, one.position)
        for one in plant.locations
    ]
    members = {**links, **points}
    plant.areas = [
        replace(area, name=areas[area.name], members=tuple(members[name] for name in area.members))
        for area in plant.areas
    ]
    vehicles = _plain(vehicle.name for vehicle in plant.vehicles)
    plant.vehicles = [replace(one, name=vehicles[one.name]) for one in plant.vehicles]
    changed = [
        f"{new} from {old!r}" for names in (points, positions, areas) for old, new in names.items() if old != new
    ]
    plant.note("changed", "name", changed, "with characters that not every file can hold, or blanks around it")


def _plain(names: Iterable[str]) -> dict[str, str]:
    """The plain form of every name, each of them once."""
    plain = {name: _trimmed(name) for name in names}
    taken = {name for name, trimmed in plain.items() if trimmed == name}
    return {name: name if trimmed == name else claim(trimmed or "unnamed", taken) for name, trimmed in plain.items()}


def _trimmed(name: str) -> str:
    return " ".join(one_line(name).split())
