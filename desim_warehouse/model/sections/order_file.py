"""The table of a file of orders, as a WMS or ERP writes it: CSV with whatever stands between cells, Parquet, Excel.

What the file does not say is found out and kept as words: encoding, separator, the row of the header, columns by
common headings. Rows come in chunks, as text or dates, so a file of any length takes the same memory.

A file is read in one way or refused, as a guess would be wrong in silence. Common headings are looked for only where
there is no column `release`, so no file that a model read before is read otherwise. Times have no zone, as the
calendars of the hall have none; a column with two is refused, so an export over the night in which clocks change has
to be written by the hall's clock. A column has one reading of points and commas. Row by row `2.5` beside `1,5` was
2.5 beside 1.5, and `1.234` beside `2.5` was 1,234. Going by the language of the headings was rejected, which are
often English in German exports. Where only `1.234` stands it is 1,234, as SAP writes it, and that is said. Rows in no
order are sorted in memory, which a million of them allow, and there may be no more.

A workbook is refused by the sizes in its directory, before it is opened: 100 times its size unfolded, or 1 GB, or 200
MB of texts. Then a stream looks for cells and rows longer than Excel writes. A file of 588 kB with one cell of 600 MB
took 1.7 GB; now it takes 0.13 GB, as any command does.
"""

from __future__ import annotations

import codecs
import csv
import io
import re
import zipfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import ModelError, got, nearest, reason
from desim_warehouse.model.sections.flows import ORDER_COLUMNS, OrdersFile
from desim_warehouse.values.fields import LIMITS
from desim_warehouse.values.headings import heading

if TYPE_CHECKING:
    import pandas as pd

CHUNK = 50_000
"""Rows read at a time."""
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
"""What files call our columns, in letters and digits alone; `clock`: the time of day where it has a column of its own.

They are looked for where a file has no column `release`, so in none that is written in our words.
"""
_HEAD = 20  # rows in which the header is looked for
_SAMPLE = 65_536  # bytes that show how a file is written
_LARGEST_PART = 10_000_000  # bytes from which on a part of it may not unfold to too many times its size
_FOLDED = 100  # times; sheets of orders are some 5 to 25
_LARGEST_CELL = 1_000_000  # bytes; Excel writes 32,767 characters at most
_LARGEST_ROW = 20  # megabytes
BEYOND, REST = "\0beyond", "\0rest"
"""The columns of a chunk with what stands in cells beyond the header, and in columns that are not read."""
BETWEEN = "\x1f"
"""Between the cells of columns that are not read."""
_ROW = re.compile(rb"<(?:\w+:)?(?:row|si)\b")
_MERGED = re.compile(rb'<mergeCell ref="([A-Z]{1,3})(\d{1,7}):([A-Z]{1,3})(\d{1,7})"')
MOST_PROBLEMS = 20
"""Kinds of problems of one file that are listed."""
_DISTINCT, _COMMON = 1000, 5  # values of a kind of problem that are told apart, and that are shown


@dataclass(frozen=True)
class Table:
    """How a file is written: our names of the columns that are read, by their ranks, and what was `assumed`.

    `twice`: headings of such columns that stand there more than once. `unread`: the others, by their ranks.
    """

    path: Path
    columns: dict[int, str]
    titles: dict[str, str]
    head: int = 0
    width: int = 0
    encoding: str = "utf-8-sig"
    delimiter: str = ","
    assumed: tuple[str, ...] = ()
    twice: tuple[str, ...] = ()
    unread: Mapping[int, str] = field(default_factory=dict)

    @property
    def decimal_comma(self) -> bool:
        """Whether numbers in cells may have a decimal comma."""
        return self.delimiter != ","


