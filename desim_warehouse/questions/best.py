"""Which design is best: `best`, and its answer where many were searched, by their values on fresh days."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer, Answered
from desim_warehouse.answer.numbers import capital, number, sentence
from desim_warehouse.answer.parts import Bar, BigNumber, Dot, Folded, Option, Points, Rows, SaidNumber
from desim_warehouse.answer.standing import BY_VERDICT, Standing
from desim_warehouse.errors import StudyError, number_of, spoken
from desim_warehouse.model import Source, as_model
from desim_warehouse.model.facts.costs import is_fixed
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
"""Designs tried that have a row besides those judged on fresh days."""
_SHORT = 24
"""Letters of a design that is a large number."""
_COUNTED = 1e15
"""Designs up to which their number is said."""


@dataclass(frozen=True, repr=False)
class BestOfMany(Answered, SearchedDesigns):
    """The best of the designs that were searched: what `best` found where not all of them could race.

    Attributes:
        answer: in words; printing prints it.
        best: the design, with its values on fresh days.
        shown: whether it was shown to meet the target; None without one.
        runner_up: the next best, if it was judged on fresh days.
        tried: all designs simulated, with their means in the search.
        runs: simulated for it in all.
    """

    @property
    def design(self) -> str:
        """The best design in words."""
        return design(self.best)

    @property
    def overrides(self) -> dict[str, Any]:
        """What makes the model into the best design."""
        return dict(self.best.overrides)

    @property
    def mean(self) -> float:
        """The indicator of the best design on fresh days, in the model's units; nan where no run ended."""
        return math.nan if self.best.value is None else self.best.value.mean

    @property
    def table(self) -> pd.DataFrame:
        """A row for each design tried, best first: its factors, means in the search, and `runs` in the search."""
        import pandas as pd

        goal = None if self.target is None else self.target.indicator
        return pd.DataFrame(
            {
                **{key.replace(".", "_"): label for key, label in one.labels.items()},
                **({} if goal is None else {goal: one.reached}),
                self.indicator: one.mean,
                "runs": one.runs,
            }
            for one in in_order(self)
        )

    def in_short(self) -> str:
        """Name the best design and its value."""
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


