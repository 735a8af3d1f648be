"""Whether one more of a count does worse than a design that is enough: what searches of sizes assume not to be so."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from desim_warehouse.study.statistics.comparison import paired
from desim_warehouse.study.statistics.procedure import Procedure, request

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.study.statistics.cheapest import Budget
    from desim_warehouse.study.statistics.intervals import Estimate
    from desim_warehouse.study.statistics.targets import Target

MOST_PAIRS = 40
"""Replications of a larger design."""


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

    Both are held against it run by run with the same random numbers, each at half of the error that is allowed.
    """
    numbers = {design: number for number, design in enumerate(designs)}
    first, second = designs[best]
    more = [numbers[design] for design in ((first + 1, second), (first, second + 1)) if design in numbers]
    runs, found = min(runs, MOST_PAIRS), list[Larger]()
    base = yield from request([(best, r) for r in range(runs)])
    for number in more:
        if not budget.allows(runs):
            break
        budget.take(runs)
        values = yield from request([(number, r) for r in range(runs)])
        difference = paired(values, base, 1 - (1 - confidence) / 2, deterministic=deterministic)
        low, high = difference.interval or (difference.mean, difference.mean)
        found.append(Larger(number, difference, (high if target.sign > 0 else -low) < 0))
    return tuple(found)
