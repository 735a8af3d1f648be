"""How many robots and chargers a warehouse needs, today and with more demand, with which strategy, and what limits it.

Sizes are found by `statistics.scout_steps` and shown by `statistics.cheapest_meeting_steps`; nothing else is judged
here. Designs that cannot keep up, or run down their batteries (see `outcome.verdicts`), do not count as meeting
a target, however well the run looks.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import StudyError, WarehouseError
from desim_warehouse.feasibility import errors, estimate
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.model.facts.demand import arrival_rate
from desim_warehouse.model.facts.destinations import destinations
from desim_warehouse.model.sections.flows import StorageEnd
from desim_warehouse.outcome.indicators import find, within
from desim_warehouse.outcome.money import equipment
from desim_warehouse.outcome.verdicts import LASTING, judge_design
from desim_warehouse.states import TIMES
from desim_warehouse.study import statistics
from desim_warehouse.study.limits import SCOUTS
from desim_warehouse.study.runner import ran_flat
from desim_warehouse.study.study import Study
from desim_warehouse.study.target import read_target

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from desim_warehouse.model import Model
    from desim_warehouse.study.design import Point
    from desim_warehouse.study.runner import StudyRunner
    from desim_warehouse.study.statistics import Budget, Cheapest, DesignVerdict, Estimate, Procedure, Target
    from desim_warehouse.study.statistics.cheapest import Counts
    from desim_warehouse.study.table import Row

ROOM = 2.5
"""How far robots are searched by default, as a multiple of what the hand calculation needs."""
STRATEGIES = ("nearest", "hungarian", "earliest-due")
"""Allocation policies that are tried by default."""


@dataclass(frozen=True)
class Shown:
    """A design that was judged: its robots and chargers, what changes the model into it, and what its runs say.

    `estimate`: of the target's indicator, with the bounds of the verdict, which allow for looking after every stage;
    None where all runs failed. `vetoed`: why it fails in any case. `cost`: of its robots and chargers a year, None
    without prices of them.
    """

    robots: int
    chargers: int
    overrides: Mapping[str, Any]
    verdict: DesignVerdict[int]
    estimate: Estimate | None
    vetoed: str | None
    cost: float | None


@dataclass(frozen=True)
class Sized:
    """The answer for one demand: the cheapest design shown to meet the target, and those that rule out cheaper ones.

    `name`: of the study that shows it. `best` is None if none was shown to, and `below` are then the largest that
    failed. `rate`: tasks an hour, None where the demand has none. `utilisation`: the part of their time that robots,
    chargers and stations are busy at `best`, or at the largest design, the busiest first. With hours (`in_hours`) only
    the time within them counts. It follows from the indicators `shown_by`, and is empty where no design was judged.
    `open`: designs of which nothing is known, as the runs allowed ended before; `best` may not be the cheapest then.
    `worse`: designs with one robot or one charger more than the one found first that do worse, and by how much.
    """

    name: str
    growth: float
    rate: float | None
    best: Shown | None
    below: tuple[Shown, ...]
    utilisation: Mapping[str, Estimate]
    in_hours: bool
    shown_by: tuple[str, ...]
    overrides: Mapping[str, Any]
    open: tuple[tuple[int, int], ...] = ()
    worse: tuple[tuple[int, int, Estimate], ...] = ()


@dataclass(frozen=True)
class Strategy:
    """Another strategy at designs that are too small with the model's own: whether they would do with it."""

    label: str
    overrides: Mapping[str, Any]
    shown: tuple[Shown, ...]

    @property
    def saves(self) -> bool:
        """Whether a cheaper design meets the target with it."""
        return any(one.verdict.verdict == "meets" for one in self.shown)


@dataclass(frozen=True)
class FleetPlan:
    """What `plan_fleet` found; `strategy` is the better one that the sizes are for, None: the model's own.

    `untried`: strategies for which the runs allowed did not suffice.
    """

    target: Target
    zone: float
    confidence: float
    own: str
    today: Sized
    grown: Sized | None
    strategies: tuple[Strategy, ...]
    strategy: Strategy | None
    sized: str | None
    runs: int
    untried: tuple[str, ...] = ()

    @property
    def feasible(self) -> bool:
        """Whether a design was found for every demand."""
        return self.today.best is not None and (self.grown is None or self.grown.best is not None) and not self.ended

    @property
    def ended(self) -> bool:
        """Whether the runs allowed ended before an answer."""
        return bool(self.today.open or (self.grown is not None and self.grown.open))


