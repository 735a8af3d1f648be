"""The verb `best`, which finds the best design, and the answer of a search among many designs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer, Answered
from desim_warehouse.answer.numbers import capital, number, sentence
from desim_warehouse.answer.parts import Bar, BigNumber, Dot, Folded, Option, Points, Rows, ShownNumber
from desim_warehouse.answer.standing import BY_VERDICT, Standing
from desim_warehouse.errors import StudyError, number_of, spoken
from desim_warehouse.model import Source, as_model
from desim_warehouse.model.facts.costs import COST, is_fixed
from desim_warehouse.outcome.targets import Target
from desim_warehouse.questions import judged, race
from desim_warehouse.questions.race import Best, best_of_study
from desim_warehouse.questions.study import Study
from desim_warehouse.study.designs.best_of_many import JudgedDesign, SearchedDesigns, TriedDesign, search_designs
from desim_warehouse.study.designs.design_space import AisleWays, ChargerNodes
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.intervals import Estimate

if TYPE_CHECKING:
    import pandas as pd

_LUCK = "Means of the search, few runs each, which flatter the best options slightly."
_NOT_SHOWN = ", not shown to be enough"
_OTHERS = 12
"""Number of tried designs that have a row besides those judged on fresh days."""
_SHORT = 24
"""Most letters of a design's name that is shown as a large number."""
_COUNTED = 1e15
"""Number of designs up to which it is printed in full."""


@dataclass(frozen=True, repr=False)
class BestOfMany(Answered, SearchedDesigns):
    """The best design that a search found: the result of `best` when not all designs race.

    Attributes:
        answer: the answer in words; shown by `print`.
        best: the best design, with its values on days that the search did not use.
        shown: whether the best design was shown to meet the target; None without a target.
        runner_up: the second-best design; None if it was not judged on such days.
        tried: all designs that were simulated, with their means in the search.
        runs: total number of runs simulated.
    """

    @property
    def design(self) -> str:
        """The best design in words."""
        return design(self.best)

    @property
    def overrides(self) -> dict[str, Any]:
        """The overrides that turn the model into the best design."""
        return dict(self.best.overrides)

    @property
    def mean(self) -> float:
        """The indicator of the best design on fresh days, in the model's units; nan if no run finished."""
        return math.nan if self.best.value is None else self.best.value.mean

    @property
    def table(self) -> pd.DataFrame:
        """One row for each tried design, best first: its factors, its means in the search, and its number of `runs`."""
        import pandas as pd

        goal = None if self.target is None else self.target.indicator
        return pd.DataFrame(
            {
                **{key.replace(".", "_"): label for key, label in tried.labels.items()},
                **({} if goal is None else {goal: tried.reached}),
                self.indicator: tried.mean,
                "runs": tried.runs,
            }
            for tried in in_order(self)
        )

    def in_short(self) -> str:
        """Return the best design and its value in a few words."""
        return f"{self.design}: {self.indicator} {self.mean:g}"


@overload
def best(
    what: Study,
    indicator: str,
    delta: float | None = None,
    *,
    maximise: bool | None = None,
    search: Search = USUAL,
) -> Best: ...
@overload
def best(
    what: Source,
    indicator: str,
    delta: float | None = None,
    *,
    target: str | None = None,
    vary: Mapping[str, Any] | None = None,
    place_chargers: int | None = None,
    directions: bool = False,
    maximise: bool | None = None,
    search: Search = USUAL,
) -> Best | BestOfMany: ...


