"""Rows of a workbook of Excel; a huge one is refused by the sizes in its directory before it is opened.

That is 100 times its size unfolded, or 1 GB, or 200 MB of texts. Then a stream looks for cells and rows longer than
Excel writes. A file of 588 kB with one cell of 600 MB took 1.7 GB; now it takes 0.13 GB, as any command does.
"""

from __future__ import annotations

import datetime as dt
import re
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from itertools import chain
from pathlib import Path
from typing import Any

from desim_warehouse.errors import ModelError, did_you_mean, got, reason
from desim_warehouse.values.fields import LIMITS

NO_VALUE = "a formula without a stored value"
"""Text of a cell whose formula was never calculated, as other programs than Excel write them."""
RECALCULATE = "open and save the file in Excel"
"""Cure for it."""
_LARGEST_PART = 10_000_000  # bytes: larger parts may not unfold to too many times their size
_FOLDED = 100  # times; sheets of orders are some 5 to 25
_LARGEST_CELL = 1_000_000  # bytes; Excel writes 32,767 characters at most
_LARGEST_ROW = 20  # megabytes
_ROW = re.compile(rb"<(?:\w+:)?(?:row|si)\b")
_FORMULA = re.compile(rb"<(?:\w+:)?f[ />]")
_MERGED = re.compile(rb'<mergeCell ref="([A-Z]{1,3})(\d{1,7}):([A-Z]{1,3})(\d{1,7})"')


def rows_of(path: Path, sheet: str | None) -> Iterator[list[str]]:
    """Yield the rows of a sheet, by default the first, as text; formulas with the values last computed, or `NO_VALUE`.

    Cells that are merged downwards all have the value of the first.

    Raises:
        ModelError: where there is no such sheet, or openpyxl is not installed. ValueError: for what is damaged or huge.
    """
    with _opened(path) as book:
        yield from _filled(path, book, sheet)


