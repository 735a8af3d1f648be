"""Demand in words: orders a day, and orders, lines and trips for them an hour.

For `desim check`, and for the answer of a run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from desim_warehouse.errors import spoken
from desim_warehouse.findings import amount
from desim_warehouse.model import Model
from desim_warehouse.model.facts.demand import flow_rates
from desim_warehouse.model.sections.flows import SaturatedArrivals, mean_rate
from desim_warehouse.model.sections.goods import PoissonGoods
from desim_warehouse.model.sections.lines import shares_of


def orders_asked_for(model: Model) -> Iterator[str]:
    """Yield a line on the demand of each flow whose orders have several lines, in orders, lines and trips an hour.

    With pods the trips are left out. If tasks are batched by order, a trip serves as many lines of an order as a robot
    carries; with other batching the number of trips is a lower bound.
    """
    size, rates, batching = most_loads(model), flow_rates(model), model.policies.batching
    together = batching.params.get("orders", 1) if batching.name == "by-order" else 1
    exact = batching.name in {"single", "by-order"} and together == 1
    for name, flow in model.tasks.flows.items():
        if flow.lines == 1 or isinstance(flow.when, SaturatedArrivals):
            continue
        lines, orders = rates[name], rates[name] / flow.mean_lines
        text = f"{amount(orders)} orders an hour of {amount(flow.mean_lines)} lines on average: {amount(lines)} lines"
        if model.pods is not None:  # how many lines a visit of a pod serves depends on what is open as it comes
            yield f"flow {name}: {text}, each a task"
            continue
        a_trip = math.fsum(share * math.ceil(count / size) for count, share in shares_of(flow.lines).items())
        trips = orders * a_trip if exact else max(lines / size, orders / together if together > 1 else 0.0)
        least = "" if exact else "at least "
        yield f"flow {name}: {text}, each a task, in {least}{amount(trips)} trips"


def orders_a_day(model: Model) -> Iterator[str]:
    """Yield the line on the number of orders in 24 h: `demand: orders 2,704, inbound 640 = 3,344 orders a day`.

    The 24 h begin with the run. Flows from files, or of as many as can be done, are not counted, but named. There is no
    line if no orders come at a rate, or if the unit of time has no known length.
    """
    tasks, hour = model.tasks, model.units.hour
    if not model.units.has_seconds or not tasks.arrive:
        return
    day, asked = 24 * hour, {}
    if isinstance(tasks.goods, PoissonGoods):
        asked[""] = 24 * tasks.goods.poisson * model.hours(tasks.goods.hours).share(0.0, day)
    for name, flow in tasks.flows.items():
        rate = mean_rate(flow, day, hour, model.run.start, model.hours(flow.hours))
        if rate is not None:
            asked[name] = 24 * rate / flow.mean_lines
    whole = math.fsum(asked.values()) * tasks.demand
    each = ", ".join(f"{name} {orders * tasks.demand:,.0f}" for name, orders in asked.items())
    parts = f"{amount(whole / 24)} an hour = " if "" in asked else f"{each} = " if len(asked) > 1 else ""
    others = [name for name in tasks.flows if name not in asked]
    left = f", not counting {spoken(others)}" if others else ""
    yield f"demand: {parts}{whole:,.0f} orders a day{left}"


def most_loads(model: Model) -> int:
    """Return the most loads of a tour; with the user's own batching policy as many as a robot carries."""
    if model.policies.batching.name == "single":
        return 1
    most, size = model.fleet.largest_capacity, model.policies.batching.params.get("size")
    return most if size is None else min(most, int(size))
