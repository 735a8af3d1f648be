"""What a run comes to in money: the year's cost, from its prices and what was counted in the run."""

from __future__ import annotations

import math
from collections.abc import Sequence

from desim_warehouse.model.facts.charging import spare_batteries
from desim_warehouse.model.schema import Prices
from desim_warehouse.outcome.history import History


def equipment(prices: Prices, kinds: Sequence[str], chargers: int, batteries: int) -> float:
    """What robots of these kinds, these chargers and these spare batteries cost a year."""
    robots = math.fsum(prices.kinds.get(kind, prices.robot) for kind in kinds)
    return robots + prices.charger * chargers + prices.battery * batteries


def is_fixed(prices: Prices | None) -> bool:
    """Whether nothing in the cost of a year depends on a run."""
    return prices is not None and not (prices.energy or prices.late_order)


def annual_cost(history: History) -> float:
    """The cost of a year of `prices.hours` hours like those counted, nan without prices or counted time."""
    prices, hours = history.model.prices, history.counted / history.model.units.hour
    if prices is None or not hours:
        return math.nan
    servers = math.fsum(
        (station.servers + (spec.workers if spec.work_time is not None else 0))
        * history.model.hours(spec.hours).share(history.begin, history.end)
        for node, station in history.layout.stations.items()
        for spec in (history.model.layout.stations[station.zone],)
    )
    by_the_hour = (
        prices.energy * history.totals["energy"] / hours
        + prices.station_hour * servers
        + prices.late_order * late(history) / hours
    )
    kinds = history.model.fleet.kinds_of_robots()
    spare = sum(spare_batteries(history.model).values())
    return equipment(prices, kinds, history.chargers, spare) + by_the_hour * prices.hours


def cost_per_task(history: History) -> float:
    """The year's cost by the tasks that it delivers at the rate counted, nan where there were none."""
    prices, hours = history.model.prices, history.counted / history.model.units.hour
    tasks = history.totals["delivered"] / hours if hours else 0.0
    return annual_cost(history) / (tasks * prices.hours) if prices is not None and tasks else math.nan


def late(history: History) -> int:
    """Orders that came due in the counted time and were not done by then; a task of no order is one by itself."""
    alone = history.settled(task.deadline for task in history.tasks.values() if not task.order)
    return sum(one.missed for one in (*history.order_deadlines, *alone))
