"""What is asked for: orders, lines and trips for them an hour, and tasks in the busiest hour of a run."""

from __future__ import annotations

import math
from functools import partial
from operator import mul
from typing import TYPE_CHECKING

from desim_warehouse.findings import amount
from desim_warehouse.model.facts.demand import flow_rates
from desim_warehouse.model.facts.hours import first_stretches
from desim_warehouse.model.sections.flows import PoissonArrivals, ProfileArrivals, SaturatedArrivals, mean_rate
from desim_warehouse.model.sections.goods import PoissonGoods
from desim_warehouse.model.sections.lines import shares_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from desim_warehouse.model import Model
    from desim_warehouse.values.calendars import Hours

    Expected = Callable[[float], float]
    """How many tasks are expected by a time, if nothing keeps them away."""


def orders_asked_for(model: Model) -> Iterator[str]:
    """For each flow whose orders have several lines: orders, lines and trips an hour, such as `250 orders an hour`.

    Without pods a trip serves one line or, by-order, as many of an order as a robot carries; other tours at least as
    many as that.
    """
    size, rates = most_loads(model), flow_rates(model)
    exact = model.policies.batching.name in {"single", "by-order"}
    for name, flow in model.tasks.flows.items():
        if flow.lines == 1 or isinstance(flow.when, SaturatedArrivals):
            continue
        lines, orders = rates[name], rates[name] / flow.mean_lines
        said = f"{amount(orders)} orders an hour of {amount(flow.mean_lines)} lines on average: {amount(lines)} lines"
        if model.pods is not None:  # how many lines a visit of a pod serves depends on what is open as it comes
            yield f"flow {name}: {said}, each a task"
            continue
        a_trip = math.fsum(share * math.ceil(count / size) for count, share in shares_of(flow.lines).items())
        trips = orders * a_trip if exact else lines / size
        least = "" if exact else "at least "
        yield f"flow {name}: {said}, each a task, in {least}{amount(trips)} trips"


def orders_a_day(model: Model) -> Iterator[str]:
    """How many orders come in 24 h from the start of the run: `asked for: orders 2,704, inbound 640 = 3,344 a day`.

    Nothing where none come at a rate, or where it is not known how long a unit of time is.
    """
    tasks, hour = model.tasks, model.units.hour
    if not model.units.has_seconds:
        return
    day, asked = 24 * hour, {}
    if isinstance(tasks.goods, PoissonGoods):
        asked[""] = 24 * tasks.goods.poisson * model.hours(tasks.goods.hours).share(0.0, day)
    for name, flow in tasks.flows.items():
        if isinstance(flow.when, PoissonArrivals | ProfileArrivals):
            rate = mean_rate(flow, day, hour, model.run.start, model.hours(flow.hours)) or 0.0
            asked[name] = 24 * rate / flow.mean_lines
    if asked:
        whole = math.fsum(asked.values()) * tasks.demand
        each = ", ".join(f"{name} {orders * tasks.demand:,.0f}" for name, orders in asked.items() if name)
        yield f"asked for: {each or f'{amount(whole / 24)} an hour'} = {whole:,.0f} orders a day"


def most_loads(model: Model) -> int:
    """The most loads of a tour; with a batching policy of the user's as many as a robot carries."""
    if model.policies.batching.name == "single":
        return 1
    most, size = model.fleet.largest_capacity, model.policies.batching.params.get("size")
    return most if size is None else min(most, int(size))


def peak_rate(model: Model) -> float | None:
    """Tasks an hour in the busiest hour of a run, where rates change in it; else None."""
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
    """Flows whose rates change (goods: the flow without a name), what is expected of each, and its hours."""
    tasks, hour = model.tasks, model.units.hour
    if isinstance(tasks.goods, PoissonGoods) and tasks.goods.hours is not None:
        yield "", partial(mul, tasks.goods.poisson * tasks.demand / hour), model.hours(tasks.goods.hours)
    for name, flow in tasks.flows.items():
        if isinstance(flow.when, ProfileArrivals):
            yield name, model.rates(flow.when.profile, tasks.demand * flow.mean_lines).expected, model.hours(flow.hours)
        elif isinstance(flow.when, PoissonArrivals) and flow.hours is not None:
            yield name, partial(mul, flow.when.poisson * flow.mean_lines * tasks.demand / hour), model.hours(flow.hours)
