"""Comparison of named options, such as the robots of two vendors: a plan of each, compared on the same days.

If no price depends on chance, the yearly cost follows from the counts. The only uncertainty is then whether a smaller
fleet would do: the cost could fall to that of a fleet that is not shown to miss the target.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from desim_warehouse.errors import StudyError
from desim_warehouse.model import Model
from desim_warehouse.model.facts.costs import COST, is_fixed
from desim_warehouse.study.fleet.plan import size_fleet
from desim_warehouse.study.fleet.sizes import FleetSizes, Shown, Sized
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.cheapest import within_counts
from desim_warehouse.study.statistics.comparison import paired
from desim_warehouse.study.statistics.limits import PLAN_RUNS
from desim_warehouse.study.study import StudyEngine
from desim_warehouse.study.target import read_target

DAYS = 10
"""Days on which options are compared."""


@dataclass(frozen=True)
class Against:
    """The mean difference of an option to the first option in an indicator, with the ends of its interval."""

    name: str
    mean: float
    low: float
    high: float

    @property
    def is_clear(self) -> bool:
        """Whether the difference is significant."""
        return self.low > 0 or self.high < 0


@dataclass(frozen=True)
class ComparedOptions:
    """The plans of named options, and the comparison of the cheapest sufficient option, `first`, with the others.

    `indicator`: the compared indicator, which is the yearly cost or, without prices, the target's indicator; in the
    latter case `first` has the fewest robots.
    """

    plans: Mapping[str, FleetSizes]
    first: str | None
    against: tuple[Against, ...]
    indicator: str
    confidence: float
    runs: int

    @property
    def feasible(self) -> bool:
        """Whether each option has a design that meets the target."""
        return all(plan.feasible for plan in self.plans.values())

    @property
    def undecided(self) -> bool:
        """Whether it is open for some option if any design meets the target."""
        return any(plan.undecided for plan in self.plans.values())

    @property
    def ended(self) -> bool:
        """Whether the budget of runs was exhausted before an answer."""
        return any(plan.ended for plan in self.plans.values())


def compare_options(models: Mapping[str, Model], target: str, *, search: Search = USUAL, **how: Any) -> ComparedOptions:
    """Size the fleet of each option, and compare the cheapest designs that meet the target on shared days.

    The arguments are those of `questions.plan.options.plan_options`.

    Raises:
        StudyError: fewer than two options, some with prices and some without, or as `size_fleet`.

    Source: `statistics.paired`. The interval of a difference in cost covers the costs of all fleets that were not shown
    to miss the target.
    """
    if len(models) < 2:  # noqa: PLR2004
        raise StudyError(f"options {list(models)}: expected at least two to compare")
    read_target(target)  # one for all: several are refused
    with search.together() as together:
        return _compared(models, target, together, **how)


def _compared(models: Mapping[str, Model], target: str, search: Search, **how: Any) -> ComparedOptions:
    """Plan the fleets of several models, and compare them on shared days."""
    each = replace(search, confidence=1 - (1 - search.confidence) / (len(models) + 1))
    plans: dict[str, FleetSizes] = {}
    left = search.runs or PLAN_RUNS
    for name, model in models.items():
        part = replace(each.under(name), runs=max(left, 1))
        plans[name] = size_fleet(model, target, search=part, **{"strategies": {}, **how})
        left -= plans[name].runs
    enough = {name: plan.today.best for name, plan in plans.items() if plan.feasible and plan.today.best is not None}
    indicator = COST if _are_priced(enough) else next(iter(plans.values())).target.indicator
    values = {name: _on_days(plans[name], best, indicator, search) for name, best in enough.items()}
    first = min(values, key=lambda name: sum(values[name]) if indicator == COST else enough[name].counts, default=None)
    others = [name for name in values if name != first]
    sure = 1 - (1 - each.confidence) / max(len(others), 1)
    against = tuple(_against(name, first, values, plans, sure) for name in others if first is not None)
    spent = sum(plan.runs for plan in plans.values()) + (DAYS * len(values) if others else 0)
    return ComparedOptions(plans, first, against, indicator, search.confidence, spent)


def _are_priced(enough: Mapping[str, Shown]) -> bool:
    """Whether options have prices; raise StudyError if only some have."""
    unpriced = [name for name, best in enough.items() if best.cost is None]
    if unpriced and len(unpriced) < len(enough):
        raise StudyError(f"options {', '.join(unpriced)}: no prices of robots or chargers, which the others have")
    return bool(enough) and not unpriced


def _on_days(plan: FleetSizes, best: Shown, indicator: str, search: Search) -> Sequence[float]:
    """Run a design on some days, shared by all options, and return its values of an indicator."""
    changes = {**plan.today.overrides, **best.overrides}
    days = StudyEngine(
        plan.model, changes=changes, replications=DAYS, seed=search.seed + 2, name="days", timeout=search.timeout
    )
    days.run_by(search.under(f"days-{'-'.join(map(str, best.counts))}-{plan.model.digest()[:8]}"))
    return [row.measured(indicator) for row in days.rows]


def _against(
    name: str, first: str, values: Mapping[str, Sequence[float]], plans: Mapping[str, FleetSizes], confidence: float
) -> Against:
    """Compare an option with the first on shared days; the interval allows for cheaper designs that may suffice."""
    fixed = all(is_fixed(plans[option].model) for option in (name, first))
    difference = paired(values[name], values[first], confidence, deterministic=fixed)
    low, high = difference.interval or (difference.mean, difference.mean)
    return Against(name, difference.mean, low - _could_save(plans[name]), high + _could_save(plans[first]))


def _could_save(plan: FleetSizes) -> float:
    """Return the largest excess of the chosen design's cost over the cost of a design not shown to miss the target."""
    sized, best = plan.today, plan.today.best
    if best is None or best.cost is None:
        return 0.0
    left = [best.counts, *(counts for counts in sized.counts if not _misses(counts, sized, plan))]
    own, *others = [plan.designs.cost(counts) or 0.0 for counts in left]
    return max(own - min(others), 0.0)


def _misses(counts: tuple[int, ...], sized: Sized, plan: FleetSizes) -> bool:
    """Whether a design, or a larger one where larger is never worse, was shown to miss the target."""
    return any(
        (within_counts(counts, design.counts) if sized.ordered else counts == design.counts)
        for design in sized.below
        if design.vetoed or _shown_to_miss(design, plan)
    )


def _shown_to_miss(shown: Shown, plan: FleetSizes) -> bool:
    verdict, target = shown.verdict, plan.target
    better = verdict.high if target.sign > 0 else verdict.low
    return not target.met_by(verdict.mean if better is None else better)
