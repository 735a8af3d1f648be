"""State messages of VDA 5050, read (2.0 to 3.0) and written (2.1), one JSON object a line: what fleets report.

Recorders write more around them: the topic before each, as `mosquitto_sub -v` does, a wrapper with the message as its
`payload`, several messages of a line as a list, or a list with a message on each line.

Source: VDA 5050, Interface for the communication between automated guided vehicles (AGV) and a master control,
version 2.1.0 (January 2025), sections 6.10 and 6.11.
"""

from __future__ import annotations

import codecs
import datetime as dt
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from desim_warehouse.errors import ReportError, got, reason
from desim_warehouse.fleet_log.table import CHARGE, DROP, NOTHING, PICK, UNSAID, Collector, FleetLog
from desim_warehouse.model.json_text import JsonError, value_of
from desim_warehouse.run import RunData
from desim_warehouse.values.dates import Slashes, instant

V = TypeVar("V")
_KINDS = {"pick": PICK, "drop": DROP, "startCharging": CHARGE}
_LEVELS = {"batteryState": "batteryCharge", "powerSupply": "stateOfCharge"}
"""Where the level of the battery stands, up to VDA 5050 2.1 and from 3.0 on."""
_TOPIC = re.compile(rb"^[^\s\"{}\[\]]+\s+(?=[{\[])")
_STATE = "a state message of VDA 5050"
_LINE = f"{_STATE} on each line"
_WORDS = {dict: "an object", list: "a list of objects", str: "text", bool: "true or false", float: "a number"}
_TYPES = {code: kind for kind, code in _KINDS.items()}
_FIRST_DAY = dt.datetime(2026, 1, 1, tzinfo=dt.UTC)
"""When a run begins whose model names no date."""
GAP_LENGTH = (20.0, 90.0)
"""Least and largest length of the gaps that are written, in seconds."""
LONGEST = 1_000_000
"""Bytes of a line that is read; a state message has some thousands."""
_FAR_OFF = 1e9
"""Positions have smaller figures."""
_FULL = 100.0


def read_messages(path: Path, slashes: Slashes | None = None) -> FleetLog:
    """Read the states in a file of messages, one a line; empty lines are skipped, bad lines noted.

    Time stamps without an offset from UTC are UTC, as the standard asks for.

    Raises:
        ReportError: a file that cannot be read, or has no good line.
    """
    collector = Collector(str(path))
    try:
        for number, line in enumerate(_lines(path), 1):
            if len(line) > LONGEST:
                raise ReportError(f"{path}:{number}: a line of more than {LONGEST:,} bytes, expected {_LINE}")
            if not (text := _of_list(line.strip())):
                continue
            try:
                for message in _unwrapped(value_of(_TOPIC.sub(b"", text))):
                    _take(message, collector, slashes)
            except JsonError as error:
                why = f"{error.where.removeprefix(':').strip()}: {error}" if error.expected else str(error)
                collector.notes.refuse(f"{path}:{number}", f"{why}, expected {error.expected or _LINE}")
            except ValueError as error:
                collector.notes.refuse(f"{path}:{number}", str(error))
    except (OSError, UnicodeError) as error:
        raise ReportError(f"{path}: cannot be read ({reason(error)}), expected a log") from error
    return collector.log()


def _lines(path: Path) -> Iterator[bytes]:
    """Yield the lines of a file in UTF-8, also of one in UTF-16 with its mark, as PowerShell writes what it is sent."""
    with path.open("rb") as file:
        start = file.read(2)
        if start in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
            with path.open(encoding="utf-16") as text:
                yield from iter(lambda: text.readline(LONGEST + 1).encode(), b"")
            return
        file.seek(0)
        yield file.readline(LONGEST + 1).removeprefix(codecs.BOM_UTF8)
        yield from iter(lambda: file.readline(LONGEST + 1), b"")


def _of_list(line: bytes) -> bytes:
    """Return a line without the marks of a list that goes on over several lines: its brackets and commas."""
    line = line.removesuffix(b",")
    if line.startswith(b"[") != line.endswith(b"]"):
        return line.removeprefix(b"[").removesuffix(b"]").strip()
    return line


def _unwrapped(value: Any) -> list[Any]:
    """Unwrap the message, or list of messages, of a line; raises JsonError for a payload that is not JSON."""
    unwrapped = []
    for item in value if isinstance(value, list) and value else [value]:
        payload = item.get("payload") if isinstance(item, dict) and "timestamp" not in item else None
        message = item if payload is None else payload
        unwrapped.append(value_of(message.encode()) if isinstance(payload, str) else message)
    return unwrapped


def _of(section: Any, key: str, kind: type[V], within: str = "") -> V | None:
    """Return the value at a key of a message; None where it is missing. Raises ValueError for another kind."""
    value = section.get(key)
    if value is None:
        return None
    fits = isinstance(value, kind)
    if kind is float:
        fits = isinstance(value, int | float) and not isinstance(value, bool)
    if kind is list and fits:
        fits = all(isinstance(entry, dict) for entry in value)
    if not fits:
        raise ValueError(f"{within}{key}: expected {_WORDS[kind]} (got {got(value)})")
    return value  # type: ignore[no-any-return]


def _needed(section: Any, key: str, kind: type[V], within: str = "") -> V:
    value = _of(section, key, kind, within)
    if value is None:
        raise ValueError(f"no '{within}{key}', which every state message has")
    return value


