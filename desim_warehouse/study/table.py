"""The table of a study: a row for each run, in the order of the design.

For all studies: the table of `Results`, of a study folder and of the live page.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from desim_warehouse.errors import ReportError, StudyError, reason
from desim_warehouse.outcome.indicators import INDICATORS, counted_in, is_count, no_run_has, within
from desim_warehouse.study.execution.work import Outcome
from desim_warehouse.study.factors import RESERVED, Label
from desim_warehouse.values.labels import plain

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

    from desim_warehouse.study.design import Point
    from desim_warehouse.study.statistics.intervals import Estimate


class Row(NamedTuple):
    """A finished run of a study."""

    point: Point
    replication: int
    seed: int
    outcome: Outcome

    @property
    def indicators(self) -> Mapping[str, float]:
        """The indicators of the run by name, none where it failed."""
        return self.outcome.values  # noqa: PD011 - not a DataFrame

    def value(self, indicator: str) -> float:
        """Return an indicator; nan where the run failed or has none. A share of tasks carries its number of tasks."""
        from desim_warehouse.study.statistics.intervals import TaskShare

        value = self.indicators.get(indicator, math.nan)
        tasks = math.fsum(self.indicators.get(name, 0.0) for name in counted_in(indicator, self.indicators))
        return TaskShare(value, tasks) if tasks else value

    def measured(self, indicator: str) -> float:
        """Return an indicator of a run that did not fail.

        Raises:
            StudyError: where the run has no such indicator, naming the nearest.
        """
        if indicator not in self.indicators:
            raise StudyError(no_run_has(indicator, self.indicators))
        return self.value(indicator)


def columns(rows: Sequence[Row], factors: Iterable[str], indicators: Sequence[str]) -> dict[str, list[Any]]:
    """Make the columns of the table: factors, replication, seed, indicators, deterministic, run_time, error.

    `indicators`: those to show, by default all that any run has. A failed run has none.
    """
    shown = indicators or _all(rows)
    table: dict[str, list[Any]] = {key: [row.point.labels[key] for row in rows] for key in factors}
    table |= {"replication": [row.replication for row in rows], "seed": [row.seed for row in rows]}
    table |= {name: [row.indicators.get(name) for row in rows] for name in shown}
    table["deterministic"] = [row.outcome.deterministic for row in rows]
    table["run_time"] = [row.outcome.run_time for row in rows]
    table["error"] = [row.outcome.error for row in rows]
    return table


def _all(rows: Iterable[Row]) -> list[str]:
    """Return every indicator that any run has: built-in ones in their order, then any others."""
    names = dict.fromkeys(name for row in rows for name in row.indicators)
    return [*(name for name in INDICATORS if name in names), *(name for name in names if name not in INDICATORS)]


def arrow(table: Mapping[str, list[Any]]) -> pa.Table:
    """Return the table with one type a column: whole numbers, numbers, truth values or text."""
    import pyarrow as pa

    return pa.table({name: _array(name, values) for name, values in table.items()})


def _array(name: str, values: list[Any]) -> pa.Array:
    import pyarrow as pa

    kinds = {type(value) for value in values if value is not None}
    if name == "error":
        return pa.array(values, pa.string())
    if kinds == {int} and name != "run_time":
        return pa.array(values, pa.int64())
    if kinds <= {int, float}:
        return pa.array([None if value is None else float(value) for value in values], pa.float64())
    if kinds == {bool}:
        return pa.array(values, pa.bool_())
    return pa.array([None if value is None else as_text(value) for value in values], pa.string())


def as_text(value: Any) -> str:
    """Return a value as text for a column."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def write_results(table: pa.Table, path: Path) -> None:
    """Write the table atomically.

    Raises:
        StudyError: where it cannot be written. What was there before stays.
    """
    import pyarrow.parquet as pq

    partial = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        pq.write_table(table, partial)
        with partial.open("rb+") as file:
            os.fsync(file.fileno())
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise StudyError(
            f"{path}: cannot be written ({reason(error)}); the runs are kept: make room and start the study again"
        ) from error


def is_damaged(path: Path) -> bool:
    """Whether a table exists that cannot be read."""
    if not path.exists():
        return False
    import pyarrow.parquet as pq

    try:
        pq.ParquetFile(path).close()
    except (OSError, ValueError):
        return True
    return False


def read_results(path: Path) -> pd.DataFrame:
    """Return the table of a study folder. Raises StudyError where it cannot be read."""
    import pandas as pd

    try:
        return pd.read_parquet(path)
    except (OSError, ValueError) as error:
        text = f"cannot be read ({reason(error)}); start the study again with this folder"
        raise StudyError(f"{path}: {text}") from error


# One estimate for each combination of levels: what figures and sentences are made of


def level_column(values: Sequence[Label]) -> list[Label]:
    """Return the levels of a factor as a column of one type."""
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {int, float} or kinds == {bool}:
        return list(values)
    return [None if value is None else as_text(value) for value in values]


def rows_of(path: Path, points: Sequence[Point]) -> tuple[Row, ...]:
    """Return the rows of a table, each at its point, and of equal points in their order."""
    table = read_results(path)
    try:
        return tuple(_rows(table, points))
    except (KeyError, IndexError, TypeError) as error:
        raise StudyError(f"{path}: not the table of this study ({reason(error)})") from error


