"""Orders from a plain table, as `desim orders` writes it: CSV in UTF-8 with commas, or Parquet, in our columns alone.

Rows come in chunks, so a million orders take no more memory than some thousand. Rows in no order are sorted by their
release, in memory. What is wrong is summed up by kind. Any other table is refused with the command that reads it:
what an export means is asked once, where somebody sees the answer.
"""

from __future__ import annotations

import csv
import datetime as dt
import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby, islice, pairwise
from operator import attrgetter
from pathlib import Path
from sys import intern
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import ModelError, first_of, got, nearest, reason
from desim_warehouse.layout import Layout
from desim_warehouse.model.sections.flows import ORDER_COLUMNS, STORAGE, FlowSpec, OrdersArrivals, OrdersFile
from desim_warehouse.model.sections.order_lines import BEYOND, ISO, OrderLine, OrderRows, Problems, Reading
from desim_warehouse.values.csv_rows import csv_rows
from desim_warehouse.values.fields import LIMITS, FrozenMap

if TYPE_CHECKING:
    import pandas as pd
    from numpy.random import Generator

CHUNK = 50_000
"""Rows read at a time."""
PARQUET, EXCEL = (".parquet", ".pq"), (".xlsx", ".xlsm")
"""Endings of files, in small letters."""
_EARLIER: dict[str, Any] = {"columns": {}, "sheet": None, "dates": None, "quantity": "tasks", "pieces_per_load": None}
"""Keys that a file of orders had before 0.4, and what they were where nothing was said."""


@dataclass(frozen=True)
class Summary:
    """Contents of a file: tasks, rows, the last release, and the nodes and stations it names.

    `due` and `urgent`: rows with a due time, and with a priority; `orders`: how many different ones; `in_order`:
    whether every row is released no earlier than those before; `fetched`, `stored`: rows from a storage place to a node
    or station, and the other way; `items`: with pods, the tasks of each item that rows name.
    """

    tasks: int
    rows: int
    last: float
    names: frozenset[str] = frozenset()
    due: int = 0
    urgent: int = 0
    orders: int = 0
    in_order: bool = True
    fetched: int = 0
    stored: int = 0
    items: Mapping[int, int] = FrozenMap()


# The table


def command(path: Path, named: dict[str, Any], model: str) -> str:
    """Return the `desim orders` command that makes a plain table of a file.

    `named`: the section of the model that names it, maybe with keys of earlier versions; `model`: the model's file.
    """
    file = near(path)
    out = file.with_name(f"{file.stem}{'-plain' * (file.suffix.lower() in PARQUET)}.parquet")
    columns = named.get("columns")
    maps = columns.items() if isinstance(columns, Mapping) else ()
    words = ["desim", "orders", str(file), *(word for pair in maps for word in ("--map", "=".join(map(str, pair))))]
    if "quantity" in dict(maps) and not named.get("quantity"):
        words += ["--quantity", "tasks"]
    for key in ("sheet", "dates", "quantity", "pieces_per_load"):
        words += [f"--{key.replace('_', '-')}", str(named[key])] if named.get(key) else []
    return shlex.join([*words, "--model", model if Path(model).is_file() else "MODEL", "--out", str(out)])


def near(path: str | Path) -> Path:
    """Return a path as people type it: from the current folder on, if the file lies below."""
    folder = Path.cwd()
    return Path(path).relative_to(folder) if Path(path).is_relative_to(folder) else Path(path)


