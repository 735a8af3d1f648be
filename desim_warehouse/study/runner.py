"""Doing the missing runs of a study, each written down as it finishes.

For `Study.run`, `desim study` and every question that does a study.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from time import monotonic
from typing import TypeVar, cast

from desim_warehouse.errors import (
    BatteryError,
    CheckError,
    LayoutError,
    ModelError,
    PolicyError,
    SimulationError,
    StudyError,
)
from desim_warehouse.outcome.indicators import why_no_value
from desim_warehouse.study.design import Point
from desim_warehouse.study.execution import Executor
from desim_warehouse.study.execution.progress import Progress
from desim_warehouse.study.execution.repeats import Repeats
from desim_warehouse.study.execution.store import Store
from desim_warehouse.study.execution.work import Handle, Outcome, Wanted
from desim_warehouse.study.file import Until
from desim_warehouse.study.plan import StudyPlan, models, run_seed
from desim_warehouse.study.statistics.procedure import Procedure
from desim_warehouse.study.table import Row

T = TypeVar("T")
LOG = logging.getLogger("desim_warehouse")
_WRITE_EVERY = 10.0  # seconds between writes of the table
_CANNOT_GO_ON = tuple(f"{kind.__name__}: " for kind in SimulationError.__subclasses__())
_CANNOT_WORK = tuple(f"{kind.__name__}: " for kind in (CheckError, LayoutError, ModelError))


def ran_flat(row: Row) -> bool:
    """Whether a run ended because a robot ran flat."""
    return (row.outcome.error or "").startswith(f"{BatteryError.__name__}: ")


def could_not_go_on(row: Row) -> bool:
    """Whether a run ended because it could not go on: a robot ran flat, or work stalled."""
    return (row.outcome.error or "").startswith(_CANNOT_GO_ON)


def is_refused(outcome: Outcome) -> bool:
    """Whether a run ended with an error that every run of its design has: a model or a policy that cannot work."""
    error = outcome.error or ""
    unmade = error.startswith(f"{PolicyError.__name__}: ") and " at time " not in error
    return unmade or error.startswith(_CANNOT_WORK)


class _MissingError(Exception):
    """Raised where a run has not been done yet."""


class StudyRunner:
    """Runs designs by point and replication, without repeating runs that the store has."""

    def __init__(
        self,
        plan: StudyPlan,
        store: Store,
        points: list[Point],
        keys: Mapping[int, str] | None = None,
        executor: Executor | None = None,
        progress: Progress | None = None,
        write: Callable[[list[Row]], None] = lambda _: None,
        repeats: Repeats | None = None,
    ) -> None:
        self.plan = plan
        self.store = store
        self.points = points
        self.executor = executor  # None: nothing is simulated
        self.progress = progress or Progress(plan.name, shown=False)
        self.write = write
        self.repeats = repeats
        self.refused: set[str] = set()  # names of models that no run can simulate
        self.own: dict[int, list[str]] = {}  # policies of the user's own, by point
        self.deterministic = False  # chance plays no part in any design, by what the models say
        if keys is None:
            made = models(plan, points)
            keys = {number: plan.run_name(model) for number, model in made.items()}
            self.deterministic = all(model.is_deterministic for model in made.values())
            self.own = {number: model.policies.own() for number, model in made.items()}
        self.keys = dict(keys)  # the name of a point's model in the store
        self.replications = dict.fromkeys(self.keys, 0)  # asked for, by point
        self.written = monotonic()

    def add(self, plan: StudyPlan, point: Point) -> None:
        """Go on with a plan that has one point more, which need not have runs; raises ModelError if it has no model."""
        model = models(plan, [point])[point.number]
        self.keys[point.number], self.own[point.number] = plan.run_name(model), model.policies.own()
        self.replications[point.number] = 0
        self.plan = plan
        self.points.append(point)

    def replicate(self) -> Iterator[Row]:
        """Do all replications of all points, and yield their rows as they end, finished ones first."""
        rule = self.plan.replications
        if isinstance(rule, Until):
            self.progress.is_search = True
            yield from self._until(rule)
            return
        counts = rule if isinstance(rule, tuple) else (rule,) * len(self.points)
        yield from self.each([(point.number, r) for point in self.points for r in range(counts[point.number])])

    def recall(self) -> bool:
        """Replay the study as far as its runs are there, so that `finished` has them; returns whether all are."""
        executor, self.executor = self.executor, None
        try:
            for _ in self.replicate():
                pass
        except _MissingError:
            return False
        finally:
            self.executor = executor
        return True

    def follow(
        self,
        make: Callable[[bool], Procedure[T]],
        indicator: str,
        *,
        flat: float | None = None,
        failed: float | None = None,
    ) -> T:
        """Carry out a sequential procedure: simulate every batch it asks for, and send it the values.

        Args:
            make: makes it, told whether the models are deterministic, so that one run is exact. Where runs show that
                to be wrong, it is made anew; the runs that are done count.
            indicator: whose values it is sent.
            flat: the value of a run that ended because a robot ran flat, or None for an error like any other.
            failed: the value of a run that could not go on for any reason, or None for an error.
        """
        self.progress.is_search = True
        exact, drew, first = self.deterministic, False, True
        procedure, values = make(exact), cast("list[float] | None", None)
        while True:
            try:
                asked = next(procedure) if values is None else procedure.send(values)
            except StopIteration as end:
                return cast("T", end.value)
            self.ask(asked)
            self._see_that_none_is_refused(asked)
            drew = drew or any(self._drew(*run) for run in asked)
            if (exact and drew) or (first and not exact and not drew):
                exact = not exact
                procedure, values = make(exact), None
            else:
                values = [self._value(*run, indicator, flat, failed) for run in asked]
            first = False

    def _see_that_none_is_refused(self, asked: Iterable[tuple[int, int]]) -> None:
        """Raise StudyError if a run was refused, as the other runs of its design are then not done."""
        for number, replication in asked:
            row = self.row_if_done(number, replication)
            if row is not None and is_refused(row.outcome):
                raise StudyError(f"{self.points[number]}, replication {replication} failed: {row.outcome.error}")

    def _drew(self, number: int, replication: int) -> bool:
        """Whether a run that ended drew random numbers."""
        outcome = self.row(number, replication).outcome
        return outcome.error is None and not outcome.deterministic

    def _value(self, number: int, replication: int, indicator: str, flat: float | None, failed: float | None) -> float:
        """Return the indicator of a run; `flat` or `failed` replaces it where the run could not go on."""
        row = self.row(number, replication)
        if flat is not None and ran_flat(row):
            return flat
        if failed is not None and could_not_go_on(row):
            return failed
        if row.outcome.error is not None:
            raise StudyError(f"{self.points[number]}, replication {replication} failed: {row.outcome.error}")
        value = row.measured(indicator)
        stands_for_failure = failed is not None and math.isnan(failed) and indicator != "T"
        if math.isnan(value) and not stands_for_failure:
            raise StudyError(
                f"{self.points[number]}, replication {replication}: no value of {indicator}, as "
                f"{why_no_value(indicator)}; try a longer run"
            )
        return value

    def ask(self, runs: Iterable[tuple[int, int]]) -> None:
        """Do the runs of these (point, replication) that are missing."""
        for _ in self.each(runs):
            pass

    def each(self, runs: Iterable[tuple[int, int]]) -> Iterator[Row]:
        """Do the missing runs of these (point, replication), and yield all rows, finished runs first."""
        present: list[tuple[int, int]] = []
        missing: dict[tuple[str, int], list[tuple[int, int]]] = {}  # the same run may be asked for at several points
        for number, replication in runs:
            if self._is_refused(number):
                continue
            self.replications[number] = max(self.replications[number], replication + 1)
            name = self.keys[number], run_seed(self.plan.seed, replication)
            lacks = name in missing or self.store.missing(*name)
            (missing.setdefault(name, []) if lacks else present).append((number, replication))
        if self.executor is None:
            if missing:
                raise _MissingError
            return
        if missing:
            self._has_functions()
        looked = sum(asked > 0 for asked in self.replications.values())
        self.progress.want(len(missing), len({(self.keys[n], r) for n, r in present}), looked)
        LOG.debug("%s: %d runs to do, %d there already", self.plan.name, len(missing), len(present))
        yield from (self.row(*run) for run in present)
        names: dict[Handle, tuple[str, int]] = {}
        try:
            for name, requests in missing.items():
                wanted = Wanted(
                    requests[0][0],
                    self.points[requests[0][0]].overrides,
                    name[1],
                    scout=self.plan.scouts,
                    own=self.plan.own,
                )
                names[self.executor.submit(self.plan.base, wanted)] = name
            with closing(self.executor.ended(list(names))) as ended:
                for handle in ended:
                    if handle.outcome is not None:  # else another run of its design was refused
                        self._take(handle, handle.outcome, names)
                        yield from (self.row(*run) for run in missing[names[handle]])
        finally:
            for handle in names:
                handle.cancel()

    def _has_functions(self) -> None:
        """Refuse to simulate where the user's own indicators are known by their values alone; raises StudyError."""
        lost = [indicator.name for indicator in self.plan.own if indicator.function is None]
        if lost:
            cure = f"make the study in Python again, with indicators={{{lost[0]!r}: ...}} and this folder"
            raise StudyError(
                f"indicator {lost[0]}: its function is not in the folder, so no more runs can be done; {cure}"
            )

    def _take(self, done: Handle, outcome: Outcome, names: Mapping[Handle, tuple[str, int]]) -> None:
        """Keep a run that has ended; of a design that is refused no other run is done."""
        model, seed = names[done]
        self.store.add(model, seed, outcome)
        if is_refused(outcome):
            self.refused.add(model)
            for other, (its, _) in names.items():
                if its == model:
                    other.cancel()
        if outcome.error is not None:
            LOG.warning("%s: a run failed: %s", self.points[done.wanted.design], outcome.error)
        self._repeat((model, seed), done)
        self.progress.step(failed=outcome.error is not None)
        if monotonic() - self.written > _WRITE_EVERY:
            self.write(self.finished())
            self.written = monotonic()

    def _repeat(self, name: tuple[str, int], done: Handle) -> None:
        """Repeat the first run that has policies of the user's own, and compare such runs as they end."""
        own = self.own.get(done.wanted.design)
        if self.repeats is not None and own:
            self.repeats.begin(own, name, done)
            self.see_that_runs_repeat()

    def see_that_runs_repeat(self, *, wait: bool = False) -> None:
        """Raise StudyError where a repeated run differed; it is done anew when the study goes on."""
        wrong = None if self.repeats is None else self.repeats.wrong(wait=wait)
        if wrong is not None:
            (model, seed), why = wrong
            self.store.add(model, seed, Outcome({}, 0.0, why, final=False))
            raise StudyError(why)

    def _is_refused(self, number: int) -> bool:
        """Whether a run of a design was refused, as every other would be."""
        return self.keys[number] in self.refused or self._first_is_refused(number, final=True)

    def _first_is_refused(self, number: int, *, final: bool = False) -> bool:
        first = self.store.get(self.keys[number], run_seed(self.plan.seed, 0))
        return first is not None and is_refused(first) and (first.final or not final)

    def row_if_done(self, number: int, replication: int) -> Row | None:
        """Return a run if it is finished, else None."""
        seed = run_seed(self.plan.seed, replication)
        outcome = self.store.get(self.keys[number], seed)
        return None if outcome is None else Row(self.points[number], replication, seed, outcome)

    def row(self, number: int, replication: int) -> Row:
        """Return a finished run that was asked for."""
        row = self.row_if_done(number, replication)
        assert row is not None
        return row

    def finished(self) -> list[Row]:
        """Return the finished runs of the study, by point and replication."""
        counts = {number: 1 if self._first_is_refused(number) else many for number, many in self.replications.items()}
        runs = (self.row_if_done(number, r) for number, many in counts.items() for r in range(many))
        return [row for row in runs if row is not None]

    def _until(self, rule: Until) -> Iterator[Row]:
        """Replicate each point until its mean is known well enough, or its cap is reached."""
        from desim_warehouse.study.statistics.precision import PrecisionRule, replications_to_run

        precision = PrecisionRule(rule.half_width, rule.confidence, rule.minimum, rule.cap)
        have = dict.fromkeys(self.keys, 0)
        more = dict.fromkeys(self.keys, rule.minimum)
        while more:
            yield from self.each([(n, r) for n, m in more.items() for r in range(have[n], have[n] + m)])
            for number, count in list(more.items()):
                have[number] += count
                rows = [row for r in range(have[number]) if (row := self.row_if_done(number, r)) is not None]
                good = [row for row in rows if row.outcome.error is None]
                values = [row.measured(rule.indicator) for row in good]
                fixed = bool(good) and all(row.outcome.deterministic for row in good)
                further = replications_to_run(values, precision, deterministic=fixed)
                next_ones = min(further, rule.cap - have[number])
                hopeless = all(row.outcome.error is not None for row in rows[-count:])
                if next_ones < 1 or hopeless:
                    del more[number]
                else:
                    more[number] = next_ones
