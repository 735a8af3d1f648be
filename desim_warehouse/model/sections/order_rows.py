"""Rows of a file of orders as lines in the words of the model, and what is wrong with them, summed up by kind.

Times are numbers from the start of the run, times of day, or dates: ISO, and as people write them: German, US or
British, with months in digits or in words. A table that `desim orders` wrote has only the first three.
"""

from __future__ import annotations

import datetime as dt
import math
import re
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
from desim_warehouse.values.fields import LIMITS

if TYPE_CHECKING:
    import pandas as pd

NUMBERS = {"priority": -LIMITS["number"][0], "quantity": 1}
"""Columns of whole numbers, and the least of each."""
_EXAMPLE = "2026-03-02T06:15"
_DAY = dt.datetime(2000, 1, 1)  # noqa: DTZ001 - wall clock
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

    earliest = None
    table = table_of(spec)
    for frame in chunks(spec, table):
        cells = frame["release"]
        if pd.api.types.is_numeric_dtype(cells):
            return None
        dates = cells if pd.api.types.is_datetime64_any_dtype(cells) else read_dates(_texts(cells), spec.dates)
        if getattr(dates.dt, "tz", None) is not None:
            dates = dates.dt.tz_localize(None)
        day = dates.min()
        if pd.isna(day) and earliest is None:
            return None
        if not pd.isna(day) and (earliest is None or day < earliest):
            earliest = day
    return None if earliest is None else earliest.normalize().to_pydatetime()


def _texts(cells: pd.Series[Any]) -> pd.Series[Any]:
    """Cells as text, empty where there is nothing."""
    import pandas as pd

    if pd.api.types.is_integer_dtype(cells):
        return pd.Series(list(map(str, cells.tolist())), dtype=object)
    return pd.Series(
        ["" if value is None or value != value else str(value).strip() for value in cells.tolist()],  # noqa: PLR0124
        dtype=object,
    )


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
        cells = self.table[column]
        self.told = self.bad & False
        if pd.api.types.is_datetime64_any_dtype(cells):
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
                self._check_zones(text[left], column)
                found[left] = self._of_text(text[left])
        late = found > _LATEST / self.how.seconds
        self.problem(late, column, "later than 10 years after the start of the run", "seconds from it, or a date")
        early = found < 0
        cure = f"a number of at least 0, or a time such as 06:15 or {_EXAMPLE}"
        self.problem(early, column, "before the start of the run", cure)
        bad = ~empty & ~early & ~(found >= 0) & ~self.told
        slashes = self._text(column) if bad.any() and self.spec.dates is None else []
        if slashes:
            unsaid = bad & np.array([bool(SLASHES.match(one)) for one in slashes], dtype=bool)
            self.problem(
                unsaid, column, "a date that may be meant in two ways", "--dates us or uk of desim orders to say which"
            )
            bad &= ~unsaid
        self.problem(bad | (empty if needed else False), column, "not a time", cure)
        return np.where((found >= 0) & ~late, found, np.nan)

    def _check_zones(self, text: pd.Series[Any], column: str) -> None:
        """Refuse times of another zone than those before; a zone that all have is left out, and named."""
        zones = text.str.extract(ZONE)[1].dropna()
        if len(zones):
            zone = self.found.zones.setdefault(column, zones.iloc[0])
            self.found.form("times with a zone", text[zones.index].tolist())
            others = self._mask(zones.index[zones != zone])
            self.told |= others
            self.problem(others, column, f"a time of another zone than {zone}", "all as on the clock of the hall")

    def _of_text(self, text: pd.Series[Any]) -> Any:
        """Times of day, and dates with times."""
        import numpy as np

        hands = text.str.extract(r"^(\d{1,2}):(\d{2})(?::(\d{2}(?:\.\d+)?))?$").astype(float).fillna({2: 0.0})
        seconds = (hands[0] * 3600 + hands[1] * 60 + hands[2]).to_numpy() - clock(self.how.start)
        dates = read_dates(text.where(np.isnan(seconds)), self.spec.dates)
        self.found.form("times", text[dates.notna() & ~text.str.match(_ISO)].tolist())
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


# Dates as people write them

