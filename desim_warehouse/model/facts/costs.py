"""The cost of a design a year: robots, chargers, spare batteries, wages; a run adds energy and late orders."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from desim_warehouse.model.facts.charging import chargers_at, spare_batteries
from desim_warehouse.model.facts.people import PACKERS, PEOPLE, PICKERS, at_work
from desim_warehouse.model.schema import Model
from desim_warehouse.values.calendars import Stretch

COST = "annual_cost"
"""The indicator of the cost of a year."""


def is_fixed(model: Model, indicator: str = COST) -> bool:
    """Whether no run changes an indicator: the annual cost alone, where it needs neither energy nor the end of work."""
    prices = model.prices
    if indicator != COST or prices is None or prices.energy or prices.late_order:
        return False
    pickers = () if model.pickers is None else (model.pickers.hours,)
    hours = {PACKERS: [spec.hours for spec in model.layout.stations.values()], PICKERS: pickers}
    by_the_clock = any(any(hours[name]) for name, kind in PEOPLE.items() if getattr(prices, kind.wage))
    return model.tasks.never_end or not by_the_clock


def year_of(
    model: Model,
    kinds: Sequence[str] | None = None,
    chargers: int | None = None,
    people: Mapping[str, int] | None = None,
    counted: Stretch | None = None,
) -> float:
    """Return the cost of a design a year without energy and late orders, nan without prices.

    None stands for the model's own value.

    Args:
        model: prices, and the rest of the design.
        kinds: the kind of each robot.
        chargers: all of them; None: the chargers of the model, without batteries only where a bay gives their number.
        people: how many are paid in some stations, in all nodes of each, and under "" of no station.
        counted: begin and end of the time whose hours are paid; None: as far as it is known before a run.
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
    paid = at_work(model, counted or (model.run.warm_up, model.run.end), people)
    return things + math.fsum(wages[name] * prices.hours * number for name, number in paid.items())


def _chargers(model: Model) -> int:
    """Count the chargers that are paid; without batteries, only chargers for which a bay gives a number."""
    bays = model.floor.bays
    at_nodes = chargers_at(model, model.floor).items()
    return sum(count for node, count in at_nodes if model.battery is not None or bays[node].chargers is not None)
