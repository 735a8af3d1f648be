"""State messages of VDA 5050 2.0 and 2.1, one JSON object a line: what fleets report, read and written.

Source: VDA 5050, Interface for the communication between automated guided vehicles (AGV) and a master control,
version 2.1.0 (January 2025), sections 6.10 and 6.11.
"""

from __future__ import annotations

import datetime as dt
import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.errors import ReportError, got, reason
from desim_warehouse.fleet_log.table import CHARGE, DROP, NOTHING, PICK, UNSAID, Collector, FleetLog

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from desim_warehouse.run import Run

_KINDS = {"pick": PICK, "drop": DROP, "startCharging": CHARGE}
_MILLISECONDS = 1e11
"""A number above this is a time in milliseconds since 1970, below in seconds."""
_FIRST_DAY = dt.datetime(2026, 1, 1, tzinfo=dt.UTC)
"""When a run begins whose model names no date."""
GAP_LENGTH = (20.0, 90.0)
"""Least and largest length of the gaps that are written, in seconds."""


def read_messages(path: Path) -> FleetLog:
    """The states in a file of messages, one a line; empty lines are passed over, bad ones noted.

    Raises:
        ReportError: a file that cannot be read, or has no good line.
    """
    found = Collector(str(path))
    try:
        with path.open("rb") as lines:
            for number, line in enumerate(lines, 1):
                if not line.strip():
                    continue
                try:
                    _take(json.loads(line), found)
                except (ValueError, TypeError, KeyError, AttributeError, OverflowError) as error:
                    found.notes.refuse(f"{path}:{number}", _why(error))
    except OSError as error:
        raise ReportError(f"{path}: cannot be read ({reason(error)}), expected a log") from error
    return found.log()


def _why(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"no {error.args[0]!r}, which every state message has"
    if isinstance(error, json.JSONDecodeError | UnicodeDecodeError):
        return "no JSON object, expected a state message of VDA 5050"
    return str(error)


def _take(message: dict[str, Any], found: Collector) -> None:
    position = message.get("agvPosition") or {}
    loads, errors = message.get("loads"), message["errors"]
    x, y = position.get("x", math.nan), position.get("y", math.nan)
    if position.get("positionInitialized") is False:
        x = y = math.nan
    battery = message["batteryState"]
    action = CHARGE if battery.get("charging") else NOTHING
    for state in message["actionStates"]:
        if state["actionStatus"] == "RUNNING":
            action = _KINDS.get(state.get("actionType", ""), action)
    found.add(
        seconds(message["timestamp"]),
        message["serialNumber"],
        x,
        y,
        message["lastNodeId"],
        message["driving"] is True,
        UNSAID if loads is None else bool(loads),
        action,
        battery.get("batteryCharge", math.nan),
        any(error["errorLevel"] == "FATAL" for error in errors),
    )


def seconds(stamp: str | float) -> float:
    """A time stamp in seconds since 1970; one without a zone is UTC, as the standard asks for."""
    if isinstance(stamp, int | float):
        return stamp / 1000 if stamp > _MILLISECONDS else float(stamp)
    try:
        time = dt.datetime.fromisoformat(stamp)
    except (ValueError, TypeError):
        raise ValueError(f"timestamp: no time (got {got(stamp)}), expected one such as 2026-03-02T06:15:00Z") from None
    return (time if time.tzinfo else time.replace(tzinfo=dt.UTC)).timestamp()


def messages(run: Run, *, noise: float = 0.0, gaps: float = 0.0, every: float = 1.0) -> Iterator[str]:
    """The run as state messages of VDA 5050 2.1, one for each robot every second, in order of time.

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


_TYPES = {code: kind for kind, code in _KINDS.items()}


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
