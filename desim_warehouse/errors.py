"""Exceptions of this package, as one tree.

    WarehouseError
    ├── ModelError        the model or study file: all problems of a file at once
    ├── CheckError        a model that a check before the run shows cannot work
    │   └── LayoutError       the Highways: unreachable places, stops that void the liveness guarantee
    ├── PolicyError       a decision that cannot be carried out, with the policy that made it
    ├── SimulationError   a run that cannot go on
    │   ├── GridlockError     a full ring where the model forbids turning
    │   ├── StallError        work is open and nothing is scheduled
    │   └── BatteryError      a robot ran flat
    ├── StudyError        a study that cannot be run, stored or read
    └── ReportError       a report, replay or export that cannot be made
        └── NoIndicatorError  an indicator that a run does not have; also a KeyError

Catch `WarehouseError` to catch them all. Below the tree: how messages word values, lists and near misses.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any


class WarehouseError(Exception):
    """Base class of all errors that this package raises."""

    def _render_traceback_(self) -> list[str]:
        """Show in Jupyter the message alone, which says where and what to do, and not the way through the code."""
        return [f"{type(self).__name__}: {self}"]


class ModelError(WarehouseError):
    """Raised for an invalid model or study file: `problems` lists all problems, one line each, with their positions."""

    def __init__(self, problems: list[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = list(problems)

    def __reduce__(self) -> tuple[type[ModelError], tuple[list[str]]]:
        return type(self), (self.problems,)


class CheckError(WarehouseError):
    """Raised for a model that a check shows cannot work: `problems` lists all errors with their codes."""

    def __init__(self, problems: list[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = list(problems)

    def __reduce__(self) -> tuple[type[CheckError], tuple[list[str]]]:
        return type(self), (self.problems,)


class LayoutError(CheckError):
    """Raised for a layout on which work could stop for good: `problems` lists all problems, one line each."""


class PolicyError(WarehouseError):
    """Raised for a policy that cannot be loaded, or that returns something impossible."""


class SimulationError(WarehouseError):
    """Raised when a run cannot continue."""


class GridlockError(SimulationError):
    """Raised for a full ring of robots that is not allowed to turn (`traffic.gridlock: stop`)."""


class StallError(SimulationError):
    """Raised when work is open, but no event is scheduled that could complete it, or it is never given out."""


class BatteryError(SimulationError):
    """Raised when a robot runs flat outside its charging zone."""


class StudyError(WarehouseError):
    """Raised for a study that cannot be run, stored or read."""


class ReportError(WarehouseError):
    """Raised when a report, replay, figure or export cannot be made."""


class NoIndicatorError(ReportError, KeyError):
    """An indicator that a run does not have."""

    __str__ = Exception.__str__  # a KeyError would put its message into quotes


class Interruption(BaseException):
    """A signal that ends a run from outside, whatever a policy catches; not taken for a fault of the policy."""


PASSED_ON = (KeyboardInterrupt, Interruption)
"""What code of the user's own raises without a fault of its own; all else, SystemExit too, is one."""

_LONGEST = 50  # characters of a value in a message
_LARGE = 1e15  # whole numbers below it are written out
_ALIKE = 0.6  # of 1, as difflib counts
_LONG = 3  # letters that may abbreviate a longer word
_COMPARED = 1000  # words among which the nearest is looked for
_DECIMAL_COMMA = re.compile(r"([+-]?\d+),(\d+)((?: ?[a-zA-Z%/].*)?)")
_MARKS = {";": "semicolons", "\t": "tabs"}  # between the cells of a file that is no plain CSV