def _figure(section: Any, key: str, within: str, low: float, high: float) -> float:
    """Return the number at a key, nan where there is none; raises ValueError for a value outside of its bounds."""
    value = _of(section, key, float, within)
    if value is None:
        return math.nan
    if not low <= value <= high:
        raise ValueError(f"{within}{key}: expected a number from {low:g} to {high:g} (got {got(value)})")
    return value


def _take(message: Any, collector: Collector, slashes: Slashes | None) -> None:
    """Add a message to a log; raises ValueError where it is no state message."""
    if not isinstance(message, dict):
        raise ValueError(f"expected {_STATE}, a JSON object (got {got(message)})")  # noqa: TRY004 - as for its parts
    stamp = message.get("timestamp")
    if stamp is None:
        raise ValueError("no 'timestamp', which every state message has")
    position = _of(message, "agvPosition", dict) or {}
    x, y = (_figure(position, axis, "agvPosition.", -_FAR_OFF, _FAR_OFF) for axis in ("x", "y"))
    if position.get("positionInitialized") is False:
        x = y = math.nan
    loads, errors = _of(message, "loads", list), _needed(message, "errors", list)
    power = "batteryState" if "powerSupply" not in message else "powerSupply"
    battery = _needed(message, power, dict)
    action = CHARGE if battery.get("charging") else NOTHING
    for state in _needed(message, "actionStates", list):
        if _needed(state, "actionStatus", str, "actionStates.") == "RUNNING":
            action = _KINDS.get(_of(state, "actionType", str, "actionStates.") or "", action)
    collector.add(
        instant(stamp, slashes),
        (_needed(message, "serialNumber", str), _of(message, "manufacturer", str) or ""),
        x,
        y,
        _needed(message, "lastNodeId", str),
        _needed(message, "driving", bool),
        UNSAID if loads is None else bool(loads),
        action,
        _figure(battery, _LEVELS[power], f"{power}.", 0.0, _FULL),
        any(_needed(error, "errorLevel", str, "errors.") == "FATAL" for error in errors),
    )


def messages(run: RunData, *, noise: float = 0.0, gaps: float = 0.0, every: float = 1.0) -> Iterator[str]:
    """Yield the run as state messages of VDA 5050 2.1, one for each robot every second, in order of time.

    Args:
        run: simulated with `log: all`.
        noise: standard deviation of the positions, in the length unit of the layout.
        gaps: stretches of 20 to 90 s without messages, on average for each robot and hour.
        every: seconds between two messages of a robot.

    The axes are those of the standard, y upwards. Noise and gaps are the same each time.
    """
    from desim_warehouse.fleet_log.runs import sampled

    rng = np.random.default_rng(0)
    table = sampled(run, every)
    time = table["time"].to_numpy()
    robot = table["robot"].to_numpy()
    silent = np.zeros(len(table), bool)
    for number in range(run.model.fleet.size):
        begins = rng.uniform(0, time.max(), rng.poisson(gaps * time.max() / 3600))
        for begin, length in zip(begins, rng.uniform(*GAP_LENGTH, len(begins)), strict=True):
            silent |= (robot == number) & (time >= begin) & (time < begin + length)
    for axis in ("x", "y"):
        table[axis] += rng.normal(0, noise, len(table))
    day, _, clock = run.model.run.start.rpartition("T")
    start = dt.datetime.fromisoformat(f"{day or _FIRST_DAY.date()}T{clock}").replace(tzinfo=dt.UTC)
    actions = [0] * run.model.fleet.size
    before = [NOTHING] * run.model.fleet.size
    rows: Any = table[~silent].itertuples(index=False)
    for rank, row in enumerate(rows):
        if row.action != before[row.robot]:
            actions[row.robot] += row.action != NOTHING
            before[row.robot] = row.action
        yield json.dumps(_message(row, rank, start, actions[row.robot]), separators=(",", ":"))


def _message(row: Any, rank: int, start: dt.datetime, action: int) -> dict[str, Any]:
    now = start + dt.timedelta(seconds=row.time)
    kind = _TYPES.get(row.action)
    running = [{"actionId": f"{row.robot}-{action}", "actionType": kind, "actionStatus": "RUNNING"}] if kind else []
    return {
        "headerId": rank,
        "timestamp": now.isoformat(timespec="milliseconds").replace("+00:00", "Z"),
        "version": "2.1.0",
        "manufacturer": "desim-warehouse",
        "serialNumber": f"robot {row.robot}",
        "orderId": "",
        "orderUpdateId": 0,
        "lastNodeId": row.node,
        "lastNodeSequenceId": 0,
        "nodeStates": [],
        "edgeStates": [],
        "driving": row.driving,
        "agvPosition": {
            "x": round(row.x, 4),
            "y": round(-row.y, 4),
            "theta": round(-row.heading, 4),
            "mapId": "floor",
            "positionInitialized": True,
        },
        "loads": [{}] if row.load else [],
        "actionStates": running,
        "batteryState": {"batteryCharge": round(row.charge, 1), "charging": row.action == CHARGE},
        "operatingMode": "AUTOMATIC",
        "errors": [{"errorType": "breakdown", "errorLevel": "FATAL"}] if row.fault else [],
        "safetyState": {"eStop": "NONE", "fieldViolation": False},
    }
