"""Reading the table of orders in an export as text: CSV with any delimiter, Parquet, Excel.

For `desim orders`.

Encoding, separator, header row, and columns by common headings are inferred where the file does not state them, and
reported in words. A file is read unambiguously or refused, as a wrong guess would go unnoticed. Common headings are
tried only if there is no column `release`. The whole file is held in memory, so that a column is interpreted by all of
its rows: at most a million rows and 200 MB of text.
"""

from __future__ import annotations

import codecs
import csv
import io
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING

from desim_warehouse.errors import ModelError, first_of, got, nearest
from desim_warehouse.model.sections.flows import ORDER_COLUMNS
from desim_warehouse.model.sections.orders import EXCEL, PARQUET, check_there, framed, parquet_chunks, unreadable
from desim_warehouse.model.workbook import rows_of, sheets_of
from desim_warehouse.values.csv_rows import csv_rows
from desim_warehouse.values.fields import LIMITS
from desim_warehouse.values.headings import heading

if TYPE_CHECKING:
    import pandas as pd

HEADINGS = {
    "release": "release released created createdat creationdate orderdate ordertime timestamp datetime date time "
    "anlagedatum auftragsdatum bestelldatum erstellt erstelltam eingang freigabe datum zeitpunkt zeit erdat",
    "clock": "time ordertime creationtime uhrzeit zeit anlagezeit erzet",
    "from": "from source sourcebin pickfrom picklocation location bin storagebin storagelocation lagerplatz platz "
    "vonplatz von quelle quellplatz entnahmeplatz vlpla",
    "to": "to target destination station workstation nachplatz nach ziel zielplatz packplatz nlpla",
    "due": "due dueat duedate duetime deadline cutoff fällig fälligam faellig liefertermin termin versandzeit",
    "priority": "priority prio priorität prioritaet dringlichkeit",
    "quantity": "quantity qty pieces amount units menge anzahl stück stueck stk",
    "order": "order orderid orderno ordernr ordernumber auftrag auftragsnr auftragsnummer bestellnr bestellnummer "
    "bestellung belegnr belegnummer beleg vbeln",
}
"""Headings of our columns in files, in letters and digits alone; `clock`: the time of day in a column of its own.

They are tried only for files without a column `release`, so never for tables in our own format.
"""
_HEAD = 20  # rows in which the header is searched
_SAMPLE = 65_536  # bytes that show the format of a file
_OTHERS = {
    b"PK\x03\x04": "a workbook or another zip file; save it as .xlsx or CSV",
    b"\xd0\xcf\x11\xe0": "a workbook of Excel before 2007; save it as .xlsx",
    b"<": "a web page or XML; open it in a spreadsheet program, and save it as .xlsx or CSV",
    b"{": "JSON; save it as CSV",
    b"[": "JSON; save it as CSV",
}
"""Files that are no CSV, by their first bytes: what they are, and what helps."""
_MIDNIGHT = r"[ T]00:00:00(\.0+)?$"


@dataclass(frozen=True)
class Export:
    """A table as another program wrote it.

    Attributes:
        cells: text, by our columns, and by their ranks for `unread` ones; the index has the row numbers, from 1.
        titles: what the file calls the columns.
        assumed: what the file does not say.
        decimal_comma: whether numbers may have one.
    """

    cells: pd.DataFrame
    titles: dict[str | int, str]
    unread: tuple[int, ...]
    assumed: tuple[str, ...]
    decimal_comma: bool


def read_export(path: Path, columns: Mapping[str, str], sheet: str | None) -> Export:
    """Read the table of orders in an export as text.

    Args:
        path: of CSV, Parquet or Excel.
        columns: what the file calls our columns, where that is not to be looked for.
        sheet: of an Excel file; None for the first.

    Raises:
        ModelError: where it cannot be read, or has no column of releases.
    """
    check_there(path)
    if path.suffix.lower() not in {*PARQUET, *EXCEL} and path.stat().st_size > LIMITS["texts"][0]:
        raise ModelError([f"{path}: too large, expected CSV of at most {LIMITS['texts'][0] / 1e6:,.0f} MB"])
    if sheet is not None and path.suffix.lower() not in EXCEL:
        raise ModelError([f"{path}: sheet (got {got(sheet)}) of a file that is no Excel file, expected none"])
    for ours in columns:
        if ours not in ORDER_COLUMNS:
            raise ModelError([f"--map {ours}: unknown column, expected one of {', '.join(ORDER_COLUMNS)}"])
    try:
        if path.suffix.lower() in PARQUET:
            return _made(path, columns, _of_parquet(path, columns))
        _check_kind(path)
        if path.suffix.lower() in EXCEL:
            sheets = sheets_of(path)
            several = [f"sheet {got(sheets[0])}, the first of {len(sheets)}"] if sheet is None and sheets[1:] else []
            export = _made(path, columns, rows_of(path, sheet), sheet=sheet)
            return replace(export, assumed=(*several, *export.assumed))
        encoding = _encoding(path)
        delimiter = _delimiter(path, columns, encoding)
        return _made(path, columns, _of_text(path, encoding, delimiter), encoding, delimiter)
    except (OSError, ValueError, KeyError, csv.Error, zipfile.BadZipFile) as error:
        raise ModelError([unreadable(path, error, "CSV, Parquet or Excel (.xlsx)")]) from None


