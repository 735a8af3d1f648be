"""Which factor matters, from a table of runs: main effects, and each factor's share of the variance.

Sobol indices of a screening study: each factor's share of the variance, alone and with interactions.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.checks import check_confidence, finite, is_constant

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray


HALVES = 100  # random halves of the points, for intervals
PER_BIN = 5  # points in a bin of a continuous factor, for shares
LEVELS = 12  # a numeric factor with more values than this is taken as continuous and cut into bins


@dataclass(frozen=True)
class MainEffect:
    """What one factor does on average: level -> mean of the indicator there minus the grand mean.

    `swing` is the largest minus the smallest effect. A continuous factor's levels are bins, shown as
    intervals.
    """

    factor: str
    effects: dict[Any, float]
    runs: dict[Any, int]
    swing: float


@dataclass(frozen=True)
class MainEffects:
    """All factors, the largest swing first.

    `left_out` counts rows without a value (failed runs).
    """

    indicator: str
    grand_mean: float
    factors: tuple[MainEffect, ...]
    left_out: int


@dataclass(frozen=True)
class FirstOrder:
    """Share of the indicator's variance that each factor explains alone, largest first.

    `intervals` says how sure the shares of scattered points are, each on its own. It is empty for a full grid, whose
    shares are exact. `rest`, 1 minus the sum of the shares, is interactions between factors, and noise unless averaged
    out. nan if the indicator does not vary. `corrected` says that the estimator subtracted what chance alone would
    explain. `warning` names neighbours in the order that cannot be told apart, if any.
    """

    indicator: str
    shares: dict[str, float]
    intervals: dict[str, tuple[float, float]]
    rest: float
    corrected: bool
    left_out: int
    warning: str = ""

    def text(self, factor: str) -> str:
        """A share in per cent, with its interval if it has one."""
        share, ends = self.shares[factor], self.intervals.get(factor)
        return f"{100 * share:.1f} %" + (f" ({100 * ends[0]:.0f} to {100 * ends[1]:.0f})" if ends else "")


def main_effects(table: pd.DataFrame, factors: Sequence[str], indicator: str, bins: int = 5) -> MainEffects:
    """The mean of an indicator at each level of each factor, minus the grand mean over all runs.

    Args:
        table: a row per run, columns for factors and indicators. Rows with a missing indicator are left out.
        factors: columns to look at.
        indicator: column with the output.
        bins: a numeric factor with more than 12 values is cut into this number of bins of equally many runs.

    Raises:
        StudyError: an unknown or missing column, or no row left.

    Source: Law (2015), section 12.2 (factorial designs), for any number of levels.
    Assumes: the other factors are spread alike over the levels (grid, Latin hypercube or Sobol points). On
    paired lists a factor's effect contains those of the factors varied with it.
    """
    rows, left_out = _clean(table, factors, indicator)
    grand_mean = float(rows[indicator].mean())
    found = []
    for factor in factors:
        groups = rows.groupby(_levels(rows[factor], bins), observed=True, sort=True, dropna=False)[indicator]
        effects = {level: float(mean) - grand_mean for level, mean in groups.mean().items()}
        runs = {level: int(count) for level, count in groups.size().items()}
        found.append(MainEffect(factor, effects, runs, max(effects.values()) - min(effects.values())))
    found.sort(key=lambda effect: -effect.swing)  # stable: equal swings stay in the order given
    return MainEffects(indicator, grand_mean, tuple(found), left_out)


def first_order(
    table: pd.DataFrame,
    factors: Sequence[str],
    indicator: str,
    *,
    bins: int | None = None,
    average: bool = True,
    confidence: float = 0.95,
) -> FirstOrder:
    """First-order Sobol indices from the given runs, from any design.

    Args:
        table: a row per run. Rows with a missing indicator are left out.
        factors: columns that were varied, each independently of the others.
        indicator: column with the output.
        bins: of a numeric factor with more than 12 values; default: of five points each, at least 2. Fewer and
            wider ones lose what happens inside them, which misranks factors with a wavy effect.
        average: replications of the same design point are averaged first, which takes most of the noise out.
        confidence: of the intervals, and that neighbours said to differ do, each on its own.

    Raises:
        StudyError: an unknown or missing column, or no row left.

    Source: Var(E[Y | factor]) / Var(Y) with the factor in classes: the correlation ratio η² (Plischke,
    Borgonovo & Smith 2013, Global sensitivity measures from given data, EJOR 226(3), 536-550). On a full grid
    with equally many runs this is exact. Elsewhere chance differences between the classes are subtracted, as
    in Kelley's ε² (1935), and intervals are normal ones with the delete-half jackknife's error (Shao & Wu 1989,
    A general theory for jackknife variance estimation, Annals of Statistics 17(3), 1176-1197).
    Assumes: factors independent of one another. Total indices need another design: see `saltelli_design`.
    """
    check_confidence(confidence)
    rows, left_out = _clean(table, factors, indicator)
    if average:
        rows = rows.groupby(list(factors), observed=True, sort=True, dropna=False)[indicator].mean().reset_index()
    sizes = rows.groupby(list(factors), observed=True, dropna=False).size()
    cells = math.prod(int(rows[f].nunique(dropna=False)) for f in factors)
    full_grid = len(sizes) == cells and sizes.min() == sizes.max()
    y = rows[indicator].to_numpy(dtype=float)
    shares = {f: _share(y, _classes(rows[f], bins), corrected=not full_grid) for f in factors}
    ranked = dict(sorted(shares.items(), key=lambda item: -item[1]))
    rest = 1.0 - sum(shares.values())
    if full_grid or math.isnan(rest):
        return FirstOrder(indicator, ranked, {}, rest, not full_grid, left_out)
    errors = _errors(y, [rows[factor] for factor in ranked], bins)
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    ends = {
        name: (max(0.0, share - z * error), min(1.0, share + z * error))
        for (name, share), error in zip(ranked.items(), np.sqrt(np.diag(errors)), strict=True)
    }
    doubtful = [
        f"{a} and {b}"
        for i, (a, b) in enumerate(pairwise(ranked))
        if ranked[a] - ranked[b] <= z * math.sqrt(errors[i, i] + errors[i + 1, i + 1] - 2 * errors[i, i + 1])
    ]
    warning = f"{len(rows)} designs cannot tell which of {', of '.join(doubtful)} matters more" if doubtful else ""
    return FirstOrder(indicator, ranked, ends, rest, True, left_out, warning)


def _errors(y: NDArray[np.float64], columns: Sequence[pd.Series[Any]], bins: int | None) -> NDArray[np.float64]:
    """Covariances of the shares, shape (factors, factors), from how they differ between random halves of the points."""
    rng = np.random.default_rng(0)
    halves = []
    for _ in range(HALVES):
        half = rng.choice(y.size, y.size // 2, replace=False)
        halves.append([_share(y[half], _classes(column.iloc[half], bins), corrected=True) for column in columns])
    return np.atleast_2d(np.cov(np.nan_to_num(halves), rowvar=False))


def _clean(table: pd.DataFrame, factors: Sequence[str], indicator: str) -> tuple[pd.DataFrame, int]:
    """The rows that have the indicator, and how many have not."""
    if not factors:
        raise StudyError("no factors: nothing was varied")
    missing = [name for name in (*factors, indicator) if name not in table.columns]
    if missing:
        names = ", ".join(map(str, table.columns))
        raise StudyError(f"columns {missing}: expected factors and an indicator out of {names}")
    rows = table.loc[table[indicator].notna(), [*factors, indicator]]
    if rows.empty:
        raise StudyError(f"indicator {indicator!r}: no row has a value")
    return rows, len(table) - len(rows)


def _levels(column: pd.Series[Any], bins: int) -> pd.Series[Any]:
    """The factor's own levels, or for a continuous one its bins of equally many runs."""
    import pandas as pd

    if pd.api.types.is_numeric_dtype(column) and column.nunique() > LEVELS:
        return pd.qcut(column, bins, duplicates="drop")
    return column


