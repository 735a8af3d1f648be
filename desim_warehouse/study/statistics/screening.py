"""Which factor matters, from a table of runs: main effects, and each factor's share of the variance."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import StudyError

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

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
    """All factors, the largest swing first; `left_out` counts rows without a value (failed runs)."""

    indicator: str
    grand_mean: float
    factors: tuple[MainEffect, ...]
    left_out: int


@dataclass(frozen=True)
class FirstOrder:
    """Share of the indicator's variance that each factor explains alone, largest first.

    `rest`, 1 minus their sum, is interactions between factors, and noise unless averaged out. nan if the
    indicator does not vary. `corrected` says that the estimator subtracted what chance alone would explain.
    """

    indicator: str
    shares: dict[str, float]
    rest: float
    corrected: bool
    left_out: int


def main_effects(table: pd.DataFrame, factors: Sequence[str], indicator: str, bins: int = 5) -> MainEffects:
    """The mean of an indicator at each level of each factor, minus the grand mean over all runs.

    Args:
        table: a row per run, columns for factors and indicators; rows with a missing indicator are left out.
        factors: columns to look at.
        indicator: column with the output.
        bins: a numeric factor with more than 12 values is cut into so many bins of equally many runs.

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
) -> FirstOrder:
    """First-order Sobol indices from the runs at hand, whatever design they came from.

    Args:
        table: a row per run; rows with a missing indicator are left out.
        factors: columns that were varied, each independently of the others.
        indicator: column with the output.
        bins: of a numeric factor with more than 12 values; default ½√runs, at least 2.
        average: replications of the same design point are averaged first, which takes most of the noise out.

    Raises:
        StudyError: an unknown or missing column, or no row left.

    Source: Var(E[Y | factor]) / Var(Y) with the factor in classes: the correlation ratio η² (Plischke,
    Borgonovo & Smith 2013, Global sensitivity measures from given data, EJOR 226(3), 536-550). On a full grid
    with equally many runs this is exact. Elsewhere chance differences between the classes are subtracted, as
    in Kelley's ε² (1935).
    Assumes: factors independent of one another. Total indices cannot be had this way: see `saltelli_design`.
    """
    rows, left_out = _clean(table, factors, indicator)
    if average:
        rows = rows.groupby(list(factors), observed=True, sort=True, dropna=False)[indicator].mean().reset_index()
    sizes = rows.groupby(list(factors), observed=True, dropna=False).size()
    cells = math.prod(int(rows[f].nunique(dropna=False)) for f in factors)
    full_grid = len(sizes) == cells and sizes.min() == sizes.max()
    cut = bins or max(2, round(math.sqrt(len(rows)) / 2))
    shares = {f: _share(rows[indicator], _levels(rows[f], cut), corrected=not full_grid) for f in factors}
    ranked = dict(sorted(shares.items(), key=lambda item: -item[1]))
    return FirstOrder(indicator, ranked, 1.0 - sum(shares.values()), not full_grid, left_out)


def _clean(table: pd.DataFrame, factors: Sequence[str], indicator: str) -> tuple[pd.DataFrame, int]:
    """The rows that have the indicator, and how many have not."""
    if not factors:
        raise StudyError("no factors: nothing was varied, so nothing can matter")
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


def _share(y: pd.Series[Any], levels: pd.Series[Any], corrected: bool) -> float:
    """η², or with the correction ε²: variance between the levels over variance in all, or nan."""
    total = float(((y - y.mean()) ** 2).sum())
    if total == 0.0:
        return math.nan
    groups = y.groupby(levels, observed=True, dropna=False)
    inside = float(((y - groups.transform("mean")) ** 2).sum())
    between = total - inside
    n, k = len(y), groups.ngroups
    if corrected and n > k:
        between -= (k - 1) * inside / (n - k)
    return max(between, 0.0) / total
