"""Cells of an export as times and numbers, in the ways in which people and programs write them.

A column has one reading of dates, points and commas, by all its rows. Row by row `2.5` beside `1,5` was 2.5 beside 1.5,
and `1.234` beside `2.5` was 1,234. Going by the language of the headings was rejected, which are often English in
German exports. Where only `1.234` stands it is 1,234, as SAP writes it, and that is said. Times have no zone, as the
calendars of the hall have none; a column with two is refused, but for those of a night of a clock change.
"""

from __future__ import annotations

import datetime as dt
import math
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from desim_warehouse.model.sections.order_lines import OrderRows, Problems, Reading
from desim_warehouse.orders.export import Export
from desim_warehouse.values.dates import (
    SLASHES,
    ZONE,
    Slashes,
    are_days_of_excel,
    hours_between,
    of_excel,
    read_dates,
    settled,
)

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd

_AROUND_ALL = dt.timedelta(days=366)
"""Orders so long before most others are dates of nothing, such as 1900-01-01, and no start of a run."""
_HALF_A_DAY = 43_200.0
_COUNTED = r"(?i)^([\d.,]+)\s*(?:st|stk|stck|stück|stueck|pc|pcs|pce|pieces?|ea|each|units?)\.?$"
"""Quantities with a word for pieces; kilograms, cartons or pallets are none."""
_GROUPED, _POINT = r"[+-]?[1-9]\d{0,2}(\.\d{3})+", r"[+-]?\d*\.\d+"
_COMMA, _THOUSANDS = r"[+-]?(\d+|\d{1,3}(\.\d{3})+),\d+", r"[+-]?\d{1,3}(,\d{3})+(\.\d+)?"


class _Times(NamedTuple):
    """A column of times: each cell is a number, a time of day, or a date; nan and NaT for the others."""

    numbers: np.ndarray[Any, Any]
    hands: np.ndarray[Any, Any]
    dates: pd.Series[Any]