def _classes(column: pd.Series[Any], bins: int | None) -> NDArray[np.int64]:
    """The number of each value's class: a level of the factor, or a bin of equally many points."""
    import pandas as pd

    if pd.api.types.is_numeric_dtype(column) and column.nunique() > LEVELS:
        x = column.to_numpy(dtype=float)
        edges = np.quantile(x, np.linspace(0.0, 1.0, (bins or max(2, x.size // PER_BIN)) + 1))
        return np.asarray(np.digitize(x, np.unique(edges)[1:-1], right=True))
    return pd.factorize(column, use_na_sentinel=False)[0]


def _share(y: NDArray[np.float64], classes: NDArray[np.int64], *, corrected: bool) -> float:
    """η², or with the correction ε²: variance between the classes over variance in all, or nan."""
    total = float(((y - y.mean()) ** 2).sum())
    if total == 0.0:
        return math.nan
    sizes = np.bincount(classes)
    means = np.bincount(classes, y) / np.maximum(sizes, 1)
    inside = float(((y - means[classes]) ** 2).sum())
    between = total - inside
    n, k = y.size, np.count_nonzero(sizes)
    if corrected and n > k:
        between -= (k - 1) * inside / (n - k)
    return max(between, 0.0) / total


@dataclass(frozen=True)
class Between:
    """A numeric factor, uniform from `low` to `high`; `integer`: whole numbers, both ends included."""

    low: float
    high: float
    integer: bool = False

    def __post_init__(self) -> None:
        whole = not self.integer or (float(self.low).is_integer() and float(self.high).is_integer())
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high and whole):
            raise StudyError(f"{self}: expected low < high, whole numbers for an integer factor")

    def at(self, u: float) -> float:
        """The value at the share `u` (0 <= u < 1) of the range."""
        if self.integer:
            return int(self.low) + int(u * (self.high - self.low + 1))
        return self.low + u * (self.high - self.low)


@dataclass(frozen=True)
class SaltelliDesign:
    """The n · (d + 2) design points to simulate, each a dict factor -> value, for d factors.

    First n points of A, then n of B, then for each factor in turn the n of A with that factor from B. The
    values go to `saltelli_indices` in this order.
    """

    factors: tuple[str, ...]
    n: int
    points: tuple[dict[str, Any], ...]


@dataclass(frozen=True)
class SobolIndices:
    """Shares of the indicator's variance by factor, with bootstrap intervals (`confidence`, each on its own).

    `first`: what the factor explains alone. `total`: with all interactions it takes part in. Near 0 it means that the
    factor can be left out. All nan, and `variance` 0, where the indicator does not vary.
    """

    first: dict[str, float]
    total: dict[str, float]
    first_interval: dict[str, tuple[float, float]]
    total_interval: dict[str, tuple[float, float]]
    variance: float
    confidence: float


def saltelli_design(factors: Mapping[str, Between | Sequence[Any]], n: int = 128, seed: int = 0) -> SaltelliDesign:
    """The design points from which `saltelli_indices` computes the indices.

    Args:
        factors: at least two, each a range `Between(low, high)` or a sequence of levels, all equally likely.
        n: base sample, a power of 2: n · (d + 2) points for d factors.
        seed: of the scrambling: the same seed, the same points.

    Raises:
        StudyError: fewer than two factors, a factor without levels, or n not a power of 2.

    Source: Saltelli et al. (2010), Variance based sensitivity analysis of model output, Computer Physics
    Communications 181(2), 259-270, section 5: A and B are halves of one 2d-dimensional Sobol sequence.
    """
    from scipy.stats import qmc

    if len(factors) < 2:  # noqa: PLR2004
        raise StudyError(f"Sobol indices of {len(factors)} factors: expected at least two to share the variance")
    if n < 2 or n & (n - 1):  # noqa: PLR2004
        raise StudyError(f"base sample {n}: expected a power of 2, as 64, 128 or 256")
    d = len(factors)
    points = qmc.Sobol(2 * d, rng=np.random.default_rng(seed)).random(n)
    a, b = points[:, :d], points[:, d:]
    blocks = [a, b]
    for i in range(d):
        mixed = a.copy()
        mixed[:, i] = b[:, i]
        blocks.append(mixed)
    rows = np.vstack(blocks).tolist()
    chosen = tuple(
        {name: _level(name, spec, u) for (name, spec), u in zip(factors.items(), row, strict=True)} for row in rows
    )
    return SaltelliDesign(tuple(factors), n, chosen)


def saltelli_indices(
    design: SaltelliDesign,
    values: Sequence[float] | NDArray[np.float64],
    confidence: float = 0.95,
    resamples: int = 500,
    seed: int = 0,
) -> SobolIndices:
    """First-order and total Sobol indices of an indicator from its values at the design's points.

    Args:
        design: from `saltelli_design`.
        values: the indicator at each point, in the design's order, shape (n · (d + 2),).
        confidence: of the bootstrap intervals.
        resamples: bootstrap samples of the n base points.
        seed: draws the bootstrap samples.

    Raises:
        StudyError: the wrong number of values, or one that is not finite (a failed run leaves a gap:
            repeat it).

    Source: Saltelli et al. (2010), as `scipy.stats.sobol_indices` computes them; percentile bootstrap over
    base points.
    Assumes: factors independent and uniform over what the design says. Noise: with common random numbers the
    indices are those of one noise path; average several replications of each point, or noise counts as
    interaction and inflates the totals. Estimates may fall a little outside 0..1.
    """
    check_confidence(confidence)
    y = finite(values, "indicator")
    d, n = len(design.factors), design.n
    if y.size != n * (d + 2):
        raise StudyError(f"Sobol indices: {y.size} values, expected n · (d + 2) = {n * (d + 2)} of the design")
    if is_constant(y):
        nothing = dict.fromkeys(design.factors, math.nan)
        none = dict.fromkeys(design.factors, (math.nan, math.nan))
        return SobolIndices(nothing, nothing, none, none, 0.0, confidence)
    f = y.reshape(d + 2, n)
    rng = np.random.default_rng(seed)
    draws = np.array([_indices(f[:, rng.integers(0, n, n)]) for _ in range(resamples)])
    ends = np.quantile(draws, [0.5 - confidence / 2, 0.5 + confidence / 2], axis=0)  # shape (2, 2, d)
    first, total = (dict(zip(design.factors, row, strict=True)) for row in _indices(f).tolist())
    first_ends, total_ends = (
        {name: (low, high) for name, low, high in zip(design.factors, *ends[:, which].tolist(), strict=True)}
        for which in (0, 1)
    )
    return SobolIndices(first, total, first_ends, total_ends, float(f[:2].var()), confidence)


def _level(name: str, spec: Between | Sequence[Any], u: float) -> Any:
    """The factor's value at a share of its range or levels."""
    if isinstance(spec, Between):
        return spec.at(u)
    if not spec:
        raise StudyError(f"factor {name!r} has no levels")
    return spec[int(u * len(spec))]


def _indices(f: NDArray[np.float64]) -> NDArray[np.float64]:
    """First and total indices, shape (2, d), from values of shape (d + 2, n): A, B, then the mixed."""
    from scipy.stats import sobol_indices

    result = sobol_indices(func={"f_A": f[:1], "f_B": f[1:2], "f_AB": f[2:, None, :]}, n=f.shape[1])
    return np.array([result.first_order, result.total_order])
