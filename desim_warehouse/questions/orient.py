"""The verb `orient`, which chooses directions of aisles, and its answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import overload

from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer, Answered
from desim_warehouse.answer.numbers import Scale
from desim_warehouse.answer.parts import Option, ShownNumber
from desim_warehouse.answer.standing import Standing
from desim_warehouse.errors import number_of
from desim_warehouse.model import Model, Source, as_model
from desim_warehouse.model.oriented import orientation, oriented
from desim_warehouse.questions import judged
from desim_warehouse.study.designs.directions import DirectionGain, SearchedDirections, search_directions
from desim_warehouse.study.search import USUAL, Search

_STANDING: dict[bool | None, Standing] = {True: "differs", False: "worse", None: "alike"}


@dataclass(frozen=True, repr=False)
class BetterDirections(Answered, SearchedDirections):
    """The best directions of aisles: the result of `orient` with an indicator.

    Attributes:
        answer: the answer in words; shown by `print`.
        model: the warehouse with these directions.
        turned: the aisles that are reversed.
        gain: the resulting gain; None if nothing better than the floor as drawn was found.
        cost: the one-off cost of reversing the aisles.
        runs: total number of runs simulated.
    """

    def in_short(self) -> str:
        """Return the number of reversed aisles and the gain in a few words."""
        gain = "no gain" if self.gain is None else f"{self.indicator} {100 * self.gain.mean:+.3g} %"
        return f"{len(self.turned)} of {self.units} turned: {gain}"


@overload
def orient(model: Source, indicator: None = None) -> Model: ...
@overload
def orient(model: Source, indicator: str, *, search: Search = USUAL) -> BetterDirections: ...


def orient(model: Source, indicator: str | None = None, *, search: Search = USUAL) -> Model | BetterDirections:
    """Make two-way lanes of a model one-way, or find the directions of aisles that are best for an indicator.

    Without an indicator, the directions keep trips between goods and stations short; bridges stay two-way. With an
    indicator, directions are searched by simulation: rows and columns of blocks are turned as a whole, other lanes
    between junctions one by one or by aisles. Two-way lanes may become one-way, or prefer a direction. Every node stays
    within reach of every other. The search and the final comparison use different days, so that the gain is not due to
    selection.

    Args:
        model: the warehouse, or its file.
        indicator: the indicator to optimise; None: keep trips short, and return a model.
        search: settings of runs, at most 500 by default.

    Returns:
        The model with these directions; with an indicator, the directions and their gain, see `BetterDirections`.

    Raises:
        ModelError: no two-way lane, or goods and stations that cannot reach each other.
        StudyError: nothing can be turned, too few runs, or an indicator without a better direction.

    Source: a local search from many starts, judged on other days.
    """
    model = as_model(model)
    if indicator is None:
        return oriented(model, orientation(model))
    return worded(search_directions(model, indicator, search), search)


def worded(turned: SearchedDirections, search: Search = USUAL) -> BetterDirections:
    """Add the answer to directions, and write it to the folder of the search."""
    return BetterDirections(**vars(turned), answer=answer(turned).keep(search.out, search.command))


def answer(directions: SearchedDirections) -> Answer:
    """Put directions into words: the turned aisles, their gain, and the gain with other fleets and demands."""
    model, indicator = directions.model, words.in_sentence(directions.indicator)
    places = [] if directions.gain is None else [directions.gain, *directions.elsewhere]
    options = tuple(
        Option(
            name=gain.where or "as it is",
            standing=_STANDING[gain.is_better],
            number=ShownNumber(of=directions.indicator, mean=gain.mean, low=gain.low, high=gain.high, text=_gain(gain)),
            runs=2 * gain.pairs,
        )
        for gain in places
    )
    bars = (judged.bar(row.name, row.number, row.standing) for row in options if row.number is not None)
    return Answer(
        kind="orient",
        name=model.name,
        description=model.description,
        question=f"Which way should aisles lead for the best {indicator}?",
        answer=tuple(sentences(directions)),
        measures={directions.indicator: f"gain in {indicator}"},
        options=options,
        figure=judged.figure(f"What turned aisles gain in {indicator}, of that as drawn", bars, 0.0, "no gain"),
        promise=judged.each(directions.confidence),
        runs=directions.runs,
        confidence=directions.confidence,
        made={"model": model.digest()},
    )


def sentences(directions: SearchedDirections) -> list[str]:
    """Return the sentences on the turned aisles, their gain on fresh days, where the gain holds, and the price."""
    if directions.gain is None:
        return [f"No directions were found that are better than those drawn, in {number_of(directions.runs, 'run')}."]
    verdict = {True: "", False: ", which is worse", None: ", which may be chance"}[directions.gain.is_better]
    name = words.indicator_name(directions.indicator)
    gains = f"{name}: {_gain(directions.gain)} in {directions.gain.pairs} pairs of runs on fresh days"
    turned = f"{len(directions.turned)} of {directions.units} turned: {'; '.join(directions.turned)}."
    lines = [turned, f"{gains}{verdict}."]
    for is_better, lead in ((True, "The gain holds"), (None, "The gain may be chance"), (False, "The result is worse")):
        places = [f"{place.where}, {_gain(place)}" for place in directions.elsewhere if place.is_better is is_better]
        if places:
            lines.append(f"{lead} with {'; '.join(places)}.")
    if directions.cost:
        lines.append(f"Turning costs {Scale(words.money(directions.model)).value(directions.cost)} once.")
    return lines


def _gain(gain: DirectionGain) -> str:
    low, mean, high = (
        f"{100 * share:+.1f}".replace("-", "\N{MINUS SIGN}") for share in (gain.low, gain.mean, gain.high)
    )
    return f"{mean} % ({low} to {high})"
