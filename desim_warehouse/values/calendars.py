"""Calendars: when something is open, at work or in force, as a model file says it, and as times of a run.

A calendar is written by the clock and the days of the week, as a pattern that repeats, or as stretches of the run.
All of them become `Hours`: stretches on the run's own clock, which repeat after a period.
"""

from __future__ import annotations

import datetime as dt
import math
import re
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, BeforeValidator, Field, ValidationInfo, field_validator, model_validator

from desim_warehouse.errors import did_you_mean, got, spoken
from desim_warehouse.values.dates import time_of_day
from desim_warehouse.values.fields import SECTION, Duration, Forms, Name, Part, Time, Usual, form, known, wrong

Stretch = tuple[float, float]

Weekday = Literal["mon", "tue", "wed", "thu", "fri", "sat", "sun"]
DAYS: tuple[Weekday, ...] = get_args(Weekday)
DAY = 86400.0
"""Seconds in a day."""
MONDAY = "2026-03-02"
"""The day on which a run starts that has only a time of day."""

_CLOCK = re.compile(r"(\d\d?):([0-5]\d)(?::([0-5]\d))?", re.ASCII)


@dataclass(frozen=True)
class Hours:
    """Stretches [begin, end) of a run, in order and apart, repeated after `period`.

    `phase` is where in the period the run starts. Before `since` there are none.
    """

    stretches: list[Stretch]
    period: float = math.inf
    phase: float = 0.0
    since: float = -math.inf
    _latest: list[tuple[float, Stretch]] = field(
        default_factory=lambda: [(math.inf, (0.0, 0.0))], repr=False, compare=False
    )
    """A time and the stretch that follows it, which also follows every later time until the stretch ends."""

    def is_open(self, time: float) -> bool:
        """Whether a time is in one of the stretches."""
        begin, _ = self.following(time)
        return begin <= time

    def following(self, time: float) -> Stretch:
        """Return the stretch that a time is in, or the next one after it; (inf, inf) where there is none.

        Where one touches the next, at the end of a period, it goes on. Robots ask again and again within a stretch.
        """
        asked, stretch = self._latest[0]
        if not asked <= time < stretch[1]:
            stretch = self._joined(time)
            self._latest[0] = time, stretch
        return stretch

    def _joined(self, time: float) -> Stretch:
        begin, end = self._next(time)
        while math.isfinite(end) and end - begin < self.period:
            then, later = self._next(end)
            if then > end:
                break
            end = later
        return (begin, end) if end - begin < self.period else (begin, math.inf)

    def changes(self, time: float) -> float:
        """Return the next time after a given one at which the calendar opens or closes, or inf."""
        begin, end = self.following(time)
        return end if begin <= time else begin

    def open_time(self, time: float) -> float:
        """Return the time for which the calendar has been open from the start of the run to a time."""
        total, now = 0.0, 0.0
        if math.isfinite(self.period) and time - max(self.since, 0.0) > self.period:
            start = max(self.since, 0.0)
            rounds = math.floor((time - start) / self.period)
            total = rounds * math.fsum(b - a for a, b in self.stretches)
            now = start + rounds * self.period
        while now < time:
            begin, end = self._next(now)
            if begin >= time:
                break
            total += min(end, time) - max(begin, now)
            now = end
        return total

    def when_open(self, amount: float) -> float:
        """Return the time by which the calendar has been open for so long since the start of the run, or inf."""
        now = max(self.since, 0.0)
        a_period = math.fsum(b - a for a, b in self.stretches)
        if math.isfinite(self.period) and amount > a_period:
            rounds = math.ceil(amount / a_period) - 1
            amount -= rounds * a_period
            now += rounds * self.period
        while True:
            begin, end = self._next(now)
            if math.isinf(begin):
                return math.inf
            here = end - max(begin, now)
            if amount <= here:
                return max(begin, now) + amount
            amount -= here
            now = end

    def between(self, begin: float, end: float) -> Iterator[Stretch]:
        """Yield the stretches of a part of the run, cut off at its ends."""
        now = begin
        while now < end:
            first, last = self.following(now)
            if first >= end:
                return
            yield max(first, begin), min(last, end)
            now = last

    def share(self, begin: float, end: float) -> float:
        """Return the share of the time between two times in which the calendar is open.

        If there is no end, of a period, else of the time until it closes for good.
        """
        if math.isfinite(end):
            return (self.open_time(end) - self.open_time(begin)) / (end - begin) if end > begin else 1.0
        if math.isfinite(self.period):
            return math.fsum(b - a for a, b in self.stretches) / self.period
        last = self.stretches[-1][1]
        return 1.0 if math.isinf(last) else self.share(0.0, last)

    @property
    def repeats_from(self) -> float:
        """The time from which on the calendar repeats itself, or stays as it is if it has no period."""
        if math.isfinite(self.period):
            return max(self.since, 0.0)
        return max((time for stretch in self.stretches for time in stretch if math.isfinite(time)), default=0.0)

    def _next(self, time: float) -> Stretch:
        """Return the stretch that a time is in, or the next one after it, where touching stretches count as two."""
        now = max(time, self.since)
        rounds = math.floor((now + self.phase) / self.period) if math.isfinite(self.period) else 0
        for extra in (0, 1):
            base = (rounds + extra) * self.period - self.phase if math.isfinite(self.period) else 0.0
            for begin, end in self.stretches[max(bisect_right(self.stretches, (now - base, math.inf)) - 1, 0) :]:
                if base + end > now:
                    return base + begin, base + end
            if math.isinf(self.period):
                break
        return math.inf, math.inf


