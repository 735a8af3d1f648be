"""Rare events, for the verdicts of plans and of the live page: how often breakdowns or closures fall into a run.

This determines, before any run, how many days a verdict needs, and which events a few runs may miss.
"""

from __future__ import annotations

import math
from collections import defaultdict

from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.model.facts.costs import is_fixed
from desim_warehouse.outcome.indicators import is_measured
from desim_warehouse.study.statistics.limits import COMMON_DAYS, RARE_DAYS, DaysNeeded, days_for
from desim_warehouse.values.distributions import mean_of

FEW = 20
"""Number of runs below which intervals of times do not reflect rare days."""
_OFTEN = 1 / 3
"""Probability of an event in a run from which even few runs show its cost."""


def expected(model: Model, length: float) -> dict[str, float]:
    """Return the expected number of each kind of failure in a run of this length, in the model's time.

    Robots break down while they operate, so for breakdowns it is an upper bound.
    """
    often = defaultdict[str, float](float)
    for robot in model.fleet.robots():
        if robot.breakdowns is not None:
            often["breakdowns"] += length / mean_of(robot.breakdowns.every)
    layout = model.floor
    for node, chargers in chargers_at(model, layout).items():
        outages = layout.bays[node].outages
        if outages is not None:
            often["outages of chargers"] += chargers * length / (mean_of(outages.every) + mean_of(outages.repair))
    for lift in layout.lifts:
        if (outages := lift.outages) is not None:
            often["outages of lifts"] += length / (mean_of(outages.every) + mean_of(outages.repair))
    return dict(often)


def chances(model: Model, length: float | None) -> dict[str, float]:
    """Return the probability that a run of this length has each kind of failure at all; nan without a length."""
    if length is None:
        return dict.fromkeys(expected(model, 1.0), math.nan)
    return {what: -math.expm1(-often) for what, often in expected(model, length).items()}


def days_needed(model: Model, first: int | None = None, cap: int | None = None) -> DaysNeeded:
    """Return the least and the most days for which a fleet is simulated before a verdict that it meets a target.

    There are more of them where the model has events rarer than one day in ten, or of unknown rarity.

    Args:
        model: the warehouse with that fleet.
        first: the user's lower limit of days before a verdict, if any.
        cap: the user's upper limit of days, if any.
    """
    often = chances(model, model.run.length).values()
    days = COMMON_DAYS if all(_covered(chance, COMMON_DAYS.least) for chance in often) else RARE_DAYS
    least = max(days.least, first or 0)
    days = DaysNeeded(least, max(days.cap, 2 * least) if least > days.least else days.cap)
    return days if cap is None else days.up_to(cap)


def beyond(model: Model, days: int) -> dict[str, int]:
    """Return the failures too rare for so many days, each with the days that would cover it (0: unknown)."""
    often = chances(model, model.run.length)
    return {what: days_for(chance) if chance > 0 else 0 for what, chance in often.items() if not _covered(chance, days)}


def _covered(chance: float, days: int) -> bool:
    """Whether so many days include, with 95 % probability, an event that has this chance on each."""
    return chance > 0 and (chance >= 1 or days_for(chance) <= days)


def closed(model: Model, length: float | None = None) -> list[str]:
    """List the closures that never fall into the evaluation period of a run of this length, a line for each.

    `length` None: the length of the model's run.
    """
    end = length or model.run.length or math.inf
    return [
        f"closures of {name} never fall into a run: their cost does not show here"
        for name, closure in model.traffic.closures.items()
        if end < math.inf and not model.hours(closure.hours).share(model.run.warm_up, end)
    ]


def shows(model: Model, indicator: str) -> bool:
    """Whether agreement of an indicator in a few runs shows that it is equal in all runs.

    This holds if the indicator is measured (not a count), and no rare event may change it.
    """
    if is_fixed(model, indicator):
        return True
    return is_measured(indicator) and not chances(model, model.run.length)


def unknown(model: Model, runs: int, length: float) -> list[str]:
    """List the rare events that so few runs of this length miss: closures that never come, failures they may lack."""
    lines = closed(model, length)
    for what, chance in chances(model, length).items():
        if 0 < chance < _OFTEN and runs < min(FEW, days_for(chance)):
            cover = "one run does not cover" if runs == 1 else f"intervals of times from {runs} runs do not cover"
            lines.append(f"{what} come on one day in {round(1 / chance)}: {cover} such days")
    return lines
