"""Sizes of a fleet for each demand, the designs that show them, and the strategies tried."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from desim_warehouse.model import Model
from desim_warehouse.model.facts.keys import about
from desim_warehouse.model.facts.workers import Load
from desim_warehouse.outcome.targets import Target
from desim_warehouse.outcome.verdicts import Verdict
from desim_warehouse.study.fleet.capped import Capped
from desim_warehouse.study.fleet.designs import Designs
from desim_warehouse.study.fleet.hours import Hour, Lead
from desim_warehouse.study.fleet.most import Most
from desim_warehouse.study.possible import NotTried
from desim_warehouse.study.statistics.cheapest import Counts
from desim_warehouse.study.statistics.intervals import Estimate
from desim_warehouse.study.statistics.judge import DesignVerdict
from desim_warehouse.study.target import Days


@dataclass(frozen=True)
class Shown:
    """A design that was judged: its counts (`Designs`), its changes to the model, and the result of its runs.

    `estimate`: the target's indicator, with the bounds of the verdict, which allow for repeated looks (interim
    analyses); None if all runs failed. `vetoed`: why the design fails regardless of the target. `cost`: yearly cost,
    from its runs if they affect it; None if nothing that is sized has a price. `wrong`: problems that its runs show.
    `days`: its worst day, and how many days missed the target. `to_tell`: the total number of runs that would probably
    decide an undecided design. `flat`: the error of the first run in which a robot ran flat. `lost`: the share of
    its capacity that the mean battery loses in each day, if no night fills it.
    """

    counts: Counts
    overrides: Mapping[str, Any]
    verdict: DesignVerdict[int]
    estimate: Estimate | None
    vetoed: str | None
    cost: float | None
    wrong: tuple[Verdict, ...] = ()
    days: Days | None = None
    to_tell: int | None = None
    flat: str = ""
    lost: float = 0.0

    @property
    def is_open(self) -> bool:
        """Whether the design was neither shown to meet the target nor to miss it."""
        return self.vetoed is None and not self.wrong_for_good and self.verdict.verdict == "undecided"

    @property
    def wrong_for_good(self) -> bool:
        """Whether longer runs would be worse because work piles up or batteries run down."""
        return any(verdict.is_lasting for verdict in self.wrong)

    @property
    def robots(self) -> int:
        """The number of robots."""
        return self.counts[0]

    @property
    def chargers(self) -> int:
        """The number of chargers, 0 where they are not sized."""
        return self.counts[1]


@dataclass(frozen=True)
class Sized:
    """The answer for one demand: the cheapest design shown to meet the target, and designs that rule out cheaper ones.

    `name`: name of its study. `best` is None if no design was shown to meet the target; `below` then holds the largest
    designs that failed. `rate`: tasks per hour, None if the demand has no rate. `loads`: utilisation of each group at
    `best`, or else at the largest design, largest first (`fleet.loads`); empty if no design was judged. With opening
    hours (`in_hours`) only the time within them counts.
    `open`: designs without a result because the budget was exhausted; `best` may then not be the cheapest.
    `worse`: designs that do worse than a smaller design: both, the difference (None: robots ran flat), and the target.
    `capped`: the gain of a cap on robots under way at the largest design, if none suffices because robots wait.
    `counts`: counts of all designs searched. `hours`: how the target is met by the hour at `best`.
    `year`: years from today, if years are planned. `failed_before`: designs that failed in an earlier year, each with
    whether its batteries ran down.
    `most`: with pods, the fleet that does most, if the largest does worse; fleets larger than its `up_to` were not
    judged. `fewer`: whether fewer robots were assumed to do no worse, by the target's indicator. `against`: whether the
    smallest and the largest design contradict this, so that designs were judged one by one. `scanned`: whether designs
    were judged one by one on request.
    `trip`: if no design suffices although nothing is scarce, the mean time from release of a task until it is done.
    `lead`: how long before a departure orders must arrive at `best`; None if nothing departs.
    `not_tried`: robots, chargers or values that were to be searched, but cannot be simulated.
    """

    name: str
    growth: float
    rate: float | None
    best: Shown | None
    below: tuple[Shown, ...]
    loads: Mapping[Load, Estimate]
    in_hours: bool
    overrides: Mapping[str, Any]
    open: tuple[Counts, ...] = ()
    worse: tuple[tuple[Counts, Counts, Estimate | None, Target], ...] = ()
    capped: Capped | None = None
    trip: Estimate | None = None
    counts: tuple[Counts, ...] = ()
    hours: tuple[Hour, ...] = ()
    year: int | None = None
    failed_before: Mapping[Counts, bool] = field(default_factory=dict)
    most: Most | None = None
    lead: Lead | None = None
    fewer: bool = False
    against: bool = False
    scanned: bool = False
    not_tried: tuple[NotTried, ...] = ()

    @property
    def is_cut_off(self) -> bool:
        """Whether designs larger than those that were tried cannot be simulated."""
        return any(item.larger for item in self.not_tried)

    @property
    def ordered(self) -> bool:
        """Whether a larger design is assumed to do no worse than a smaller one."""
        return not (self.worse or self.against or self.fewer or self.scanned)

    @property
    def undecided(self) -> bool:
        """Whether it is open if all designs are too small; if larger is no worse, the largest design decides."""
        telling = self.below[-1:] if self.ordered else self.below
        return self.best is None and any(design.is_open for design in telling)


def strategy_label(values: Mapping[str, Any]) -> str:
    """Name a strategy by its values, with the key if a value is not a name: `nearest, cabins of main 2`."""
    labels = []
    for key, value in values.items():
        factor = None if isinstance(value, str) else about(key)
        labels.append(str(value) if factor is None else f"{factor.label} {value}")
    return ", ".join(labels)


@dataclass(frozen=True)
class Strategy:
    """Another strategy, judged at designs that are too small with the model's strategy.

    `same`: counts of designs whose first runs are equal in every indicator with this strategy; only the other designs
    were judged with it.
    """

    label: str
    overrides: Mapping[str, Any]
    shown: tuple[Shown, ...]
    same: tuple[Counts, ...] = ()

    @property
    def saves(self) -> bool:
        """Whether a cheaper design meets the target with this strategy."""
        return any(design.verdict.verdict == "meets" for design in self.shown)


@dataclass(frozen=True)
class FleetSizes:
    """The fleet sizes for each demand; `strategy` is the better strategy that they assume, or None for the model's.

    `demands`: today's demand first. `untried`: strategies for which the budget of runs did not suffice. `beside`:
    further targets that a fleet has to meet, with their indifference zones. `with_own`: if a strategy is better, the
    answer for the last demand with the model's own strategy.
    """

    model: Model
    target: Target
    zone: float
    confidence: float
    own: str
    demands: tuple[Sized, ...]
    strategies: tuple[Strategy, ...]
    strategy: Strategy | None
    designs: Designs
    runs: int
    untried: tuple[str, ...] = ()
    seed: int = 0
    beside: tuple[tuple[Target, float], ...] = ()
    with_own: Sized | None = None

    @property
    def targets(self) -> tuple[Target, ...]:
        """All targets that a fleet has to meet."""
        return self.target, *(goal for goal, _ in self.beside)

    @property
    def today(self) -> Sized:
        """The answer for the model's own demand."""
        return self.demands[0]

    @property
    def grown(self) -> Sized | None:
        """The answer for the last grown demand; None if demand does not grow."""
        return self.demands[-1] if len(self.demands) > 1 else None

    @property
    def feasible(self) -> bool:
        """Whether every demand has a design that meets the target."""
        return all(sized.best is not None for sized in self.demands) and not self.ended

    @property
    def undecided(self) -> bool:
        """Whether it is open for some demand if any fleet meets the target."""
        return any(sized.undecided for sized in self.demands)

    @property
    def ended(self) -> bool:
        """Whether the budget of runs was exhausted before an answer."""
        return any(sized.open for sized in self.demands)
