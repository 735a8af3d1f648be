"""Lines of orders in the words of the model, made of rows of text, and what is wrong with rows, summed up by kind.

Times are numbers from the start of the run, times of day (06:15), or ISO dates with times; whole numbers are written in
digits. `desim_warehouse.orders` reads all else that an export has.
"""

from __future__ import annotations

import datetime as dt
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from desim_warehouse.errors import did_you_mean, got
from desim_warehouse.layout import Layout
from desim_warehouse.model.sections.flows import ORDER_COLUMNS, STORAGE
from desim_warehouse.model.sections.pods import PodsSpec
from desim_warehouse.values.fields import LIMITS

if TYPE_CHECKING:
    import pandas as pd

BEYOND = ""
"""The column of a table with the cells beyond its header."""
CLOCK = r"^(\d{1,2}):(\d{2})(?::(\d{2}(?:\.\d+)?))?$"
ISO = r"^\d{4}-\d\d-\d\d[T ]\d\d:\d\d(?::\d\d(?:\.\d+)?)?$"
"""A date with a time as `desim orders` writes it."""
_NO_VALUE = r"#(?:N/A|NV|REF!|BEZUG!|VALUE!|WERT!|DIV/0!|NAME\?|NULL!|NUM!|ZAHL!|SPILL!|CALC!)"
"""Values of formulas of Excel that have none, in English and in German."""
_TIME = "a number of at least 0, or a time such as 06:15 or 2026-03-02T06:15"
_LATEST = 10 * 365 * 86_400.0
_DAY = dt.datetime(2000, 1, 1)  # noqa: DTZ001 - wall clock
_MOST, _DISTINCT, _COMMON = 20, 1000, 5  # kinds of problems listed; values of a kind told apart, and shown


class OrderLine(NamedTuple):
    """A row of the file, with times from the start of the run, in the model's unit.

    `source`, `target`: name of a node or station, number of a storage place, `storage` for any. `via`: stops on the
    way, by name or number. `item`: with pods, its number. None: what the flow says. `due`, `priority`: None where the
    file says nothing.
    """

    release: float
    source: str | int | None
    target: str | int | None
    due: float | None
    priority: int | None
    quantity: int
    order: str
    via: tuple[str | int, ...] | None = None
    item: int | None = None


@dataclass(frozen=True)
class Reading:
    """Facts of a model by which the rows of an order list are read: names, number of storage places, start, time unit.

    Attributes:
        names: the nodes and zones that a row may name; with pods the stations alone.
        places: the number of storage places; 0 with pods.
        start: when the run starts, a time of day or a date with one.
        seconds: the length of the model's time unit.
        stored: names of storage places with their numbers.
        items: with pods, the number of items that are sold: a row asks for one of them instead of a storage place.
        sold: with pods, the names of the items; without names, rows have their numbers.
    """

    names: frozenset[str]
    places: int
    start: str
    seconds: float
    stored: tuple[tuple[str, int], ...] = ()
    items: int = 0
    sold: tuple[str, ...] = ()

    @cached_property
    def item_numbers(self) -> dict[str, int]:
        """The numbers of items by how files write them."""
        return {name: number for number, name in enumerate(self.sold or map(str, range(self.items)))}

    @cached_property
    def numbers(self) -> dict[str, int]:
        """The numbers of storage places by their names."""
        return dict(self.stored)

    @cached_property
    def clock(self) -> float:
        """The time of day at which the run starts, in seconds from midnight."""
        time = dt.time.fromisoformat(self.start.rpartition("T")[2] or "00:00")
        return time.hour * 3600 + time.minute * 60 + time.second + time.microsecond / 1e6

    @cached_property
    def day(self) -> dt.datetime | None:
        """The day on which the run starts, or None where the model says only the time."""
        return dt.datetime.fromisoformat(self.start.partition("T")[0]) if "T" in self.start else None

    @classmethod
    def of(cls, layout: Layout, start: str, seconds: float, pods: PodsSpec | None = None) -> Reading:
        """Make the facts from a layout; `start`: of the run, `seconds`: in a time unit."""
        zones = {station.zone for station in layout.stations.values()}
        if pods is not None:
            stations = frozenset(layout.stations) | zones
            return cls(stations, 0, start, float(seconds), items=pods.items, sold=pods.names)
        stored = tuple(layout.place_names.items())
        return cls(frozenset(layout.graph) | zones, len(layout.storage), start, float(seconds), stored)

    def place(self, text: str) -> str | int | None:
        """Return a node or station by its name, a storage place by its number; None if it is neither."""
        if text in self.names:
            return text
        if text in self.numbers:
            return self.numbers[text]
        number = text.removesuffix(".0")
        return int(number) if number.isdecimal() and int(number) < self.places else None

    def since_start(self, dates: pd.Series[Any], midnight: dt.datetime | None) -> Any:
        """Return dates as an array of times from the start of a run of that day, in the model's unit; nan for NaT."""
        import pandas as pd

        start = pd.Timestamp(midnight or _DAY) + pd.Timedelta(seconds=self.clock)
        return (dates - start).dt.total_seconds().to_numpy(dtype=float) / self.seconds


