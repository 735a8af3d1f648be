"""A what-if study: many runs of changed models, kept as they finish, judged by statistics."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, TypeVar

from desim_warehouse.errors import StudyError, number_of
from desim_warehouse.folders import ANSWER, JOURNAL, RESULTS
from desim_warehouse.model import Model
from desim_warehouse.study.design import Rule
from desim_warehouse.study.execution import Executor
from desim_warehouse.study.execution.progress import Progress
from desim_warehouse.study.execution.store import Store
from desim_warehouse.study.factors import Level
from desim_warehouse.study.plan import StudyPlan
from desim_warehouse.study.results import ResultsData
from desim_warehouse.study.runner import StudyRunner
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.procedure import Procedure
from desim_warehouse.study.table import Row, arrow, columns, is_damaged, write_results
from desim_warehouse.study.warm_up import PILOT, settle_designs

if TYPE_CHECKING:
    import pandas as pd

    from desim_warehouse.run import RunData


T = TypeVar("T")
LOG = logging.getLogger("desim_warehouse")
LOG.addHandler(logging.NullHandler())  # silent unless a program adds a handler


class StudyEngine:
    """Many runs of one model with varied factors: call `run()`, then look at `table` and `summary()`.

    `questions.study.Study` is what users hold: its results answer in words.
    """

    _results_type: ClassVar[type[ResultsData]] = ResultsData
    """What `results` gives."""

    def __init__(  # every key of a study file is an argument, with its meaning
        self,
        base: str | Path | Mapping[str, Any] | Model,
        factors: Mapping[str, Any] | None = None,
        *,
        replications: int | Mapping[str, Any] = 1,
        seed: int = 0,
        indicators: Sequence[str] | Mapping[str, Callable[[Any], float]] | None = None,
        baseline: Mapping[str, Any] | None = None,
        design: Rule = "grid",
        changes: Mapping[str, Any] | None = None,
        confidence: float = 0.95,
        target: str | None = None,
        timeout: float | None = None,
        name: str = "study",
        description: str = "",
        warm_up: Literal["auto"] | None = None,
    ) -> None:
        """Plan a study, without running anything yet.

        Args:
            base: a model, its file, or its content.
            factors: key of the model -> its values, in any form of a study file (`study.design`).
            replications: of each design, or `{"indicator": "T", "half_width": 0.02}`: until the mean is known.
            seed: of the study. Replication r has the same run seed, and random streams, in every design.
            indicators: columns of the table (default: all); or further ones of your own, each a function of a run.
            baseline: values of factors that pick the design to compare with (default: the first).
            design: grid, or paired: the first values of all factors, then the second ones, ...
            changes: changes to the model for all runs (`set` of a study file).
            confidence: of intervals.
            target: what designs should meet, such as "on_time >= 95 %"; reports name those that do.
            timeout: seconds that a run may take.
            name: for tables and messages.
            description: a sentence or two.
            warm_up: auto: each design has its own `run.warm_up`, from five pilot runs of it (`warm_up.settle_designs`).

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
                "indicators": None if indicators is None or isinstance(indicators, Mapping) else list(indicators),
                "baseline": baseline,
                "confidence": confidence,
                "target": target,
                "timeout": timeout,
                "warm_up": warm_up,
            },
        )
        if isinstance(indicators, Mapping):
            self.plan = self.plan.measuring(indicators, self._as_given)
        self._start()

    @classmethod
    def of(cls, plan: StudyPlan) -> Self:
        """Create a study from a plan."""
        study = cls.__new__(cls)
        study.plan = plan
        study._start()  # noqa: SLF001 - our own
        return study

    @classmethod
    def read(cls, path: str | Path, overrides: Mapping[str, Any] | None = None) -> Self:
        """Read a study file such as studies/fleet_size.yaml, and apply further changes to its model."""
        from desim_warehouse.study.reading import read_study

        return cls.of(read_study(path, overrides))

    @classmethod
    def open(cls, folder: str | Path) -> Self:
        """Open the study in a folder with its finished runs, without simulating anything.

        Raises:
            StudyError: where there is no study.
        """
        results = cls._results_type.load(folder)
        study = cls.of(results.plan)
        study.notes += results.notes
        study._results = results  # noqa: SLF001 - our own
        return study

    @staticmethod
    def _as_given(run: RunData) -> Any:
        """Return a run in the form that the user's own indicators receive."""
        return run

    def _start(self) -> None:
        self.points = self.plan.points()
        self.notes: list[str] = []
        self.folder: Path | None = None
        self._results: ResultsData | None = None

    # Running

    def run(
        self,
        *,
        workers: int | str = 1,
        cluster: str | None = None,
        out: str | Path | None = None,
        cache: bool = False,
        progress: bool = False,
    ) -> Self:
        """Simulate the missing runs; results do not depend on the number of workers.

        Args:
            workers: see `Search`, as for all of these.
            cluster: a Dask scheduler.
            out: the study folder.
            cache: whether runs are kept without one.
            progress: whether progress is shown.

        Returns:
            The study itself.

        Raises:
            StudyError: where no run finished, runs with a policy of the user's own cannot be done again, or the folder
                or the cluster cannot be used. Finished runs are kept. Where some runs failed there is a warning.
            KeyboardInterrupt: on Ctrl-C, after finished runs are stored.
        """
        self.run_by(Search(workers=workers, cluster=cluster, out=out, cache=cache, progress=progress))
        errors = [row.outcome.error for row in self.rows if row.outcome.error is not None]
        if errors and len(errors) == len(self.rows):
            raise StudyError(f"{self.plan.name}: no run finished: {errors[0]}")
        if errors:
            failed = f"{len(errors)} of {number_of(len(self.rows), 'run')} failed (see the column error)"
            warnings.warn(f"{self.plan.name}: {failed}: {errors[0]}", RuntimeWarning, stacklevel=2)
        return self

    def run_by(self, search: Search) -> Self:
        """Simulate the missing runs with the settings of a search."""
        with self.session(search) as runner:
            runner.recall()
            for _ in runner.replicate():
                pass
        return self

    def stream(
        self,
        *,
        workers: int | str = 1,
        cluster: str | None = None,
        out: str | Path | None = None,
        cache: bool = False,
        progress: bool = False,
    ) -> Generator[Row]:
        """Yield the rows of the study as runs end, finished ones first, for callers that show or judge each row.

        Closing the generator ends the study at once: what is not finished is cancelled, what ended is kept.

            for row in study.stream(workers=2):
                print(row.point, row.value("T"))

        Args:
            workers: as of `run`, as all of these.
            cluster: a Dask scheduler.
            out: the study folder.
            cache: whether runs are kept without one.
            progress: whether progress is shown.

        Raises:
            StudyError: where the folder or the cluster cannot be used. Finished runs are kept.
        """
        search = Search(workers=workers, cluster=cluster, out=out, cache=cache, progress=progress)
        with self.session(search) as runner:
            yield from runner.replicate()

    def follow(
        self,
        make: Callable[[bool], Procedure[T]],
        indicator: str,
        *,
        failed: float | None = None,
        search: Search = USUAL,
    ) -> T:
        """Carry out a sequential procedure (`statistics`), which asks for the runs it needs.

        The runs become part of the study: `table` and `summary` have them. `make`, `indicator` and `failed` are as of
        `StudyRunner.follow`.

        Raises:
            StudyError: a run that was asked for failed.
        """
        with self.session(search) as runner:
            return self.carry_out(runner, make, indicator, failed=failed)

    def carry_out(self, runner: StudyRunner, make: Callable[[bool], Procedure[T]], indicator: str, **how: Any) -> T:
        """Carry out a procedure with the `runner` of a session that is open; arguments as of `StudyRunner.follow`."""
        runner.recall()
        result = runner.follow(make, indicator, **how)
        self.plan = replace(self.plan, replications=tuple(runner.replications.values()))
        return result

    def grow(self, runner: StudyRunner, label: str, overrides: Mapping[str, Any]) -> int:
        """Give the one factor of this study another level, in an open session; returns the number of its design.

        Raises:
            ModelError: where that is no model.
        """
        (factor,) = self.plan.factors
        levels = (*factor.levels, Level(label, overrides, ()))
        counts = (*runner.replications.values(), 0)
        plan = replace(self.plan, factors=(replace(factor, levels=levels),), replications=counts)
        point = plan.points()[-1]
        runner.add(plan, point)
        self.plan = plan
        return point.number

    @contextmanager
    def session(self, search: Search = USUAL) -> Iterator[StudyRunner]:
        """The runner of this study, for procedures that choose runs.

        However the block ends, finished runs are in the folder, or in the user's cache, and in `results`.
        """
        from desim_warehouse.study.execution.cache import Cache
        from desim_warehouse.study.record import write_record

        self.folder = None if search.out is None else Path(search.out)
        with (
            search.simulating() as crew,
            crew.interrupts,
            Progress(self.plan.name, shown=search.progress) as shown,
            Store(
                self.folder,
                self._say(shown),
                cache=Cache(self._say(shown)) if search.cache and self.folder is None else None,
            ) as store,
        ):
            executor = crew.executor(self.plan.timeout, self._say(shown))
            if self.plan.warm_up == "auto":
                self._settle(executor, shown)
            runner = StudyRunner(self.plan, store, self.points, None, executor, shown, self._write, crew.repeats)
            if self.folder is not None:
                (self.folder / ANSWER).unlink(missing_ok=True)  # of fewer runs, or to another question
                if is_damaged(self.folder / RESULTS):
                    self._say(shown)(f"{self.folder / RESULTS}: damaged; rebuilt from {JOURNAL}")
                write_record(self.plan, self.points, runner.keys, self.folder)
            before = self.plan
            try:
                yield runner
                runner.see_that_runs_repeat(wait=True)
            except BaseException:
                store.reload()
                raise
            finally:
                self._write(runner.finished())
            if self.folder is not None and self.plan is not before:
                write_record(self.plan, self.points, runner.keys, self.folder)
            shown.print(shown.summary())
            LOG.info("%s: %s", self.plan.name, shown.summary())

    def _settle(self, executor: Executor, shown: Progress) -> None:
        """Give each design its warm-up, from the study's folder or from pilot runs."""
        from desim_warehouse.study.record import recorded_warm_up

        times = None if self.folder is None else recorded_warm_up(self.plan, self.folder)
        if times is None:
            shown.want(PILOT * len(self.points), 0)
            times, remarks = settle_designs(
                self.plan, self.points, executor, lambda outcome: shown.step(failed=outcome.error is not None)
            )
            for remark in remarks:
                self._say(shown)(remark)
        self.plan = replace(self.plan, warm_up=times)
        self.points = self.plan.points()

    def _say(self, shown: Progress) -> Callable[[str], None]:
        def say(text: str) -> None:
            self.notes.append(text)
            LOG.warning("%s: %s", self.plan.name, text)
            shown.print(text)

        return say

    def _write(self, rows: list[Row]) -> None:
        """Store the results as they are now."""
        from desim_warehouse.study.execution.cache import versions

        self._results = self._results_type(
            self.plan, tuple(self.points), tuple(rows), versions(), self.folder, tuple(self.notes)
        )
        if self.folder is not None:
            table = arrow(columns(rows, self._results.factors, self.plan.indicators))
            write_results(table, self.folder / RESULTS)

    # Looking

    @property
    def results(self) -> ResultsData:
        """The finished runs, and the results that follow. They do not change when the study runs on.

        Raises:
            StudyError: where the study has not been run.
        """
        if self._results is None:
            raise StudyError("this study has not been run: call run() first")
        return self._results

    @property
    def rows(self) -> Sequence[Row]:
        """The finished runs, none before the study is run."""
        return () if self._results is None else self._results.rows

    @property
    def table(self) -> pd.DataFrame:
        """One row per run: factors under their key, replication, seed, indicators, deterministic, run_time, error.

        Raises:
            StudyError: where the study has not been run.
        """
        return self.results.table

    @property
    def deterministic(self) -> bool:
        """Whether no run drew a random number or used a policy of the user's own: one replication is enough."""
        return self._results is not None and self._results.deterministic

    def summary(self, indicators: Sequence[str] | None = None) -> pd.DataFrame:
        """Mean, half-width, median and quantiles of each indicator at each design point, as a tidy table."""
        return self.results.summary(indicators)

    def __repr__(self) -> str:
        """Name, designs and finished runs."""
        return f"Study({self.plan.name}: {len(self.points)} designs, {len(self.rows)} runs)"


def searched(base: Model, factors: Mapping[str, Any], search: Search, **content: Any) -> StudyEngine:
    """Make a study whose runs a search chooses one by one; `content`: further keys of a study file."""
    made = StudyEngine(
        base, factors, confidence=search.confidence, timeout=search.timeout, **{"seed": search.seed, **content}
    )
    made.plan = made.plan.unreplicated()
    return made
