"""Annual cost of a design (`model.facts.costs`) together with the energy and late orders of a run.

For the indicators of cost.
"""

from __future__ import annotations

import math

from desim_warehouse.model.facts.costs import year_of
from desim_warehouse.outcome.history import History


def annual_cost(history: History) -> float:
    """Return the cost of a year with `prices.hours` hours like the evaluation period; nan without prices or period."""
    prices, hours = history.model.prices, history.counted / history.model.units.hour
    if prices is None or not hours:
        return math.nan
    by_the_hour = (prices.energy * history.totals["energy"] + prices.late_order * late(history)) / hours
    return year_of(history.model, counted=(history.begin, history.end)) + by_the_hour * prices.hours


def cost_per_task(history: History) -> float:
    """Return the annual cost divided by the tasks of a year at the throughput of the run; nan without tasks."""
    prices, hours = history.model.prices, history.counted / history.model.units.hour
    tasks = history.totals["delivered"] / hours if hours else 0.0
    return annual_cost(history) / (tasks * prices.hours) if prices is not None and tasks else math.nan


def late(history: History) -> int:
    """Count the orders that came due in the evaluation period, its end included, and missed their due times.

    A task without an order counts as an order.
    """
    alone = history.falling_due(task.deadline for task in history.tasks.values() if not task.order)
    return sum(deadline.missed for deadline in (*history.order_deadlines, *alone))
