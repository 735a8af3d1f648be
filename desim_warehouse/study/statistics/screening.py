"""Which factor matters, from a table of runs: main effects, and each factor's share of the variance."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.checks import check_confidence

if TYPE_CHECKING:
    from collections.abc import Sequence

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
