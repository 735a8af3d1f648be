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
"""From one minute of the day to another."""


@dataclass(frozen=True)
class Peak:
    """A stretch of the day in which `times` as many orders come."""

    stretch: Stretch
    times: float


@dataclass(frozen=True)
class WorkingDay:
    """When people work, in stretches of the day in order (none: around the clock), and when most orders come."""

    shifts: tuple[Stretch, ...] = ()
    peak: Peak | None = None

    @property
    def busiest(self) -> float:
        """How many times the usual rate comes in the busiest hour."""
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
        """The minutes for which each rate holds, and the rates from midnight on."""
        ends = [minute for stretch in self.shifts for minute in stretch]
        ends += [] if self.peak is None else self.peak.stretch
        every = math.gcd(60, *ends)
        return every, [hourly * self._times(minute) for minute in range(0, DAY, every)]

    def _times(self, minute: int) -> float:
        if self.shifts and not any(begin <= minute < end for begin, end in self.shifts):
            return 0.0
        if self.peak is not None and self.peak.stretch[0] <= minute < self.peak.stretch[1]:
            return self.peak.times
        return 1.0

    def words(self) -> str:
        """When orders come, for a sentence; empty where they come alike around the clock."""
        said = (
            f" {spoken([f'from {clock(begin)} to {clock(end)}' for begin, end in self.shifts])}" if self.shifts else ""
        )
        if self.peak is not None:
            begin, end = self.peak.stretch
            said += f" with {self.peak.times:g} times as many from {clock(begin)} to {clock(end)}"
        return said


AROUND_THE_CLOCK = WorkingDay()
"""Orders come alike at all times."""


def clock(minute: int) -> str:
    """A minute of the day as a time of day."""
    return f"{minute // 60:02}:{minute % 60:02}"


def read_shifts(text: str) -> tuple[Stretch, ...]:
    """Shifts such as `06-22` or `06-14,15:30-22`; those that follow each other are one stretch.

    Raises:
        ModelError: no such shifts.
    """
    found: list[Stretch] = []
    for begin, end in sorted(_stretch("--shifts", part) for part in text.split(",")):
        if found and begin < found[-1][1]:
            raise ModelError([f"--shifts {text}: they overlap, expected one after the other"])
        if found and begin == found[-1][1]:
            found[-1] = found[-1][0], end
        else:
            found.append((begin, end))
    return tuple(found)


def read_peak(text: str, shifts: Iterable[Stretch]) -> Peak:
    """A peak such as `11:30-13x1.6`: from when to when, and how many times as many orders come.

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
    found = Peak(_stretch("--peak", stretch), factor)
    shifts = list(shifts)
    if shifts and not any(begin <= found.stretch[0] and found.stretch[1] <= end for begin, end in shifts):
        raise ModelError([f"--peak {text}: outside the shifts, expected a peak within one of them"])
    return found


def _stretch(option: str, text: str) -> Stretch:
    """From one time of day to a later one."""
    from desim_warehouse.values.calendars import clock_time

    try:
        begin, end = (clock_time(_full(part)) / 60 for part in text.split("-"))
    except ValueError:
        begin = end = 0.0
    if not begin < end:
        expected = "two times of day, the earlier first, such as 06-22 or 11:30-13"
        raise ModelError([f"{option} {text}: not from one time to another, expected {expected}"])
    return int(begin), int(end)


def _full(text: str) -> str:
    """A time of day in full: 6 is 06:00."""
    text = text.strip()
    return f"{int(text):02}:00" if text.isdecimal() else f"{text:0>5}"