def best(  # half of it documents its arguments
    what: Study | Source,
    indicator: str,
    delta: float | None = None,
    *,
    target: str | None = None,
    vary: Mapping[str, Any] | None = None,
    place_chargers: int | None = None,
    directions: bool = False,
    maximise: bool | None = None,
    search: Search = USUAL,
) -> Best | BestOfMany:
    """Find the best design of a study, or of a model whose keys, chargers or directions of aisles are varied.

    The designs of a study all race: designs that are clearly worse by the mean of the indicator drop out early. The
    designs of a model race if only keys are varied, there is no target, and each design can have ten runs. Otherwise
    four fifths of the runs are used to search among the designs, and the last fifth estimates the best on fresh days,
    and whether it meets the target.

    Args:
        what: a study, with its runs and its confidence, or a model, or the path of a model file.
        indicator: the indicator to optimise; a study may define its own.
        delta: the largest difference that does not matter, in the indicator's unit; default: 1 % of the largest of the
            first means.
        target: for a model, a target that designs must meet, such as "on_time >= 95 %".
        vary: for a model, key -> values to try, in any form that study files allow.
        place_chargers: for a model, the number of nodes to search for, each with a charger. None: chargers stay.
        directions: for a model, whether aisles may be reversed.
        maximise: whether larger is better (default: as usual for the indicator; required for your own indicators).
        search: settings of runs, at most 500 by default, in a race at most `cap` of each design; `first` and `cap` are
            for a race.

    Returns:
        `Best`, after a race: the best design and those as good. `BestOfMany`, after a search: the best design and those
            that came close.

    Raises:
        ModelError: a value with which the model is invalid.
        StudyError: nothing to choose from, too few runs, a bad target, a study together with arguments for models, an
            unknown indicator, or an indicator without a better direction.

    Source: the race is KN, Kim & Nelson (2001). The search is a local search from many starts, judged on other days.
    """
    if isinstance(what, Study):
        if directions or any(argument is not None for argument in (target, vary, place_chargers)):
            raise StudyError("target, vary, place_chargers, directions: for a model, expected none beside a study")
        return best_of_study(what, indicator, delta, maximise=maximise, search=search)
    chosen = search_designs(
        as_model(what),
        indicator,
        delta,
        target=target,
        vary=vary,
        place_chargers=place_chargers,
        directions=directions,
        maximise=maximise,
        search=search,
    )
    if isinstance(chosen, SearchedDesigns):
        return BestOfMany(**vars(chosen), answer=answer(chosen).keep(search.out, search.command))
    return race.worded(chosen, search)


def answer(searched: SearchedDesigns) -> Answer:
    """Put a search for the best design into words; its subject is the best, shown to meet the target or not."""
    best, unproven = searched.best, searched.shown is False
    head, rows = table(searched, in_order(searched))
    values = [] if unproven else _numbers(searched, best)
    return Answer(
        kind="best",
        name=searched.model.name,
        description=searched.model.description,
        question=_question(searched),
        answer=tuple(sentences(searched)),
        measures={name: words.in_sentence(name) for name in _judged_by(searched)},
        tiles=tuple(_tiles(searched, values)),
        options=tuple(
            _option(searched, candidate) for candidate in (best, *searched.cheaper, *filter(None, [searched.runner_up]))
        ),
        figure=_figure(searched),
        about=judged.about(f"{design(best)}{_NOT_SHOWN if unproven else ''}", searched.model, searched.seed),
        tables=(Folded(title="The search", note=_LUCK, head=tuple(head), rows=tuple(map(tuple, rows))),),
        promise=f"Values are from days that the search did not use, with {100 * searched.confidence:g} % confidence.",
        runs=searched.runs,
        confidence=searched.confidence,
        made={"seed": str(searched.seed), "model": searched.model.digest()},
        indicator=searched.indicator,
        shown=searched.shown,
    )


def _tiles(searched: SearchedDesigns, values: list[ShownNumber]) -> list[BigNumber]:
    """Return the large numbers of the best design, after its name if the name is short."""
    name = design(searched.best)
    first = [BigNumber(value=name, what=f"the {_best(searched)} option")] if len(name) <= _SHORT else []
    return (first if values else []) + [judged.tile(value.text, words.in_sentence(value.of)) for value in values]


def _question(searched: SearchedDesigns) -> str:
    if _best(searched) == "cheapest":
        return f"What is the cheapest option{f' that gives {_aim(searched)}' if searched.target else ''}?"
    sense, aim = "largest" if searched.maximise else "smallest", f" with {_aim(searched)}" if searched.target else ""
    return f"With which option is {words.in_sentence(searched.indicator)} {sense}{aim}?"


def _best(searched: SearchedDesigns) -> str:
    """Return the word for the best option: `cheapest` or `best`."""
    return "cheapest" if searched.indicator == COST and not searched.maximise else "best"


def _option(searched: SearchedDesigns, candidate: JudgedDesign) -> Option:
    """Return the row of a design that was judged on fresh days."""
    values = [] if candidate.vetoed else _numbers(searched, candidate)
    kind: Standing = "known" if candidate.verdict is None else BY_VERDICT[candidate.verdict]
    return Option(
        name=design(candidate),
        standing="drained" if candidate.vetoed else kind,
        number=values[0] if values else None,
        also=tuple(values[1:]),
        instead=candidate.vetoed or "",
        runs=0 if candidate.value is None else candidate.value.n,
        set=dict(candidate.overrides),
    )