def table_of(spec: OrdersFile) -> Table:
    """How a file is written; raises ModelError where it cannot be read, or has no column of releases."""
    path = Path(spec.file)
    check_there(path)
    if spec.sheet is not None and not _is(path, ".xlsx", ".xlsm"):
        raise ModelError([f"{path}: sheet (got {got(spec.sheet)}) of a file that is no Excel file, expected none"])
    table = _table(path, spec)
    if table.twice:
        text = f"column {got(table.twice[0])} given twice, expected it once"
        raise ModelError([f"{path}: {text}; desim orders --map says which other is meant"])
    return table


def raw(spec: OrdersFile, table: Table) -> tuple[str, ...]:
    """In what a file is another than `desim orders` writes, as far as its header and the model show."""
    needs = [name for name in ("columns", "sheet", "dates") if getattr(spec, name)]
    needs += ["quantity: pieces"] if spec.quantity == "pieces" else []
    said = (f"it needs {', '.join(needs)}",) if needs else ()
    return (*said, *("a workbook",) * _is(table.path, ".xlsx", ".xlsm"), *table.assumed)


def options(spec: OrdersFile, table: Table) -> list[str]:
    """The options with which `desim orders` reads a file as a model does that names it."""
    said = [word for ours, theirs in spec.columns.items() for word in ("--map", f"{ours}={theirs}")]
    for name in ("sheet", "dates"):
        said += [] if getattr(spec, name) is None else [f"--{name}", getattr(spec, name)]
    said += ["--quantity", "tasks"] if "quantity" in table.titles and spec.quantity == "tasks" else []
    return said + ([] if spec.pieces_per_load is None else ["--pieces-per-load", str(spec.pieces_per_load)])


def _table(path: Path, spec: OrdersFile) -> Table:
    try:
        if _is(path, ".parquet", ".pq"):
            from pyarrow import parquet

            with parquet.ParquetFile(path) as file:
                found = _headed(path, spec, [file.schema_arrow.names])
                _check_groups(file)
                for rank in found.columns:
                    _check_kind(path, file.schema_arrow.field(rank))
                return found
        if _is(path, ".xlsx", ".xlsm"):
            return _headed(path, spec, islice(_sheet(spec), _HEAD))
        encoding = _encoding(path)
        with path.open(encoding=encoding, newline="") as lines:
            sample = lines.read(_SAMPLE)
        if "\0" in sample:
            raise ValueError("not text")  # noqa: TRY301 - said with the others
        best: Table | ModelError | None = None
        for delimiter in ",;\t|":
            rows = islice(csv.reader(io.StringIO(sample, newline=""), delimiter=delimiter), _HEAD)
            try:
                found = _headed(path, spec, list(rows), encoding, delimiter)
            except ModelError as error:
                best = best or error
                continue
            if not isinstance(best, Table) or found.width > best.width:
                best = found
        if isinstance(best, Table):
            return best
        assert best is not None
        raise best
    except (OSError, ValueError, KeyError, csv.Error, zipfile.BadZipFile) as error:
        raise ModelError([_unread(path, error)]) from None


def chunks(spec: OrdersFile, table: Table, *, rest: bool = False) -> Iterator[pd.DataFrame]:
    """The rows that are not empty, in chunks of our columns, numbered from 1; raises ModelError if they cannot be.

    `rest`: with what stands in the other columns, too.
    """
    path = table.path
    try:
        if _is(path, ".parquet", ".pq"):
            from pyarrow import parquet

            with parquet.ParquetFile(path, read_dictionary=_of_text(path)) as file:
                names = [file.schema_arrow.names[rank] for rank in table.columns]
                others = _plain_columns(file.schema_arrow, table) if rest else []
                begin = 1
                for batch in file.iter_batches(CHUNK, columns=[*names, *others]):
                    whole = _texts(batch).to_pandas()
                    frame = whole[names].set_axis([*table.columns.values()], axis=1)
                    if others:
                        frame[REST] = whole[others].astype(str).agg(BETWEEN.join, axis=1)
                    yield _whole(frame.set_axis(range(begin, begin + len(frame))))
                    begin += len(frame)
        elif _is(path, ".xlsx", ".xlsm"):
            yield from _rows(table, _sheet(spec), rest=rest)
        else:
            with path.open(encoding=table.encoding, newline="") as lines:
                yield from _rows(table, csv.reader(lines, delimiter=table.delimiter), rest=rest)
    except (OSError, ValueError, KeyError, csv.Error, zipfile.BadZipFile) as error:
        raise ModelError([_unread(path, error)]) from None


