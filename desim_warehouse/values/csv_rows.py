"""Rows of CSV text, for every table that is read: a text with two readings is refused.

A quote that opens a cell may be meant as text, such as an inch sign. It then swallows all rows up to the next quote,
and the rest would still be a table.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator

_CURE = "write a quote in a cell twice, and the cell in quotes"


def csv_rows(
    lines: Iterable[str], delimiter: str = ",", *, skip_spaces: bool = False
) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows of CSV text, each with the number of its last line.

    Args:
        lines: of a file that was opened with `newline=""`.
        delimiter: what separates cells.
        skip_spaces: whether spaces before a cell are left out.

    Raises:
        csv.Error: a quoted cell that does not end with its quote, or one whose lines are rows if quotes are text. It
            names the line in which the row begins.
    """
    reader = csv.reader(lines, delimiter=delimiter, strict=True, skipinitialspace=skip_spaces)
    begin, width = 1, 0
    while True:
        try:
            cells = next(reader, None)
        except csv.Error as error:
            raise csv.Error(
                f"line {begin}: a cell that begins with a quote does not end with it ({error}); {_CURE}"
            ) from None
        if cells is None:
            return
        width = max(width, len(cells))
        if (reader.line_num > begin or len(cells) < width) and _are_rows(cells, delimiter, width):
            ways = "one row with a quoted cell, or rows of which two have a quote as text"
            raise csv.Error(f"line {begin}: two readings up to line {reader.line_num}: {ways}; {_CURE}")
        yield reader.line_num, cells
        begin = reader.line_num + 1


def _are_rows(cells: list[str], delimiter: str, width: int) -> bool:
    """Whether the first and the last line of a row are whole rows themselves where quotes are text."""
    first, *others = re.split("[\r\n]", delimiter.join(cells))
    return bool(cells) and all(line.count(delimiter) == width - 1 for line in (first, *others[-1:]))
