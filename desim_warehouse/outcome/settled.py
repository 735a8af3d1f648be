"""Whether batteries have settled while a run counts: does their mean level fall, what charging costs is to come.

Does it rise, more is charged than will be, and the fleet looks worse than it is.

Settled, each robot charges for the part f of its time in which it takes up what it draws in the rest: with e drawn and
g given for each time unit, (1 - f) e = f g.
"""

from __future__ import annotations

import math
from statistics import fmean, stdev
from typing import TYPE_CHECKING

from desim_warehouse.errors import number_of
from desim_warehouse.findings import amount
from desim_warehouse.model.facts.charging import chargers_at, charging_rate, refills_overnight

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from desim_warehouse.model import Model
    from desim_warehouse.outcome.history import History

LEAST_DRIFT = 0.01
"""Share of the capacity per hour by which the mean level must move."""
CONFIDENCE = 0.99
"""Of the interval that the move must exceed."""


def drifts_of_robots(history: History) -> list[float]:
    """By how much the level of each robot moved in the counted time: shares of the capacity an hour."""
    import numpy as np

    hours = history.counted / history.model.units.hour
    if not history.batteries or not hours:
        return []
    ends = [np.interp((history.begin, history.end), times, levels) for times, levels in history.energy_curves]
    pairs = zip(ends, history.batteries, strict=True)
    return [float(last - first) / battery.capacity / hours for (first, last), battery in pairs]


def fall(values: Sequence[float], model: Model, part: float = 1.0) -> float | None:
    """By how much levels fall, or rise (below 0), from the moves of a run's robots or a design's runs; None: by chance.

    Where the level only swings between two charges, the moves of robots, or of runs, differ as much as their mean does
    from 0 (a t interval). `part`: of the error, where it is asked again as runs come in. Of a fleet that begins settled
    nothing is said: what is left of a drift then is that of the one run in which it settled.
    """
    if model.battery is None or not model.tasks.never_end or len(values) < 2:  # noqa: PLR2004 - no interval of one
        return None
    if model.fleet.start_energy == "settled":
        return None
    mean = -fmean(values)
    if not abs(mean) >= LEAST_DRIFT or refills_overnight(model):
        return None
    from scipy.special import stdtrit

    half = float(stdtrit(len(values) - 1, 1 - (1 - CONFIDENCE) * part / 2)) * stdev(values) / math.sqrt(len(values))
    return mean if abs(mean) > half else None


def expected(kpis: Mapping[str, float], model: Model) -> str:
    """What is to be expected of chargers and robots once batteries have settled, by estimate, in words."""
    time = kpis.get("T", math.nan)
    counted = time - model.run.warm_up if time > model.run.warm_up else time
    away = model.fleet.size * counted * (1 - kpis.get("share_charging", math.nan))
    drawn, chargers = kpis.get("energy", math.nan) / away, sum(chargers_at(model, model.floor).values())
    if not chargers or not math.isfinite(drawn):
        return "what charging costs is not seen"
    charging = model.fleet.size * drawn / (drawn + charging_rate(model))
    if charging > chargers:
        at = number_of(chargers, "charger")
        return f"to give what they draw {amount_of(charging)} robots would have to charge, at {at}"
    used, now = (amount_of(100 * share) for share in (charging / chargers, kpis.get("charger_utilisation", math.nan)))
    return (
        f"settled, by estimate, {amount_of(charging)} robots charge and {amount_of(model.fleet.size - charging)} are "
        f"at work, with chargers used {used} % of the time (here {now} %)"
    )


def amount_of(value: float) -> str:
    """Two digits."""
    return amount(float(f"{value:.2g}"))