class ExportRows(OrderRows):
    """Rows of an export; `assumed` has how its cells are read, where they may be meant otherwise."""

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
        self._columns = {"release": (release := self._parsed("release"))}
        self._cross_midnight(release.hands)
        if "due" in export.cells:
            self._columns["due"] = due = self._parsed("due", dated=bool(release.dates.notna().any()))
            due.hands[release.hands - due.hands > _HALF_A_DAY / how.seconds] += 2 * _HALF_A_DAY / how.seconds
            self._to_the_end_of_days(due.dates)
        if _are_days(release.dates):
            text = "have no time of day: all orders of a day come at 00:00"
            self.assumed.append(f"dates in '{self.titles['release']}' {text}")
        if self.midnight is None:
            self.midnight = _first_day(release.dates)

    def times(self, column: str, _text: pd.Series[Any]) -> Any:
        """Cells as times from the start of the run in the model's unit, nan where they are none."""
        import numpy as np

        numbers, hands, dates = self._columns[column]
        since = self.how.since_start(dates, self.midnight)
        return np.where(np.isnan(numbers), np.where(np.isnan(hands), since, hands), numbers)

    def amounts(self, column: str, text: pd.Series[Any]) -> Any:
        """Cells as numbers, nan where they are none; with decimal commas, and points or commas between thousands."""
        import pandas as pd

        text = text.str.replace(_COUNTED, r"\1", regex=True) if column == "quantity" else text
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
        """How many tasks each quantity of pieces is."""
        self.pieces = quantities
        most = self._per_load
        return [max(1, math.ceil(amount / most)) for amount in quantities] if most else quantities

    def _parsed(self, column: str, *, dated: bool = False) -> _Times:
        """A column of times, in its one reading; `dated`: whether numbers are rather days than seconds."""
        import numpy as np
        import pandas as pd

        text = self.cells[column]
        filled = (text != "").to_numpy()
        numbers, none = self.amounts(column, text), np.full(len(text), np.nan)
        if filled.any() and are_days_of_excel(numbers[filled], whole=dated):
            self.assumed.append(f"'{self.titles[column]}' counts days, as Excel does")
            return _Times(none, none.copy(), of_excel(text.str.replace("," if self._comma else ".", ".", regex=False)))
        text = text.where(np.isnan(numbers), "")
        hands = self.hands(text)
        text = text.where(np.isnan(hands), "")
        dates = read_dates(text, self._way(column, text)) - pd.to_timedelta(self._ahead(column, text), unit="h")
        return _Times(numbers, hands, dates)

    def _cross_midnight(self, hands: np.ndarray[Any, Any]) -> None:
        """Put times of day that come after midnight in a night shift on the next day.

        They follow later ones, in rows that rise otherwise; or they are more than 12 h before the start of the run.
        """
        import numpy as np

        rows = np.flatnonzero(~np.isnan(hands))
        times, half = hands[rows], _HALF_A_DAY / self.how.seconds
        falls = np.flatnonzero(np.diff(times) < 0)
        next_day = times < -half
        if len(falls) == 1 and -np.diff(times)[falls[0]] > half and times[-1] < times[0]:
            next_day = np.arange(len(times)) > falls[0]
        if next_day.any():
            hands[rows[next_day]] += 2 * half
            first = self.cells["release"].iloc[rows[next_day][0]]
            self.assumed.append(f"'{self.titles['release']}' crosses midnight: {first} is on the next day")

    def _to_the_end_of_days(self, dates: pd.Series[Any]) -> None:
        """Put due dates without a time of day at the end of their day."""
        alone = dates.notna() & (_are_days(dates) or ~self.cells["due"].str.contains(":"))
        if alone.any():
            dates[alone] += dt.timedelta(days=1)
            self.assumed.append(f"dates in '{self.titles['due']}' have no time of day: due at the end of the day")

    def _way(self, column: str, text: pd.Series[Any]) -> Slashes | None:
        """How dates with slashes are meant; those that may be meant in two ways are refused."""
        with_slashes = text.str.match(SLASHES).to_numpy(dtype=bool)
        if self._slashes or not with_slashes.any():
            return self._slashes
        way = settled(text)
        if way is None:
            cure = "--dates us or uk of desim orders to say which"
            self.flag(with_slashes, column, "a date that may be meant in two ways", cure)
        else:
            first = "month" if way == "us" else "day"
            reason = "as some of its dates can be read in no other way"
            self.assumed.append(f"'{self.titles[column]}' has the {first} first, {reason}")
        return way

    def _ahead(self, column: str, text: pd.Series[Any]) -> Any:
        """By how many hours the clock of each time is ahead of the first: 1 or -1 after a clock change.

        Times of any other zone than the first are refused; a zone that all have is left out, and named.
        """
        zones = text.str.extract(ZONE)[1]
        if not len(offsets := zones.dropna().unique()):
            return 0.0
        zone, *others = offsets
        title, hours = self.titles[column], {other: hours_between(other, zone) for other in offsets}
        if len(others) == 1 and abs(hours[others[0]]) == 1 and not {"Z", "z"} & set(offsets):
            self.assumed.append(f"'{title}' has {zone} and {others[0]}: times are instants, on the clock of {zone}")
            return zones.map(hours).fillna(0.0)
        self.assumed.append(f"'{title}' is as on the clock of the hall: {zone} is left out")
        other = (zones.notna() & (zones != zone)).to_numpy(dtype=bool)
        self.flag(other, column, f"a time of another zone than {zone}", "all as on the clock of the hall")
        return 0.0


def _are_days(dates: pd.Series[Any]) -> bool:
    """Whether there are dates, and none has a time of day."""
    days = dates.dropna()
    return len(days) > 0 and bool((days == days.dt.normalize()).all())


def _first_day(dates: pd.Series[Any]) -> dt.datetime | None:
    """The day of the first order, sentinel dates long before most orders left out; None where there are no dates."""
    days = dates.dropna().dt.normalize().sort_values()
    if days.empty:
        return None
    middle = days.iloc[(len(days) - 1) // 2]
    day: dt.datetime = days[days >= middle - _AROUND_ALL].iloc[0].to_pydatetime()
    return day
