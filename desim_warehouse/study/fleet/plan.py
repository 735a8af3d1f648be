"""Fleet planning: how many robots, chargers and people a warehouse needs, today and later, and with which strategy.

`scout_steps` finds candidate sizes, and `cheapest_meeting_steps` proves them. Designs that cannot keep up, or run down
their batteries (see `outcome.verdicts`), never count as meeting a target, however well their runs look.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from statistics import fmean
from typing import Any

from desim_warehouse.errors import number_of
from desim_warehouse.model import Model
from desim_warehouse.model.facts.costs import COST, is_fixed
from desim_warehouse.model.facts.day_parts import parts_of_the_day
from desim_warehouse.model.facts.demand import arrival_rate, due_within
from desim_warehouse.model.facts.people import COUNTED, PACKERS, PICKERS
from desim_warehouse.model.facts.workers import Load, scarce
from desim_warehouse.outcome.targets import Target
from desim_warehouse.outcome.verdicts import lost_in_a_day
from desim_warehouse.study.design import Point
from desim_warehouse.study.factors import level_of
from desim_warehouse.study.fleet.capped import PARTS, Capped, tried_cap, waits_much
from desim_warehouse.study.fleet.designs import Designs, OneKey, more_demand
from desim_warehouse.study.fleet.first_answer import first_answer
from desim_warehouse.study.fleet.given import counts_of, demands_of, goals_of
from desim_warehouse.study.fleet.hours import DAYS, by_hour, lead_of
from desim_warehouse.study.fleet.loads import TRIP, loads_at
from desim_warehouse.study.fleet.most import Most, most_steps
from desim_warehouse.study.fleet.people import people_of
from desim_warehouse.study.fleet.sizes import FleetSizes, Shown, Sized, Strategy, strategy_label
from desim_warehouse.study.procedures import judge_of, measured, scouted
from desim_warehouse.study.results import outcome_of
from desim_warehouse.study.runner import StudyRunner, ran_flat
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.cheapest import (
    NOTHING,
    Cheapest,
    Counts,
    Earlier,
    cheapest_meeting_steps,
    covered,
    rules_out,
    ruling_out,
)
from desim_warehouse.study.statistics.intervals import Estimate
from desim_warehouse.study.statistics.judge import (
    GLANCE,
    Beside,
    Budget,
    DesignVerdict,
    Judge,
    runs_to_tell,
    verdict_steps,
)
from desim_warehouse.study.statistics.limits import PLAN_RUNS
from desim_warehouse.study.statistics.procedure import Procedure, request
from desim_warehouse.study.study import StudyEngine, searched
from desim_warehouse.study.table import Row
from desim_warehouse.study.target import days_of, first_look

STRATEGIES = ("nearest", "hungarian", "earliest-due")
"""Allocation policies to try by default."""
ENDS = 2
"""Number of demands (the first and the last year) that are planned before the years between."""
CAPPED = 20
"""Most replications of each cap on the robots under way."""
SAME = 0.2
"""Share of the zone within which days with another strategy count as equal to days with the model's strategy."""


@dataclass(frozen=True)
class _Demand:
    """The results for a demand, which is `growth` times today's.

    `failing`: designs that failed, except `drained` ones, whose batteries ran down. `doubted`: designs that failed in a
    scout (pilot run). `best`: the answer.
    """

    growth: float
    failing: frozenset[Counts]
    drained: frozenset[Counts]
    doubted: frozenset[Counts]
    best: Counts | None