class Designs:
    """The designs that could be built of a model: robots, and chargers in the bays that have most of them."""

    def __init__(
        self, model: Model, robots: Sequence[int] | None = None, chargers: Sequence[int] | None = None
    ) -> None:
        self.model = model
        self._now = _chargers(model)
        self.zone = max(self._now, key=self._now.__getitem__) if model.battery is not None and self._now else None
        if chargers is not None and self.zone is None:
            raise StudyError("--chargers: this model has no chargers, expected bays with chargers and a battery")
        self._robots, self._chargers = robots, chargers

    def overrides(self, design: Counts) -> dict[str, Any]:
        """What makes the model into a design."""
        robots, chargers = design
        return {"fleet.size": robots, **self.of_chargers(chargers)}

    def of_chargers(self, chargers: int) -> dict[str, Any]:
        """The changes that give the model this number of chargers; where its slots are too few, one slot for each."""
        if self.zone is None:
            return {}
        bay = self.model.layout.bays[self.zone]
        nodes = sum(item.zone == self.zone for item in self.model.floor.bays.values())
        key = f"layout.bays.{self.zone}"
        found: dict[str, Any] = {f"{key}.total_chargers": chargers}
        if bay.chargers is not None:
            found[f"{key}.chargers"] = None
        if bay.places is not None and chargers > bay.places * nodes:
            found[f"{key}.places"] = None
        return found

    def cost(self, design: Counts) -> float | None:
        """What the robots and chargers of a design cost a year, or None without prices."""
        prices = self.model.prices
        if prices is None or not prices.of_fleet:
            return None
        robots, chargers = design
        special = [kind for kind in self.model.fleet.kinds_of_robots() if kind]
        others = sum(self._now.values()) - self.today
        return equipment(prices, [*special, *[""] * (robots - len(special))], others + chargers)

    def key(self, design: Counts) -> tuple[float, ...]:
        """What to sort designs by: cost, then robots, then chargers."""
        return (self.cost(design) or 0.0, *map(float, design))

    def counts(self, growth: float) -> tuple[list[int], list[int]]:
        """Robots and chargers that are searched, by default from the hand calculation."""
        model = _grown(self.model, growth)
        found = estimate(model, model.floor)
        needed = found.robots_needed
        if self._robots is not None:
            robots = list(self._robots)
        elif needed is None:
            robots = list(range(1, max(2 * model.fleet.size, 10) + 1))
        else:
            robots = list(
                range(max(math.floor(needed / 2), 1), max(math.ceil(ROOM * needed) + 2, model.fleet.size) + 1)
            )
        robots = [size for size in robots if could_run(model, {"fleet.size": size})]
        if not robots:
            raise StudyError("no such fleet can be simulated; `desim check` says why, --robots which are searched")
        if self.zone is None:
            return robots, [0]
        if self._chargers is not None:
            return robots, list(self._chargers)
        short = 0 if found.power is None or found.power.needed is None else found.power.needed * robots[-1]
        most = max(math.ceil(1.5 * short / max(model.fleet.size, 1)), self.today, 2) + 1
        return robots, list(range(1, min(most, robots[-1]) + 1))

    @property
    def today(self) -> int:
        """Chargers of the model as it is, in the bays whose chargers are sized."""
        return self._now.get(self.zone or "", 0)


def _chargers(model: Model) -> dict[str, int]:
    """The chargers of each zone of bays."""
    layout = model.floor
    found: dict[str, int] = {}
    for node, chargers in chargers_at(model, layout).items():
        zone = layout.bays[node].zone
        found[zone] = found.get(zone, 0) + chargers
    return found


def could_run(model: Model, overrides: Mapping[str, Any]) -> bool:
    """Whether a changed model has no errors that a run would refuse."""
    return refused(model, overrides) is None


def refused(model: Model, overrides: Mapping[str, Any]) -> str | None:
    """Why a changed model could not be simulated; None where it could."""
    try:
        changed = model.replace(overrides)
    except WarehouseError as error:
        return str(error).splitlines()[0]
    return next((found.text for found in errors(changed) if found.code not in changed.accept), None)


def _demand(model: Model, growth: float) -> dict[str, Any]:
    """The changes that multiply demand by a factor."""
    if growth == 1:
        return {}
    if not model.tasks.grow:
        raise StudyError(
            "--growth: this model's demand is no rate that could grow, expected tasks.goods: {poisson: orders an "
            "hour}, or flows that arrive at a rate"
        )
    return {"tasks.demand": round(model.tasks.demand * growth, 9)}


def _grown(model: Model, growth: float) -> Model:
    return model.replace(_demand(model, growth))


