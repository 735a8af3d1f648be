"""Logs of real fleets: reading them, calibrating a model from them, validating a model against them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from desim_warehouse.errors import ReportError
from desim_warehouse.values.arguments import each

if TYPE_CHECKING:
    from desim_warehouse.fleet_log.table import FleetLog
    from desim_warehouse.values.dates import Slashes


__all__ = ["read_log", "read_logs"]


def read_log(path: str | Path, *, dates: Slashes | None = None) -> FleetLog:
    """Read the log of a fleet from the folder of a run, a CSV file of trips, or VDA 5050 messages as JSON lines.

    `dates`: how 03/02/2026 is meant, "us" or "uk", where all dates may be meant in both ways.

    Returns:
        Tables of trips, and of messages where there are some; times in seconds.

    Raises:
        ReportError: what cannot be read, or has no good row.
    """
    from desim_warehouse.fleet_log.runs import from_run
    from desim_warehouse.fleet_log.trips import read_trips
    from desim_warehouse.fleet_log.vda5050 import read_messages
    from desim_warehouse.run import RunData

    path = Path(path)
    if path.is_dir():
        return from_run(RunData.load(path))
    return (read_trips if path.suffix.lower() == ".csv" else read_messages)(path, dates)


def read_logs(
    logs: str | Path | FleetLog | Iterable[str | Path | FleetLog], dates: Slashes | None = None
) -> list[FleetLog]:
    """Read one log or several: those that are paths with `read_log`.

    Raises:
        ReportError: no log, or one whose rows are all of one time.
    """
    read = [read_log(log, dates=dates) if isinstance(log, str | Path) else log for log in each(logs)]
    if not read:
        raise ReportError("no log, expected at least one")
    for log in read:
        if not log.length:
            problem = f"; {log.notes.problems[0]}" if log.notes.problems else ""
            raise ReportError(f"{log.name}: all that can be read is of one time, expected the log of a day{problem}")
    return read
