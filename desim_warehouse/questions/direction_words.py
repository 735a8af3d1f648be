"""What is said of directions that a search found."""

from __future__ import annotations

from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.answered import answer_of
from desim_warehouse.answer.numbers import Scale
from desim_warehouse.answer.parts import Option, SaidNumber
from desim_warehouse.answer.standing import Standing
from desim_warehouse.errors import number_of
from desim_warehouse.questions import judged
from desim_warehouse.study.designs.directions import BetterDirections, DirectionGain

_STANDING: dict[bool | None, Standing] = {True: "differs", False: "worse", None: "alike"}


@answer_of.register
def answer(found: BetterDirections) -> Answer:
    """What `desim orient --indicator` found: what is turned, what that gains, and with which fleets and demands."""
    model, of = found.model, words.in_sentence(found.indicator)
    places = [] if found.gain is None else [found.gain, *found.elsewhere]
    options = tuple(
        Option(
            name=one.where or "as it is",
            standing=_STANDING[one.is_better],
            number=SaidNumber(of=found.indicator, mean=one.mean, low=one.low, high=one.high, text=_gain(one)),
            runs=2 * one.pairs,
        )
        for one in places
    )
    bars = (judged.bar(one.name, one.number, one.standing) for one in options if one.number is not None)
    return Answer(
        kind="orient",
        name=model.name,
        description=model.description,
        question=f"Which way should aisles lead for the best {of}?",
        answer=tuple(sentences(found)),
        measures={found.indicator: f"gain in {of}"},
        options=options,
        figure=judged.figure(f"What turned aisles gain in {of}, of that as drawn", bars, 0.0, "no gain"),
        promise=judged.each(found.confidence),
        runs=found.runs,
        confidence=found.confidence,
        made={"model": model.digest()},
    )


def sentences(found: BetterDirections) -> list[str]:
    """The answer: what is turned, what that gains on fresh days, for which fleets and demands it holds, its price."""
    if found.gain is None:
        return [f"No better directions found than those drawn, in {number_of(found.runs, 'run')}."]
    verdict = {True: "", False: ", which is worse", None: ", which may be chance"}[found.gain.is_better]
    name = words.indicator_name(found.indicator)
    gains = f"{name}: {_gain(found.gain)} in {found.gain.pairs} pairs of runs on fresh days"
    lines = [f"{len(found.turned)} of {found.units} turned: {'; '.join(found.turned)}.", f"{gains}{verdict}."]
    for is_better, said in ((True, "It holds"), (None, "It may be chance"), (False, "It is worse")):
        places = [f"{one.where}, {_gain(one)}" for one in found.elsewhere if one.is_better is is_better]
        if places:
            lines.append(f"{said} with {'; '.join(places)}.")
    if found.cost:
        lines.append(f"Turning costs {Scale(words.money(found.model)).value(found.cost)} once.")
    return lines


def _gain(gain: DirectionGain) -> str:
    low, mean, high = (
        f"{100 * share:+.1f}".replace("-", "\N{MINUS SIGN}") for share in (gain.low, gain.mean, gain.high)
    )
    return f"{mean} % ({low} to {high})"
