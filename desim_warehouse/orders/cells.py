"""Parse cells of an export as times and numbers, in the notations of people and programs.

For `desim orders`.

Dates, points and commas are read in one way per column, by all its rows. Row by row, `2.5` beside `1,5` was 2.5 beside
1.5, and `1.234` beside `2.5` was 1,234. The language of the headings was rejected as a criterion, as they are often
English in German exports. A lone `1.234` is 1,234, as SAP writes it, and this is reported. Times have no zone, as the
calendars of the hall have none; a column with two is refused, except where clocks change.
"""

from __future__ import annotations

import datetime as dt
import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar

from desim_warehouse.model.sections.flows import ORDER_COLUMNS
from desim_warehouse.model.sections.order_lines import OrderRows, Problems, Reading
from desim_warehouse.model.workbook import NO_VALUE, RECALCULATE
from desim_warehouse.orders.export import Export
from desim_warehouse.values.dates import (
    TWOFOLD,
    Slashes,
    Times,
    across_midnight,
    end_across_midnight,
    exchanged,
    read_times,
)

if TYPE_CHECKING:
    import pandas as pd

_AROUND_ALL = dt.timedelta(days=366)
"""Orders so long before most others have sentinel dates, such as 1900-01-01, which are no start of a run."""
_HOUR, _UTC = dt.timedelta(hours=1), dt.timedelta()
_NIGHT = dt.timedelta(hours=12)
"""The longest stretch of orders that is one night, in which times are instants if clocks change."""
_SEASON = dt.timedelta(days=120)
"""Clocks change at most once in so many days."""
_LAST_DAY = dt.datetime(9999, 12, 31)  # noqa: DTZ001 - wall clock
_COUNTED = r"(?i)^([\d.,'’\s]*[\d.,])\s*(?:st|stk|stck|stück|stueck|pc|pcs|pce|pieces?|ea|each|units?)\.?$"
"""Quantities with a word for pieces, as opposed to kilograms, cartons or pallets."""
_GROUPED, _POINT = r"[+-]?[1-9]\d{0,2}(\.\d{3})+", r"[+-]?\d*\.\d+"
_COMMA, _THOUSANDS = r"[+-]?(\d+|\d{1,3}(\.\d{3})+),\d+", r"[+-]?\d{1,3}(,\d{3})+(\.\d+)?"
_APART, _PARTED = r"[ '’\u00a0\u2009\u202f]", r"[+-]?\d{1,3}([ '’\u00a0\u2009\u202f]\d{3})+([.,]\d+)?"
"""Blanks and apostrophes between thousands, as in France and Switzerland."""


