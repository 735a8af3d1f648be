"""What is said of inputs that are not known exactly: where they tip the answer, and what knowing them is worth."""

from __future__ import annotations

import math
from typing import Any

from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.answered import answer_of
from desim_warehouse.answer.numbers import Scale, capital, number, percent, plural, sentence
from desim_warehouse.answer.parts import BigNumber, Folded, Option, SaidNumber, Subject
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.questions import judged
from desim_warehouse.study.tipping import GOOD_FIT, InputEffect, TippingPoint, TippingPoints

_EFFECT, _WORTH = "robots", "worth"
"""What the numbers of an input are of."""


@answer_of.register
def answer(found: TippingPoints) -> Answer:
    """How many robots are safe, what not knowing costs, then each input, the one most worth knowing first."""
    model = found.model
    keys = [words.in_words(one.key) for one in found.inputs]
    vary = f"{spoken(keys)} turn{'s' * (len(keys) == 1)} out to be" if keys else "is not known exactly"
    options = tuple(_option(found, one) for one in found.inputs)
    bars = (judged.bar(one.name, one.number) for one in options if one.number is not None)
    title = "Robots that the highest value needs more than the lowest"
    return Answer(
        kind="tipping",
        name=model.name,
        description=model.description,
        question=f"How many robots give {words.target(found.target)}, whatever {vary}?",
        answer=tuple(_sentences(found)),
        tiles=tuple(_tiles(found)),
        measures={_EFFECT: "robots over its range", _WORTH: "worth knowing, a year"},
        options=options,
        figure=judged.figure(title, bars, 0.0, "no difference"),
        about=_about(found),
        tables=tuple(tables(found)),
        promise=_promise(found),
        runs=found.runs,
        confidence=found.confidence,
        made={"seed": str(found.seed), "model": model.digest()},
        **facts(found),
    )


def in_short(found: TippingPoints) -> str:
    """The same in one sentence: the robots that are safe, and where the input most worth knowing tips the answer."""
    if not found.says_something:
        return _poor(found)
    first = found.inputs[0]
    most = f"{words.in_words(first.key)} counts most: {_tips(found, first)}"
    return f"Allowing for what is not known exactly, {_robots(found.safe)} {_are(found.safe)} safe; {most}."


def tables(found: TippingPoints) -> list[Folded]:
    """Where the answer tips, and what knowing better is worth: a row for each input."""
    rows = tuple(
        (_named(found, one), _tips(found, one), _effect(one).text, _worth(found, one.worth)) for one in found.inputs
    )
    head = ("input", "where the answer tips", "robots over its range", "worth knowing, a year")
    note = " ".join(_sentences(found)[:1] if rows else _sentences(found))
    return [Folded(title="What is not known exactly", note=note, head=head, rows=rows)]


def facts(found: TippingPoints) -> dict[str, Any]:
    """What only this question knows, as JSON has it."""
    return {
        "fit": _finite(found.fit),
        "robots": found.robots,
        "safe": found.safe,
        "doubt": _finite(found.doubt),
        "cost": _finite(found.cost),
        "inputs": {
            one.key: {
                "low": one.low,
                "high": one.high,
                "effect": one.effect,
                "error": one.error,
                "worth": one.worth,
                "open": one.open,
                "tips": [
                    {
                        "robots": tip.robots,
                        "too_few": "above" if tip.above else "below",
                        "at": tip.at,
                        "interval": [tip.low, tip.high],
                        "confirmed": tip.confirmed,
                    }
                    for tip in one.tips
                ],
            }
            for one in found.inputs
        },
    }


# Sentences


def _sentences(found: TippingPoints) -> list[str]:
    if not found.says_something:
        return [_poor(found), "Narrower ranges, or fewer inputs, may help."]
    safe = f"{capital(_robots(found.safe))} {_are(found.safe)} safe: the chance of too few is {_doubt(found)}"
    middle = f"In the middle of all ranges {_robots(found.robots)} {_are(found.robots)} enough"
    lines = [f"{safe}.", f"{middle}; not knowing better costs {_worth(found, found.cost)} a year."]
    return lines + [_input(found, one) for one in found.inputs]


