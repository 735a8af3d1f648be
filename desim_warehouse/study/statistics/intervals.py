"""Confidence intervals of means, quantiles and shares: one rule, for all methods, chooses the interval by the values.

For shares of tasks, such as tasks on time, the interval allows for the dependence between tasks of one day.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from desim_warehouse.study.statistics.checks import (
    ROUNDING,
    check_confidence,
    check_same,
    check_share,
    finite,
    is_constant,
)
from desim_warehouse.values.arrays import Floats

Interval = tuple[float, float]
QUANTILES = (0.05, 0.25, 0.75, 0.95)
ANYTHING: Interval = (-math.inf, math.inf)
NOT_NEGATIVE: Interval = (0.0, math.inf)
SKEWED_FROM = 10  # fewest values to correct for skewness; that of fewer values is mostly chance
AGREEING = 5
"""The fewest runs that must agree in an indicator for it to count as equal in all runs."""
ALIKE = 0.04
"""The least intra-class correlation assumed between tasks of one day, however alike a few days are.

Days of drafts at and above their target show 0 to 0.008, overloaded ones 0.014 (docs/dev/performance.md)."""
FEW = 18
"""The number of days from which the least correlation falls in proportion, as they show how days vary."""
RARE = 5
"""The fewest missed tasks assumed at the upper limit of the effective sample size, however many days there are."""


def t_quantile(df: float, probability: float) -> float:
    """Return the `probability` quantile of Student's t with `df` degrees of freedom (scipy.special: loads fast)."""
    from scipy.special import stdtrit

    return float(stdtrit(df, probability))


@dataclass(frozen=True)
class Estimate:
    """The summary of an indicator over the replications of one design, in the indicator's unit.

    `interval` is None for one replication of a random model, for a `deterministic` model, whose mean is exact, and for
    a measurement that is 0 in all runs, as nothing tells how far from 0 another run may lie.
    `sd` (divisor n-1) is None for one replication of a random model. An `sd` of 0 without `deterministic` means that
    the replications agree so far. The `mean` of shares of tasks weighs all replications equally, however many tasks
    they have.
    """

    n: int
    mean: float
    interval: Interval | None
    sd: float | None
    median: float
    quantiles: dict[float, float]
    deterministic: bool
    confidence: float

    @property
    def half_width(self) -> float | None:
        """The distance from the mean to the farther end of the interval; None without an interval."""
        return None if self.interval is None else max(self.mean - self.interval[0], self.interval[1] - self.mean)

    @property
    def relative_half_width(self) -> float | None:
        """Half-width as a share of |mean|; None without an interval, infinite for a mean of zero."""
        if self.half_width is None:
            return None
        return self.half_width / abs(self.mean) if self.mean else math.inf


def estimate(
    values: Sequence[float] | Floats,
    confidence: float = 0.95,
    *,
    deterministic: bool = False,
    within: Interval = ANYTHING,
    counts: bool = False,
) -> Estimate:
    """Estimate the mean of an indicator, with interval, median and quantiles, from one value per replication.

    Args:
        values: one number per replication, any unit, shape (n,); shares of tasks as `TaskShare`.
        confidence: of the two-sided interval, between 0 and 1.
        deterministic: the runs used no random numbers, so one replication is enough. Agreement of values is not
            taken as evidence of this, since the next run may differ.
        within: the range of the indicator, such as (0, 1) for a share. The interval stays within it.
        counts: whether the values count events or tasks.

    Raises:
        StudyError: no values, one that is not finite, a bad confidence, or a model said to be deterministic
            whose values differ.

    Source: `bounds`; means of replications: Law (2015), Simulation Modeling and Analysis, 5th ed., section
    9.4.1. Quantiles: linear interpolation, type 7 of Hyndman & Fan (1996).
    Assumes: as `bounds`; n is chosen in advance.
    """
    array = finite(values)
    check_confidence(confidence)
    if deterministic:
        check_same(array)
    interval = None
    if not deterministic and array.size > 1:
        interval = with_width(bounds_of(values, 0.5 + confidence / 2, within, counts))
    return described(array, interval, deterministic, confidence)


