"""Which distribution do measured times follow? Maximum likelihood, Akaike's criterion, Cramér and von Mises' test."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.study.fit.families import Counted, clock_step, families

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from desim_warehouse.study.fit.families import Family, Parameters
    from desim_warehouse.values.distributions import Distribution

FEWEST = 20
"""Measured times from which on a distribution is proposed."""
TESTED = 2000
"""Times that the test takes at most: with more, every smooth curve is refuted by the clock that measured them."""
SAMPLES = 199
"""Samples of the proposed distribution to which the measured times are compared."""
BOUNDED = {"uniform", "triangular"}
"""Families with a largest time."""
LEVEL = 0.05
"""A p-value below this speaks against a distribution."""


@dataclass(frozen=True)
class Candidate:
    """A family with its most likely parameters, and Akaike's criterion: the less, the better.

    `share_below(times)` is its distribution function.
    """

    distribution: Distribution
    aic: float
    share_below: Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True)
class Fitted:
    """Distributions for measured times, best first.

    Attributes:
        times: what was measured.
        candidates: by Akaike's criterion, best first.
        statistic: Cramér and von Mises', of the best.
        p_value: the part of samples of the best distribution, fitted in the same manner, that lie as far from theirs.
        step: to which the times were rounded, 0: they were not.
    """

    times: NDArray[np.float64]
    candidates: tuple[Candidate, ...]
    statistic: float
    p_value: float
    step: float = 0.0

    @property
    def best(self) -> Distribution:
        """The distribution that fits best."""
        return self.candidates[0].distribution

    @property
    def fits(self) -> bool:
        """Whether nothing speaks against the best one."""
        return self.p_value >= LEVEL


def fit(times: Sequence[float] | NDArray[np.float64]) -> Fitted:
    """Fit exponential, gamma, lognormal, Weibull, uniform and triangular distributions to measured times.

    Times that a clock has rounded, to whole seconds or tenths, are taken for what they are: somewhere between half a
    step below and half a step above. Their likelihood is that of these intervals. Where the steps are small beside the
    spread, that is the same as the density.

    The p-value is Monte Carlo with the parameters fitted anew to every sample, which is rounded as the times were (as
    Lilliefors has it): that of a test with parameters given beforehand would be far too large.

    Raises:
        StudyError: fewer than 20 times, one that is negative or not finite, or all alike.

    Sources: Akaike (1974); Cramér (1928), von Mises (1931); for rounded times Choulakian, Lockhart & Stephens (1994),
    Cramér-von Mises statistics for discrete distributions, Canadian J. of Statistics 22(1), 125-137; Stute,
    Gonzáles-Manteiga & Presedo-Quindimil (1993); intervals: Law (2015), section 6.5; Gentleman & Geyer (1994),
    Maximum likelihood for interval censored data, Biometrika 81(3), 618-623.
    """
    x = np.asarray(times, dtype=float)
    if len(x) < FEWEST:
        raise StudyError(f"{len(x)} times are too few for a distribution, expected at least {FEWEST}")
    if not np.all(np.isfinite(x) & (x >= 0)):
        raise StudyError("times that are negative or no numbers, expected numbers of at least 0")
    if x.min() == x.max():
        raise StudyError(f"all times are {x[0]:g}: write that number instead of a distribution")
    step = clock_step(x)
    found = []
    for name, family in families().items():
        if x.min() == 0 and not step and name not in {"exponential", "uniform"}:
            continue  # a time of 0 is impossible there
        likely = family.most_likely(x, step)
        aic = 2 * family.free + 2 * family.cost(likely, Counted.of(x, step))
        if math.isfinite(aic):
            found.append((family, likely, aic))
    found.sort(key=lambda item: item[2])
    family, likely, _ = found[0]
    rng = np.random.default_rng(0)
    some = x if len(x) <= TESTED else rng.choice(x, TESTED, replace=False)
    statistic, p_value = _tested(family, some, step, rng)
    candidates = tuple(Candidate(family.ours(*one), aic, family.frozen(one).cdf) for family, one, aic in found)
    return Fitted(x, candidates, statistic, p_value, step)


def fit_between(begun: NDArray[np.float64], ended: NDArray[np.float64]) -> Distribution:
    """The most likely of the exponential, gamma, lognormal and Weibull distributions for times seen now and then only.

    Args:
        begun: for each time the last instant at which it had not begun, and the first at which it had.
        ended: the last instant at which it was still running, and the first at which it was over (inf: not seen).

    Source: Turnbull (1976), The empirical distribution function with arbitrarily grouped, censored and truncated data,
    J. Royal Statistical Society B 38(3), 290-295.
    """
    counted = Counted.between(begun, ended)
    found = []
    for name, family in families().items():
        if name in BOUNDED:
            continue  # its ends would lie where the clock put them
        likely = family.likeliest(counted, family.guess(counted.times, 0.0))
        found.append((family.free + family.cost(likely, counted), name, family.ours(*likely)))
    return min(found)[2]


def _tested(family: Family, times: NDArray[np.float64], step: float, rng: np.random.Generator) -> tuple[float, float]:
    """Cramér and von Mises' statistic of a family, and the part of its samples that are as far from their best."""
    likely = family.most_likely(times, step)
    ours = _distance(family, likely, times, step)
    worse = 0
    for _ in range(SAMPLES):
        sample = family.frozen(likely).rvs(len(times), random_state=rng)
        sample = np.round(sample / step) * step if step else sample
        alike = sample.min() == sample.max()
        worse += not alike and _distance(family, family.most_likely(sample, step), sample, step) >= ours
    return ours, (worse + 1) / (SAMPLES + 1)


def _distance(family: Family, parameters: Parameters, times: NDArray[np.float64], step: float) -> float:
    """How far the times are from a distribution: Cramér and von Mises' statistic, by steps where they are rounded."""
    n = len(times)
    if not step:
        below = family.frozen(parameters).cdf(np.sort(times))
        return float(1 / (12 * n) + (((2 * np.arange(1, n + 1) - 1) / (2 * n) - below) ** 2).sum())
    marks = np.arange(times.min(), times.max() + 1.5 * step, step)
    below = family.frozen(parameters).cdf(marks + step / 2)
    seen = np.searchsorted(np.sort(times), marks + step / 2) / n
    return float(n * ((seen - below) ** 2 * np.diff(below, prepend=0.0)).sum())
