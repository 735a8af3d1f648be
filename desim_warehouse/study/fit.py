"""Distribution fitting for measured times, for `desim fit` and `desim calibrate`.

Families are fitted by maximum likelihood, including to times that a clock has rounded, compared by Akaike's criterion,
and tested by the Cramér-von Mises test.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from desim_warehouse.errors import StudyError, did_you_mean, got, other_marks, reason
from desim_warehouse.values.arrays import Floats, Ints
from desim_warehouse.values.csv_rows import csv_rows
from desim_warehouse.values.distributions import (
    Distribution,
    ExponentialTime,
    GammaTime,
    LognormalTime,
    TriangularTime,
    UniformTime,
    WeibullTime,
)

Parameters: TypeAlias = tuple[float, ...]
"""Parameters of a distribution in the order of scipy."""
STEPS = (60.0, 30.0, 15.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
"""Steps to which clocks round, in seconds."""
COARSE = 0.05
"""Least clock step that matters, as a share of the standard deviation; smaller steps change no fit."""
DIGITS = 4
POINTS = 5
"""Number of quadrature points for an interval in which a time began."""
WEIGHTS = {1: np.ones(1), POINTS: np.polynomial.legendre.leggauss(POINTS)[1] / 2}
"""Weights of the intervals of a time, by their number."""
TINY = 1e-300
"""Replacement of 0 as a divisor."""
IMPOSSIBLE = 1e10
"""Negative log likelihood assigned to times that a distribution cannot have."""
FEWEST = 20
"""Fewest measured times for which a distribution is proposed."""
TESTED = 2000
"""Largest sample for the test; with more times, the clock's rounding makes it reject every smooth distribution."""
SAMPLES = 199
"""Samples of the proposed distribution to which the measured times are compared."""
BOUNDED = {"uniform", "triangular"}
"""Families with a largest time."""
LEVEL = 0.05
"""A p-value below this speaks against a distribution."""
MOST_PROBLEMS = 20
"""Largest number of problems of one file that are listed."""


class Counted(NamedTuple):
    """A sample of times: distinct times, how often each occurs, and the intervals in which they lie (None: exact).

    `ends`: two tables, of lower and of upper ends, with a row for each time and a column for each of its equally
    likely intervals.
    """

    times: Floats
    often: Ints
    ends: Floats | None

    @classmethod
    def of(cls, times: Floats, step: float) -> Counted:
        """Count the times of a sample that a clock has rounded to a step (0: not rounded)."""
        each, often = np.unique(times, return_counts=True)
        return cls(each, often, np.stack([each - step / 2, each + step / 2])[:, :, None] if step else None)

    @classmethod
    def between(cls, begun: Floats, ended: Floats) -> Counted:
        """Count times whose begin and end each lie between two known instants (interval-censored times).

        Both arguments are arrays with a row of two instants for each time. The begin is uniformly distributed between
        its two instants (Gauss-Legendre quadrature). The end is inf (open) if the time was still running.
        """
        points, _ = np.polynomial.legendre.leggauss(POINTS)
        begin = begun[:, :1] + (points + 1) / 2 * (begun[:, 1:] - begun[:, :1])
        ends = np.maximum(np.stack([ended[:, :1] - begin, ended[:, 1:] - begin]), 0.0)
        middle = ends[0].mean(axis=1) + np.where(np.isinf(ended[:, 1]), 0.0, (ended[:, 1] - ended[:, 0]) / 2)
        return cls(middle, np.ones(len(begun), np.int64), ends)


