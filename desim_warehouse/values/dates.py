"""Dates and times as people and programs write them: the one reader of orders, trips and whatever else has some.

ISO with `T` or a blank, with AM and PM; German (02.03.2026 14:00), US and British (3/2/2026 2:00 PM), with months in
digits or in words, in English and German; days since 1900 as Excel counts them. Where two readings remain, a column is
read as its dates that have one only (12/13/2018), or else not at all: the user is asked.
"""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    import pandas as pd

Slashes = Literal["us", "uk"]
"""Whether 03/02/2026 is March 2, or 3 February."""
EXCEL = dt.datetime(1899, 12, 30)  # noqa: DTZ001 - wall clock
"""The day from which Excel counts days, except for days before March 1900."""
_EXCEL_DAYS, _MOST_DAYS = (36_526.0, 73_050.0), 31.0
"""The years 2000 to 2099 in days of Excel, and the longest stretch of days that is taken for such."""
_PARTS = re.compile(r"(\d{1,2})([/-])(\d{1,2})\2\d{2}")
_MONTHS_OF_A_YEAR = 12
_DAY = 86_400.0

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
ISO = r"\d{4}-?\d"
"""How dates begin that are as the standard has them."""
_WRITTEN = (
    r"^(?P<a>\d{1,2})(?P<mark>[./-])(?P<b>\d{1,2})(?P=mark)(?P<year>\d{4}|\d{2})"
    r"(?:[ T,]+(?P<hour>\d{1,2}):(?P<minute>\d{2})(?::(?P<second>\d{2}(?:[.,]\d+)?))?"
    r" ?(?:(?P<half>[AaPp])\.?[Mm]\.?)?)?$"
)
_YEAR_FIRST = r"^(\d{4})([/.-])(\d{1,2})\2(\d{1,2})(?=$|[ T,])"
_NEEDS_HANDS = r"(?i)^\d{4}(?:[/.]|.*(?:[ap]\.?m\.?|[T ]24:00(?::00)?)$)"
"""Dates with the year first whose time, or mark, ISO does not have."""
ZONE = r"^(\d{4}-?\d\d-?\d\d[T ]\d\d(?::?\d\d){0,2}(?:[.,]\d+)?) ?([Zz]|[+-]\d\d(?::?\d\d)?)$"
"""A date with a time, and the time zone behind it."""
SLASHES = re.compile(r"\d{1,2}([/-])\d{1,2}\1\d{2}")
"""Dates with slashes or hyphens, which may be meant in two ways."""


def read_dates(text: pd.Series[Any], slashes: str | None) -> pd.Series[Any]:
    """Read dates with times as people write them: ISO, 02.03.2026 14:00, 2 Mar 2026, or with slashes of a stated order.

    Time zones are left out; 24:00 is the midnight that ends a day. What is no date is NaT.
    """
    import pandas as pd

    text = text.str.replace(_AROUND, "", regex=True).str.replace(ZONE, r"\1", regex=True)
    with_words = text.str.contains(_WORD, na=False)
    if with_words.any():
        text = text.where(~with_words, text[with_words].map(_month_as_number))
    by_hand = text.str.contains(_NEEDS_HANDS, na=False, regex=True)
    if by_hand.any():
        text = text.where(~by_hand, text.str.replace(_YEAR_FIRST, r"\4.\3.\1", regex=True))
    dates = pd.to_datetime(text.where(text.str.match(ISO)), format="ISO8601", errors="coerce")
    parts = text.str.extract(_WRITTEN)
    dotted = parts["mark"] == "."
    if not (parts["mark"].notna() & (dotted | (slashes is not None))).any():
        return dates
    month_first = ~dotted & (slashes == "us")
    day, month = parts["a"].where(~month_first, parts["b"]), parts["b"].where(~month_first, parts["a"])
    year = parts["year"].where(parts["year"].str.len() != 2, "20" + parts["year"])  # noqa: PLR2004 - of the century
    hour = pd.to_numeric(parts["hour"]).fillna(0)
    half = parts["half"].str.lower()
    hour = hour.where(half.isna(), hour % 12 + 12 * (half == "p"))
    is_readable = dotted | (parts["mark"].notna() & (slashes is not None))
    days = pd.to_datetime((year + "-" + month + "-" + day).where(is_readable), format="%Y-%m-%d", errors="coerce")
    minutes, seconds = pd.to_numeric(parts["minute"]).fillna(0), pd.to_numeric(parts["second"].str.replace(",", "."))
    midnight = (hour == 24) & (minutes == 0) & ~(seconds > 0)  # noqa: PLR2004 - of the next day
    late = ((hour > 23) & ~midnight) | (minutes > 59) | (seconds > 60)  # noqa: PLR2004 - of a clock
    time = pd.to_timedelta(hour * 3600 + minutes * 60 + seconds.fillna(0), unit="s")
    return dates.where(dates.notna(), (days + time).where(~late).astype(dates.dtype))


def _month_as_number(text: str) -> str:
    """`2 Mar 2026` and `March 2, 2026` as 2.3.2026, with what follows; as it is where no month is named."""
    match = _DAY_MONTH.match(text) or _MONTH_DAY.match(text)
    month = match and _MONTHS.get(match["month"].casefold())
    return f"{match['day']}.{month}.{match['year']}{text[match.end() :]}" if match and month else text


def settled(texts: Iterable[str]) -> Slashes | None:
    """The order of day and month in dates with slashes or hyphens, where some have one reading only; else None."""
    readings: set[Slashes] = set()
    for text in texts:
        if (parts := _PARTS.match(text)) is not None:
            if int(parts[1]) > _MONTHS_OF_A_YEAR:
                readings.add("uk")
            elif int(parts[3]) > _MONTHS_OF_A_YEAR:
                readings.add("us")
    return readings.pop() if len(readings) == 1 else None


def are_days_of_excel(numbers: Any, *, whole: bool = False) -> bool:
    """Whether an array of numbers has days since 1900, all in a month of this century.

    Some have a time of day, unless it is known that there are dates: `whole`.
    """
    if not len(numbers):
        return False
    low, high = float(numbers.min()), float(numbers.max())
    return _EXCEL_DAYS[0] <= low <= high <= min(_EXCEL_DAYS[1], low + _MOST_DAYS) and (
        whole or bool((numbers % 1 > 0).any())
    )


def of_excel(text: pd.Series[Any]) -> pd.Series[Any]:
    """Days since 1900, with decimal points, as dates: to the minute where their digits say no more, else the second."""
    import numpy as np
    import pandas as pd

    seconds = pd.to_numeric(text, errors="coerce").astype(float) * _DAY
    exact = _DAY / 10.0 ** text.str.extract(r"\.(\d+)")[0].str.len().fillna(0).astype(float)
    minutes = (seconds / 60).round() * 60
    return pd.Timestamp(EXCEL) + pd.to_timedelta(
        np.where((minutes - seconds).abs() <= exact, minutes, seconds.round()), unit="s"
    ).to_series(index=text.index)


def hours_between(zone: str, other: str) -> float:
    """The hours by which clocks of one offset from UTC, such as `+02:00` or `Z`, are ahead of clocks of another."""
    return _hours(zone) - _hours(other)


def _hours(zone: str) -> float:
    digits = re.sub(r"\D", "", zone)
    size = int(digits[:2]) + int(digits[2:] or 0) / 60 if digits else 0.0
    return -size if zone.startswith("-") else size
