"""Times as people and programs write them: the one reader of orders, logs of fleets and the start of a run.

Dates are ISO, with `T` or a blank, with AM and PM; German (02.03.2026 14:00); US or British (3/2/2026 2:00 PM); with
months in English or German words; without marks, as SAP writes them (20260302); days since 1900, as Excel counts them.
Where two readings remain, a column is read as its dates that have one only (12/13/2018), or else not at all: the user
is asked. Plain Python, not pandas: 300,000 cells take half a second, and one cell no import.
"""

from __future__ import annotations

import datetime as dt
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Literal

from desim_warehouse.errors import got, spoken

Slashes = Literal["us", "uk"]
"""Whether 03/02/2026 is March 2, or 3 February."""
TWOFOLD = "a date that may be meant in two ways"
_EXCEL = dt.datetime(1899, 12, 30)  # noqa: DTZ001 - wall clock
"""The day from which Excel counts days, except for days before March 1900."""
_EXCEL_DAYS, _MOST_DAYS = (36_526.0, 73_050.0), 31.0
"""The years 2000 to 2099 in days of Excel, and the longest stretch of days that is taken for such."""
_MILLISECONDS, _LAST_TIME = 1e11, 4_102_444_800.0
"""A number above the first is in milliseconds since 1970, below in seconds; the second is the year 2100."""
_SUNDAY, _CHANGING = 6, range(1, 4)
_CHANGES = (3, range(25, 32)), (10, range(25, 32)), (3, range(8, 15)), (11, range(1, 8))
"""The day on which clocks change, and the hours of it; months with the days of that Sunday, Europe first."""
_MONTHS_OF_A_YEAR, _HOURS, _DAY = 12, 24, 86_400.0

_AROUND = re.compile(
    r"^(?:mo|di|mi|do|fr|sa|so|mon|tue|wed|thu|fri|sat|sun)[a-zäö]{0,8}\.?,? +(?=\d|[a-zä]{3})", re.IGNORECASE
)
"""A day of the week before a date."""
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
_WORDED = re.compile(
    r"^(?:(?P<day>\d\d?)(?:st|nd|rd|th)?[. -]{1,2}(?P<month>[^\W\d_]{3,9})\.?[ ,-]{1,2}(?P<year>\d{4}|\d\d)|"
    r"(?P<month2>[^\W\d_]{3,9})\.? (?P<day2>\d\d?)(?:st|nd|rd|th)?,? (?P<year2>\d{4}))(?=[ ,]|$)"
)
_TIME = (
    r"(?P<hour>\d\d?)(?::?(?P<minute>[0-5]\d)(?::?(?P<second>[0-5]\d|60)(?:[.,](?P<part>\d+))?)?)?"
    r" ?(?:(?P<half>[ap])\.?m\.?|(?P<uhr>uhr))?"
)
_CLOCK = re.compile(_TIME, re.ASCII | re.IGNORECASE)
_DATE = re.compile(
    r"(?:(?P<y>\d{4})(?P<mark>[-/.]?)(?P<m>\d\d?)(?P=mark)(?P<d>\d\d?)|"
    r"(?P<a>\d\d?)(?P<sign>[-/.])(?P<b>\d\d?)(?P=sign)(?P<year>\d{4}|\d\d))"
    rf"(?:(?:,? +|T){_TIME} ?(?P<zone>Z|UTC|GMT|[+-]\d\d(?::?\d\d)?)?)?",
    re.ASCII | re.IGNORECASE,
)
_SLASHES = re.compile(r"(\d\d?)([/-])(\d\d?)\2(?:\d{4}|\d\d)(?!\d)", re.ASCII)
"""Dates with slashes or hyphens, which may be meant in two ways."""
_ISO = re.compile(r"\d{4}-?\d\d", re.ASCII)
_UNMARKED = re.compile(r"(?:19|20)\d{6}(?:\d{6})?", re.ASCII)
_WITH_TIME = re.compile(r":\d\d|\d ?(?:[ap]\.?m|uhr)|^\d+\.\d+$", re.IGNORECASE)
_FIXED = re.compile(r"\.(\d+)")
_BLANKS = dict.fromkeys(map(ord, "\u00a0\u2007\u2009\u202f"), " ")
"""Blanks at which no line is broken, which Excel and Java write before AM and PM."""


