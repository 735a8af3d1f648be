"""Measured times from a column of a table."""

from __future__ import annotations

import csv
import math
from typing import TYPE_CHECKING

from desim_warehouse.errors import StudyError, got, nearest, reason

if TYPE_CHECKING:
    from pathlib import Path

MOST_PROBLEMS = 20
"""Problems of one file that are listed."""


def read_times(path: Path, column: str) -> list[float]:
    """The times in a column of a CSV file, without empty cells.

    Raises:
        StudyError: no such file or column, or cells that are no times: the first 20 of them, by row and column.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as lines:
            rows = csv.DictReader(lines, skipinitialspace=True)
            names = rows.fieldnames or []
            if column not in names:
                near = nearest(column, names)
                hint = f"; did you mean '{near}'?" if near else ""
                raise StudyError(f"{path}: no column '{column}' (it has {', '.join(names) or 'none'}){hint}")
            cells = [(rows.line_num, row[column]) for row in rows if row[column]]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise StudyError(f"{path}: cannot be read ({reason(error)}), expected a CSV file") from error
    times, problems = [], []
    for line, cell in cells:
        try:
            time = float(cell)
        except ValueError:
            time = math.nan
        if not 0 <= time < math.inf:
            problems.append(f"{path}:{line}: {column}: not a time (got {got(cell)}), expected a number of at least 0")
        times.append(time)
    if len(problems) > MOST_PROBLEMS:
        problems[MOST_PROBLEMS:] = [f"{path}: and {len(problems) - MOST_PROBLEMS} more"]
    if problems:
        raise StudyError("\n".join(problems))
    return times