def _check_kind(path: Path, field: Any) -> None:
    """Refuse a column of lists and the like."""
    from pyarrow import types

    if types.is_nested(field.type):
        text = f"column {got(field.name)} has lists or sections, expected text, numbers or times"
        raise ModelError([f"{path}: {text}"])


def _of_text(path: Path) -> list[str]:
    """The columns of a Parquet file that are read with each text once, so that a long one is not there many times."""
    from pyarrow import parquet, types

    schema = parquet.read_schema(path)
    kinds = types.is_string, types.is_large_string, types.is_binary, types.is_large_binary
    return [field.name for field in schema if any(is_text(field.type) for is_text in kinds)]


def _check_groups(file: Any) -> None:
    """Refuse a Parquet file with a column that would take gigabytes of memory; raises ValueError."""
    groups = map(file.metadata.row_group, range(file.metadata.num_row_groups))
    columns = (group.column(rank) for group in groups for rank in range(group.num_columns))
    if any(column.total_uncompressed_size > LIMITS["texts"][0] for column in columns):
        raise ValueError("too large when it is unfolded")


def _bytes_of(column: Any) -> int:
    """The bytes of all texts of a column, each as often as it is there."""
    import pyarrow as pa
    from pyarrow import compute

    if not pa.types.is_dictionary(column.type):
        return int(column.nbytes)
    words = column.dictionary
    if not (pa.types.is_binary(words.type) or pa.types.is_string(words.type)):
        return int(column.nbytes)
    return int(compute.sum(compute.take(compute.binary_length(words), column.indices)).as_py() or 0)


def _texts(batch: Any) -> Any:
    """Rows of Parquet with bytes as the text that they are; raises ValueError for bytes that are none."""
    import pyarrow as pa

    kinds = pa.types.is_binary, pa.types.is_large_binary, pa.types.is_fixed_size_binary
    columns = []
    if (size := sum(map(_bytes_of, batch.columns))) > LIMITS["texts"][0]:
        raise ValueError(f"{len(batch):,} rows have {size / 1e6:,.0f} MB of texts")
    for name, column in zip(batch.schema.names, batch.columns, strict=True):
        plain = column.dictionary_decode() if pa.types.is_dictionary(column.type) else column
        try:
            if any(is_bytes(plain.type) for is_bytes in kinds):
                plain = plain.cast(pa.binary()).cast(pa.string())
            plain.validate(full=True)
        except pa.ArrowInvalid:
            raise ValueError(f"column {got(name)} has bytes that are no text") from None
        columns.append(plain)
    return pa.RecordBatch.from_arrays(columns, batch.schema.names)


def _plain_columns(schema: Any, table: Table) -> list[str]:
    """The columns of a Parquet file that are not read, as far as they are text, numbers or times."""
    from pyarrow import types

    no_text = types.is_nested, types.is_binary, types.is_large_binary, types.is_fixed_size_binary
    kinds = {rank: schema.field(rank).type for rank in table.unread}
    kinds = {rank: kind.value_type if types.is_dictionary(kind) else kind for rank, kind in kinds.items()}
    return [name for rank, name in table.unread.items() if not any(one(kinds[rank]) for one in no_text)]


