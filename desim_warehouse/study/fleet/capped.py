"""Gain of a cap on the robots under way (`traffic.most_out`), for fleets whose robots block each other.

Beyond some number of robots a floor's throughput falls (`outcome.verdicts` has the source). If robots wait much, a few
caps are compared with no cap on the same days. `desim size --key traffic.most_out` finds the best cap of all.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from statistics import fmean
from typing import Any

from desim_warehouse.model import Model
from desim_warehouse.outcome.indicators import find
from desim_warehouse.outcome.verdicts import LEAST_WAITING
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.effects import Gain, Gains, gains_steps
from desim_warehouse.study.statistics.limits import FIRST
from desim_warehouse.study.statistics.procedure import Procedure, request
from desim_warehouse.study.study import searched

KEY = "traffic.most_out"
PARTS = (0.75, 0.5, 0.33)
"""Caps to try, as shares of the fleet."""
MOST_RUNS = 20
"""Most replications of each cap, by default."""
LEAST = 0.01
"""Least gain that matters, as a share of the indicator's mean."""


@dataclass(frozen=True)
class Capped:
    """The effect of a cap: with at most `cap` of `robots` under way, `indicator` has this `mean`, better by `gain`."""

    robots: int
    cap: int
    indicator: str
    mean: float
    gain: Gain

    @property
    def overrides(self) -> dict[str, Any]:
        """The changes that cap the model."""
        return {KEY: self.cap}


def caps(model: Model) -> list[int]:
    """Return the caps to try for a model, none if the model has a cap."""
    if model.traffic.most_out is not None:
        return []
    most = {math.ceil(part * model.fleet.size) for part in PARTS}
    return sorted((cap for cap in most if cap < model.fleet.size), reverse=True)


def waits_much(runs: Iterable[Mapping[str, float]]) -> bool:
    """Whether robots wait in traffic so long that fewer robots under way may do more work."""
    shares = [kpis.get("share_waiting", 0.0) for kpis in runs]
    return bool(shares) and fmean(shares) >= LEAST_WAITING


def tried_cap(
    model: Model,
    indicator: str,
    search: Search = USUAL,
) -> tuple[Capped | None, int]:
    """Return the cap that gains most, or None if no cap is shown to gain; and the number of runs done.

    Args:
        model: the warehouse without a cap.
        indicator: indicator to improve.
        search: how runs are done (by default 5 replications at the first look at each cap, and at most 20).
    """
    tried, better = caps(model), find(indicator).better
    if not tried or better is None:
        return None, 0
    cases = {"no cap": {}, **{f"at most {cap} under way": {KEY: cap} for cap in tried}}
    study = searched(model, {"cap": {"cases": cases}}, search, name="cap")
    first, most = search.looks(FIRST, MOST_RUNS)

    def steps(exact: bool) -> Procedure[Gains]:
        base = yield from request([(0, 0)], failing=True)
        least = LEAST * (abs(base[0]) if math.isfinite(base[0]) and base[0] else 1.0)
        return (
            yield from gains_steps(
                [1.0] * len(tried),
                least,
                search.confidence,
                maximise=better == "more",
                first=first,
                cap=most,
                deterministic=exact,
            )
        )

    result = study.follow(steps, indicator, failed=math.nan, search=search)
    gain = next((gain for gain in result.gains if gain.low > 0 and not gain.failed), None)
    if gain is None:
        return None, result.runs
    mean = result.base + (gain.mean if better == "more" else -gain.mean)
    return Capped(model.fleet.size, tried[gain.change - 1], indicator, mean, gain), result.runs
