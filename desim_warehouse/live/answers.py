"""Results of a design in words, for the live page.

Before the first run, these are the quick estimate, or the reason why the design cannot be simulated; afterwards
numbers, a verdict that is never revised, and a sentence.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.numbers import Scale, number, percent
from desim_warehouse.answer.standing import instead, lasts_not, standing
from desim_warehouse.errors import CheckError, number_of
from desim_warehouse.feasibility import errors
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.live.busy import Busy, busy
from desim_warehouse.live.messages import Measured, Verdict, label
from desim_warehouse.live.offers import ROBOTS
from desim_warehouse.model import Model
from desim_warehouse.outcome.indicators import judged_by, why_no_value
from desim_warehouse.outcome.targets import Target
from desim_warehouse.outcome.verdicts import Verdict as Wrong
from desim_warehouse.outcome.verdicts import judge_design, piles_up
from desim_warehouse.questions.judged import estimated
from desim_warehouse.questions.study import Results
from desim_warehouse.run.quick import estimate
from desim_warehouse.study.execution.work import Outcome
from desim_warehouse.study.factors import Factor, Level
from desim_warehouse.study.plan import StudyPlan, run_seed
from desim_warehouse.study.rare import days_needed, shows
from desim_warehouse.study.statistics.intervals import Estimate
from desim_warehouse.study.statistics.judge import DesignVerdict, looked_at, looks_by
from desim_warehouse.study.statistics.limits import FIRST_OF_MEANS
from desim_warehouse.study.table import Row

CONFIDENCE = 0.95
FEWEST = 5
"""Fewest runs after which a design is abandoned because its runs fail, or its verdict is clear."""
_SHOWN = 6
"""Largest number of indicators on the page."""


class ByHand(NamedTuple):
    """The quick estimate of a design in words: two sentences, and the sufficient values by key."""

    sentence: str
    more: str
    needed: Mapping[str, float]


def by_hand(model: Model, design: str) -> ByHand:
    """Make the quick estimate of a design; `design` is its name in the sentence.

    Raises:
        CheckError: the errors of a design that cannot work, with cures, except those that the model accepts.
    """
    problems = [item.problem for item in errors(model) if item.code not in model.accept]
    if problems:
        raise CheckError(problems)
    calculation = estimate(model)
    return ByHand(
        _sentence(calculation, model.units.hour, design),
        "A quick estimate. The simulation follows.",
        _needed(calculation, model),
    )


def _sentence(quick: QuickEstimate, hour: float, design: str) -> str:
    capacity = f"about {number(quick.capacity * hour, 0)}" if math.isfinite(quick.capacity) else ""
    if quick.rate is None:
        end = f"limited by {quick.bottleneck}"
        return (
            f"{design} can do {capacity} tasks an hour, {end}." if capacity else f"{design}: nothing limits the work."
        )
    asked = number(quick.rate * hour, 0)
    if quick.capacity < quick.rate:
        return f"{design} can do {capacity} of {asked} tasks an hour, limited by {quick.bottleneck}."
    if quick.power is not None and quick.power.short:
        return f"{design}: the chargers give less than the fleet draws; {quick.power.needed} are needed."
    return f"{design}: the robots would be busy {percent(quick.rate / quick.fleet_capacity, 0)} % of the time."


def _needed(quick: QuickEstimate, model: Model) -> dict[str, float]:
    needed: dict[str, float] = {}
    if quick.robots_needed is not None and math.isfinite(quick.robots_needed):
        needed[ROBOTS] = math.ceil(quick.robots_needed - 1e-9)
    if quick.power is not None and quick.power.needed:
        for zone, bay in model.layout.bays.items():
            if bay.total_chargers:
                others = quick.power.chargers - bay.total_chargers
                needed[f"layout.bays.{zone}.total_chargers"] = max(quick.power.needed - others, 1)
    return needed


@dataclass(frozen=True)
class RunsInWords:
    """A verdict on a design in words: its sentence, and further sentences."""

    verdict: Verdict
    sentence: str
    more: tuple[str, ...] = ()
    runs: int = 0
    """The number of runs before the first look; 0 afterwards."""

    @property
    def label(self) -> str:
        """The label of the verdict; before the first look (interim analysis), the number of runs."""
        return f"{self.runs} of {FIRST_OF_MEANS} runs" if self.runs else label(self.verdict)


@dataclass(frozen=True)
class Named:
    """A design with its name in words, its changes to the model, and its model."""

    words: str
    changes: Mapping[str, object]
    model: Model


class RunsSoFar:
    """The first runs of a design, from replication 0 without gaps, and their results."""

    def __init__(self, design: Named, outcomes: Sequence[Outcome], main: str, seed: int) -> None:
        self.design = design
        self.model = design.model
        self.results = results_of(self.model, [(replace(design, changes={}), outcomes)], seed)
        self.rows = self.results.rows
        self.main = main
        self._met: dict[Target | None, Verdict] = {}

    @property
    def n(self) -> int:
        """The number of runs."""
        return len(self.rows)

    @cached_property
    def exact(self) -> bool:
        """Whether the design uses no random numbers, so that one run is enough."""
        return self.results.deterministic

    @cached_property
    def failed(self) -> list[str]:
        """The errors of failed runs."""
        return [row.outcome.error for row in self.rows if row.outcome.error is not None]

    @cached_property
    def indicators(self) -> list[str]:
        """The indicators by which the runs are judged, beginning with the main indicator."""
        names = dict.fromkeys(name for row in self.rows for name in row.indicators)
        usual = judged_by(names, never_ends=self.model.tasks.never_end)
        return [name for name in dict.fromkeys([self.main, *usual]) if name in names][:_SHOWN]

    def estimate(self, indicator: str, n: int | None = None) -> Estimate | None:
        """Return the mean and confidence interval of an indicator over the first n runs; None without values."""
        return self.results.estimate(self.rows[:n], indicator)

    def scale(self, indicator: str) -> Scale:
        """Return the scale in which an indicator is written."""
        return words.scale_of(indicator, self.model, [self.estimate(indicator)])

    def reached(self, value: str) -> str:
        """Return a phrase with the main indicator and a value."""
        return words.reached(self.main, value)

    def values(self, by: float) -> list[float | None]:
        """Return the main indicator in each run, times `by`; None for runs without a value."""
        values = (by * row.value(self.main) for row in self.rows)
        return [value if math.isfinite(value) else None for value in values]

    @cached_property
    def lasting(self) -> Wrong | None:
        """The problem by which the long run will be worse than the runs, at the first look that finds one, or None.

        A single run can show that work piles up, as this verdict allows for chance in the arrivals of the run.
        """
        for n, part in [(1, 1.0)] * bool(self.n) + looks_by(self.n):
            for wrong in judge_design([row.indicators for row in self.rows[:n]], self.model, part):
                if wrong.is_lasting and (n > 1 or self.exact or piles_up([wrong])):
                    return wrong
        return None

    def met(self, target: Target | None) -> Verdict:
        """Return the verdict on a target, which is final once a look has decided."""
        if target not in self._met:
            self._met[target] = self._verdict(target)
        return self._met[target]

    def _verdict(self, target: Target | None) -> Verdict:
        if self.n == 0:
            return "estimate"
        if self.failed:
            return "fails"
        if self.lasting is not None:
            return lasts_not([self.lasting]) or "fails"
        if self.n == 1 and not self.exact:
            return "first run"
        if not self._can_meet(target):
            return "known"
        verdict = self.look(target)
        return "early" if verdict is None else standing(verdict)

    def _can_meet(self, target: Target | None) -> bool:
        return target is not None and all(math.isfinite(row.value(self.main)) for row in self.rows)

    def look(self, target: Target | None) -> DesignVerdict[None] | None:
        """Return the verdict of the first look that decided, or of the last look; None before the first look.

        Its bounds are the interval that the page shows.
        """
        if target is None or not self._can_meet(target):
            return None
        values = [row.value(self.main) for row in self.rows]
        return looked_at(
            values,
            target,
            CONFIDENCE,
            deterministic=self.exact,
            within=target.measure.within,
            least=days_needed(self.model).least,
            agree=shows(self.model, target.indicator),
        )

    def main_in_words(self, target: Target | None) -> str:
        """Return the main indicator with the interval of its verdict; before the first look, the mean only."""
        estimate, look, scale = self.estimate(self.main), self.look(target), self.scale(self.main)
        assert estimate is not None
        if target is None or not self._can_meet(target):
            return scale.estimate(estimate)
        if look is None:
            return scale.value(estimate.mean)
        if look.agrees:
            return scale.agreeing(look.mean, look.n)
        if look.low is None or look.high is None:
            return scale.value(look.mean)
        return scale.within(look.mean, look.low, look.high, target.value)

    def in_words(self, target: Target | None) -> RunsInWords:
        """Return the verdict on a target in words."""
        verdict, design = self.met(target), self.design.words
        estimate = self.estimate(self.main)
        if verdict == "fails":
            count = f"{len(self.failed)} of {number_of(self.n, 'run')}"
            return RunsInWords(verdict, f"{design}: {count} could not go on.", (_short(self.failed[0]),))
        if estimate is None:
            title = words.in_sentence(self.main)
            return RunsInWords(
                verdict, f"{design}: the runs have no {title}.", (numbers.sentence(why_no_value(self.main)),)
            )
        if self.lasting is not None:
            text = instead([self.lasting], self.model)
            return RunsInWords(verdict, f"{numbers.capital(text)} with {design}.")
        if verdict == "first run":
            result = self.reached(self.scale(self.main).value(estimate.mean))
            text = f"{numbers.capital(result)} with {design}, in the first run."
            runs = self.n if self._can_meet(target) else 0
            return RunsInWords(verdict, text, ("One run says nothing about chance yet.",), runs)
        aim = () if target is None else (f"Target: {words.target(target)}.",)
        result = self.reached(self.main_in_words(target))
        if verdict == "early":
            return RunsInWords(verdict, f"So far {result} with {design}{self._year()}.", aim, self.n)
        return RunsInWords(verdict, f"{numbers.capital(result)} with {design}{self._year()}.", aim)

    def _year(self) -> str:
        """Return a phrase with the annual cost; empty if the model has no prices."""
        estimate = self.estimate("annual_cost") if self.main != "annual_cost" else None
        return "" if estimate is None else f", {self.scale('annual_cost').value(estimate.mean)} a year"

    def measured(self, target: Target | None) -> list[Measured]:
        """Return the indicators, each with its interval."""
        measured = []
        for name in self.indicators:
            estimate = self.estimate(name)
            if estimate is None:
                continue
            scale = self.scale(name)
            low, high = estimate.interval or (None, None)
            text = estimated(name, scale, estimate).text
            if name == self.main and self._can_meet(target):
                look, text = self.look(target), self.main_in_words(target)
                low, high = (None, None) if look is None else (look.low, look.high)
            unit = "%" if scale.is_share else scale.unit
            measured.append(
                Measured(
                    name=name,
                    label=words.indicator_name(name),
                    unit=unit,
                    text=text,
                    mean=scale.by * estimate.mean,
                    low=None if low is None else scale.by * low,
                    high=None if high is None else scale.by * high,
                )
            )
        return measured

    def busy(self) -> Busy:
        """Return the busiest group so far, and the load of each group, the largest first."""
        return busy(self.rows, self.model, CONFIDENCE)


def results_of(base: Model, designs: Sequence[tuple[Named, Sequence[Outcome]]], seed: int, target: str = "") -> Results:
    """Return the runs of some designs of a model as the results of a study, whose baseline is the first design."""
    from desim_warehouse.study.execution.cache import versions

    levels = tuple(Level(design.words, design.changes, ()) for design, _ in designs)
    plan = StudyPlan(
        base,
        (Factor("Design", levels),),
        replications=tuple(len(outcomes) for _, outcomes in designs),
        seed=seed,
        baseline={"Design": designs[0][0].words},
        confidence=CONFIDENCE,
        target=target,
        name="live",
    )
    points = plan.points()
    rows = tuple(
        Row(point, r, run_seed(seed, r), outcome)
        for point, (_, outcomes) in zip(points, designs, strict=True)
        for r, outcome in enumerate(outcomes)
    )
    return Results(plan, tuple(points), rows, versions())


def _short(error: str) -> str:
    """Return an error as a sentence, without the name of its type."""
    return numbers.sentence(error.partition(": ")[2] or error)
