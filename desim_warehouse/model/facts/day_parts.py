"""The parts of the day in which orders come at one rate, such as a peak, by the clock."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

from desim_warehouse.model.sections.flows import ProfileArrivals
from desim_warehouse.values.calendars import DAY, clock_of
from desim_warehouse.working_day import clock

if TYPE_CHECKING:
    from collections.abc import Iterable

    from desim_warehouse.model.schema import Model
    from desim_warehouse.values.calendars import Stretch

LONG = 2
"""Hours of one rate from which on it is told hour by hour."""
MOST = 24
"""Parts of a day; where rates change more often, each hour is one."""


def parts_of_the_day(model: Model) -> dict[str, list[Stretch]]:
    """The stretches of a run in which orders come at one rate, long ones by the hour; none where the rate stays.

    By the clock, as `11:30-13:00`: a part of a run of several days has a stretch on each.
    """
    profiles = [flow.when.profile for flow in model.tasks.flows.values() if isinstance(flow.when, ProfileArrivals)]
    if not profiles or model.run.length is None:
        return {}
    rates = [model.rates(profile) for profile in profiles]
    begin, end = model.run.warm_up, model.run.end

    def expected(stretch: Stretch) -> float:
        return math.fsum(one.expected(stretch[1]) - one.expected(stretch[0]) for one in rates)

    found: list[tuple[Stretch, float]] = []
    for one in pairwise(sorted({begin, end, *(t for rate in rates for t in rate.changes(end) if begin < t < end)})):
        rate = expected(one) / (one[1] - one[0])
        if found and math.isclose(found[-1][1], rate, abs_tol=1e-12):
            found[-1] = ((found[-1][0][0], one[1]), rate)
        else:
            found.append((one, rate))
    if len(found) == 1:
        return {}
    parts: list[Stretch] = []
    for one, _ in found:
        parts += _by_the_hour(model, one) if one[1] - one[0] > LONG * model.units.hour else [one]
    named = _by_the_clock(model, (one for one in parts if expected(one) > 0))
    if len(named) <= MOST:
        return named
    return _by_the_clock(model, (one for one in _by_the_hour(model, (begin, end)) if expected(one) > 0))


def _by_the_hour(model: Model, stretch: Stretch) -> list[Stretch]:
    """The pieces of a stretch between full hours."""
    hour, (begin, end) = model.units.hour, stretch
    first = -clock_of(model.run.start) / 3600 % 1.0
    full = range(math.floor(begin / hour - first) + 1, math.ceil(end / hour - first))
    return list(pairwise([begin, *((n + first) * hour for n in full), end]))


def _by_the_clock(model: Model, stretches: Iterable[Stretch]) -> dict[str, list[Stretch]]:
    found: dict[str, list[Stretch]] = {}
    for begin, end in stretches:
        found.setdefault(f"{time_of_day(model, begin)}-{time_of_day(model, end)}", []).append((begin, end))
    return found


def time_of_day(model: Model, time: float) -> str:
    """Return the time of day at a time of the run, such as `18:50`."""
    return clock(round((clock_of(model.run.start) + time / model.units.hour * 3600) % DAY / 60) % (24 * 60))