def bounds_of(
    values: Sequence[float] | Floats, level: float, within: Interval = ANYTHING, counts: bool = False
) -> Interval:
    """Return the bounds of the mean of an indicator over runs; for shares of tasks in several runs, `share_bounds`."""
    array, tasks = finite(values), tasks_of(values)
    if tasks is None or array.size == 1:
        return bounds(array, level, within, counts=counts)
    return share_bounds(array, tasks, level)


def with_width(interval: Interval) -> Interval | None:
    """Return an interval, or None if its ends are equal, as for a measurement that is 0 in all runs."""
    return interval if interval[0] < interval[1] else None


def described(array: Floats, interval: Interval | None, deterministic: bool, confidence: float) -> Estimate:
    """Describe the values of an indicator, or of a difference, given the interval of their mean."""
    n = array.size
    constant = is_constant(array)
    return Estimate(
        n=n,
        mean=float(array.mean()),
        interval=interval,
        sd=0.0 if deterministic or (constant and n > 1) else float(array.std(ddof=1)) if n > 1 else None,
        median=float(np.median(array)),
        quantiles=dict(zip(QUANTILES, np.quantile(array, QUANTILES).tolist(), strict=True)),
        deterministic=deterministic,
        confidence=confidence,
    )


def bounds(
    array: Floats, level: float, within: Interval = ANYTHING, *, counts: bool = False, reach: float | None = None
) -> Interval:
    """Return a lower and an upper bound of the mean, each right with probability `level`, from at least two values.

    If all values are 0 or 1, as for a rare event, the bounds are Clopper & Pearson's exact bounds of a proportion, or
    for `counts` Garwood's exact bounds of a Poisson mean. If all values are equal, a share 1 - (1 - level)^(1/n) of all
    runs (the rule of three: 3/n) may still give another value, `reach` away; by default this distance is the width of
    the range `within`, or without one that to zero. So the bounds do not depend on the unit; both are 0 for a
    measurement that is always 0. In all other cases the bounds are Student's t, corrected for skewness from ten values
    on.

    A `reach` also marks the values as differences, for which 0 and 1 have no special meaning, as they have none for
    measurements of at least 0, such as times.

    Source: Clopper & Pearson (1934), Biometrika 26(4), 404-413; Garwood (1936), Fiducial limits for the Poisson
    distribution, Biometrika 28(3/4), 437-442; Hanley & Lippman-Hand (1983), If nothing goes wrong, is everything all
    right?, JAMA 249(13), 1743-1745; Law (2015), section 4.5 (t); Hall (1992), On the removal of skewness by
    transformation, J. Royal Statistical Society B 54(1), 221-228.
    Assumes: values independent and identically distributed. Coverage of 95 % intervals from ten values is 94 to 96 %
    for an exponential or small count (t: 90 %), and 91 % for a lognormal with sigma 1 (t: 84 %). For mean cycle times
    where one day in ten has a breakdown, it is 64 % from ten values and 94 % from 40.
    """
    n, mean = array.size, float(array.mean())
    is_0_or_1 = reach is None and bool(np.isin(array, (0.0, 1.0)).all())
    if is_0_or_1 and counts:
        from scipy.special import gammaincinv

        events = array.sum()
        low = float(gammaincinv(events, 1.0 - level)) / n if events else 0.0
        high = float(gammaincinv(events + 1, level)) / n
    elif is_constant(array):
        width = within[1] - within[0]
        off = differing_share(n, level) * (reach if reach is not None else width if width < math.inf else abs(mean))
        low, high = mean - off, mean + off
    elif is_0_or_1 and within != NOT_NEGATIVE:
        from scipy.special import betaincinv

        ones = int(array.sum())  # neither 0 nor n: such values are all equal
        low, high = float(betaincinv(ones, n - ones + 1, 1.0 - level)), float(betaincinv(ones + 1, n - ones, level))
    else:
        (se, skew), t = _error(array), t_quantile(n - 1, level)
        low, high = mean - se * _from_symmetric(t, skew), mean - se * _from_symmetric(-t, skew)
    return max(low, within[0]), min(high, within[1])


