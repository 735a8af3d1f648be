"""Sequential comparison of several changes with a base, until the change that gains most is clear.

For `desim why`, and for caps on the robots under way in `desim plan` and `size`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.checks import check_confidence
from desim_warehouse.study.statistics.intervals import bounds, gaps
from desim_warehouse.study.statistics.judge import schedule
from desim_warehouse.study.statistics.limits import FIRST
from desim_warehouse.study.statistics.procedure import Procedure, request
from desim_warehouse.values.arrays import Floats


@dataclass(frozen=True)
class Gain:
    """The gain of a change in the indicator's unit, positive where it helps: mean, bounds and replications.

    The bounds equal the mean if the values are exact. `same`: no replication differed from the base; there are no
    bounds (nan), because the size of a rare difference is unknown. `failed`: number of replications without a value; if
    any failed, the mean is over the others and has no bounds. `scale`: the factor that scales the gain to an equal
    dose, by which changes are ranked; None if the change is not ranked. `beaten`: another change is shown to gain more
    for an equal dose.
    """

    change: int
    mean: float
    low: float
    high: float
    n: int
    scale: float | None = 1.0
    same: bool = False
    failed: int = 0
    beaten: bool = False

    @property
    def each(self) -> Gain:
        """The gain scaled to an equal dose."""
        by = 1.0 if self.scale is None else self.scale
        return replace(self, mean=by * self.mean, low=by * self.low, high=by * self.high, scale=1.0)

    @property
    def competes(self) -> bool:
        """Whether the change may gain most: it is ranked, has a value in every replication, and has some effect."""
        return self.scale is not None and not self.same and not self.failed


@dataclass(frozen=True)
class Gains:
    """The gains of all changes: competing changes first, ordered by their gain for an equal dose, largest first.

    All intervals hold simultaneously with `confidence`, at every look (interim analysis). `clear`: whether the first
    change is shown to gain more for an equal dose than every other. `none`: whether every competing change is shown to
    gain less than `delta`, unscaled. If neither holds, the runs did not suffice. `failed`: number of replications of
    the base without a value, which end the procedure; `base` is the mean of the others.
    """

    gains: tuple[Gain, ...]
    base: float
    delta: float
    confidence: float
    runs: int
    failed: int = 0

    @property
    def competing(self) -> tuple[Gain, ...]:
        """The gains among which the largest is sought."""
        return tuple(gain for gain in self.gains if gain.competes)

    @property
    def clear(self) -> bool:
        """Whether one change is shown to gain most."""
        first, *others = self.competing or (None,)
        return first is not None and first.low > 0 and all(other.beaten for other in others)

    @property
    def exact(self) -> bool:
        """Whether every gain is exact, so that it equals its bounds."""
        return all(gain.low == gain.high for gain in self.gains if not gain.failed)

    @property
    def none(self) -> bool:
        """Whether every competing change is shown to gain less than `delta`."""
        return all(gain.high < self.delta for gain in self.competing)


def gains_steps(
    scales: Sequence[float | None],
    delta: float,
    confidence: float = 0.95,
    *,
    maximise: bool = True,
    first: int = FIRST,
    cap: int = 160,
    deterministic: bool = False,
) -> Procedure[Gains]:
    """Replicate a base (design 0) and changed designs (1, 2, ...) until one is shown to gain most.

    All changes share the same looks (`judge.looks`). A change drops out if it is shown to gain less than another for an
    equal dose, made no difference in any replication, or has no value in a replication (nan). The procedure ends when
    the one change left is shown to gain, or no change can gain `delta`.

    Args:
        scales: factor for each change that scales its gain to an equal dose; None: the change is looked at once and
            not ranked.
        delta: least gain of a change that matters, in the indicator's unit.
        confidence: probability that all intervals hold and the change that gains most does not drop out.
        maximise: more is better.
        first: replications at the first look.
        cap: most replications.
        deterministic: the values are exact.

    Source: paired differences with common random numbers (Law 2015, section 10.2.1) and one-sided bounds
    (`intervals.bounds`): each gain over the base at alpha / 2 / (2 · changes), and each comparison of two changes at
    alpha / 2 / (changes - 1), because only errors in comparisons with the change that gains most matter. Each look
    spends its share of this alpha (Bonferroni), so that stopping early does not inflate the error rate.
    Assumes: as `bounds`.
    """
    check_confidence(confidence)
    changes = len(scales)
    if changes < 1 or not delta > 0:
        raise StudyError(f"{changes} changes, delta {delta:g}: expected at least one, and a delta above 0")
    sign = 1.0 if maximise else -1.0
    data: dict[int, list[float]] = {design: [] for design in range(changes + 1)}
    alive = list(range(1, changes + 1))
    by_design: dict[int, Gain] = {}
    beaten: set[int] = set()
    for n, part in schedule(first, cap, exact=deterministic):
        error = (1.0 - confidence) / 2 * part
        runs = [(design, r) for r in range(len(data[0]), n) for design in (0, *alive)]
        values = yield from request(runs, failing=True)
        for (design, _), value in zip(runs, values, strict=True):
            data[design].append(value)
        if not np.isfinite(data[0]).all():
            break
        for design in alive:
            gain = _gain(design, data[design], data[0], sign, 1.0 - error / (2 * changes), deterministic)
            by_design[design] = replace(gain, scale=scales[design - 1])
        competing = [design for design in alive if by_design[design].competes]
        doses = {design: sign * _dose(scales[design - 1], data[design], data[0]) for design in competing}
        beaten |= {
            design
            for design in competing
            if any(_is_less(doses[design], doses[other], error / max(changes - 1, 1)) for other in competing)
        }
        alive = [design for design in competing if design not in beaten]
        if not alive or (len(alive) == 1 and by_design[alive[0]].low > 0):
            break
        if all(gain.high < delta for gain in by_design.values() if gain.competes):
            break
    return _ranked(by_design, data, delta, confidence, beaten)


def _dose(scale: float | None, ours: Sequence[float], base: Sequence[float]) -> Floats:
    """Return the differences to the base scaled to an equal dose, day by day."""
    return (1.0 if scale is None else scale) * np.subtract(ours, base[: len(ours)], dtype=float)


def _is_less(ours: Floats, other: Floats, error: float) -> bool:
    """Whether one change is shown to gain less than another on the same days."""
    differences, reach = gaps(ours, other)
    return bool((differences[0] if differences.size == 1 else bounds(differences, 1.0 - error, reach=reach)[1]) < 0)


def _ranked(
    by_design: dict[int, Gain], data: dict[int, list[float]], delta: float, confidence: float, beaten: set[int]
) -> Gains:
    """Rank the gains, and add the mean of the base."""
    gains = [replace(gain, beaten=gain.change in beaten) for gain in by_design.values()]
    ordered = tuple(sorted(gains, key=lambda gain: (not gain.competes, gain.beaten, -gain.each.mean, gain.change)))
    base = np.array(data[0])
    measured = base[np.isfinite(base)]
    mean = float(measured.mean()) if measured.size else math.nan
    return Gains(ordered, mean, delta, confidence, sum(map(len, data.values())), int(base.size - measured.size))


def _gain(
    design: int, ours: Sequence[float], base: Sequence[float], sign: float, level: float, deterministic: bool
) -> Gain:
    has_value = np.isfinite(ours)
    n, failed = len(ours), int((~has_value).sum())
    if failed == n:
        return Gain(design, math.nan, math.nan, math.nan, n, failed=failed)
    differences, reach = gaps(sign * np.array(ours)[has_value], sign * np.array(base[:n])[has_value])
    mean = float(differences.mean())
    if deterministic and not failed:
        return Gain(design, mean, mean, mean, n, same=mean == 0)
    if failed or not differences.any():
        return Gain(design, mean, math.nan, math.nan, n, same=not failed, failed=failed)
    low, high = bounds(differences, level, reach=reach)
    return Gain(design, mean, low, high, n)
