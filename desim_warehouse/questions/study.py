"""The classes of studies that users hold: `Study`, `Results`, `Comparison`, `MainEffects`; the engine with words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

from desim_warehouse.answer.answer import Answer, Answering
from desim_warehouse.answer.frame import number_columns
from desim_warehouse.answer.text import printed_rows
from desim_warehouse.errors import number_of
from desim_warehouse.questions.run import Run, as_run
from desim_warehouse.study.results import ResultsData
from desim_warehouse.study.statistics import comparison, screening
from desim_warehouse.study.study import StudyEngine

if TYPE_CHECKING:
    import pandas as pd

    from desim_warehouse.run import RunData


@dataclass(frozen=True, repr=False)
class Comparison(Answering, comparison.Differences):
    """Differences of designs from a baseline on the same days: the result of `Study.compare`.

    Attributes:
        answer: the answer in words, as `desim compare` prints it; shown by `print`.
        indicator: the indicator that is compared.
        differences: a difference for each design, with interval and p-value; designs with equal runs share one.
        against: the baseline of each design.
        confidence: confidence level at which all differences hold simultaneously.
        statement: the meaning of intervals and p-values in words.
    """

    indicator: str = field(kw_only=True)
    results: Results = field(repr=False, compare=False, kw_only=True)

    @property
    def answer(self) -> Answer:
        """The differences in words."""
        from desim_warehouse.questions import compare_words

        return compare_words.answer(self.results, {self.indicator: self})

    @property
    def table(self) -> pd.DataFrame:
        """A row for each difference.

        Columns: the factors, baseline (the design compared with), difference with `_low` and `_high` (in the units of
        the indicator; nan without an interval), p (adjusted), differs (None: undecided), runs, missing (replications
        that only one of the two designs has).
        """
        import pandas as pd

        rows = []
        for difference in self.differences:
            low, high = difference.estimate.interval or (None, None)
            factors = zip(self.results.factors, self.results.designs[str(difference.design)], strict=True)
            rows.append(
                {
                    **dict(factors),
                    "baseline": difference.baseline,
                    **number_columns("difference", difference.estimate.mean, low, high),
                    "p": difference.p_adjusted,
                    "differs": difference.differs,
                    "runs": difference.estimate.n,
                    "missing": difference.missing,
                }
            )
        return pd.DataFrame(rows)

    def in_short(self) -> str:
        """Return a phrase with the indicator and the number of differences shown."""
        differ = sum(bool(difference.differs) for difference in self.differences)
        return f"{self.indicator}: {differ} of {number_of(len(self.differences), 'difference')} shown"


@dataclass(frozen=True, repr=False)
class MainEffects(screening.Effects):
    """Main effects of the factors of a study, the largest swing first: the result of `Study.main_effects`.

    Attributes:
        indicator: the indicator that is analysed.
        grand_mean: mean of the indicator over all runs, in the model's units.
        factors: for each factor, the effects of its levels (mean at the level minus grand mean), and its swing.
        left_out: number of runs without a value.
    """

    @property
    def table(self) -> pd.DataFrame:
        """A row for each level of each factor.

        Columns: factor, level, effect (mean at the level minus grand mean), swing, runs.
        """
        import pandas as pd

        return pd.DataFrame(
            {"factor": row.factor, "level": level, "effect": effect, "swing": row.swing, "runs": row.runs[level]}
            for row in self.factors
            for level, effect in row.effects.items()
        )

    def __str__(self) -> str:
        rows = [
            (factor.factor, str(level), f"{effect:+.4g}", str(factor.runs[level]))
            for factor in self.factors
            for level, effect in factor.effects.items()
        ]
        title = f"{self.indicator}: {self.grand_mean:.4g} on average, and what levels add to it"
        return printed_rows(title, ("factor", "level", "effect", "runs"), rows)

    def __repr__(self) -> str:
        swings = ", ".join(f"{factor.factor} {factor.swing:.3g}" for factor in self.factors)
        return f"MainEffects({self.indicator}: {swings})"


@dataclass(frozen=True, eq=False, repr=False)
class Results(Answering, ResultsData):
    """The finished runs of a study, their statistics, and the resulting answer.

    A design is named by its text, such as "fleet.size=3"; equal designs count once.

    Attributes:
        answer: the answer in words, as `desim study` prints it; shown by `print`.
        table: a row for each run; `summary` has a row for each design and indicator.
        rows: the runs, in the order of designs, then of replications.
        designs: each design with the levels of its factors.
        indicators: names of the indicators that any run has.
        verdicts: problems of each design.
    """

    @property
    def answer(self) -> Answer:
        """The answer of the study: the terminal prints it, and pages show it."""
        return self.answer_in(())

    @cached_property
    def table(self) -> pd.DataFrame:
        """A row for each run: factors under their key, replication, seed, indicators, run_time, error."""
        return self.frame(self.plan.indicators)

    def answer_in(self, indicators: Sequence[str]) -> Answer:
        """Compose the answer of the study in these indicators; if empty, in the usual indicators."""
        from desim_warehouse.questions import study_words  # imported late, as most studies are not asked for an answer

        return study_words.answer(self, indicators)

    def compare(
        self,
        indicator: str,
        baseline: Mapping[str, Any] | None = None,
        method: comparison.Method = "bonferroni",
    ) -> Comparison:
        """Compare designs with a baseline, replication by replication, with simultaneous confidence intervals.

        Each design is compared with the design that has the baseline's values of the named factors, and its own values
        of all other factors: with `{"policies.allocation": "in-order"}`, each policy is compared with in-order at the
        same fleet size. All comparisons form one family. Designs with equal runs count once, so that copies do not
        widen intervals; designs equal to their baseline have no row.

        Args:
            indicator: the indicator to compare.
            baseline: values of factors; for paired designs, whose factors vary together, the first design with these
                values. None for the study's baseline, by default its first design.
            method: bonferroni, or holm, whose p-values are never larger.

        Returns:
            The differences in the units of the indicator, each with interval and p-value.

        Raises:
            StudyError: no such indicator or baseline, or a design without a replication in common with its baseline.
        """
        return Comparison(**vars(super().compare(indicator, baseline, method)), indicator=indicator, results=self)

    def main_effects(self, indicator: str) -> MainEffects:
        """Compute main effects: the mean of an indicator at each level of each factor, minus the grand mean.

        Raises:
            StudyError: no factor was varied, or no run has a value.
        """
        return MainEffects(**vars(super().main_effects(indicator)))

    def in_short(self) -> str:
        """Return a phrase with the numbers of designs and runs."""
        failed = sum(row.outcome.error is not None for row in self.rows)
        runs = f"{number_of(len(self.rows), 'run')}{f', {failed} failed' if failed else ''}"
        return f"{self.plan.name}: {number_of(len(self.designs), 'design')}, {runs}"


class Study(StudyEngine):
    """Many runs of one model with varied factors: call `run()`, then look at `table` and `summary()`.

        study = dw.Study("models/multibots.yaml", {"fleet.size": range(1, 7)}, replications=20)
        study.run(workers=2, out="reports/out/fleet")
        study.summary(["T", "S"])

    `Study.open` loads the runs of a folder, in another program or after an interruption.
    """

    _results_type = Results

    @staticmethod
    def _as_given(run: RunData) -> Run:
        return as_run(run)

    @property
    def results(self) -> Results:
        """The finished runs with their statistics; they do not change when the study runs on.

        Raises:
            StudyError: the study has not been run.
        """
        return cast("Results", super().results)

    def compare(
        self,
        indicator: str,
        baseline: Mapping[str, Any] | None = None,
        method: comparison.Method = "bonferroni",
    ) -> Comparison:
        """Compare designs with a baseline on the same days: see `Results.compare`."""
        return self.results.compare(indicator, baseline, method)

    def main_effects(self, indicator: str) -> MainEffects:
        """Compute main effects of the factors: see `Results.main_effects`."""
        return self.results.main_effects(indicator)
