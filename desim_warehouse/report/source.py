"""What a report needs to know of a study, whatever it was read from."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.errors import ReportError, StudyError, WarehouseError, reason
from desim_warehouse.report import words
from desim_warehouse.report.tables import is_numeric

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd
    from numpy.typing import NDArray

    from desim_warehouse.model import Model
    from desim_warehouse.study.design import Point
    from desim_warehouse.study.plan import Plan
    from desim_warehouse.study.statistics import Comparison

Design = tuple[Any, ...]
"""The levels of all factors of a study, in their order."""

MAIN = ("T", "S", "C", "throughput_per_hour", "cycle_time_mean")
"""What reports look at if the study does not say."""
_MOST_MAIN = 6


@dataclass(frozen=True, eq=False)
class StudyFacts:
    """A study and its runs: `table` has a row per run, its columns are factors, replication, seed and indicators.

    `designs` are the points in the order of the study, `models` what was simulated there. `baseline` is one of
    the designs. `deterministic`: no run used random numbers or a policy of the user's own.
    """

    name: str
    description: str
    base: Model
    factors: tuple[str, ...]
    designs: tuple[Design, ...]
    models: Mapping[Design, Model]
    baseline: Design
    indicators: tuple[str, ...]
    table: pd.DataFrame
    confidence: float
    seed: int
    rule: str
    replications: str
    deterministic: bool
    versions: Mapping[str, str]
    folder: str

    @property
    def main(self) -> tuple[str, ...]:
        """The indicators that the report shows, those without any value left out."""
        chosen = self.indicators if 0 < len(self.indicators) <= _MOST_MAIN else MAIN
        return tuple(name for name in chosen if name in self.table and self.table[name].notna().any())

    @property
    def moving(self) -> tuple[str, ...]:
        """Those of `main` that are not the same in all runs."""
        return tuple(name for name in self.main if not _constant(self.table[name]))

    @property
    def sampled(self) -> bool:
        """Whether the designs are a sample of ranges rather than listed values."""
        return self.rule not in ("grid", "paired")

    def levels(self, factor: str) -> list[Any]:
        """The values of a factor that were simulated: numbers upwards, else in the order of the study."""
        place = self.factors.index(factor)
        found = list(dict.fromkeys(design[place] for design in self.designs))
        return sorted(found) if is_numeric(found) else found

    def name_of(self, design: Design) -> str:
        """A design in words; factors that do not vary are left out."""
        varied = {
            key: value
            for key, value in zip(self.factors, design, strict=True)
            if len(self.levels(key)) > 1 or len(self.factors) == 1
        }
        return words.design_name(varied)

    @cached_property
    def _rows(self) -> dict[Design, pd.DataFrame]:
        """The runs of each design, by replication."""
        columns = [[words.plain(value) for value in self.table[factor]] for factor in self.factors]
        keys = list(zip(*columns, strict=True)) if columns else [()] * len(self.table)
        places: dict[Design, list[int]] = {design: [] for design in self.designs}
        for place, key in enumerate(keys):
            places.setdefault(key, []).append(place)
        rows = {
            design: self.table.iloc[chosen].set_index("replication").sort_index() for design, chosen in places.items()
        }
        return {design: runs[~runs.index.duplicated()] for design, runs in rows.items()}

    def runs(self, design: Design) -> pd.DataFrame:
        """The runs of a design, by replication."""
        return self._rows[design]

    def is_deterministic(self, design: Design) -> bool:
        """Whether chance played no part in the runs of a design."""
        runs = self.runs(design)
        known = "deterministic" in runs and bool(runs.loc[runs["error"].isna(), "deterministic"].all())
        return self.deterministic or known

    def values(self, design: Design, indicator: str) -> NDArray[np.float64]:
        """An indicator by replication number; nan for runs that failed or are missing."""
        runs = self.runs(design)
        values = np.full(int(runs.index.max()) + 1 if len(runs) else 0, np.nan)
        values[runs.index.to_numpy(dtype=int)] = runs[indicator].to_numpy(dtype=float)
        return values

    def comparison(self, indicator: str) -> Comparison | None:
        """All designs against the baseline, as far as they have replications in common with it; None without any."""
        from desim_warehouse.study.statistics import compare

        base = self.values(self.baseline, indicator)
        table = {self.baseline: base}
        for design in self.designs:
            ours = self.values(design, indicator)
            n = min(ours.size, base.size)
            if design != self.baseline and np.isfinite(ours[:n] + base[:n]).any():
                table[design] = ours
        if len(table) == 1:
            return None
        exact = [design for design in table if self.is_deterministic(design)]
        return compare(table, self.baseline, confidence=self.confidence, deterministic=exact)


def _constant(column: pd.Series[Any]) -> bool:
    """Whether all runs that have a value have the same."""
    values = column.dropna()
    return bool((values == values.iloc[0]).all())


def read_study(folder: str | Path) -> StudyFacts:
    """The study of a folder that `desim study` or `desim what-if` wrote.

    Raises:
        ReportError: where there is none, it is damaged, or has no finished run.
    """
    from desim_warehouse.study import plan as plans
    from desim_warehouse.study.record import read_record

    folder = Path(folder)
    try:
        plan = read_record(folder)
    except StudyError as error:
        raise ReportError(str(error)) from error
    versions: dict[str, str] = json.loads((folder / "study.json").read_text(encoding="utf-8"))["versions"]
    table = _table(folder)
    points = plan.points()
    factors = tuple(factor.key for factor in plan.factors)
    keys = {point.number: _design(point, factors, table) for point in points}
    try:
        made = plans.models(plan, points)
    except WarehouseError:  # a user's own policy that cannot be had here
        made = {}
    return StudyFacts(
        name=plan.name,
        description=plan.description,
        base=plan.base,
        factors=factors,
        designs=tuple(dict.fromkeys(keys.values())),
        models={keys[number]: model for number, model in made.items()},
        baseline=keys[plan.baseline_point(points).number],
        indicators=plan.indicators,
        table=table,
        confidence=plan.confidence,
        seed=plan.seed,
        rule=plan.rule.name,
        replications=_replications(plan),
        deterministic="deterministic" in table and bool(table.loc[table["error"].isna(), "deterministic"].all()),
        versions=versions,
        folder=str(folder),
    )


def _table(folder: Path) -> pd.DataFrame:
    """The runs of a study folder."""
    import pandas as pd

    path = folder / "results.parquet"
    try:
        table = pd.read_parquet(path)
    except (OSError, ValueError) as error:
        said = f"cannot be read ({reason(error)}); start the study again with this folder"
        raise ReportError(f"{path}: {said}") from error
    if table.empty:
        raise ReportError(f"{path}: no run has finished, so there is nothing to report")
    if table["error"].notna().all():
        raise ReportError(f"{path}: every run failed, the first with: {table['error'].iloc[0]}")
    return table


def _design(point: Point, factors: tuple[str, ...], table: pd.DataFrame) -> Design:
    """The labels of a point as the table holds them: a column with any text is all text."""
    from pandas.api.types import is_bool_dtype, is_numeric_dtype

    found = []
    for key in factors:
        label = point.labels[key]
        as_text = not (is_numeric_dtype(table[key]) or is_bool_dtype(table[key])) and label is not None
        found.append((str(label).lower() if isinstance(label, bool) else str(label)) if as_text else label)
    return tuple(found)


def _replications(plan: Plan) -> str:
    """How often each design is run, in words."""
    rule = plan.replications
    if isinstance(rule, int):
        return str(rule)
    if isinstance(rule, tuple):
        return f"{min(rule)} to {max(rule)} of each design, as the procedure asked for"
    return (
        f"{rule.minimum} to {rule.cap} of each design, until the half-width of {rule.indicator} is at most "
        f"{words.number(100 * rule.half_width)} % of its mean"
    )
