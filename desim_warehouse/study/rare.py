"""Disasters that a study of few runs hardly sees: by the model, as no test of ten days can tell."""

from __future__ import annotations

import math

from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.values.distributions import mean_of

RARE = 1 / 3
"""Expected in a run: what is rarer may be missing in all of ten runs."""
FEW = 10
"""Expected in all runs: with fewer, intervals do not know what such a thing costs."""


def expected(model: Model, length: float) -> dict[str, float]:
    """How many of each kind of failure and closure are to be expected in a run of this length, in the model's time.

    Robots break down while they operate, so for breakdowns it is an upper bound.
    """
    found: dict[str, float] = {}
    for robot in model.fleet.robots():
        if robot.breakdowns is not None:
            found["breakdowns"] = found.get("breakdowns", 0.0) + length / mean_of(robot.breakdowns.every)
    layout = model.floor
    for node, chargers in chargers_at(model, layout).items():
        outages = layout.bays[node].outages
        if outages is not None:
            often = chargers * length / (mean_of(outages.every) + mean_of(outages.repair))
            found["outages of chargers"] = found.get("outages of chargers", 0.0) + often
    for name, closure in model.traffic.closures.items():
        if not model.hours(closure.hours).share(model.run.warm_up, length):
            found[f"closures of {name}"] = 0.0
    return found


def warnings(model: Model, runs: int, length: float) -> list[str]:
    """A line for each kind of disaster that is rarer than one in three runs, where all runs together saw few."""
    if not (runs and length < math.inf):
        return []
    return [_line(what, often, runs) for what, often in expected(model, length).items() if _is_hidden(often, runs)]


def _is_hidden(often: float, runs: int) -> bool:
    return often < RARE and often * runs < FEW


def _line(what: str, often: float, runs: int) -> str:
    if not often:
        return f"{what} never fall into a run: nothing here says what they cost"
    seen = f"{often:.2g} to be expected in a run, {often * runs:.2g} in {runs} runs"
    return f"{what} are rare ({seen}): intervals of few runs do not know what one costs"
