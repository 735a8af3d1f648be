"""The answer of `desim plan` in at most five sentences, and its numbers, each with the command that shows it."""

from __future__ import annotations

import json
import math
import shlex
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model import options_of
from desim_warehouse.model.facts.demand import due_within
from desim_warehouse.report.text import cap_words, numbers, words
from desim_warehouse.report.text.sentences import capital
from desim_warehouse.report.text.standing import WORDS, standing
from desim_warehouse.run.folder import PLAN, write_whole
from desim_warehouse.study import rare
from desim_warehouse.study.fleet.utilisation import TRIP
from desim_warehouse.study.statistics import GLANCE

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from desim_warehouse.model import Model
    from desim_warehouse.study.fleet import FleetPlan, Shown, Sized, Strategy
    from desim_warehouse.study.statistics import Estimate

_LISTED = 8
"""Fleets that are named one by one."""
PARTS = {
    "robots": ("the robots", "they are busy"),
    "traffic": ("traffic", "robots wait in it"),
    "chargers": ("charging", "chargers are in use"),
    "stations": ("packing at the stations", "servers are busy"),
}
"""What may be the bottleneck, in words, and what its share of the time is."""


@dataclass(frozen=True)
class Evidence:
    """A number of the answer: what it is, its mean and interval in words, how many runs, and how to see it again."""

    what: str
    found: str
    runs: int
    command: str


def sentences(plan: FleetPlan, model: Model) -> list[str]:
    """The answer: today, after growth, the strategy, the bottleneck, the cost."""
    lines = [_sized(plan, plan.today, _when(plan.today, "Today"), model)]
    if plan.grown is not None:
        lines.append(_sized(plan, plan.grown, _when(plan.grown, capital(more_orders(plan.grown.growth))), model))
    if plan.strategies:
        lines.append(_strategy(plan))
    if plan.untried:
        lines.append(f"The runs allowed ended before {spoken(plan.untried, 'and')} could be tried.")
    if (plan.grown or plan.today).utilisation:
        lines.append(_bottleneck(plan, model))
    return lines + _cost(plan, model)


def _cost(plan: FleetPlan, model: Model) -> list[str]:
    """What the fleets named cost a year, once where they cost the same."""
    scale = numbers.Scale(words.money(model))
    costs = {
        "today" if sized is plan.today else more_orders(sized.growth): scale.value(sized.best.cost)
        for sized in _demands(plan)
        if sized.best and sized.best.cost is not None
    }
    if len(set(costs.values())) == 1:
        return [f"Robots and chargers cost {next(iter(costs.values()))} a year."]
    said = spoken([f"{cost} {when}" for when, cost in costs.items()]) if costs else ""
    return [f"Robots and chargers cost a year {said}."] if costs else []


def question(plan: FleetPlan) -> str:
    """What was asked."""
    what = "robots" if plan.sized is None else "robots and chargers"
    grown = "" if plan.grown is None else f", today and {more_orders(plan.grown.growth)}"
    return f"How many {what} does it take for {words.target(plan.target)}{grown}?"


def promise(plan: FleetPlan) -> str:
    """What is meant by enough, and how sure it is."""
    zone = words.amount(plan.target.indicator, plan.zone, plan.target.unit)
    if plan.ended:
        return f"With {100 * plan.confidence:g} % confidence for each demand, all that is said to be known is right."
    return (
        f"With {100 * plan.confidence:g} % confidence for each demand, each fleet reaches {words.target(plan.target)}, "
        f"and no smaller one is better than that by {zone} or more "
        f"(if more robots and chargers never do worse{_tried(plan)}). "
        "Ranges of verdicts hold however often the runs were looked at; the commands look once, and may print others."
    )


def _tried(plan: FleetPlan) -> str:
    """How far it is known that larger fleets do no worse."""
    if any(sized.worse for sized in _demands(plan)):
        return "; where they did, every cheaper one was judged by itself"
    return "; one more of each than the fleets named did not" if plan.sized else "; one more than those named did not"


def _worse(plan: FleetPlan, sized: Sized) -> str:
    """Larger designs that do worse than a smaller one."""
    goal = plan.target
    said = [
        f"{words.fleet(robots, chargers)} by {words.amount(goal.indicator, abs(difference.mean), goal.unit)}"
        for robots, chargers, difference in sized.worse
    ]
    return f" More is not always better here: {spoken(said)} worse; so cheaper fleets were searched step by step."