def p_value(array: Floats, reach: float) -> float:
    """Return the two-sided p-value of the hypothesis that differences have mean zero, by inverting `bounds`.

    The array has at least two values. If all are equal, `reach` is how far an unseen value may lie from them.
    """
    mean = float(array.mean())
    if is_constant(array):
        return min(1.0, 2.0 * max(0.0, 1.0 - abs(mean) / reach) ** array.size)
    from scipy.special import stdtr

    se, skew = _error(array)
    return 2.0 * float(stdtr(array.size - 1, -abs(_to_symmetric(mean / se, skew))))


def gaps(ours: Floats, base: Floats) -> tuple[Floats, float]:
    """Return the differences by replication, and how far an unseen difference may lie from them if they all agree.

    This distance is at least 1, the range of either design, and the distance to the opposite difference. Differences
    that are equal up to rounding of the values are made equal.
    """
    differences = ours - base
    scale = float(max(np.abs(ours).max(), np.abs(base).max()))
    if is_constant(differences, scale):
        differences = np.full_like(
            differences, 0.0 if np.allclose(ours, base, rtol=ROUNDING, atol=0.0) else np.median(differences)
        )
    return differences, float(max(1.0, 2.0 * abs(differences.mean()), np.ptp(ours), np.ptp(base)))


def does_not_vary(values: Sequence[float] | Floats, within: Interval) -> bool:
    """Whether an indicator counts as equal in all runs: its values agree to 12 digits in five or more runs.

    Do not call this for counts, nor for shares and rates of counts, which may agree by chance. Values at an end of
    the range `within`, such as waiting times that are all 0, never count as equal in all runs.
    """
    array = finite(values)
    return array.size >= AGREEING and is_constant(array) and within[0] < float(array[0]) < within[1]


def differing_share(n: int, level: float) -> float:
    """Return the upper bound, at probability `level`, of the share of all runs that differ from n runs that agree."""
    return float(1.0 - (1.0 - level) ** (1.0 / n))


def _error(array: Floats) -> tuple[float, float]:
    """Return the standard error of the mean and the skewness over sqrt(n); the latter is 0 for few values."""
    n = array.size
    se = float(array.std(ddof=1)) / math.sqrt(n)
    if n < SKEWED_FROM:
        return se, 0.0
    z = (array - array.mean()) / array.std()
    return se, float((z * z * z).mean()) / math.sqrt(n)


def _to_symmetric(t: float, a: float) -> float:
    """Make a t statistic with skewness over sqrt(n) of `a` nearly symmetric by Hall's cubic; at least half of `t`."""
    made = t + a * t**2 / 3 + a**2 * t**3 / 27 + a / 6
    return max(made, t / 2) if t > 0 else min(made, t / 2)


def _from_symmetric(x: float, a: float) -> float:
    """Invert `_to_symmetric`: return the t statistic that it maps to x, at most twice as far from 0."""
    made = x if abs(a) < 1e-6 else 3 / a * (float(np.cbrt(1 + a * (x - a / 6))) - 1)  # noqa: PLR2004 - digits lost
    return min(made, 2 * x) if x > 0 else max(made, 2 * x)


@dataclass(frozen=True)
class QuantileEstimate:
    """A quantile over replications, in the indicator's unit.

    An end of the interval is None if there are too few replications for it, or the model is `deterministic`.
    """

    share: float
    n: int
    value: float
    low: float | None
    high: float | None
    confidence: float
    deterministic: bool = False


