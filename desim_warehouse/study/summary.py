"""What a study says: means with intervals by design, and differences to the baseline."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal, cast

from desim_warehouse.errors import StudyError
from desim_warehouse.model import outline
from desim_warehouse.study import statistics
from desim_warehouse.study.design import saltelli
from desim_warehouse.study.factors import label
from desim_warehouse.study.indicators import within
from desim_warehouse.study.results import value_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import pandas as pd

    from desim_warehouse.study.design import Point
    from desim_warehouse.study.results import Row
    from desim_warehouse.study.study import Study


def shown_indicators(study: Study, wanted: Sequence[str] | None = None) -> list[str]:
    """The indicators to look at: those wanted, else the study's, else all that any run has.

    Raises:
        StudyError: for one that no run has.
    """
    have = list(dict.fromkeys(name for row in study.rows for name in row.outcome.values))  # noqa: PD011 - not a DataFrame
    chosen = list(wanted or study.plan.indicators or have)
    for name in chosen:
        if have and name not in have:
            near = outline.nearest(name, have)
            hint = f"did you mean {near!r}?" if near else f"expected one of {', '.join(have)}"
            raise StudyError(f"indicator {name!r}: no run has it, {hint}")
    return chosen


def by_point(study: Study) -> dict[int, list[Row]]:
    """The rows of each design point."""
    found: dict[int, list[Row]] = {point.number: [] for point in study.points}
    for row in study.rows:
        found[row.point.number].append(row)
    return found


def estimates(study: Study, indicator: str) -> dict[int, statistics.Estimate | None]:
    """Mean and interval of an indicator at each point; None where no run gave a value."""
    found: dict[int, statistics.Estimate | None] = {}
    for number, rows in by_point(study).items():
        good = [row for row in rows if math.isfinite(_value(row, indicator))]
        found[number] = (
            statistics.estimate(
                [_value(row, indicator) for row in good],
                study.plan.confidence,
                deterministic=_deterministic(good),
                within=within(indicator),
            )
            if good
            else None
        )
    return found


def _deterministic(rows: Sequence[Row]) -> bool:
    """Whether chance played no part in any of the runs that were finished."""
    return all(row.outcome.deterministic for row in rows if row.outcome.error is None)


def _value(row: Row, indicator: str) -> float:
    """The indicator of a run, nan where it has none."""
    return row.outcome.values.get(indicator, math.nan)  # noqa: PD011 - not a DataFrame


def summary(study: Study, indicators: Sequence[str] | None = None) -> pd.DataFrame:
    """A row for each design point and indicator.

    Columns: the factors, indicator, n (runs with a value), failed (runs without), mean, half_width (mean ±
    half-width holds the interval with the study's confidence), low and high (its ends), median, q05, q25, q75,
    q95, deterministic. Where `deterministic` is true the mean is exact, and there is no interval; with a single
    random run there is none either.
    """
    import pandas as pd

    counts = {number: len(rows) for number, rows in by_point(study).items()}
    lines = []
    for indicator in shown_indicators(study, indicators):
        for point, found in zip(study.points, estimates(study, indicator).values(), strict=True):
            lines.append({**point.labels, "indicator": indicator, **_line(found, counts[point.number])})
    return pd.DataFrame(lines)


def _line(found: statistics.Estimate | None, runs: int) -> dict[str, Any]:
    if found is None:
        nothing = dict.fromkeys(("mean", "half_width", "low", "high"), math.nan)
        return {"n": 0, "failed": runs, **nothing, "deterministic": False}
    low, high = found.interval or (math.nan, math.nan)
    return {
        "n": found.n,
        "failed": runs - found.n,
        "mean": found.mean,
        "half_width": math.nan if found.half_width is None else found.half_width,
        "low": low,
        "high": high,
        "median": found.median,
        **{f"q{round(100 * share):02d}": value for share, value in found.quantiles.items()},
        "deterministic": found.deterministic,
    }


def comparison(study: Study, indicator: str, baseline: Mapping[str, Any] | None, method: str) -> statistics.Comparison:
    """Differences of all designs to the baseline; designs are called by their text."""
    shown_indicators(study, [indicator])
    base = baseline_point(study, baseline)
    rows = by_point(study)
    table = {str(point): _by_replication(rows[point.number], indicator) for point in study.points}
    exact = [str(point) for point in study.points if _deterministic(rows[point.number])]
    kind = cast("Literal['bonferroni', 'holm']", method)
    return statistics.compare(table, str(base), kind, study.plan.confidence, deterministic=exact)


def baseline_point(study: Study, baseline: Mapping[str, Any] | None) -> Point:
    """The point to compare with: as given, else the study's."""
    from dataclasses import replace

    plan = study.plan
    if baseline:
        unknown = [key for key in baseline if key not in {factor.key for factor in plan.factors}]
        if unknown:
            names = ", ".join(factor.key for factor in plan.factors)
            raise StudyError(f"baseline: {unknown[0]!r} is no factor of the study, expected {names}")
        plan = replace(plan, baseline={key: label(value) for key, value in baseline.items()})
    return plan.baseline_point(study.points)


def _by_replication(rows: Sequence[Row], indicator: str) -> list[float]:
    """Values by replication number; nan where there is none."""
    values = [math.nan] * (max((row.replication for row in rows), default=-1) + 1)
    for row in rows:
        values[row.replication] = _value(row, indicator)
    return values


def sobol(study: Study, indicator: str) -> statistics.SobolIndices:
    """Sobol indices of a study with the design {saltelli: n}; replications of a point are averaged."""
    plan = study.plan
    if plan.rule.name != "saltelli":
        raise StudyError(
            f"Sobol indices need the design {{saltelli: 64}}, this study's is {plan.rule.name}; "
            "first-order shares can be had from any design"
        )
    shown_indicators(study, [indicator])
    means = []
    for number, rows in by_point(study).items():
        values = [value_of(row.outcome, indicator) for row in rows if row.outcome.error is None]
        if not values:
            raise StudyError(f"Sobol indices: no run of design {study.points[number]} has a value")
        means.append(math.fsum(values) / len(values))
    design = saltelli(plan.factors, plan.rule.size, plan.seed)
    return statistics.saltelli_indices(design, means, plan.confidence)
