"""Whether one more of a count does worse than a design that is enough: what searches of sizes assume not to be so."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from desim_warehouse.study.statistics.comparison import paired
from desim_warehouse.study.statistics.procedure import Procedure, request

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.study.statistics.intervals import Estimate
    from desim_warehouse.study.statistics.sizes.cheapest import Budget
    from desim_warehouse.study.statistics.targets import Target

FIRST_PAIRS, MOST_PAIRS = 10, 40
"""Replications of a larger design: at first, and where they lean to its being worse."""


@dataclass(frozen=True)
class Larger:
    """A design with one more of one count: by how much its indicator differs, and whether that is shown to be worse."""

    number: int
    difference: Estimate
    worse: bool


def larger_steps(
    best: int,
    designs: Sequence[tuple[int, int]],
    target: Target,
    runs: int,
    confidence: float,
    budget: Budget,
    *,
    deterministic: bool = False,
) -> Procedure[tuple[Larger, ...]]:
    """Judge the designs with one more of either count than the best, as far as the runs allowed go.

    Both are held against it run by run with the same random numbers, each at half of the error that is allowed, and
    each look at one at half of that.
    """
    numbers = {design: number for number, design in enumerate(designs)}
    first, second = designs[best]
    more = [numbers[design] for design in ((first + 1, second), (first, second + 1)) if design in numbers]
    runs, found = min(runs, MOST_PAIRS), list[Larger]()
    base = yield from request([(best, r) for r in range(runs)])
    looks = sorted({min(runs, FIRST_PAIRS), runs})
    level = 1 - (1 - confidence) / (2 * len(looks))
    for number in more:
        values, now = list[float](), None
        for n in looks:
            if not budget.allows(n - len(values)):
                break
            budget.take(n - len(values))
            values += yield from request([(number, r) for r in range(len(values), n)])
            difference = paired(values, base[:n], level, deterministic=deterministic)
            low, high = difference.interval or (difference.mean, difference.mean)
            now = Larger(number, difference, (high if target.sign > 0 else -low) < 0)
            if now.worse or target.sign * difference.mean >= 0:
                break
        found += [] if now is None else [now]
    return tuple(found)