def repeat_together(calendars: Iterable[Hours], most: int) -> float:
    """Return the time after which calendars repeat together, 0 if none repeats.

    That is the least common multiple of their periods, or `most` times the longest if the multiple is longer.
    """
    periods = [Fraction(hours.period).limit_denominator(10**6) for hours in calendars if math.isfinite(hours.period)]
    if not periods:
        return 0.0
    together = math.lcm(*(period.numerator for period in periods))
    return min(together / math.gcd(*(period.denominator for period in periods)), most * float(max(periods)))


def clock_time(text: str) -> float:
    """Return the seconds from midnight to a time of day such as `06:30`; `24:00` is the end of the day.

    Nothing else is taken, such as offsets from UTC: the times of a run have no time zone.

    Raises:
        ValueError: where it is none.
    """
    match = _CLOCK.fullmatch(text)
    hours, minutes, seconds = map(int, match.groups("0")) if match else (25, 0, 0)
    time = hours * 3600.0 + minutes * 60 + seconds
    if time > DAY:
        raise ValueError(text)
    return time


def in_24_hours(text: str) -> str:
    """Rewrite a time of day such as `6 am` or `22 Uhr` as `06:00` or `22:00`; any other text stays."""
    seconds = None if _CLOCK.fullmatch(text) else time_of_day(text)
    if seconds is None or seconds % 1:
        return text
    minutes, rest = divmod(int(seconds), 60)
    return f"{minutes // 60:02}:{minutes % 60:02}" + f":{rest:02}" * (rest > 0)


def clock_of(start: str) -> float:
    """Return the time of day in seconds of the `start` of a run, which may have a date."""
    return clock_time(start.rpartition("T")[2])


def _span(text: str) -> str:
    text = "-".join(map(in_24_hours, text.split("-")))
    try:
        begin, end = _ends(text)
    except ValueError:
        raise wrong(f"no stretch of a day (got {got(text)}), expected one such as '06:00-14:00'") from None
    if begin == end:
        raise wrong(
            f"it ends when it begins (got {got(text)}), expected one such as '06:00-14:00'; '00:00-24:00': all day"
        )
    return text


def _ends(span: str) -> Stretch:
    begin, _, end = span.partition("-")
    return clock_time(begin.strip()), clock_time(end.strip())


def seconds_of(span: str) -> Stretch:
    """Return a stretch of the day in seconds from midnight; past midnight it ends on the next day."""
    first, last = _ends(span)
    return first, last if last > first else last + DAY


class Shifts(Part):
    """`open: ["06:00-14:00", "14:30-22:00"]`: by the clock, on some days of the week, breaks taken out."""

    open: tuple[Annotated[Name, AfterValidator(_span)], ...] = Field(
        min_length=1, description="periods of the day, such as '06:00-14:00'"
    )
    breaks: tuple[Annotated[Name, AfterValidator(_span)], ...] = Field((), description="periods of the day to take out")
    days: tuple[Weekday, ...] = Field(
        DAYS, min_length=1, description="days of the week on which a period begins; default: all"
    )

    def hours(self, start: str, second: float) -> Hours:
        """Return the stretches on the clock of a run that starts at `start`; `second`: a second in its time units."""
        day, _, clock = start.rpartition("T")
        weekday = dt.date.fromisoformat(day or MONDAY).weekday()
        phase = weekday * DAY + clock_time(clock)
        week = [DAYS.index(name) * DAY for name in self.days]
        open_ones = [(day + a, day + b) for day in week for a, b in map(seconds_of, self.open)]
        breaks = [
            (day + a, day + b) for day in (n * DAY for n in range(-1, 8)) for a, b in map(seconds_of, self.breaks)
        ]
        left = without(wrapped(open_ones, 7 * DAY), breaks)
        return Hours([(a * second, b * second) for a, b in left], 7 * DAY * second, phase * second)

    def words(self, unit: str) -> str:  # noqa: ARG002 - by the clock
        """Return the shifts in a few words."""
        breaks = f" without {', '.join(self.breaks)}" if self.breaks else ""
        days = f" on {', '.join(self.days)}" if set(self.days) != set(DAYS) else ""
        return f"{', '.join(self.open)}{breaks}{days}"

    @model_validator(mode="after")
    def _some(self) -> Shifts:
        if not self.hours(MONDAY + "T00:00", 1.0).stretches:
            raise wrong("its breaks leave nothing of it, expected some time that is open", "breaks")
        return self


