"""A plant as drawn, in metres and seconds, y downwards, the common result of the readers of all formats.

For `desim import` and `desim export`.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from desim_warehouse.errors import first_of, number_of

Role: TypeAlias = Literal["load", "unload", "charge", "park"]
"""The activity of robots at a location."""
Rule: TypeAlias = Literal["one-robot", "one-direction"]
"""The rule by which robots share an area."""
What: TypeAlias = Literal["left out", "changed", "doubtful", "unreachable", "assumed"]

Part: TypeAlias = "Waypoint | Link | Location | Vehicle | Area | Transport"


@dataclass(frozen=True, slots=True)
class Waypoint:
    """A point where links meet and robots can stop; `parking`: idle robots are sent there."""

    name: str
    x: float
    y: float
    parking: bool = False
    position: str = ""
    """Position in the file, such as a line; also in all other parts of a plant."""


@dataclass(frozen=True, slots=True)
class Link:
    """A way between two points.

    `length` is in metres; None for the straight distance. `speed` and `speed_back` are the limits from source to target
    and back: 0 if robots may not drive in that direction, inf without a limit. `against`: factor on the length in the
    choice of routes, if the link is driven back. `side_by_side`: together with an opposite link it is two lanes,
    however alike they are.
    """

    name: str
    source: str
    target: str
    length: float | None = None
    speed: float = math.inf
    speed_back: float = 0.0
    position: str = ""
    against: float = 1.0
    side_by_side: bool = False


@dataclass(frozen=True, slots=True)
class Location:
    """A place of work: the allowed operations, by the points from which robots reach it."""

    name: str
    operations: dict[str, tuple[str, ...]]
    position: str = ""


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A robot as drawn; `start`: the point at which it begins."""

    name: str
    length: float | None = None
    speed: float | None = None
    start: str | None = None
    critical: float | None = None
    """Share of a full battery at which the vehicle has to charge."""
    position: str = ""


@dataclass(frozen=True, slots=True)
class Transport:
    """A transport order: points or locations in the order of visits, each with the operation there.

    `release` and `due` are times from the start of a run, in seconds.
    """

    name: str
    stops: tuple[tuple[str, str], ...]
    release: float = 0.0
    due: float | None = None
    position: str = ""


@dataclass(frozen=True, slots=True)
class Area:
    """Points and links that robots use one at a time, or in one direction at a time."""

    name: str
    members: tuple[str, ...]
    rule: Rule
    position: str = ""


@dataclass(frozen=True, slots=True)
class Remark:
    """A remark on parts of a drawing that the model leaves out or changes, or on an assumption that it makes.

    Attributes:
        what: one of left out, changed, doubtful, unreachable, assumed.
        kind: the kind of part, such as "path"; for an assumption, the key of the model.
        names: names of the parts.
        why: the reason, and what to do about it.
        positions: position of each part in the file, if known.
    """

    what: What
    kind: str
    names: tuple[str, ...]
    why: str
    positions: tuple[str, ...] = ()

    def which(self, most: int | None = None) -> str:
        """Return the names, each with its position in the file, at most `most` of them."""
        positions = self.positions or ("",) * len(self.names)
        named = [
            f"{name} ({position})" if position else name for name, position in zip(self.names, positions, strict=True)
        ]
        return first_of(named, len(named) if most is None else most)

    def __str__(self) -> str:
        number, names = len(self.names), f": {self.which()}" if self.names else ""
        kind = self.kind if self.what == "assumed" else number_of(number, self.kind)
        return f"{self.what}: {kind}: {self.why}{names}"


@dataclass(slots=True)
class Plant:
    """The content of a file in another program's format; `source` names the file and the format."""

    name: str
    source: str
    points: dict[str, Waypoint] = field(default_factory=dict)
    links: list[Link] = field(default_factory=list)
    locations: list[Location] = field(default_factory=list)
    vehicles: list[Vehicle] = field(default_factory=list)
    areas: list[Area] = field(default_factory=list)
    lifts: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Lifts by name, each with a point on every level that it serves, from the lowest up."""
    level_of: dict[str, str] = field(default_factory=dict)
    """The name of each point's level, if the plant has several."""
    levels: tuple[str, ...] = ()
    """The names of levels, from the lowest up."""
    transports: list[Transport] = field(default_factory=list)
    """The work, if the file or one beside it lists it."""
    numbered: dict[int, str] = field(default_factory=dict)
    """Points by the numbers that files with tasks use."""
    handling: float | None = None
    """Seconds that loading and unloading take; None if unknown."""
    cell: float | None = None
    """Side of the cells of a grid, in metres: by default a robot fills a cell, and drives one a second."""
    remarks: list[Remark] = field(default_factory=list)
    options: tuple[str, ...] = ()
    """Names of the options of its format."""
    unknown: dict[str, tuple[str, int]] = field(default_factory=dict)
    """Unknown keys of the file: the first position of each, and its number."""

    def note(self, what: What, kind: str, names: Iterable[str], why: str, positions: Iterable[str] = ()) -> None:
        """Add a remark unless `names` is empty; `positions`: the position of each name in the file."""
        if names := tuple(names):
            self.remarks.append(Remark(what, kind, names, why, tuple(positions)))

    def see_keys(self, keys: Iterable[str], expected: Container[str], position: str, part: str = "") -> None:
        """Record the keys of a part of the file that are not among the expected ones; `part`: the name of the part."""
        for key in keys:
            if key not in expected:
                name = f"{part}.{key}" if part else key
                first, count = self.unknown.get(name, (position, 0))
                self.unknown[name] = first, count + 1

    def note_unknown(self) -> None:
        """Note the keys that `see_keys` has recorded as unknown."""
        positions = [f"{first}{f' and {count - 1:,} more' * (count > 1)}" for first, count in self.unknown.values()]
        self.note("left out", "key", self.unknown, "not known here", positions)

    def note_parts(self, what: What, kind: str, parts: Iterable[Part], why: str) -> None:
        """Add a remark about parts of the plant, by their names and positions."""
        parts = list(parts)
        self.note(what, kind, [part.name for part in parts], why, [part.position for part in parts])

    def work(self) -> dict[str, tuple[str, ...]]:
        """Return the operations of robots by points: parking, and the operations that locations allow there."""
        doing: dict[str, dict[str, None]] = {
            point.name: {"park": None} for point in self.points.values() if point.parking
        }
        for location in self.locations:
            for name, operations in location.operations.items():
                doing.setdefault(name, {}).update(dict.fromkeys(operations))
        return {name: tuple(operations) for name, operations in doing.items()}

    def assume(self, key: str, why: str, names: Iterable[str] = ()) -> None:
        """Note an assumption on a key of the model, for which the drawing has no value."""
        self.remarks.append(Remark("assumed", key, tuple(names), why))


def unique(name: str, taken: Container[str]) -> str:
    """Return the name, with a number appended if it is taken."""
    number, tried = 1, name
    while tried in taken:
        number += 1
        tried = f"{name} ({number})"
    return tried


def claim(name: str, taken: set[str]) -> str:
    """Return the name, with a number appended if it is taken, and add it to `taken`."""
    made = unique(name, taken)
    taken.add(made)
    return made
