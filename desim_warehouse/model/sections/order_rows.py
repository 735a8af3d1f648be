"""Rows of a file of orders as lines in the words of the model, and what is wrong with them, summed up by kind.

Times are numbers from the start of the run, times of day, or dates: ISO, and as people write them: German, US or
British, with months in digits or in words. A table that `desim orders` wrote has only the first three.
"""

from __future__ import annotations

import datetime as dt
import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import starmap
from typing import TYPE_CHECKING, Any, NamedTuple

from desim_warehouse.errors import nearest
from desim_warehouse.layout import Layout
from desim_warehouse.model.sections.flows import STORAGE, OrdersFile
from desim_warehouse.model.sections.order_file import BEYOND, Problems, Table, check_there, chunks, table_of
from desim_warehouse.model.sections.pods import PodsSpec
from desim_warehouse.values.dates import (
    ISO,
    SLASHES,
    ZONE,
    Slashes,
    are_days_of_excel,
    hours_between,
    of_excel,
    read_dates,
    settled,
)
from desim_warehouse.values.fields import LIMITS

if TYPE_CHECKING:
    import pandas as pd

NUMBERS = {"priority": -LIMITS["number"][0], "quantity": 1}
"""Columns of whole numbers, and the least of each."""
_EXAMPLE = "2026-03-02T06:15"
_DAY = dt.datetime(2000, 1, 1)  # noqa: DTZ001 - wall clock
_AROUND_ALL = dt.timedelta(days=366)
"""Orders so long before most others are dates of nothing, such as 1900-01-01, and no start of a run."""
_LATEST = 10 * 365 * 86_400.0
_COMPARED = 1000
_COUNTED = r"(?i)^([\d.,]+)\s*(?:st|stk|stck|stück|stueck|pc|pcs|pce|pieces?|ea|each|units?)\.?$"
"""Quantities with a word for pieces; kilograms, cartons or pallets are none."""


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
    """What it takes to understand a file: names of places, how many storage places, when the run starts, the unit.

    `stored`: names of storage places with their numbers. With pods rows name stations alone, and one of so many
    `items`, by number or by its name in `sold`.
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

    @classmethod
    def of(cls, layout: Layout, start: str, seconds: float, pods: PodsSpec | None = None) -> Reading:
        """That of a layout; `start`: of the run, `seconds`: in a time unit."""
        zones = {station.zone for station in layout.stations.values()}
        if pods is not None:
            stations = frozenset(layout.stations) | zones
            return cls(stations, 0, start, float(seconds), items=pods.items, sold=pods.names)
        stored = tuple(layout.place_names.items())
        return cls(frozenset(layout.graph) | zones, len(layout.storage), start, float(seconds), stored)


def first_day(spec: OrdersFile, table: Table, how: Reading) -> dt.datetime | None:
    """The day on which the run starts: as the model says, or the day of the first order, where the file has dates."""
    stat = check_there(table.path)
    return _midnight(how.start) or _earliest_day(spec, (stat.st_mtime_ns, stat.st_size))


@lru_cache(maxsize=8)
def _earliest_day(spec: OrdersFile, _: tuple[int, int]) -> dt.datetime | None:
    import pandas as pd

    table = table_of(spec)
    ways, days = ways_of(spec, "release"), Counter[pd.Timestamp]()
    for frame in chunks(spec, table):
        cells = frame["release"]
        if pd.api.types.is_numeric_dtype(cells) and not ways.excel:
            return None
        dates = cells if pd.api.types.is_datetime64_any_dtype(cells) else dates_of(_texts(cells), ways, table)
        if getattr(dates.dt, "tz", None) is not None:
            dates = dates.dt.tz_localize(None)
        if dates.isna().all() and not days:
            return None
        days.update(dates.dropna().dt.normalize().value_counts().to_dict())
    if not days:
        return None
    middle, before = sum(days.values()) / 2, 0
    for day in sorted(days):
        before += days[day]
        if before >= middle:
            break
    return min(one for one in days if one >= day - _AROUND_ALL).to_pydatetime()


def dates_of(text: pd.Series[Any], ways: Ways, table: Table) -> pd.Series[Any]:
    """Cells as dates, NaT where they are none, in the way of their column."""
    if not ways.excel:
        return read_dates(text, ways.slashes)
    mark = "," if table.decimal_comma else "."
    return of_excel(text.str.replace(mark, ".", regex=False))


def _texts(cells: pd.Series[Any]) -> pd.Series[Any]:
    """Cells as text, empty where there is nothing."""
    import pandas as pd

    if pd.api.types.is_integer_dtype(cells):
        return pd.Series(list(map(str, cells.tolist())), dtype=object)
    return pd.Series(
        ["" if value is None or value != value else str(value).strip() for value in cells.tolist()],  # noqa: PLR0124
        dtype=object,
    )


@dataclass(frozen=True)
class Ways:
    """In which way the times of a column are written: `slashes` as in `--dates`, or as `excel` counts days."""

    slashes: Slashes | None = None
    excel: bool = False


def ways_of(spec: OrdersFile, column: str) -> Ways:
    """How a column of times of a file is read, by all its rows; where two readings remain, `slashes` is None."""
    stat = check_there(table_of(spec).path)
    return _ways(spec, column, (stat.st_mtime_ns, stat.st_size))


@lru_cache(maxsize=16)
def _ways(spec: OrdersFile, column: str, _: tuple[int, int]) -> Ways:
    import pandas as pd

    table, readings, days = table_of(spec), set[Slashes | None](), set[bool]()
    for frame in chunks(spec, table):
        cells = frame[column]
        if pd.api.types.is_datetime64_any_dtype(cells):
            return Ways(spec.dates)
        text = _texts(cells)
        mark = "," if table.decimal_comma else "."
        numbers = pd.to_numeric(text[text != ""].str.replace(mark, ".", regex=False), errors="coerce")
        days.add(bool(numbers.notna().all()) and are_days_of_excel(numbers.to_numpy(dtype=float)))
        with_slashes = bool(text.str.match(SLASHES).any())
        if not with_slashes and not days <= {True}:
            break
        if with_slashes:
            readings.add(settled(text))
    readings.discard(None)
    slashes = spec.dates or (readings.pop() if len(readings) == 1 else None)
    return Ways(slashes, days == {True})


class Chunk:
    """Some rows of a file; what is wrong with them is `found`, and `bad` says with which."""

    def __init__(
        self,
        table: pd.DataFrame,
        spec: OrdersFile,
        how: Table,
        reading: Reading,
        midnight: dt.datetime | None,
        found: Problems,
    ) -> None:
        import numpy as np

        self.table = table
        self.spec = spec
        self.file = how
        self.how = reading
        self.midnight = midnight
        self.found = found
        self.bad = np.zeros(len(table), dtype=bool)
        self.pieces: list[int] = []
        self.unread: frozenset[int] = frozenset()
        self.told = self.bad & False  # rows of the column at hand whose cell is refused already

    def lines(self) -> list[OrderLine]:
        """The rows that could be read."""
        import numpy as np

        if BEYOND in self.table:
            beyond = (self.table[BEYOND] != "").to_numpy()
            self.problem(beyond, BEYOND, "cells beyond the header", "no more cells than it has")
        release = self._times("release", needed=True)
        due = self._times("due")
        self.problem(due < release, "due", "due before its release", "a time not before it")
        source, target = self._ends("from"), self._ends("to")
        priority, quantity = self._numbers("priority"), self._numbers("quantity")
        via, items = self._stops(), self._items()
        orders = [name or str(row) for row, name in zip(self.table.index, self._text("order"), strict=True)]
        dues = [None if value != value else value for value in due.tolist()]  # noqa: PLR0124 - not a number
        self.pieces = [1 if value is None else value for value in quantity]
        loads = self._loads()
        rows = zip(release.tolist(), source, target, dues, priority, loads, orders, via, items, strict=True)
        good = np.flatnonzero(~self.bad).tolist()
        self.unread = frozenset(np.flatnonzero(self.bad).tolist())
        lines = list(starmap(OrderLine, rows))
        return lines if len(good) == len(lines) else [lines[row] for row in good]

    def _loads(self) -> list[int]:
        """How many tasks each quantity is."""
        if self.spec.quantity == "tasks":
            return self.pieces
        most = self.spec.pieces_per_load
        return [1 if most is None else math.ceil(amount / most) for amount in self.pieces]

    def problem(self, rows: Any, column: str, wrong: str, expected: str) -> None:
        """Some rows, given as a mask, have a problem."""
        import numpy as np

        hit = np.flatnonzero(rows)
        if len(hit):
            self.bad[hit] = True
            name = "" if column == BEYOND else self.file.titles.get(column, column)
            cells = self.table[column] if column in self.table else self.table["release"]
            self.found.add(name, wrong, expected, self.table.index[hit].tolist(), cells.iloc[hit].tolist())

    def _text(self, column: str) -> list[str]:
        return _texts(self.table[column]).tolist() if column in self.table else [""] * len(self.table)

    def _times(self, column: str, *, needed: bool = False) -> Any:
        """Times from the start of the run in the model's unit, nan where there is none."""
        import numpy as np
        import pandas as pd

        if column not in self.table:
            return np.full(len(self.table), np.nan)
        cells, self.told = self.table[column], self.bad & False
        ways = ways_of(self.spec, column)
        if ways.excel:
            text = _texts(cells)
            found, empty = self._of_dates(dates_of(text, ways, self.file)), (text == "").to_numpy()
            self.found.ways[column] = "counts days, as Excel does"
        elif pd.api.types.is_datetime64_any_dtype(cells):
            found, empty = self._of_dates(cells), cells.isna().to_numpy()
            if getattr(cells.dt, "tz", None) is not None:
                self.found.zones[column] = str(cells.dt.tz)
                self.found.form("times with a zone", cells.tolist())
        elif pd.api.types.is_numeric_dtype(cells):
            found, empty = cells.to_numpy(dtype=float), cells.isna().to_numpy()
        else:
            text = _texts(cells)
            empty = (text == "").to_numpy()
            found = self._plain_numbers(text, column)
            left = np.isnan(found) & ~empty & ~self.told
            if left.any():
                ahead = self._check_zones(text[left], column)
                found[left] = self._of_text(text[left], ways) - ahead * 3600 / self.how.seconds
                if ways.slashes != self.spec.dates and text.str.match(SLASHES).any():
                    first = "month" if ways.slashes == "us" else "day"
                    self.found.ways[column] = f"has the {first} first, as some of its dates can be read in no other way"
        late = found > _LATEST / self.how.seconds
        self.problem(late, column, "later than 10 years after the start of the run", "seconds from it, or a date")
        early = found < 0
        cure = f"a number of at least 0, or a time such as 06:15 or {_EXAMPLE}"
        self.problem(early, column, "before the start of the run", cure)
        bad = ~empty & ~early & ~(found >= 0) & ~self.told
        slashes = self._text(column) if bad.any() and ways.slashes is None else []
        if slashes:
            unsaid = bad & np.array([bool(SLASHES.match(one)) for one in slashes], dtype=bool)
            self.problem(
                unsaid, column, "a date that may be meant in two ways", "--dates us or uk of desim orders to say which"
            )
            bad &= ~unsaid
        self.problem(bad | (empty if needed else False), column, "not a time", cure)
        return np.where((found >= 0) & ~late, found, np.nan)

    def _check_zones(self, text: pd.Series[Any], column: str) -> Any:
        """Refuse times of another zone than those before; a zone that all have is left out, and named.

        Returns by how many hours clocks are ahead: 1 or -1 after the change of a night, whose times are instants.
        """
        import numpy as np

        ahead = np.zeros(len(text))
        zones = text.str.extract(ZONE)[1].dropna()
        if len(zones):
            zone = self.found.zones.setdefault(column, zones.iloc[0])
            self.found.form("times with a zone", text[zones.index].tolist())
            by = {other: hours_between(other, zone) for other in zones.unique()}
            ahead = text.str.extract(ZONE)[1].map(by).fillna(0.0).to_numpy(dtype=float)
            changed = [other for other, hours in by.items() if abs(hours) == 1 and not {"Z", "z"} & {zone, other}]
            if changed and len(set(by.values()) - {0.0}) == 1:
                self.found.ways[column] = f"has {zone} and {changed[0]}: times are instants, on the clock of {zone}"
                return ahead
            others = self._mask(zones.index[zones != zone])
            self.told |= others
            self.problem(others, column, f"a time of another zone than {zone}", "all as on the clock of the hall")
            ahead = np.zeros(len(text))
        return ahead

    def _of_text(self, text: pd.Series[Any], ways: Ways) -> Any:
        """Times of day, and dates with times."""
        import numpy as np

        hands = text.str.extract(r"^(\d{1,2}):(\d{2})(?::(\d{2}(?:\.\d+)?))?$").astype(float).fillna({2: 0.0})
        seconds = (hands[0] * 3600 + hands[1] * 60 + hands[2]).to_numpy() - clock(self.how.start)
        dates = read_dates(text.where(np.isnan(seconds)), ways.slashes)
        self.found.form("times", text[dates.notna() & ~text.str.match(ISO)].tolist())
        return np.where(np.isnan(seconds), self._of_dates(dates) * self.how.seconds, seconds) / self.how.seconds

    def _of_dates(self, dates: pd.Series[Any]) -> Any:
        import pandas as pd

        if getattr(dates.dt, "tz", None) is not None:
            dates = dates.dt.tz_localize(None)
        start = pd.Timestamp(self.midnight or _DAY) + pd.Timedelta(seconds=clock(self.how.start))
        return (dates - start).dt.total_seconds().to_numpy(dtype=float) / self.how.seconds

    def _plain_numbers(self, text: pd.Series[Any], column: str) -> Any:
        """Cells as numbers, nan where they are none; with decimal commas, and points or commas between thousands."""
        import pandas as pd

        marks = ",." if self.file.decimal_comma else ","
        odd = [any(mark in cell for mark in marks) for cell in text]
        if any(odd):
            self.found.form("numbers", text[odd].tolist())
            text = text.where(~pd.Series(odd, text.index), self._with_points(text[odd], column))
        return pd.to_numeric(text, errors="coerce").to_numpy(dtype=float, copy=True)

    def _with_points(self, text: pd.Series[Any], column: str) -> pd.Series[Any]:
        """Numbers as programs write them; one reading for all of a column."""
        if not self.file.decimal_comma:
            return text.where(~text.str.fullmatch(r"[+-]?\d{1,3}(,\d{3})+(\.\d+)?"), text.str.replace(",", ""))
        grouped = text.str.fullmatch(r"[+-]?[1-9]\d{0,2}(\.\d{3})+")  # or a decimal point
        point = text.str.fullmatch(r"[+-]?\d*\.\d+") & ~grouped
        comma = text.str.fullmatch(r"[+-]?(\d+|\d{1,3}(\.\d{3})+),\d+")
        mark = self.found.decimals.get(column) or ("," if comma.any() else "." if point.any() else "")
        if mark:
            self.found.decimals[column] = mark
        mixed = comma if mark == "." else point
        if mark == "." and column in self.found.thousands:
            mixed = mixed | point
        if mark != ".":
            if grouped.any() and not mark:
                self.found.thousands.add(column)
            text = text.where(~(grouped | comma), text.str.replace(".", "").str.replace(",", "."))
        rows = self._mask(text.index[mixed])
        self.told |= rows
        self.problem(rows, column, "a decimal point and a decimal comma in one column", "the same in all rows")
        return text.where(~mixed, "")

    def _numbers(self, column: str) -> list[int | None]:
        import numpy as np
        import pandas as pd

        if column not in self.table:
            return [None] * len(self.table)
        text = _texts(self.table[column])
        self.told = self.bad & False
        is_number = pd.api.types.is_numeric_dtype(self.table[column])
        found = self.table[column].to_numpy(dtype=float) if is_number else self._plain_numbers(text, column)
        least = NUMBERS[column]
        empty = (text == "").to_numpy()
        left = np.isnan(found) & ~empty & ~self.told
        if column == "quantity" and left.any():
            self.found.form("quantities", text[left].tolist())
            found[left] = self._plain_numbers(text[left].str.replace(_COUNTED, r"\1", regex=True), column)
        bad = ~empty & ~self.told & ~((found >= least) & (found == np.floor(found)) & (found <= LIMITS["number"][0]))
        expected = "a whole number" if column == "priority" else "a whole number of at least 1, alone or with ST or pcs"
        self.problem(bad, column, "not a number of this kind", expected)
        return [
            None if none or wrong else int(value)
            for value, none, wrong in zip(found, empty, bad | self.told, strict=True)
        ]

    def _stops(self) -> list[tuple[str | int, ...] | None]:
        """The places of `B > C`, in order."""
        if "via" not in self.table:
            return [None] * len(self.table)
        if self.how.items:
            stops = [row for row, text in enumerate(self._text("via")) if text]
            self.problem(self._mask(stops), "via", "a stop on the way", "none: pods go to a station and back")
        known: dict[str, tuple[str | int, ...] | None] = {"": None}
        lost: dict[str, list[int]] = {}
        found: list[tuple[str | int, ...] | None] = []
        for row, text in enumerate(self._text("via")):
            if text not in known:
                ends = [self._end(part.strip()) for part in text.split(">")]
                known[text] = tuple(end for end in ends if end is not None) if None not in ends else None
            if known[text] is None and text:
                lost.setdefault(text, []).append(row)
            found.append(known[text])
        for text, rows in lost.items():
            wrong = next(part.strip() for part in text.split(">") if self._end(part.strip()) is None)
            expected = self._expected(wrong, "places such as B > C: ")
            self.problem(self._mask(rows), "via", f"no such place, '{wrong}'", expected)
        return found

    def _items(self) -> list[int | None]:
        """With pods the number of the item of each row; None: any, by popularity."""
        if "item" not in self.table or not self.how.items:
            return [None] * len(self.table)
        known, texts = self.how.item_numbers, [text.removesuffix(".0") for text in self._text("item")]
        lost = [row for row, text in enumerate(texts) if text and text not in known]
        if lost:
            near = nearest(texts[lost[0]], known) if len(known) <= _COMPARED else None
            expected = "an item that a pod holds" if self.how.sold else f"a number from 0 to {self.how.items - 1}"
            hint = f"; did you mean '{near}'?" if near else ""
            self.problem(self._mask(lost), "item", "no such item", f"{expected} (pods.items){hint}")
        return [known.get(text) for text in texts]

    def _mask(self, rows: Iterable[int]) -> Any:
        mask = self.bad & False
        mask[list(rows)] = True
        return mask

    def _expected(self, text: str, among: str = "") -> str:
        known = [*self.how.names, *self.how.numbers]
        near = nearest(text, known) if len(known) <= _COMPARED else None
        hint = f"; did you mean '{near}'?" if near else ""
        if self.how.items:
            return f"a station, or 'storage': with pods a row names an item (column item){hint}"
        any_storage = "" if among else "'storage', "
        return f"{among}a node, a station, {any_storage}or a storage place from 0 to {self.how.places - 1}{hint}"

    def _ends(self, column: str) -> list[str | int | None]:
        """Names of nodes and stations, numbers and names of storage places, `storage` for any of these."""
        if column not in self.table:
            return [None] * len(self.table)
        known: dict[str, str | int | None] = {"": None, STORAGE: STORAGE}
        texts = self._text(column)
        for text in dict.fromkeys(texts):
            if text not in known:
                known[text] = self._end(text)
        lost = [row for row, text in enumerate(texts) if text and known[text] is None]
        if lost:
            self.problem(self._mask(lost), column, "no such place", self._expected(texts[lost[0]]))
        return [known[text] for text in texts]

    def _end(self, text: str) -> str | int | None:
        if text in self.how.names:
            return text
        if text in self.how.numbers:
            return self.how.numbers[text]
        number = text.removesuffix(".0")
        return int(number) if number.isdecimal() and int(number) < self.how.places else None


def clock(start: str) -> float:
    """The seconds from midnight of `06:00`, or of a date with a time."""
    time = dt.time.fromisoformat(start.rpartition("T")[2] or "00:00")
    return time.hour * 3600 + time.minute * 60 + time.second + time.microsecond / 1e6


def _midnight(start: str) -> dt.datetime | None:
    """The day on which the run starts, or None where only its time is known."""
    if "T" not in start:
        return None
    return dt.datetime.fromisoformat(start.partition("T")[0])
