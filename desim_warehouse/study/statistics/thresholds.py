"""How a number that is needed follows uncertain inputs: where it turns, and what not knowing an input costs.

Shares are compared by their odds, as 98 and 99 % are not as far apart as 90 and 91 %: that raised R² from 0.80 to
0.94 on a small hall. Three probes of an input on the same six days are interpolated by a parabola; the interval holds
the points at which the mean is not told from the target (Fieller), or where it is beside it by no more than the
smallest step between two values. In short runs of work that always waits all six days may have the same count:
without that step two of seven plants had intervals without width.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.checks import check_confidence
from desim_warehouse.study.statistics.intervals import t_quantile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


_DRAWS = 20_000
"""Points at which losses are averaged."""
_SLICES = 20
"""Parts of an input's range within which it counts as known."""
_STEPS = 2000
"""Points between two probes at which a crossing is looked for."""


@dataclass(frozen=True)
class LinearNeed:
    """A need that follows its inputs by straight lines: from the middle of all ranges, by so much over each range.

    `spread` is the standard deviation of what the inputs leave open, `fit` the adjusted R², `errors` are half-widths
    of 95 % intervals of the effects.
    """

    middle: float
    effects: tuple[float, ...]
    errors: tuple[float, ...]
    spread: float
    fit: float


def linear_need(shares: Floats, needs: Sequence[float], level: float = 0.975) -> LinearNeed:
    """Fit needs at points of the unit cube, shape (points, inputs), by least squares.

    Raises:
        StudyError: hardly more points than inputs.
    """
    points, inputs = shares.shape
    free = points - inputs - 1
    if free < 1:
        raise StudyError(f"{points} points for {inputs} inputs: expected at least {inputs + 2}")
    design = np.c_[np.ones(points), shares - 0.5]
    needed = np.asarray(needs, float)
    found, *_ = np.linalg.lstsq(design, needed, rcond=None)
    rest = needed - design @ found
    variance = float(rest @ rest) / free
    total = float(((needed - needed.mean()) ** 2).sum()) / (points - 1)
    errors = t_quantile(free, level) * np.sqrt(np.diag(np.linalg.pinv(design.T @ design)) * variance)
    fit = 1 - variance / total if total > 0 else math.nan
    return LinearNeed(float(found[0]), tuple(found[1:].tolist()), tuple(errors[1:].tolist()), math.sqrt(variance), fit)


@dataclass(frozen=True)
class Worth:
    """What not knowing costs, with one unit too many at the price 1, and how much less it is with an input known.

    `middle` is the number needed where all inputs are in the middle, `safe` the one that costs least in expectation,
    and `doubt` the chance that this many are too few.
    """

    middle: int
    safe: int
    doubt: float
    cost: float
    inputs: tuple[float, ...]


def worth(need: LinearNeed, confidence: float = 0.95, seed: int = 0) -> Worth:
    """The expected value of knowing each input, all of them uniform over their ranges and independent.

    One unit missing costs c / (1 - c) as much as one too many, with c the `confidence`: then it is cheapest to have
    enough with that probability.

    Source: expected value of partial perfect information, as in Briggs, Sculpher & Claxton (2006), Decision Modelling
    for Health Economic Evaluation, chapter 7, by slices of the input; the newsvendor's critical ratio.
    """
    check_confidence(confidence)
    random = np.random.default_rng(seed)
    shares = random.random((_DRAWS, len(need.effects)))
    latent = need.middle + (shares - 0.5) @ np.array(need.effects) + random.normal(0, need.spread, _DRAWS)
    needed = np.ceil(latent)
    fleets = np.arange(needed.min(), needed.max() + 1)
    missing = confidence / (1 - confidence)
    losses = np.array([np.maximum(n - needed, 0) + missing * np.maximum(needed - n, 0) for n in fleets])
    means = losses.mean(axis=1)
    safe, cost = fleets[means.argmin()], float(means.min())
    gains = []
    for known in shares.T:
        part = np.minimum((known * _SLICES).astype(int), _SLICES - 1)
        left = sum(float(losses[:, part == number].sum(axis=1).min()) for number in range(_SLICES)) / _DRAWS
        gains.append(max(0.0, cost - left))
    return Worth(math.ceil(need.middle), int(safe), float((needed > safe).mean()), cost, tuple(gains))


@dataclass(frozen=True)
class Crossing:
    """Where a mean crosses a bound, with an interval, or -inf and inf where an end was not found between the probes."""

    at: float
    low: float
    high: float


def crossing(probes: Sequence[float], values: Floats, bound: float, level: float = 0.975) -> Crossing | None:
    """Where the mean of values at three probes crosses a bound; None where the means lie on one side.

    Args:
        probes: where the runs were done, ascending, shape (3,).
        values: of the same days at each probe, shape (days, 3).
        bound: what is to be crossed.
        level: of each end of the interval.

    Each day is interpolated by the parabola through its values. The interval has the points at which the mean of the
    days is not told from the bound (Fieller 1954, Some problems in interval estimation, by a test at each point).
    Means are told from it by more than the smallest step between two values only, as days may agree on a count by
    chance, or always.
    """
    first, middle, last = probes
    at = np.unique(np.concatenate([np.linspace(first, middle, _STEPS), np.linspace(middle, last, _STEPS)]))
    days = len(values)
    weights = np.array(
        [
            (at - middle) * (at - last) / ((first - middle) * (first - last)),
            (at - first) * (at - last) / ((middle - first) * (middle - last)),
            (at - first) * (at - middle) / ((last - first) * (last - middle)),
        ]
    )
    beyond = values @ weights - bound
    mean, error = beyond.mean(axis=0), beyond.std(axis=0, ddof=1) / math.sqrt(days)
    turns = np.flatnonzero(np.sign(mean[:-1]) != np.sign(mean[1:]))
    if not len(turns) or np.sign(mean[0]) == np.sign(mean[-1]):
        return None
    where = int(turns[len(turns) // 2])
    step = np.diff(np.unique(values)).min()
    inside = np.abs(mean) <= np.maximum(t_quantile(days - 1, level) * error, step)
    before, after = where, where + 1
    while before > 0 and inside[before]:
        before -= 1
    while after < len(at) - 1 and inside[after]:
        after += 1
    low = -math.inf if before == 0 and inside[0] else float(at[before])
    high = math.inf if after == len(at) - 1 and inside[-1] else float(at[after])
    return Crossing(float(at[where]), low, high)