@dataclass
class _Planner:
    """What all parts of a plan share."""

    model: Model
    target: Target
    zone: float
    confidence: float
    designs: Designs
    seed: int
    first: int
    cap: int
    timeout: float | None
    budget: Budget
    where: dict[str, Any]
    untried: tuple[str, ...] = ()

    def judge(self, veto: Callable[[int], str | None], exact: bool) -> statistics.Judge:
        """Who judges the designs of a study."""
        return statistics.Judge(
            self.target,
            confidence=self.confidence,
            zone=self.zone,
            n0=self.first,
            cap=self.cap,
            deterministic=exact,
            within=within(self.target.indicator),
            budget=self.budget,
            veto=veto,
        )

    def study(self, name: str, factors: Mapping[str, Any], changes: Mapping[str, Any], seed: int) -> Study:
        made = Study(
            self.model,
            factors,
            changes=changes,
            seed=seed,
            confidence=self.confidence,
            target=self.target.text,
            timeout=self.timeout,
            name=name,
        )
        made.plan = made.plan.unreplicated()
        return made

    def follow(self, study: Study, make: Callable[[Callable[[int], str | None], bool], Procedure[Any]]) -> Any:
        """Carry out a procedure that may ask whether a design can last, and whether runs are exact.

        The runs become part of the study.
        """
        out = self.where.get("out")
        where = {**self.where, "out": None if out is None else Path(out) / study.plan.name.replace(" ", "-")}
        with study.session(**where) as runner:
            runner.recall()
            missed = self.target.value - self.target.sign * max(1.0, abs(self.target.value))
            result = runner.follow(
                lambda exact: make(lambda number: _veto(study, runner, number), exact),
                self.target.indicator,
                flat=missed,
            )
            study.plan = replace(study.plan, replications=tuple(runner.replications.values()))
        return result

    def size(self, growth: float, changes: Mapping[str, Any], name: str) -> Sized:
        """The cheapest design for a demand."""
        changes = {**changes, **_demand(self.model, growth)}
        robots, chargers = self.designs.counts(growth)
        factors: dict[str, Any] = {"fleet.size": robots}
        if self.designs.zone is not None:
            cases = {f"{number}": self.designs.of_chargers(number) for number in chargers}
            factors["chargers"] = {"cases": cases}
        counts = [(first, second) for first in robots for second in chargers]
        study = self.study(name, factors, changes, self.seed)
        found = self._cheapest(study, self.study(f"{name} scout", factors, changes, self.seed + 1), counts)
        shown = {
            number: self._shown(study, number, counts[number], found.verdicts[number], found.vetoed.get(number))
            for number in (*found.below, *([] if found.design is None else [found.design]))
        }
        best = None if found.design is None else shown[found.design]
        below = tuple(shown[number] for number in found.below)
        base = study.plan.base
        rate = arrival_rate(base)
        hourly = None if rate is None else rate * base.units.hour
        used = {}
        if shown:
            busiest = found.design if found.design is not None else max(found.below, key=lambda n: counts[n])
            used = utilisation(study, study.points[busiest])
        in_hours = base.layout.has_hours or base.fleet.has_hours
        shown_by = tuple(indicator for part in used for indicator in indicators_of(base)[part])
        left = tuple(counts[number] for number in found.open)
        worse = tuple((*counts[one.number], one.difference) for one in found.larger if one.worse)
        return Sized(name, growth, hourly, best, below, used, in_hours, shown_by, changes, left, worse)

    def _cheapest(self, study: Study, scout: Study, counts: list[Counts]) -> Cheapest:
        """The cheapest of the designs of a study, which a scout with other runs looks for first."""

        def scouting(exact: bool) -> Procedure[set[int] | None]:
            runs = 1 if exact else SCOUTS
            try:
                return (yield from statistics.scout_steps(counts, self.designs.key, self.target, runs, self.budget))
            except statistics.RunsEndedError:
                return None

        doubts = self.follow(scout, lambda _, exact: scouting(exact))
        if doubts is None:
            order = sorted(range(len(counts)), key=lambda number: self.designs.key(counts[number]))
            self.follow(study, lambda veto, exact: statistics.verdict_steps([], self.judge(veto, exact)))
            return statistics.Cheapest(None, (), {}, {}, 0, self.confidence, self.zone, tuple(order))
        found: Cheapest = self.follow(
            study,
            lambda veto, exact: statistics.cheapest_meeting_steps(
                counts, self.designs.key, self.judge(veto, exact), doubts
            ),
        )
        return found

    def _shown(
        self, study: Study, number: int, counts: Counts, verdict: DesignVerdict[int], vetoed: str | None
    ) -> Shown:
        mean = study.results.estimate(study.results.by_point[number], self.target.indicator)
        if mean is not None and mean.interval is not None and verdict.low is not None and verdict.high is not None:
            mean = replace(mean, interval=(verdict.low, verdict.high))
        return Shown(*counts, self.designs.overrides(counts), verdict, mean, vetoed, self.designs.cost(counts))

    def strategies(self, sized: Sized, factors: Mapping[str, Any]) -> tuple[Strategy, ...]:
        """What other strategies do with the designs that are too small with the model's own."""
        counts = [(shown.robots, shown.chargers) for shown in sized.below] if sized.best and not sized.open else []
        if not counts or not factors:
            return ()
        cases = {
            f"{robots} robots, {chargers} chargers": self.designs.overrides((robots, chargers))
            for robots, chargers in counts
        }
        study = self.study("strategies", {**factors, "design": {"cases": cases}}, sized.overrides, self.seed)
        own = {key: _level(self.model, key) for key in factors}
        others: dict[str, list[Point]] = {}
        for point in study.points:
            if any(point.overrides.get(key) != own[key] for key in factors):
                others.setdefault(", ".join(str(point.labels[key]) for key in factors), []).append(point)
        if not others:
            return ()
        found = self.follow(
            study,
            lambda veto, exact: statistics.verdict_steps(
                [point.number for points in others.values() for point in points], self.judge(veto, exact)
            ),
        )
        tried = {
            label: points for label, points in others.items() if all(point.number in found.verdicts for point in points)
        }
        self.untried += tuple(label for label in others if label not in tried)
        return tuple(
            Strategy(
                label,
                {key: value for key, value in points[0].overrides.items() if key in factors},
                tuple(
                    self._shown(
                        study, point.number, count, found.verdicts[point.number], found.vetoed.get(point.number)
                    )
                    for point, count in zip(points, counts, strict=True)
                ),
            )
            for label, points in tried.items()
        )


