"""The busiest hour of a run, and how many tasks come in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
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
    hour, length = model.units.hour, model.run.length
    changing = {name: (expected, hours) for name, expected, hours in _changing(model)}
    if not changing or length is None or length <= hour:
        return None
    profiles = [flow.when.profile for flow in model.tasks.flows.values() if isinstance(flow.when, ProfileArrivals)]
    starts = [0.0]
    for rates in map(model.rates, profiles):  # the busiest hour begins, or ends, where a rate does
        ends = rates.changes(length)
        starts += [*ends, *(end - hour for end in ends)]
    for _, hours in changing.values():
        starts += [start for a, b in first_stretches(hours, length) for start in (a, b - hour)]
    return sum(rate for name, rate in flow_rates(model).items() if name not in changing) + max(
        sum(
            expected(b) - expected(a)
            for expected, hours in changing.values()
            for a, b in hours.between(start, start + hour)
        )
        for start in starts
        if 0 <= start <= length - hour
    )


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
