"""With pods more robots may do worse, as each visit of a pod serves fewer lines: which fleet does most.

Fleets are judged beside each other, by a few runs of some of them, then of those beside the best. Up to it, more does
not do worse, as everywhere, and a plan searches there. The runs are not those that judge.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import fmean
from typing import TYPE_CHECKING

from desim_warehouse.study.statistics.procedure import request

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.study.statistics import Procedure, Target

RUNS = 3
APART = 12
"""Fleets that are looked at first, spread over all."""


@dataclass(frozen=True)
class Most:
    """The fleet with the best mean, the largest fleet, and both means. `up_to`: the largest that does not do worse.

    A fleet does worse whose mean is beyond the indifference zone.
    """

    robots: int
    mean: float
    largest: int
    at_largest: float
    up_to: int


def most_steps(robots: Sequence[int], target: Target, zone: float) -> Procedure[Most | None]:
    """The fleet that does most, among numbers of `robots` in order; None where the largest does not do worse."""
    last = len(robots) - 1
    first = sorted({round(rank * last / (APART - 1)) for rank in range(APART)})
    means: dict[int, float] = {}

    def look(ranks: Sequence[int]) -> Procedure[None]:
        asked = [(rank, run) for rank in ranks if rank not in means for run in range(RUNS)]
        values = yield from request(asked, failing=True)
        for n in range(0, len(asked), RUNS):
            some = values[n : n + RUNS]
            means[asked[n][0]] = -math.inf if any(map(math.isnan, some)) else target.sign * fmean(some)

    yield from look(first)
    best = max(means, key=means.__getitem__)
    beside = [rank for rank in first if rank < best][-1:] + [rank for rank in first if rank > best][:1]
    yield from look(range(min(beside, default=best), max(beside, default=best) + 1))
    best = max(means, key=means.__getitem__)
    as_good = max(rank for rank, mean in means.items() if mean >= means[best] - zone)
    if as_good == last:
        return None
    mean, at_largest = (target.sign * means[rank] for rank in (best, last))
    return Most(robots[best], mean, robots[last], at_largest, robots[as_good])