def _level(model: Model, key: str) -> Any:
    """The value that a model has at a key."""
    from desim_warehouse.model.sections.policy import PolicySpec

    value: Any = model
    for part in key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else getattr(value, part, None)
    return value.content() if isinstance(value, PolicySpec) else value


def _veto(study: Study, runner: StudyRunner, number: int) -> str | None:
    """Why a design cannot last, by the means of its runs, or None if it can."""
    rows = [row for r in range(runner.replications[number]) if (row := runner.found(number, r)) is not None]
    if any(map(ran_flat, rows)):
        return "a robot runs flat"
    model = study.plan.base.replace(study.points[number].overrides)
    found = judge_design([row.indicators for row in rows], model)
    return next((verdict.text for verdict in found if verdict.code in LASTING), None)


def indicators_of(model: Model) -> dict[str, tuple[str, ...]]:
    """The indicators from which the utilisation follows: robots are busy but for the shares in which they stand."""
    stand = (name for name, state in TIMES.items() if state.draws == "standing" and state.applies(model))
    return {
        "robots": tuple(f"share_{name}" for name in stand),
        "chargers": ("charger_utilisation",),
        "stations": ("share_unloading",),
    }


def utilisation(study: Study, point: Point) -> dict[str, Estimate]:
    """The part of their time that robots, chargers and the servers of stations are busy, the busiest first.

    A robot that waits, for work, in a queue, in traffic or for a repair, is not busy: others hold it up. Time outside
    their hours is not the time of robots and stations. Nothing is said of servers where robots unload elsewhere, too,
    or load in stations.
    """
    rows = [row for row in study.results.by_point[point.number] if row.outcome.error is None]
    model = study.plan.base.replace(point.overrides)
    counted = model.run.warm_up, model.run.end
    layout = model.floor
    used = [layout.stations[node] for node in destinations(model, layout) if node in layout.stations]
    hours = {name: model.hours(station.hours) for name, station in model.layout.stations.items()}
    servers = math.fsum(station.servers * hours[station.zone].share(*counted) for station in used)
    each = model.fleet.size / servers if servers else 0.0
    stand = indicators_of(model)["robots"]
    values = {
        "robots": [_busy_share([row.value(name) for name in stand], _off_duty(row, model)) for row in rows],
        "chargers": [row.value("charger_utilisation") for row in rows],
        "stations": [row.value("share_unloading") * each for row in rows] if servers and _unloads_only(model) else [],
    }
    exact = bool(rows) and all(row.outcome.deterministic for row in rows)
    found = {
        name: statistics.estimate(given, study.plan.confidence, deterministic=exact, within=(0.0, 1.0))
        for name, given in values.items()
        if given and all(map(math.isfinite, given))
    }
    return dict(sorted(found.items(), key=lambda item: -item[1].mean))


