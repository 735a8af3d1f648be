"""Orders from a file, CSV or Parquet.

It is read in chunks, so a million orders take no more memory than some thousand, and checked row by row.
"""

from __future__ import annotations

import csv
import datetime as dt
import hashlib
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from desim_warehouse.errors import ModelError, got, nearest, reason
from desim_warehouse.model.sections.flows import ORDER_COLUMNS, STORAGE, OrdersArrivals
from desim_warehouse.values.fields import LIMITS

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

    import pandas as pd
    from numpy.random import Generator

    from desim_warehouse.layout import Layout
    from desim_warehouse.model.sections.flows import FlowSpec, OrdersFile

CHUNK = 50_000
"""Rows read at a time."""
MOST_PROBLEMS = 20
"""Problems of one file that are listed."""
NUMBERS = {"priority": -LIMITS["number"][0], "quantity": 1}
"""Columns of whole numbers, and the least of each."""


class OrderLine(NamedTuple):
    """A row of the file, with times from the start of the run, in the model's unit.

    `source`, `target`: name of a node or station, number of a storage place, `storage` for any. `via`: stops on the
    way, by name or number. None: what the flow says. `due`, `priority`: None where the file says nothing.
    """

    release: float
    source: str | int | None
    target: str | int | None
    due: float | None
    priority: int | None
    quantity: int
    order: str
    via: tuple[str | int, ...] | None = None


@dataclass(frozen=True)
class Reading:
    """What it takes to understand a file: names of places, how many storage places, when the run starts, the unit."""

    names: frozenset[str]
    places: int
    start: str
    seconds: float

    @classmethod
    def of(cls, layout: Layout, start: str, seconds: float) -> Reading:
        """That of a layout; `start`: of the run, `seconds`: in a time unit."""
        zones = {station.zone for station in layout.stations.values()}
        return cls(frozenset(layout.graph) | zones, len(layout.storage), start, float(seconds))


@dataclass(frozen=True)
class Summary:
    """What a file holds: tasks (quantities added up), rows, the last release, and the nodes and stations it names.

    `due` and `urgent`: rows with a due time, and with a priority; `orders`: how many different ones.
    """

    tasks: int
    rows: int
    last: float
    names: frozenset[str] = frozenset()
    due: int = 0
    urgent: int = 0
    orders: int = 0


