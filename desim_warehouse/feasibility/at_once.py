"""The finding that a whole fleet needs chargers at once, because equal batteries run low together.

Batteries that start at equal levels, in robots that never rest, reach the charging threshold at nearly the same time,
since they differ only by the power drawn in the states of a robot. If d is the difference between the largest and the
smallest power, the standard deviation of the energy drawn is about d / 4 times the square root of the time worked times
the time of a task. If all batteries are low before the first robot is back, no robot works until then, however many
chargers there are.

For `desim check`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from desim_warehouse.errors import number_of
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.findings import Finding, amount
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import levels, start_energy
from desim_warehouse.model.facts.day_parts import time_of_day
from desim_warehouse.model.facts.demand import always_open

ALWAYS_AT_WORK = 0.95
"""Share of its time at work from which on a fleet has no time to charge in between."""
APART = 4.0
"""Time from the first robot that is low to the last, in standard deviations."""


def warnings(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    """Find fleets whose robots are all low before the first of them has been charged."""
    balance, thresholds, end = estimate.power, levels(model), model.run.end
    if (
        balance is None
        or balance.kinds
        or thresholds is None
        or thresholds.swap_time is not None
        or model.battery is None
    ):
        return
    low, high = start_energy(model)
    if not balance.chargers or not balance.charging_rate or low < high or _at_work(model, estimate) < ALWAYS_AT_WORK:
        return
    battery = model.battery
    states, draw = battery.draws, balance.task / estimate.cycle.time if estimate.cycle.time else 0.0
    worked = (low * battery.capacity - thresholds.critical) / draw if draw else math.inf
    each = (thresholds.sufficient - thresholds.critical) / balance.charging_rate
    rates = states.standing, states.empty, states.loaded, states.handling
    apart = APART * (max(rates) - min(rates)) / 4 / draw * math.sqrt(worked * estimate.cycle.time) if draw else math.inf
    if not 0 < worked < end or apart >= each:
        return
    units, waiting = model.units, max(model.fleet.size - balance.chargers, 0)
    by_clock = model.run.start != "00:00" and units.has_seconds
    when = f"at about {time_of_day(model, worked)}" if by_clock else f"after about {amount(worked)} {units.time}"
    waits = f" for {number_of(model.fleet.size, 'robot')}, so that {waiting:,} wait" if waiting else " for all"
    yield Finding(
        "CHARGE_AT_ONCE",
        "fleet.start_energy",
        (
            f"{when}, within {amount(apart)} {units.time}, all batteries reach the level at which robots charge, and "
            f"charging takes {amount(each)}: nothing is delivered until the first are back, with "
            f"{number_of(balance.chargers, 'charger')}{waits}"
        ),
        "batteries that begin at different levels (fleet.start_energy: settled, or {uniform: [0.3, 1]}), or a charging "
        "policy that charges some of them before",
    )


def _at_work(model: Model, estimate: QuickEstimate) -> float:
    """Return the share of the fleet's time that its work takes, at most 1."""
    if always_open(model):
        return 1.0
    return min(estimate.rate * estimate.cycle.time / estimate.robots, 1.0) if estimate.rate is not None else 0.0
