"""Trips of a fleet from a CSV file: where each load was picked and put down, and when."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable
from pathlib import Path

from desim_warehouse.errors import ReportError, got, nearest, reason
from desim_warehouse.fleet_log.table import DROP, PICK, Collector, FleetLog
from desim_warehouse.fleet_log.vda5050 import seconds
from desim_warehouse.values.dates import (
    SLASHES,
    ZONE,
    Slashes,
    are_days_of_excel,
    of_excel,
    read_dates,
    settled,
)

_ZONED = re.compile(ZONE)
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
            table = list(rows)
            start_of, end_of = (_times([row.get(name) or "" for row in table], slashes) for name in ("start", "end"))
            for number, row in enumerate(table, 2):
                try:
                    if None in row.values() or None in row:
                        raise ValueError(f"a row with other than {len(rows.fieldnames or ())} cells")  # noqa: TRY301
                    start, end = start_of(row["start"]), end_of(row["end"])
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


def _times(column: list[str], slashes: Slashes | None) -> Callable[[str], float]:
    """How a column of times is read: seconds, ISO dates, days of Excel, or dates as people write them."""
    import pandas as pd

    texts = pd.Series(list(dict.fromkeys(column)), dtype=object).str.strip()
    numbers = pd.to_numeric(texts, errors="coerce")
    if numbers.notna().all() and are_days_of_excel(numbers.to_numpy(dtype=float)):
        dates = of_excel(texts)
    else:
        slashes = slashes or settled(texts)
        dates = read_dates(texts.where(numbers.isna(), ""), slashes)
    known = dict(zip(dict.fromkeys(column), dates, strict=True))

    def read(text: str) -> float:
        date = known[text]
        if pd.notna(date) and _ZONED.search(text) is None:
            return seconds(date.isoformat())
        if slashes is None and SLASHES.match(text.strip()):
            raise ValueError(
                f"a date that may be meant in two ways (got {got(text)}), expected --dates us or uk to say"
            )
        try:
            number = float(text)
        except ValueError:
            return seconds(text)
        return seconds(number)

    return read
