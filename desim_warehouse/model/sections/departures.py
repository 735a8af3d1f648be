"""Departures: orders released before them are due then, at times of the run or, every day, by the clock."""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field

from desim_warehouse.errors import got
from desim_warehouse.values.calendars import DAY, clock_of, clock_time, in_24_hours
from desim_warehouse.values.fields import SECTION, Duration, Forms, Part, Text, Time, Usual, by_type, form, wrong

_PATTERN = r"^\d\d?(:[0-5]\d){0,2}( ?[AaPp]\.?[Mm]\.?)?$"
DUE_AT = Usual("1 min", instant=True)


def is_clock(value: Any) -> bool:
    """Whether a time of a file is written by the clock, as in `10:00` or `10 am`."""
    return isinstance(value, str) and ":" in in_24_hours(value)


def _pick(value: Any) -> str:
    return "\0clock" if is_clock(value) else "\0time"


def _of_a_day(text: str) -> str:
    try:
        if clock_time(text) < DAY:
            return text
    except ValueError:
        pass
    raise wrong(f"not a time of day (got {got(text)}), expected one such as '10:00', from 00:00 to 23:59")


def _in_order(times: tuple[float | str, ...]) -> tuple[float | str, ...]:
    by_clock = [is_clock(time) for time in times]
    if any(by_clock) != all(by_clock):
        raise wrong(f"by the clock and from the start of the run (got {got(times)}), expected one of the two")
    seconds = [clock_time(time) if isinstance(time, str) else time for time in times]
    if seconds != sorted(seconds):
        raise wrong(f"not in order (got {got(times)}), expected the earliest time first")
    return times


ClockTime = Annotated[Text, BeforeValidator(in_24_hours), AfterValidator(_of_a_day), Field(pattern=_PATTERN)]
DueTime = Annotated[
    Annotated[Time, form("time")] | Annotated[ClockTime, form("clock")],
    Forms("a time by the clock such as '10:00', or from the start of the run such as 4 h", pick=_pick),
]
DueTimes = Annotated[tuple[DueTime, ...], Field(min_length=1), AfterValidator(_in_order)]


class DepartureList(Part):
    """Departures with a cut-off time before each; orders that come later take the next one."""

    times: Annotated[
        DueTimes,
        DUE_AT,
        Forms("a list of times by the clock (['10:00', '18:00']) or from the start of the run ([4 h, 12 h])"),
    ] = Field(title="times due", description="by the clock, every day (`10:00`), or from the start of the run (`4 h`)")
    cut_off: Annotated[Duration, Usual("1 min", "2 d")] = Field(
        0.0,
        title="cut-off",
        description="time before a departure by which an order must come; later orders take the next departure",
    )


DueAt = Annotated[
    Annotated[DueTimes, form("times")] | Annotated[DepartureList, form("section")],
    Forms(
        "a list of times by the clock (['10:00', '18:00']) or from the start of the run ([4 h, 12 h]), "
        "or {times: [...], cut_off: 30 min}",
        pick=by_type(times=(list, tuple), section=SECTION),
    ),
]


@dataclass(frozen=True)
class Timetable:
    """The departures of a flow on the clock of a run, in its time unit.

    `times`: from the start of the run on, in order; after a `period` they come again. `cut_off`: how long before a
    departure an order has to come for it.
    """

    times: tuple[float, ...]
    period: float = math.inf
    cut_off: float = 0.0

    @classmethod
    def of(cls, due_at: tuple[float | str, ...] | DepartureList, start: str, second: float) -> Timetable:
        """Make the departures of a key, for a run that starts at `start`; `second`: in its time unit."""
        times, cut_off = (due_at.times, due_at.cut_off) if isinstance(due_at, DepartureList) else (due_at, 0.0)
        clocks = [clock_time(time) for time in times if isinstance(time, str)]
        if not clocks:
            return cls(tuple(time for time in times if not isinstance(time, str)), math.inf, cut_off)
        begin = clock_of(start)
        return cls(tuple(sorted({(time - begin) % DAY * second for time in clocks})), DAY * second, cut_off)

    def next(self, released: float) -> float | None:
        """Return the departure for which an order comes in time; None where it is after the last."""
        earliest = released + self.cut_off
        if math.isinf(self.period):
            place = bisect_left(self.times, earliest)
            return self.times[place] if place < len(self.times) else None
        day, rest = divmod(earliest, self.period)
        place = bisect_left(self.times, rest)
        return day * self.period + (self.times[place] if place < len(self.times) else self.period + self.times[0])

    def last(self, end: float) -> float | None:
        """Return the last departure up to the end of a run, or None. Without an end the last of all."""
        if math.isinf(self.period) or math.isinf(end):
            return max((time for time in self.times if time <= end), default=None)
        day, rest = divmod(end, self.period)
        place = bisect_left(self.times, rest + 1e-9 * self.period)
        if place:
            return day * self.period + self.times[place - 1]
        return (day - 1) * self.period + self.times[-1] if day else None