def _rare(plan: FleetPlan, model: Model) -> list[str]:
    """Disasters of which the runs of the fleets named know little."""
    found: dict[str, None] = {}
    for sized in _demands(plan):
        if sized.best is not None:
            fleet = model.replace({**sized.overrides, **sized.best.overrides})
            found.update(dict.fromkeys(rare.warnings(fleet, sized.best.verdict.n, fleet.run.length or math.inf)))
    return [f"{line[:1].upper()}{line[1:]}." for line in found]


def evidence(plan: FleetPlan, loaded: Model, model: str, assignments: tuple[str, ...], seed: int) -> list[Evidence]:
    """The numbers behind the sentences."""
    found = []
    for sized in _demands(plan):
        name = "today" if sized is plan.today else more_orders(sized.growth)
        shown = ([sized.best] if sized.best else []) + list(sized.below)
        if sized.capped is not None:
            overrides, n = {**sized.overrides, **shown[-1].overrides, **sized.capped.overrides}, sized.capped.gain.n
            command = command_line(model, assignments, overrides, n, (plan.target.indicator,), seed)
            said = words.scale(plan.target.indicator, loaded, (sized.capped.mean,)).value(sized.capped.mean)
            found.append(
                Evidence(f"{name}: {_fleet(shown[-1])}, at most {sized.capped.cap} under way", said, n, command)
            )
        for one in shown:
            verdict = WORDS[standing(one.verdict)]
            overrides = {**sized.overrides, **one.overrides}
            found.append(
                Evidence(
                    f"{name}: {_fleet(one)}, {verdict}",
                    _found(plan, one, loaded),
                    one.verdict.n,
                    command_line(model, assignments, overrides, one.verdict.n, (plan.target.indicator,), seed),
                )
            )
    sized = plan.grown or plan.today
    if not sized.utilisation:
        return found
    busiest = sized.best or sized.below[-1]
    overrides = {**sized.overrides, **busiest.overrides}
    busy = ", ".join(f"{part} {numbers.PERCENT.estimate(estimate)}" for part, estimate in sized.utilisation.items())
    found.append(
        Evidence(
            f"{_fleet(busiest)}, busy",
            busy,
            busiest.verdict.n,
            command_line(model, assignments, overrides, busiest.verdict.n, sized.shown_by, seed),
        )
    )
    for strategy in plan.strategies:
        for one in strategy.shown:
            changed = {**_without(sized.overrides, plan.strategy), **strategy.overrides, **one.overrides}
            command = command_line(model, assignments, changed, one.verdict.n, (plan.target.indicator,), seed)
            found.append(
                Evidence(f"{_choice(strategy)}: {_fleet(one)}", _found(plan, one, loaded), one.verdict.n, command)
            )
        for one in (one for one in sized.below if (one.robots, one.chargers) in strategy.same):
            changed = {**_without(sized.overrides, plan.strategy), **strategy.overrides, **one.overrides}
            command = command_line(model, assignments, changed, GLANCE, (plan.target.indicator,), seed)
            same = f"all as with {_own(plan)}"
            found.append(Evidence(f"{_choice(strategy)}: {_fleet(one)}", same, GLANCE, command))
    return found


def _without(overrides: Mapping[str, Any], strategy: Strategy | None) -> dict[str, Any]:
    """The changes of a demand, without those of a better strategy."""
    return {key: value for key, value in overrides.items() if strategy is None or key not in strategy.overrides}


def _demands(plan: FleetPlan) -> list[Sized]:
    return [plan.today] if plan.grown is None else [plan.today, plan.grown]


def more_orders(growth: float) -> str:
    """Demand in words, from times today's: `with 30 % more orders`."""
    percent = round(100 * (growth - 1), 6)
    return f"with {percent:g} % more orders" if percent >= 0 else f"with {-percent:g} % fewer orders"


def _when(sized: Sized, when: str) -> str:
    return when if sized.rate is None else f"{when} ({numbers.number(sized.rate)} an hour)"


def _fleet(shown: Shown) -> str:
    """The robots and chargers of a design."""
    return words.fleet(shown.robots, shown.chargers)


def _ended(plan: FleetPlan, sized: Sized, when: str) -> str:
    """What is known where the runs allowed ended before there was an answer."""
    aim = f"reach {words.target(plan.target)}"
    left, few = sorted(sized.open), [(one.robots, one.chargers) for one in sized.below]
    parts = [] if sized.best is None else [f"{_fleets([(sized.best.robots, sized.best.chargers)])} {aim}"]
    parts += [f"{_fleets(few)} do not{'' if parts else f' {aim}'}"] if few else []
    parts += [f"{_fleets(left) if len(left) <= _LISTED else _many(left)} are open"]
    return f"{when} the runs allowed ended before an answer: {', '.join(parts)}."


