"""Procedures that choose the next runs: the race of `desim best`, and the scouts and the judge of `desim size`.

A scout is a pilot run that orders the designs; the judge decides whether a design meets a target.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from desim_warehouse.errors import StudyError, shown
from desim_warehouse.model import Model
from desim_warehouse.outcome.indicators import find
from desim_warehouse.outcome.targets import Target
from desim_warehouse.outcome.verdicts import Verdict, judge_design, piles_up
from desim_warehouse.study.design import Point
from desim_warehouse.study.possible import NotTried, possible_part
from desim_warehouse.study.rare import days_needed, shows
from desim_warehouse.study.runner import StudyRunner, ran_flat
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.cheapest import (
    NOTHING,
    Earlier,
    scout_steps,
)
from desim_warehouse.study.statistics.judge import Budget, Judge, RunsEndedError, looks_of_days
from desim_warehouse.study.statistics.limits import CAP, LEAST_DELTA, MOST_RUNS, RACED, DaysNeeded
from desim_warehouse.study.statistics.procedure import Procedure, request
from desim_warehouse.study.statistics.selection import Selection, kn_steps
from desim_warehouse.study.study import StudyEngine
from desim_warehouse.study.table import Row
from desim_warehouse.study.target import check_zone, first_look
from desim_warehouse.values.arguments import is_finite

FLEET = "fleet.size"
"""The key for which indicators declare in which direction they usually move."""
_AHEAD = 4  # replications of each design requested at a time: enough to keep workers busy
ZONE = 0.01
"""The indifference zone, as a share of the largest of the first means."""


@dataclass(frozen=True)
class Raced:
    """The best design, the designs shown to be less than delta worse, and when others were eliminated.

    `not_tried`: designs that cannot be simulated, which are not in `study`.
    """

    point: Point
    within: tuple[Point, ...]
    indicator: str
    maximise: bool
    selection: Selection
    study: StudyEngine = field(repr=False, compare=False)
    not_tried: tuple[NotTried, ...] = ()

    @property
    def first(self) -> Point:
        """The first design, in the order of the study, among the best and those less than delta worse."""
        return min((self.point, *self.within), key=lambda point: point.number)


def race(
    study: StudyEngine,
    indicator: str,
    delta: float | None = None,
    *,
    share: float = ZONE,
    maximise: bool | None = None,
    search: Search = USUAL,
) -> Raced:
    """Race the designs of a study (KN): designs that are clearly worse by the mean of an indicator drop out early.

    Args:
        study: its designs are the candidates, at its own confidence. Runs that it already has are used.
        indicator: what is compared, one of ours or of the study's own.
        delta: indifference zone in the indicator's unit; None: `share` of the largest mean of the first replications.
        share: a part of that mean.
        maximise: whether more is better (default: as usual for the indicator; of one of its own it must be said).
        search: how runs are done, and how many; confidence, seed and time limit are the study's.

    Raises:
        StudyError: unknown indicator, one of its own without `maximise`, fewer than two designs, or a run that failed.

    Source: KN, Kim & Nelson (2001); see `statistics.kn_steps` for what is promised and assumed.
    """
    is_own = any(indicator == own.name for own in study.plan.own)
    if is_own and maximise is None:
        raise StudyError(f"indicator {indicator!r}: of one of your own, expected maximise=False or True")
    measure = None if is_own else find(indicator)
    if delta is not None and not (is_finite(delta) and delta >= LEAST_DELTA):
        raise StudyError(f"delta {shown(delta):.60}: expected an indifference zone of at least {LEAST_DELTA:g}")
    if delta is not None and measure is not None:
        check_zone(measure, delta)
    more = more_is_better(indicator) if maximise is None else maximise
    study, not_tried = possible_part(study)
    designs = len(study.points)
    if designs < 2:  # noqa: PLR2004
        others = "".join(f"; another cannot be simulated: {item.reason}" for item in not_tried[:1])
        raise StudyError(f"the best of one design: expected factors with several values{others}")
    refuse_other(study, search)
    first, cap = search.looks(*RACED)
    most = search.runs or MOST_RUNS

    def steps(exact: bool) -> Procedure[Selection]:
        begin, end = (2, 2) if exact else (first, cap)  # designs without chance are compared by two runs each
        zone = delta
        if zone is None:
            values = yield from request([(design, rank) for design in range(designs) for rank in range(begin)])
            sums = [abs(sum(values[start : start + begin])) for start in range(0, len(values), begin)]
            zone = max(share * max(sums) / begin, LEAST_DELTA)
        return (
            yield from kn_steps(
                designs,
                zone,
                study.plan.confidence,
                begin,
                maximise=more,
                cap=end,
                most=most,
                ahead=_AHEAD,
                deterministic=exact,
            )
        )

    selection = study.follow(steps, indicator, search=search)
    tied = tuple(study.points[number] for number in selection.within)
    return Raced(study.points[selection.best], tied, indicator, more, selection, study, not_tried)


def refuse_other(study: StudyEngine, search: Search) -> None:
    """Refuse a search whose confidence, seed or timeout differs from the study's own; raises StudyError."""
    for name in ("confidence", "seed", "timeout"):
        value, own = getattr(search, name), getattr(study.plan, name)
        if value not in (own, getattr(USUAL, name)):
            raise StudyError(f"search, {name} {value}: the study has {own}; expected it in the study alone")