def _figure(searched: SearchedDesigns) -> Rows | Points | None:
    """Draw all tried designs: by the indicator and the target's indicator, or in rows if the two are one."""
    if searched.target is not None and searched.target.indicator != searched.indicator:
        return _points(searched, searched.target)
    return _rows(searched)


def _points(searched: SearchedDesigns, goal: Target) -> Points | None:
    """Draw the tried designs by both indicators; judged designs have names, and their means on fresh days."""
    judged_ones = (searched.best, *searched.cheaper, *filter(None, [searched.runner_up]))
    fresh = {
        design(candidate): candidate
        for candidate in judged_ones
        if candidate.value is not None and candidate.reached is not None
    }
    points = [
        Dot(x=tried.reached, y=tried.mean)
        for tried in searched.tried
        if tried.reached is not None and math.isfinite(tried.reached + tried.mean) and design(tried) not in fresh
    ]
    for name, candidate in fresh.items():
        assert candidate.value is not None
        assert candidate.reached is not None
        kind = "met" if candidate.verdict == "meets" else "not met" if candidate.verdict == "fails" else "open"
        points.append(Dot(x=candidate.reached.mean, y=candidate.value.mean, name=name, standing=kind))
    if not points:
        return None
    ends = []
    for indicator, values in (
        (goal.indicator, [goal.value, *(dot.x for dot in points)]),
        (searched.indicator, [dot.y for dot in points]),
    ):
        scale = words.scale(indicator, searched.model, values)
        ends += [scale.value(min(values)), scale.value(max(values))]
    return Points(
        title=f"{capital(words.in_sentence(searched.indicator))} and {words.in_sentence(goal.indicator)} of all tried",
        across=capital(words.in_sentence(goal.indicator)),
        up=capital(words.in_sentence(searched.indicator)),
        at=goal.value,
        at_words=judged.aim(goal),
        ends=(ends[0], ends[1], ends[2], ends[3]),
        points=tuple(points),
    )


def _rows(searched: SearchedDesigns) -> Rows | None:
    """Draw the designs judged on fresh days, then the best of the others by their means in the search."""
    goal, rows = searched.target, []
    for candidate in (searched.best, *searched.cheaper, *filter(None, [searched.runner_up])):
        numbers = _numbers(searched, candidate)
        if numbers and not candidate.vetoed:
            kind = "met" if candidate.verdict == "meets" else "not met" if candidate.verdict == "fails" else ""
            rows.append(judged.bar(design(candidate), numbers[-1], kind))
    if not rows:
        return None
    scale = words.scale(
        searched.indicator, searched.model, [tried.mean for tried in searched.tried if math.isfinite(tried.mean)]
    )
    names = {row.label for row in rows}
    others = [tried for tried in in_order(searched) if math.isfinite(tried.mean) and design(tried) not in names][
        :_OTHERS
    ]
    rows += [
        Bar(label=design(tried), mean=tried.mean, text=f"{scale.value(tried.mean)} in the search") for tried in others
    ]
    title = f"{capital(words.in_sentence(goal.indicator if goal else searched.indicator))} on fresh days"
    line = searched.best.value.mean if goal is None and searched.best.value else goal and goal.value
    line_words = judged.aim(goal) if goal else "the best"
    return Rows(title=title, at=line, at_words=line_words, rows=tuple(rows))


def sentences(searched: SearchedDesigns) -> list[str]:
    """Return the sentences of the answer: the best design, cheaper ones not shown to be enough, runner-up, and runs."""
    lines = [_answer(searched)]
    for candidate in searched.cheaper:
        why = candidate.vetoed or f"not shown to give {_aim(searched)}"
        lines.append(
            sentence(f"Better in the search, but {why}: {design(candidate)} with {_values(searched, candidate)}")
        )
    if searched.runner_up is not None:
        lines.append(_runner_up(searched, searched.runner_up))
    many = (
        f"{number(searched.many)}" if searched.many < _COUNTED else f"some 10^{math.floor(math.log10(searched.many))}"
    )
    lines.append(f"{len(searched.tried)} of {many} options were tried, in {number_of(searched.runs, 'run')} in all.")
    return lines


def _answer(searched: SearchedDesigns) -> str:
    best = f"{design(searched.best)}: {_values(searched, searched.best)}"
    if searched.shown is None:
        return sentence(f"{best}, {_days(searched.best)}")
    if searched.shown:
        return sentence(
            f"The {_best(searched)} option shown to give {_aim(searched)} is {best}, {_days(searched.best)}"
        )
    wrong = f"; but {searched.best.vetoed}" if searched.best.vetoed else ""
    return sentence(f"No option was shown to give {_aim(searched)}; the best in the search is {best}{wrong}")


