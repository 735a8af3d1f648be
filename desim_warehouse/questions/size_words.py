"""The answer of `desim size --target`: the smallest value that meets it, and what a cap on robots under way gives."""

from __future__ import annotations

import math
from typing import Any

from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer, merged
from desim_warehouse.answer.answered import answer_of
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.parts import BigNumber, Option, Rows
from desim_warehouse.answer.standing import Standing, instead, lasts_not, standing
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model import Model
from desim_warehouse.questions import judged
from desim_warehouse.study.design import Point
from desim_warehouse.study.fleet.capped import KEY, Capped
from desim_warehouse.study.procedures import SizeFound
from desim_warehouse.study.statistics.judge import DesignVerdict


@answer_of.register
def answer(found: SizeFound, besides: str = "") -> Answer:
    """What `desim size --target` found; `besides`: a sentence more."""
    return _Sized(found).answer(besides)


class _Sized:
    """The values that were looked at, in their order; those whose runs are equal are one."""

    def __init__(self, found: SizeFound) -> None:
        study = found.study
        self.found, self.results, self.goal = found, study.results, found.target
        self.model, self.seed = study.plan.base, study.plan.seed
        [self.key] = (factor.key for factor in study.plan.factors)
        self.points: dict[Any, Point] = {point.labels[self.key]: point for point in study.points}
        places = list(self.points)
        looked_at = sorted(found.decisions, key=lambda one: places.index(one.value))
        self.tried = merged(looked_at, lambda one: self.results.outcomes(str(self.points[one.value])))
        self.options = [self._option(one, same) for one, same in self.tried]

    def answer(self, besides: str) -> Answer:
        found, goal = self.found, self.goal
        best = next((one for one in found.decisions if one.value == found.smallest), None)
        said = self._none() if best is None else [self._smallest(best)]
        said += self._open() + self._falls() + ([besides] if besides else [])
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
            promise=judged.promise(
                "verdicts", found.confidence, exact=all(one.deterministic for one in found.decisions)
            ),
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
        return f"{capital(name)} {are} the {fewest} shown to give {words.target(self.goal)}: {number}."

    def _none(self) -> list[str]:
        """That none is enough, and what the best or, where more may be worse, each does."""
        said = [f"No {words.in_words(self.key)} within the range is shown to give {words.target(self.goal)}."]
        return said + [f"{capital(one.name)}: {one.text}." for one in self.options[-1:]]

    def _open(self) -> list[str]:
        close = [one.name for one in self.options if one.standing == "open"]
        return [f"{capital(spoken(close, 'or'))} may also be enough; more runs would tell."] if close else []

    def _falls(self) -> list[str]:
        pairs = [f"with {words.level(more)} than with {words.level(one)}" for one, more in self.found.falls]
        return [f"It does worse {spoken(pairs)}, so each smaller value was judged by itself."] if pairs else []

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
        kind: Standing = why or ("fails" if veto or math.isnan(one.mean) else standing(one))
        done = self.results.estimate(self.results.by_point[point.number], "throughput_per_hour")
        said = instead(wrong, None if done is None else done.mean, self._model(one)) if why else veto or ""
        known = not said and not math.isnan(one.mean)
        return Option(
            name=self._name(one),
            standing=kind,
            number=judged.number(one, self.goal, self.model) if known else None,
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
