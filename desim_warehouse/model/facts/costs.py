"""The cost of a design a year: robots, chargers, spare batteries, wages; a run adds energy and late orders."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from desim_warehouse.model.facts.charging import chargers_at, spare_batteries
from desim_warehouse.model.facts.people import PEOPLE, at_work
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
        chargers: all of them; None: without batteries only those that the model counts, as nobody uses the others.
        people: how many are paid in some stations, in all nodes of each, and under "" of no station.
    """
    prices = model.prices
    if prices is None:
        return math.nan
    if chargers is None:
        chargers = _chargers(model)
    if kinds is None:
        kinds = model.fleet.kinds_of_robots()
    robots = math.fsum(prices.kinds.get(kind, prices.robot) for kind in kinds)
    things = robots + prices.charger * chargers + prices.battery * sum(spare_batteries(model).values())
    wages = {name: getattr(prices, kind.wage) for name, kind in PEOPLE.items()}
    if not any(wages.values()):
        return things
    return things + math.fsum(wages[name] * prices.hours * number for name, number in at_work(model, people).items())


def _chargers(model: Model) -> int:
    """Count the chargers that are paid: without a battery, only chargers that the model states for their bay."""
    bays = model.floor.bays
    at_nodes = chargers_at(model, model.floor).items()
    return sum(count for node, count in at_nodes if model.battery is not None or bays[node].chargers is not None)
