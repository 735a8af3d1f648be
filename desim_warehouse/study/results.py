"""The table of a study: a row for each run, in the order of the design, whatever order they finished in."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any, NamedTuple

from desim_warehouse.errors import StudyError, reason
from desim_warehouse.study.indicators import INDICATORS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    import pyarrow as pa

    from desim_warehouse.study.design import Point
    from desim_warehouse.study.execution.work import Outcome


class Row(NamedTuple):
    """A finished run of a study."""

    point: Point
    replication: int
    seed: int
    outcome: Outcome


def columns(rows: Sequence[Row], factors: Iterable[str], indicators: Sequence[str]) -> dict[str, list[Any]]:
    """The table by columns: factors, replication, seed, indicators, deterministic, run_time, error.

    `indicators`: those to show; none given, all that any run has. A failed run has none.
    """
    shown = indicators or _all(rows)
    table: dict[str, list[Any]] = {key: [row.point.labels[key] for row in rows] for key in factors}
    table |= {"replication": [row.replication for row in rows], "seed": [row.seed for row in rows]}
    table |= {name: [row.outcome.values.get(name) for row in rows] for name in shown}
    table["deterministic"] = [row.outcome.deterministic for row in rows]
    table["run_time"] = [row.outcome.run_time for row in rows]
    table["error"] = [row.outcome.error for row in rows]
    return table


def _all(rows: Iterable[Row]) -> list[str]:
    """Every indicator that any run has, in our order, then any others."""
    found = dict.fromkeys(name for row in rows for name in row.outcome.values)
    return [*(name for name in INDICATORS if name in found), *(name for name in found if name not in INDICATORS)]


def arrow(table: Mapping[str, list[Any]]) -> pa.Table:
    """The table with one type a column: whole numbers, numbers, truth values or text."""
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
    return pa.array([None if value is None else _text(value) for value in values], pa.string())


def _text(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def write_results(table: pa.Table, path: Path) -> None:
    """Put the table in place as a whole.

    Raises:
        StudyError: where it cannot be written; what was there before stays.
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
    """Whether there is a table that cannot be read."""
    if not path.exists():
        return False
    import pyarrow.parquet as pq

    try:
        pq.ParquetFile(path).close()
    except (OSError, ValueError):
        return True
    return False


def value_of(outcome: Outcome, indicator: str) -> float:
    """The indicator of a run; nan where it failed.

    Raises:
        StudyError: where the run has no such indicator.
    """
    if outcome.error is not None:
        return math.nan
    if indicator not in outcome.values:
        raise StudyError(f"indicator {indicator!r}: the runs have none; they have {', '.join(outcome.values)}")
    return outcome.values[indicator]