def sha256(path: Path) -> str:
    """The SHA-256 of a file: the same orders, the same model."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read(spec: OrdersFile, how: Reading) -> Iterator[OrderLine]:
    """The rows in the order of the file, which is that of release.

    Raises:
        ModelError: with the problems of the first chunk that has some, by row and column.
    """
    for lines, problems in _checked(spec, how):
        if problems:
            raise ModelError(problems)
        yield from lines


def summary(spec: OrdersFile, how: Reading) -> Summary:
    """Read the whole file once.

    Raises:
        ModelError: where it cannot be read, or with its first 20 problems.
    """
    stat = _stat(Path(spec.file))
    return _summary(spec, how, (stat.st_mtime_ns, stat.st_size))


@lru_cache(maxsize=8)
def _summary(spec: OrdersFile, how: Reading, _: tuple[int, int]) -> Summary:
    tasks, rows, last, found = 0, 0, 0.0, list[str]()
    names: set[str | int | None] = set()
    due, urgent, orders = 0, 0, set[str]()
    for lines, problems in _checked(spec, how):
        found += problems
        rows += len(lines)
        tasks += sum(line.quantity for line in lines)
        last = lines[-1].release if lines else last
        due += sum(line.due is not None for line in lines)
        urgent += sum(bool(line.priority) for line in lines)
        orders.update(map(attrgetter("order"), lines))
        names.update(map(attrgetter("source"), lines), map(attrgetter("target"), lines))
        names.update(place for via in set(map(attrgetter("via"), lines)) for place in via or ())
        if len(found) > MOST_PROBLEMS:
            raise ModelError([*found[:MOST_PROBLEMS], f"{spec.file}: and more problems"])
    if not rows and not found:
        found.append(f"{spec.file}: no rows, expected at least one order")
    if tasks > LIMITS["tasks"][0] and not found:
        found.append(f"{spec.file}: too many tasks (got {tasks:,}), expected at most {LIMITS['tasks'][0]:,}")
    if found:
        raise ModelError(found)
    named = frozenset(name for name in names if isinstance(name, str) and name != STORAGE)
    return Summary(tasks, rows, last, named, due, urgent, len(orders))


def files_of(flows: Mapping[str, FlowSpec]) -> list[OrdersFile]:
    """The files of orders that flows name; one that is not there any more is left out."""
    named = [flow.when.orders for flow in flows.values() if isinstance(flow.when, OrdersArrivals)]
    return [spec for spec in named if Path(spec.file).exists()]


def nodes_named(files: Iterable[OrdersFile], how: Reading, layout: Layout) -> tuple[str, ...]:
    """The nodes that files of orders name."""
    names = (name for spec in files for name in sorted(summary(spec, how).names))
    return tuple(dict.fromkeys(node for name in names for node in layout.nodes_of(name)))


def problems_of(files: Iterable[OrdersFile], how: Reading) -> list[str]:
    """What is wrong with files of orders, by row and column."""
    found: list[str] = []
    for spec in files:
        try:
            summary(spec, how)
        except ModelError as error:
            found += error.problems
    return found


def resampled(
    lines: Iterator[OrderLine], width: float, demand: float, stream: Callable[[int], Generator]
) -> Iterator[OrderLine]:
    """Orders drawn anew, stretch by stretch of this width: as many as there are on average, `demand` times.

    In each stretch their number is Poisson, each is one of those in it, and its release anywhere in it. An order keeps
    its rows, and the time until it is due. `stream` gives the generator of the n-th stretch.

    Source: the block bootstrap (Kuensch 1989) for a process whose rate changes with the time of day.
    """
    for number, block in groupby(lines, key=lambda line: int(line.release // width)):
        of: dict[str, list[OrderLine]] = {}
        for line in block:
            of.setdefault(line.order, []).append(line)
        orders = list(of.values())
        generator = stream(number)
        count = int(generator.poisson(demand * len(orders)))
        drawn = generator.choice(len(orders), count).tolist()
        times = sorted((generator.uniform(0, width, count) + number * width).tolist())
        for copy, (which, time) in enumerate(zip(drawn, times, strict=True)):
            for line in orders[which]:
                due = None if line.due is None else line.due - line.release + time
                yield line._replace(release=time, due=due, order=f"{line.order}.{number}.{copy}")


# Chunks

Chunk = tuple[list[OrderLine], list[str]]


def _checked(spec: OrdersFile, how: Reading) -> Iterator[Chunk]:
    """For each chunk its rows, or what is wrong with them."""
    before, first, midnight = 0.0, 1, _midnight(how.start)
    for table in _chunks(spec):
        if midnight is None:
            midnight = _first_day(table["release"])
        chunk = _Chunk(table, spec, how, first, midnight)
        lines = chunk.lines(before)
        yield lines, chunk.problems
        before = max([before, *(line.release for line in lines)])
        first += len(table)


def _chunks(spec: OrdersFile) -> Iterator[pd.DataFrame]:
    """The columns that are known, as they stand there."""
    import pandas as pd

    path, theirs = Path(spec.file), {ours: spec.columns.get(ours, ours) for ours in ORDER_COLUMNS}
    _stat(path)
    try:
        if path.suffix.lower() in {".parquet", ".pq"}:
            from pyarrow import parquet

            with parquet.ParquetFile(path) as file:
                here = _present(path, file.schema_arrow.names, theirs, spec)
                for batch in file.iter_batches(CHUNK, columns=list(here)):
                    yield batch.to_pandas().rename(columns=here)
        else:
            with path.open(encoding="utf-8-sig", newline="") as lines:
                here = _present(path, next(csv.reader(lines), []), theirs, spec)
            text: Any = {"dtype": str, "keep_default_na": False, "encoding": "utf-8-sig"}
            with pd.read_csv(path, usecols=list(here), chunksize=CHUNK, **text) as tables:
                for table in tables:
                    yield table.rename(columns=here)
    except (OSError, ValueError) as error:
        raise ModelError([f"{path}: cannot be read ({reason(error)}), expected a CSV or Parquet file"]) from None


def _present(path: Path, names: Collection[str], theirs: dict[str, str], spec: OrdersFile) -> dict[str, str]:
    """The columns of the file that are read, and what we call them."""
    for ours, name in theirs.items():
        if name not in names and (ours == "release" or ours in spec.columns):
            near = nearest(name, names)
            hint = f"; did you mean '{near}'?" if near else ""
            raise ModelError([f"{path}: no column '{name}' (it has {len(names) or 'none'}){hint}"])
    return {name: ours for ours, name in theirs.items() if name in names}


def _stat(path: Path) -> Any:
    try:
        if not path.is_file():
            raise FileNotFoundError(2, "no such file")
        return path.stat()
    except OSError as error:
        raise ModelError([f"{path}: cannot be read ({reason(error)}), expected a CSV or Parquet file"]) from None


class _Chunk:
    """Some rows of a file, and the `problems` with them."""

    def __init__(
        self, table: pd.DataFrame, spec: OrdersFile, how: Reading, first: int, midnight: dt.datetime | None
    ) -> None:
        self.table = table
        self.spec = spec
        self.how = how
        self.first = first
        self.midnight = midnight
        self.problems: list[str] = []

    def lines(self, before: float) -> list[OrderLine]:
        """The rows. Where there are problems, only those that could be read matter."""
        import numpy as np

        size = len(self.table)
        release = self._times("release", needed=True)
        due = self._times("due")
        late = np.maximum.accumulate(np.concatenate([[before], np.nan_to_num(release, nan=-np.inf)]))[:-1]
        for row in np.flatnonzero(release < late)[:MOST_PROBLEMS]:
            self._problem(row, "release", "before the row above", "rows in the order of their release")
        for row in np.flatnonzero(due < release)[:MOST_PROBLEMS]:
            self._problem(row, "due", "due before its release", "a time not before it")
        source, target = self._ends("from"), self._ends("to")
        priority, quantity = self._numbers("priority"), self._numbers("quantity")
        via = self._stops()
        names = self._text("order")
        orders = [name or str(self.first + row) for row, name in enumerate(names)]
        if self.problems:
            return []
        dues = [None if value != value else value for value in due.tolist()]  # noqa: PLR0124 - not a number
        amounts = [1 if value is None else value for value in quantity]
        rows = zip(release.tolist(), source, target, dues, priority, amounts, orders, via, strict=True)
        assert size == len(orders)
        return [OrderLine(*row) for row in rows]

    def _problem(self, row: int, column: str, wrong: str, expected: str) -> None:
        name = self.spec.columns.get(column, column)
        value = self.table[column].iloc[row]
        where = f"{self.spec.file}, row {self.first + row}, {name}"
        self.problems.append(f"{where}: {wrong} (got {got(_plain(value))}), expected {expected}")

    def _text(self, column: str) -> list[str]:
        if column not in self.table:
            return [""] * len(self.table)
        cells = self.table[column]
        return ["" if value is None or value != value else str(value).strip() for value in cells.tolist()]  # noqa: PLR0124

    def _times(self, column: str, *, needed: bool = False) -> Any:
        """Times from the start of the run in the model's unit, nan where there is none."""
        import numpy as np
        import pandas as pd

        if column not in self.table:
            return np.full(len(self.table), np.nan)
        cells = self.table[column]
        if pd.api.types.is_datetime64_any_dtype(cells):
            found, empty = self._of_dates(cells), cells.isna().to_numpy()
        elif pd.api.types.is_numeric_dtype(cells):
            found, empty = cells.to_numpy(dtype=float), cells.isna().to_numpy()
        else:
            text = pd.Series(self._text(column), dtype=object)
            empty = (text == "").to_numpy()
            found = pd.to_numeric(text, errors="coerce").to_numpy(dtype=float, copy=True)
            left = np.isnan(found) & ~empty
            if left.any():
                found[left] = self._of_text(text[left])
        bad = ~empty & ~(found >= 0)
        if needed:
            bad |= empty
        for row in np.flatnonzero(bad)[:MOST_PROBLEMS]:
            early = found[row] < 0
            wrong = "before the start of the run" if early else "not a time"
            self._problem(row, column, wrong, f"a number of at least 0, or a time such as 06:15 or {_EXAMPLE}")
        return np.where(bad, np.nan, found)

    def _of_text(self, text: pd.Series[Any]) -> Any:
        """Times of day, and dates with times."""
        import numpy as np
        import pandas as pd

        clock = text.str.extract(r"^(\d{1,2}):(\d{2})(?::(\d{2}(?:\.\d+)?))?$").astype(float).fillna({2: 0.0})
        seconds = (clock[0] * 3600 + clock[1] * 60 + clock[2]).to_numpy() - _seconds_of_day(self.how.start)
        dates = pd.to_datetime(text.where(np.isnan(seconds)), format="ISO8601", errors="coerce")
        return np.where(np.isnan(seconds), self._of_dates(dates) * self.how.seconds, seconds) / self.how.seconds

    def _of_dates(self, dates: pd.Series[Any]) -> Any:
        import pandas as pd

        if getattr(dates.dt, "tz", None) is not None:
            dates = dates.dt.tz_localize(None)
        start = pd.Timestamp(self.midnight or _DAY) + pd.Timedelta(seconds=_seconds_of_day(self.how.start))
        return (dates - start).dt.total_seconds().to_numpy(dtype=float) / self.how.seconds

    def _numbers(self, column: str) -> list[int | None]:
        import numpy as np
        import pandas as pd

        if column not in self.table:
            return [None] * len(self.table)
        text = pd.Series(self._text(column), dtype=object)
        found = pd.to_numeric(text, errors="coerce").to_numpy(dtype=float, copy=True)
        least = NUMBERS[column]
        empty = (text == "").to_numpy()
        bad = ~empty & ~((found >= least) & (found == np.floor(found)) & (found <= LIMITS["number"][0]))
        expected = "a whole number" if column == "priority" else "a whole number of at least 1"
        for row in np.flatnonzero(bad)[:MOST_PROBLEMS]:
            self._problem(row, column, "not a number of this kind", expected)
        return [None if none or wrong else int(value) for value, none, wrong in zip(found, empty, bad, strict=True)]

    def _stops(self) -> list[tuple[str | int, ...] | None]:
        """The places of `B > C`, in order."""
        if "via" not in self.table:
            return [None] * len(self.table)
        known: dict[str, tuple[str | int, ...] | None] = {"": None}
        found: list[tuple[str | int, ...] | None] = []
        for row, text in enumerate(self._text("via")):
            if text not in known:
                ends = [self._end(part.strip()) for part in text.split(">")]
                known[text] = tuple(end for end in ends if end is not None) if None not in ends else None
            if known[text] is None and text and len(self.problems) < MOST_PROBLEMS:
                wrong = next(part.strip() for part in text.split(">") if self._end(part.strip()) is None)
                self._problem(row, "via", f"no such place, '{wrong}'", self._expected(wrong, "places such as B > C: "))
            found.append(known[text])
        return found

    def _expected(self, text: str, among: str = "") -> str:
        near = nearest(text, self.how.names) if len(self.how.names) <= _COMPARED else None
        hint = f"; did you mean '{near}'?" if near else ""
        any_storage = "" if among else "'storage', "
        return f"{among}a node, a station, {any_storage}or a storage place from 0 to {self.how.places - 1}{hint}"

    def _ends(self, column: str) -> list[str | int | None]:
        """Names of nodes and stations, numbers of storage places, `storage` for any of these."""
        if column not in self.table:
            return [None] * len(self.table)
        found: list[str | int | None] = []
        known: dict[str, str | int | None] = {"": None, STORAGE: STORAGE}
        for row, text in enumerate(self._text(column)):
            if text not in known:
                known[text] = self._end(text)
            end = known[text]
            if end is None and text and len(self.problems) < MOST_PROBLEMS:
                self._problem(row, column, "no such place", self._expected(text))
            found.append(end)
        return found

    def _end(self, text: str) -> str | int | None:
        if text in self.how.names:
            return text
        number = text.removesuffix(".0")
        return int(number) if number.isdecimal() and int(number) < self.how.places else None