def _fleets(counts: Sequence[tuple[int, int]]) -> str:
    """Fleets as one says them: `4 and 5 robots`, `4 robots and 2 chargers, or 5 robots and 1 charger`."""
    if any(chargers for _, chargers in counts):
        return ", or ".join(words.fleet(*one) for one in counts)
    return f"{spoken([f'{robots}' for robots, _ in counts])} robot{'s' * (counts[-1][0] != 1)}"


def _many(counts: Sequence[tuple[int, int]]) -> str:
    """Fleets that are too many to be named: `36 fleets of 6 to 14 robots and 1 to 4 chargers`."""
    spans = zip(map(min, zip(*counts, strict=True)), map(max, zip(*counts, strict=True)), strict=True)
    parts = [
        f"{low} to {high} {what}s" if low < high else number_of(high, what)
        for (low, high), what in zip(spans, ("robot", "charger"), strict=True)
        if high
    ]
    return f"{len(counts)} fleets of {spoken(parts)}"


def _sized(plan: FleetPlan, sized: Sized, when: str, model: Model) -> str:
    """The answer for one demand."""
    if sized.open:
        return _ended(plan, sized, when)
    if sized.best is None:
        largest = sized.below[-1]
        line = f"{when} not even {_fleet(largest)} were shown to be enough: {_reached(plan, largest, model)}."
        return line if sized.capped is None else f"{line} {cap_words.capped(sized.capped, model)}."
    line = f"{when} {_fleet(sized.best)}: {_reached(plan, sized.best, model)}"
    line += "."
    close = [_fleet(one) for one in sized.below if standing(one.verdict) == "open"]
    edge = [_fleet(one) for one in sized.below if standing(one.verdict) == "edge"]
    if close:
        line += f" {capital(spoken(close, 'or'))} may also be enough; more runs would tell."
    if edge:
        zone = words.amount(plan.target.indicator, plan.zone, plan.target.unit)
        line += f" {capital(spoken(edge, 'or'))} may also be enough: {WORDS['edge']}, within {zone} of the target."
    return line + (_worse(plan, sized) if sized.worse else "")


def _strategy(plan: FleetPlan) -> str:
    """Whether another strategy makes do with less."""
    own = _own(plan)
    if plan.strategy is not None:
        return f"With {_choice(plan.strategy)} instead of {own} fewer are needed: these numbers are for it."
    judged = [_choice(strategy) for strategy in plan.strategies if strategy.shown]
    same = [_choice(strategy) for strategy in plan.strategies if not strategy.shown]
    if not judged:
        return f"With {spoken(same, 'or')} instead of {own} nothing changes (three runs of each)."
    line = f"With {spoken(judged, 'or')} instead of {own} no fewer are enough"
    changes = f"change{'s' * (len(same) == 1)} nothing (three runs of each)"
    return f"{line}, and {spoken(same)} {changes}." if same else f"{line}."


def _own(plan: FleetPlan) -> str:
    """The strategy of the model in words."""
    [key, *others] = plan.strategies[0].overrides
    return plan.own if others else words.policy(key, plan.own)


def _choice(strategy: Strategy) -> str:
    """A strategy in words: `the least driving in all (hungarian)`."""
    [key, *others] = strategy.overrides
    return strategy.label if others else words.policy(key, strategy.label)


def _bottleneck(plan: FleetPlan, model: Model) -> str:
    """What is busiest at the last answer; where nothing is scarce, what a task takes all the same."""
    sized = plan.grown or plan.today
    (part, most), *others = sized.utilisation.items()
    rest = ", ".join(f"{name} {numbers.PERCENT.estimate(estimate)}" for name, estimate in others)
    what, who = PARTS[part]
    time = "of the time within their hours" if sized.in_hours else "of the time"
    busy = f"{who} {numbers.PERCENT.estimate(most)} {time}" + (f" ({rest})" if rest else "")
    if sized.trip is not None:
        return f"Nothing is scarce: {busy.replace('they', part, 1)}. {_trip(sized.trip, model)}"
    return f"The bottleneck is {what}: {busy}."


def _trip(trip: Estimate, model: Model) -> str:
    """What a task takes against the time in which it is due."""
    due = due_within(model)
    scale = words.scale(TRIP, model, (trip.mean,))
    of = "" if due is None else f" where {scale.value(due)} are allowed"
    return f"A trip takes {scale.value(trip.mean)}{of}, waits included: more robots do not help."


