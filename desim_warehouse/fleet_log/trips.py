"""Trips of a fleet from a CSV file: where each load was picked and put down, and when."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from desim_warehouse.errors import ReportError, got, nearest, reason
from desim_warehouse.fleet_log.table import DROP, PICK, Collector, FleetLog
from desim_warehouse.values.dates import Slashes, across_midnight, end_across_midnight, instant, read_times

COLUMNS = ("robot", "pick", "drop", "start", "end")


def read_trips(path: Path, slashes: Slashes | None = None) -> FleetLog:
    """The trips of a CSV file with columns robot, pick, drop (nodes), start and end (seconds, or dates).

    Each makes two rows: a pick where it starts and a drop where it ends. Bad rows are noted. Dates are read as those of
    orders (`values.dates`); those without a zone are on the clock of the hall, and count as UTC, as in messages.

    Raises:
        ReportError: a file that cannot be read, a column that is missing, or no good row.
    """
    found = Collector(str(path))
    try:
        with path.open(encoding="utf-8-sig", newline="") as lines:
            rows = csv.DictReader(lines, skipinitialspace=True)
            for name in COLUMNS:
                if name not in (rows.fieldnames or ()):
                    near = nearest(name, rows.fieldnames or ())
                    hint = f"; did you mean '{near}'?" if near else ""
                    raise ReportError(f"{path}: no column '{name}', expected {', '.join(COLUMNS)}{hint}")
            for number, row, start, end in _timed(list(rows), slashes, found):
                try:
                    if None in row.values() or None in row:
                        raise ValueError(f"a row with other than {len(rows.fieldnames or ())} cells")  # noqa: TRY301
                    for name, time in (("start", start), ("end", end)):
                        if math.isnan(time):
                            instant(row[name], slashes)  # which says why it is none
                    if end < start:
                        raise ValueError(f"it ends before it starts (got {got(row['end'])})")  # noqa: TRY301
                except ValueError as error:
                    found.notes.refuse(f"{path}:{number}", str(error))
                    continue
                found.add(
                    start, (row["robot"], ""), math.nan, math.nan, row["pick"], False, True, PICK, math.nan, False
                )
                found.add(end, (row["robot"], ""), math.nan, math.nan, row["drop"], False, False, DROP, math.nan, False)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ReportError(f"{path}: cannot be read ({reason(error)}), expected a CSV file of trips") from error
    return found.log(trips=True)


def _timed(
    rows: list[dict[Any, Any]], slashes: Slashes | None, found: Collector
) -> Iterator[tuple[int, dict[Any, Any], float, float]]:
    """The rows of trips with their numbers, and when they start and end, by the one reading of both columns."""
    read = read_times([(row.get(name) or "").strip() for name in ("start", "end") for row in rows], slashes)
    found.notes.assumed += [f"times: each column {note}" for note in read.notes]
    starts, ends = read.clocks[: len(rows)], read.clocks[len(rows) :]
    across_midnight(starts)
    end_across_midnight(starts, ends)
    read.clocks = starts + ends
    times = read.since_1970()
    yield from zip(range(2, len(rows) + 2), rows, times[: len(rows)], times[len(rows) :], strict=True)