class ExportRows(OrderRows):
    """Rows of an export; `assumed` says how ambiguous cells are read."""

    quantity: ClassVar = "a whole number of at least 1, alone or with ST or pcs"

    def __init__(
        self, export: Export, how: Reading, problems: Problems, dates: Slashes | None, per_load: float | None
    ) -> None:
        super().__init__(export.cells, how, problems, how.day, export.titles)
        self.assumed: list[str] = []
        self.pieces: list[int] = []
        self._comma = export.decimal_comma
        self._slashes = dates
        self._per_load = per_load
        for column in [name for name in ORDER_COLUMNS if name in export.cells]:
            no_value = self.cells[column].str.contains(NO_VALUE, regex=False)
            self.flag(no_value.to_numpy(), column, "no value", f"one; {RECALCULATE}")
        self._columns = {"release": (release := self._parsed("release"))}
        if later := across_midnight(release.clocks, how.clock):
            first = self.cells["release"].iloc[later[0]]
            self.assumed.append(f"'{self.titles['release']}' crosses midnight: {first} is on the next day")
        if "due" in export.cells:
            self._columns["due"] = due = self._parsed("due", whole=any(release.dates))
            end_across_midnight(release.clocks, due.clocks)
            due.dates = self._to_the_end_of_days(due.dates)
        if _are_days(release.dates):
            text = "have no time of day: all orders of a day come at 00:00"
            self.assumed.append(f"dates in '{self.titles['release']}' {text}")
        if self.midnight is None:
            self.midnight = _first_day(release.dates)

    def times(self, column: str, _text: pd.Series[Any]) -> Any:
        """Read cells as times from the start of the run in the model's unit; nan for other cells."""
        import numpy as np

        read, midnight = self._columns[column], self.midnight or _LAST_DAY
        dates = [math.nan if date is None else (date - midnight).total_seconds() for date in read.dates]
        return np.fmax(read.numbers, (np.fmax(dates, read.clocks) - self.how.clock) / self.how.seconds)

    def amounts(self, column: str, text: pd.Series[Any]) -> Any:
        """Read cells as numbers, with decimal commas and marks between thousands; nan for other cells."""
        import pandas as pd

        text = text.str.replace(_COUNTED, r"\1", regex=True) if column == "quantity" else text
        text = text.where(~text.str.fullmatch(_PARTED), text.str.replace(_APART, "", regex=True))
        if not self._comma:
            text = text.where(~text.str.fullmatch(_THOUSANDS), text.str.replace(",", ""))
            return pd.to_numeric(text, errors="coerce").to_numpy(dtype=float)
        grouped, comma = text.str.fullmatch(_GROUPED), text.str.fullmatch(_COMMA)
        point = text.str.fullmatch(_POINT) & ~grouped
        if comma.any():
            wrong = "a decimal point and a decimal comma in one column"
            self.flag(point.to_numpy(dtype=bool), column, wrong, "the same in all rows")
            text = text.where(~point, "")
        elif grouped.any() and not point.any():
            self.assumed.append(f"points in '{self.titles[column]}' stand between thousands")
        if not point.any() or comma.any():
            text = text.where(~(grouped | comma), text.str.replace(".", "").str.replace(",", "."))
        return pd.to_numeric(text, errors="coerce").to_numpy(dtype=float)

    def loads(self, quantities: list[int]) -> list[int]:
        """Return the number of tasks that each quantity of pieces takes."""
        self.pieces = quantities
        most = self._per_load
        return [max(1, math.ceil(amount / most)) for amount in quantities] if most else quantities

    def _parsed(self, column: str, *, whole: bool = False) -> Times:
        """Parse a column of times in the one way that fits all its cells, on one clock.

        Whole numbers are Excel days rather than seconds if that is certain (`whole`), or if the column is not called
        `release`, as in our own tables.
        """
        text, title = self.cells[column], self.titles[column]
        numbers = self.amounts(column, text).tolist()
        read = read_times(text.tolist(), self._slashes, numbers=numbers, whole=whole or title != column)
        self.assumed += [f"'{title}' {note}" for note in read.notes]
        if title != column:
            self._check_numbers(column, read)
        self.flag(read.twofold, column, TWOFOLD, "--dates us or uk of desim orders to say which")
        wrong = "a date whose day and month a spreadsheet may have exchanged, as those above 12 are text"
        self.flag(exchanged(text.tolist(), read.dates), column, wrong, "the file that was opened there")
        read.dates = self._on_one_clock(column, read.dates)
        return read

    def _check_numbers(self, column: str, read: Times) -> None:
        """Refuse numbers beside dates or times of day; numbers alone count from the start of the run, which is said."""
        are_numbers = [not math.isnan(number) for number in read.numbers]
        if any(read.dates) or not all(map(math.isnan, read.clocks)):
            self.flag(are_numbers, column, "a number among dates or times of day", "the same in all rows")
        elif any(are_numbers):
            self.assumed.append(f"'{self.titles[column]}' counts the time from the start of the run")

    def _on_one_clock(self, column: str, dates: list[dt.datetime | None]) -> list[dt.datetime | None]:
        """Remove the offsets from UTC of dates, and add their interpretation to `assumed`.

        In the night of a clock change all are on the clock of the first; in longer files each is on the clock of its
        day, as shifts are. Times of any other zone are refused.
        """
        zones = [None if date is None else date.utcoffset() for date in dates]
        offsets = [*dict.fromkeys(zone for zone in zones if zone is not None)]
        if not offsets:
            return dates
        title, texts = self.titles[column], self.cells[column].tolist()
        in_utc = any(zone == _UTC and text[-1].isalpha() for zone, text in zip(zones, texts, strict=True))
        first, *others = ((str(dt.timezone(zone))[3:] or "+00:00") if zone or not in_utc else "Z" for zone in offsets)
        ahead = dict.fromkeys(offsets, _UTC)
        stamps = sorted(date for date in dates if date is not None and date.tzinfo is not None)
        is_change = not in_utc and _clocks_change(stamps, offsets)
        if is_change and stamps[-1] - stamps[0] <= _NIGHT:
            ahead[offsets[1]] = offsets[1] - offsets[0]
            self.assumed.append(f"'{title}' has {first} and {others[0]}: times are instants, on the clock of {first}")
        elif is_change:
            both = f"{first} and {others[0]}"
            self.assumed.append(f"'{title}' is as on the clock of the hall, which changes: {both} are left out")
        else:
            self.assumed.append(f"'{title}' is as on the clock of the hall: {first} is left out")
            other = [zone is not None and zone != offsets[0] for zone in zones]
            self.flag(other, column, f"a time of another zone than {first}", "all as on the clock of the hall")
        return [
            None if date is None else date.replace(tzinfo=None) - (_UTC if zone is None else ahead[zone])
            for date, zone in zip(dates, zones, strict=True)
        ]

    def _to_the_end_of_days(self, dates: list[dt.datetime | None]) -> list[dt.datetime | None]:
        """Move due dates without a time of day to the end of their day."""
        days = _are_days(dates)
        alone = [
            _has_no_time(date) and (days or ":" not in text)
            for date, text in zip(dates, self.cells["due"], strict=True)
        ]
        if any(alone):
            self.assumed.append(f"dates in '{self.titles['due']}' have no time of day: due at the end of the day")
        return [
            date if date is None or not is_alone or date >= _LAST_DAY else date + dt.timedelta(days=1)
            for date, is_alone in zip(dates, alone, strict=True)
        ]


def _clocks_change(stamps: list[dt.datetime], offsets: list[dt.timedelta]) -> bool:
    """Whether one place has two offsets from UTC, in summer and in winter; `stamps`: in order of time."""
    if len(offsets) != 2 or abs(offsets[1] - offsets[0]) != _HOUR:  # noqa: PLR2004
        return False
    changes = sum(a.utcoffset() != b.utcoffset() for a, b in pairwise(stamps))
    return changes <= 1 + (stamps[-1] - stamps[0]) // _SEASON


def _has_no_time(date: dt.datetime | None) -> bool:
    return date is not None and date.time() == dt.time()


def _are_days(dates: list[dt.datetime | None]) -> bool:
    """Whether there are dates, all without a time of day."""
    return any(dates) and all(date is None or _has_no_time(date) for date in dates)


def _first_day(dates: list[dt.datetime | None]) -> dt.datetime | None:
    """Return the day of the first order, ignoring sentinel dates long before most orders; None without dates."""
    days = sorted(date.replace(hour=0, minute=0, second=0, microsecond=0) for date in dates if date is not None)
    if not days:
        return None
    middle = days[(len(days) - 1) // 2]
    return next(day for day in days if middle - day <= _AROUND_ALL)
