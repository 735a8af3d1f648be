"""The results of a study so far: its finished runs by design, and the statistics that follow from them.

For `desim study`, `compare` and `what-if`, and for every question that does a study; users hold
`questions.study.Results`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from desim_warehouse.errors import StudyError, WarehouseError
from desim_warehouse.folders import JOURNAL, RESULTS
from desim_warehouse.model import Model
from desim_warehouse.model.facts.costs import is_fixed
from desim_warehouse.outcome import targets
from desim_warehouse.outcome.indicators import chosen, is_count, judged_by, within
from desim_warehouse.outcome.verdicts import Verdict, end_of_run, judge_design
from desim_warehouse.study import rare
from desim_warehouse.study.design import Point, baseline_point
from desim_warehouse.study.factors import Label
from desim_warehouse.study.file import labels
from desim_warehouse.study.plan import StudyPlan, models
from desim_warehouse.study.statistics import comparison, intervals, judge, screening
from desim_warehouse.study.table import Row, arrow, columns, is_numeric, level_column, rows_of
from desim_warehouse.study.target import read_target
from desim_warehouse.values.labels import readable

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray


_MOST_MAIN = 6


def outcome_of(row: Row) -> tuple[object, ...]:
    """Return the outcome of a run, with its replication, as a value that can be compared."""
    return row.replication, row.outcome.error, *sorted((name, repr(value)) for name, value in row.indicators.items())


@dataclass(frozen=True, eq=False)
class ResultsData:
    """The finished runs of a study and the statistics that follow from them; `questions.study.Results` has the words.

    `rows` are in the order of the design, then of replications. A design is named by its text, such as "fleet.size=3".
    Points that are equal are one design. `versions` are those that the runs were made with.
    """

    plan: StudyPlan
    points: tuple[Point, ...]
    rows: tuple[Row, ...]
    versions: Mapping[str, str] = field(default_factory=dict)
    folder: Path | None = None
    notes: tuple[str, ...] = ()
    is_whole: bool = False
    """Whether every run is there that the plan asks for."""

    @classmethod
    def load(cls, folder: str | Path) -> Self:
        """Read the results of the finished runs in a study folder, without simulating anything.

        Raises:
            StudyError: where there is no study, or it is damaged.
        """
        from desim_warehouse.study.execution.store import Store
        from desim_warehouse.study.record import read_record
        from desim_warehouse.study.runner import StudyRunner

        folder = Path(folder)
        record = read_record(folder)
        points = tuple(record.plan.points())
        if not (folder / JOURNAL).exists() and (folder / RESULTS).exists():
            rows = rows_of(folder / RESULTS, points)
            return cls(record.plan, points, rows, record.versions, folder)
        notes: list[str] = []
        with Store(folder, notes.append, read_only=True, version=record.versions["desim-warehouse"]) as store:
            runner = StudyRunner(record.plan, store, list(points), record.keys)
            is_whole = runner.recall()
            rows = tuple(runner.finished())
        return cls(record.plan, points, rows, record.versions, folder, tuple(notes), is_whole)

    @property
    def version(self) -> str:
        """The version of desim-warehouse that simulated the runs."""
        return self.versions["desim-warehouse"]

    # The table

    @property
    def factors(self) -> tuple[str, ...]:
        """The factors: keys of the model, or names of cases."""
        return tuple(factor.key for factor in self.plan.factors)

    @cached_property
    def table(self) -> pd.DataFrame:
        """One row per run: factors under their key, replication, seed, indicators, deterministic, run_time, error."""
        return self.frame(self.plan.indicators)

    def frame(self, indicators: Sequence[str]) -> pd.DataFrame:
        """Return the table with these indicators, or all that any run has."""
        frame: pd.DataFrame = arrow(columns(self.rows, self.factors, indicators)).to_pandas()
        return frame

    # Indicators

    @cached_property
    def indicators(self) -> tuple[str, ...]:
        """Every indicator that a run has."""
        return tuple(dict.fromkeys(name for row in self.rows for name in row.indicators))

    def chosen(self, wanted: Sequence[str] | None = None) -> list[str]:
        """Return the indicators to show: the wanted ones, else the study's, else all that any run has.

        Raises:
            StudyError: for one that no run has.
        """
        return chosen(wanted or self.plan.indicators or self.indicators, self.indicators)

    def usual(self, most: int = 5) -> list[str]:
        """Return the first of the indicators that such runs are judged by, as far as all runs have them."""
        never_ends = any(model.tasks.never_end for model in (self.base, *self.models.values()))
        done = [row for row in self.rows if not row.outcome.error]
        common = [name for name in self.indicators if all(name in row.indicators for row in done)]
        return judged_by(common, never_ends=never_ends)[:most]

    @cached_property
    def main(self) -> tuple[str, ...]:
        """The indicators of a report: the study's own if they are few, without those that have no value."""
        chosen = self.plan.indicators if 0 < len(self.plan.indicators) <= _MOST_MAIN else self.usual()
        if self.target is not None:
            chosen = list(dict.fromkeys((self.target.indicator, *chosen)))
        return tuple(name for name in chosen if name in self.table and self.table[name].notna().any())

    @cached_property
    def moving(self) -> tuple[str, ...]:
        """The indicators of `main` that differ between runs."""
        return tuple(name for name in self.main if len(set(self.table[name].dropna())) > 1)

    # Designs

    @property
    def base(self) -> Model:
        """The model that is varied."""
        return self.plan.base

    @cached_property
    def models(self) -> Mapping[str, Model]:
        """The model of every design, empty where one cannot be made here, such as with a user's own policy."""
        try:
            made = models(self.plan, self.points)
        except WarehouseError:
            return {}
        return {str(self.points[number]): model for number, model in made.items()}

    @cached_property
    def warm_ups(self) -> Mapping[str, float]:
        """With `warm_up: auto`: the warm-up of every design, in the model's time unit, else empty."""
        times = self.plan.warm_up
        return dict(zip(map(str, self.points), times, strict=True)) if isinstance(times, tuple) else {}

    @cached_property
    def unsettled(self) -> tuple[str, ...]:
        """With `warm_up: auto`: designs not settled by the middle of their runs, which are counted from there on."""
        lengths = {design: model.run.end for design, model in self.models.items()}
        return tuple(design for design, time in self.warm_ups.items() if 2 * time >= lengths.get(design, math.inf))

    @cached_property
    def deterministic(self) -> bool:
        """Whether no run drew a random number or used a policy of the user's own: one replication is enough."""
        return _deterministic(self.rows)

    @cached_property
    def baseline(self) -> str:
        """The design that others are compared with."""
        return str(baseline_point(self.points, self.plan.baseline))

    @cached_property
    def designs(self) -> Mapping[str, tuple[Label, ...]]:
        """Every design with the levels of its factors as in the table: a column with any text is all text."""
        columns = [level_column([point.labels[key] for point in self.points]) for key in self.factors]
        levels = zip(*columns, strict=True) if columns else [()] * len(self.points)
        designs: dict[str, tuple[Label, ...]] = {}
        for point, of_point in zip(self.points, levels, strict=True):
            designs.setdefault(str(point), of_point)
        return designs

    def levels(self, factor: str) -> list[Any]:
        """Return the values of a factor: numbers ascending, else in the order of the study."""
        place = self.factors.index(factor)
        values = list(dict.fromkeys(levels[place] for levels in self.designs.values()))
        return sorted(values) if is_numeric(values) else values

    @cached_property
    def varied(self) -> tuple[str, ...]:
        """The factors that have several values."""
        return tuple(key for key in self.factors if len(self.levels(key)) > 1)

    def is_demand(self, factor: str) -> bool:
        """Whether a factor changes only the work that is asked for, and no decision about the warehouse."""
        [declared] = [item for item in self.plan.factors if item.key == factor]
        changed = {key for level in declared.levels for key in level.overrides} or {factor}
        return all(key.startswith(("tasks.demand", "tasks.goods", "tasks.flows")) for key in changed)

    @cached_property
    def verdicts(self) -> Mapping[str, list[Verdict]]:
        """The problems of each design, by the means of its runs (see `desim_warehouse.outcome.verdicts`).

        If a search requested the runs, it checked for these problems at each of its looks (interim analyses).
        """
        part = 1 / len(judge.looks_of_days()) if isinstance(self.plan.replications, tuple) else 1.0
        return {
            design: judge_design([row.indicators for row in self.runs(design)], model, part)
            for design, model in self.models.items()
        }

    @cached_property
    def rare(self) -> tuple[str, ...]:
        """Rare events that the runs so far miss: failures, each for the design with the fewest runs, and closures."""
        remarks: dict[str, None] = {}
        for design, model in self.models.items():
            times = [end_of_run(row.indicators, model) for row in self.runs(design) if not row.outcome.error]
            if times:
                remarks.update(dict.fromkeys(rare.unknown(model, len(times), math.fsum(times) / len(times))))
        return tuple(remarks)

    @cached_property
    def by_point(self) -> Mapping[int, list[Row]]:
        """Rows of the results table, one a run, by the number of their design point."""
        rows_by_point: dict[int, list[Row]] = {point.number: [] for point in self.points}
        for row in self.rows:
            rows_by_point[row.point.number].append(row)
        return rows_by_point

    @cached_property
    def _by_design(self) -> Mapping[str, Mapping[int, Row]]:
        """The rows of each design, by replication. Equal points have equal rows."""
        rows: dict[str, dict[int, Row]] = {str(point): {} for point in self.points}
        for row in self.rows:
            rows[str(row.point)].setdefault(row.replication, row)
        return rows

    def runs(self, design: str) -> list[Row]:
        """Return the runs of a design, by replication."""
        return list(self._by_design[design].values())

    def values(self, design: str, indicator: str) -> NDArray[np.float64]:
        """Return an indicator of a design by replication number, nan for runs that failed or are missing."""
        rows = self._by_design[design]
        values = np.full(max(rows, default=-1) + 1, np.nan)
        for replication, row in rows.items():
            values[replication] = row.value(indicator)
        return values

    # Statistics

    def estimates(self, indicator: str) -> dict[int, intervals.Estimate | None]:
        """Mean and interval of an indicator at each point, by its number, None where no run gave a value."""
        estimates: dict[int, intervals.Estimate | None] = {}
        for number, rows in self.by_point.items():
            estimates[number] = self.estimate(rows, indicator)
        return estimates

    def estimate(self, rows: Sequence[Row], indicator: str) -> intervals.Estimate | None:
        """Mean and interval of an indicator over runs of one design, None where none gave a value."""
        values = _known(rows, indicator)
        if not values:
            return None
        exact = self._is_free_of_chance(rows, indicator)
        return intervals.estimate(
            values, self.plan.confidence, deterministic=exact, within=within(indicator), counts=is_count(indicator)
        )

    def _is_free_of_chance(self, rows: Sequence[Row], indicator: str) -> bool:
        """Whether one run of a design gives an indicator exactly, as all its runs do where chance plays no part in it.

        Beside deterministic runs, these are costs of a year that depend on no run.
        """
        fixed = is_fixed(self.base, indicator) and len(set(_known(rows, indicator))) == 1
        return fixed or _deterministic(rows)

    def shown(self, design: str, indicator: str) -> intervals.Estimate | None:
        """Mean and interval of an indicator at a design; for the target's indicator, with the bounds of its verdict."""
        estimate, goal = self.estimate(self.runs(design), indicator), self.target
        if estimate is None or goal is None or goal.indicator != indicator:
            return estimate
        verdict = self.judged[design]
        return (
            estimate
            if verdict.low is None or verdict.high is None
            else replace(estimate, interval=(verdict.low, verdict.high))
        )

    def quantiles(self, indicator: str, share: float) -> dict[int, intervals.QuantileEstimate | None]:
        """Return the quantile of an indicator over all runs, with its interval, at each point by number, or None."""
        self.chosen([indicator])
        quantiles: dict[int, intervals.QuantileEstimate | None] = {}
        for number, rows in self.by_point.items():
            values = _known(rows, indicator)
            exact = _deterministic(rows)
            quantiles[number] = (
                intervals.quantile(values, share, self.plan.confidence, deterministic=exact) if values else None
            )
        return quantiles

    def summary(self, indicators: Sequence[str] | None = None) -> pd.DataFrame:
        """Return a row for each design point and indicator.

        Columns: the factors, indicator, n (runs with a value), failed (runs without), mean, half_width (mean ±
        half-width holds the interval with the study's confidence), low and high (its ends), median, q05, q25, q75, q95,
        deterministic. Where `deterministic` is true the mean is exact, and there is no interval. With a single random
        run there is none either.
        """
        import pandas as pd

        lines = [
            {**point.labels, "indicator": indicator, **_line(estimate, len(self.by_point[point.number]))}
            for indicator in self.chosen(indicators)
            for point, estimate in zip(self.points, self.estimates(indicator).values(), strict=True)
        ]
        return pd.DataFrame(lines)

    def compare(
        self,
        indicator: str,
        baseline: Mapping[str, Any] | None = None,
        method: comparison.Method = "bonferroni",
    ) -> comparison.Differences:
        """Return paired differences of designs to a baseline; arguments as for `questions.study.Results.compare`.

        Raises:
            StudyError: no such indicator or baseline, or a design without a replication in common with it.
        """
        self.chosen([indicator])
        unknown = [key for key in baseline or () if key not in self.factors]
        if unknown:
            raise StudyError(f"baseline: {unknown[0]!r} is no factor of the study, expected {', '.join(self.factors)}")
        if baseline and self.plan.rule == "grid":
            against = self._matched(labels(baseline))
        else:
            base = str(baseline_point(self.points, labels(baseline))) if baseline else self.baseline
            against = dict.fromkeys(self.designs, base)
        values = {design: self.values(design, indicator) for design in self.designs}
        return self._compared(values, indicator, against, method)

    def _matched(self, wanted: Mapping[str, Label]) -> dict[str, str]:
        """Return the baseline of each design: it has the wanted levels, and else the levels of the design itself."""
        baseline_point(self.points, wanted)  # refuses levels that no design has
        points = {tuple(point.labels.items()): str(point) for point in self.points}
        against = {}
        for point in self.points:
            levels = {key: wanted.get(key, level) for key, level in point.labels.items()}
            base = points.get(tuple(levels.items()))
            if base is None:
                text = ", ".join(f"{key}={readable(level)}" for key, level in levels.items())
                raise StudyError(f"baseline: no design {text}, which {point} would be compared with")
            against[str(point)] = base
        return against

    def compare_finished(self, indicator: str, baseline: str | None = None) -> comparison.Differences | None:
        """Paired differences of designs that have replications in common with the baseline, None where none has.

        `baseline`: a design by its text (default: the study's).
        """
        chosen = baseline or self.baseline
        base = self.values(chosen, indicator)
        table = {chosen: base}
        for design in self.designs:
            ours = self.values(design, indicator)
            n = min(ours.size, base.size)
            if design != chosen and np.isfinite(ours[:n] + base[:n]).any():
                table[design] = ours
        against = dict.fromkeys(table, chosen)
        return self._compared(table, indicator, against, "bonferroni") if len(table) > 1 else None

    @cached_property
    def target(self) -> targets.Target | None:
        """The target that designs should meet."""
        return read_target(self.plan.target, self.base.units.names) if self.plan.target else None

    def outcomes(self, design: str) -> tuple[object, ...]:
        """Return the outcomes of the runs of a design, each with its replication, as values that can be compared."""
        return tuple(map(outcome_of, self.runs(design)))

    @cached_property
    def same(self) -> Mapping[str, str]:
        """Designs whose runs equal an earlier design's in every indicator, mapped to that design, as one option."""
        first: dict[tuple[object, ...], str] = {}
        same = {}
        for design in self.designs:
            if any(row.indicators for row in self.runs(design)):
                other = first.setdefault(self.outcomes(design), design)
                if other != design:
                    same[design] = other
        return same

    @cached_property
    def judged(self) -> Mapping[str, judge.DesignVerdict[str]]:
        """Verdicts on whether designs with values meet the target, valid simultaneously with the study's confidence.

        If a search requested runs until a verdict was clear, each of its looks (interim analyses) counts. A search
        spends alpha in the order of its designs, so it may have decided a design that is undecided here; its answer has
        its own verdicts. A design that cannot last (see `desim_warehouse.outcome.verdicts`) fails regardless of its
        values. Designs with equal runs count once, so that copies cost no certainty.
        """
        goal = self.target
        if goal is None:
            return {}
        values_of = {design: _known(self.runs(design), goal.indicator) for design in self.designs}
        counts = [len(values) for design, values in values_of.items() if values and design not in self.same]
        asked = isinstance(self.plan.replications, tuple) and counts
        looks = len(judge.looks(min(counts), max(counts))) if asked else 1
        level = 1 - (1 - self.plan.confidence) / max(len(counts) * looks, 1)
        verdicts = {}
        for design, values in values_of.items():
            if values:
                exact = self._is_exact(design, values)
                least = self._least(design, max(counts)) if asked else 0
                verdict = judge.judged(design, values, goal, level, exact, goal.measure.within, least=least)
                lasts = not any(problem.is_lasting for problem in self.verdicts.get(design, ()))
                verdicts[design] = verdict if lasts else replace(verdict, verdict="fails")
        return verdicts

    def _is_exact(self, design: str, values: Sequence[float]) -> bool:
        """Whether the mean of these values of the target's indicator is exact."""
        goal, model = self.target, self.models.get(design)
        agree = goal is not None and model is not None and rare.shows(model, goal.indicator)
        fixed = agree and goal is not None and intervals.does_not_vary(values, goal.measure.within)
        return fixed or _deterministic(self.runs(design))

    def _least(self, design: str, most: int) -> int:
        """Return the fewest runs for a verdict that a design meets the target, in a search with `most` runs of each."""
        model = self.models.get(design)
        return 0 if model is None else rare.days_needed(model, cap=most).least

    @cached_property
    def runs_to_tell(self) -> Mapping[str, int | None]:
        """Undecided designs, each with the total number of runs that would probably decide; None if too many."""
        goal = self.target
        return {
            design: judge.runs_to_tell(
                _known(self.runs(design), goal.indicator), goal, verdict.level, goal.measure.within
            )
            for design, verdict in self.judged.items()
            if goal is not None and verdict.verdict == "undecided" and verdict.n > 1 and design not in self.same
        }

    def _compared(
        self, table: Mapping[str, Any], indicator: str, against: Mapping[str, str], method: comparison.Method
    ) -> comparison.Differences:
        """Return the differences of designs to the baseline of each; pairs with equal runs count once."""
        every = {design: base for design, base in against.items() if design != base}
        if not every:
            raise StudyError(f"nothing to compare with the baseline {next(iter(against.values()))!r}: the only design")
        once: dict[tuple[str, str], str] = {}
        for design, base in every.items():
            ours, theirs = (self.same.get(name, name) for name in (design, base))
            if ours != theirs:
                once.setdefault((ours, theirs), design)
        pairs = {design: every[design] for design in once.values()} or every
        exact = [design for design in table if self._is_free_of_chance(self.runs(design), indicator)]
        differences = comparison.compare_pairs(table, pairs, method, self.plan.confidence, deterministic=exact)
        return replace(differences, against=every)

    def main_effects(self, indicator: str) -> screening.Effects:
        """Return the main effect of each factor."""
        return screening.main_effects(self.frame([indicator]), self.factors, indicator)


def _known(rows: Sequence[Row], indicator: str) -> list[float]:
    """Return the values of an indicator in the runs that have one."""
    return [value for row in rows if math.isfinite(value := row.value(indicator))]


def _deterministic(rows: Sequence[Row]) -> bool:
    """Whether all finished runs were deterministic."""
    done = [row.outcome for row in rows if row.outcome.error is None]
    return bool(done) and all(outcome.deterministic for outcome in done)


def _line(estimate: intervals.Estimate | None, runs: int) -> dict[str, Any]:
    if estimate is None:
        nothing = dict.fromkeys(("mean", "half_width", "low", "high"), math.nan)
        return {"n": 0, "failed": runs, **nothing, "deterministic": False}
    low, high = estimate.interval or (math.nan, math.nan)
    return {
        "n": estimate.n,
        "failed": runs - estimate.n,
        "mean": estimate.mean,
        "half_width": math.nan if estimate.half_width is None else estimate.half_width,
        "low": low,
        "high": high,
        "median": estimate.median,
        **{f"q{round(100 * share):02d}": value for share, value in estimate.quantiles.items()},
        "deterministic": estimate.deterministic,
    }