_EXAMPLE = "2026-03-02T06:15"
_DAY = dt.datetime(2000, 1, 1)  # noqa: DTZ001 - wall clock
_COMPARED = 1000


def _plain(value: Any) -> Any:
    return value.item() if hasattr(value, "item") else str(value) if hasattr(value, "isoformat") else value


def _seconds_of_day(start: str) -> float:
    """Of `06:00` or of a date with a time."""
    clock = dt.time.fromisoformat(start.rpartition("T")[2] or "00:00")
    return clock.hour * 3600 + clock.minute * 60 + clock.second + clock.microsecond / 1e6


def _midnight(start: str) -> dt.datetime | None:
    """The day on which the run starts, or None where only its time is known."""
    if "T" not in start:
        return None
    return dt.datetime.fromisoformat(start.partition("T")[0])


def _first_day(release: pd.Series[Any]) -> dt.datetime | None:
    """The day of the first order, where the file has dates."""
    import pandas as pd

    first = next((value for value in release.tolist() if value is not None and value == value and value != ""), None)  # noqa: PLR0124
    if first is None or isinstance(first, int | float):
        return None
    date = pd.to_datetime(str(first), format="ISO8601", errors="coerce")
    return None if pd.isna(date) else date.normalize().tz_localize(None).to_pydatetime()
