"""Operations of a plant's locations, sorted into loading, unloading, charging and parking.

Every plant has its own words for operations, so their meaning can only be guessed from their names: a mapping by the
user has precedence. Points out of reach are noted.

For `desim import`; its `--operation` passes the mapping.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, get_args

from desim_warehouse.errors import ModelError, did_you_mean, got, spoken
from desim_warehouse.plants.plant import Plant, Role, Transport

_GUESSES: tuple[tuple[Role, str], ...] = (
    ("unload", r"unload|discharg|deliver|deposit|\bdrop|\bput\b"),
    ("load", r"load|\bpick|\bcatch|\bfetch|\bcollect|\bget\b|\btake\b"),
    ("charge", r"charg"),
    ("park", r"\bpark"),
)
NONE = "none"
VISIT = "visit"
"""The operation of a stop on the way, where a robot does nothing."""


class PlantTask(NamedTuple):
    """A task that a plant lists: a load to be brought from one point to another, via other points in order."""

    source: str
    target: str
    release: float
    due: float | None
    via: tuple[str, ...] = ()
    name: str = ""


@dataclass
class Stops:
    """Points that robots can reach, by their operation, each with the names of its locations."""

    load: dict[str, list[str]] = field(default_factory=dict)
    unload: dict[str, list[str]] = field(default_factory=dict)
    charge: dict[str, list[str]] = field(default_factory=dict)
    park: dict[str, list[str]] = field(default_factory=dict)
    other: dict[str, list[str]] = field(default_factory=dict)
    tasks: list[PlantTask] = field(default_factory=list)


def stops_of(plant: Plant, reachable: Collection[str], operations: Mapping[str, str]) -> Stops:
    """Return the points of a plant's locations by operation; unusable parts are noted in the plant.

    Args:
        plant: the plant.
        reachable: the points that robots can drive to and away from.
        operations: what robots do at locations that allow an operation: load, unload, charge, park or none.

    Raises:
        ModelError: the mapping names no operation of the plant, or no activity of robots.
    """
    roles = _roles(plant, operations)
    stops = Stops()
    cut_off, idle = [], []
    for location in plant.locations:
        points = {point: allowed for point, allowed in location.operations.items() if point in reachable}
        if not points:
            cut_off.append(location)
        for point, allowed in points.items():
            here = {roles[name] for name in allowed} - {NONE}
            for role in sorted(here) or ["other"]:
                getattr(stops, role).setdefault(point, []).append(location.name)
            if not here:
                idle.append(location)
    plant.note_parts("unreachable", "location", cut_off, "robots cannot get to its points and back")
    parking = [point for point in plant.points.values() if point.parking]
    for park in parking:
        if park.name in reachable:
            stops.park.setdefault(park.name, [])
    lost = [point for point in parking if point.name not in reachable]
    plant.note_parts("unreachable", "parking point", lost, "robots cannot get there and back")
    _tasks(plant, stops, roles, reachable)
    _fall_back(plant, stops, roles, reachable)
    if idle and not any(remark.kind in {"layout.storage", "tasks.unload_at"} for remark in plant.remarks):
        why = f"no operation there is loading, unloading, charging or parking by its name ({_named(roles, NONE)})"
        plant.note_parts("left out", "location", {location.name: location for location in idle}.values(), why)
    return stops


def _roles(plant: Plant, operations: Mapping[str, str]) -> dict[str, str]:
    """Return the role of every operation: as the user maps it, else as its name suggests."""
    names = dict.fromkeys(
        name for location in plant.locations for allowed in location.operations.values() for name in allowed
    )
    names |= dict.fromkeys(operation for order in plant.transports for _, operation in order.stops)
    mapped = {}
    for name, role in operations.items():
        same = [operation for operation in names if operation.casefold() == name.casefold()]
        if not same:
            hint = did_you_mean(name, names)
            expected = f"one of {spoken(map(repr, names), 'or')}" if names else "none, as the plant has no operations"
            raise ModelError([f"operation {name!r}: not an operation of {plant.source}, expected {expected}{hint}"])
        if role not in {*get_args(Role), NONE}:
            expected = spoken([*get_args(Role), NONE], "or")
            raise ModelError([f"operation {name!r}: not what robots do (got {got(role)}), expected {expected}"])
        mapped.update(dict.fromkeys(same, role))
    return {name: mapped.get(name) or sounds_like(name) for name in names}


def sounds_like(name: str) -> str:
    """Return the role that the name of an operation suggests; `none` if it suggests none."""
    sound = name.casefold().replace("_", " ")
    return next((role for role, pattern in _GUESSES if re.search(pattern, sound)), NONE)


def _named(roles: Mapping[str, str], role: str) -> str:
    return ", ".join(name for name, its in roles.items() if its == role) or "none"


def _tasks(plant: Plant, stops: Stops, roles: Mapping[str, str], reachable: Collection[str]) -> None:
    """Turn transport orders into tasks: a load goes to the next stop that unloads, via the stops in between."""
    reached = {
        location.name: [name for name in location.operations if name in reachable] for location in plant.locations
    }
    lost: list[Transport] = []
    idle: list[Transport] = []
    several: list[Transport] = []
    skipped: list[str] = []
    for order in plant.transports:
        tasks: list[PlantTask] = []
        load, via = None, list[str]()
        for name, operation in order.stops:
            point = name if name in reachable else next(iter(reached.get(name, ())), None)
            role = roles[operation]
            if point is None:
                lost.append(order)
            elif role == "load" and load is None:
                load, via = point, []
            elif role == NONE and load is not None:
                via.append(point)
            elif role == "unload" and load is not None:
                tasks.append(PlantTask(load, point, order.release, order.due, tuple(via), order.name))
                load = None
            else:
                skipped.append(f"{operation} at {name}")
        stops.tasks += tasks
        if not tasks:
            idle.append(order)
        elif len(tasks) > 1:
            several.append(order)
    for task in stops.tasks:
        stops.load.setdefault(task.source, ["begin of tasks"])
        stops.unload.setdefault(task.target, ["end of tasks"])
    plant.note("left out", "stop of an order", skipped, "neither loads a robot that is empty nor unloads it")
    plant.note_parts("left out", "transport order", lost, "in part: robots cannot get to one of its stops and back")
    plant.note_parts("left out", "transport order", idle, "nothing is loaded in it and then unloaded; map operations")
    plant.note_parts("changed", "transport order", several, "a task for every load, in any order and by any robot")


def _fall_back(plant: Plant, stops: Stops, roles: Mapping[str, str], reachable: Collection[str]) -> None:
    """Assume loading, or unloading, at all locations but chargers if no operation is loading, or unloading.

    If the drawing has no other locations, use the points where robots park; if they park nowhere, use every point.
    """
    work = {**stops.other, **stops.unload, **stops.load}
    drawn = [allowed for location in plant.locations for allowed in location.operations.values()]
    if not (stops.load or stops.unload) and all(
        allowed and {roles[name] for name in allowed} <= {"charge", "park"} for allowed in drawn
    ):
        names = list(stops.park) or [name for name in plant.points if name in reachable]
        where = "where robots park" if stops.park else "at every point"
        stops.load = stops.unload = {name: ["anywhere"] for name in names}
        why = f"the drawing has no places of work, so robots load and unload {where}"
        plant.assume("layout.storage", why)
        plant.assume("tasks.unload_at", why)
    for role, key, cure in (("load", "layout.storage", "loading"), ("unload", "tasks.unload_at", "unloading")):
        if not getattr(stops, role) and work:
            setattr(stops, role, work)
            why = (
                f"no operation is {cure} by its name ({', '.join(roles)}), so all but chargers and parking are; map one"
            )
            plant.assume(key, why, list(dict.fromkeys(name for names in work.values() for name in names)))