@dataclass
class Planner:
    """The settings shared by all parts of a plan, and the search through its designs."""

    model: Model
    target: Target
    zone: float
    designs: Designs
    search: Search
    budget: Budget
    untried: tuple[str, ...] = ()
    sized: dict[str, dict[Counts, Sequence[Row]]] = field(default_factory=dict)
    """The runs of the designs that were judged, by the name of a demand."""
    shared: list[_Demand] = field(default_factory=list)
    """The results of other demands, with which runs are shared; see `_known`."""
    beside: tuple[tuple[Target, float], ...] = ()
    """Further targets that a fleet has to meet, with their indifference zones."""
    answers: str = ""
    """The answers for earlier demands, as shown with the progress."""
    believed: str = ""
    """The scouts' first answer for the demand under way, until it is decided."""

    @property
    def more_helps(self) -> bool:
        """Whether more robots, or more of another key, are assumed to do no worse."""
        return not self.designs.is_fleet or all(goal.more_helps for goal in self.targets)

    @property
    def of_key(self) -> OneKey | None:
        """The values of one key as designs; None if robots are counted."""
        return self.designs if isinstance(self.designs, OneKey) else None

    @property
    def targets(self) -> tuple[Target, ...]:
        """All targets that a fleet has to meet."""
        return self.target, *(goal for goal, _ in self.beside)

    def judge(self, study: StudyEngine, runner: StudyRunner, exact: bool) -> Judge:
        """Make the judge of the designs of a study."""
        return judge_of(
            study,
            runner,
            self.target,
            self.search,
            exact=exact,
            before=f"{self.answers}{study.plan.name}: ",
            name=lambda n: _named(study.points[n]),
            zone=self.zone,
            budget=self.budget,
            beside=[Beside(goal, zone, partial(_values, runner, goal)) for goal, zone in self.beside],
        )

    def study(self, name: str, factors: Mapping[str, Any], changes: Mapping[str, Any], **more: Any) -> StudyEngine:
        """Make a study of designs, with the changes that a demand and a strategy make."""
        return searched(self.model, factors, self.search, changes=changes, target=self.target.text, name=name, **more)

    def follow(self, study: StudyEngine, make: Callable[[Judge, StudyRunner], Procedure[Any]]) -> Any:
        """Make a procedure with the judge and the runner of a study, and carry it out."""
        where = self.search.under(study.plan.name) if self.of_key is None else self.search  # has a folder
        with study.session(where) as runner:
            if self.believed:
                runner.progress.print(f"{study.plan.name}: {self.believed}")
            runner.progress.tell(f"{self.answers}{self.believed}")
            return study.carry_out(
                runner,
                lambda exact: make(self.judge(study, runner, exact), runner),
                self.target.indicator,
                flat=self.target.missed,
            )

    def plan(self, times: Sequence[float], strategies: Mapping[str, Any] | None, *, yearly: bool) -> FleetSizes:
        """Plan for today's and later demands; if a better strategy turns up, plan once more with that strategy."""
        own = self.model.policies.allocation.content()
        factors = {"policies.allocation": list(dict.fromkeys((own, *STRATEGIES)))} if strategies is None else strategies
        demands = self._sizes(times, {}, "", yearly=yearly)
        tried = self.strategies(demands[-1], factors)
        better = max(
            (strategy for strategy in tried if strategy.saves),
            key=lambda strategy: max(self.target.sign * shown.verdict.mean for shown in strategy.shown),
            default=None,
        )
        with_own = None
        if better is not None:
            with_own = demands[-1]
            self.shared.clear()
            demands = self._sizes(times, better.overrides, f" with {better.label}", yearly=yearly)
        return FleetSizes(
            self.model,
            self.target,
            self.zone,
            self.search.confidence,
            strategy_label({key: level_of(self.model, key) for key in factors}),
            demands,
            tried,
            better,
            self.designs,
            self.budget.spent,
            self.untried,
            self.search.seed,
            self.beside,
            with_own,
        )

    def _sizes(
        self, times: Sequence[float], changes: Mapping[str, Any], suffix: str, *, yearly: bool
    ) -> tuple[Sized, ...]:
        """Return the answers for today's and later demands; the last year is planned before the years between."""
        if not yearly:
            today = self.size(1.0, changes, f"today{suffix}")
            return today, *(self.size(growth, changes, f"growth{suffix}") for growth in times)
        years = {0: 1.0, len(times): times[-1], **dict(enumerate(times, 1))}
        sized = {n: self.size(growth, changes, f"year {n}{suffix}", n) for n, growth in years.items()}
        return tuple(sized[n] for n in sorted(sized))

    def size(self, growth: float, changes: Mapping[str, Any], name: str, year: int | None = None) -> Sized:
        """Find the cheapest design for a demand, using the results of other years if years are planned."""
        changes = {**changes, **more_demand(self.model, growth)}
        ranges, not_tried = self.designs.ranges(growth)
        most = (
            self._most(ranges, changes, name)
            if self.model.pods is not None and self.more_helps and not self.beside and self.of_key is None
            else None
        )
        ranges[0] = [size for size in ranges[0] if most is None or size <= most.up_to]
        counts = list(itertools.product(*ranges))
        of_key = self.of_key
        study = self.study(name, self.designs.factors(ranges), changes) if of_key is None else of_key.study
        earlier = NOTHING if year is None or not self.more_helps else self._known(growth, counts)
        cheapest, doubts = self._cheapest(study, counts, earlier)
        if year is not None:
            self._share(growth, cheapest, doubts, counts)
        self.sized[name] = {counts[number]: study.results.by_point[number] for number in cheapest.verdicts}
        too_small = cheapest.below
        if of_key is not None:  # all designs judged, as each is a row of the answer
            too_small = tuple(sorted(n for n, verdict in cheapest.verdicts.items() if verdict.verdict != "meets"))
        shown = {
            number: self._shown(study, number, counts[number], cheapest.verdicts[number], cheapest.vetoed.get(number))
            for number in (*too_small, *([] if cheapest.design is None else [cheapest.design]))
        }
        best = None if cheapest.design is None else shown[cheapest.design]
        below = tuple(shown[number] for number in too_small)
        base = study.plan.base
        used, trip = self._used(study, cheapest, counts) if shown else ({}, None)
        left = tuple(counts[number] for number in cheapest.open)
        worse = tuple(
            (
                counts[comparison.number],
                counts[comparison.base],
                None if _first_flat(study.results.by_point[comparison.number]) else comparison.difference,
                comparison.target,
            )
            for comparison in cheapest.larger
            if comparison.worse
        )
        capped = (
            self._capped(study, below[-1], name, changes)
            if best is None and below and not left and not self.beside and self.designs.is_fleet
            else None
        )
        return Sized(
            name,
            growth,
            _hourly(base),
            best,
            below,
            used,
            base.layout.has_hours or base.fleet.has_hours,
            changes,
            left,
            worse,
            capped,
            trip,
            tuple(counts),
            () if best is None else by_hour(base, study.results.by_point[best.verdict.value], self.search.confidence),
            year,
            {counts[number]: number in earlier.drained for number in earlier.failing},
            most,
            None if best is None else lead_of(study.results.by_point[best.verdict.value]),
            not self.more_helps,
            cheapest.against,
            self.designs.scan,
            not_tried,
        )

    def _used(
        self, study: StudyEngine, cheapest: Cheapest, counts: list[Counts]
    ) -> tuple[dict[Load, Estimate], Estimate | None]:
        """Return the loads at the chosen or else the largest design, and the trip time if nothing is scarce."""
        busiest = cheapest.design if cheapest.design is not None else max(cheapest.below, key=lambda n: counts[n])
        used = loads_at(study, study.points[busiest])
        if cheapest.design is not None or scarce(used):
            return used, None
        return used, study.results.estimate(study.results.by_point[busiest], TRIP)

    def _with_its_days(self, search: Procedure[Cheapest], judge: Judge) -> Procedure[Cheapest]:
        """Search; if orders arrive by the clock, run the chosen design on more days to show orders by hour."""
        cheapest = yield from search
        if cheapest.design is not None and due_within(self.model) is not None and parts_of_the_day(self.model):
            days = range(judge.runs(cheapest.design), DAYS)
            if days and self.budget.allows(len(days)):
                self.budget.take(len(days))
                yield from request([(cheapest.design, day) for day in days])
        return cheapest

    def _share(self, growth: float, cheapest: Cheapest, doubts: set[int], counts: list[Counts]) -> None:
        """Keep the results of a year for other years."""
        fails = {n for n, verdict in cheapest.verdicts.items() if verdict.verdict == "fails"} - cheapest.drained
        answer = None if cheapest.design is None or cheapest.open else counts[cheapest.design]
        failing, drained, doubted = (
            frozenset(counts[n] for n in numbers) for numbers in (fails, cheapest.drained, doubts)
        )
        self.shared.append(_Demand(growth, failing, drained, doubted, answer))

    def _known(self, growth: float, counts: list[Counts]) -> Earlier:
        """Return results that follow from other years, assuming that more demand is never easier to meet.

        A design that fails with less demand fails, and one that suffices for more demand suffices. Larger designs are
        compared only in the first and the last year, which are planned first.
        """
        less = [demand for demand in self.shared if demand.growth <= growth]
        number = {design: n for n, design in enumerate(counts)}
        enough = [number[demand.best] for demand in self.shared if demand.growth >= growth and demand.best in number]

        largest = max(counts)  # judged each year, for its figures

        def ruled_out(designs: Iterable[Counts], *, drained: bool = False) -> frozenset[int]:
            numbers = (n for other in designs for n in number.values() if rules_out(other, counts[n], drained=drained))
            return frozenset(n for n in numbers if counts[n] != largest)

        fails = ruled_out(design for demand in less for design in demand.failing)
        drains = ruled_out((design for demand in less for design in demand.drained), drained=True) - fails
        return Earlier(
            fails | drains,
            ruled_out(design for demand in less for design in demand.doubted),
            min(enough, key=lambda n: self.designs.key(counts[n]), default=None),
            compare=len(self.shared) < ENDS,
            drained=drains,
        )

    def _most(self, ranges: Sequence[Sequence[int]], changes: Mapping[str, Any], name: str) -> Most | None:
        """Find the fleet that does most; None if no larger fleet does worse."""
        robots, *others = ranges
        largest = self.designs.overrides((robots[-1], *(side[-1] for side in others)))
        seed = self.search.seed + 1
        study = self.study(f"{name} most", {"fleet.size": robots}, {**changes, **largest}, seed=seed)
        with study.session(self.search.under(study.plan.name)) as runner:
            return study.carry_out(
                runner,
                lambda _: most_steps(robots, self.target, self.zone, self.budget),
                self.target.indicator,
                failed=math.nan,
                flat=self.target.missed,
            )

    def _capped(self, study: StudyEngine, largest: Shown, name: str, changes: Mapping[str, Any]) -> Capped | None:
        """Try caps on the robots under way for the largest fleet, if no fleet suffices and robots wait much."""
        rows = study.results.by_point[largest.verdict.value]
        if not waits_much(row.indicators for row in rows) or not self.budget.allows(CAPPED * (len(PARTS) + 1)):
            return None
        first = min(self.search.first or first_look(self.target, CAPPED), CAPPED)
        capped, runs = tried_cap(
            self.model.replace({**changes, **largest.overrides}),
            self.target.indicator,
            replace(self.search.under("cap" if self.of_key else f"cap-{name}"), first=first, cap=CAPPED),
        )
        self.budget.take(runs)
        return capped

    def _cheapest(self, study: StudyEngine, counts: list[Counts], earlier: Earlier) -> tuple[Cheapest, set[int]]:
        """Find the cheapest design of a study that meets the target, and the designs that failed in a scout."""
        where = self.search.under(f"{study.plan.name} scout")
        doubts: set[int] | None = set()
        scan = self.designs.scan
        if self.more_helps and not scan:
            doubts = scouted(
                *(study, self.target, counts, self.designs.key, self.budget, where, self.answers, earlier),
                *(self.targets[1:], lambda number: _named(study.points[number])),
            )
        if doubts is None:
            order = sorted(range(len(counts)), key=lambda number: self.designs.key(counts[number]))
            self.follow(study, lambda judge, _: verdict_steps([], judge))
            return Cheapest(None, (), {}, {}, 0, tuple(order)), set()
        if self.more_helps and not scan:  # else there was no scout
            self.believed = first_answer(counts, self.designs.key, doubts, lambda number: _named(study.points[number]))
        cheapest: Cheapest = self.follow(
            study,
            lambda judge, _: self._with_its_days(
                cheapest_meeting_steps(
                    counts, self.designs.key, judge, doubts, scan=scan, fewer=not self.more_helps, earlier=earlier
                ),
                judge,
            ),
        )
        self.believed = ""
        cheapest = self._as_cheap(study, cheapest, counts, earlier)
        if cheapest.design is not None:
            self.answers += f"{study.plan.name}: {_named(study.points[cheapest.design])}; "
        return cheapest, doubts

    def _as_cheap(self, study: StudyEngine, result: Cheapest, counts: list[Counts], earlier: Earlier) -> Cheapest:
        """Replace the chosen design by the cheapest design whose runs equal its runs day by day.

        Fleets with one charger per robot and with more have equal runs, but the former may be undecided when the latter
        is not. The choice stands if the cheaper design alone rules out an unjudged design, which might suffice as well.
        """
        best, runs = result.design, study.results.by_point
        if best is None:
            return result

        def dear(number: int) -> tuple[float, ...]:
            return self.designs.key(counts[number])

        open_ = [n for n, verdict in result.verdicts.items() if verdict.verdict == "undecided" and dear(n) < dear(best)]
        cheapest = min((n for n in open_ if _equal(runs[n], runs[best])), key=dear, default=best)
        if cheapest == best:
            return result
        verdicts = {**result.verdicts, cheapest: replace(result.verdicts[best], value=cheapest)}
        cheaper = {n: verdict.verdict for n, verdict in verdicts.items() if dear(n) < dear(cheapest)}
        standing = earlier.failing.union(cheaper)
        below = [n for n in range(len(counts)) if dear(n) < dear(cheapest)]
        if not all(covered(counts, n, standing, result.drained) for n in below):
            return result
        failing = {n for n, verdict in cheaper.items() if verdict == "fails"}.union(earlier.failing)
        needed = ruling_out(counts, failing.union(cheaper), failing, result.drained) - earlier.failing
        return replace(result, design=cheapest, below=tuple(sorted(needed, key=dear)), verdicts=verdicts)

    def _shown(
        self, study: StudyEngine, number: int, counts: Counts, verdict: DesignVerdict[int], vetoed: str | None
    ) -> Shown:
        rows = [row for row in study.results.by_point[number] if row.replication < verdict.n]  # the runs of the verdict
        mean = study.results.estimate(rows, self.target.indicator)
        if mean is not None and mean.interval is not None and verdict.low is not None and verdict.high is not None:
            mean = replace(mean, interval=(verdict.low, verdict.high))
        cost = self._cost(rows, counts)
        wrong = tuple(study.results.verdicts.get(str(study.points[number]), ()))
        name, days, to_tell = self.target.indicator, None, None
        if mean is not None:
            by_run = {row.replication: row.value(name) for row in rows}
            days = days_of([by_run.get(run, math.nan) for run in range(verdict.n)], self.target)
        if not verdict.closed:
            to_tell = self._to_tell(rows, verdict)
        why = _first_flat(rows).partition(": ")[2]
        overrides = self.designs.overrides(counts)
        drift = study.results.estimate(rows, "energy_drift_per_hour")
        made = study.results.models.get(str(study.points[number]))
        lost = 0.0 if drift is None or made is None else lost_in_a_day(drift.mean, made)
        return Shown(counts, overrides, verdict, mean, vetoed, cost, wrong, days, to_tell, why, lost)

    def _cost(self, rows: Sequence[Row], counts: Counts) -> float | None:
        """Return the yearly cost of a design: the mean over its runs if prices depend on them."""
        cost = self.designs.cost(counts)
        if cost is None or is_fixed(self.model):
            return cost
        years = [row.value(COST) for row in rows if math.isfinite(row.value(COST))]
        return fmean(years) if years else cost

    def _to_tell(self, rows: Sequence[Row], verdict: DesignVerdict[int]) -> int | None:
        """Return how many runs of a design would decide all open targets; None if too many."""
        each = zip(self.targets, verdict.each or (verdict,), strict=True)
        left = [goal for goal, judged in each if not judged.closed]
        needed = [
            runs_to_tell([measured(row, goal) for row in rows], goal, verdict.level, goal.measure.within, verdict.least)
            for goal in left
        ]
        numbers = [runs for runs in needed if runs is not None]
        return max(numbers) if numbers and len(numbers) == len(needed) else None

    def strategies(self, sized: Sized, factors: Mapping[str, Any]) -> tuple[Strategy, ...]:
        """Try other strategies at the designs that are too small with the model's strategy."""
        counts = [shown.counts for shown in sized.below] if sized.best and not sized.open else []
        if not counts or not factors:
            return ()
        cases = {_in_words(self.designs.totals(design)): self.designs.overrides(design) for design in counts}
        study = self.study("strategies", {**factors, "design": {"cases": cases}}, sized.overrides)
        others = self._others(study, factors)
        if not others:
            return ()
        fleets = {
            point.number: count for points in others.values() for point, count in zip(points, counts, strict=True)
        }
        own, same = self.sized[sized.name], set[int]()

        def changes_nothing(runner: StudyRunner, number: int) -> bool:
            runs = [row for r in range(GLANCE) if (row := runner.row_if_done(number, r)) is not None]
            if runs and all(map(self._alike, runs, own[fleets[number]])):
                same.add(number)
            return number in same

        judged = self.follow(
            study,
            lambda judge, runner: verdict_steps(list(fleets), judge, lambda number: changes_nothing(runner, number)),
        )
        tested = same.union(judged.verdicts)
        tried = {label: points for label, points in others.items() if all(point.number in tested for point in points)}
        self.untried += tuple(label for label in others if label not in tried)
        return tuple(
            Strategy(
                label,
                {key: value for key, value in points[0].overrides.items() if key in factors},
                tuple(
                    self._shown(study, number, fleets[number], judged.verdicts[number], judged.vetoed.get(number))
                    for number in (point.number for point in points)
                    if number not in same
                ),
                tuple(fleets[point.number] for point in points if point.number in same),
            )
            for label, points in tried.items()
        )

    def _alike(self, row: Row, other: Row) -> bool:
        """Whether two runs of a day differ negligibly in each target, or failed with the same error."""
        if row.outcome.error or other.outcome.error:
            return row.outcome.error == other.outcome.error
        zones = ((self.target, self.zone), *self.beside)
        return all(abs(row.value(goal.indicator) - other.value(goal.indicator)) <= SAME * zone for goal, zone in zones)

    def _others(self, study: StudyEngine, factors: Mapping[str, Any]) -> dict[str, list[Point]]:
        """Return the points of a study whose strategy differs from the model's, by the strategy's label."""
        own = {key: level_of(self.model, key) for key in factors}
        points_by_label: dict[str, list[Point]] = {}
        for point in study.points:
            if any(point.overrides.get(key) != own[key] for key in factors):
                label = strategy_label({key: point.labels[key] for key in factors})
                points_by_label.setdefault(label, []).append(point)
        return points_by_label


