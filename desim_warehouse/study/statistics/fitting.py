"""Which distribution do measured times follow? Maximum likelihood, Akaike's criterion, Cramér and von Mises' test."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.values.distributions import (
    Distribution,
    ExponentialTime,
    GammaTime,
    LognormalTime,
    UniformTime,
    WeibullTime,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

FEWEST = 20
"""Measured times from which on a distribution is proposed."""
TESTED = 2000
"""Times that the test takes at most: with more, every smooth curve is refuted by the clock that measured them."""
SAMPLES = 199
"""Samples of the proposed distribution to which the measured times are compared."""
LEVEL = 0.05
"""A p-value below this speaks against a distribution."""
DIGITS = 4


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
    """

    times: NDArray[np.float64]
    candidates: tuple[Candidate, ...]
    statistic: float
    p_value: float

    @property
    def best(self) -> Distribution:
        """The distribution that fits best."""
        return self.candidates[0].distribution

    @property
    def fits(self) -> bool:
        """Whether nothing speaks against the best one."""
        return self.p_value >= LEVEL


def fit(times: Sequence[float] | NDArray[np.float64]) -> Fitted:
    """Fit exponential, gamma, lognormal, Weibull and uniform distributions to measured times.

    The p-value is Monte Carlo with the parameters fitted anew to every sample (as Lilliefors has it): that of a test
    with parameters given beforehand would be far too large.

    Raises:
        StudyError: fewer than 20 times, one that is negative or not finite, or all alike.

    Sources: Akaike (1974); Cramér (1928), von Mises (1931); Stute, Gonzáles-Manteiga & Presedo-Quindimil (1993).
    """
    from scipy import stats

    x = np.asarray(times, dtype=float)
    if len(x) < FEWEST:
        raise StudyError(f"{len(x)} times are too few for a distribution, expected at least {FEWEST}")
    if not np.all(np.isfinite(x) & (x >= 0)):
        raise StudyError("times that are negative or no numbers, expected numbers of at least 0")
    if x.min() == x.max():
        raise StudyError(f"all times are {x[0]:g}: write that number instead of a distribution")
    found = []
    for name, (family, known, ours) in _families().items():
        if x.min() == 0 and name not in {"exponential", "uniform"}:
            continue  # a time of 0 is impossible there
        parameters = family.fit(x, **{f"f{key}": value for key, value in known.items()})
        aic = 2 * (len(parameters) - len(known)) - 2 * float(family.logpdf(x, *parameters).sum())
        if math.isfinite(aic):
            found.append((name, Candidate(ours(*parameters), aic, family(*parameters).cdf)))
    found.sort(key=lambda item: item[1].aic)
    family, known, _ = _families()[found[0][0]]
    some = x if len(x) <= TESTED else np.random.default_rng(0).choice(x, TESTED, replace=False)
    test = stats.goodness_of_fit(
        family, some, known_params=known, statistic="cvm", n_mc_samples=SAMPLES, rng=np.random.default_rng(0)
    )
    return Fitted(x, tuple(one for _, one in found), float(test.statistic), float(test.pvalue))


Family = tuple["Any", dict[str, float], "Callable[..., Distribution]"]


def _families() -> dict[str, Family]:
    """The distribution of scipy, what of it is not fitted, and ours from scipy's parameters."""
    from scipy import stats

    from_zero = {"loc": 0.0}
    return {
        "exponential": (stats.expon, from_zero, lambda _, mean: ExponentialTime(exponential=_short(mean))),
        "gamma": (stats.gamma, from_zero, lambda a, _, scale: _by_mean(GammaTime, a * scale, a**-0.5)),
        "lognormal": (stats.lognorm, from_zero, _lognormal),
        "weibull": (
            stats.weibull_min,
            from_zero,
            lambda c, _, scale: WeibullTime.model_validate({"weibull": {"shape": _short(c), "scale": _short(scale)}}),
        ),
        "uniform": (stats.uniform, {}, lambda least, width: UniformTime(uniform=(least, least + width))),
    }


def _lognormal(sigma: float, _: float, scale: float) -> Distribution:
    return _by_mean(LognormalTime, scale * math.exp(sigma**2 / 2), math.sqrt(math.expm1(sigma**2)))


def _by_mean(kind: type[Distribution], mean: float, cv: float) -> Distribution:
    name = next(iter(kind.model_fields))
    return kind.model_validate({name: {"mean": _short(mean), "cv": _short(cv)}})


def _short(value: float) -> float:
    """A parameter as it is written into a model: no more digits than are known."""
    return float(f"{value:.{DIGITS}g}")
