"""The parts of the day in which the orders of each flow come at one rate, such as a peak, by the clock."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise

from desim_warehouse.model.schema import Model
from desim_warehouse.model.sections.flows import ProfileArrivals
from desim_warehouse.values.calendars import DAY, Stretch, clock_of
from desim_warehouse.working_day import clock

LONG = 2
"""Hours of one rate from which on it is told hour by hour."""
MOST = 24
"""Parts of a day; where rates change more often, each hour is one."""


def parts_of_the_day(model: Model) -> dict[str, list[Stretch]]:
    """Return the stretches of a run in which no rate of orders changes, long ones by the hour; none where all stay.

    By the clock, as `11:30-13:00`: a part of a run of several days has a stretch on each.
    """
    profiles = [flow.when.profile for flow in model.tasks.flows.values() if isinstance(flow.when, ProfileArrivals)]
    if not profiles or model.run.length is None:
        return {}
    rates = [model.rates(profile) for profile in profiles]
    begin, end = model.run.warm_up, model.run.end

    def expected(stretch: Stretch) -> list[float]:
        return [profile_rates.expected(stretch[1]) - profile_rates.expected(stretch[0]) for profile_rates in rates]

    def comes(stretch: Stretch) -> bool:
        return any(tasks > 0 for tasks in expected(stretch))

    pieces: list[tuple[Stretch, list[float]]] = []
    for stretch in pairwise(sorted({begin, end, *(t for rate in rates for t in rate.changes(end) if begin < t < end)})):
        now = [tasks / (stretch[1] - stretch[0]) for tasks in expected(stretch)]
        if pieces and all(math.isclose(*both, abs_tol=1e-12) for both in zip(pieces[-1][1], now, strict=True)):
            pieces[-1] = ((pieces[-1][0][0], stretch[1]), now)
        else:
            pieces.append((stretch, now))
    if len(pieces) == 1:
        return {}
    parts: list[Stretch] = []
    for stretch, _ in pieces:
        parts += _by_the_hour(model, stretch) if stretch[1] - stretch[0] > LONG * model.units.hour else [stretch]
    named = _by_the_clock(model, (stretch for stretch in parts if comes(stretch)))
    if len(named) <= MOST:
        return named
    return _by_the_clock(model, (stretch for stretch in _by_the_hour(model, (begin, end)) if comes(stretch)))


def _by_the_hour(model: Model, stretch: Stretch) -> list[Stretch]:
    """Cut a stretch at full hours."""
    hour, (begin, end) = model.units.hour, stretch
    first = -clock_of(model.run.start) / 3600 % 1.0
    full = range(math.floor(begin / hour - first) + 1, math.ceil(end / hour - first))
    return list(pairwise([begin, *((n + first) * hour for n in full), end]))


def _by_the_clock(model: Model, stretches: Iterable[Stretch]) -> dict[str, list[Stretch]]:
    parts: dict[str, list[Stretch]] = {}
    for begin, end in stretches:
        parts.setdefault(f"{time_of_day(model, begin)}-{time_of_day(model, end)}", []).append((begin, end))
    return parts


def time_of_day(model: Model, time: float) -> str:
    """Return the time of day at a time of the run, such as `18:50`."""
    return clock(round((clock_of(model.run.start) + time / model.units.hour * 3600) % DAY / 60) % (24 * 60))
