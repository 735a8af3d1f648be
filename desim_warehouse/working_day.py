"""The working day of a first model file: its shifts, its peak, and what they make of the hourly rates."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass

from desim_warehouse.errors import ModelError, spoken

DAY = 24 * 60
"""Minutes."""
MOST_TIMES = 20.0
"""A peak of more than this many times the usual rate is a slip."""

Stretch = tuple[int, int]
"""From one minute of the day to another, which is beyond `DAY` where it is of the next day."""


@dataclass(frozen=True)
class Peak:
    """A stretch of the day in which `times` as many orders come."""

    stretch: Stretch
    times: float


@dataclass(frozen=True)
class WorkingDay:
    """The hours in which people work, in stretches of a day (none: around the clock), and its peak of orders."""

    shifts: tuple[Stretch, ...] = ()
    peak: Peak | None = None

    @property
    def busiest(self) -> float:
        """The rate in the peak, as a multiple of the rate outside it; never below 1, and 1 without a peak."""
        return 1.0 if self.peak is None else max(self.peak.times, 1.0)

    @property
    def hours(self) -> float:
        """The hours of a day in which orders come at the usual rate; an hour of the peak counts as many times."""
        every, times = self.rates(1.0)
        return math.fsum(times) * every / 60

    @property
    def begin(self) -> int:
        """The minute at which the first shift begins."""
        return self.shifts[0][0] if self.shifts else 0

    @property
    def length(self) -> int:
        """Minutes from the first shift's begin to the last one's end."""
        return self.shifts[-1][1] - self.begin if self.shifts else DAY

    def rates(self, hourly: float) -> tuple[int, list[float]]:
        """Return the minutes for which each rate holds, and the rates from midnight on."""
        ends = [minute for stretch in self.shifts for minute in stretch]
        ends += [] if self.peak is None else self.peak.stretch
        every = math.gcd(60, *ends)
        return every, [hourly * self._times(minute) for minute in range(0, DAY, every)]

    def _times(self, minute: int) -> float:
        if self.shifts and not any(_has(stretch, minute) for stretch in self.shifts):
            return 0.0
        if self.peak is not None and _has(self.peak.stretch, minute):
            return self.peak.times
        return 1.0

    def words(self) -> str:
        """Return the words for when orders come, for a sentence; empty where they come alike around the clock."""
        phrase = (
            f" {spoken([f'from {clock(begin)} to {clock(end)}' for begin, end in self.shifts])}" if self.shifts else ""
        )
        if self.peak is not None:
            begin, end = self.peak.stretch
            phrase += f" with {self.peak.times:g} times as many from {clock(begin)} to {clock(end)}"
        return phrase


AROUND_THE_CLOCK = WorkingDay()
"""Orders come alike at all times."""


def clock(minute: int) -> str:
    """Write a minute of the day, or of the next one, as a time of day; the end of the day is 24:00."""
    minute -= DAY * (minute > DAY)
    return f"{minute // 60:02}:{minute % 60:02}"


def _has(stretch: Stretch, minute: int) -> bool:
    """Whether a minute of the day is in a stretch, be it of the day before."""
    begin, end = stretch
    return begin <= minute < end or begin <= minute + DAY < end


def read_shifts(text: str) -> tuple[Stretch, ...]:
    """Read shifts such as `06-22`, `6am-2pm,3:30pm-10pm` or `22-06`; shifts that follow each other are one stretch.

    Raises:
        ModelError: no such shifts.
    """
    stretches: list[Stretch] = []
    for begin, end in sorted(_stretch("--shifts", part, over_midnight=True) for part in text.split(",")):
        if stretches and begin == stretches[-1][1]:
            stretches[-1] = stretches[-1][0], end
        else:
            stretches.append((begin, end))
    if len(stretches) > 1 and stretches[-1][1] - DAY == stretches[0][0]:
        stretches[-1] = stretches[-1][0], stretches.pop(0)[1] + DAY
    following = [*stretches[1:], (stretches[0][0] + DAY, 0)]
    if any(after < end for (_, end), (after, _) in zip(stretches, following, strict=True)):
        raise ModelError([f"--shifts {text}: they overlap, expected one after the other"])
    return tuple(stretches)


def read_peak(text: str, shifts: Iterable[Stretch]) -> Peak:
    """Read a peak such as `11:30-13x1.6`: from when to when, and how many times as many orders come.

    Raises:
        ModelError: no such peak, or one outside the shifts.
    """
    stretch, cross, times = re.sub("[*×X]", "x", text).partition("x")
    try:
        factor = float(times)
    except ValueError:
        factor = math.nan
    if not cross or not 0 < factor <= MOST_TIMES:
        expected = f"from-to and times as many (above 0, at most {MOST_TIMES:g}), such as 11:30-13x1.6"
        raise ModelError([f"--peak {text}: no peak, expected {expected}"])
    shifts = list(shifts)
    begin, end = _stretch("--peak", stretch, over_midnight=True)
    if not shifts and end > DAY and end - begin > DAY / 2:  # by day, with its ends swapped
        raise ModelError([_no_stretch("--peak", stretch)])
    peak = Peak((begin, end), factor)
    days = (0, DAY)  # of a night shift the peak may be on the next day
    if shifts and not any(first <= begin + day and end + day <= last for first, last in shifts for day in days):
        raise ModelError([f"--peak {text}: outside the shifts, expected a peak within one of them"])
    return peak


def _stretch(option: str, text: str, *, over_midnight: bool) -> Stretch:
    """Read a stretch from one time of day to a later one, which may be on the next day."""
    from desim_warehouse.values.calendars import clock_time, in_24_hours

    try:
        begin, end = (clock_time(in_24_hours(_full(part))) / 60 for part in text.split("-"))
    except ValueError:
        begin = end = 0.0
    if over_midnight and end < begin:
        end += DAY
    if not begin < end:
        raise ModelError([_no_stretch(option, text)])
    return int(begin), int(end)


def _no_stretch(option: str, text: str) -> str:
    """Return the message that a text is not from one time of day to another."""
    expected = "two times of day, such as 06-22, 6am-10pm or 11:30-13"
    return f"{option} {text}: not from one time to another, expected {expected}"


def _full(text: str) -> str:
    """Return a time of day in full: 6 is 06:00."""
    text = text.strip()
    return f"{text}:00" if text.isdecimal() else text
