"""The first answer of a plan, after its scouts, for people who wait: the fleet, and about how many are to be judged."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from desim_warehouse.errors import number_of
from desim_warehouse.study.statistics.cheapest import Cost, Counts, within_counts


def first_answer(designs: Sequence[Counts], cost: Cost, doubted: Collection[int], name: Callable[[int], str]) -> str:
    """The first answer, by the scouts of a plan, in a line.

    The plan goes on to judge the cheapest fleet that scouts do not doubt, and the cheaper fleets that rule out all
    others, unless their verdicts turn out otherwise.

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
            return f"first guess from single days: {name(number)}; about {number_of(judged, 'fleet')} to judge"
        cheaper.append(designs[number])
    return "first guess from single days: no fleet is enough"


def _largest(designs: Sequence[Counts]) -> list[Counts]:
    """The designs that no other design exceeds in every count."""
    largest: list[Counts] = []
    for design in sorted(designs, reverse=True):
        if not any(within_counts(design, other) for other in largest):
            largest.append(design)
    return largest