def _values(runner: StudyRunner, goal: Target, number: int, runs: int) -> list[float]:
    """Return the indicator of a target in the first runs of a design."""
    return [measured(runner.row(number, replication), goal) for replication in range(runs)]


def _first_flat(rows: Iterable[Row]) -> str:
    """Return the error of the first run in which a robot ran flat; empty if none did."""
    return next((row.outcome.error or "" for row in rows if ran_flat(row)), "")


def _equal(ours: Sequence[Row], others: Sequence[Row]) -> bool:
    """Whether two designs had equal outcomes on each day on which both were run."""
    theirs = {row.replication: row for row in others}
    both = [(row, theirs[row.replication]) for row in ours if row.replication in theirs]
    return bool(both) and all(outcome_of(row) == outcome_of(other) for row, other in both)


def _hourly(model: Model) -> float | None:
    """Return the tasks per hour; None if the demand has no rate."""
    rate = arrival_rate(model)
    return None if rate is None else rate * model.units.hour


def _in_words(totals: Mapping[str, int]) -> str:
    """Return a design in words: `6 robots, 2 chargers, 3 packers`."""
    return ", ".join(number_of(number, COUNTED[name]) for name, number in totals.items())


def _named(point: Point) -> str:
    """Return a design in words for the progress bar: `10 robots + 1 charger`."""
    labels = dict(point.labels)
    fleet = [number_of(int(str(labels.pop(key))), what) for key, what in COUNTED.items() if key in labels]
    return " + ".join([*fleet, *map(str, labels.values())])


