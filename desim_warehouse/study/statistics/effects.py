"""What each of several changes gains over a base: replicated until the one that gains most is clear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.checks import check_confidence
from desim_warehouse.study.statistics.intervals import bounds, gaps
from desim_warehouse.study.statistics.procedure import Procedure, request
from desim_warehouse.study.statistics.sizing import looks_at

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True)
class Gain:
    """What a change gains, in the indicator's unit, more is better: mean, bounds and replications.

    The bounds are equal to the mean where the values are exact.
    """

    change: int
    mean: float
    low: float
    high: float
    n: int


@dataclass(frozen=True)
class Gains:
    """All gains, the largest first; all intervals hold at once with `confidence`, at every look of the procedure.

    `clear`: whether the first is shown to gain more than every other, and more than `delta` that does not matter.
    `none`: whether every change is shown to gain less than `delta`. Neither: the runs allowed did not tell.
    """

    gains: tuple[Gain, ...]
    base: float
    delta: float
    confidence: float
    runs: int

    @property
    def clear(self) -> bool:
        """Whether one change is shown to gain most."""
        first, *others = self.gains
        return first.low > 0 and all(first.low > other.high for other in others)

    @property
    def none(self) -> bool:
        """Whether nothing is shown to matter."""
        return all(gain.high < self.delta for gain in self.gains)


def gains_steps(
    changes: int,
    delta: float,
    confidence: float = 0.95,
    *,
    maximise: bool = True,
    n0: int = 10,
    cap: int = 160,
    deterministic: bool = False,
) -> Procedure[Gains]:
    """Replicate a base (design 0) and `changes` changed designs (1, 2, ...) until it is clear which gains most.

    After n0 replications of all, and at every doubling up to `cap`, changes that are shown to gain less than the best
    drop out. It ends when one is left, or no change can gain `delta`, the least gain that matters.

    Source: paired differences with common random numbers (Law 2015, section 10.2.1), one-sided bounds
    (`intervals.bounds`), each at 1 - α / (2 · changes · looks) (Bonferroni), so that stopping early costs nothing.
    Assumes: as `bounds`.
    """
    check_confidence(confidence)
    if changes < 1 or not delta > 0:
        raise StudyError(f"{changes} changes, delta {delta:g}: expected at least one, and a delta above 0")
    looks = [1] if deterministic else looks_at(n0, cap)
    level = 1.0 - (1.0 - confidence) / (2 * changes * len(looks))
    sign = 1.0 if maximise else -1.0
    data: dict[int, list[float]] = {design: [] for design in range(changes + 1)}
    alive = list(range(1, changes + 1))
    found: dict[int, Gain] = {}
    for n in looks:
        runs = [(design, r) for r in range(len(data[0]), n) for design in (0, *alive)]
        values = yield from request(runs)
        for (design, _), value in zip(runs, values, strict=True):
            data[design].append(value)
        for design in alive:
            found[design] = _gain(design, data[design], data[0], sign, level, deterministic)
        best = max(found.values(), key=lambda gain: gain.mean)
        alive = [design for design in alive if found[design].high >= max(best.low, 0.0)]
        if len(alive) <= 1 or all(gain.high < delta for gain in found.values()):
            break
    ordered = tuple(sorted(found.values(), key=lambda gain: (-gain.mean, gain.change)))
    return Gains(ordered, float(np.mean(data[0])), delta, confidence, sum(map(len, data.values())))


def _gain(
    design: int, ours: Sequence[float], base: Sequence[float], sign: float, level: float, deterministic: bool
) -> Gain:
    found, reach = gaps(sign * np.array(ours), sign * np.array(base[: len(ours)]))
    mean = float(found.mean())
    low, high = (mean, mean) if deterministic else bounds(found, level, reach=reach)
    return Gain(design, mean, low, high, len(ours))
