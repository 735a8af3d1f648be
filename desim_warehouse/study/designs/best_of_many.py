"""The search of `desim best` among more designs than can be raced by simulation.

The candidates that the search chooses are finally judged on fresh days, which the search did not use.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from random import Random
from typing import Any

from desim_warehouse.errors import StudyError
from desim_warehouse.model import Model
from desim_warehouse.outcome.indicators import find, refuse_unknown
from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.designs.design_space import (
    AisleWays,
    ChargerNodes,
    Combined,
    DesignPart,
    DesignSpace,
    FactorLevels,
)
from desim_warehouse.study.designs.local_search import Goal, LocalSearch
from desim_warehouse.study.factors import Factor, Label
from desim_warehouse.study.procedures import ZONE, Raced, judge_of, more_is_better, not_lasting, race
from desim_warehouse.study.results import ResultsData
from desim_warehouse.study.runner import StudyRunner, could_not_go_on
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.comparison import paired
from desim_warehouse.study.statistics.intervals import Estimate
from desim_warehouse.study.statistics.judge import Budget, Judge, RunsEndedError
from desim_warehouse.study.statistics.limits import SEARCH_RUNS
from desim_warehouse.study.statistics.procedure import Procedure, request
from desim_warehouse.study.study import StudyEngine, searched
from desim_warehouse.study.target import check_zone, read_target

FEWEST_RUNS = 50
"""Fewest runs of a search; with fewer, it looks at little more than its initial design."""
_JUDGED = 5
"""One in five runs is done on fresh days, which the search did not use."""
_CANDIDATES = 4
"""The largest number of designs judged on fresh days."""
_FIRST = 10
"""Replications at the first look at a candidate, or of each design where few are raced."""


@dataclass(frozen=True)
class TriedDesign:
    """A design that the search simulated: means of the indicator, and of the target's, over its completed runs."""

    labels: Mapping[str, Label]
    mean: float
    reached: float | None
    runs: int


@dataclass(frozen=True)
class JudgedDesign:
    """A design on fresh days: estimates of the indicator and of the target's indicator, and the verdict on the target.

    `vetoed`: why the design cannot last, regardless of the target. Without a target `reached` and `verdict` are None.
    """

    labels: Mapping[str, Label]
    overrides: Mapping[str, Any]
    value: Estimate | None
    reached: Estimate | None
    verdict: str | None
    vetoed: str | None


@dataclass(frozen=True)
class SearchedDesigns:
    """The best design found, with its value on fresh days.

    `shown`: whether the best design was shown to meet the target; None without a target. `runner_up`: the other of the
    two leading designs of the search; the better of the two on fresh days is `best`, if they show which. `apart`:
    their difference in the indicator, from pairs of runs. Differences below `delta` do not matter. `cheaper`:
    candidates that did better in the search but were not shown to meet the target. `tried`: all designs simulated, out
    of `many`.
    """

    model: Model
    best: JudgedDesign
    indicator: str
    maximise: bool
    target: Target | None
    shown: bool | None
    cheaper: tuple[JudgedDesign, ...]
    runner_up: JudgedDesign | None
    apart: Estimate | None
    delta: float
    tried: tuple[TriedDesign, ...]
    many: float
    runs: int
    confidence: float
    seed: int = 0


def search_designs(
    model: Model,
    indicator: str,
    delta: float | None = None,
    *,
    target: str | None = None,
    vary: Mapping[str, Any] | None = None,
    place_chargers: int | None = None,
    directions: bool = False,
    maximise: bool | None = None,
    search: Search = USUAL,
) -> Raced | SearchedDesigns:
    """Search the designs of a model for the best mean of an indicator; a few designs race instead.

    The arguments are those of `questions.best.best`.

    Raises:
        ModelError: a value with which the model is invalid.
        StudyError: nothing to choose from, too few runs, a bad target, or an indicator of which neither is better.

    Source: `designs.local_search`; verdicts: see `Judge`.
    """
    measure = find(indicator)
    refuse_unknown(indicator, [model])
    more = more_is_better(indicator) if maximise is None else maximise
    runs = search.runs or SEARCH_RUNS
    factors = [_factor(model, key, values, search.seed) for key, values in (vary or {}).items()]
    if target is None and place_chargers is None and not directions and are_few(factors, runs):
        few = searched(model, vary or {}, search, name="best", indicators=[indicator])
        return race(few, indicator, delta, maximise=more, search=search)
    if runs < FEWEST_RUNS:
        raise StudyError(f"{runs} runs: too few to search designs, expected at least {FEWEST_RUNS}")
    space = _space(model, factors, place_chargers, directions=directions)
    if delta is not None:
        check_zone(measure, delta)
    goal = None if target is None else read_target(target, model.units.names)
    if goal is not None:
        refuse_unknown(goal.indicator, [model])
    with search.together() as together:
        return _DesignSearch(space, indicator, more, goal, together).outcome(delta)