def _rows(table: Table, rows: Iterator[Sequence[Any]], *, rest: bool) -> Iterator[pd.DataFrame]:
    """The rows below the header, in chunks, numbered from 1."""
    import pandas as pd

    below, begin = islice(rows, table.head + 1, None), 1
    while some := list(islice(below, CHUNK)):
        width = table.width
        if any(len(row) != width for row in some):
            cells = [[row[rank] if rank < len(row) else None for row in some] for rank in table.columns]
            beyond = ["".join(str(cell) for cell in row[width:] if cell is not None) for row in some]
        else:
            columns = list(zip(*some, strict=True))
            cells, beyond = [list(columns[rank]) for rank in table.columns], []
        numbers = range(begin, begin + len(some))
        frame = pd.DataFrame(dict(zip(table.columns.values(), cells, strict=True)), numbers, dtype=object)
        begin += len(some)
        if rest and table.unread:
            ranks = list(table.unread)
            frame[REST] = [
                BETWEEN.join(
                    str(row[rank]).strip() if rank < len(row) and row[rank] is not None else "" for rank in ranks
                )
                for row in some
            ]
        yield _whole(frame.assign(**{BEYOND: beyond}) if any(beyond) else frame)


def _is(path: Path, *endings: str) -> bool:
    return path.suffix.lower() in endings


def _unread(path: Path, error: Exception) -> str:
    return f"{path}: cannot be read ({reason(error)}), expected orders in CSV, Parquet or Excel (.xlsx)"


def check_there(path: Path) -> Any:
    """The state of a file that is there; raises ModelError for what is not, or is no file."""
    try:
        if not path.is_file():
            raise FileNotFoundError(2, "no such file")
        return path.stat()
    except (OSError, ValueError) as error:
        raise ModelError([_unread(path, error)]) from None


def _whole(frame: pd.DataFrame) -> pd.DataFrame:
    """The rows that have anything in them; date and time of day in one column, if they stand in two."""
    without = frame[frame["release"].isna() | (frame["release"] == "")].drop(columns=REST, errors="ignore")
    empty = (without.isna() | without.isin([""])).all(axis=1)
    frame = frame.drop(without.index[empty])
    if "clock" in frame:
        clock = frame["clock"].map(lambda cell: "" if cell is None or cell != cell else str(cell))  # noqa: PLR0124
        days = frame["release"].map(lambda cell: cell.date() if hasattr(cell, "date") else cell)
        frame = frame.assign(release=(days.astype(str).where(days.notna(), "") + " " + clock).str.strip())
        frame = frame.drop(columns="clock")
    return frame


def _encoding(path: Path) -> str:
    """UTF-8 where the file is, UTF-16 where it says so, else what Windows writes in the west."""
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


def _headed(
    path: Path, spec: OrdersFile, rows: Iterable[Sequence[Any]], encoding: str = "utf-8-sig", delimiter: str = ","
) -> Table:
    """The table below the first row that has a column of releases."""
    rows = list(rows)
    for head, titles in enumerate(rows):
        names = [" ".join(str(title).split()) if title is not None else "" for title in titles]
        ranks = _ours(names, spec)
        if "release" in ranks:
            for ours in spec.columns:
                if ours not in ranks:
                    raise _missing(path, ours, spec, names)
            said = [f"'{names[rank]}' is {ours}" for ours, rank in ranks.items() if heading(names[rank])[0] != ours]
            assumed = [", ".join(said)] if said and not spec.columns else []
            assumed += _rivals(names, ranks, spec)
            assumed += [f"encoding {encoding}"] if encoding == "cp1252" else []
            assumed += [f"cells end with {delimiter!r}"] if delimiter != "," else []
            assumed += [f"the header is row {head + 1}"] if head else []
            columns = {rank: ours for ours, rank in sorted(ranks.items(), key=lambda item: item[1])}
            titles_of = {ours: names[rank] for ours, rank in ranks.items()}
            twice = tuple(name for name in titles_of.values() if names.count(name) > 1)
            unread = {rank: name for rank, name in enumerate(names) if name and rank not in columns}
            return Table(path, columns, titles_of, head, len(names), encoding, delimiter, tuple(assumed), twice, unread)
    names = [str(title) for title in rows[0]] if rows else []
    raise _missing(path, "release", spec, names)


