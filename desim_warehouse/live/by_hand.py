"""What can be said of a design before any run: the quick estimate, or why it cannot be simulated."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from desim_warehouse.errors import CheckError
from desim_warehouse.feasibility import errors
from desim_warehouse.live.offers import ROBOTS
from desim_warehouse.report.text.numbers import number, percent
from desim_warehouse.run.quick import estimate

if TYPE_CHECKING:
    from collections.abc import Mapping

    from desim_warehouse.feasibility.estimate import QuickEstimate
    from desim_warehouse.model import Model


class ByHand(NamedTuple):
    """The quick estimate of a design: a sentence, one more, and by key what would be enough."""

    sentence: str
    more: str
    needed: Mapping[str, float]


def by_hand(model: Model, design: str) -> ByHand:
    """Estimate what a design does.

    Raises:
        CheckError: where it cannot work, with cures; what the model accepts is no reason.
    """
    found = [item.problem for item in errors(model) if item.code not in model.accept]
    if found:
        raise CheckError(found)
    calculation = estimate(model)
    return ByHand(
        _sentence(calculation, model.units.hour, design),
        "Quick estimate, ignoring traffic and randomness. The simulation follows.",
        _needed(calculation, model),
    )


def _sentence(found: QuickEstimate, hour: float, design: str) -> str:
    capacity = f"about {number(found.capacity * hour, 0)}" if math.isfinite(found.capacity) else ""
    if found.rate is None:
        end = f"limited by {found.bottleneck}"
        return (
            f"{design} can do {capacity} tasks an hour, {end}." if capacity else f"{design}: nothing limits the work."
        )
    asked = number(found.rate * hour, 0)
    if found.capacity < found.rate:
        return f"{design} can do {capacity} of the {asked} tasks asked for an hour, limited by {found.bottleneck}."
    if found.power is not None and found.power.short:
        return f"{design}: the chargers give less than the fleet draws; {found.power.needed} are needed."
    return f"{design}: the robots would be busy {percent(found.rate / found.fleet_capacity, 0)} % of the time."


def _needed(found: QuickEstimate, model: Model) -> dict[str, float]:
    needed: dict[str, float] = {}
    if found.robots_needed is not None and math.isfinite(found.robots_needed):
        needed[ROBOTS] = math.ceil(found.robots_needed - 1e-9)
    if found.power is not None and found.power.needed:
        for zone, bay in model.layout.bays.items():
            if bay.total_chargers:
                needed[f"layout.bays.{zone}.total_chargers"] = found.power.needed
    return needed
