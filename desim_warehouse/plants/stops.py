"""What robots do where: the operations of a plant's locations, sorted into loading, unloading, charging, parking.

Every plant has words of its own for its operations, so what they look like is only a guess: the mapping given comes
first. Points out of reach are named.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, get_args

from desim_warehouse.errors import ModelError, got, nearest, spoken
from desim_warehouse.plants.plant import Role

if TYPE_CHECKING:
    from collections.abc import Container, Mapping

    from desim_warehouse.plants.plant import Plant

_GUESSES: tuple[tuple[Role, str], ...] = (
    ("unload", r"unload|discharg|deliver|deposit|\bdrop|\bput\b"),
    ("load", r"load|\bpick|\bcatch|\bfetch|\bcollect|\bget\b|\btake\b"),
    ("charge", r"charg"),
    ("park", r"\bpark"),
)
NONE = "none"


@dataclass
class Stops:
    """Points in reach by what robots do there, each with the names of its locations."""

    load: dict[str, list[str]] = field(default_factory=dict)
    unload: dict[str, list[str]] = field(default_factory=dict)
    charge: dict[str, list[str]] = field(default_factory=dict)
    park: dict[str, list[str]] = field(default_factory=dict)
    other: dict[str, list[str]] = field(default_factory=dict)


def stops_of(plant: Plant, reachable: Container[str], operations: Mapping[str, str]) -> Stops:
    """Sort the points of a plant's locations; what cannot be used is noted there.

    Args:
        plant: the plant.
        reachable: the points that robots can get to and away from.
        operations: what robots do at locations that allow an operation: load, unload, charge, park or none.

    Raises:
        ModelError: where the mapping names no operation of the plant, or nothing that robots do.
    """
    roles = _roles(plant, operations)
    found = Stops()
    cut_off, idle = [], []
    for location in plant.locations:
        points = {point: allowed for point, allowed in location.operations.items() if point in reachable}
        if not points:
            cut_off.append(location.name)
        for point, allowed in points.items():
            here = {roles[name] for name in allowed} - {NONE}
            for role in sorted(here) or ["other"]:
                getattr(found, role).setdefault(point, []).append(location.name)
            if not here:
                idle.append(location.name)
    plant.note("unreachable", "location", cut_off, "robots cannot get to its points and back")
    parking = [point.name for point in plant.points.values() if point.parking]
    for name in parking:
        if name in reachable:
            found.park.setdefault(name, [])
    lost = [name for name in parking if name not in reachable]
    plant.note("unreachable", "parking point", lost, "robots cannot get there and back")
    _fall_back(plant, found, roles)
    if idle and not any(remark.kind in {"layout.storage", "tasks.unload_at"} for remark in plant.remarks):
        why = f"no operation there is loading, unloading, charging or parking by its name ({_named(roles, NONE)})"
        plant.note("left out", "location", list(dict.fromkeys(idle)), why)
    return found


def _roles(plant: Plant, operations: Mapping[str, str]) -> dict[str, str]:
    """What robots do by operation: as given, else as its name sounds."""
    names = dict.fromkeys(
        name for location in plant.locations for allowed in location.operations.values() for name in allowed
    )
    given = {}
    for name, role in operations.items():
        known = [one for one in names if one.casefold() == name.casefold()]
        if not known:
            near = nearest(name, names)
            hint = f"; did you mean '{near}'?" if near else ""
            expected = f"one of {spoken(map(repr, names), 'or')}" if names else "none, as the plant has no operations"
            raise ModelError([f"operation {name!r}: not an operation of {plant.source}, expected {expected}{hint}"])
        if role not in {*get_args(Role), NONE}:
            expected = spoken([*get_args(Role), NONE], "or")
            raise ModelError([f"operation {name!r}: not what robots do (got {got(role)}), expected {expected}"])
        given.update(dict.fromkeys(known, role))
    return {name: given.get(name) or _guess(name) for name in names}


def _guess(name: str) -> str:
    sound = name.casefold().replace("_", " ")
    return next((role for role, pattern in _GUESSES if re.search(pattern, sound)), NONE)


def _named(roles: Mapping[str, str], role: str) -> str:
    return ", ".join(name for name, its in roles.items() if its == role) or "none"


def _fall_back(plant: Plant, found: Stops, roles: Mapping[str, str]) -> None:
    """Where no operation says where goods are loaded, or unloaded, it is wherever robots do anything but charge."""
    work = {**found.other, **found.unload, **found.load}
    for role, key, cure in (("load", "layout.storage", "loading"), ("unload", "tasks.unload_at", "unloading")):
        if not getattr(found, role) and work:
            setattr(found, role, work)
            why = (
                f"no operation is {cure} by its name ({', '.join(roles)}), so all but chargers and parking are; map one"
            )
            plant.assume(key, why, list(dict.fromkeys(name for names in work.values() for name in names)))
