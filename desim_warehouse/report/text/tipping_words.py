"""What is said of inputs that are not known exactly: where they tip the answer, and what knowing them is worth."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import number_of
from desim_warehouse.report.text import words
from desim_warehouse.report.text.numbers import Scale, number, percent, plural
from desim_warehouse.report.text.sentences import sentence
from desim_warehouse.study.tipping import GOOD_FIT

if TYPE_CHECKING:
    from desim_warehouse.model import Model
    from desim_warehouse.study.tipping import InputEffect, TippingPoint, TippingPoints


def sentences(found: TippingPoints, model: Model) -> list[str]:
    """How many robots are safe, what not knowing costs, then each input, the one most worth knowing first."""
    fit = number(found.fit, 3)
    if not found.says_something:
        said = "too few of its points could be told" if math.isnan(found.fit) else f"R² is {fit}"
        poor = f"Nothing is said of where the answer tips: {said}, and lines describe it from R² {GOOD_FIT:g} on"
        return [sentence(poor), "Narrower ranges, or fewer inputs, may help."]
    doubt, cost = percent(found.doubt), _worth(found, found.cost, model)
    safe = f"{_robots(found.safe)} to be safe ({doubt} % that they are too few)"
    costs = f"Not knowing better costs {cost} a year (R² {fit}, {found.runs} runs)."
    lines = [f"In the middle of all ranges {_robots(found.robots)}; {safe}. {costs}"]
    return lines + [sentence(_input(found, one, model)) for one in found.inputs]


def in_short(found: TippingPoints, model: Model) -> str:
    """The same in one sentence: the robots that are safe, and where the input most worth knowing tips the answer."""
    if not found.says_something:
        return sentences(found, model)[0]
    first = found.inputs[0]
    safe = f"{_robots(found.safe)} {'is' if found.safe == 1 else 'are'} safe"
    most = f"{words.in_words(first.key)} counts most: {_tips(first, model)}"
    return f"Allowing for what is not known exactly, {safe}; {most}."


def table(found: TippingPoints, model: Model) -> tuple[list[str], list[list[str]]]:
    """The head and the rows of a table of the inputs, the one most worth knowing first."""
    head = ["input", "where the answer tips", "range", "robots over the range", "worth knowing, a year"]
    return head, [
        [
            words.factor_name(one.key),
            _tips(one, model),
            _range(one, model),
            _effect(one),
            _worth(found, one.worth, model),
        ]
        for one in found.inputs
    ]


def _input(found: TippingPoints, one: InputEffect, model: Model) -> str:
    said = f"{words.factor_name(one.key)}, {_range(one, model)}: {_effect(one)} robots over the range"
    return f"{said}; {_tips(one, model)}; knowing it is worth {_worth(found, one.worth, model)} a year"


def _range(one: InputEffect, model: Model) -> str:
    low, high = (_value(end, "") for end in (one.low, one.high))
    return f"{low} to {high}{_unit(words.factor_unit(one.key, model.units), one.high)}"


def _effect(one: InputEffect) -> str:
    return f"{one.effect:+.1f} ± {one.error:.1f}".replace("-", "\N{MINUS SIGN}")


def _tips(one: InputEffect, model: Model) -> str:
    unit = words.factor_unit(one.key, model.units)
    tips = [_tip(tip, unit) for tip in one.tips]
    if one.open:
        tips.append(f"{number_of(one.open, 'more threshold')} not looked at, as no runs were left")
    return "; ".join(tips) or "the answer turns nowhere"


def _tip(tip: TippingPoint, unit: str) -> str:
    """`8 robots above 15.2 s (14.1 to 16)`, as one more than are enough on the other side."""
    side = "above" if tip.above else "below"
    ends = f"({_value(tip.low, '')} to {_value(tip.high, '')})"
    perhaps = "" if tip.confirmed else "perhaps "
    unsure = "" if tip.confirmed else ", not confirmed on both sides"
    return f"{perhaps}{_robots(tip.robots + 1)} {side} {_value(tip.at, unit)} {ends}{unsure}"


def _robots(count: int) -> str:
    return words.fleet(count, 0)


def _value(value: float, unit: str) -> str:
    return f"{number(float(f'{value:.3g}'))}{_unit(unit, value)}"


def _unit(unit: str, value: float) -> str:
    return f" {plural(unit, value)}" if unit else ""


def _worth(found: TippingPoints, amount: float, model: Model) -> str:
    """Money, or robots where these have no price."""
    if found.priced:
        return Scale(words.money(model)).value(float(f"{amount:.3g}"))
    return f"{number(float(f'{amount:.2g}'))} robots"


def content(found: TippingPoints, model: Model) -> dict[str, Any]:
    """The same as JSON and plan.json have it."""
    head, rows = table(found, model)
    return {
        "answer": sentences(found, model),
        "in_short": in_short(found, model),
        "table": [head, *rows],
        "fit": None if math.isnan(found.fit) else found.fit,
        "robots": found.robots,
        "safe": found.safe,
        "doubt": None if math.isnan(found.doubt) else found.doubt,
        "cost": None if math.isnan(found.cost) else found.cost,
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
        "runs": found.runs,
    }