def _rivals(names: Sequence[str], ranks: Mapping[str, int], spec: OrdersFile) -> list[str]:
    """Columns that are left though their heading may mean one of ours, too."""
    found = []
    for ours, rank in ranks.items():
        words = HEADINGS.get(ours, ours).split() if ours not in spec.columns else []
        others = [
            got(name)
            for other, name in enumerate(names)
            if heading(name)[0] in words and other not in ranks.values() and name != names[rank]
        ]
        if others:
            found.append(f"{got(names[rank])} is {ours}, and {', '.join(others)} left out")
    return found


def _missing(path: Path, ours: str, spec: OrdersFile, names: Sequence[str]) -> ModelError:
    name = spec.columns.get(ours, ours)
    near = nearest(name, names)
    hint = f"; did you mean '{near}'?" if near else ""
    cure = f"; desim orders --map {ours}=HEADING says what the file calls it" if not near else ""
    return ModelError([f"{path}: no column '{name}' (it has {len(names) or 'none'}){hint}{cure}"])


def _ours(names: Sequence[str], spec: OrdersFile) -> dict[str, int]:
    """The ranks of our columns in a header.

    Unlike columns of plants (`plants.records`) they are guessed only where no heading is our `release`. A second column
    that could be meant is left, and what was guessed is said.
    """
    exact = {ours: spec.columns.get(ours, ours) for ours in ORDER_COLUMNS}
    found = {ours: names.index(theirs) for ours, theirs in exact.items() if theirs in names}
    if "release" in found or "release" in spec.columns:
        return found
    plain = [heading(name)[0] for name in names]
    for ours, text in HEADINGS.items():
        rank = next((plain.index(word) for word in text.split() if word in plain), None)
        if ours not in found and rank is not None and rank not in found.values():
            found[ours] = rank
    return found


def _sheet(spec: OrdersFile) -> Iterator[tuple[Any, ...]]:
    """The rows of a sheet of a workbook: of each the values, those of formulas as they were last worked out.

    Cells that are merged downwards all have the value of the first.
    """
    path = Path(spec.file)
    try:
        from openpyxl import load_workbook
    except ImportError:
        cure = "install it: pip install 'desim-warehouse[excel]'"
        raise ModelError([f"{path}: orders in Excel, which need the package openpyxl; {cure}"]) from None
    _check_sizes(path)
    try:
        book = load_workbook(path, read_only=True, data_only=True, keep_links=False)
    except (KeyError, ValueError, TypeError, AttributeError, SyntaxError, EOFError) as error:  # of damaged XML
        raise ValueError(f"damaged: {reason(error)}") from None
    try:
        names = book.sheetnames
        name = spec.sheet or names[0]
        if name not in names:
            near = nearest(name, names)
            hint = f"; did you mean '{near}'?" if near else ""
            raise ModelError([f"{path}: no sheet {got(name)}, expected one of its {len(names)} sheets{hint}"])
        below = _merged(path, names.index(name) + 1)
        above: dict[int, tuple[int, Any]] = {}
        sheet = book[name]
        sheet.reset_dimensions()  # which the file says, and with which rows of nothing are 16,384 cells
        for rank, row in enumerate(sheet.iter_rows(values_only=True), 1):
            cells = _without_end(row)
            for column, (last, value) in list(above.items()):
                if rank > last:
                    del above[column]
                else:
                    cells += [None] * (column + 1 - len(cells))
                    cells[column] = value if cells[column] is None else cells[column]
            for column, last in below.get(rank, ()):
                if column < len(cells):
                    above[column] = last, cells[column]
            yield tuple(cells)
    except (KeyError, TypeError, AttributeError, SyntaxError, EOFError, zipfile.zlib.error) as error:  # type: ignore[attr-defined]
        raise ValueError(f"damaged: {reason(error)}") from None
    finally:
        book.close()