def time_of_day(text: str) -> float | None:
    """Return the seconds from midnight to a time such as 06:15, 6:15:30 pm or 22 Uhr; None for anything else.

    24:00 ends the day, and 25:10 is 01:10 on the next, as timetables write it.
    """
    parts = _CLOCK.fullmatch(text.translate(_BLANKS).strip())
    if parts is None or not (":" in text or parts["half"] or parts["uhr"]):
        return None
    return _seconds(parts, 2 * _HOURS)


def _seconds(parts: re.Match[str], below: int) -> float | None:
    """Return the seconds of a clock, if its hour is below a bound; else None."""
    hour, half = int(parts["hour"] or 0), parts["half"]
    if half and not 1 <= hour <= _MONTHS_OF_A_YEAR:
        return None
    hour = hour % 12 + 12 * (half in "pP") if half else hour
    part = float(f"0.{parts['part']}") if parts["part"] else 0.0
    seconds = hour * 3600.0 + int(parts["minute"] or 0) * 60 + int(parts["second"] or 0) + part
    return seconds if hour < below else None


def read_date(text: str, slashes: Slashes | None = None) -> dt.datetime | None:
    """Read a date, with its time of day and its offset from UTC where it has some; None for anything else.

    24:00 is the midnight that ends a day. `slashes`: how 03/02/2026 is meant; None: it is not read.
    """
    text = text.translate(_BLANKS).strip()
    if _ISO.match(text):
        try:
            return dt.datetime.fromisoformat(text)
        except ValueError:
            pass
    parts = _DATE.fullmatch(_in_digits(text))
    if parts is None or (parts["a"] and parts["sign"] != "." and slashes is None):
        return None
    seconds = _seconds(parts, _HOURS + 1)
    year, month, day = parts["y"] or parts["year"], parts["m"] or parts["b"], parts["d"] or parts["a"]
    if slashes == "us" and parts["sign"] in {"/", "-"}:
        month, day = day, month
    if seconds is None or seconds > _DAY:
        return None
    try:
        date = dt.datetime(int(year) + 2000 * (len(year) < 4), int(month), int(day))  # noqa: DTZ001, PLR2004
        return (date + dt.timedelta(seconds=seconds)).replace(tzinfo=_offset(parts["zone"]))
    except (ValueError, OverflowError):
        return None


def _offset(zone: str | None) -> dt.timezone | None:
    """Return the offset from UTC that `+01:00`, `-0530` or `Z` names; raises ValueError for one of a day or more."""
    if zone is None:
        return None
    digits = re.sub(r"\D", "", zone) + "0000"
    size = dt.timedelta(hours=int(digits[:2]), minutes=int(digits[2:4]))
    return dt.timezone(-size if zone.startswith("-") else size)


def _in_digits(text: str) -> str:
    """Rewrite `Mo, 2 Mar 2026` and `March 2, 2026` as 2.3.2026, with what follows; any other text stays."""
    text = _AROUND.sub("", text)
    match = _WORDED.match(text)
    month = match and _MONTHS.get((match["month"] or match["month2"]).casefold())
    if not match or not month:
        return text
    return f"{match['day'] or match['day2']}.{month}.{match['year'] or match['year2']}{text[match.end() :]}"


def settled(texts: Iterable[str]) -> Slashes | None:
    """Return the order of day and month in dates with slashes, if some dates have one reading only; else None."""
    readings: set[Slashes] = set()
    for text in texts:
        if (parts := _SLASHES.match(text)) is not None:
            if int(parts[1]) > _MONTHS_OF_A_YEAR:
                readings.add("uk")
            elif int(parts[3]) > _MONTHS_OF_A_YEAR:
                readings.add("us")
    return readings.pop() if len(readings) == 1 else None


