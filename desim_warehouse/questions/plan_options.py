"""Which of some options is cheapest: `plan_options`, and its answer, by how much, with the plan of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.answer import Answer, Answered
from desim_warehouse.answer.parts import Option
from desim_warehouse.errors import spoken
from desim_warehouse.model import Source, as_model
from desim_warehouse.questions import plan, plan_cells
from desim_warehouse.questions.plan import Plan
from desim_warehouse.study.fleet.options import COST, Against, ComparedOptions, compare_options
from desim_warehouse.study.search import USUAL, Search

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class OptionsPlan(Answered, ComparedOptions):
    """The plans of named options and how they compare: what `plan_options` found.

    Attributes:
        answer: in words; printing prints it.
        plans: by name the plan of each option, with an answer of its own.
        first: the cheapest of those that are enough; None: none is.
        against: by how much each other one differs from it.
        indicator: in which they are compared, `annual_cost` where there are prices.
        runs: simulated for it in all.
    """

    plans: Mapping[str, Plan]

    @property
    def table(self) -> pd.DataFrame:
        """A row for each fleet of each option: the option, then the columns of `Plan.table`."""
        import pandas as pd

        tables = [plan.table.assign(option=name) for name, plan in self.plans.items()]
        whole = pd.concat(tables, ignore_index=True)
        return whole[["option", *(name for name in whole if name != "option")]]

    def in_short(self) -> str:
        """Name the first option, then the fleet of each."""
        fleets = [f"{name}: {plan.in_short()}" for name, plan in self.plans.items()]
        return "; ".join([f"{self.first} first" if self.first else "none is enough", *fleets])


def plan_options(
    options: Mapping[str, Source],
    target: str,
    *,
    strategies: Mapping[str, Any] | None = None,
    robots: Sequence[int] | str | None = None,
    chargers: Sequence[int] | str | None = None,
    packers: str | None = None,
    zone: float | str | None = None,
    search: Search = USUAL,
) -> OptionsPlan:
    """Plan each of some options, and compare the cheapest designs that are enough on the same days.

    Args:
        options: by name the warehouse with each of them, or its file.
        target: such as "on_time >= 95 %", one for all options.
        strategies: key of the model -> its values, to be tried with designs too small (default: none).
        robots: fleet sizes that could be bought, such as "6..20" (default: around what the quick estimate needs).
        chargers: likewise.
        packers: a station and who may work there, such as "packing=1..4"; None: as many as the models have.
        zone: indifference zone in the unit of the target; default: 0.01 for shares, else 1 % of the target.
        search: for all plans together: each has an equal part of the error, and so have the days.

    Returns:
        The plan of each option, the first of them against the others, and the answer in words; see `OptionsPlan`.

    Raises:
        StudyError: fewer than two options, some with prices and some without, or as of `plan`.

    Source: paired differences on the same days. The ends of a difference in cost are as far apart as the costs of
    fleets that were not shown to miss the target leave open.
    """
    models = {name: as_model(model) for name, model in options.items()}
    compared = compare_options(
        models,
        target,
        strategies=strategies or {},
        robots=robots,
        chargers=chargers,
        packers=packers,
        zone=zone,
        search=search,
    )
    plans = {name: plan.worded(sizes, search.under(name)) for name, sizes in compared.plans.items()}
    whole = answer(compared, {name: one.answer for name, one in plans.items()})
    return OptionsPlan(**vars(compared) | {"plans": plans}, answer=whole.keep(search.out, search.command))


def answer(found: ComparedOptions, answers: Mapping[str, Answer]) -> Answer:
    """Put a comparison of options into words, with the answers of their plans."""
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


def _compared(found: ComparedOptions) -> str:
    """The first option against each of the others: `B is cheaper than A by 2,000 a year (1,200 to 2,900).`."""
    untold = [one.name for one in found.against if not one.told]
    close = f"; too close to tell from {spoken(untold)}" if untold else ""
    if found.indicator == COST:
        same = [one.name for one in found.against if one.mean == one.low == one.high == 0]
        close = close if len(same) < len(untold) else ""
        than = [f"than {one.name} by {_difference(found, one)}" for one in found.against if one.name not in same]
        parts = [f"{found.first} is cheaper {spoken(than)}{close}"] if than else []
        parts += [f"{found.first} costs as much as {spoken(same)}"] if same else []
        return f"{'; '.join(parts)}."
    by = spoken([f"with that of {one.name} by {_difference(found, one)}" for one in found.against])
    what = words.in_sentence(found.indicator)
    return f"{found.first} needs the fewest robots. On the same days {what} differs {by}{close}."


def _difference(found: ComparedOptions, one: Against) -> str:
    """By how much an option is above the first, with its interval."""
    model = found.plans[one.name].model
    priced = found.indicator == COST
    scale = numbers.Scale(words.money(model)) if priced else words.scale(found.indicator, model, (one.mean,))
    text = f"{scale.value(one.mean)}{' a year' * priced}"
    return text if one.low == one.high else f"{text} ({scale.value(one.low)} to {scale.value(one.high)})"


def _of(name: str, option: Option) -> Option:
    return option.model_copy(update={"group": f"option {name}"})


def _target(found: ComparedOptions) -> str:
    return words.target(next(iter(found.plans.values())).target)


def _promise(found: ComparedOptions) -> str:
    first = next(iter(found.plans.values()))
    zone = words.amount(first.target.indicator, first.zone, first.target.unit)
    left = next(filter(None, map(plan_cells.but, found.plans.values())), "")
    saves = " Costs allow for fewer, where those are not shown to miss it." if found.indicator == COST else ""
    return (
        f"With {100 * found.confidence:g} % confidence all of this holds at once: each fleet reaches {_target(found)}, "
        f"and no smaller one{left} is better than that by {zone} or more.{saves} This takes it that more never does "
        "worse."
    )
