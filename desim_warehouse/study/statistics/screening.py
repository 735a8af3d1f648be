"""Screening of factors from a table of runs: the main effect of each.

For `Results.main_effects`, and for the answer of a study with several factors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import StudyError

if TYPE_CHECKING:
    import pandas as pd


LEVELS = 12  # a numeric factor with more values than this is taken as continuous and cut into bins


@dataclass(frozen=True)
class MainEffect:
    """The main effect of one factor: level -> mean of the indicator there minus the grand mean.

    `swing` is the largest minus the smallest effect. A continuous factor's levels are bins, shown as
    intervals.
    """

    factor: str
    effects: dict[Any, float]
    runs: dict[Any, int]
    swing: float


@dataclass(frozen=True)
class Effects:
    """The main effects of all factors, the largest swing first.

    `left_out` counts rows without a value (failed runs).
    """

    indicator: str
    grand_mean: float
    factors: tuple[MainEffect, ...]
    left_out: int


def main_effects(table: pd.DataFrame, factors: Sequence[str], indicator: str, bins: int = 5) -> Effects:
    """Return the mean of an indicator at each level of each factor, minus the grand mean over all runs.

    Args:
        table: a row per run, columns for factors and indicators. Rows with a missing indicator are left out.
        factors: columns to look at.
        indicator: column with the output.
        bins: a numeric factor with more than 12 values is cut into this number of bins of equally many runs.

    Raises:
        StudyError: an unknown or missing column, or no row left.

    Source: Law (2015), section 12.2 (factorial designs), for any number of levels.
    Assumes: the other factors are spread alike over the levels, as in a grid. On paired lists a factor's effect
    contains those of the factors varied with it.
    """
    rows, left_out = _clean(table, factors, indicator)
    grand_mean = float(rows[indicator].mean())
    ranked = []
    for factor in factors:
        groups = rows.groupby(_levels(rows[factor], bins), observed=True, sort=True, dropna=False)[indicator]
        effects = {level: float(mean) - grand_mean for level, mean in groups.mean().items()}
        runs = {level: int(count) for level, count in groups.size().items()}
        ranked.append(MainEffect(factor, effects, runs, max(effects.values()) - min(effects.values())))
    ranked.sort(key=lambda effect: -effect.swing)  # stable: equal swings stay in the order given
    return Effects(indicator, grand_mean, tuple(ranked), left_out)


def _clean(table: pd.DataFrame, factors: Sequence[str], indicator: str) -> tuple[pd.DataFrame, int]:
    """Return the rows that have the indicator, and how many rows lack it."""
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
    """Return the factor's own levels, or for a continuous factor its bins of equally many runs."""
    import pandas as pd

    if pd.api.types.is_numeric_dtype(column) and column.nunique() > LEVELS:
        return pd.qcut(column, bins, duplicates="drop")
    return column