def _check_kind(path: Path) -> None:
    """Raise ValueError for a file that is neither a workbook, as its name says, nor text with cells."""
    with path.open("rb") as file:
        start = file.read(64).removeprefix(codecs.BOM_UTF8).lstrip()
    other = next((other for first, other in _OTHERS.items() if start.startswith(first)), "")
    is_workbook = path.suffix.lower() in EXCEL
    if bool(other) != is_workbook or (is_workbook and not start.startswith(b"PK")):
        raise ValueError(other or "text; call it .csv")


def _made(
    path: Path,
    columns: Mapping[str, str],
    rows: Iterator[Sequence[str]],
    encoding: str = "",
    delimiter: str = ",",
    sheet: str | None = None,
) -> Export:
    """Make an export of the rows below the header, with assumptions in words."""
    head, names, ranks = _header(top := [*islice(rows, _HEAD)], columns)
    if len(names) > LIMITS["columns"][0]:
        raise ValueError(f"{len(names):,} columns, expected at most {LIMITS['columns'][0]:,}")
    for ours in ("release", *columns):
        if ours not in ranks:
            raise _missing(path, ours, columns, names, sheet)
    if twice := [names[rank] for rank in ranks.values() if names.count(names[rank]) > 1]:
        text = f"column {got(twice[0])} given twice, expected it once"
        raise ModelError([f"{path}: {text}; desim orders --map says which other is meant"])
    meant = [f"'{names[rank]}' is {ours}" for ours, rank in ranks.items() if heading(names[rank])[0] != ours]
    assumed = [", ".join(meant)] if meant and not columns else []
    assumed += [f"encoding {encoding}"] if encoding == "cp1252" else []
    assumed += [f"cells end with {delimiter!r}"] if delimiter != "," else []
    assumed += [f"the header is row {head + 1}"] if head else []
    labels = {rank: ours for ours, rank in ranks.items()}
    cells = framed(_limited(path, chain(top[head + 1 :], rows)), [labels.get(n, n) for n in range(len(names))], 1)
    titles: dict[str | int, str] = {labels.get(n, n): name or f"column {n + 1}" for n, name in enumerate(names)}
    others = [rank for rank in range(len(names)) if rank not in labels]
    unread = tuple(rank for rank in others if names[rank] or (cells[rank] != "").any())
    return Export(_whole(cells, [*ranks]), titles, unread, tuple(assumed), delimiter != ",")


def _whole(cells: pd.DataFrame, ours: list[str]) -> pd.DataFrame:
    """Keep the rows that are not empty; join date and time of day where they stand in two columns."""
    cells = cells[(cells[ours] != "").any(axis=1)]
    if "clock" not in ours:
        return cells
    days = cells["release"].str.replace(_MIDNIGHT, "", regex=True)
    return cells.assign(release=(days + " " + cells["clock"]).str.strip()).drop(columns="clock")


def _limited(path: Path, rows: Iterable[Sequence[str]]) -> Iterator[Sequence[str]]:
    """Yield rows; raises ModelError for too many, ValueError for more text than may be held at once."""
    most, size = LIMITS["tasks"][0], 0
    for number, row in enumerate(rows):
        size += sum(map(len, row))
        if number >= most:
            raise ModelError([f"{path}: too many rows, expected at most {most:,}; split the file by days"])
        if size > LIMITS["texts"][0]:
            raise ValueError(f"more than {LIMITS['texts'][0] / 1e6:,.0f} MB of texts")
        yield row


def _of_text(path: Path, encoding: str, delimiter: str) -> Iterator[list[str]]:
    with path.open(encoding=encoding, newline="") as lines:
        yield from (cells for _, cells in csv_rows(lines, delimiter))


