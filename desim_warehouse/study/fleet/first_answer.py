"""What a plan believes after its scouts, for those who wait: the fleet, and about how many are to be judged."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from desim_warehouse.errors import number_of
from desim_warehouse.study.statistics.cheapest import Cost, Counts, within_counts


def first_answer(designs: Sequence[Counts], cost: Cost, doubted: Collection[int], name: Callable[[int], str]) -> str:
    """What the scouts of a plan say, in a line.

    Judged are the cheapest fleet that they do not doubt, and of the cheaper ones those that rule out all others, unless
    their verdicts turn out otherwise.

    Args:
        designs: all counts that could be built.
        cost: what one costs.
        doubted: numbers of designs that failed.
        name: what a design is called.
    """
    failed = _largest([designs[number] for number in doubted])
    order = sorted(range(len(designs)), key=lambda number: cost(designs[number]))
    cheaper: list[Counts] = []
    for number in order:
        if not any(within_counts(designs[number], other) for other in failed):
            judged = 1 + len(_largest(cheaper))
            return f"about {name(number)}, by single days; some {number_of(judged, 'fleet')} to judge"
        cheaper.append(designs[number])
    return "no fleet is enough, by single days"


def _largest(designs: Sequence[Counts]) -> list[Counts]:
    """Those of designs that have no more of all counts than another."""
    found: list[Counts] = []
    for design in sorted(designs, reverse=True):
        if not any(within_counts(design, other) for other in found):
            found.append(design)
    return found