_ALSO_CALLED = {
    "service_level": ("on_time",),
    "sla": ("on_time",),
    "otif": ("on_time",),
    "on_time_in_full": ("on_time",),
    "punctuality": ("on_time",),
    "utilisation": ("robots_busy",),
    "robot_utilisation": ("robots_busy",),
    "fleet_utilisation": ("robots_busy",),
    "occupancy": ("robots_busy",),
    "throughput": ("throughput_per_hour",),
    "queue_length": ("backlog",),
    "wip": ("backlog",),
    "congestion": ("share_waiting",),
    "idle_time": ("share_idle",),
    "empty_travel": ("share_empty",),
    "uptime": ("availability",),
    "downtime": ("share_broken",),
    "late": ("tardiness_mean", "on_time"),
    "lateness": ("tardiness_mean",),
    "makespan": ("T",),
    "cycle_time": ("cycle_time_mean",),
    "p95_cycle_time": ("cycle_time_p95",),
    "lead_time": ("cycle_time_mean", "cycle_time_p95"),
    "throughput_time": ("cycle_time_mean",),
    "flow_time": ("cycle_time_mean",),
    "turnaround_time": ("cycle_time_mean",),
    "costs": ("annual_cost",),
    "dispatching": ("allocation",),
    "closest": ("nearest",),
    "closest_robot": ("nearest",),
    "fifo": ("in-order",),
    "first_come": ("in-order",),
    "edd": ("earliest-due",),
    "due_date": ("earliest-due", "due_within"),
    "deadline": ("due_within", "due_at"),
    "dijkstra": ("shortest",),
    "a_star": ("shortest",),
    "4_thresholds": ("four-thresholds",),
    "shortest_path": ("shortest",),
    "feet": ("ft",),
    "foot": ("ft",),
    "inch": ("in",),
    "inches": ("in",),
    "meters": ("m",),
    "metres": ("m",),
    "seconds": ("s",),
    "sec": ("s",),
    "minutes": ("min",),
    "hours": ("h",),
    "hr": ("h",),
    "days": ("d",),
    "fps": ("ft/s",),
    "fpm": ("ft/min",),
    "kmh": ("km/h",),
    "duration": ("length", "stay", "lasts"),
    "count": ("size", "count"),
    "number": ("size", "count"),
    "robots": ("fleet.size", "size", "robots_busy"),
    "agvs": ("fleet.size", "size", "robots_busy"),
    "amrs": ("fleet.size", "size", "robots_busy"),
    "vehicles": ("fleet.size", "size", "robots_busy"),
    "fleet_size": ("fleet.size",),
    "speed": ("fleet.robot.speed",),
    "velocity": ("fleet.robot.speed", "speed"),
    "width": ("radius", "aisle_width"),
    "diameter": ("radius",),
    "mtbf": ("every",),
    "mttr": ("repair",),
    "pick_time": ("load_time",),
    "drop_time": ("unload_time",),
    "orders_per_hour": ("poisson", "per_hour"),
    "slots": ("places",),
    "pickers": ("workers", "servers", "worker_utilisation"),
    "packers": ("servers", "workers", "server_utilisation", "worker_utilisation"),
    "packer_utilisation": ("server_utilisation", "worker_utilisation"),
    "chargers": ("charger_utilisation",),
}
"""What people call things that have another name here; the first one that there is where it is said is meant."""

LONGEST = 500
"""The number of characters of a path that a message spells out."""


def shown(value: object) -> str:
    """Show a value that code of the user's own has made, in one line; such a value may refuse to be shown."""
    try:
        return " ".join(line.strip() for line in repr(value).splitlines())
    except Exception:  # noqa: BLE001 - whatever their __repr__ raises
        return f"a {type(value).__name__}"