def _unloads_only(model: Model) -> bool:
    """Whether all that stations do is to have loads from storage put down, and robots put down loads nowhere else."""
    flows = model.tasks.flows.values()
    routes = [route for flow in flows for route in flow.routes]
    stored = [(isinstance(route.source, StorageEnd), isinstance(route.target, StorageEnd)) for route in routes]
    return not any(flow.via for flow in flows) and all(ends == (True, False) for ends in stored)


def _off_duty(row: Row, model: Model) -> float:
    return row.value("share_on_break") if model.fleet.has_hours else 0.0


def _busy_share(standing: Sequence[float], off_duty: float) -> float:
    """Of the time on duty, nan where there was none."""
    return (1 - sum(standing)) / (1 - off_duty) if off_duty < 1 else math.nan


def plan_fleet(
    model: Model,
    target: str,
    *,
    growth: float | None = None,
    strategies: Mapping[str, Any] | None = None,
    robots: Sequence[int] | None = None,
    chargers: Sequence[int] | None = None,
    zone: float | None = None,
    confidence: float = 0.95,
    seed: int = 0,
    runs: int = 5000,
    first: int = 10,
    cap: int = 320,
    timeout: float | None = None,
    **where: Any,
) -> FleetPlan:
    """Find how many robots and chargers meet a target, today and with more demand, and with which strategy.

    Args:
        model: the warehouse. Its bays with most chargers are those whose chargers are sized. Where its section
            `prices` has prices of robots or chargers, the cheapest are sought, else fewest robots, then chargers.
        target: such as "on_time >= 95 %".
        growth: demand in times today's, such as 1.3; None: today's only.
        strategies: key of the model -> its values, to be tried with designs too small (default: `STRATEGIES`).
        robots: fleet sizes that could be bought (default: around what the hand calculation needs).
        chargers: likewise.
        zone: indifference zone in the indicator's unit; default: 0.01 for shares, else 1 % of the target. At most half
            of what is possible beyond the target: for 99.5 % it is 0.25 %.
        confidence: that all that is said of one demand is right.
        seed: of all runs.
        runs: the most that may be done.
        first: replications at the first look at a design.
        cap: most replications of a design.
        timeout: seconds that a run may take.
        where: workers, cluster, out, cache, progress, as of `Study.run`; its runs are kept in the user's cache.

    Raises:
        StudyError: a bad target, demand that cannot grow, a run that failed, too few runs to search.

    Source: see `statistics.cheapest_meeting_steps`, with what it promises and assumes.
    """
    goal = read_target(target, model.units.names)
    if zone is None:
        zone = 0.01 if find(goal.indicator).is_share else 0.01 * abs(goal.value)
    least, largest = within(goal.indicator)
    zone = min(zone, abs((largest if goal.sign > 0 else least) - goal.value) / 2)  # what is harder must be possible
    if growth is not None and not 0 < growth < math.inf:
        raise StudyError(f"growth {growth:g}: expected a factor above 0, such as 1.3 for 30 % more")
    _demand(model, growth or 1.0)
    budget = statistics.Budget(runs)
    designs = Designs(model, robots, chargers)
    planner = _Planner(model, goal, zone, confidence, designs, seed, first, cap, timeout, budget, where)
    if strategies is None:
        strategies = {"policies.allocation": list(dict.fromkeys((model.policies.allocation.content(), *STRATEGIES)))}
    today, grown = _sizes(planner, growth, {}, "")
    tried = planner.strategies(grown or today, strategies)
    better = min(
        (strategy for strategy in tried if strategy.saves),
        key=lambda strategy: -max(goal.sign * one.verdict.mean for one in strategy.shown),
        default=None,
    )
    if better is not None:
        today, grown = _sizes(planner, growth, better.overrides, f" with {better.label}")
    own = ", ".join(str(_level(model, key)) for key in strategies)
    return FleetPlan(
        goal, zone, confidence, own, today, grown, tried, better, designs.zone, budget.spent, planner.untried
    )


def _sizes(
    planner: _Planner, growth: float | None, changes: Mapping[str, Any], suffix: str
) -> tuple[Sized, Sized | None]:
    today = planner.size(1.0, changes, f"today{suffix}")
    return today, None if growth is None else planner.size(growth, changes, f"growth{suffix}")