@dataclass
class Problems:
    """Problems of a file, summed up by kind: how often, with which values, first where.

    A kind is a column, "" for whole rows, and what is wrong.
    """

    file: str
    kinds: dict[tuple[str, str], list[Any]] = field(default_factory=dict)
    values: dict[tuple[str, str], Counter[str]] = field(default_factory=dict)

    def add(self, column: str, wrong: str, expected: str, rows: Sequence[int], values: Iterable[str]) -> None:
        """Add rows that have one problem, and the values that stand there."""
        kind = column, wrong
        self.kinds.setdefault(kind, [0, rows[0], expected])[0] += len(rows)
        counts = self.values.setdefault(kind, Counter())
        for text in map(got, values):
            if text in counts or len(counts) < _DISTINCT:
                counts[text] += 1

    def messages(self) -> list[str]:
        """Return a line for each kind of problem, up to 20."""
        lines = []
        for (column, wrong), (count, row, expected) in islice(self.kinds.items(), _MOST):
            counts, where = self.values[column, wrong], self.file
            if count == 1:
                where, cells = f"{where}, row {row}", f"got {next(iter(counts))}"
            else:
                shown = ", ".join(text for text, _ in counts.most_common(_COMMON)) + ", ..." * (len(counts) > _COMMON)
                number = f"{len(counts)}{' or more' * (len(counts) == _DISTINCT)} value{'s' * (len(counts) > 1)}"
                cells = f"{count:,} rows from row {row} on, {number}: {shown}"
            where += f", {column}" * bool(column)
            lines.append(f"{where}: {wrong} ({cells}), expected {expected}")
        more = len(self.kinds) - _MOST
        return [*lines, *[f"{self.file}: and {more} more kinds of problems"] * (more > 0)]


