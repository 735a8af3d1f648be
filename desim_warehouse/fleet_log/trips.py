"""Trips of a fleet from a CSV file: where each load was picked and put down, and when."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from pathlib import Path
from sys import intern
from typing import NamedTuple

from desim_warehouse.errors import ReportError, did_you_mean, got, other_marks, reason
from desim_warehouse.fleet_log.table import DROP, PICK, Collector, FleetLog
from desim_warehouse.values.csv_rows import csv_rows
from desim_warehouse.values.dates import Slashes, across_midnight, end_across_midnight, instant, read_times
from desim_warehouse.values.fields import LIMITS

COLUMNS = ("robot", "pick", "drop", "start", "end")


def read_trips(path: Path, slashes: Slashes | None = None) -> FleetLog:
    """Return the trips of a CSV file with columns robot, pick, drop (nodes), start and end (seconds, or dates).

    Each makes two rows: a pick where it starts and a drop where it ends. Bad rows are noted. Dates are read as those of
    orders (`values.dates`); those without a zone are on the clock of the hall, and count as UTC, as in messages.

    Raises:
        ReportError: a file that cannot be read, a column that is missing, or no good row.
    """
    collector = Collector(str(path))
    try:
        if path.stat().st_size > LIMITS["texts"][0]:
            raise ReportError(f"{path}: too large, expected trips of at most {LIMITS['texts'][0] / 1e6:,.0f} MB")
        with path.open(encoding="utf-8-sig", newline="") as lines:
            table = csv_rows(lines, skip_spaces=True)
            header = next(table, (1, []))[1]
            for name in COLUMNS:
                if name not in header:
                    hint = other_marks(header) or did_you_mean(name, header)
                    raise ReportError(f"{path}: no column '{name}', expected {', '.join(COLUMNS)}{hint}")
            for row, start, end in _timed(_trips(path, table, header), slashes, collector):
                try:
                    for time, text in ((start, row.start), (end, row.end)):
                        if row.cells != len(header):
                            raise ValueError(f"a row with other than {len(header)} cells")  # noqa: TRY301
                        if math.isnan(time):
                            instant(text, slashes)  # raises ValueError with the reason
                    if end < start:
                        raise ValueError(f"it ends before it starts (got {got(row.end)})")  # noqa: TRY301
                except ValueError as error:
                    collector.notes.refuse(f"{path}:{row.line}", str(error))
                    continue
                collector.add(start, (row.robot, ""), math.nan, math.nan, row.pick, False, True, PICK, math.nan, False)
                collector.add(end, (row.robot, ""), math.nan, math.nan, row.drop, False, False, DROP, math.nan, False)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ReportError(f"{path}: cannot be read ({reason(error)}), expected trips as CSV UTF-8") from error
    return collector.log(trips=True)


class _Trip(NamedTuple):
    """A row of the file: the number of its last line, its five cells that are read, and how many there are."""

    line: int
    robot: str
    pick: str
    drop: str
    start: str
    end: str
    cells: int


def _trips(path: Path, table: Iterator[tuple[int, list[str]]], header: list[str]) -> list[_Trip]:
    """Return the rows of a file; raises ReportError where there are more than a log has."""
    ranks, rows = [header.index(name) for name in COLUMNS], list[_Trip]()
    for line, cells in table:
        if not cells:
            continue
        if len(rows) == LIMITS["trips"][0]:
            raise ReportError(f"{path}: too many rows, expected at most {LIMITS['trips'][0]:,}; split the file by days")
        robot, pick, drop, start, end = (cells[rank] if rank < len(cells) else "" for rank in ranks)
        rows.append(_Trip(line, intern(robot), intern(pick), intern(drop), start.strip(), end.strip(), len(cells)))
    return rows


def _timed(rows: list[_Trip], slashes: Slashes | None, collector: Collector) -> Iterator[tuple[_Trip, float, float]]:
    """Yield trips with start and end (s), both columns read in the one way that fits them."""
    read = read_times([row.start for row in rows] + [row.end for row in rows], slashes)
    collector.notes.assumed += [f"times: each column {note}" for note in read.notes]
    starts, ends = read.clocks[: len(rows)], read.clocks[len(rows) :]
    across_midnight(starts)
    end_across_midnight(starts, ends)
    read.clocks = starts + ends
    times = read.since_1970()
    yield from zip(rows, times[: len(rows)], times[len(rows) :], strict=True)