@dataclass(frozen=True)
class Family:
    """A family of distributions: scipy's, the number of free parameters, and the conversion to ours.

    `logs` and `below`: log density and distribution function of standardised times; scipy's own spend 20 times as long
    on checking arguments as on computing. `free` is one more for a family with a largest time, because an end that may
    lie on the largest measured time flatters the fit. `guess`: function for starting values of the free parameters, on
    an unbounded scale. `made`: function that converts these to scipy's parameters.
    """

    scipy: Any
    logs: Callable[..., Any]
    below: Callable[..., Any]
    free: int
    ours: Callable[..., Distribution]
    guess: Callable[[Floats, float], list[float]]
    made: Callable[[Floats], Parameters]

    def frozen(self, parameters: Parameters) -> Any:
        """Scipy's distribution with these parameters."""
        return self.scipy(*parameters)

    def cost(self, parameters: Parameters, counted: Counted) -> float:
        """Return the negative log likelihood of the times; of rounded times by the intervals in which they lie."""
        times, often, ends = counted
        *shape, least, scale = parameters
        with np.errstate(divide="ignore"):
            if ends is None:
                logs = self.logs((times - least) / scale, *shape) - math.log(scale)
            else:
                below = self.below(np.maximum((ends - least) / scale, 0.0), *shape)
                logs = np.log((below[1] - below[0]) @ WEIGHTS[ends.shape[2]])
        return float(-(often * logs).sum())

    def most_likely(self, times: Floats, step: float) -> Parameters:
        """Return the maximum likelihood parameters of times that are rounded to a step."""
        if not step and self.scipy.name != "triang":
            fixed = {} if self.scipy.name == "uniform" else {"floc": 0.0}
            return tuple(map(float, self.scipy.fit(times, **fixed)))
        return self.likeliest(Counted.of(times, step), self.guess(times, step))

    def likeliest(self, counted: Counted, guess: list[float]) -> Parameters:
        """Return the maximum likelihood parameters of interval-censored times, from a first guess."""
        from scipy.optimize import minimize

        def cost(free: Floats) -> float:
            with np.errstate(over="ignore", invalid="ignore"):
                minus_log = self.cost(self.made(free), counted)
            return minus_log if math.isfinite(minus_log) else IMPOSSIBLE

        best = minimize(cost, guess, method="Nelder-Mead", options={"maxiter": 600, "fatol": 1e-4})
        return self.made(best.x)


def clock_step(times: Floats) -> float:
    """Return the step to which times were rounded, if it matters beside their spread; else 0."""
    for step in STEPS:
        if np.allclose(times / step, np.round(times / step), rtol=0.0, atol=1e-6):
            return step if step > COARSE * times.std() else 0.0
    return 0.0


# A list of families, long as it is.
def families() -> dict[str, Family]:
    """Return the families of distributions that are proposed, by our names."""
    from scipy import stats
    from scipy.special import gammainc, gammaln, ndtr, xlogy

    return {
        "exponential": Family(
            stats.expon,
            lambda x: -x,
            lambda x: -np.expm1(-x),
            1,
            lambda _, mean: ExponentialTime(exponential=_short(mean)),
            lambda times, _: [math.log(_moments(times)[0])],
            lambda free: (0.0, math.exp(min(float(free[0]), 30))),
        ),
        "gamma": Family(
            stats.gamma,
            lambda x, a: xlogy(a - 1, x) - x - gammaln(a),
            lambda x, a: gammainc(a, x),
            2,
            lambda a, _, scale: _by_mean(GammaTime, a * scale, a**-0.5),
            _gamma_guess,
            _from_logs,
        ),
        "lognormal": Family(
            stats.lognorm,
            lambda x, s: -((np.log(x) / s) ** 2) / 2 - np.log(s * x) - math.log(2 * math.pi) / 2,
            lambda x, s: ndtr(np.log(x) / s),
            2,
            _lognormal,
            _lognormal_guess,
            _from_logs,
        ),
        "weibull": Family(
            stats.weibull_min,
            lambda x, c: math.log(c) + xlogy(c - 1, x) - x**c,
            lambda x, c: -np.expm1(-(x**c)),
            2,
            _weibull,
            _weibull_guess,
            _from_logs,
        ),
        "uniform": Family(
            stats.uniform,
            lambda x: np.where((x >= 0) & (x <= 1), 0.0, -np.inf),
            lambda x: np.minimum(x, 1.0),
            3,
            lambda least, width: UniformTime(uniform=(_short(least), _short(least + width))),
            _ends,
            lambda free: (max(float(free[0]), 0.0), max(float(free[1] - max(free[0], 0.0)), 1e-9)),
        ),
        "triangular": Family(stats.triang, _triangle_logs, _triangle_below, 4, _triangular, _corners, _triangle),
    }


def _moments(times: Floats) -> tuple[float, float]:
    """Return mean and coefficient of variation of times."""
    mean = float(times.mean())
    return mean, max(float(times.std()) / mean, 0.01)


def _logs(*values: float) -> list[float]:
    return [math.log(value) for value in values]


def _gamma_guess(times: Floats, _: float) -> list[float]:
    mean, cv = _moments(times)
    return _logs(cv**-2, mean * cv**2)


def _lognormal_guess(times: Floats, _: float) -> list[float]:
    mean, cv = _moments(times)
    square = math.log1p(cv**2)
    return _logs(math.sqrt(square), mean * math.exp(-square / 2))


