"""Search for bottlenecks, for `desim why`: the gain of relieving each suspect, by simulation.

Suspects come from the account of time of a run, longest waits first. A wait at one point need not cost anything, since
a queue elsewhere might grow instead. So every suspect is relieved by changing keys of the model, on the same days, and
gains are compared for equal doses (`suspects.Suspect.scale`). If nothing is wrong, that is the answer.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from statistics import fmean
from typing import Any

from desim_warehouse.errors import SimulationError, StudyError
from desim_warehouse.model import Model, Source, as_model
from desim_warehouse.model.facts.workers import Load
from desim_warehouse.outcome.account import BATCHED, UNTAKEN, share_of_tasks
from desim_warehouse.outcome.chains import Root, lost_to
from desim_warehouse.outcome.indicators import find
from desim_warehouse.outcome.loads import loads
from desim_warehouse.outcome.verdicts import Verdict
from desim_warehouse.run import RunData
from desim_warehouse.states import APART, AT_START, TIMES, WAITING
from desim_warehouse.study.runner import could_not_go_on
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.effects import Gain, Gains, gains_steps
from desim_warehouse.study.statistics.intervals import Estimate
from desim_warehouse.study.statistics.limits import RELIEVED
from desim_warehouse.study.statistics.procedure import Procedure
from desim_warehouse.study.study import StudyEngine, searched
from desim_warehouse.study.suspects import MOST_UNTAKEN, Suspect, impossible, left_out, suspects
from desim_warehouse.world.robots.settled import SettledFleets

LEAST = 0.01
"""Part of the indicator's mean that matters."""
LEAST_IDLE, MOST_WAITING = 0.25, 0.02
"""Shares of the fleet's time: robots idle for at least the first and waiting for at most the second are not held up."""
MOST_LATE = 0.02
"""Share of tasks that may be late: one bad day in twenty is no bottleneck, nor are a few distant places."""


@dataclass(frozen=True)
class Failure:
    """Runs of a design that could not go on: their number, and the error of one of them."""

    failed: int
    runs: int
    text: str


@dataclass(frozen=True)
class Health:
    """The state of a warehouse without changes, by the means of its runs.

    `idle`, `waiting`: shares of the fleet's time. `on_time`: share of the tasks; None where no tasks are due.
    `untaken`: share of the tasks' time in which they wait for a batch or a robot, in the run that was looked at.
    """

    idle: float
    waiting: float
    on_time: float | None
    untaken: float

    @property
    def is_held_up(self) -> bool:
        """Whether many tasks are late (where none is due: wait for robots), robots wait, or few of them are idle."""
        late = self.untaken > MOST_UNTAKEN if self.on_time is None else self.on_time < 1 - MOST_LATE
        return late or self.waiting > MOST_WAITING or self.idle < LEAST_IDLE


@dataclass(frozen=True)
class HeldUp:
    """The suspects that may hold a warehouse up, each with the gain of its relief.

    Competing suspects come first, ordered by their gain for an equal dose.

    Attributes:
        left_out: reliefs that could not be tried, with the reason.
        as_it_is: the indicator of the warehouse without changes.
        state: the health of the warehouse, if tasks arrive and it keeps up with them.
        failures: runs that could not go on, by number of the change (0: no change); if runs without a change failed,
            no other attribute is set.
        verdicts: verdicts on the run that was looked at.
        lost: in that run, for each root of waiting the share of the fleet's time lost to it, most first.
        batched: in that run, the share of the tasks' time in which they waited for a batch to fill.
        loads: in that run, how busy each group was.
        impossible: those reliefs of `left_out` with which nothing can be simulated.
    """

    model: Model
    indicator: str
    ranked: tuple[tuple[Suspect, Gain], ...]
    gains: Gains
    seed: int = 0
    as_it_is: Estimate | None = None
    left_out: tuple[str, ...] = ()
    state: Health | None = None
    failures: Mapping[int, Failure] = field(default_factory=dict)
    verdicts: Sequence[Verdict] = ()
    lost: Mapping[Root, float] = field(default_factory=dict)
    batched: float = 0.0
    loads: tuple[Load, ...] = ()
    impossible: tuple[str, ...] = ()

    @property
    def is_clear(self) -> bool:
        """Whether one suspect is shown to cost most, even if it is unclear which of its reliefs gains most."""
        competing = [(suspect.name, gain) for suspect, gain in self.ranked if gain.competes]
        if not competing:
            return False
        (name, most), *others = competing
        return most.low > 0 and all(other == name or gain.beaten for other, gain in others)

    @property
    def is_held_up(self) -> bool:
        """Whether anything needs mending: False where all tasks are on time, and robots are idle and hardly wait."""
        return self.state is None or self.state.is_held_up


def usual_indicator(run: RunData) -> str:
    """Return the default indicator in which costs are counted: throughput where work always waits or is not done.

    Where loads pile up before workers, it is the number of loads worked on; where all work is done, the time that the
    work, or a task, takes.
    """
    overloaded = any(verdict.code == "CANNOT_KEEP_UP" for verdict in run.verdicts)
    tasks = run.model.tasks
    if (tasks.never_end and not tasks.arrive) or overloaded or math.isnan(run.kpis["T"]):
        return "worked" if run.kpis.get("work_backlog", 0) > run.model.fleet.size else "throughput_per_hour"
    return "cycle_time_mean" if run.model.tasks.never_end else "T"