def sheets_of(path: Path) -> list[str]:
    """Return the names of the sheets of a workbook; raises errors as `rows_of` does."""
    with _opened(path) as book:
        return list(book.sheetnames)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Open a workbook that is read row by row, after a check of its sizes."""
    try:
        from openpyxl import load_workbook
    except ImportError:
        cure = "install it: pip install 'desim-warehouse[excel]'"
        raise ModelError([f"{path}: a workbook of Excel, which needs the package openpyxl; {cure}"]) from None
    _check_sizes(path)
    try:
        with (
            path.open("rb") as file,
            closing(load_workbook(file, read_only=True, data_only=True, keep_links=False)) as book,
        ):
            yield book
    except (KeyError, TypeError, AttributeError, SyntaxError, EOFError, zlib.error) as error:
        raise ValueError(f"damaged: {reason(error)}") from None


def _filled(path: Path, book: Any, sheet: str | None) -> Iterator[list[str]]:
    """Yield the rows of a sheet, with the first value in all cells that are merged downwards."""
    names = book.sheetnames
    name = sheet or names[0]
    if name not in names:
        hint = did_you_mean(name, names)
        raise ModelError([f"{path}: no sheet {got(name)}, expected one of its {len(names)} sheets{hint}"])
    above: dict[int, tuple[int, Any]] = {}
    rows = book[name]
    below, formulas = _merged(path, rows._worksheet_path), _not_computed(path, rows._worksheet_path)  # noqa: SLF001
    rows.reset_dimensions()  # which the file says, and with which rows of nothing are 16,384 cells
    for rank, row in enumerate(rows.iter_rows(values_only=True), 1):
        cells = _without_end(row)
        for column in formulas.get(rank, ()):
            cells += [None] * (column + 1 - len(cells))
            cells[column] = NO_VALUE
        for column, (last, value) in above.items():
            if rank <= last:
                cells += [None] * (column + 1 - len(cells))
                cells[column] = value if cells[column] is None else cells[column]
        above |= {column: (last, cells[column]) for column, last in below.get(rank, ()) if column < len(cells)}
        yield [_text(cell) for cell in cells]


def _text(cell: Any) -> str:
    """Return the text of a cell; a duration beyond a day (`[h]:mm`) has all of its hours."""
    if isinstance(cell, dt.timedelta):
        minutes, seconds = divmod(round(cell.total_seconds()), 60)
        return f"{minutes // 60:02}:{minutes % 60:02}:{seconds:02}"
    return "" if cell is None else str(cell)


def _without_end(row: Sequence[Any]) -> list[Any]:
    """Cells of a row up to the last that is not empty; raises ValueError for too many."""
    width = len(row)
    while width and row[width - 1] is None:
        width -= 1
    if width > LIMITS["columns"][0]:
        raise ValueError(f"a row of {width:,} cells, expected at most {LIMITS['columns'][0]:,}")
    return list(row[:width])


def _check_sizes(path: Path) -> None:
    """Refuse a workbook that would take gigabytes of memory; raises ValueError."""
    with zipfile.ZipFile(path) as file:
        parts = {part.filename: part for part in file.infolist()}
        sizes = {name: part.file_size for name, part in parts.items()}
        folded = any(part.file_size > max(_LARGEST_PART, _FOLDED * part.compress_size) for part in parts.values())
        at_once = sum(sizes.get(f"xl/{name}.xml", 0) for name in ("sharedStrings", "styles", "workbook"))
        if folded or sum(sizes.values()) > LIMITS["sheet"][0] or at_once > LIMITS["texts"][0]:
            raise ValueError("too large when it is unfolded")
        for name, size in sizes.items():
            if size > _LARGEST_CELL and name.startswith(("xl/worksheets/", "xl/sharedStrings")):
                with file.open(name) as content:
                    _check_cells(content)


def _check_cells(content: Any) -> None:
    """Refuse a part of a workbook with a text longer than any cell, or a row longer than any row."""
    length, blocks = 0, 0
    for block in iter(lambda: content.read(1 << 20), b""):
        first, *others = map(len, block.split(b"<"))
        blocks = 0 if _ROW.search(block) else blocks + 1
        if max(length + first, *others, 0) > _LARGEST_CELL or blocks > _LARGEST_ROW:
            raise ValueError("a cell or row longer than Excel writes them")
        length = others[-1] if others else length + first


def _not_computed(path: Path, part: str) -> dict[int, list[int]]:
    """Cells with a formula and no value, by the row (from 1): the columns (from 0)."""
    from openpyxl.utils.cell import coordinate_to_tuple
    from openpyxl.xml.functions import iterparse

    columns: dict[int, list[int]] = {}
    with zipfile.ZipFile(path) as file:
        with file.open(part) as content:
            if not any(map(_FORMULA.search, iter(lambda: content.read(1 << 20), b""))):
                return columns
        with file.open(part) as content:
            for _, element in iterparse(content):
                kind = element.tag.rpartition("}")[2]
                if kind == "c" and element.get("r") and element.get("t") != "str":  # an empty text is a value
                    values = {child.tag.rpartition("}")[2]: child.text for child in element}
                    if "f" in values and not values.get("v"):
                        row, column = coordinate_to_tuple(element.get("r", ""))
                        columns.setdefault(row, []).append(column - 1)
                elif kind == "row":
                    element.clear()
    return columns


def _merged(path: Path, part: str) -> dict[int, list[tuple[int, int]]]:
    """Cells merged downwards, by the row (from 1) in which they begin: the column (from 0) and the last row."""
    from openpyxl.utils import column_index_from_string

    merged: dict[int, list[tuple[int, int]]] = {}
    with zipfile.ZipFile(path) as file, file.open(part) as content:
        before = b""
        for block in chain(iter(lambda: content.read(1 << 20), b""), [b""]):
            for left, top, _, bottom in _MERGED.findall(before + block):
                if int(bottom) > int(top):
                    column = column_index_from_string(left.decode()) - 1
                    merged.setdefault(int(top), []).append((column, int(bottom)))
            before = (before + block)[-60:] if not _MERGED.search((before + block)[-60:]) else b""
    return merged