def _runner_up(searched: SearchedDesigns, other: JudgedDesign) -> str:
    apart = searched.apart
    line = f"Next: {design(other)} with {_values(searched, other)}"
    if apart is None:
        return sentence(line)
    scale = words.scale(searched.indicator, searched.model, [apart.mean])
    low, high = apart.interval or (apart.mean, apart.mean)
    if not apart.mean and not apart.sd:
        return sentence(f"{line}; no difference in {number_of(apart.n, 'pair')} of runs: take either")
    exact = is_fixed(searched.model, searched.indicator)
    amount = scale.value(apart.mean) if exact else scale.within(apart.mean, low, high)
    line += f"; the difference is {amount} in {number_of(apart.n, 'pair')} of runs"
    if max(abs(low), abs(high)) < searched.delta:
        line += f", less than {scale.value(searched.delta)}: take either"
    return sentence(line)


def design(candidate: JudgedDesign | TriedDesign) -> str:
    """Return a design in words, with its directions only if some are turned or it has no other part."""
    labels = dict(candidate.labels)
    nodes, turned = labels.pop(ChargerNodes.key, None), labels.pop(AisleWays.key, None)
    parts = [words.design_spoken(labels)] if labels else []
    parts += [] if nodes is None else [f"chargers at {spoken(str(nodes).split(', '))}"]
    parts += [] if turned is None else [f"{turned} turned" if turned != AisleWays.drawn_label else "aisles as drawn"]
    return ", ".join(parts)


def _values(searched: SearchedDesigns, candidate: JudgedDesign) -> str:
    """Return the values of the indicator and of the target's indicator, with their intervals, in words."""
    values = [words.reached(reading.of, reading.text) for reading in _numbers(searched, candidate)]
    return ", ".join(values) or "no finished run"


def _judged_by(searched: SearchedDesigns) -> list[str]:
    """Return the names of the indicator and of the target's indicator."""
    return [searched.indicator, *([] if searched.target is None else [searched.target.indicator])]


def _numbers(searched: SearchedDesigns, candidate: JudgedDesign) -> list[ShownNumber]:
    means: dict[str, tuple[Estimate | None, float | None]] = {searched.indicator: (candidate.value, None)}
    if searched.target is not None:
        means[searched.target.indicator] = (candidate.reached, searched.target.value)
    return [
        judged.estimated(name, words.scale(name, searched.model, [mean.mean if aim is None else aim]), mean, aim)
        for name, (mean, aim) in means.items()
        if mean is not None
    ]


def _days(candidate: JudgedDesign) -> str:
    return "" if candidate.value is None else f"in {number_of(candidate.value.n, 'run')} on fresh days"


def _aim(searched: SearchedDesigns) -> str:
    return "" if searched.target is None else words.target(searched.target)


def in_order(searched: SearchedDesigns) -> list[TriedDesign]:
    """Return all tried designs: first those whose runs in the search meet the target; within each part, best first."""
    sign = 1 if searched.maximise else -1

    def rank(tried: TriedDesign) -> tuple[bool, float]:
        is_met = searched.target is None or (tried.reached is not None and searched.target.met_by(tried.reached))
        return not is_met, -sign * tried.mean if math.isfinite(tried.mean) else math.inf

    return sorted(searched.tried, key=rank)


def table(searched: SearchedDesigns, shown: Sequence[TriedDesign]) -> tuple[list[str], list[list[str]]]:
    """Return the head and the rows of a table of tried designs, with their means in the search."""
    keys = list(searched.best.labels)
    goal = [] if searched.target is None else [searched.target.indicator]
    names = list(dict.fromkeys([searched.indicator, *goal]))
    scales = {name: words.scale(name, searched.model, [tried.mean for tried in shown]) for name in names}
    head = [words.factor_head(key, searched.model.units) for key in keys]
    head += [words.head(name, scale) for name, scale in scales.items()]
    rows = []
    for tried in shown:
        values = {searched.indicator: tried.mean, **dict.fromkeys(goal, tried.reached)}
        cells = [words.level(tried.labels[key]) for key in keys]
        cells += [scales[name].single(math.nan if value is None else value) for name, value in values.items()]
        rows.append([*cells, str(tried.runs)])
    return [*head, "runs in the search"], rows