def _space(model: Model, factors: Sequence[Factor], place_chargers: int | None, *, directions: bool) -> DesignSpace:
    """Return the space of designs to search."""
    parts: list[DesignPart] = [FactorLevels(model, factor) for factor in factors]
    parts += [] if place_chargers is None else [ChargerNodes(model, place_chargers)]
    parts += [AisleWays(model)] if directions else []
    space = DesignSpace(model, parts)
    if space.many < 2:  # noqa: PLR2004
        raise StudyError("the best of one design: expected factors with several values")
    return space


def are_few(factors: Sequence[Factor], runs: int) -> bool:
    """Whether designs are so few that all can race, with ten of the runs for each combination of values."""
    return math.prod(len(factor.levels) for factor in factors) * _FIRST <= runs


def _factor(model: Model, key: str, values: Any, seed: int) -> Factor:
    """Make a factor from a key and its values; each value alone must make a valid model."""
    (factor,) = StudyEngine(model, {key: values}, seed=seed).plan.factors
    return factor


class _DesignSearch:
    """One search for the best design, and the judgement of its candidates on fresh days."""

    def __init__(self, space: DesignSpace, indicator: str, maximise: bool, goal: Target | None, search: Search) -> None:
        self.space, self.indicator, self.maximise, self.goal, self.search = space, indicator, maximise, goal, search
        runs = search.runs or SEARCH_RUNS
        self.judged = runs // _JUDGED
        self.runs = runs - self.judged
        self.numbers: dict[Combined, int] = {}

    def outcome(self, delta: float | None) -> SearchedDesigns:
        """Search the designs, and judge the best candidates on fresh days."""
        scout = self._study("search", [self.space.now], self.search.seed + 1)
        candidates = self._searched(scout)[:_CANDIDATES]
        fresh = self._study("judged", candidates, self.search.seed)
        chosen, judge = self._judge(fresh)
        tried = tuple(self._tried(scout.results))
        if delta is None:
            first = next((abs(design.mean) for design in tried if math.isfinite(design.mean)), math.nan)
            delta = ZONE * first
        judged = [self._known(fresh.results, number, design, judge) for number, design in enumerate(candidates)]
        other = 1 if not chosen and len(judged) > 1 and judged[1].value is not None else None
        apart = None if other is None else self._apart(fresh.results, other, 0)
        if other is not None and chosen == 0 and self._is_better(apart) and judged[other].verdict in {None, "meets"}:
            chosen, other = other, chosen
            apart = self._apart(fresh.results, other, chosen)
        best, swapped = judged[chosen or 0], other == 0
        return SearchedDesigns(
            self.space.model.replace(best.overrides),
            best,
            self.indicator,
            self.maximise,
            self.goal,
            None if self.goal is None else chosen is not None,
            tuple(judged[:chosen]) if chosen and not swapped else (),
            None if other is None else judged[other],
            apart,
            delta,
            tried,
            self.space.many,
            len(scout.rows) + len(fresh.rows),
            self.search.confidence,
            self.search.seed,
        )

    def _is_better(self, apart: Estimate | None) -> bool:
        """Whether a difference is shown to be an improvement."""
        if apart is None:
            return False
        low, high = apart.interval or (apart.mean, apart.mean)
        return low > 0 if self.maximise else high < 0

    def _study(self, name: str, designs: Sequence[Combined], seed: int) -> StudyEngine:
        cases = {self._label(design): self.space.changes(design) for design in designs}
        base = self.space.model
        target = None if self.goal is None else self.goal.text
        return searched(base, {"design": {"cases": cases}}, self.search, name=name, seed=seed, target=target)

    def _label(self, design: Combined) -> str:
        return ", ".join(f"{key}: {label}" for key, label in self.space.labels(design).items())

    def _searched(self, scout: StudyEngine) -> list[Combined]:
        """Search, and return the final designs, the best first; designs that are simulated are added to `scout`."""
        with scout.session(self.search.under("search")) as runner:
            self.numbers = {self.space.now: 0}

            def number(design: Combined) -> int:
                if design not in self.numbers:
                    changes = self.space.changes(design)
                    self.numbers[design] = scout.grow(runner, self._label(design), changes)
                return self.numbers[design]

            def steps(exact: bool) -> Procedure[list[Combined]]:
                goal = None if self.goal is None else Goal(self.goal, _reached(scout, runner, self.goal))
                random = Random(self.search.seed)  # noqa: S311 - a search, no secret
                return LocalSearch(
                    self.space, number, self.runs, random, maximise=self.maximise, exact=exact, goal=goal
                ).steps()

            return scout.carry_out(runner, steps, self.indicator, failed=math.nan)

    def _judge(self, fresh: StudyEngine) -> tuple[int | None, Judge | None]:
        """Judge candidates; return the number of the candidate shown to meet the target, and the judge.

        Without a target, return the first candidate and no judge.
        """
        first, cap = min(_FIRST, self.judged // 2), max(_FIRST, 2 * self.judged // _JUDGED)
        search = replace(self.search.under("judged"), first=first, cap=cap)
        if self.goal is None:
            each = self.judged // len(fresh.points)

            def replicated(exact: bool) -> Procedure[None]:
                runs = [(point.number, r) for point in fresh.points[:2] for r in range(1 if exact else 2 * each)]
                yield from request(runs, failing=True)

            fresh.follow(replicated, self.indicator, failed=math.nan, search=search)
            return 0, None
        target, judges = self.goal, list[Judge]()
        with fresh.session(search) as runner:

            def judged(exact: bool) -> Procedure[int | None]:
                budget = Budget(self.judged)
                judges.append(judge_of(fresh, runner, target, search, exact=exact, budget=budget))
                return first_meeting_steps(len(fresh.points), judges[-1])

            chosen = fresh.carry_out(runner, judged, target.indicator, failed=target.missed)
        return chosen, judges[-1]

    def _known(self, fresh: ResultsData, number: int, design: Combined, judge: Judge | None) -> JudgedDesign:
        rows = fresh.by_point[number]
        verdict = None if judge is None else judge.verdicts.get(number)
        return JudgedDesign(
            self.space.labels(design),
            self.space.changes(design),
            fresh.estimate(rows, self.indicator),
            None if self.goal is None else _with_bounds(fresh.estimate(rows, self.goal.indicator), verdict),
            None if verdict is None else verdict.verdict,
            None if judge is None else judge.vetoed.get(number),
        )

    def _apart(self, fresh: ResultsData, other: int, chosen: int) -> Estimate | None:
        """Return the difference of another design to the chosen one, in the pairs of runs that both have."""
        values = {
            number: {row.replication: row.value(self.indicator) for row in fresh.by_point[number]}
            for number in (other, chosen)
        }
        common = [
            r for r in values[other].keys() & values[chosen].keys() if all(math.isfinite(values[n][r]) for n in values)
        ]
        if not common:
            return None
        ours, theirs = ([values[number][r] for r in sorted(common)] for number in (other, chosen))
        return paired(ours, theirs, fresh.plan.confidence, deterministic=fresh.deterministic)

    def _tried(self, scout: ResultsData) -> list[TriedDesign]:
        tried = []
        for design, number in self.numbers.items():
            rows = scout.by_point[number]
            mean = scout.estimate(rows, self.indicator)
            reached = None if self.goal is None else scout.estimate(rows, self.goal.indicator)
            labels = self.space.labels(design)
            means = math.nan if mean is None else mean.mean, None if reached is None else reached.mean
            tried.append(TriedDesign(labels, *means, len(rows)))
        return tried


def first_meeting_steps(candidates: int, judge: Judge) -> Procedure[int | None]:
    """Find the first candidate, in order, that is shown to meet the target before the budget is exhausted.

    If this is candidate 0, candidate 1 is then judged on the same days, so that the two can be compared.
    """
    meeting = None
    try:
        for number in range(candidates):
            if (yield from judge.verdict(number)) == "meets":
                meeting = number
                if number == 0 and candidates > 1:
                    yield from judge.verdict(1)
                break
    except RunsEndedError:
        pass
    return meeting


def _with_bounds(mean: Estimate | None, verdict: Any) -> Estimate | None:
    """Return a mean with the bounds of its verdict, which allow for several looks (interim analyses)."""
    if mean is None or verdict is None or mean.interval is None or verdict.low is None:
        return mean
    return replace(mean, interval=(verdict.low, verdict.high))


def _reached(scout: StudyEngine, runner: StudyRunner, target: Target) -> Any:
    """Return a function for the target's indicator in a run; nan if the run ended early or could not last."""
    models: dict[int, Model] = {}

    def reached(number: int, replication: int) -> float:
        row = runner.row(number, replication)
        if could_not_go_on(row):
            return math.nan
        if number not in models:
            models[number] = scout.plan.base.replace(scout.points[number].overrides)
        value = row.measured(target.indicator)
        return math.nan if not_lasting([row.indicators], models[number], glance=True) else value

    return reached
