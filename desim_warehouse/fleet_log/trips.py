"""Trips of a fleet from a CSV file: where each load was picked and put down, and when."""

from __future__ import annotations

import csv
import math
from pathlib import Path

from desim_warehouse.errors import ReportError, got, nearest, reason
from desim_warehouse.fleet_log.table import DROP, PICK, Collector, FleetLog
from desim_warehouse.fleet_log.vda5050 import seconds

COLUMNS = ("robot", "pick", "drop", "start", "end")


def read_trips(path: Path) -> FleetLog:
    """The trips of a CSV file with columns robot, pick, drop (nodes), start and end (seconds, or ISO dates).

    Each makes two rows: a pick where it starts and a drop where it ends. Bad rows are noted.

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
            for row in rows:
                try:
                    if None in row.values() or None in row:
                        raise ValueError(f"a row with other than {len(rows.fieldnames or ())} cells")  # noqa: TRY301
                    start, end = _time(row["start"]), _time(row["end"])
                    if end < start:
                        raise ValueError(f"it ends before it starts (got {got(row['end'])})")  # noqa: TRY301
                except ValueError as error:
                    found.notes.refuse(f"{path}:{rows.line_num}", str(error))
                    continue
                found.add(start, row["robot"], math.nan, math.nan, row["pick"], False, True, PICK, math.nan, False)
                found.add(end, row["robot"], math.nan, math.nan, row["drop"], False, False, DROP, math.nan, False)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ReportError(f"{path}: cannot be read ({reason(error)}), expected a CSV file of trips") from error
    return found.log(trips=True)


def _time(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        return seconds(text)
    return seconds(number)
