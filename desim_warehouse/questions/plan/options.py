"""The verb `plan_options`, which finds the cheapest of several options, and its answer with the plan of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.answer import Answer, Answered
from desim_warehouse.answer.parts import Option
from desim_warehouse.errors import spoken
from desim_warehouse.model import Source, as_model
from desim_warehouse.model.facts.costs import COST
from desim_warehouse.questions import plan
from desim_warehouse.questions.plan import Plan, cells
from desim_warehouse.study.fleet.options import Against, ComparedOptions, compare_options
from desim_warehouse.study.search import USUAL, Search

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class OptionsPlan(Answered, ComparedOptions):
    """The plans of several options and their comparison: the result of `plan_options`.

    Attributes:
        answer: the answer in words; shown by `print`.
        plans: name of each option -> its plan, with an answer of its own.
        first: the cheapest option that is enough; None if no option is enough.
        against: difference of each other option from the first.
        indicator: the indicator that is compared, `annual_cost` if there are prices.
        runs: total number of runs simulated.
    """

    plans: Mapping[str, Plan]

    @property
    def table(self) -> pd.DataFrame:
        """A row for each fleet of each option: the option, then the columns of `Plan.table`."""
        import pandas as pd

        tables = [planned.table.assign(option=name) for name, planned in self.plans.items()]
        whole = pd.concat(tables, ignore_index=True)
        return whole[["option", *(name for name in whole if name != "option")]]

    def in_short(self) -> str:
        """Return the first option, then the fleet of each option, in a few words."""
        fleets = [f"{name}: {planned.in_short()}" for name, planned in self.plans.items()]
        return "; ".join([f"{self.first} first" if self.first else "none is enough", *fleets])


def plan_options(
    options: Mapping[str, Source],
    target: str,
    *,
    strategies: Mapping[str, Any] | None = None,
    robots: Sequence[int] | str | None = None,
    chargers: Sequence[int] | str | None = None,
    packers: str | None = None,
    pickers: Sequence[int] | str | None = None,
    zone: float | str | None = None,
    search: Search = USUAL,
) -> OptionsPlan:
    """Plan each of several options, and compare their cheapest sufficient designs on the same days.

    Args:
        options: name of each option -> its model, or the path of its model file.
        target: such as "on_time >= 95 %"; it holds for all options.
        strategies: key of the model -> values to try with designs that are too small (default: none).
        robots: numbers of robots to consider, such as "6..20" (default: around the quick estimate).
        chargers: numbers of chargers to consider, likewise.
        packers: a station and numbers of people at each of its nodes, such as "packing=1..4"; None: as in the models.
        pickers: numbers of people who walk to robots, such as "3..9", or "auto"; None: as in the models.
        zone: indifference zone in the unit of the target; default: 0.01 for shares, else 1 % of the target.
        search: settings for all plans together; each plan, and the comparison, has an equal part of the error.

    Returns:
        The plan of each option, the first of them against the others, and the answer in words; see `OptionsPlan`.

    Raises:
        StudyError: fewer than two options, some with prices and some without, or any error of `plan`.

    Source: paired differences on the same days. The interval of a difference in cost spans the costs of all fleets that
    were not shown to miss the target.
    """
    models = {name: as_model(model) for name, model in options.items()}
    compared = compare_options(
        models,
        target,
        strategies=strategies or {},
        robots=robots,
        chargers=chargers,
        packers=packers,
        pickers=pickers,
        zone=zone,
        search=search,
    )
    plans = {name: plan.worded(sizes, search.under(name)) for name, sizes in compared.plans.items()}
    whole = answer(compared, {name: option_plan.answer for name, option_plan in plans.items()})
    return OptionsPlan(**vars(compared) | {"plans": plans}, answer=whole.keep(search.out, search.command))


def answer(compared: ComparedOptions, answers: Mapping[str, Answer]) -> Answer:
    """Put a comparison of options into words, with the answers of their plans."""
    shown = answers[compared.first or next(iter(answers))]
    named = [f"{name}: {plan_answer.answer[0]}" for name, plan_answer in answers.items()]
    fails = [name for name, plan_answer in answers.items() if not plan_answer.about]
    last = f" {spoken(fails)} {'is' if len(fails) == 1 else 'are'} not compared." if fails and compared.first else ""
    return shown.model_copy(
        update={
            "question": f"Which of {spoken(list(compared.plans))}, for {_target(compared)}?",
            "answer": (*([f"{_compared(compared)}{last}"] if compared.against else []), *named),
            "options": tuple(
                _of(name, option) for name, plan_answer in answers.items() for option in plan_answer.options
            ),
            "figure": None,
            "promise": _promise(compared),
            "runs": compared.runs,
            "confidence": compared.confidence,
            "feasible": compared.feasible,
            "first": compared.first,
            "compared": [
                {
                    "option": gap.name,
                    "indicator": compared.indicator,
                    "mean": gap.mean,
                    "low": gap.low,
                    "high": gap.high,
                }
                for gap in compared.against
            ],
            "plans": {name: plan_answer.content()["today"] for name, plan_answer in answers.items()},
        }
    )


def _compared(compared: ComparedOptions) -> str:
    """Return the sentence that compares the first option with the others, with differences and their intervals.

    Example: `B is cheaper than A by 2,000 a year (1,200 to 2,900).`
    """
    close_ones = [gap.name for gap in compared.against if not gap.is_clear]
    close = f"; too close to tell from {spoken(close_ones)}" if close_ones else ""
    if compared.indicator == COST:
        same = [gap.name for gap in compared.against if gap.mean == gap.low == gap.high == 0]
        close = close if len(same) < len(close_ones) else ""
        than = [f"than {gap.name} by {_difference(compared, gap)}" for gap in compared.against if gap.name not in same]
        parts = [f"{compared.first} is cheaper {spoken(than)}{close}"] if than else []
        parts += [f"{compared.first} costs as much as {spoken(same)}"] if same else []
        return f"{'; '.join(parts)}."
    by = spoken([f"from that of {gap.name} by {_difference(compared, gap)}" for gap in compared.against])
    what = words.in_sentence(compared.indicator)
    return f"{compared.first} needs the fewest robots. On the same days {what} differs {by}{close}."


def _difference(compared: ComparedOptions, gap: Against) -> str:
    """Return the difference of an option from the first, with its interval, in words."""
    model = compared.plans[gap.name].model
    priced = compared.indicator == COST
    scale = numbers.Scale(words.money(model)) if priced else words.scale(compared.indicator, model, (gap.mean,))
    text = f"{scale.value(gap.mean)}{' a year' * priced}"
    return text if gap.low == gap.high else f"{text} ({scale.value(gap.low)} to {scale.value(gap.high)})"


def _of(name: str, option: Option) -> Option:
    return option.model_copy(update={"group": f"option {name}"})


def _target(compared: ComparedOptions) -> str:
    return words.target(next(iter(compared.plans.values())).target)


def _promise(compared: ComparedOptions) -> str:
    first = next(iter(compared.plans.values()))
    zone = words.amount(first.target.indicator, first.zone, first.target.unit)
    left = next(filter(None, map(cells.but, compared.plans.values())), "")
    saves = " Costs allow for smaller fleets that are not shown to miss it." if compared.indicator == COST else ""
    return (
        f"With {100 * compared.confidence:g} % confidence all of this holds together: each fleet shown to be enough "
        f"reaches {_target(compared)}, and no smaller fleet beats this target by {zone} or more{left}.{saves} "
        "Assumption: a larger fleet never does worse."
    )
