"""Search for the fleet that does most: with pods, more robots may do worse, as each pod visit serves fewer lines.

A few runs compare some fleets, then the neighbours of the best. A plan searches up to the best fleet, where more robots
do no worse. The runs that judge the plan are others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.statistics.judge import Budget, RunsEndedError
from desim_warehouse.study.statistics.procedure import Procedure, request

RUNS = 3
APART = 12
"""Number of fleets compared at first, spread over all, and again between the neighbours of the best."""


@dataclass(frozen=True)
class Most:
    """The fleet with the best mean, the largest fleet, and both means.

    `up_to`: the largest fleet that does not do worse, that is, whose mean is not worse by more than the indifference
    zone.
    """

    robots: int
    mean: float
    largest: int
    at_largest: float
    up_to: int


def most_steps(robots: Sequence[int], target: Target, zone: float, budget: Budget) -> Procedure[Most | None]:
    """Find the fleet that does most, among ascending numbers of `robots`.

    Return None if the largest fleet does not do worse, or if the budget is exhausted before the search ends.
    """
    last = len(robots) - 1
    means: dict[int, float] = {}

    def look(low: int, high: int) -> Procedure[int]:
        ranks = sorted({low + round(n * (high - low) / (APART - 1)) for n in range(APART)} - means.keys())
        asked = [(rank, run) for rank in ranks for run in range(RUNS)]
        budget.take(len(asked))
        values = yield from request(asked, failing=True)
        for n, rank in enumerate(ranks):
            some = values[n * RUNS : (n + 1) * RUNS]
            means[rank] = -math.inf if any(map(math.isnan, some)) else target.sign * fmean(some)
        return max(sorted(means), key=means.__getitem__)

    try:
        best = yield from look(0, last)
        low = max((rank for rank in means if rank < best), default=best)
        high = min((rank for rank in means if rank > best), default=best)
        best = yield from look(low, high)
    except RunsEndedError:
        return None
    as_good = max(rank for rank, mean in means.items() if mean >= means[best] - zone)
    if as_good == last:
        return None
    mean, at_largest = (target.sign * means[rank] for rank in (best, last))
    return Most(robots[best], mean, robots[last], at_largest, robots[as_good])