def _without_end(row: Sequence[Any]) -> list[Any]:
    """The cells of a row up to the last that has anything in it; raises ValueError for more than a table has."""
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


def _merged(path: Path, number: int) -> dict[int, list[tuple[int, int]]]:
    """Cells merged downwards, by the row in which they begin: the column, from 0, and the last row."""
    from openpyxl.utils import column_index_from_string

    found: dict[int, list[tuple[int, int]]] = {}
    with zipfile.ZipFile(path) as file:
        name = f"xl/worksheets/sheet{number}.xml"
        if name not in file.namelist():
            return found
        with file.open(name) as sheet:
            before = b""
            for block in chain(iter(lambda: sheet.read(1 << 20), b""), [b""]):
                for left, top, _, bottom in _MERGED.findall(before + block):
                    if int(bottom) > int(top):
                        column = column_index_from_string(left.decode()) - 1
                        found.setdefault(int(top), []).append((column, int(bottom)))
                before = (before + block)[-60:] if not _MERGED.search((before + block)[-60:]) else b""
    return found


# What is wrong


@dataclass
class Problems:
    """What is wrong with a file, summed up by kind: how often, with which values, first where.

    A kind is a column, "" for whole rows, and what is wrong. By column also how the file is read: the mark of
    `decimals`, whether points stand between `thousands` for all that is known, the time zone that is left out, and in
    which of two `ways` its times are read. `forms`: what cells are like that `desim orders` would have written
    otherwise.
    """

    file: str
    kinds: dict[tuple[str, str], list[Any]] = field(default_factory=dict)
    values: dict[tuple[str, str], Counter[str]] = field(default_factory=dict)
    decimals: dict[str, str] = field(default_factory=dict)
    thousands: set[str] = field(default_factory=set)
    zones: dict[str, str] = field(default_factory=dict)
    ways: dict[str, str] = field(default_factory=dict)
    forms: dict[str, None] = field(default_factory=dict)

    def add(self, column: str, wrong: str, expected: str, rows: Sequence[int], values: Iterable[Any]) -> None:
        """Some rows that have the same problem, and what stands there."""
        kind = column, wrong
        self.kinds.setdefault(kind, [0, rows[0], expected])[0] += len(rows)
        counts = self.values.setdefault(kind, Counter())
        for value in values:
            if (said := got(_plain(value))) in counts or len(counts) < _DISTINCT:
                counts[said] += 1

    def form(self, what: str, cells: Iterable[Any]) -> None:
        """Some cells that no plain table has, of which the first is named."""
        for cell in islice(cells, 1):
            self.forms.setdefault(f"{what} such as {got(_plain(cell))}")

    def told(self) -> list[str]:
        """A line for each kind, up to 20."""
        lines = []
        for (column, wrong), (count, row, expected) in islice(self.kinds.items(), MOST_PROBLEMS):
            counts = self.values[column, wrong]
            if count == 1:
                where, said = f"{self.file}, row {row}", f"got {next(iter(counts))}"
            else:
                where, number = self.file, f"{len(counts)}{' or more' * (len(counts) == _DISTINCT)}"
                common = ", ".join(value for value, _ in counts.most_common(_COMMON)) + ", ..." * (
                    len(counts) > _COMMON
                )
                many = "values" if len(counts) > 1 else "value"
                said = f"{count:,} rows from row {row} on, {number} {many}: {common}"
            where += f", {column}" * bool(column)
            lines.append(f"{where}: {wrong} ({said}), expected {expected}")
        more = len(self.kinds) - MOST_PROBLEMS
        return [*lines, *[f"{self.file}: and {more} more kinds of problems"] * (more > 0)]


def _plain(value: Any) -> Any:
    return value.item() if hasattr(value, "item") else str(value) if hasattr(value, "isoformat") else value