_AROUND = r"(?i)^(?:mo|di|mi|do|fr|sa|so|mon|tue|wed|thu|fri|sat|sun)[a-zäö]{0,8}\.?,? +(?=\d|[a-zä]{3})|,? uhr$"
"""What stands around a date: a day of the week before it, *Uhr* after the time."""
_MONTH_WORDS = (
    "jan january januar jänner",
    "feb february februar",
    "mar march mär mrz märz maerz",
    "apr april",
    "may mai",
    "jun june juni",
    "jul july juli",
    "aug august",
    "sep sept september",
    "oct october okt oktober",
    "nov november",
    "dec december dez dezember",
)
_MONTHS = {word: number for number, words in enumerate(_MONTH_WORDS, 1) for word in words.split()}
_WORD = r"[^\W\d_]{3}"
_DAY_MONTH = re.compile(
    r"(?P<day>\d{1,2})(?:st|nd|rd|th)?[. -]{1,2}(?P<month>[^\W\d_]{3,9})\.?[ ,-]{1,2}(?P<year>\d{4}|\d{2})(?=[ ,]|$)"
)
_MONTH_DAY = re.compile(r"(?P<month>[^\W\d_]{3,9})\.? (?P<day>\d{1,2})(?:st|nd|rd|th)?,? (?P<year>\d{4})(?=[ ,]|$)")
_ISO = r"\d{4}-?\d"
_WRITTEN = (
    r"^(?P<a>\d{1,2})(?P<mark>[./-])(?P<b>\d{1,2})(?P=mark)(?P<year>\d{4}|\d{2})"
    r"(?:[ T,]+(?P<hour>\d{1,2}):(?P<minute>\d{2})(?::(?P<second>\d{2}(?:[.,]\d+)?))?"
    r" ?(?:(?P<half>[AaPp])\.?[Mm]\.?)?)?$"
)
ZONE = r"^(\d{4}-?\d\d-?\d\d[T ]\d\d(?::?\d\d){0,2}(?:[.,]\d+)?) ?([Zz]|[+-]\d\d(?::?\d\d)?)$"
"""A date with a time, and the time zone behind it."""
SLASHES = re.compile(r"\d{1,2}([/-])\d{1,2}\1\d{2}")
"""Dates with slashes or hyphens, which may be meant in two ways."""


def read_dates(text: pd.Series[Any], slashes: str | None) -> pd.Series[Any]:
    """Dates with times, as people write them: ISO, 02.03.2026 14:00, 2 Mar 2026, and with slashes if it is said how.

    Time zones are left out.
    """
    import pandas as pd

    text = text.str.replace(_AROUND, "", regex=True).str.replace(ZONE, r"\1", regex=True)
    with_words = text.str.contains(_WORD, na=False)
    if with_words.any():
        text = text.where(~with_words, text[with_words].map(_month_as_number))
    found = pd.to_datetime(text.where(text.str.match(_ISO)), format="ISO8601", errors="coerce")
    parts = text.str.extract(_WRITTEN)
    dotted = parts["mark"] == "."
    if not (parts["mark"].notna() & (dotted | (slashes is not None))).any():
        return found
    month_first = ~dotted & (slashes == "us")
    day, month = parts["a"].where(~month_first, parts["b"]), parts["b"].where(~month_first, parts["a"])
    year = parts["year"].where(parts["year"].str.len() != 2, "20" + parts["year"])  # noqa: PLR2004 - of the century
    hour = pd.to_numeric(parts["hour"]).fillna(0)
    half = parts["half"].str.lower()
    hour = hour.where(half.isna(), hour % 12 + 12 * (half == "p"))
    known = dotted | (parts["mark"].notna() & (slashes is not None))
    days = pd.to_datetime((year + "-" + month + "-" + day).where(known), format="%Y-%m-%d", errors="coerce")
    minutes, seconds = pd.to_numeric(parts["minute"]).fillna(0), pd.to_numeric(parts["second"].str.replace(",", "."))
    late = (hour > 23) | (minutes > 59) | (seconds > 60)  # noqa: PLR2004 - of a clock
    time = pd.to_timedelta(hour * 3600 + minutes * 60 + seconds.fillna(0), unit="s")
    return found.where(found.notna(), (days + time).where(~late).astype(found.dtype))


def _month_as_number(text: str) -> str:
    """`2 Mar 2026` and `March 2, 2026` as 2.3.2026, with what follows; as it is where no month is named."""
    found = _DAY_MONTH.match(text) or _MONTH_DAY.match(text)
    month = found and _MONTHS.get(found["month"].casefold())
    return f"{found['day']}.{month}.{found['year']}{text[found.end() :]}" if found and month else text