@dataclass
class Times:
    """A column of times in its one reading: each cell is a number, a time of day or a date, or else nothing.

    Attributes:
        numbers: as they stand there; nan for others.
        clocks: seconds from midnight; nan for others.
        dates: by the clock on the wall, with offsets from UTC where they are written; None for others.
        twofold: which cells are dates that may be meant in two ways.
        notes: how the column is read where that is not plain, to be said behind its title.
    """

    numbers: list[float]
    clocks: list[float] = field(default_factory=list)
    dates: list[dt.datetime | None] = field(default_factory=list)
    twofold: list[bool] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def since_1970(self) -> list[float]:
        """Return seconds since 1970, nan for other cells; dates without an offset from UTC are taken as UTC.

        Times of day are those of the first day.
        """
        return [
            _instant(date or (number if math.isnan(clock) else clock))
            for number, clock, date in zip(self.numbers, self.clocks, self.dates, strict=True)
        ]


def read_times(
    texts: Sequence[str],
    slashes: Slashes | None = None,
    *,
    numbers: Sequence[float] | None = None,
    whole: bool = False,
) -> Times:
    """Read a column of times.

    Args:
        texts: of its cells; "" where nothing stands.
        slashes: how 03/02/2026 is meant; None: as those that have one reading only.
        numbers: the cells that are numbers, nan for others, where they may have decimal commas.
        whole: numbers without fractions are rather days of Excel than seconds.
    """
    read = Times([_number(text) for text in texts] if numbers is None else [*numbers])
    filled = [(text, number) for text, number in zip(texts, read.numbers, strict=True) if text]
    excel = are_days_of_excel([number for _, number in filled], whole=whole)
    unmarked = bool(filled) and all(_UNMARKED.fullmatch(text) and read_date(_parted(text)) for text, _ in filled)
    if excel or unmarked:
        read.numbers = [math.nan] * len(texts)
        read.dates = [None if not text else of_excel(text) if excel else read_date(_parted(text)) for text in texts]
        read.notes += ["counts days, as Excel does"] * excel
    else:
        if slashes is None and (slashes := settled(texts)) is not None:
            first = "month" if slashes == "us" else "day"
            read.notes.append(f"has the {first} first, as some of its dates can be read in no other way")
        for text, number in zip(texts, read.numbers, strict=True):
            clock = time_of_day(text) if math.isnan(number) else None
            read.clocks.append(math.nan if clock is None else clock)
            read.dates.append(read_date(text, slashes) if math.isnan(number) and clock is None else None)
    read.clocks = read.clocks or [math.nan] * len(texts)
    if nights := dict.fromkeys(f"{date:%Y-%m-%d}" for date in read.dates if date is not None and _is_of_change(date)):
        why = "and its times have no offset from UTC: an hour may be missing, or there twice"
        read.notes.append(f"has the night of {spoken(nights)}, in which clocks change, {why}")
    pairs = zip(texts, read.dates, strict=True)
    read.twofold = [slashes is None and date is None and is_twofold(text) for text, date in pairs]
    return read


def _is_of_change(date: dt.datetime) -> bool:
    """Whether a date without an offset from UTC is in a night in which clocks change, in Europe or North America."""
    if date.tzinfo is not None or date.hour not in _CHANGING or date.weekday() != _SUNDAY:
        return False
    return any(date.month == month and date.day in days for month, days in _CHANGES)


def across_midnight(clocks: list[float], start: float = 0.0) -> list[int]:
    """Put times of day of a night shift that come after midnight on the next day; returns their ranks.

    They follow later ones, in rows that rise otherwise; or they are more than 12 h before `start`, when a run begins.
    """
    rows = [rank for rank, clock in enumerate(clocks) if not math.isnan(clock)]
    later = [rank for rank in rows if clocks[rank] < start - _DAY / 2]
    falls = [(a, b) for a, b in pairwise(rows) if clocks[b] < clocks[a]]
    if len(falls) == 1 and clocks[rows[-1]] < clocks[rows[0]]:
        [(before, after)] = falls
        if clocks[before] - clocks[after] > _DAY / 2:
            later = [rank for rank in rows if rank >= after]
    for rank in later:
        clocks[rank] += _DAY
    return later


