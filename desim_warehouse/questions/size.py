"""What is the smallest value that meets a target: `size`; or with which most is done: `most`; and their answers."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer, Answered, merged
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.parts import BigNumber, Option, Rows
from desim_warehouse.answer.standing import Standing, instead, lasts_not
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model import Model
from desim_warehouse.questions import judged, race
from desim_warehouse.questions.race import Best
from desim_warehouse.questions.study import Study
from desim_warehouse.study import procedures
from desim_warehouse.study.design import Point
from desim_warehouse.study.fleet.capped import KEY, Capped, tried_cap, waits_much
from desim_warehouse.study.procedures import FLEET, ZONE, Smallest, smallest
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.judge import DesignVerdict
from desim_warehouse.study.statistics.limits import FIRST
from desim_warehouse.study.target import Days, days_of


@dataclass(frozen=True, repr=False)
class Size(Answered, Smallest):
    """The smallest value that meets a target: what `size` found.

    Attributes:
        answer: in words; printing prints it.
        smallest: the value; None: none was shown to meet the target.
        target: what is to be met.
        decisions: the verdict on each value that was looked at.
        runs: simulated for it in all.
    """

    def in_short(self) -> str:
        """Name the value and the target."""
        return f"{self.smallest}: {self.target}" if self.smallest is not None else f"none: {self.target}"


def size(
    study: Study,
    target: str,
    *,
    zone: float | str | None = None,
    scan: bool = False,
    search: Search = USUAL,
) -> Size:
    """Find the first value of a study's factor, smallest first, whose mean meets a target with confidence.

    Args:
        study: with one factor, its values upwards.
        target: such as "throughput_per_hour >= 220"; of shares such as "on_time >= 95 %" or "on_time >= 0.95".
        zone: indifference zone in the indicator's unit; default: 0.01 for shares, else 1 % of the target.
        scan: look at all values from the first on, as where more need not be better, instead of by bisection.
        search: how runs are done; confidence, seed and time limit are the study's.

    Returns:
        The smallest value with the verdict on each that was looked at, and the answer in words; see `Size`.

    Raises:
        StudyError: not one factor, a bad target, or a run that failed but for a robot that ran flat, which fails.

    Source: a search by bisection with sequential tests, as for a plan of one count.
    """
    least = smallest(study, target, zone=zone, scan=scan, search=search)
    return Size(**vars(least), answer=answer(least).keep(search.out, search.command))


def most(
    study: Study,
    indicator: str = "throughput_per_hour",
    *,
    share: float = ZONE,
    search: Search = USUAL,
) -> Best:
    """Find the smallest value of a study's factor with which most is done, where more of it need not do more.

    Of fleets that do less where they are larger, the largest is tried with a cap on the robots under way, too.

    Args:
        study: with one factor, its values upwards.
        indicator: what is done.
        share: a smaller difference, as a part of the largest mean of the first replications, does not matter.
        search: how runs are done; confidence, seed and time limit are the study's.

    Raises:
        StudyError: unknown indicator, fewer than two designs, or a run that failed.

    Source: see `procedures.race`.
    """
    [key] = (factor.key for factor in study.plan.factors)
    with search.together() as together:
        raced = procedures.race(study, indicator, share=share, search=together)
        falls = key == FLEET and raced.selection.eliminated_at[-1] is not None
        capped = cap_sentence(study, indicator, together) if falls else ""
    least = f"{words.factor_name(key)} {words.level(raced.first.labels[key])}"
    alike = f"{least} is the smallest that does as much, within {100 * share:g} % of the most."
    return Best(
        **vars(raced),
        answer=race.answer(raced, "size", tuple(filter(None, (alike, capped)))).keep(search.out, search.command),
    )


def cap_sentence(study: Study, indicator: str, search: Search) -> str:
    """Try caps on the robots under way of the largest fleet; the sentence is empty unless robots wait and one helps."""
    largest = study.points[-1]
    rows = study.results.by_point[largest.number]
    if not waits_much(row.indicators for row in rows):
        return ""
    model = study.plan.base.replace(largest.overrides)
    first = search.first or FIRST
    best, _ = tried_cap(model, indicator, replace(search.under("cap"), first=first, cap=2 * first))
    return "" if best is None else f"{capped(best, model)}."


def answer(least: Smallest) -> Answer:
    """Put the values that were looked at into words, the smallest that meets the target first."""
    return _Sized(least).answer()


class _Sized:
    """The values that were looked at, in their order; those whose runs are equal are one."""

    def __init__(self, found: Smallest) -> None:
        study = found.study
        self.found, self.results, self.goal = found, study.results, found.target
        self.model, self.seed = study.plan.base, study.plan.seed
        [self.key] = (factor.key for factor in study.plan.factors)
        self.points: dict[Any, Point] = {point.labels[self.key]: point for point in study.points}
        places = list(self.points)
        looked_at = sorted(found.decisions, key=lambda one: places.index(one.value))
        self.tried = merged(looked_at, lambda one: self.results.outcomes(str(self.points[one.value])))
        self.options = [self._option(one, same) for one, same in self.tried]

    def answer(self) -> Answer:
        found, goal = self.found, self.goal
        best = next((one for one in found.decisions if one.value == found.smallest), None)
        said = self._none() if best is None else [self._smallest(best)]
        said += self._open() + self._falls() + self._against()
        return Answer(
            kind="size",
            name=self.model.name,
            description=self.model.description,
            question=f"What is the smallest {words.in_words(self.key)} that gives {words.target(goal)}?",
            answer=tuple(said),
            measures={goal.indicator: words.in_sentence(goal.indicator)},
            tiles=() if best is None else self._tiles(best),
            options=tuple(self.options),
            figure=self._figure(),
            about=None if best is None else judged.about(self._name(best), self._model(best), self.seed),
            promise=self._promise(best),
            notes=tuple(judged.holds_the_target(self.options, goal, self._zone())),
            runs=found.runs,
            confidence=found.confidence,
            made={"seed": str(self.seed), "model": self.model.digest()},
            key=self.key,
            smallest=found.smallest,
            target={"indicator": goal.indicator, "sense": goal.sense, "value": goal.value},
        )

    # Sentences

    def _smallest(self, best: DesignVerdict[Any]) -> str:
        name = self._name(best)
        many = name[:1].isdigit()
        are = "are" if many and best.value != 1 else "is"
        fewest = "fewest" if many else "smallest value"
        number = judged.number(best, self.goal, self.model).text
        return (
            f"{capital(name)} {are} the {fewest} shown to give {words.target(self.goal)}: {number}{self._days(best)}."
        )

    def _days(self, one: DesignVerdict[Any]) -> str:
        """The worst of the days of a value, behind its mean."""
        said = judged.days(self._days_of(one), self.goal, self.model)
        return said and f"; {said}"

    def _days_of(self, one: DesignVerdict[Any]) -> Days | None:
        rows = self.results.by_point[self.points[one.value].number][: one.n]
        return days_of([value for row in rows if math.isfinite(value := row.value(self.goal.indicator))], self.goal)

    def _zone(self) -> str:
        return words.amount(self.goal.indicator, self.found.zone, self.goal.unit)

    def _promise(self, best: DesignVerdict[Any] | None) -> str:
        exact = all(one.deterministic for one in self.found.decisions)
        sure = judged.promise("verdicts", self.found.confidence, exact=exact)
        if best is None or best.deterministic or not best.least:
            return sure
        return f"{sure} {judged.covers(best.least, [self._model(best)])}"

    def _none(self) -> list[str]:
        """That none is enough, and what the best or, where more may be worse, each does."""
        said = [f"No {words.in_words(self.key)} within the range is shown to give {words.target(self.goal)}."]
        last, _ = self.tried[-1]
        if judged.is_perfect(last, self.goal):
            return [*said, f"{capital(self._name(last))}: {judged.perfect(last, self.goal)}"]
        return said + [f"{capital(one.name)}: {one.text}." for one in self.options[-1:]]

    def _open(self) -> list[str]:
        close = [one.name for one in self.options if one.standing == "open"]
        also = " also" if self.found.smallest is not None else ""
        return [f"{capital(spoken(close, 'or'))} may{also} be enough; more runs would tell."] if close else []

    def _falls(self) -> list[str]:
        pairs = [f"with {words.level(more)} than with {words.level(one)}" for one, more in self.found.falls]
        return [f"It does worse {spoken(pairs)}, so each smaller value was judged by itself."] if pairs else []

    def _against(self) -> list[str]:
        line = "The smallest and the largest contradict what usually holds, so each smaller value was judged by itself."
        return [line] if self.found.against else []

    # Numbers

    def _name(self, one: DesignVerdict[Any]) -> str:
        return words.design_spoken({self.key: one.value})

    def _model(self, one: DesignVerdict[Any]) -> Any:
        return self.model.replace(self.points[one.value].overrides)

    def _option(self, one: DesignVerdict[Any], same: list[DesignVerdict[Any]]) -> Option:
        point = self.points[one.value]
        wrong = self.results.verdicts.get(str(point), ())
        why = lasts_not(wrong)
        veto = dict(self.found.vetoed).get(one.value)
        kind: Standing = why or ("fails" if veto or math.isnan(one.mean) else judged.standing_of(one, self.goal))
        done = self.results.estimate(self.results.by_point[point.number], "throughput_per_hour")
        said = instead(wrong, None if done is None else done.mean, self._model(one)) if why else veto or ""
        known = not said and not math.isnan(one.mean)
        return Option(
            name=self._name(one),
            standing=kind,
            number=judged.number(one, self.goal, self.model) if known else None,
            days=judged.in_row(self._days_of(one), self.goal, self.model) if known else "",
            said=said,
            runs=one.n,
            set=dict(point.overrides),
            same=tuple(words.level(other.value) for other in same),
        )

    def _tiles(self, best: DesignVerdict[Any]) -> tuple[BigNumber, ...]:
        name = self._name(best)
        count, _, what = name.partition(" ")
        first = BigNumber(value=count, what=what) if name[:1].isdigit() else None
        first = first or BigNumber(value=words.level(best.value), what=words.in_words(self.key))
        number = judged.number(best, self.goal, self.model).text
        return first, judged.tile(number, words.in_sentence(self.goal.indicator))

    def _figure(self) -> Rows | None:
        title = capital(words.in_sentence(self.goal.indicator))
        bars = (judged.bar(one.name, one.number, one.standing) for one in self.options if one.number is not None)
        return judged.figure(title, bars, self.goal.value, judged.aim(self.goal))


def capped(found: Capped, model: Model | None) -> str:
    """What a cap on the robots under way gives."""
    scale_of = words.scale(found.indicator, model, (found.mean,))
    gain, is_now = found.gain, f"{words.in_sentence(found.indicator)} is {scale_of.value(found.mean)}"
    ends = "" if gain.low == gain.high else f" ({scale_of.bare(gain.low)} to {scale_of.bare(gain.high)})"
    return (
        f"With at most {found.cap} of {number_of(found.robots, 'robot')} under way {is_now}: better by "
        f"{scale_of.value(gain.mean)}{ends}; desim size --key {KEY} finds the best cap"
    )