def _weibull_guess(times: Floats, _: float) -> list[float]:
    mean, cv = _moments(times)
    return _logs(cv**-1.086, mean / math.gamma(1 + cv**1.086))


def _from_logs(free: Floats) -> Parameters:
    """Return shape and scale from their logarithms, which have no limits."""
    first, second = np.exp(np.clip(free, -30, 30))
    return float(first), 0.0, float(second)


def _ends(times: Floats, step: float) -> list[float]:
    """Return a guess of the ends of a uniform distribution: a little beyond the smallest and the largest time."""
    return [float(times.min()) - step / 4, float(times.max()) + step / 4]


def _corners(times: Floats, step: float) -> list[float]:
    """Return a guess of the corners of a triangular distribution, from the extremes and the mean."""
    beyond = max(step / 2, 0.05 * float(np.ptp(times)))
    least, most = float(times.min()) - beyond, float(times.max()) + beyond
    usual = min(max(3 * float(times.mean()) - least - most, least + beyond), most - beyond)
    return [least, usual, most]


def _triangle_logs(x: Floats, usual: float) -> Floats:
    up, down = x / max(usual, TINY), (1 - x) / max(1 - usual, TINY)
    return np.where((x >= 0) & (x <= 1), np.log(np.clip(2 * np.minimum(up, down), 0.0, 2.0)), -np.inf)


def _triangle_below(x: Floats, usual: float) -> Floats:
    x = np.minimum(x, 1.0)
    return np.where(x < usual, x**2 / max(usual, TINY), 1 - (1 - x) ** 2 / max(1 - usual, TINY))


def _triangle(free: Floats) -> Parameters:
    """Return scipy's mode, least and width from the corners of a triangle."""
    least, usual, most = float(max(free[0], 0.0)), float(free[1]), float(free[2])
    width = max(most - least, 1e-9)
    return min(max((usual - least) / width, 0.0), 1.0), least, width


def _lognormal(sigma: float, _: float, scale: float) -> Distribution:
    return _by_mean(LognormalTime, scale * math.exp(sigma**2 / 2), math.sqrt(math.expm1(sigma**2)))


def _weibull(shape: float, _: float, scale: float) -> Distribution:
    return WeibullTime.model_validate({"weibull": {"shape": _short(shape), "scale": _short(scale)}})


def _triangular(usual: float, least: float, width: float) -> Distribution:
    corners = least, least + usual * width, least + width
    return TriangularTime.model_validate({"triangular": [_short(corner) for corner in corners]})


def _by_mean(kind: type[Distribution], mean: float, cv: float) -> Distribution:
    name = next(iter(kind.model_fields))
    return kind.model_validate({name: {"mean": _short(mean), "cv": _short(cv)}})


def _short(value: float) -> float:
    """Round a parameter to the digits that are known, as it is written into a model."""
    return float(f"{value:.{DIGITS}g}")


@dataclass(frozen=True)
class Candidate:
    """A family with its most likely parameters, and Akaike's criterion: the less, the better.

    `share_below`: distribution function.
    """

    distribution: Distribution
    aic: float
    share_below: Callable[[Floats], Floats]


@dataclass(frozen=True)
class Fitted:
    """Distributions for measured times, best first.

    Attributes:
        times: the measured times.
        candidates: the families fitted, ordered by Akaike's criterion, best first.
        statistic: Cramér-von Mises statistic of the best distribution.
        p_value: share of samples of the best distribution that lie as far from the distribution fitted to them.
        step: step to which the times were rounded; 0 if they were not.
    """

    times: Floats
    candidates: tuple[Candidate, ...]
    statistic: float
    p_value: float
    step: float = 0.0

    @property
    def best(self) -> Distribution:
        """The distribution that fits best, in the unit of the times."""
        return self.candidates[0].distribution

    @property
    def fits(self) -> bool:
        """Whether the goodness-of-fit test does not reject the best distribution."""
        return self.p_value >= LEVEL