def _of_parquet(path: Path, columns: Mapping[str, str]) -> Iterator[Sequence[str]]:
    """Yield the header and the rows; unread columns only where they are text, numbers or times."""
    from pyarrow import parquet, types

    schema = parquet.read_schema(path)
    _, _, ranks = _header([schema.names], columns)
    others = types.is_nested, types.is_binary, types.is_large_binary, types.is_fixed_size_binary, types.is_duration
    names = [
        field.name
        for rank, field in enumerate(schema)
        if rank in ranks.values() or not any(is_other(field.type) for is_other in others)
    ]
    yield names
    for _, cells in parquet_chunks(path, names):
        yield from zip(*cells, strict=True)


def _delimiter(path: Path, columns: Mapping[str, str], encoding: str) -> str:
    """Return the separator of cells: the one with which there is a column of releases, and the most columns."""
    with path.open(encoding=encoding, newline="") as lines:
        sample = lines.read(_SAMPLE)
    if "\0" in sample:
        raise ValueError("no text, or UTF-16 without its mark; save it as CSV UTF-8")

    def columns_with(delimiter: str) -> tuple[bool, int]:
        top = islice(csv.reader(io.StringIO(sample, newline=""), delimiter=delimiter), _HEAD)
        _, names, ranks = _header([*top], columns)
        return "release" in ranks, len(names)

    return max(",;\t|", key=columns_with)


def _encoding(path: Path) -> str:
    """Return the encoding of a file: UTF-8 if valid, UTF-16 with its byte order mark, else Windows-1252."""
    with path.open("rb") as file:
        start = file.read(2)
        if start in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
            return "utf-16"
        decoder = codecs.getincrementaldecoder("utf-8-sig")()
        try:
            for block in iter(lambda: file.read(1 << 20), b""):
                decoder.decode(start + block)
                start = b""
            decoder.decode(start, final=True)
        except UnicodeDecodeError:
            return "cp1252"
    return "utf-8-sig"


def _header(top: Sequence[Sequence[str]], columns: Mapping[str, str]) -> tuple[int, list[str], dict[str, int]]:
    """Find the header: its rank, headings, and ranks of our columns.

    It is the row with a column of releases, and of several, such as `Date;2026-03-02` above a table, the first with
    most of our columns. Where none has one it is the first row, and no column is ours.
    """
    rows = [[" ".join(title.split()) for title in row] for row in top]
    heads = [(head, names, ranks) for head, names in enumerate(rows) if "release" in (ranks := _ours(names, columns))]
    return max(heads, key=lambda row: len(row[2])) if heads else (0, rows[0] if rows else [], {})


def _missing(path: Path, ours: str, columns: Mapping[str, str], names: Sequence[str], sheet: str | None) -> ModelError:
    """Return the error of a table without a column; of a workbook, it names the other sheets."""
    sheets = sheets_of(path) if path.suffix.lower() in EXCEL else []
    place, others = "", ""
    if len(sheets) > 1:
        read = sheet or sheets[0]
        place = f" in sheet {got(read)}"
        others = f"; --sheet reads another: {first_of([got(name) for name in sheets if name != read], 8)}"
    name = columns.get(ours, ours)
    if not any(names):
        return ModelError([f"{path}: empty{place}, expected a header with a column '{name}'{others}"])
    near = nearest(name, names)
    cure = f"did you mean '{near}'?" if near else f"desim orders --map {ours}=HEADING says what the file calls it"
    headings = first_of([got(title) for title in names if title], 8)
    return ModelError([f"{path}: no column '{name}'{place} (it has {headings}); {cure}{others}"])


def _ours(names: Sequence[str], columns: Mapping[str, str]) -> dict[str, int]:
    """Find the ranks of our columns in a header.

    Unlike columns of plants (`plants.records`) they are guessed only if no heading is our `release`. A second candidate
    for a column is left unread, and guesses are reported.
    """
    exact = {ours: columns.get(ours, ours) for ours in ORDER_COLUMNS}
    ranks = {ours: names.index(theirs) for ours, theirs in exact.items() if theirs in names}
    if "release" in ranks or "release" in columns:
        return ranks
    plain = [heading(name)[0] for name in names]
    for ours, text in HEADINGS.items():
        rank = next((plain.index(word) for word in text.split() if word in plain), None)
        if ours not in ranks and rank is not None and rank not in ranks.values():
            ranks[ours] = rank
    return ranks