def quantile(
    values: Sequence[float] | Floats, share: float, confidence: float = 0.95, *, deterministic: bool = False
) -> QuantileEstimate:
    """Estimate a quantile of an indicator from one value per replication, with an interval between two values.

    Args:
        values: one number per replication, any unit, shape (n,).
        share: which quantile, between 0 and 1.
        confidence: of the two-sided interval, a lower bound of its coverage for any distribution.
        deterministic: the runs used no random numbers, so one replication is enough.

    Raises:
        StudyError: no values, one that is not finite, a share or confidence not between 0 and 1, or a model said to be
            deterministic whose values differ.

    Source: `scipy.stats.quantile_test` (Conover 1999, Practical Nonparametric Statistics, section 3.2): how many
    values lie below the quantile is binomial. Quantile: type 7 of Hyndman & Fan (1996).
    Assumes: values independent and identically distributed, n chosen in advance.
    """
    array = finite(values)
    check_confidence(confidence)
    check_share(share)
    if deterministic:
        check_same(array)
    value = float(np.quantile(array, share))
    if deterministic:
        return QuantileEstimate(share, array.size, value, None, None, confidence, deterministic=True)
    from scipy.stats import quantile_test

    interval: Any = quantile_test(array, q=0.0, p=share).confidence_interval(confidence)
    low, high = (None if math.isnan(end) else float(end) for end in (interval.low, interval.high))
    return QuantileEstimate(share, array.size, value, low, high, confidence)


def replications_for_quantile(share: float, confidence: float = 0.95) -> int:
    """Return the fewest replications with which `quantile` gives both ends of an interval.

    All of n values lie below the quantile with probability share^n, and all lie above it with (1 - share)^n.
    """
    tail = (1.0 - confidence) / 2
    return math.ceil(math.log(tail) / math.log(max(share, 1.0 - share)))


class TaskShare(float):
    """A share of the tasks of one run, as a float that also holds the number of tasks, `of`."""

    of: float

    def __new__(cls, share: float, tasks: float = 0.0) -> Self:
        """Create a share of a number of tasks; 0 if unknown, as for a mean that `statistics` makes of several."""
        made = super().__new__(cls, share)
        made.of = tasks
        return made


def tasks_of(values: Sequence[float] | Floats) -> Floats | None:
    """Return the number of tasks behind each share, shape (n,); None unless all values are shares of tasks."""
    counts = [value.of for value in values if isinstance(value, TaskShare) and value.of > 0]
    return np.array(counts) if counts and len(counts) == len(values) else None


def share_bounds(shares: Floats, tasks: Floats, level: float) -> tuple[float, float]:
    """Return a lower and an upper bound of the mean share over all days, each right with probability `level`.

    The lower bound is Clopper and Pearson's with the effective sample size of Korn and Graubard: the number of
    independent tasks whose mean would vary as much as the means of days do. This size is limited to that of tasks with
    a correlation of 0.04 within a day (Kish's design effect, 1 + (tasks - 1) 0.04), so that each of up to 18 days
    counts for at most 25 tasks; if all days are alike, nothing more is known. For n >= 18 days the correlation is 0.04
    times 18 / n, since rarer bad days matter less. Then as many tasks count as the variation between days shows,
    but the bound is at most the one for 5 missed tasks at the limit of the size: where nearly all tasks are on time,
    days show little of how they vary.

    The upper bound is the larger of Student's t over days and Clopper and Pearson's for independent tasks. It needs no
    least correlation: a few days tend to lack the rare bad ones, which lower the mean, and for shares with a tail of
    bad days Student's t is too high rather than too low.

    Neither bound falls when a day gets better: the lower bound is the minimum over all cases in which the best days
    had been perfect, and the upper bound the minimum over all cases in which the worst days had been less bad.

    Args:
        shares: share of tasks on each day, shape (n,), n at least 2.
        tasks: number of tasks on each day, shape (n,).
        level: of each bound, above 0.5.

    Source: Korn & Graubard (1998), Confidence intervals for proportions with small expected number of positive counts
    estimated from survey data, Survey Methodology 24(2), 193-201; Kish (1965), Survey Sampling, section 5.4; Clopper &
    Pearson (1934), Biometrika 26(4), 404-413.
    Assumes: days independent. docs/dev/validation.md lists error rates by the correlation of the tasks of a day.
    """
    n = shares.size
    most, alone = (_worth(tasks, alike) for alike in (ALIKE * min(1.0, FEW / n), 0.0))
    worst_first = np.sort(shares)
    missed = 1.0 - worst_first
    high = max(_by_tasks_high(float(shares.mean()), alone, level), _by_days_high(worst_first, level))
    low = _low(missed, most, level)
    if n >= FEW:
        low = max(low, min(_low(missed, alone, level), float(_by_tasks_low(RARE / most, most, level))))
    return low, min(high, 1.0)


