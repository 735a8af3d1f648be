"""What one long run says: means and quantiles of observations that depend on each other, from batches of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.checks import check_confidence, check_share, finite, is_constant
from desim_warehouse.study.statistics.intervals import ANYTHING, bounds

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from desim_warehouse.study.statistics.intervals import Interval

BATCHES = (20, 10, 5)
SMALL_BATCHES = 100  # a fifth of a batch of 20 each: their independence is tested
LEAST_WORTH = 300  # independent observations: a run that is worth fewer is too short
_SURE = 1.6449  # of a standard normal variable 5 % lie above


@dataclass(frozen=True)
class OneRun:
    """A mean or a quantile over one run, in the unit of the observations, with its interval.

    `correlation` is that of neighbouring small batches; `independent` is False where it is too large to be chance:
    the run is too short then, and the interval too narrow. `worth`: as many independent observations would tell as
    much; with fewer than 300 no test sees that batches depend on each other. An end of the `interval` is infinite where
    the run has too few observations beyond the quantile.
    """

    value: float
    interval: Interval
    observations: int
    correlation: float
    independent: bool
    confidence: float
    worth: float = math.inf

    @property
    def bounded(self) -> bool:
        """Whether both ends of the interval are known."""
        return all(map(math.isfinite, self.interval))

    @property
    def note(self) -> str:
        """What is wrong with the run, in words, or nothing if it is long enough."""
        if not self.independent:
            return f"batches depend on each other (correlation {self.correlation:.2f}): run longer"
        if not self.bounded:
            return "too few observations beyond the quantile: run longer"
        few = self.worth < LEAST_WORTH
        return f"worth only {self.worth:.0f} independent observations: run longer" if few else ""


def batch_means(
    values: Sequence[float] | NDArray[np.float64], confidence: float = 0.95, *, within: Interval = ANYTHING
) -> OneRun:
    """The mean of observations of one run in order of time, warm-up left out, with the interval of batch means.

    The interval reaches as far as those of 20, of 10 and of 5 batches: dependence that is left between 20 batches shows
    in longer ones, and a run that happens to be calm, which no test can tell from a short-memoried one, is wider.

    Args:
        values: observations in order of time (the cycle times of the tasks, the deliveries of every minute), in any
            unit, shape (n,). Batches hold equally many of them, or one more.
        confidence: of the two-sided interval.
        within: the range of the indicator. The interval stays within it.

    Raises:
        StudyError: fewer than 100 observations, or one that is not finite.

    Source: Schmeiser (1982), Batch size effects in the analysis of simulation output, Operations Research 30(3),
    556-568: 10 to 30 batches; more gain nearly nothing, and being shorter depend on each other more. The check: the
    ratio of von Neumann (1941) on the means of 100 small batches, one-sided at 5 %, as Fishman (1978), Grouping
    observations in digital simulation, Management Science 24(5), 510-521, and Alexopoulos & Seila (1998), Output data
    analysis, in Banks (ed.), Handbook of Simulation, chapter 7, use it. Where small batches show no dependence, those
    five times as long have next to none. Interval of the batch means: `intervals.bounds`.
    Assumes: a steady state; a warm-up that is left out. In at most 6 % of runs a 95 % interval is said to be of
    independent batches and misses the mean (autoregressive series up to 0.98, waits of M/M/1 up to load 0.9); of the
    runs without a note docs/dev/validation.md says how often the interval covers.
    """
    check_confidence(confidence)
    array = _enough(values)
    interval = _interval(array, 0.5 + confidence / 2, within)
    return OneRun(float(array.mean()), interval, array.size, *_dependence(array), confidence, _worth(array))


def quantile_in_run(values: Sequence[float] | NDArray[np.float64], share: float, confidence: float = 0.95) -> OneRun:
    """A quantile of observations of one run in order of time, with its interval between two order statistics.

    The observations up to the quantile are a share of all; the interval of that share, by batch means, says how far
    up and down the order of the observations the true quantile may lie.

    Args:
        values: as of `batch_means`.
        share: which quantile, between 0 and 1: 0.95 for the time that 95 % stay below.
        confidence: of the two-sided interval.

    Raises:
        StudyError: as `batch_means`, or a share that is not between 0 and 1.

    Source: Woodruff (1952), Confidence intervals for medians and other position measures, J. American Statistical
    Association 47(260), 635-646, with the variance of the share from batches, as dependence asks for: Heidelberger &
    Lewis (1984), Quantile estimation in dependent sequences, Operations Research 32(1), 185-209. Quantiles: type 7 of
    Hyndman & Fan (1996).
    Assumes: as `batch_means`.
    """
    check_confidence(confidence)
    check_share(share)
    array = _enough(values)
    found = float(np.quantile(array, share))
    below = (array <= found).astype(float)
    low, high = _interval(below, 0.5 + confidence / 2)
    middle = float(below.mean())
    interval = _at(array, share - (high - middle)), _at(array, share + (middle - low))
    return OneRun(found, interval, array.size, *_dependence(below), confidence, _worth(below))


def _enough(values: Sequence[float] | NDArray[np.float64]) -> NDArray[np.float64]:
    if len(values) < SMALL_BATCHES:
        raise StudyError(f"one run: {len(values)} observations, expected at least {SMALL_BATCHES}; run longer")
    return finite(values, "one run")


def _means(array: NDArray[np.float64], batches: int) -> NDArray[np.float64]:
    return np.array([batch.mean() for batch in np.array_split(array, batches)])


def _interval(array: NDArray[np.float64], level: float, within: Interval = ANYTHING) -> Interval:
    """As far as the bounds by any number of batches reach; longer ones that agree say nothing of their own."""
    most, *fewer = (_means(array, batches) for batches in BATCHES)
    ends = [bounds(means, level, within) for means in (most, *(one for one in fewer if not is_constant(one)))]
    return min(low for low, _ in ends), max(high for _, high in ends)


def _worth(array: NDArray[np.float64]) -> float:
    """How many independent observations tell as much: their variance over that of the mean, by small batches."""
    small = _means(array, SMALL_BATCHES)
    if is_constant(array) or is_constant(small):
        return float(array.size)
    left = min(max(_dependence(array)[0], 0.0), 0.99)  # as an autoregressive series of small batches
    return float(array.var(ddof=1) * SMALL_BATCHES / small.var(ddof=1) * (1.0 - left) / (1.0 + left))


def _dependence(array: NDArray[np.float64]) -> tuple[float, bool]:
    """The correlation of neighbouring small batches by von Neumann's ratio, and whether it may be chance."""
    means = _means(array, SMALL_BATCHES)
    if is_constant(means):
        return 0.0, True
    n = means.size
    away, steps = means - means.mean(), np.diff(means)
    correlation = 1.0 - float(steps @ steps) / (2.0 * float(away @ away))
    return correlation, correlation * math.sqrt((n * n - 1) / (n - 2)) <= _SURE


def _at(array: NDArray[np.float64], share: float) -> float:
    """A quantile, infinite where there is none."""
    if not 0.0 <= share <= 1.0:
        return math.copysign(math.inf, share)
    return float(np.quantile(array, share))