def end_across_midnight(begins: Sequence[float], ends: list[float]) -> None:
    """Put the times of day at which something ends on the next day where they are 12 h before it began."""
    for rank, (begin, end) in enumerate(zip(begins, ends, strict=True)):
        if begin - end > _DAY / 2:
            ends[rank] += _DAY


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _parted(text: str) -> str:
    """Return the date and the time of day of 20260302061500, apart."""
    return f"{text[:8]} {text[8:]}".strip()


def has_time(text: str) -> bool:
    """Whether a date has a time of day: as 06:15, 6 am or 22 Uhr, or as a fraction of a day of Excel."""
    return _WITH_TIME.search(text) is not None


def exchanged(texts: Sequence[str], dates: Sequence[dt.datetime | None]) -> list[bool]:
    """Return in which dates a spreadsheet has probably exchanged day and month as it opened the file.

    It took 03/02/2026 for a date in the order of its own country, and left 13/02/2026 as text. So all dates with
    slashes have one reading, and all ISO dates could have had two.
    """
    left = [max(int(parts[1]), int(parts[3])) for text in texts if (parts := _SLASHES.match(text))]
    taken = [_ISO.match(text) is not None for text in texts]
    days = [date.day for date, is_taken in zip(dates, taken, strict=True) if date is not None and is_taken]
    is_probable = bool(left and days) and max(days) <= _MONTHS_OF_A_YEAR < min(left)
    return [is_taken and is_probable for is_taken in taken]


def is_twofold(text: str) -> bool:
    """Whether a text is a date with slashes or hyphens, with the year last."""
    return _SLASHES.match(_AROUND.sub("", text)) is not None


def are_days_of_excel(numbers: Sequence[float], *, whole: bool = False) -> bool:
    """Whether numbers are days since 1900, all in a month of this century; nan is none.

    Some have a time of day, unless it is known that there are dates: `whole`.
    """
    if not numbers or not all(_EXCEL_DAYS[0] <= number <= _EXCEL_DAYS[1] for number in numbers):
        return False
    return max(numbers) - min(numbers) <= _MOST_DAYS and (whole or any(number % 1 for number in numbers))


def of_excel(text: str) -> dt.datetime:
    """Return a day since 1900 as a date: to the minute where its digits say no more, else to the second."""
    text = text.replace(",", ".")
    seconds, digits = float(text) * _DAY, _FIXED.search(text)
    exact = _DAY / 10.0 ** (len(digits[1]) if digits else 0)
    minutes = round(seconds / 60) * 60
    return _EXCEL + dt.timedelta(seconds=minutes if abs(minutes - seconds) <= exact else round(seconds))


def instant(stamp: Any, slashes: Slashes | None = None) -> float:
    """Turn a time stamp, a date or a number, into seconds since 1970; without an offset from UTC it is UTC.

    Raises:
        ValueError: for anything else, a time before 1970 or after 2099, and a date that may be meant in two ways.
    """
    time = _instant(read_date(stamp, slashes) if isinstance(stamp, str) else stamp)
    if not math.isnan(time):
        return time
    if slashes is None and isinstance(stamp, str) and is_twofold(stamp):
        raise ValueError(f"{TWOFOLD} (got {got(stamp)}), expected --dates us or uk to say")
    expected = "expected one such as 2026-03-02T06:15:00Z"
    raise ValueError(f"timestamp: no time from 1970 to 2099 (got {got(stamp)}), {expected}")


def _instant(time: Any) -> float:
    """Return a date or a number in seconds since 1970, nan for what is none from 1970 to 2099."""
    try:
        if isinstance(time, dt.datetime):
            seconds = (time if time.tzinfo else time.replace(tzinfo=dt.UTC)).timestamp()
        else:
            seconds = time / 1000 if time > _MILLISECONDS else float(time)
    except (ValueError, TypeError, OverflowError):
        return math.nan
    return seconds if 0 <= seconds < _LAST_TIME else math.nan
