"""A what-if study: many runs of changed models, kept as they finish, judged by statistics."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from desim_warehouse.errors import StudyError
from desim_warehouse.study.laboratory import Laboratory
from desim_warehouse.study.progress import Progress
from desim_warehouse.study.results import Row, arrow, columns, is_damaged, write_results
from desim_warehouse.study.store import JOURNAL, RESULTS, Store

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    import pandas as pd
    import pyarrow as pa

    from desim_warehouse.model import Model
    from desim_warehouse.study.plan import Plan
    from desim_warehouse.study.statistics import (
        Comparison,
        FirstOrder,
        MainEffects,
        Procedure,
        SobolIndices,
    )

T = TypeVar("T")


class Study:
    """Many runs of one model, changed factor by factor: `run()` it, then look at `table` and `summary()`.

    study = dw.Study("models/multibots.yaml", {"fleet.size": range(1, 7)}, replications=20)
    study.run(workers=2, out="reports/out/fleet")
    study.summary(["T", "S"])
    """

    def __init__(
        self,
        base: str | Path | Mapping[str, Any] | Model,
        factors: Mapping[str, Any] | None = None,
        *,
        replications: int | Mapping[str, Any] = 1,
        seed: int = 0,
        indicators: Sequence[str] | None = None,
        baseline: Mapping[str, Any] | None = None,
        design: str | Mapping[str, int] = "grid",
        changes: Mapping[str, Any] | None = None,
        confidence: float = 0.95,
        timeout: float | None = None,
        name: str = "study",
        description: str = "",
    ) -> None:
        """Plan a study; nothing is run yet.

        Args:
            base: a model, its file, or its content.
            factors: key of the model -> its values, in any form of a study file (`study.design`).
            replications: of each design; or `{"indicator": "T", "half_width": 0.02}`: until the mean is known.
            seed: of the study; replication r has the same run seed, and random streams, in every design.
            indicators: columns of the table; default: all.
            baseline: values of factors that pick the design to compare with; default: the first.
            design: grid, paired, or a sampled design such as `{"sobol": 64}`.
            changes: changes to the model for all runs (`set` of a study file).
            confidence: of intervals.
            timeout: seconds that a run may take.
            name: for tables and messages.
            description: a sentence or two.

        Raises:
            ModelError: with every problem of the study, its model and its designs.
        """
        from desim_warehouse.study.reading import plan_of

        self.plan = plan_of(
            base,
            {
                "name": name,
                "description": description,
                "set": changes,
                "factors": factors,
                "design": design,
                "replications": replications,
                "seed": seed,
                "indicators": None if indicators is None else list(indicators),
                "baseline": baseline,
                "confidence": confidence,
                "timeout": timeout,
            },
        )
        self._start()

    @classmethod
    def of(cls, plan: Plan) -> Study:
        """A study of a plan that was read already."""
        study = cls.__new__(cls)
        study.plan = plan
        study._start()  # noqa: SLF001 - our own
        return study

    @classmethod
    def read(cls, path: str | Path, overrides: Mapping[str, Any] | None = None) -> Study:
        """The study of a file such as studies/fleet_size.yaml, with further changes to its model."""
        from desim_warehouse.study.reading import read_study

        return cls.of(read_study(path, overrides))

    @classmethod
    def open(cls, folder: str | Path) -> Study:
        """The study of a folder with the runs that are finished; nothing is run.

        Raises:
            StudyError: where there is no study.
        """
        from desim_warehouse.study.record import read_record

        study = cls.of(read_record(Path(folder)))
        with Store(Path(folder), study.notes.append, read_only=True) as store:
            laboratory = Laboratory(study.plan, store, study.points)
            laboratory.recall()
            study.rows = laboratory.finished()
        study.finished = True
        return study

    def _start(self) -> None:
        self.points = self.plan.points()
        self.rows: list[Row] = []
        self.notes: list[str] = []
        self.finished = False
        self.folder: Path | None = None

    # Running

    def run(
        self,
        *,
        workers: int | str = 1,
        cluster: str | None = None,
        out: str | Path | None = None,
        progress: bool = False,
    ) -> Study:
        """Do the runs that are not done yet; the results are the same however many workers do them.

        Args:
            workers: processes on this machine, or `auto`: one for each processor.
            cluster: address of a Dask scheduler such as tcp://10.0.0.1:8786, or `local`.
            out: the study folder; runs there are used again, whatever study they were done for.
            progress: show how far it is, on standard error.

        Returns:
            The study itself.

        Raises:
            StudyError: where the folder or the cluster cannot be used; finished runs are kept.
            KeyboardInterrupt: on Ctrl-C, after what is finished was written down.
        """
        with self.session(workers=workers, cluster=cluster, out=out, progress=progress) as laboratory:
            laboratory.recall()
            laboratory.replicate()
        return self

    def follow(self, procedure: Procedure[T], indicator: str, **where: Any) -> T:
        """Carry out a sequential procedure (`statistics`), which asks for the runs it needs.

        The runs become part of the study: `table` and `summary` have them. `where` is as in `run`.

        Raises:
            StudyError: a run that was asked for failed.
        """
        with self.session(**where) as laboratory:
            laboratory.recall()
            result = laboratory.follow(procedure, indicator)
            self.plan = replace(self.plan, replications=tuple(laboratory.replications.values()))
        return result

    @contextmanager
    def session(
        self,
        *,
        workers: int | str = 1,
        cluster: str | None = None,
        out: str | Path | None = None,
        progress: bool = False,
    ) -> Iterator[Laboratory]:
        """The laboratory of this study, for procedures that choose their runs; arguments as in `run`.

        However it is left, what is finished is in the folder and in `table`.
        """
        from desim_warehouse.study.execution import Opened
        from desim_warehouse.study.record import write_record

        self.folder = None if out is None else Path(out)
        vars(self).pop("table", None)
        with (
            Progress(self.plan.name, shown=progress) as shown,
            Store(self.folder, self._say(shown)) as store,
            Opened(self.plan.base, workers, cluster, self.plan.timeout, self._say(shown)) as execution,
        ):
            laboratory = Laboratory(self.plan, store, self.points, execution, shown, self._write)
            if self.folder is not None:
                if is_damaged(self.folder / RESULTS):
                    self._say(shown)(f"{self.folder / RESULTS}: damaged; made anew from {JOURNAL}")
                write_record(self.plan, self.points, laboratory.keys, self.folder)
            before = self.plan
            try:
                yield laboratory
            except BaseException:
                store.reload()
                raise
            finally:
                self._write(laboratory.finished())
            if self.folder is not None and self.plan is not before:
                write_record(self.plan, self.points, laboratory.keys, self.folder)
            shown.print(shown.summary())

    def _say(self, shown: Progress) -> Callable[[str], None]:
        def say(text: str) -> None:
            self.notes.append(text)
            shown.print(text)

        return say

    def _write(self, rows: list[Row]) -> None:
        """Write down the table as it is now."""
        self.rows = rows
        self.finished = True
        vars(self).pop("table", None)
        if self.folder is not None:
            write_results(self._arrow(self.plan.indicators), self.folder / RESULTS)

    # Looking

    def _arrow(self, indicators: Sequence[str]) -> pa.Table:
        if not self.finished:
            raise StudyError("this study has not been run: call run() first")
        return arrow(columns(self.rows, self._factors, indicators))

    @property
    def _factors(self) -> list[str]:
        return [factor.key for factor in self.plan.factors]

    @cached_property
    def table(self) -> pd.DataFrame:
        """One row per run: factors under their key, replication, seed, indicators, deterministic, run_time, error.

        Raises:
            StudyError: where the study has not been run.
        """
        frame: pd.DataFrame = self._arrow(self.plan.indicators).to_pandas()
        return frame

    @property
    def deterministic(self) -> bool:
        """Whether no run drew a random number or used a policy of the user's own: one replication says it all."""
        outcomes = [row.outcome for row in self.rows if row.outcome.error is None]
        return bool(outcomes) and all(outcome.deterministic for outcome in outcomes)

    def summary(self, indicators: Sequence[str] | None = None) -> pd.DataFrame:
        """Mean, half-width, median and quantiles of each indicator at each design point, as a tidy table."""
        from desim_warehouse.study.summary import summary

        return summary(self, indicators)

    def compare(
        self, indicator: str, baseline: Mapping[str, Any] | None = None, method: str = "bonferroni"
    ) -> Comparison:
        """Paired differences of all designs to the baseline, with intervals that hold all at once."""
        from desim_warehouse.study.summary import comparison

        return comparison(self, indicator, baseline, method)

    def main_effects(self, indicator: str) -> MainEffects:
        """What each factor does on average."""
        from desim_warehouse.study.statistics import main_effects

        return main_effects(self._arrow([indicator]).to_pandas(), self._factors, indicator)

    def first_order(self, indicator: str) -> FirstOrder:
        """The share of the indicator's variance that each factor explains alone, from any design."""
        from desim_warehouse.study.statistics import first_order

        table = self._arrow([indicator]).to_pandas()
        return first_order(table, self._factors, indicator, confidence=self.plan.confidence)

    def sobol(self, indicator: str) -> SobolIndices:
        """First-order and total Sobol indices; the design must be `{"saltelli": n}`."""
        from desim_warehouse.study.summary import sobol

        return sobol(self, indicator)

    def __repr__(self) -> str:
        """What it is, and how far."""
        return f"Study({self.plan.name}: {len(self.points)} designs, {len(self.rows)} runs)"