def held_up(source: RunData | Source, indicator: str | None = None, search: Search = USUAL) -> HeldUp:
    """Relieve each suspect of a run in turn and simulate the relieved model, on the same days for all.

    Args:
        source: a run with `log: all`, or a model or its file, which is then simulated once.
        indicator: indicator in which costs are counted (default: `usual_indicator`).
        search: how runs are done.

    Raises:
        StudyError: an indicator of which neither less nor more is better, or a run that failed but could have gone on.

    Source: `statistics.gains_steps`.
    """
    with search.simulating() as crew:
        return _held_up(source, indicator, replace(search, crew=crew), crew.fleets)


def _held_up(source: RunData | Source, indicator: str | None, search: Search, fleets: SettledFleets) -> HeldUp:
    try:
        run = (
            source
            if isinstance(source, RunData)
            else RunData.simulated(as_model(source, {"log": "all"}), search.seed, fleets=fleets)
        )
    except SimulationError as error:
        nothing = Gains((), math.nan, math.nan, search.confidence, 1, failed=1)
        model = source.model if isinstance(source, RunData) else as_model(source)
        failure = Failure(1, 1, f"{type(error).__name__}: {error}")
        return HeldUp(model, indicator or "", (), nothing, search.seed, failures={0: failure})
    name = indicator or usual_indicator(run)
    return _relieved(run, name, search)


def _relieved(run: RunData, name: str, search: Search) -> HeldUp:
    """Simulate the relief of each suspect of a run, and rank the gains in an indicator."""
    looked_at = suspects(run)
    gains, study = _contest(run, name, looked_at, search)
    first, cap = search.looks(*RELIEVED)
    lasts = run.model.tasks.arrive and not any(verdict.is_lasting for verdict in run.verdicts)
    untaken = share_of_tasks(run.history, *UNTAKEN)
    well = lasts and not _state([run.kpis], untaken).is_held_up
    ranked = gains(first if well else cap)
    as_it_is = [row.indicators for row in study.rows if not row.point.number and row.outcome.error is None]
    state = _state(as_it_is, untaken) if lasts and as_it_is else None
    if well and (state is None or state.is_held_up):  # on other days it does worse than on the first
        ranked = gains(cap)
    failures = _failures(study)
    if ranked.failed and 0 not in failures:
        raise StudyError(f"indicator {name!r}: {ranked.failed} runs of the model as it is have no value of it")
    return HeldUp(
        run.model,
        name,
        tuple((looked_at[gain.change - 1], gain) for gain in ranked.gains),
        ranked,
        search.seed,
        study.results.estimate(study.results.by_point[0], name),
        tuple(left_out(run)),
        state,
        failures,
        run.verdicts,
        {root: time / (run.history.counted * run.model.fleet.size) for root, (time, _) in lost_to(run.history).items()},
        share_of_tasks(run.history, BATCHED),
        loads(run.history, run.kpis),
        tuple(impossible(run)),
    )


def _contest(
    run: RunData,
    name: str,
    looked_at: list[Suspect],
    search: Search,
) -> tuple[Callable[[int], Gains], StudyEngine]:
    """Make the study that relieves each suspect, and a function that finds the gains in so many replications."""
    better = find(name).better
    if better is None:
        raise StudyError(f"indicator {name!r}: neither less nor more of it is better, so nothing can cost anything")
    cases: dict[str, Any] = {"as it is": {}, **{suspect.relief: dict(suspect.overrides) for suspect in looked_at}}
    study = searched(run.model, {"relief": {"cases": cases}}, search, name="why")
    first, _ = search.looks(*RELIEVED)
    base = abs(run.kpis[name]) or 1.0
    scales = [None if suspect.beside else suspect.scale for suspect in looked_at]

    def gains(most: int) -> Gains:
        def steps(exact: bool) -> Procedure[Gains]:
            return gains_steps(
                scales,
                LEAST * base,
                search.confidence,
                maximise=better == "more",
                first=first,
                cap=most,
                deterministic=exact,
            )

        return study.follow(steps, name, failed=math.nan, search=search)

    return gains, study


def _state(runs: Sequence[Mapping[str, float]], untaken: float) -> Health:
    """Return the health of the warehouse, by the indicators of its runs."""

    def mean(names: Iterable[str]) -> float:
        return fmean(math.fsum(kpis.get(f"share_{name}", 0.0) for name in names) for kpis in runs)

    waits = {WAITING.name, *APART, *(name for name, state in TIMES.items() if state.queue is not None)}
    due = [kpis["on_time"] for kpis in runs if math.isfinite(kpis.get("on_time", math.nan))]
    return Health(mean([AT_START]), mean(waits), fmean(due) if due else None, untaken)


def _failures(study: StudyEngine) -> dict[int, Failure]:
    """Return the runs that could not go on, by the number of their design."""
    failures = {}
    for number, rows in study.results.by_point.items():
        failed = [row for row in rows if could_not_go_on(row)]
        if failed:
            failures[number] = Failure(len(failed), len(rows), failed[0].outcome.error or "")
    return failures
