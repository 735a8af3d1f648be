"""Dates with times as people write them in orders: ISO, German, US or British, with months in digits or in words."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd

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