def _reached(plan: FleetPlan, shown: Shown, model: Model) -> str:
    """The same in a sentence: `97.4 % (97.1 to 97.7) on time`."""
    text = words.reached(plan.target.indicator, _value(plan, shown, model))
    return f"{text}, but {shown.vetoed}" if shown.vetoed else text


def _found(plan: FleetPlan, shown: Shown, model: Model) -> str:
    """The mean of the target's indicator with its interval, or why the design fails in spite of it."""
    text = _value(plan, shown, model)
    return f"{text}, but {shown.vetoed}" if shown.vetoed else text


def _value(plan: FleetPlan, shown: Shown, model: Model) -> str:
    if shown.estimate is None:
        return "no value"
    return words.scale(plan.target.indicator, model, (shown.estimate.mean,)).estimate(shown.estimate, plan.target.value)


def command_line(
    model: str,
    assignments: tuple[str, ...],
    overrides: Mapping[str, Any],
    runs: int,
    indicators: tuple[str, ...],
    seed: int,
) -> str:
    """The line that shows a number and its interval again; what it changes anew is set once."""
    kept = [text for text in assignments if text.partition("=")[0].strip() not in overrides]
    sets = [*kept, *(f"{key}={_typed(value)}" for key, value in overrides.items())]
    parts = ["desim", "what-if", model, *options_of(sets)]
    parts += ["--replications", str(runs), *(part for name in indicators for part in ("--indicator", name))]
    parts += ["--seed", str(seed)] if seed else []
    return " ".join(shlex.quote(part) for part in parts)


def _typed(value: Any) -> str:
    """A value as `--set` takes it."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key}: {_typed(item)}' for key, item in value.items())}}}"
    return value if isinstance(value, str) else json.dumps(value)


def save(
    plan: FleetPlan,
    model: Model,
    shown: list[Evidence],
    folder: Path,
    seconds: float | None = None,
    uncertain: Mapping[str, Any] | None = None,
) -> None:
    """Write plan.json, from which `desim report` makes a page; `uncertain` is the content of its tipping points."""
    found = content(plan, model, shown) | {"uncertain": uncertain, "seconds": seconds}
    write_whole(folder / PLAN, json.dumps(found, indent=1) + "\n")


def content(plan: FleetPlan, model: Model, shown: list[Evidence]) -> dict[str, Any]:
    """A plan as JSON has it, and the file plan.json."""
    return {
        "name": model.name,
        "question": question(plan),
        "answer": sentences(plan, model),
        "feasible": plan.feasible,
        "target": {"indicator": plan.target.indicator, "sense": plan.target.sense, "value": plan.target.value},
        "zone": plan.zone,
        "confidence": plan.confidence,
        "today": _demand_content(plan.today),
        "grown": None if plan.grown is None else _demand_content(plan.grown),
        "strategies": {
            one.label: {
                "saves": one.saves,
                "designs": [shown.verdict.verdict for shown in one.shown],
                "same": [{"robots": robots, "chargers": chargers} for robots, chargers in one.same],
            }
            for one in plan.strategies
        },
        "strategy": plan.strategy.label if plan.strategy else plan.own,
        "evidence": [asdict(one) for one in shown],
        "promise": promise(plan),
        "notes": _rare(plan, model),
        "runs": plan.runs,
    }


def _demand_content(sized: Sized) -> dict[str, Any]:
    return {
        "study": sized.name.replace(" ", "-"),
        "growth": sized.growth,
        "orders_per_hour": sized.rate,
        "best": None if sized.best is None else _design_content(sized.best),
        "too_small": [_design_content(one) for one in sized.below],
        "capped": None if sized.capped is None else asdict(sized.capped),
        "open": [{"robots": robots, "chargers": chargers} for robots, chargers in sized.open],
        "utilisation": {
            part: {"mean": estimate.mean, "interval": estimate.interval} for part, estimate in sized.utilisation.items()
        },
    }


def _design_content(shown: Shown) -> dict[str, Any]:
    return {
        "robots": shown.robots,
        "chargers": shown.chargers,
        "cost": shown.cost,
        "verdict": shown.verdict.verdict,
        "mean": None if shown.estimate is None else shown.estimate.mean,
        "interval": None if shown.estimate is None else shown.estimate.interval,
        "runs": shown.verdict.n,
        "reason": shown.vetoed,
        "set": shown.overrides,
    }
