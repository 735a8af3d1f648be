"""How the orders of a day fare by the time at which they come: the worst hour of a design that is enough over all."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from desim_warehouse.model import Model
from desim_warehouse.model.sections.flows import ProfileArrivals
from desim_warehouse.run import simulate
from desim_warehouse.study.plan import run_seed
from desim_warehouse.study.statistics.intervals import Estimate, TaskShare, estimate
from desim_warehouse.values.calendars import DAY, clock_of
from desim_warehouse.working_day import clock

DAYS = 10
"""Days that are looked at by the hour."""
LONG = 2.0
"""Hours of one rate from which on it is told hour by hour."""


@dataclass(frozen=True)
class Hour:
    """A part of the day, in times of the run: of the orders that come in it, how many a day, and the share on time."""

    begin: float
    end: float
    orders: float
    share: Estimate

    def named(self, model: Model) -> str:
        """It by the clock: `11:30 to 13:00`."""
        return f"{_clock(model, self.begin)} to {_clock(model, self.end)}"


def parts_of_the_day(model: Model) -> list[tuple[float, float]]:
    """The stretches of a run in which orders come at one rate, long ones by the hour; none where the rate stays."""
    hour, run = model.units.hour, model.run
    profiles = [flow.when.profile for flow in model.tasks.flows.values() if isinstance(flow.when, ProfileArrivals)]
    if not profiles or run.length is None:
        return []
    rates = [model.rates(profile) for profile in profiles]
    edges = {run.warm_up, run.end}
    for one in rates:
        edges |= {step for step in one.changes(run.end) if run.warm_up < step < run.end}
    found: list[tuple[float, float, float]] = []
    ordered = sorted(edges)
    for begin, end in pairwise(ordered):
        rate = math.fsum(one.expected(end) - one.expected(begin) for one in rates) / (end - begin)
        if found and math.isclose(found[-1][2], rate, abs_tol=1e-12):
            found[-1] = (found[-1][0], end, rate)
        else:
            found.append((begin, end, rate))
    if len(found) == 1:
        return []
    return [part for begin, end, rate in found if rate > 0 for part in _by_the_hour(begin, end, hour)]


def _by_the_hour(begin: float, end: float, hour: float) -> list[tuple[float, float]]:
    if end - begin <= LONG * hour:
        return [(begin, end)]
    cuts = [begin, *(n * hour for n in range(math.floor(begin / hour) + 1, math.ceil(end / hour))), end]
    return list(pairwise(cuts))


def by_hour(model: Model, seed: int, days: int, confidence: float) -> tuple[Hour, ...]:
    """The orders on time by the part of the day in which they come, on some days of a design.

    All intervals hold at once with the confidence.
    """
    parts = parts_of_the_day(model)
    shares: list[list[float]] = [[] for _ in parts]
    for replication in range(days if parts else 0):
        history = simulate(model, run_seed(seed, replication)).history
        known = [
            (task.released, one.missed) for task in history.tasks.values() for one in history.settled([task.deadline])
        ]
        for (begin, end), of_days in zip(parts, shares, strict=True):
            missed = [late for released, late in known if begin <= released < end]
            if missed:
                of_days.append(TaskShare(1 - sum(missed) / len(missed), len(missed)))
    level = 1 - (1 - confidence) / max(len(parts), 1)
    return tuple(
        Hour(
            begin,
            end,
            math.fsum(one.of for one in of_days if isinstance(one, TaskShare)) / len(of_days),
            estimate(of_days, level, within=(0.0, 1.0)),
        )
        for (begin, end), of_days in zip(parts, shares, strict=True)
        if len(of_days) > 1
    )


def _clock(model: Model, time: float) -> str:
    return clock(round((clock_of(model.run.start) + time / model.units.hour * 3600) % DAY / 60))
