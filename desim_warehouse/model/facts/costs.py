"""The cost of a design a year: robots, chargers, spare batteries, wages; a run adds energy and late orders.

Wages are paid to the people whom `workers.staff` names in each station, for its open hours, and to pickers for theirs.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.model.facts.charging import chargers_at, spare_batteries
from desim_warehouse.model.facts.workers import staff

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from desim_warehouse.model.schema import Model, Prices


def is_fixed(prices: Prices | None) -> bool:
    """Whether nothing in the cost of a year depends on a run."""
    return prices is not None and not (prices.energy or prices.late_order)


def year_of(
    model: Model,
    kinds: Sequence[str] | None = None,
    chargers: int | None = None,
    people: Mapping[str, int] | None = None,
) -> float:
    """Return the cost of a design a year before it runs, nan without prices; None stands for the model's own value.

    Args:
        model: prices, and the rest of the design.
        kinds: the kind of each robot.
        chargers: all of them.
        people: how many are paid in some stations, in all nodes of each.
    """
    prices = model.prices
    if prices is None:
        return math.nan
    if chargers is None:
        chargers = sum(chargers_at(model, model.floor).values())
    if kinds is None:
        kinds = model.fleet.kinds_of_robots()
    robots = math.fsum(prices.kinds.get(kind, prices.robot) for kind in kinds)
    begin, end, numbers = model.run.warm_up, model.run.end, people or {}
    if model.pickers is not None:
        at_work = model.hours(model.pickers.hours).share(begin, end)
        robots += prices.picker_hour * prices.hours * model.pickers.count * at_work
    things = robots + prices.charger * chargers + prices.battery * sum(spare_batteries(model).values())
    if not prices.station_hour:
        return things
    paid = math.fsum(
        numbers.get(zone, group.number) * model.hours(model.layout.stations[zone].hours).share(begin, end)
        for zone, group in staff(model).items()
    )
    return things + prices.station_hour * prices.hours * paid