def size_fleet(
    model: Model,
    target: str | Sequence[str],
    *,
    growth: float | str | None = None,
    years: int | None = None,
    strategies: Mapping[str, Any] | None = None,
    robots: Sequence[int] | str | None = None,
    chargers: Sequence[int] | str | None = None,
    packers: str | None = None,
    pickers: Sequence[int] | str | None = None,
    zone: float | str | None = None,
    search: Search = USUAL,
) -> FleetSizes:
    """Find how many robots, chargers and people meet a target for each demand, and with which strategy.

    The arguments are those of `questions.plan.plan_fleet`.

    Raises:
        StudyError: a bad target or zone, demand that cannot grow, a run that failed, too few runs to search.

    Source: see `cheapest_meeting_steps`, with what it promises and assumes.
    """
    goal, zone, beside = goals_of(target, zone, model)
    times = demands_of(growth, years, "growth")
    more_demand(model, max(times, default=1.0))
    people = people_of(model, {PACKERS: packers, PICKERS: pickers})
    designs = Designs(model, counts_of(robots, "robots"), counts_of(chargers, "chargers"), people)
    budget = Budget(search.runs or PLAN_RUNS)
    with search.together() as together:
        planner = Planner(model, goal, zone, designs, together, budget, beside=beside)
        return planner.plan(times, strategies, yearly=years is not None)