def _rows(table: pd.DataFrame, points: Sequence[Point]) -> Iterator[Row]:
    factors = list(points[0].labels)
    columns = [level_column([point.labels[key] for point in points]) for key in factors]
    points_at: dict[tuple[Any, ...], list[Point]] = {}
    for point, key in zip(points, zip(*columns, strict=True) if columns else [()] * len(points), strict=True):
        points_at.setdefault(tuple(map(plain, key)), []).append(point)
    besides = {*factors, *RESERVED}
    seen: Counter[tuple[Any, ...]] = Counter()
    for line in table.to_dict("records"):
        key = tuple(plain(line[factor]) for factor in factors)
        run = (key, line["replication"])
        values = {str(name): value for name, value in line.items() if name not in besides and plain(value) is not None}
        fixed = bool(line["deterministic"])
        outcome = Outcome(values, line["run_time"], plain(line["error"]), deterministic=fixed)
        yield Row(points_at[key][seen[run]], line["replication"], line["seed"], outcome)
        seen[run] += 1


@dataclass(frozen=True)
class Cell:
    """The estimate of an indicator at some levels of the factors, and its value by replication."""

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
    """Estimate an indicator for each combination of levels that has runs, in the order of the levels.

    Where other factors vary inside a combination, each replication is averaged over them first. Replications stay
    independent of one another, so the t interval holds for that average. A replication that lacks some of those runs is
    left out, failed runs (no value) always are. `scale` multiplies every value (units).

    Raises:
        ReportError: an unknown column, or no run with a value.
    """
    from desim_warehouse.study.statistics.intervals import estimate

    rows = usable(table, factors, indicator)
    low, high = (scale * end for end in within(indicator))
    result = []
    for key in order(rows, factors):
        chosen = _where(rows, factors, key)
        values = _by_replication(chosen, indicator) * scale
        fixed = "deterministic" in chosen and bool(chosen["deterministic"].all())
        sample = _shares(chosen, indicator, values) if scale == 1 else values.tolist()  # in other units it is no share
        result.append(
            Cell(
                key,
                estimate(
                    sample,
                    confidence,
                    deterministic=fixed,
                    within=(low, high),
                    counts=is_count(indicator) and scale == 1,
                ),
                {int(r): value for r, value in zip(values.index, values, strict=True)},
            )
        )
    return result


def _shares(rows: pd.DataFrame, indicator: str, values: pd.Series[float]) -> list[float]:
    """Return the values of an indicator; a share of tasks of a single run carries its number of tasks."""
    from desim_warehouse.study.statistics.intervals import TaskShare

    counts = [name for name in counted_in(indicator, [str(name) for name in rows.columns]) if name in rows.columns]
    if not counts or len(rows) != len(values):
        return values.tolist()
    by_replication = rows.set_index("replication") if "replication" in rows.columns else rows
    tasks = by_replication[counts].fillna(0.0).sum(axis=1).reindex(values.index).tolist()
    return [TaskShare(value, count) if count else value for value, count in zip(values.tolist(), tasks, strict=True)]


def averaged_over(table: pd.DataFrame, factors: Sequence[str]) -> list[str]:
    """Return the other factors that vary among runs at equal levels of these; they are averaged over."""
    if "replication" not in table.columns:
        return []
    columns = list(table.columns)
    others = [str(name) for name in columns[: columns.index("replication")] if name not in factors]
    values = {name: [plain(value) for value in table[name]] for name in (*factors, *others)}
    cell = list(zip(*(values[name] for name in factors), strict=True)) if factors else [()] * len(table)
    return [name for name in others if len(set(zip(cell, values[name], strict=True))) > len(set(cell))]


def usable(table: pd.DataFrame, factors: Sequence[str], indicator: str) -> pd.DataFrame:
    """Return the runs that have a value, with factors in a form that can be compared."""
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
    """Whether all levels are numbers, so that an axis can be to scale."""
    return all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)


def levels(rows: pd.DataFrame, factor: str) -> list[Any]:
    """Return the levels of a factor: numbers ascending, else in order of appearance."""
    values = [plain(value) for value in dict.fromkeys(rows[factor].tolist())]
    return sorted(values) if is_numeric(values) else values


def order(rows: pd.DataFrame, factors: Sequence[str]) -> list[tuple[Any, ...]]:
    """Return the combinations of levels that have runs, in the order of the levels."""
    ranks = [{value: rank for rank, value in enumerate(levels(rows, factor))} for factor in factors]
    combinations = (
        dict.fromkeys(zip(*(rows[factor].tolist() for factor in factors), strict=True)) if factors else {(): 0}
    )
    return sorted(combinations, key=lambda key: tuple(rank[value] for rank, value in zip(ranks, key, strict=True)))


def _where(rows: pd.DataFrame, factors: Sequence[str], key: tuple[Any, ...]) -> pd.DataFrame:
    for factor, value in zip(factors, key, strict=True):
        rows = rows[[bool(item == value) for item in rows[factor]]]
    return rows


def _by_replication(rows: pd.DataFrame, indicator: str) -> pd.Series[float]:
    """One value for each replication, averaged over the other factors."""
    if "replication" not in rows.columns:
        return rows[indicator].astype(float)
    groups = rows.groupby("replication", sort=True)[indicator]
    sizes = groups.size()
    means = groups.mean().astype(float)
    return means[sizes == sizes.max()]