def path_of(path: object) -> str:
    """Write a path in a message; the middle of one that is longer than people type is left out."""
    text = str(path)
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]} ... {text[-LONGEST // 10 :]}"


def reason(error: Exception) -> str:
    """Return why something failed, for a message that names the file itself: without error numbers and paths."""
    if isinstance(error, KeyError):
        return f"{error} is missing"
    if isinstance(error, UnicodeDecodeError):
        return "not text in UTF-8"
    if isinstance(error, FileExistsError | NotADirectoryError):
        return "a file is in the place of a folder"
    return getattr(error, "strerror", None) or str(error)


def spoken(words: Iterable[str], last: str = "and") -> str:
    """Write a list in words: a, b and c."""
    *head, tail = list(words)
    return f"{', '.join(head)} {last} {tail}" if head else tail


def number_of(count: float, what: str) -> str:
    """Write a number of things, `what` in the singular: `1 task`, `1,200 tasks`, `2 properties of nodes`."""
    noun = what.partition(" of ")[0]
    several = f"{noun[:-1]}ies" if re.search("[^aeiou]y$", noun) else f"{noun}s"
    return f"{count:,.15g} {what if count == 1 else several + what[len(noun) :]}"


def first_of(names: Sequence[str], most: int) -> str:
    """Write the first of many names, and how many more: a, b and 3 more."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def nearest(word: str, words: Iterable[str]) -> str | None:
    """Return the word that was probably meant: a synonym, the most similar one, or one that contains it."""
    lower = {_plain(candidate): candidate for candidate in words}
    plain = _plain(word)
    if meant := synonym(word, lower.values()):
        return meant
    near = difflib.get_close_matches(plain, lower, n=1, cutoff=_ALIKE)
    if not near and len(word) >= _LONG:
        near = [candidate for candidate in lower if candidate.startswith(plain)] or [
            candidate for candidate in lower if plain in candidate.split("_")
        ]
    return lower[near[0]] if near else None


def did_you_mean(word: str, words: Collection[str]) -> str:
    """Return the end of a message that names the nearest word; empty without one, or among too many to compare."""
    near = nearest(word, words) if len(words) <= _COMPARED else None
    return f"; did you mean '{near}'?" if near else ""


def other_marks(header: Iterable[str]) -> str:
    """Return the end of a message on a CSV file whose header has other marks between cells than commas; else empty."""
    written = "".join(header)
    marks = next((name for mark, name in _MARKS.items() if mark in written), None)
    return f"; its cells end with {marks}, expected commas, and decimal points" if marks else ""


def with_point(text: str) -> str | None:
    """Return how a number with a decimal comma is written instead, also with a unit; None for any other text."""
    match = _DECIMAL_COMMA.fullmatch(text.strip())
    if match is None:
        return None
    whole, part, unit = match.groups()
    thousands = f", or {whole}{part}{unit}" if len(part) == _LONG else ""
    return f"{whole}.{part}{unit}{thousands}"


def synonym(word: str, words: Iterable[str]) -> str | None:
    """Return the word that people mean by another name for it, or by its own with other spaces and capitals."""
    lower = {_plain(candidate): candidate for candidate in words}
    names = (word, *_ALSO_CALLED.get(_plain(word), ()))
    return next((lower[name] for name in map(_plain, names) if name in lower), None)


def _plain(word: str) -> str:
    """Normalize a name: its case, one sign between its parts, and British spelling."""
    return word.lower().replace("-", "_").replace(" ", "_").replace("ization", "isation")


def got(value: Any) -> str:
    """Write a value as it stands in a model file, shortened."""
    written = _flow(value)
    return written if len(written) <= _LONGEST else f"{written[: _LONGEST - 4]} ..."


def _flow(value: Any) -> str:  # noqa: PLR0911 - a return for each kind of value
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    if isinstance(value, float) and value.is_integer() and abs(value) < _LARGE:
        return str(int(value))
    if isinstance(value, int) and abs(value) >= 10**_LONGEST:
        return f"a number of about {int(math.log10(abs(value))) + 1} digits"
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key}: {_inner(item)}' for key, item in list(value.items())[:_LONGEST])}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(_inner(item) for item in value[:_LONGEST])}]"
    return repr(value)


def _inner(value: Any) -> str:
    """Write a value in a list or a mapping: a plain word, or a number with a unit, needs no quotes."""
    plain = isinstance(value, str) and re.fullmatch(r"[A-Za-z_][\w.-]*|[\d.]+ [a-z]+", value)
    return str(value) if plain else _flow(value)