def scouted(
    study: StudyEngine,
    goal: Target,
    designs: Sequence[tuple[int, ...]],
    cost: Callable[[tuple[int, ...]], tuple[float, ...]],
    budget: Budget,
    search: Search,
    note: str = "",
    earlier: Earlier = NOTHING,
    beside: Sequence[Target] = (),
    name: Callable[[int], str] = str,
) -> set[int] | None:
    """Find the designs that fail on a single pilot day, which is not one of the days that judge them (`scout_steps`).

    Return None if the budget is exhausted first. Batteries need not settle before such a day (`StudyPlan.scouts`).

    `note`: earlier results, shown with the progress. `name`: function that names a design there. `beside`: further
    targets.
    """
    plan = replace(study.plan, seed=study.plan.seed + 1, name=f"{study.plan.name} scout", scouts=True)
    scout = StudyEngine.of(plan.unreplicated())

    with scout.session(search) as runner:

        def hopeless(number: int) -> bool:
            missed = (not goal.met_by(measured(runner.row(number, 0), goal)) for goal in beside)
            return cannot_last(scout, runner, number) is not None or any(missed)

        def steps(_: bool) -> Procedure[set[int] | None]:
            looked = scout_steps(designs, cost, goal, budget, earlier, hopeless)
            try:
                return (yield from _watched(looked, goal, lambda seen: tell(about(designs, cost, seen, name))))
            except RunsEndedError:
                return None

        def tell(line: str) -> None:
            runner.progress.tell(f"{note}{line}")

        tell("")
        return scout.carry_out(runner, steps, goal.indicator, flat=goal.missed)


def about(
    designs: Sequence[tuple[int, ...]],
    cost: Callable[[tuple[int, ...]], tuple[float, ...]],
    met: Mapping[int, bool],
    name: Callable[[int], str],
) -> str:
    """Return in words the result of single days so far: `about 10 robots + 1 charger`, or `more than 6 robots + ...`.

    Args:
        designs: counts of all designs that could be built.
        cost: sort key of a design by cost.
        met: numbers of the designs simulated, and whether they met the target on their day.
        name: function that names a design.
    """
    enough = [number for number, is_met in met.items() if is_met]
    if enough:
        return f"about {name(min(enough, key=lambda number: cost(designs[number])))}"
    return f"more than {name(max(met, key=lambda number: cost(designs[number])))}" if met else ""


def _watched(
    scouting: Procedure[set[int]], goal: Target, tell: Callable[[Mapping[int, bool]], None]
) -> Procedure[set[int]]:
    """Run a scout (pilot runs), and call `tell` after each run with the designs that met the target in theirs."""
    seen: dict[int, bool] = {}
    try:
        asked = next(scouting)
        while True:
            values = yield asked
            seen |= {number: goal.met_by(value) for (number, _), value in zip(asked, values, strict=True)}
            tell(seen)
            asked = scouting.send(values)
    except StopIteration as end:
        doubted: set[int] = end.value
        return doubted