@dataclass(eq=False)
class OrderRows:
    """Rows of a table of orders, which are checked and made lines.

    Attributes:
        cells: text without blanks around it, "" where nothing stands, by our columns; the index has the row numbers.
        titles: how the file calls columns, where that is not as we do.
        midnight: the day on which the run starts; None without dates.
        bad: which rows have a problem; an array of bool.
    """

    quantity: ClassVar = "a whole number of at least 1"
    """The quantities that are expected, for messages."""

    cells: pd.DataFrame
    how: Reading
    problems: Problems
    midnight: dt.datetime | None = None
    titles: Mapping[Any, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        import numpy as np

        self.bad = np.zeros(len(self.cells), dtype=bool)
        self._refused: dict[Any, Any] = {}
        self._values: list[Iterable[Any]] = []

    def check(self) -> None:
        """Read all cells, and note what is wrong with them."""
        for column in [name for name in ORDER_COLUMNS if name in self.cells]:
            errors = self.cells[column].str.fullmatch(_NO_VALUE).to_numpy(dtype=bool)
            self.flag(errors, column, "an error of Excel", "a value: correct its formula there")
        if BEYOND in self.cells:
            self.flag(self.cells[BEYOND] != "", BEYOND, "cells beyond the header", "no more cells than it has")
        release, due = self._times("release"), self._times("due")
        self.flag(due < release, "due", "due before its release", "a time not before it")
        source, target = self._ends("from"), self._ends("to")
        priority = self._whole("priority", -LIMITS["number"][0], "a whole number")
        quantity = [1 if value is None else value for value in self._whole("quantity", 1, self.quantity)]
        orders = [name or str(row) for row, name in zip(self.cells.index, self._texts("order"), strict=True)]
        dues = [None if value != value else value for value in due.tolist()]  # noqa: PLR0124 - not a number
        ends = release.tolist(), source, target, dues
        self._values = [*ends, priority, self.loads(quantity), orders, self._stops(), self._items()]

    def lines(self) -> list[OrderLine]:
        """Return the rows that have no problem, once they were checked."""
        rows = zip(self.bad.tolist(), *self._values, strict=True)
        return [OrderLine(*cells) for bad, *cells in rows if not bad]

    def flag(self, rows: Any, column: Any, wrong: str, expected: str) -> None:
        """Note that some rows, by a mask or their ranks, have a problem in a column, the first of a cell alone."""
        import numpy as np

        mask = np.zeros(len(self.cells), dtype=bool)
        mask[rows] = True
        mask &= ~np.array(self._refused.get(column, False))
        if mask.any():
            self.bad |= mask
            self._refused[column] = self._refused.get(column, False) | mask
            cells = self.cells[column][mask]
            self.problems.add(self.titles.get(column, column), wrong, expected, cells.index.tolist(), cells.tolist())

    # What an export has in other forms

    def times(self, _column: str, text: pd.Series[Any]) -> Any:
        """Return cells as times from the start of the run in the model's unit, nan where they are none."""
        import numpy as np
        import pandas as pd

        values = pd.to_numeric(text, errors="coerce").to_numpy(dtype=float, copy=True)
        left = text[np.isnan(values) & (text != "").to_numpy()]
        if len(left):
            dates = pd.to_datetime(left.where(left.str.match(ISO)), format="ISO8601", errors="coerce")
            hands = self.hands(left)
            times = np.where(np.isnan(hands), self.how.since_start(dates, self.midnight), hands)
            values[self.cells.index.get_indexer(left.index)] = times
        return values

    def amounts(self, _column: str, text: pd.Series[Any]) -> Any:
        """Return cells as numbers, nan where they are none."""
        import pandas as pd

        return pd.to_numeric(text, errors="coerce").to_numpy(dtype=float)

    def loads(self, quantities: list[int]) -> list[int]:
        """Return the number of tasks that each quantity is."""
        return quantities

    def hands(self, text: pd.Series[Any]) -> Any:
        """Return times of day as times from the start of the run, nan where they are none."""
        hands = text.str.extract(CLOCK).astype(float).fillna({2: 0.0})
        seconds = (hands[0] * 3600 + hands[1] * 60 + hands[2]).to_numpy(dtype=float)
        return (seconds - self.how.clock) / self.how.seconds

    # Cells

    def _texts(self, column: str) -> list[str]:
        return self.cells[column].tolist() if column in self.cells else [""] * len(self.cells)

    def _times(self, column: str) -> Any:
        import numpy as np

        if column not in self.cells:
            return np.full(len(self.cells), np.nan)
        text = self.cells[column]
        values = self.times(column, text)
        late, early = values > _LATEST / self.how.seconds, values < 0
        self.flag(late, column, "later than 10 years after the start of the run", "seconds from it, or a date")
        cure = f"a time from {self.how.start} on, or an earlier run.start in the model"
        self.flag(early, column, "before the start of the run", cure)
        self.flag(np.isnan(values) & ((column == "release") | (text != "").to_numpy()), column, "not a time", _TIME)
        return np.where(late | early, np.nan, values)

    def _whole(self, column: str, least: int, expected: str) -> list[int | None]:
        import numpy as np

        if column not in self.cells:
            return [None] * len(self.cells)
        text = self.cells[column]
        values = self.amounts(column, text)
        good = (values >= least) & (values == np.floor(values)) & (values <= LIMITS["number"][0])
        self.flag(~good & (text != "").to_numpy(), column, "not a number of this kind", expected)
        return [int(value) if is_good else None for value, is_good in zip(values.tolist(), good.tolist(), strict=True)]

    def _ends(self, column: str) -> list[str | int | None]:
        """Return names of nodes and stations, numbers of storage places, `storage` for any of these."""
        texts = self._texts(column)
        stored = STORAGE if self.how.places or self.how.items else None
        places = {text: stored if text == STORAGE else self.how.place(text) for text in set(texts) - {""}}
        lost = [row for row, text in enumerate(texts) if text and places[text] is None]
        if lost:
            self.flag(lost, column, "no such place", self._expected(texts[lost[0]], "'storage', "))
        return [places.get(text) for text in texts]

    def _stops(self) -> list[tuple[str | int, ...] | None]:
        """Return the places of `B > C`, in order."""
        rows_of: dict[str, list[int]] = {}
        for row, text in enumerate(texts := self._texts("via")):
            rows_of.setdefault(text, []).append(row)
        rows_of.pop("", None)
        stops_of: dict[str, tuple[str | int, ...] | None] = {}
        if self.how.items:
            stops = [row for rows in rows_of.values() for row in rows]
            self.flag(stops, "via", "a stop on the way", "none: pods go to a station and back")
            return [None] * len(texts)
        for text, rows in rows_of.items():
            parts = [part.strip() for part in text.split(">")]
            places = {part: self.how.place(part) for part in parts}
            if wrong := [part for part, place in places.items() if place is None]:
                expected = f"places such as B > C: {self._expected(wrong[0])}"
                self.flag(rows, "via", f"no such place, '{wrong[0]}'", expected)
            stops_of[text] = tuple(place for part in parts if (place := places[part]) is not None)
        return [stops_of.get(text) for text in texts]

    def _items(self) -> list[int | None]:
        """Return with pods the number of the item of each row; None: any, by popularity."""
        if not self.how.items:
            return [None] * len(self.cells)
        numbers, texts = self.how.item_numbers, [text.removesuffix(".0") for text in self._texts("item")]
        lost = [row for row, text in enumerate(texts) if text and text not in numbers]
        if lost:
            expected = "an item that a pod holds" if self.how.sold else f"a number from 0 to {self.how.items - 1}"
            self.flag(lost, "item", "no such item", f"{expected} (pods.items){did_you_mean(texts[lost[0]], numbers)}")
        return [numbers.get(text) for text in texts]

    def _expected(self, text: str, any_storage: str = "") -> str:
        hint = did_you_mean(text, [*self.how.names, *self.how.numbers])
        if self.how.items:
            return f"a station, or 'storage': with pods a row names an item (column item){hint}"
        if not self.how.places:
            return f"a node or a station, as the layout has no storage places{hint}"
        return f"a node, a station, {any_storage}or a storage place from 0 to {self.how.places - 1}{hint}"
