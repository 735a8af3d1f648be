"""The first answer of a plan, after its scouts (pilot runs): a fleet, and about how many fleets are to be judged."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from desim_warehouse.errors import number_of
from desim_warehouse.study.statistics.cheapest import Cost, Counts, within_counts


def first_answer(designs: Sequence[Counts], cost: Cost, doubted: Collection[int], name: Callable[[int], str]) -> str:
    """Return the first answer of a plan, by its scouts (pilot runs), in one line.

    Next, the plan judges the cheapest fleet that scouts do not doubt, and the cheaper fleets that rule out all others,
    unless verdicts contradict the scouts.

    Args:
        designs: counts of all designs that could be built.
        cost: sort key of a design by cost.
        doubted: numbers of designs that failed in pilot runs.
        name: function that names a design.
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
    """Return the designs that no other design exceeds in every count."""
    largest: list[Counts] = []
    for design in sorted(designs, reverse=True):
        if not any(within_counts(design, other) for other in largest):
            largest.append(design)
    return largest
