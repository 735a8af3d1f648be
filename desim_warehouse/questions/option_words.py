"""The answer of `desim plan --option`: which of some options is cheapest, by how much, and the plan of each."""

from __future__ import annotations

from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.answered import answer_of
from desim_warehouse.answer.parts import Option
from desim_warehouse.errors import spoken
from desim_warehouse.study.fleet.options import COST, Against, OptionsPlan


@answer_of.register
def answer(found: OptionsPlan) -> Answer:
    """What `desim plan --option` found."""
    answers = {name: plan.answer for name, plan in found.plans.items()}
    shown = answers[found.first or next(iter(answers))]
    named = [f"{name}: {one.answer[0]}" for name, one in answers.items()]
    fails = [name for name, one in answers.items() if not one.about]
    last = f" {spoken(fails)} {'is' if len(fails) == 1 else 'are'} not compared." if fails and found.first else ""
    return shown.model_copy(
        update={
            "question": f"Which of {spoken(list(found.plans))}, for {_target(found)}?",
            "answer": (*([f"{_compared(found)}{last}"] if found.against else []), *named),
            "options": tuple(_of(name, option) for name, one in answers.items() for option in one.options),
            "figure": None,
            "promise": _promise(found),
            "runs": found.runs,
            "confidence": found.confidence,
            "feasible": found.feasible,
            "first": found.first,
            "compared": [
                {"option": one.name, "indicator": found.indicator, "mean": one.mean, "low": one.low, "high": one.high}
                for one in found.against
            ],
            "plans": {name: one.content()["today"] for name, one in answers.items()},
        }
    )


def _compared(found: OptionsPlan) -> str:
    """The first option against each of the others: `B is cheaper than A by 2,000 a year (1,200 to 2,900).`."""
    untold = [one.name for one in found.against if not one.told]
    close = f"; too close to tell from {spoken(untold)}" if untold else ""
    if found.indicator == COST:
        than = spoken([f"than {one.name} by {_difference(found, one)}" for one in found.against])
        return f"{found.first} is cheaper {than}{close}."
    by = spoken([f"with that of {one.name} by {_difference(found, one)}" for one in found.against])
    what = words.in_sentence(found.indicator)
    return f"{found.first} needs the fewest robots. On the same days {what} differs {by}{close}."


def _difference(found: OptionsPlan, one: Against) -> str:
    """By how much an option is above the first, with its interval."""
    model = found.plans[one.name].model
    priced = found.indicator == COST
    scale = numbers.Scale(words.money(model)) if priced else words.scale(found.indicator, model, (one.mean,))
    text = f"{scale.value(one.mean)}{' a year' * priced}"
    return text if one.low == one.high else f"{text} ({scale.value(one.low)} to {scale.value(one.high)})"


def _of(name: str, option: Option) -> Option:
    return option.model_copy(update={"group": f"option {name}"})


def _target(found: OptionsPlan) -> str:
    return words.target(next(iter(found.plans.values())).target)


def _promise(found: OptionsPlan) -> str:
    first = next(iter(found.plans.values()))
    zone = words.amount(first.target.indicator, first.zone, first.target.unit)
    saves = " Costs allow for fewer, where those are not shown to miss it." if found.indicator == COST else ""
    return (
        f"With {100 * found.confidence:g} % confidence all of this holds at once: each fleet reaches {_target(found)}, "
        f"and no smaller one is better than that by {zone} or more.{saves} This takes it that more never does worse."
    )