class Pattern(Part):
    """`every: 8 h, lasts: 30 min`: repeated from the start of the run."""

    every: Annotated[Duration, Usual("5 min", "366 d")] = Field(
        description="time from the start of one period to the start of the next"
    )
    lasts: Annotated[Duration, Usual("1 min", "366 d")] = Field(description="length of each period")
    first: Annotated[Time, Usual("1 min", instant=True)] = Field(
        0.0, description="start of the first period, counted from the start of the run"
    )

    @field_validator("lasts")
    @classmethod
    def _within(cls, lasts: float, info: ValidationInfo) -> float:
        every = info.data.get("every", math.inf)
        if lasts > every:
            raise wrong(f"longer than from one to the next (got {got(lasts)}), expected at most every, {got(every)}")
        return lasts

    def hours(self, start: str, second: float) -> Hours:  # noqa: ARG002 - counted from the start, in the run's units
        """Return the stretches on the clock of a run."""
        return Hours([(0.0, self.lasts)], self.every, -self.first, self.first)

    def words(self, unit: str) -> str:
        """Return the pattern in a few words."""
        first = f", from {self.first:g} on" if self.first else ""
        return f"{self.lasts:g} of every {self.every:g} {unit}{first}"


class Stretches(Part):
    """`between: [[2 h, 3 h], [5 h, 6 h]]`: these periods of the run only."""

    between: Annotated[tuple[tuple[Time, Time], ...], Usual("1 min", instant=True)] = Field(
        min_length=1, description="[from, to], from the start of the run"
    )

    @field_validator("between")
    @classmethod
    def _forward(cls, stretches: tuple[Stretch, ...]) -> tuple[Stretch, ...]:
        for rank, (begin, end) in enumerate(stretches):
            if end <= begin:
                when = "when" if end == begin else "before"
                raise wrong(f"it ends {when} it begins (got {got((begin, end))}), expected [from, to]", rank)
        return stretches

    def hours(self, start: str, second: float) -> Hours:  # noqa: ARG002 - counted from the start, in the run's units
        """Return the stretches on the clock of a run."""
        return Hours(merged(self.between))

    def words(self, unit: str) -> str:
        """Return the stretches in a few words."""
        return f"{', '.join(f'{begin:g} to {end:g}' for begin, end in self.between)} {unit}"


def _pick(value: Any) -> str | None:
    keys = type(value).model_fields if isinstance(value, Part) else value
    return next((f"\0{key}" for key in _KINDS if isinstance(keys, Mapping) and key in keys), None)


def _named(name: str, info: ValidationInfo) -> str:
    calendars = known(info).calendars
    if calendars is not None and name not in calendars:
        hint = did_you_mean(name, calendars)
        expected = f"one of {spoken(calendars, 'or')}" if calendars else "one of calendars, of which there are none"
        raise wrong(f"no such calendar (got {got(name)}), expected {expected}{hint}")
    return name


def _by_name(value: Any) -> Any:
    if isinstance(value, SECTION):
        raise wrong(f"a calendar itself (got {got(value)}), expected the name of one of the section calendars")
    return value


class Names:
    """Marks a key that names a part of the model; `of`: the section that has it."""

    def __init__(self, section: str) -> None:
        self.of = section


_KINDS: dict[str, type[Part]] = {"open": Shifts, "every": Pattern, "between": Stretches}

Calendar = Annotated[
    Annotated[Shifts, form("open")] | Annotated[Pattern, form("every")] | Annotated[Stretches, form("between")],
    Forms(
        "{open: ['06:00-14:00'], days: [...], breaks: [...]}, {every: 8 h, lasts: 30 min} or {between: [[1 h, 2 h]]}",
        pick=_pick,
    ),
]
"""When something is open, at work or in force."""

CalendarName = Annotated[Name, BeforeValidator(_by_name), AfterValidator(_named), Names("calendars")]
"""The name of a calendar of the model."""

ALWAYS = Hours([(0.0, math.inf)])
"""Where there is no calendar."""


# Stretches


def merged(stretches: Iterable[Stretch]) -> list[Stretch]:
    """Sort stretches, and join those that touch or overlap."""
    joined: list[Stretch] = []
    for begin, end in sorted(stretches):
        if joined and begin <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(joined[-1][1], end)
        else:
            joined.append((begin, end))
    return joined


def wrapped(stretches: Iterable[Stretch], period: float) -> list[Stretch]:
    """Move the part of stretches beyond the end of one period to its beginning."""
    cut = [(begin, min(end, period)) for begin, end in stretches]
    return merged([*cut, *((0.0, end - period) for _, end in stretches if end > period)])


def without(stretches: Iterable[Stretch], others: Iterable[Stretch]) -> list[Stretch]:
    """Return the rest of stretches when others are cut out of them."""
    left = []
    gaps = merged(others)
    for begin, end in stretches:
        start = begin
        for first, last in gaps:
            if last <= start or first >= end:
                continue
            if first > start:
                left.append((start, first))
            start = max(start, last)
        if start < end:
            left.append((start, end))
    return left