def judge_of(
    study: StudyEngine,
    runner: StudyRunner,
    goal: Target,
    search: Search,
    *,
    exact: bool,
    before: str = "",
    name: Callable[[int], str] | None = None,
    **how: Any,
) -> Judge:
    """Make the judge of a study's designs in a session; designs that cannot last fail regardless of the target.

    The session's progress shows the verdicts after each look (interim analysis).

    Args:
        study: study with the designs and the confidence.
        runner: runner of the session, which has the runs.
        goal: the target.
        search: settings of the first look (default: 5 for a share, else 10) and of the cap (default: `days_needed`).
        exact: whether the models use no random numbers.
        before: results before this session, in words.
        name: function that names a design in the progress (default: as in the study's table).
        how: zone and budget; see `judge.Judge`.
    """
    named = name or (lambda number: str(study.points[number]))

    def days(number: int) -> DaysNeeded:
        return days_needed(study.plan.base.replace(study.points[number].overrides), search.first, search.cap)

    return Judge(
        goal,
        study.plan.confidence,
        first=search.first or first_look(goal, search.cap or CAP),
        days=days,
        agree=shows(study.plan.base, goal.indicator),
        deterministic=exact,
        within=goal.measure.within,
        veto=lambda number: cannot_last(study, runner, number),
        drains=lambda number: drains(study, runner, number),
        hopeless=lambda number: cannot_last(study, runner, number, glance=True),
        tell=lambda judge: runner.progress.tell(f"{before}{judge.in_words(named)}"),
        **how,
    )


def measured(row: Row, goal: Target) -> float:
    """Return the target's indicator in a run; a value that clearly misses the target where a robot ran flat."""
    return goal.missed if ran_flat(row) else row.measured(goal.indicator)


_DRIFTS = ("backlog_growth_per_hour", "work_backlog", "energy_drift_per_hour")
"""Indicators whose size says that a design cannot last."""


def cannot_last(study: StudyEngine, runner: StudyRunner, number: int, *, glance: bool = False) -> str | None:
    """Return why a design cannot go on in the long run, by its runs so far; None if it can.

    `glance`: see `not_lasting`.
    """
    rows = _so_far(runner, number)
    if any(map(ran_flat, rows)):
        return "a robot runs flat"
    model = study.plan.base.replace(study.points[number].overrides)
    return not_lasting([row.indicators for row in rows], model, glance=glance)


def drains(study: StudyEngine, runner: StudyRunner, number: int) -> bool:
    """Whether a design that cannot last fails by its batteries alone: a robot runs flat, or all levels fall."""
    rows = _so_far(runner, number)
    model = study.plan.base.replace(study.points[number].overrides)
    return any(map(ran_flat, rows)) or not piles_up(_verdicts([row.indicators for row in rows], model))


def _so_far(runner: StudyRunner, number: int) -> list[Row]:
    return [row for r in range(runner.replications[number]) if (row := runner.row_if_done(number, r)) is not None]


def not_lasting(runs: Sequence[Mapping[str, float]], model: Model, *, glance: bool = False) -> str | None:
    """Return why a design cannot go on in the long run, by the means of its runs; None if it can.

    `glance`: these are the first few, so it may last if it did with half of what grows or falls in them.
    """
    why = next((verdict.text for verdict in _verdicts(runs, model) if verdict.is_lasting), None)
    if not glance or why is None:
        return why
    halved = [{name: value / 2 if name in _DRIFTS else value for name, value in run.items()} for run in runs]
    return why if not_lasting(halved, model) else None


def _verdicts(runs: Sequence[Mapping[str, float]], model: Model) -> Sequence[Verdict]:
    """Judge a design by its runs, at the part of the error that each look (interim analysis) has."""
    return judge_design(runs, model, 1 / len(looks_of_days()))


def more_is_better(name: str) -> bool:
    """Whether the largest mean of an indicator is the best by default."""
    better = find(name).better
    if better is None:
        raise StudyError(
            f"indicator {name!r}: neither less nor more of it is better by itself, expected --minimise or --maximise "
            "(in Python: maximise=False or True)"
        )
    return better == "more"