def _poor(found: TippingPoints) -> str:
    """Why nothing is said."""
    at = "too few points could be judged" if math.isnan(found.fit) else f"R² is {number(found.fit, 3)}"
    return f"Nothing is said of where the answer tips: {at}, and lines describe it from R² {GOOD_FIT:g} on."


def _input(found: TippingPoints, one: InputEffect) -> str:
    said = f"{capital(_named(found, one))}: {_tips(found, one)}"
    return sentence(f"{said}; knowing it is worth {_worth(found, one.worth)} a year")


def _promise(found: TippingPoints) -> str:
    if not found.says_something:
        return ""
    sure = f"{100 * found.confidence:g} %"
    return (
        f"All values within the ranges are taken as equally likely: safe is what is enough in {sure} of them. Each "
        f"interval holds with 95 % confidence. Lines describe the robots needed with R² {number(found.fit, 3)}."
    )


def _named(found: TippingPoints, one: InputEffect) -> str:
    """An input with its range: `load time, 5 to 20 s`."""
    low, high = (_value(end, "") for end in (one.low, one.high))
    return f"{words.in_words(one.key)}, {low} to {high}{_unit(words.factor_unit(one.key, found.model.units), one.high)}"


def _tips(found: TippingPoints, one: InputEffect) -> str:
    unit = words.factor_unit(one.key, found.model.units)
    tips = [_tip(tip, unit) for tip in one.tips]
    if one.open:
        tips.append(f"{number_of(one.open, 'more threshold')} not looked at, as no runs were left")
    return "; ".join(tips) or "as many robots over all of its range"


def _tip(tip: TippingPoint, unit: str) -> str:
    """`8 robots above 15.2 s (14.1 to 16)`, as one more than are enough on the other side."""
    side = "above" if tip.above else "below"
    ends = f"({_value(tip.low, '')} to {_value(tip.high, '')})"
    perhaps = "" if tip.confirmed else "perhaps "
    unsure = "" if tip.confirmed else ", not confirmed on both sides"
    return f"{perhaps}{_robots(tip.robots + 1)} {side} {_value(tip.at, unit)} {ends}{unsure}"


# Numbers


def _tiles(found: TippingPoints) -> list[BigNumber]:
    if not found.says_something:
        return []
    return [
        BigNumber(value=str(found.safe), what=f"robot{'s' * (found.safe != 1)} to be safe"),
        BigNumber(value=_doubt(found), what="chance of too few"),
        BigNumber(value=_worth(found, found.cost), what="a year for not knowing"),
    ]


def _option(found: TippingPoints, one: InputEffect) -> Option:
    worth = judged.within(_WORTH, Scale(), (one.worth, None, None))
    return Option(
        name=_named(found, one),
        standing="known",
        number=_effect(one),
        also=(worth.model_copy(update={"text": _worth(found, one.worth)}),),
        runs=found.runs,
    )


def _effect(one: InputEffect) -> SaidNumber:
    """How many robots more the highest value needs than the lowest."""
    return judged.within(_EFFECT, Scale(), (one.effect, one.effect - one.error, one.effect + one.error), 0.0)


def _about(found: TippingPoints) -> Subject | None:
    """The robots that are safe, in the middle of all ranges."""
    if not found.says_something:
        return None
    middle = {one.key: (one.low + one.high) / 2 for one in found.inputs}
    name = f"{_robots(found.safe)}, in the middle of all ranges"
    return judged.about(name, found.model.replace({**middle, "fleet.size": found.safe}), found.seed)


def _doubt(found: TippingPoints) -> str:
    return f"{percent(found.doubt)} %"


def _robots(count: int) -> str:
    return words.fleet(count, 0)


def _are(count: int) -> str:
    return "is" if count == 1 else "are"


def _value(value: float, unit: str) -> str:
    return f"{number(float(f'{value:.3g}'))}{_unit(unit, value)}"


def _unit(unit: str, value: float) -> str:
    return f" {plural(unit, value)}" if unit else ""


def _worth(found: TippingPoints, amount: float) -> str:
    """Money, or robots where these have no price."""
    if found.priced:
        return Scale(words.money(found.model)).value(float(f"{amount:.3g}"))
    return f"{number(float(f'{amount:.2g}'))} robots"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
