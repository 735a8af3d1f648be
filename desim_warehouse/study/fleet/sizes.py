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
from desim_warehouse.study.statistics.cheapest import Counts
from desim_warehouse.study.statistics.intervals import Estimate
from desim_warehouse.study.statistics.judge import DesignVerdict
from desim_warehouse.study.target import Days


@dataclass(frozen=True)
class Shown:
    """A design that was judged: its counts (`Designs`), its changes to the model, and the result of its runs.

    `estimate`: of the target's indicator, with the bounds of the verdict, which allow for looking after every stage;
    None where all runs failed. `vetoed`: why it fails in any case. `cost`: of a year, by its runs where these
    affect it; None where nothing that is sized has a price. `wrong`: the verdicts on its runs. `delivered`: tasks an
    hour, the figure for a design that cannot keep up. `days`: the worst of its days, and how many missed the
    target. `to_tell`: how many runs in all would probably tell, where these did not. `flat`: the error of the first run
    in which a robot ran flat.
    """

    counts: Counts
    overrides: Mapping[str, Any]
    verdict: DesignVerdict[int]
    estimate: Estimate | None
    vetoed: str | None
    cost: float | None
    wrong: tuple[Verdict, ...] = ()
    delivered: Estimate | None = None
    days: Days | None = None
    to_tell: int | None = None
    flat: str = ""

    @property
    def is_open(self) -> bool:
        """Whether the design was neither shown to meet the target nor to miss it."""
        return self.vetoed is None and not self.wrong_for_good and self.verdict.verdict == "undecided"

    @property
    def wrong_for_good(self) -> bool:
        """Whether a verdict says that longer runs would be worse: work piles up, or batteries fall."""
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

    `name`: of its study. `best` is None if no design was shown to meet the target, and `below` are then the largest
    that failed. `rate`: tasks an hour, None where the demand has none. `loads`: how busy everybody is at `best`, or at
    the largest design, the largest first (`fleet.loads`). With hours (`in_hours`) only the time within them counts.
    There are none where no design was judged.
    `open`: designs without a result, as the runs allowed ended before; `best` may not be the cheapest then.
    `worse`: designs that do worse than a smaller one: both, the difference (None: robots ran flat), and the target.
    `capped`: the gain of a cap on robots under way at the largest design, where none is enough as robots wait.
    `counts`: of all designs searched. `hours`: how the target is met by the hour at `best`.
    `year`: from today, where years are planned. `failed_before`: designs that failed in an earlier year, each with
    whether it failed by its batteries.
    `most`: with pods, the fleet that does most, where the largest does worse; larger than `up_to` were not judged then.
    `fewer`: the target's indicator made fewer robots the guess to do no worse. `against`: the smallest and the
    largest design contradict the guess, so that designs were judged one by one. `scanned`: so they were, as asked.
    `trip`: where no design is enough though nothing is scarce: the mean time from release of a task until it is done.
    `lead`: how long before a departure orders have to come at `best`; None where nothing departs.
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

    @property
    def ordered(self) -> bool:
        """Whether a larger design is taken to do no worse than a smaller one."""
        return not (self.worse or self.against or self.fewer or self.scanned)

    @property
    def undecided(self) -> bool:
        """Whether the runs leave open if all designs are too small; where larger does no worse, the largest decides."""
        telling = self.below[-1:] if self.ordered else self.below
        return self.best is None and any(design.is_open for design in telling)


def strategy_label(values: Mapping[str, Any]) -> str:
    """Name a strategy by its values, those that are no names with their keys: `nearest, cabins of main 2`."""
    labels = []
    for key, value in values.items():
        factor = None if isinstance(value, str) else about(key)
        labels.append(str(value) if factor is None else f"{factor.label} {value}")
    return ", ".join(labels)


@dataclass(frozen=True)
class Strategy:
    """Another strategy at designs that are too small with the model's own: whether they meet the target with it.

    `same`: the counts of designs whose first runs it leaves unchanged in every indicator; only the others were judged
    with it.
    """

    label: str
    overrides: Mapping[str, Any]
    shown: tuple[Shown, ...]
    same: tuple[Counts, ...] = ()

    @property
    def saves(self) -> bool:
        """Whether a cheaper design meets the target with it."""
        return any(design.verdict.verdict == "meets" for design in self.shown)


@dataclass(frozen=True)
class FleetSizes:
    """The sizes for each demand; `strategy` is the better strategy that they are for, None: the model's own.

    `demands`: today's first. `untried`: strategies for which the runs allowed did not suffice. `beside`: further
    targets that a fleet has to meet, with their indifference zones.
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
        """The answer for the last of the demands that grew; None: none did."""
        return self.demands[-1] if len(self.demands) > 1 else None

    @property
    def feasible(self) -> bool:
        """Whether a design was found for every demand."""
        return all(sized.best is not None for sized in self.demands) and not self.ended

    @property
    def undecided(self) -> bool:
        """Whether for some demand it is open if any fleet is enough."""
        return any(sized.undecided for sized in self.demands)

    @property
    def ended(self) -> bool:
        """Whether the runs allowed ended before an answer."""
        return any(sized.open for sized in self.demands)