def fit(times: Sequence[float] | Floats) -> Fitted:
    """Fit exponential, gamma, lognormal, Weibull, uniform and triangular distributions to measured times.

    Times that a clock has rounded, such as to whole seconds or tenths, are treated as intervals of half a step below to
    half a step above. Their likelihood is the probability of these intervals, which is equivalent to the density if
    steps are small compared with the spread.

    The p-value is computed by Monte Carlo: as in Lilliefors' test, parameters are fitted anew to every sample, which is
    rounded as the times were. The p-value of a test with known parameters would be far too large.

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
    fitted = []
    for name, family in families().items():
        if x.min() == 0 and not step and name not in {"exponential", "uniform"}:
            continue  # a time of 0 is impossible there
        likely = family.most_likely(x, step)
        aic = 2 * family.free + 2 * family.cost(likely, Counted.of(x, step))
        if math.isfinite(aic):
            fitted.append((family, likely, aic))
    fitted.sort(key=lambda item: item[2])
    family, likely, _ = fitted[0]
    rng = np.random.default_rng(0)
    some = x if len(x) <= TESTED else rng.choice(x, TESTED, replace=False)
    statistic, p_value = _tested(family, some, step, rng)
    candidates = tuple(
        Candidate(family.ours(*parameters), aic, family.frozen(parameters).cdf) for family, parameters, aic in fitted
    )
    return Fitted(x, candidates, statistic, p_value, step)


def fit_between(begun: Floats, ended: Floats) -> Distribution:
    """Fit exponential, gamma, lognormal and Weibull distributions to interval-censored times; return the most likely.

    Args:
        begun: for each time the last instant at which it had not begun, and the first at which it had.
        ended: the last instant at which it was still running, and the first at which it was over (inf: not seen).

    Source: Turnbull (1976), The empirical distribution function with arbitrarily grouped, censored and truncated data,
    J. Royal Statistical Society B 38(3), 290-295.
    """
    counted = Counted.between(begun, ended)
    fitted = []
    for name, family in families().items():
        if name in BOUNDED:
            continue  # its ends would lie where the clock put them
        likely = family.likeliest(counted, family.guess(counted.times, 0.0))
        fitted.append((family.free + family.cost(likely, counted), name, family.ours(*likely)))
    return min(fitted)[2]


def _tested(family: Family, times: Floats, step: float, rng: np.random.Generator) -> tuple[float, float]:
    """Return Cramér and von Mises' statistic of a family, and the p-value: the share of samples that fit no better."""
    likely = family.most_likely(times, step)
    ours = _distance(family, likely, times, step)
    worse = 0
    for _ in range(SAMPLES):
        sample = family.frozen(likely).rvs(len(times), random_state=rng)
        sample = np.round(sample / step) * step if step else sample
        alike = sample.min() == sample.max()
        worse += not alike and _distance(family, family.most_likely(sample, step), sample, step) >= ours
    return ours, (worse + 1) / (SAMPLES + 1)


def _distance(family: Family, parameters: Parameters, times: Floats, step: float) -> float:
    """Return Cramér and von Mises' distance of times from a distribution, by steps where times are rounded."""
    n = len(times)
    if not step:
        below = family.frozen(parameters).cdf(np.sort(times))
        return float(1 / (12 * n) + (((2 * np.arange(1, n + 1) - 1) / (2 * n) - below) ** 2).sum())
    marks = np.arange(times.min(), times.max() + 1.5 * step, step)
    below = family.frozen(parameters).cdf(marks + step / 2)
    seen = np.searchsorted(np.sort(times), marks + step / 2) / n
    return float(n * ((seen - below) ** 2 * np.diff(below, prepend=0.0)).sum())


def read_times(path: Path, column: str) -> list[float]:
    """Read the times in a column of a CSV file, without empty cells.

    Raises:
        StudyError: no such file or column, or cells that are no times: the first 20 of them, by row and column.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as lines:
            rows = csv_rows(lines, skip_spaces=True)
            names = next(rows, (1, []))[1]
            if column not in names:
                hint = other_marks(names) or did_you_mean(column, names)
                have = f" (it has {', '.join(names)}){hint}" if any(names) else ", as the file is empty"
                raise StudyError(f"{path}: no column '{column}'{have}")
            rank = names.index(column)
            cells = [(line, row[rank]) for line, row in rows if row[rank:] and row[rank]]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise StudyError(f"{path}: cannot be read ({reason(error)}), expected CSV UTF-8") from error
    times, problems = [], []
    for line, cell in cells:
        try:
            time = float(cell)
        except ValueError:
            time = math.nan
        if not 0 <= time < math.inf:
            problems.append(f"{path}:{line}: {column}: not a time (got {got(cell)}), expected a number of at least 0")
        times.append(time)
    if len(problems) > MOST_PROBLEMS:
        problems[MOST_PROBLEMS:] = [f"{path}: and {len(problems) - MOST_PROBLEMS} more"]
    if problems:
        raise StudyError("\n".join(problems))
    return times