def without_earlier(named: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Return a section that names a file, without keys of earlier versions, and such keys with a value, as text."""
    keys = [f"{key}: {got(named[key])}" for key in _EARLIER if key in named and named[key] != _EARLIER[key]]
    return {key: value for key, value in named.items() if key not in _EARLIER}, keys


def not_plain(path: Path) -> list[str]:
    """List in which ways a file is no plain table of orders, as far as its kind and its header show; each in words."""
    if path.suffix.lower() in EXCEL:
        return ["a workbook"]
    try:
        names = _names(path)
    except (OSError, ValueError, csv.Error) as error:
        return [reason(error)]
    others = [got(name) for name in names if name not in ORDER_COLUMNS]
    meant = nearest(others[0][1:-1], {*ORDER_COLUMNS} - {*names}) if len(others) == 1 else None
    ways = [f"column{'s' * (len(others) > 1)} {first_of(others, 4)}"] if others else []
    ways += [f"did you mean '{meant}'?"] if meant else ["no column 'release'"] * ("release" not in names)
    return ways + [f"column '{name}' twice" for name, count in Counter(names).items() if count > 1]


def check_there(path: Path) -> tuple[int, int]:
    """Return when a file was changed, in nanoseconds, and its bytes; raises ModelError where there is no such file."""
    try:
        state = path.stat()
    except FileNotFoundError:
        raise ModelError([unreadable(path, OSError(0, "no such file"))]) from None
    except (OSError, ValueError) as error:
        raise ModelError([unreadable(path, error)]) from None
    if not path.is_file():
        raise ModelError([unreadable(path, OSError(0, "a folder" if path.is_dir() else "not a file"))])
    return state.st_mtime_ns, state.st_size


def unreadable(path: Path, error: Exception, kinds: str = "CSV or Parquet") -> str:
    """Return the message that says why a file of orders cannot be read."""
    return f"{near(path)}: cannot be read ({reason(error)}), expected orders in {kinds}"


def _names(path: Path) -> list[str]:
    """Return the columns of a plain table; raises OSError, ValueError or csv.Error where it has none."""
    if path.suffix.lower() in PARQUET:
        from pyarrow import parquet

        return list(parquet.read_schema(path).names)
    with path.open(encoding="utf-8-sig", newline="") as lines:
        return [name.strip() for name in next(csv_rows(lines), (1, []))[1]]


def _chunks(path: Path, columns: Sequence[str] = ORDER_COLUMNS) -> Iterator[pd.DataFrame]:
    """Iterate over the rows of a plain table that are not empty, as text in chunks, numbered from 1."""
    try:
        names = _names(path)
        if path.suffix.lower() in PARQUET:
            wanted = [name for name in names if name in columns]
            for begin, cells in parquet_chunks(path, wanted):
                yield framed(zip(*cells, strict=True), wanted, begin)
            return
        with path.open(encoding="utf-8-sig", newline="") as lines:
            rows, begin = (cells for _, cells in islice(csv_rows(lines), 1, None)), 1
            while some := list(islice(rows, CHUNK)):
                yield framed(some, names, begin)
                begin += len(some)
    except (OSError, ValueError, csv.Error) as error:
        raise ModelError([unreadable(path, error)]) from None


def framed(rows: Iterable[Sequence[str]], names: Sequence[Any], begin: int) -> pd.DataFrame:
    """Make rows a table of text, without the empty ones, numbered from `begin`; equal texts are one in memory."""
    import pandas as pd

    width, beyond, cells, numbers = len(names), list[str](), list[list[str]](), list[int]()
    for number, row in enumerate(rows, begin):
        texts = [intern(cell.strip()) for cell in row]
        if any(texts):
            numbers.append(number)
            cells.append((texts + [""] * (width - len(texts)))[:width])
            beyond.append("".join(texts[width:]))
    frame = pd.DataFrame(cells, numbers, list(names), dtype=object)
    return frame.assign(**{BEYOND: beyond}) if any(beyond) else frame


def parquet_chunks(path: Path, names: Sequence[str]) -> Iterator[tuple[int, list[list[str]]]]:
    """Yield the columns of a Parquet file as text, in chunks: number of the first row, from 1, and the cells.

    Raises ValueError for columns that are no text, numbers or times, and for more text than is held at once.
    """
    from pyarrow import parquet

    schema, most = parquet.read_schema(path), LIMITS["texts"][0]
    texts = [field.name for field in schema if str(field.type).endswith(("string", "binary"))]
    with parquet.ParquetFile(path, read_dictionary=texts) as file:
        groups = map(file.metadata.row_group, range(file.metadata.num_row_groups))
        columns = (group.column(rank) for group in groups for rank in range(group.num_columns))
        if any(column.total_uncompressed_size > most for column in columns):
            raise ValueError("too large when it is unfolded")
        begin = 1
        for batch in file.iter_batches(CHUNK, columns=list(names)):
            cells = [_cells(batch.column(name), name) for name in names]
            if (size := sum(len(cell) for column in cells for cell in column)) > most:
                raise ValueError(f"{len(batch):,} rows have {size / 1e6:,.0f} MB of texts")
            yield begin, cells
            begin += len(batch)


def _cells(column: Any, name: str) -> list[str]:
    """Return a column of Parquet as text, each distinct text once in memory; raises ValueError where it is none."""
    import pyarrow as pa

    is_coded = pa.types.is_dictionary(column.type)
    words = column.dictionary if is_coded else column
    try:
        if pa.types.is_nested(words.type) or pa.types.is_duration(words.type):
            raise ValueError(f"column {got(name)} has {words.type}, expected text, numbers or times")
        column.validate(full=True)
        texts = words.cast(pa.string())
        texts.validate(full=True)
    except pa.ArrowInvalid:
        raise ValueError(f"column {got(name)} has bytes that are no text") from None
    empty = (None, "nan") if pa.types.is_floating(words.type) else (None,)
    cells = ["" if text in empty else text for text in texts.to_pylist()]
    return ["" if rank is None else cells[rank] for rank in column.indices.to_pylist()] if is_coded else cells


# What is in it


def read(spec: OrdersFile, how: Reading) -> Iterator[OrderLine]:
    """Iterate over the rows in the order of their release.

    Raises:
        ModelError: with all kinds of problems of the file.
    """
    if summary(spec, how).in_order:
        yield from (line for lines in _checked(spec, how, Problems(str(near(spec.file)))) for line in lines)
    else:
        lines = [line for lines in _checked(spec, how, Problems(str(near(spec.file)))) for line in lines]
        yield from sorted(lines, key=attrgetter("release"))


def summary(spec: OrdersFile, how: Reading) -> Summary:
    """Read the whole file once.

    Raises:
        ModelError: where it cannot be read, or with all kinds of its problems, up to 20.
    """
    return _summary(spec, how, check_there(Path(spec.file)))


@lru_cache(maxsize=8)
def _summary(spec: OrdersFile, how: Reading, _: tuple[int, int]) -> Summary:
    tasks, rows, last, in_order = 0, 0, 0.0, True
    names: set[str | int | None] = set()
    due, urgent, orders, items = 0, 0, set[str](), Counter[int]()
    ways: Counter[tuple[bool | None, bool | None]] = Counter()
    wrong, most = Problems(str(near(spec.file))), LIMITS["tasks"][0]
    for lines in _checked(spec, how, wrong):
        rows += len(lines)
        tasks += sum(line.quantity for line in lines)
        times = [last, *(line.release for line in lines)]
        in_order = in_order and all(earlier <= later for earlier, later in pairwise(times))
        last = max(times)
        due += sum(line.due is not None for line in lines)
        urgent += sum(bool(line.priority) for line in lines)
        orders.update(map(attrgetter("order"), lines))
        for line in lines:
            if line.item is not None:
                items[line.item] += line.quantity
        ways.update((_in_storage(line.source), _in_storage(line.target)) for line in lines)
        names.update(map(attrgetter("source"), lines), map(attrgetter("target"), lines))
        names.update(place for via in set(map(attrgetter("via"), lines)) for place in via or ())
        if rows > most:
            raise ModelError([f"{spec.file}: too many rows, expected at most {most:,} tasks"])
    problems = wrong.messages()
    if not rows and not problems:
        problems = [f"{spec.file}: no rows, expected at least one order"]
    if tasks > most and not problems:
        problems = [f"{spec.file}: too many tasks (got {tasks:,}), expected at most {most:,}"]
    if problems:
        raise ModelError(problems)
    named = frozenset(name for name in names if isinstance(name, str) and name != STORAGE)
    fetched, stored = ways[True, False], ways[False, True]
    return Summary(tasks, rows, last, named, due, urgent, len(orders), in_order, fetched, stored, FrozenMap(items))


def _in_storage(end: str | int | None) -> bool | None:
    """Whether the end of a row is a storage place, or any storage place; None where the row does not say."""
    return None if end is None else not isinstance(end, str) or end == STORAGE


def files_of(flows: Mapping[str, FlowSpec]) -> list[OrdersFile]:
    """Return the files of orders that flows name; one that is no longer there is left out."""
    named = [flow.when.orders for flow in flows.values() if isinstance(flow.when, OrdersArrivals)]
    return [spec for spec in named if Path(spec.file).exists()]


def nodes_named(files: Iterable[OrdersFile], how: Reading, layout: Layout) -> tuple[str, ...]:
    """Return the nodes that files of orders name."""
    names = (name for spec in files for name in sorted(summary(spec, how).names))
    return tuple(dict.fromkeys(node for name in names for node in layout.nodes_of(name)))


def problems_of(files: Iterable[OrdersFile], how: Reading, model: str) -> list[str]:
    """Return problems of files of orders, by row and column, and the command that reads other tables for the model."""
    problems: list[str] = []
    for spec in files:
        try:
            summary(spec, how)
        except ModelError as error:
            cure = f"the export of another program is read by: {command(Path(spec.file), {}, model)}"
            problems += [*error.problems, f"{near(spec.file)}: {cure}"]
    return problems


def resampled(
    lines: Iterator[OrderLine], width: float, demand: float, stream: Callable[[int], Generator]
) -> Iterator[OrderLine]:
    """Draw orders anew (block bootstrap), stretch by stretch of this width: as many as on average, `demand` times.

    In each stretch their number is Poisson, each is drawn from the orders in it, and its release is anywhere in it.
    An order keeps its rows, and the time until it is due. `stream` gives the generator of the n-th stretch.

    Source: the block bootstrap (Kuensch 1989) for a process whose rate changes with the time of day.
    """
    for number, block in groupby(lines, key=lambda line: int(line.release // width)):
        lines_of: dict[str, list[OrderLine]] = {}
        for line in block:
            lines_of.setdefault(line.order, []).append(line)
        orders = list(lines_of.values())
        generator = stream(number)
        count = int(generator.poisson(demand * len(orders)))
        drawn = generator.choice(len(orders), count).tolist()
        times = sorted((generator.uniform(0, width, count) + number * width).tolist())
        for copy, (which, time) in enumerate(zip(drawn, times, strict=True)):
            for line in orders[which]:
                due = None if line.due is None else line.due - line.release + time
                yield line._replace(release=time, due=due, order=f"{line.order}.{number}.{copy}")


def _checked(spec: OrdersFile, how: Reading, problems: Problems) -> Iterator[list[OrderLine]]:
    """Iterate over the rows that could be read, chunk by chunk; faults of others are added to the problems."""
    path = Path(spec.file)
    if ways := not_plain(path):  # it may have changed since the model was read
        raise ModelError([f"{near(path)}: no plain table of orders (got {'; '.join(ways)})"])
    midnight = how.day or _first_day(path, check_there(path))
    for cells in _chunks(path):
        rows = OrderRows(cells, how, problems, midnight)
        rows.check()
        yield rows.lines()


@lru_cache(maxsize=8)
def _first_day(path: Path, _: tuple[int, int]) -> dt.datetime | None:
    """Return the day of the first release, None where releases are no dates."""
    days = []
    for cells in _chunks(path, ("release",)):
        text = cells["release"]
        days += text[text.str.match(ISO)].str[:10].unique().tolist()
    return dt.datetime.fromisoformat(min(days)) if days else None