def _worth(tasks: Floats, alike: float) -> float:
    """Return the effective sample size of the tasks of all days, with correlation `alike` within a day."""
    return tasks.size**2 / float(((1.0 + (tasks - 1.0) * alike) / tasks).sum())


def _low(missed: Floats, most: float, level: float) -> float:
    """Return the lower bound from each day's share of missed tasks, worst day first; at most `most` tasks count."""
    from scipy.special import ndtri

    n = missed.size
    sums, squares = np.cumsum(missed), np.cumsum(missed**2)  # of the worst days, the others perfect
    means = np.clip(sums / n, 0.0, 1.0)
    wider = (t_quantile(n - 1, level) / float(ndtri(level))) ** 2
    varies = wider * np.maximum(squares / n - means**2, 0.0) / (n - 1)
    binomial = means * (1.0 - means)
    tasks = np.where(varies * most > binomial, binomial / np.maximum(varies, 1e-300), most)
    return float(_by_tasks_low(means, tasks, level).min())


def _by_tasks_low(missed: Any, tasks: Any, level: float) -> Floats:
    """Return Clopper and Pearson's lower bound for numbers of tasks with a share missed, elementwise."""
    from scipy.special import betaincinv

    met = np.maximum((1.0 - missed) * tasks, 1e-12)
    return np.where(missed < 1.0, betaincinv(met, missed * tasks + 1.0, 1.0 - level), 0.0)


def _by_tasks_high(mean: float, most: float, level: float) -> float:
    """Return Clopper and Pearson's upper bound for a mean share of a number of tasks."""
    from scipy.special import betaincinv

    return float(betaincinv(mean * most + 1.0, (1.0 - mean) * most, level)) if mean < 1.0 else 1.0


def _by_days_high(days: Floats, level: float) -> float:
    """Return the minimum, over k and c, of Student's t upper bound if the k worst days had all been c.

    For k days at c it is a + k c / n + b sqrt(u² + d), convex in c = u + away: its least value has a closed form.
    """
    n, best = days.size, days[-1]
    k = np.arange(1, n)
    below = days - best  # sums of these are exact where the days left are alike
    rest, squares = (np.cumsum(power[::-1])[::-1][1:] for power in (below, below**2))
    scale = k * (n - k) / n
    away = rest / (n - k)
    spread = np.maximum(squares - rest**2 / (n - k), 0.0) / scale
    times = t_quantile(n - 1, level) / math.sqrt(n * (n - 1)) * np.sqrt(scale)
    slope = k / n / times  # from 1 on it rises with c everywhere
    turn = away - slope * np.sqrt(spread / np.where(slope < 1.0, 1.0 - slope**2, 1.0))
    offset = np.where(slope < 1.0, np.clip(turn, below[:-1], below[1:]), below[:-1])
    highs = (rest + k * offset) / n + times * np.sqrt((offset - away) ** 2 + spread)
    return float(best + highs.min())
