"""The busiest hour of a run, of all its tasks or of those that are work for some people, and how much comes in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from operator import mul
from typing import TypeAlias

from desim_warehouse.model.facts.demand import flow_rates
from desim_warehouse.model.facts.hours import first_stretches
from desim_warehouse.model.schema import Model
from desim_warehouse.model.sections.flows import PoissonArrivals, ProfileArrivals
from desim_warehouse.model.sections.goods import PoissonGoods
from desim_warehouse.values.calendars import Hours

Expected: TypeAlias = Callable[[float], float]
"""How many tasks are expected by a time, if nothing keeps them away."""


def peak_rate(model: Model) -> float | None:
    """Return the tasks an hour in the busiest hour of a run, where rates change in it; else None."""
    rates = mean_and_peak(model, dict.fromkeys(["", *model.tasks.flows], 1.0))
    return None if rates is None else rates[1]


def mean_and_peak(model: Model, work: Mapping[str, float], since: float = 0.0) -> tuple[float, float] | None:
    """Return the work an hour from a time of the run on, on the mean and in the busiest hour; None if rates are steady.

    `work`: of a task, by its flow (goods: the flow without a name).
    """
    hour, length = model.units.hour, model.run.length
    changing = {name: (expected, hours) for name, expected, hours in _changing(model) if work[name]}
    if not changing or length is None or length - since <= hour:
        return None
    profiles = [flow.when.profile for flow in model.tasks.flows.values() if isinstance(flow.when, ProfileArrivals)]
    starts = [since]
    for rates in map(model.rates, profiles):  # the busiest hour begins, or ends, where a rate does
        ends = rates.changes(length)
        starts += [*ends, *(end - hour for end in ends)]
    for _, hours in changing.values():
        starts += [start for a, b in first_stretches(hours, length) for start in (a, b - hour)]

    def comes(begin: float, end: float) -> float:
        return sum(
            (expected(b) - expected(a)) * work[name]
            for name, (expected, hours) in changing.items()
            for a, b in hours.between(begin, end)
        )

    steady = sum(rate * work[name] for name, rate in flow_rates(model).items() if name not in changing)
    mean = comes(since, length) / (length - since) * hour
    peak = max(comes(start, start + hour) for start in starts if since <= start <= length - hour)
    return steady + mean, steady + peak


def _changing(model: Model) -> Iterator[tuple[str, Expected, Hours]]:
    """Iterate over flows whose rates change (goods: the flow without a name), their expected tasks, and their hours."""
    tasks, hour = model.tasks, model.units.hour
    if isinstance(tasks.goods, PoissonGoods) and tasks.goods.hours is not None:
        yield "", partial(mul, tasks.goods.poisson * tasks.demand / hour), model.hours(tasks.goods.hours)
    for name, flow in tasks.flows.items():
        if isinstance(flow.when, ProfileArrivals):
            yield name, model.rates(flow.when.profile, tasks.demand * flow.mean_lines).expected, model.hours(flow.hours)
        elif isinstance(flow.when, PoissonArrivals) and flow.hours is not None:
            yield name, partial(mul, flow.when.poisson * flow.mean_lines * tasks.demand / hour), model.hours(flow.hours)