def best(  # half of it says what its arguments mean
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
    """Choose the best design of a study, or of a model with what is to be varied, placed or turned.

    The designs of a study all race: those that are clearly worse by the mean of the indicator drop out early. So do
    those of a model where nothing but keys is varied, without a target, and each design can have ten runs. Else they
    are searched with four fifths of the runs; the last fifth is done on fresh days, and says whether the target is met,
    and what the indicator is.

    Args:
        what: a study, whose runs are used, with its own confidence; or the warehouse, or its file.
        indicator: what should be best; of a study one of its own, too.
        delta: smaller differences do not matter, in the indicator's unit; default: 1 % of the largest of the first
            means.
        target: of a model's designs, what must be met, such as "on_time >= 95 %".
        vary: of a model, key -> its values, in any form of a study file.
        place_chargers: how many nodes of a model have a charger; which is searched. None: chargers stay.
        directions: whether aisles of a model may be turned.
        maximise: whether more is better (default: as usual for the indicator; of one of a study's own it must be said).
        search: how runs are done, at most 500 by default; first look and cap are those of a race.

    Returns:
        The best design and those as good; of designs that were searched the best, with those that were close.

    Raises:
        ModelError: a value that makes no model.
        StudyError: nothing to choose from, too few runs, a bad target, a study with what is for models, an unknown
            indicator, or one of which neither more nor less is better.

    Source: the race is KN, Kim & Nelson (2001). The search is a local one from many starts, judged on other days.
    """
    if isinstance(what, Study):
        if directions or any(one is not None for one in (target, vary, place_chargers)):
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


def answer(found: SearchedDesigns) -> Answer:
    """Put a search for the best design into words; its subject is the best, shown to meet the target or not."""
    best, unproven = found.best, found.shown is False
    head, rows = table(found, in_order(found))
    known = [] if unproven else _numbers(found, best)
    return Answer(
        kind="best",
        name=found.model.name,
        description=found.model.description,
        question=_question(found),
        answer=tuple(sentences(found)),
        measures={name: words.in_sentence(name) for name in _judged_by(found)},
        tiles=tuple(_tiles(found, known)),
        options=tuple(_option(found, one) for one in (best, *found.cheaper, *filter(None, [found.runner_up]))),
        figure=_figure(found),
        about=judged.about(f"{design(best)}{_NOT_SHOWN if unproven else ''}", found.model, found.seed),
        tables=(Folded(title="The search", note=_LUCK, head=tuple(head), rows=tuple(map(tuple, rows))),),
        promise=f"Values are of days that the search has not seen, with {100 * found.confidence:g} % confidence.",
        runs=found.runs,
        confidence=found.confidence,
        made={"seed": str(found.seed), "model": found.model.digest()},
        indicator=found.indicator,
        shown=found.shown,
    )


def _tiles(found: SearchedDesigns, known: list[SaidNumber]) -> list[BigNumber]:
    """What is best, if it is said in few words, and its numbers."""
    name = design(found.best)
    first = [BigNumber(value=name, what=f"the {_best(found)} option")] if len(name) <= _SHORT else []
    return (first if known else []) + [judged.tile(one.text, words.in_sentence(one.of)) for one in known]


def _question(found: SearchedDesigns) -> str:
    if _best(found) == "cheapest":
        return f"What is the cheapest option{f' that gives {_aim(found)}' if found.target else ''}?"
    sense, aim = "largest" if found.maximise else "smallest", f" with {_aim(found)}" if found.target else ""
    return f"With which option is {words.in_sentence(found.indicator)} {sense}{aim}?"


def _best(found: SearchedDesigns) -> str:
    """What an option is called that is best."""
    return "cheapest" if found.indicator == "annual_cost" and not found.maximise else "best"


def _option(found: SearchedDesigns, one: JudgedDesign) -> Option:
    """A design that was judged on fresh days."""
    known = [] if one.vetoed else _numbers(found, one)
    kind: Standing = "known" if one.verdict is None else BY_VERDICT[one.verdict]
    return Option(
        name=design(one),
        standing="drained" if one.vetoed else kind,
        number=known[0] if known else None,
        also=tuple(known[1:]),
        said=one.vetoed or "",
        runs=0 if one.value is None else one.value.n,
        set=dict(one.overrides),
    )


def _figure(found: SearchedDesigns) -> Rows | Points | None:
    """All designs tried: by the indicator and what the target asks for, or without such a target in rows."""
    if found.target is not None and found.target.indicator != found.indicator:
        return _points(found, found.target)
    return _rows(found)


def _points(found: SearchedDesigns, goal: Target) -> Points | None:
    """Draw the designs tried by both indicators: those judged by their fresh days, with their names."""
    judged_ones = (found.best, *found.cheaper, *filter(None, [found.runner_up]))
    fresh = {design(one): one for one in judged_ones if one.value is not None and one.reached is not None}
    points = [
        Dot(x=one.reached, y=one.mean)
        for one in found.tried
        if one.reached is not None and math.isfinite(one.reached + one.mean) and design(one) not in fresh
    ]
    for name, one in fresh.items():
        assert one.value is not None
        assert one.reached is not None
        kind = "met" if one.verdict == "meets" else "not met" if one.verdict == "fails" else "open"
        points.append(Dot(x=one.reached.mean, y=one.value.mean, name=name, standing=kind))
    if not points:
        return None
    ends = []
    for of, values in ((goal.indicator, [one.x for one in points]), (found.indicator, [one.y for one in points])):
        scale = words.scale(of, found.model, values)
        ends += [scale.value(min(values)), scale.value(max(values))]
    return Points(
        title=f"{capital(words.in_sentence(found.indicator))} and {words.in_sentence(goal.indicator)} of all tried",
        across=capital(words.in_sentence(goal.indicator)),
        up=capital(words.in_sentence(found.indicator)),
        at=goal.value,
        at_words=judged.aim(goal),
        ends=(ends[0], ends[1], ends[2], ends[3]),
        points=tuple(points),
    )


def _rows(found: SearchedDesigns) -> Rows | None:
    """Draw the designs judged on fresh days, then others by their means in the search, the best of them first."""
    goal, rows = found.target, []
    for one in (found.best, *found.cheaper, *filter(None, [found.runner_up])):
        numbers = _numbers(found, one)
        if numbers and not one.vetoed:
            kind = "met" if one.verdict == "meets" else "not met" if one.verdict == "fails" else ""
            rows.append(judged.bar(design(one), numbers[-1], kind))
    if not rows:
        return None
    scale = words.scale(found.indicator, found.model, [one.mean for one in found.tried if math.isfinite(one.mean)])
    names = {row.label for row in rows}
    others = [one for one in in_order(found) if math.isfinite(one.mean) and design(one) not in names][:_OTHERS]
    rows += [Bar(label=design(one), mean=one.mean, text=f"{scale.value(one.mean)} in the search") for one in others]
    title = f"{capital(words.in_sentence(goal.indicator if goal else found.indicator))} on fresh days"
    at = found.best.value.mean if goal is None and found.best.value else goal and goal.value
    said = judged.aim(goal) if goal else "the best"
    return Rows(title=title, at=at, at_words=said, rows=tuple(rows))


def sentences(found: SearchedDesigns) -> list[str]:
    """The answer first, then cheaper designs that were not shown to be enough, the runner-up, and what was done."""
    lines = [_answer(found)]
    for one in found.cheaper:
        why = one.vetoed or f"is not shown to give {_aim(found)}"
        lines.append(sentence(f"Better by the search, but {why}: {design(one)} with {_values(found, one)}"))
    if found.runner_up is not None:
        lines.append(_runner_up(found, found.runner_up))
    many = f"{number(found.many)}" if found.many < _COUNTED else f"some 10^{math.floor(math.log10(found.many))}"
    lines.append(f"{len(found.tried)} of {many} options were tried, in {number_of(found.runs, 'run')} in all.")
    return lines


def _answer(found: SearchedDesigns) -> str:
    best = f"{design(found.best)}: {_values(found, found.best)}"
    if found.shown is None:
        return sentence(f"{best}, {_days(found.best)}")
    if found.shown:
        return sentence(f"The {_best(found)} option shown to give {_aim(found)} is {best}, {_days(found.best)}")
    wrong = f"; but {found.best.vetoed}" if found.best.vetoed else ""
    return sentence(f"No option was shown to give {_aim(found)}; best by the search is {best}{wrong}")


def _runner_up(found: SearchedDesigns, other: JudgedDesign) -> str:
    apart = found.apart
    line = f"Next: {design(other)} with {_values(found, other)}"
    if apart is None:
        return sentence(line)
    scale = words.scale(found.indicator, found.model, [apart.mean])
    low, high = apart.interval or (apart.mean, apart.mean)
    if not apart.mean and not apart.sd:
        return sentence(f"{line}; no difference in {number_of(apart.n, 'pair')} of runs: take either")
    exact = found.indicator == "annual_cost" and is_fixed(found.model.prices)
    told = scale.value(apart.mean) if exact else scale.within(apart.mean, low, high)
    line += f"; the difference is {told} in {number_of(apart.n, 'pair')} of runs"
    if max(abs(low), abs(high)) < found.delta:
        line += f", less than {scale.value(found.delta)}: take either"
    return sentence(line)


def design(one: JudgedDesign | TriedDesign) -> str:
    """A design as one says it; without its directions where none is turned."""
    labels = dict(one.labels)
    at, turned = labels.pop(ChargerNodes.key, None), labels.pop(AisleWays.key, None)
    said = [words.design_spoken(labels)] if labels else []
    said += [] if at is None else [f"chargers at {spoken(str(at).split(', '))}"]
    said += [] if turned is None else [f"{turned} turned" if turned != AisleWays.drawn_label else "aisles as drawn"]
    return ", ".join(said)


def _values(found: SearchedDesigns, one: JudgedDesign) -> str:
    """The value of the indicator, and of the target, with their intervals."""
    said = [words.reached(number.of, number.text) for number in _numbers(found, one)]
    return ", ".join(said) or "no run that ended"


def _judged_by(found: SearchedDesigns) -> list[str]:
    """The indicator, and the one that the target is about."""
    return [found.indicator, *([] if found.target is None else [found.target.indicator])]


def _numbers(found: SearchedDesigns, one: JudgedDesign) -> list[SaidNumber]:
    means: dict[str, tuple[Estimate | None, float | None]] = {found.indicator: (one.value, None)}
    if found.target is not None:
        means[found.target.indicator] = (one.reached, found.target.value)
    return [
        judged.within(
            name, words.scale(name, found.model, [mean.mean]), (mean.mean, *(mean.interval or (None, None))), aim
        )
        for name, (mean, aim) in means.items()
        if mean is not None
    ]


def _days(one: JudgedDesign) -> str:
    return "" if one.value is None else f"in {number_of(one.value.n, 'run')} on fresh days"


def _aim(found: SearchedDesigns) -> str:
    return "" if found.target is None else words.target(found.target)


def in_order(found: SearchedDesigns) -> list[TriedDesign]:
    """All designs tried: those first whose runs in the search meet the target, the best of them first."""
    sign = 1 if found.maximise else -1

    def rank(one: TriedDesign) -> tuple[bool, float]:
        is_met = found.target is None or (one.reached is not None and found.target.met_by(one.reached))
        return not is_met, -sign * one.mean if math.isfinite(one.mean) else math.inf

    return sorted(found.tried, key=rank)


def table(found: SearchedDesigns, shown: Sequence[TriedDesign]) -> tuple[list[str], list[list[str]]]:
    """The head and the rows of a table of designs tried, with their means in the search."""
    keys = list(found.best.labels)
    goal = [] if found.target is None else [found.target.indicator]
    names = list(dict.fromkeys([found.indicator, *goal]))
    scales = {name: words.scale(name, found.model, [one.mean for one in shown]) for name in names}
    head = [words.factor_head(key, found.model.units) for key in keys]
    head += [words.head(name, scale) for name, scale in scales.items()]
    rows = []
    for one in shown:
        values = {found.indicator: one.mean, **dict.fromkeys(goal, one.reached)}
        cells = [words.level(one.labels[key]) for key in keys]
        cells += [scales[name].single(math.nan if value is None else value) for name, value in values.items()]
        rows.append([*cells, str(one.runs)])
    return [*head, "runs in the search"], rows
