"""The race among all designs of a study for the best mean, and its answer: the best design and those as good."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer, Answered
from desim_warehouse.answer.numbers import capital, sentence
from desim_warehouse.answer.parts import Option, Rows
from desim_warehouse.answer.standing import Standing
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.questions import judged
from desim_warehouse.questions.sentences import not_tried, wrong
from desim_warehouse.questions.study import Study
from desim_warehouse.study.procedures import Raced, race
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.selection import Selection


@dataclass(frozen=True, repr=False)
class Best(Answered, Raced):
    """The best design of a study, and the designs that are as good: the result of `best` when all designs race.

    Attributes:
        answer: the answer in words; shown by `print`.
        point: the best design.
        within: designs shown to be worse by less than delta.
        indicator: the indicator that was compared.
        selection: means, runs, and the look at which each design dropped out.
        study: the study with all its runs.
    """

    @property
    def design(self) -> str:
        """The best design in words."""
        return words.design_spoken(self.point.labels)

    @property
    def overrides(self) -> dict[str, Any]:
        """The overrides that turn the base model into the best design."""
        return dict(self.point.overrides)

    @property
    def mean(self) -> float:
        """The mean of the indicator with the best design, in the model's units."""
        return self.selection.means[self.selection.best]

    def in_short(self) -> str:
        """Return the best design and its mean in a few words."""
        return f"{self.design}: {self.indicator} {self.mean:g}"


def best_of_study(
    study: Study,
    indicator: str,
    delta: float | None = None,
    *,
    maximise: bool | None = None,
    search: Search = USUAL,
) -> Best:
    """Choose the best design of a study by the mean of an indicator.

    Designs that are clearly worse drop out early, so far fewer runs are needed than equally many for all. Runs are
    stored where `Study.run` would store them, and stored runs are used.

    Args:
        study: its designs are the candidates, and its confidence holds for the choice.
        indicator: the indicator that is compared.
        delta: indifference zone in the indicator's unit: smaller differences do not matter. Default: 1 % of the largest
            mean of the first replications.
        maximise: whether larger is better (default: as usual for the indicator).
        search: settings of runs; confidence, seed and time limit are the study's.

    Raises:
        StudyError: unknown indicator, fewer than two designs, or a run that failed.

    Source: KN, Kim & Nelson (2001); `statistics.kn_steps` states the guarantee and its assumptions.
    """
    return worded(race(study, indicator, delta, maximise=maximise, search=search), search)


def worded(raced: Raced, search: Search = USUAL) -> Best:
    """Add the answer to a race, and write it to the folder of the search."""
    return Best(**vars(raced), answer=answer(raced).keep(search.out, search.command))


def answer(raced: Raced, kind: str = "best", besides: tuple[str, ...] = ()) -> Answer:
    """Put a race into words, with further sentences (`besides`)."""
    selection, study = raced.selection, raced.study
    model, title = study.plan.base, words.in_sentence(raced.indicator)
    zone = words.scale(raced.indicator, model, selection.means).value(selection.delta)
    sense = "largest" if raced.maximise else "smallest"
    options = tuple(_options(raced))
    problems = [sentence(line) for line in wrong(study.results, lasting=True)]
    [best] = [option for option in options if option.standing == "first"]
    first = f"{capital(title)} is {sense}, {best.text}, with {best.name}."
    return Answer(
        kind=kind,
        name=model.name,
        description=model.description,
        question=f"With which option is {title} {sense}?",
        answer=(first, *_as_good(raced, zone), *besides, *problems),
        tiles=(judged.tile(best.text, title),),
        measures={raced.indicator: title},
        options=options,
        figure=Rows(
            title=capital(title), rows=tuple(judged.bar(option.name, option.numbers[0], "part") for option in options)
        ),
        about=judged.about(best.name, model.replace(raced.point.overrides), study.plan.seed),
        promise=_promise(selection, zone),
        notes=tuple(not_tried(raced.not_tried)),
        runs=sum(selection.samples),
        confidence=selection.confidence,
        made={"seed": str(study.plan.seed), "model": model.digest()},
        indicator=raced.indicator,
        delta=selection.delta,
    )


def _as_good(raced: Raced, zone: str) -> list[str]:
    """Return the sentences on the designs shown to be worse by less than the indifference zone."""
    equal = raced.selection.equal
    same = [words.design_spoken(point.labels) for point in raced.within if point.number in equal]
    names = [words.design_spoken(point.labels) for point in raced.within if point.number not in equal]
    runs = number_of(raced.selection.samples[raced.selection.best], "run")
    parts = [f"The same in all {runs}, so just as good: {spoken(same)}."] if same else []
    return [*parts, *([f"Worse by less than {zone}, so as good: {spoken(names)}."] if names else [])]


def _options(raced: Raced) -> list[Option]:
    means = raced.selection.means
    scale = words.scale(raced.indicator, raced.study.plan.base, means)
    return [
        Option(
            name=words.design_spoken(point.labels),
            standing=_standing(raced.selection, point.number),
            number=judged.within(raced.indicator, scale, (means[point.number], None, None)),
            runs=raced.selection.samples[point.number],
            set=dict(point.overrides),
        )
        for point in raced.study.points
    ]


def _standing(selection: Selection, design: int) -> Standing:
    if design == selection.best:
        return "first"
    if design in selection.within:
        return "near"
    return "open" if selection.eliminated_at[design] is None else "worse"


def _promise(selection: Selection, zone: str) -> str:
    """Return the guarantee of a choice, with its indifference zone in the unit of the indicator."""
    if not selection.guaranteed:
        left = len(selection.survivors)
        most = number_of(sum(selection.samples), "run")
        return f"{left} options were left after {most} in all: this is the best mean, without a guarantee."
    if selection.deterministic:
        return "Nothing in this model is random: the options are compared by exact numbers."
    sure = f"{100 * selection.confidence:g} %"
    return f"With {sure} confidence this is the best option, if it leads by at least {zone} (KN, Kim & Nelson 2001)."
