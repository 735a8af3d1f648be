"""From a study table to one estimate for each design: what figures, report and sentences have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import ReportError
from desim_warehouse.report.words import level, plain

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import pandas as pd

    from desim_warehouse.study.statistics import Estimate


@dataclass(frozen=True)
class Cell:
    """What the runs at some levels of the factors say about an indicator, and its value by replication."""

    levels: tuple[Any, ...]
    estimate: Estimate
    by_replication: Mapping[int, float]


def cells(
    table: pd.DataFrame,
    factors: Sequence[str],
    indicator: str,
    confidence: float = 0.95,
    scale: float = 1.0,
) -> list[Cell]:
    """One estimate for each combination of levels that has runs, in the order of the levels.

    Where other factors vary inside a combination, each replication is averaged over them first: replications
    stay independent of one another, so the t interval holds for that average. A replication that lacks some of
    those runs is left out, failed runs (no value) always are. `scale` multiplies every value (units).

    Raises:
        ReportError: an unknown column, or no run with a value.
    """
    from desim_warehouse.study.indicators import within
    from desim_warehouse.study.statistics import estimate

    low, high = (scale * end for end in within(indicator))
    rows = usable(table, factors, indicator)
    found = []
    for key in order(rows, factors):
        chosen = _where(rows, factors, key)
        values = _by_replication(chosen, indicator) * scale
        fixed = "deterministic" in chosen and bool(chosen["deterministic"].all())
        found.append(
            Cell(
                key,
                estimate(values.tolist(), confidence, deterministic=fixed, within=(low, high)),
                {int(r): value for r, value in zip(values.index, values, strict=True)},
            )
        )
    return found


def usable(table: pd.DataFrame, factors: Sequence[str], indicator: str) -> pd.DataFrame:
    """The runs that have a value, with the factors' values as they can be compared."""
    missing = [name for name in (*factors, indicator) if name not in table.columns]
    if missing:
        raise ReportError(f"no column {', '.join(missing)}; the table has {', '.join(map(str, table.columns))}")
    rows = table[table[indicator].notna()].copy()
    if rows.empty:
        raise ReportError(f"{indicator}: no run has a value")
    for factor in factors:
        rows[factor] = _comparable(rows[factor])
    return rows


def _comparable(column: pd.Series[Any]) -> pd.Series[Any]:
    import pandas as pd

    if pd.api.types.is_numeric_dtype(column) and column.notna().all():
        return column
    return pd.Series([plain(value) for value in column], index=column.index, dtype=object)


def is_numeric(values: Sequence[Any]) -> bool:
    """Whether all levels are numbers, so that an axis can have them at scale."""
    return all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)


def levels(rows: pd.DataFrame, factor: str) -> list[Any]:
    """The levels of a factor: numbers upwards, else in the order in which they come."""
    found = [plain(value) for value in dict.fromkeys(rows[factor].tolist())]
    return sorted(found) if is_numeric(found) else found


def order(rows: pd.DataFrame, factors: Sequence[str]) -> list[tuple[Any, ...]]:
    """The combinations of levels that have runs, in the order of the levels."""
    ranks = [{value: rank for rank, value in enumerate(levels(rows, factor))} for factor in factors]
    found = dict.fromkeys(zip(*(rows[factor].tolist() for factor in factors), strict=True)) if factors else {(): 0}
    return sorted(found, key=lambda key: tuple(rank[value] for rank, value in zip(ranks, key, strict=True)))


def _where(rows: pd.DataFrame, factors: Sequence[str], key: tuple[Any, ...]) -> pd.DataFrame:
    for factor, value in zip(factors, key, strict=True):
        rows = rows[[bool(item == value) for item in rows[factor]]]
    return rows


def _by_replication(rows: pd.DataFrame, indicator: str) -> pd.Series[float]:
    """One value for each replication, averaged over factors that vary besides."""
    if "replication" not in rows.columns:
        return rows[indicator].astype(float)
    groups = rows.groupby("replication", sort=True)[indicator]
    sizes = groups.size()
    means = groups.mean().astype(float)
    return means[sizes == sizes.max()]


def names(key: Sequence[Any]) -> str:
    """Levels of several factors as one label."""
    return ", ".join(level(value) for value in key)
