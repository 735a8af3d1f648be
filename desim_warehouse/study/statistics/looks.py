"""A verdict on a target that may be looked for again and again while runs come in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.study.statistics.sizes.sizing import judged

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from desim_warehouse.study.statistics.intervals import Interval
    from desim_warehouse.study.statistics.sizes.sizing import DesignVerdict
    from desim_warehouse.study.statistics.targets import Target

LOOKS = {5: 0.02, 10: 0.08, 20: 0.2, 30: 0.3}
"""Replications at which a verdict may fall, and the part of the error that each look may use.

It is little where runs are few, as bounds from few skewed values are wrong more often than they say."""
EVERY = 30
"""Replications between the looks after these; each may use half of what is left."""


def looks(replications: int) -> Iterator[tuple[int, float]]:
    """The looks up to a number of replications: at how many, and the part of the error of each; at most 1 in all."""
    yield from (look for look in LOOKS.items() if look[0] <= replications)
    left = 1.0 - sum(LOOKS.values())
    for n in range(max(LOOKS) + EVERY, replications + 1, EVERY):
        left /= 2
        yield n, left


def looked_at(
    values: Sequence[float],
    target: Target,
    confidence: float,
    *,
    deterministic: bool = False,
    within: Interval,
) -> DesignVerdict[None] | None:
    """The verdict of the first look that gave one, else that of the last; None before the first look.

    A verdict that has fallen stands, so it does not change as further runs come in.

    Args:
        values: of the indicator, replication by replication.
        target: that the mean should meet.
        confidence: that no verdict of `meets` is ever wrong, however many runs there will be; the same of `fails`.
            It holds for all targets on the indicator at once.
        deterministic: the runs use no random numbers, so one is exact.
        within: the range of the indicator, such as (0, 1) for a share.

    Source: the error is split over looks that are fixed beforehand (Bonferroni), most to those at which most runs are
    looked at: Lan & DeMets (1983), Discrete sequential boundaries for clinical trials, Biometrika 70(3), 659-663.
    Assumes: what the bounds of one look assume (`intervals.bounds_of`). Simulated up to 30 runs, with 95 %: of designs
    exactly at the target 3 % are ever called met or 3 % not met with normal values, 5 % with gamma(2) values.
    """
    if deterministic and values:
        return judged(None, list(values[:1]), target, confidence, True, within)
    found = None
    for n, part in looks(len(values)):
        found = judged(None, list(values[:n]), target, 1.0 - (1.0 - confidence) * part, False, within)
        if found.verdict != "undecided":
            break
    return found
