"""How a plan names its demands, designs and numbers."""

from __future__ import annotations

from typing import Any

from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.standing import instead, lasts_not
from desim_warehouse.errors import spoken
from desim_warehouse.model.facts.people import COUNTED
from desim_warehouse.questions import judged
from desim_warehouse.questions.plan import cells, sheet
from desim_warehouse.study.fleet import FleetSizes, OneKey, Shown, Sized
from desim_warehouse.study.statistics.cheapest import Counts


def more_orders(growth: float) -> str:
    """Return demand relative to today's in words: `with 30 % more orders`."""
    percent = round(100 * (growth - 1), 6)
    return f"with {percent:g} % more orders" if percent >= 0 else f"with {-percent:g} % fewer orders"


class Planned:
    """A plan with the last demand that has an answer, which is the only demand that a page draws.

    `chosen`: the name of the strategy that is better than the model's; empty if none is. `with_own`: the answer for the
    last demand with the model's strategy.
    """

    def __init__(self, plan: FleetSizes) -> None:
        self.plan, self.model, self.goal = plan, plan.model, plan.target
        self.scale = judged.scale_of(plan.target, plan.model)
        self.key = plan.designs if isinstance(plan.designs, OneKey) else None
        self.noun = "fleet" if plan.designs.is_fleet else "value"
        self.yearly = plan.today.year is not None
        self.demands = [plan.today] if plan.grown is None else [plan.today, plan.grown]
        self.chosen = "" if plan.strategy is None else sheet.choice(plan.strategy)
        self.with_own = plan.with_own or self.demands[-1]
        self.answered = next((sized for sized in reversed(self.demands) if sized.best and not sized.open), None)

    def in_time(self, sized: Sized) -> str:
        """Return the demand for the end of a phrase; empty if one key is sized, as this is for today's demand alone."""
        return "" if self.key is not None else f" {self.when(sized)}"

    def then(self, sized: Sized, sentence: str) -> str:
        """Begin a sentence with its demand: `Today (60 an hour): no fleet is enough`; unchanged if one key is sized."""
        return capital(sentence if self.key is not None else f"{self.when(sized)}: {sentence}")

    def when(self, sized: Sized) -> str:
        """Return a demand in words: `today (60 an hour)`, `with 30 % more orders (78 an hour)` or `in year 2`."""
        later = more_orders(sized.growth) if sized.year is None else f"in year {sized.year}"
        when = "today" if sized is self.plan.today else later
        return when if sized.rate is None else f"{when} ({numbers.number(sized.rate)} an hour)"

    def targets(self) -> str:
        """Join the targets of a fleet: `at least 95 % on time, express and mean cycle time at most 10 min`."""
        return spoken([words.target(goal) for goal in self.plan.targets])

    def own_strategy(self) -> str:
        """Return the strategy of the model in words."""
        return words.named_policy(self.plan.own)

    def text(self, shown: Shown) -> str:
        """Return the indicator of a fleet in words, or the reason why it has none."""
        if lasts_not(shown.wrong):
            return instead(shown.wrong, self.model)
        if shown.vetoed or shown.estimate is None:
            return shown.vetoed or "no value"
        return judged.number(shown.verdict, self.goal, self.model).text

    def money(self, value: float) -> str:
        """Return an amount of money with its currency."""
        return numbers.Scale(words.money(self.model)).value(value)

    def fleet(self, counts: Counts) -> str:
        """Return the counts of a design in words: `6 robots, 2 chargers and 3 packers`."""
        return cells.named(self.plan, counts)

    def are(self, counts: Counts) -> str:
        """Return the beginning of a sentence on a design: `6 robots and 1 charger are`, or `Battery threshold 2 is`."""
        designs = self.plan.designs
        is_one = not designs.is_fleet or (designs.value(counts) == 1 and not any(counts[1:]))
        return f"{capital(self.fleet(counts))} {'is' if is_one else 'are'}"

    def counted(self, counts: Counts) -> dict[str, Any]:
        """Return the counts of a design for JSON, with people summed over the nodes of their station."""
        if self.key is not None:
            return {self.key.of: self.key.value(counts)}
        return {f"{COUNTED[name]}s": number for name, number in self.plan.designs.totals(counts).items()}

    def zone(self) -> str:
        """Return the zone of indifference of each target in words."""
        zones = ((self.goal, self.plan.zone), *self.plan.beside)
        return spoken([words.amount(goal.indicator, zone, goal.unit) for goal, zone in zones])

    def none_is(self, sized: Sized, what: str) -> str:
        """Return that no fleet is enough: no fleet tried, where larger ones cannot be simulated."""
        return f"no {self.noun}{' tried' * sized.is_cut_off} is {what}"
