"""The answer of `desim plan` in at most five sentences, and its numbers, each with the command that shows it."""

from __future__ import annotations

import json
import math
import shlex
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import spoken
from desim_warehouse.model import options_of
from desim_warehouse.report.text import words
from desim_warehouse.run.folder import PLAN, write_whole
from desim_warehouse.study import rare
from desim_warehouse.study.statistics import GLANCE

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from desim_warehouse.model import Model
    from desim_warehouse.study.fleet import FleetPlan, Shown, Sized, Strategy

_LISTED = 8
"""Fleets that are named one by one."""
PARTS = {"robots": "robots", "chargers": "charging", "stations": "packing at the stations"}
"""What may be the bottleneck, in words."""


@dataclass(frozen=True)
class Evidence:
    """A number of the answer: what it is, its mean and interval in words, how many runs, and how to see it again."""

    what: str
    found: str
    runs: int
    command: str


def sentences(plan: FleetPlan) -> list[str]:
    """The answer: today, after growth, the strategy, the bottleneck, the cost."""
    lines = [_sized(plan, plan.today, _when(plan.today, "Today"))]
    if plan.grown is not None:
        lines.append(_sized(plan, plan.grown, _when(plan.grown, _growth(plan.grown))))
    if plan.strategies:
        lines.append(_strategy(plan))
    if plan.untried:
        lines.append(f"The runs allowed ended before {spoken(plan.untried, 'and')} could be tried.")
    if (plan.grown or plan.today).utilisation:
        lines.append(_bottleneck(plan))
    costs = [sized.best.cost for sized in _demands(plan) if sized.best and sized.best.cost is not None]
    if costs:
        lines.append(f"Robots and chargers cost {spoken([words.number(cost) for cost in costs])} a year.")
    return lines


def question(plan: FleetPlan) -> str:
    """What was asked."""
    what = "robots" if plan.sized is None else "robots and chargers"
    grown = "" if plan.grown is None else f", today and {_growth(plan.grown).lower()}"
    return f"How many {what} does it take for {words.target(plan.target)}{grown}?"


def promise(plan: FleetPlan) -> str:
    """What is meant by enough, and how sure it is."""
    zone = words.amount(plan.target.indicator, plan.zone)
    if plan.ended:
        return f"With {100 * plan.confidence:g} % confidence for each demand, all that is said to be known is right."
    return (
        f"With {100 * plan.confidence:g} % confidence for each demand, each fleet meets {words.target(plan.target)}, "
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
    said = [
        f"{words.fleet(robots, chargers)} by {words.amount(plan.target.indicator, abs(difference.mean))}"
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


def evidence(plan: FleetPlan, model: str, assignments: tuple[str, ...], seed: int) -> list[Evidence]:
    """The numbers behind the sentences."""
    found = []
    for sized in _demands(plan):
        name = "today" if sized.growth == 1 else f"x {sized.growth:g}"
        shown = ([sized.best] if sized.best else []) + list(sized.below)
        for one in shown:
            verdict = "enough" if one is sized.best else _close(plan, one) if _is_close(one) else "too few"
            overrides = {**sized.overrides, **one.overrides}
            found.append(
                Evidence(
                    f"{name}: {_fleet(one)}, {verdict}",
                    _found(plan, one),
                    one.verdict.n,
                    command_line(model, assignments, overrides, one.verdict.n, (plan.target.indicator,), seed),
                )
            )
    sized = plan.grown or plan.today
    if not sized.utilisation:
        return found
    busiest = sized.best or sized.below[-1]
    overrides = {**sized.overrides, **busiest.overrides}
    busy = ", ".join(f"{part} {words.share_text(estimate)}" for part, estimate in sized.utilisation.items())
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
            found.append(Evidence(f"{strategy.label}: {_fleet(one)}", _found(plan, one), one.verdict.n, command))
        for one in (one for one in sized.below if (one.robots, one.chargers) in strategy.same):
            changed = {**_without(sized.overrides, plan.strategy), **strategy.overrides, **one.overrides}
            command = command_line(model, assignments, changed, GLANCE, (plan.target.indicator,), seed)
            found.append(Evidence(f"{strategy.label}: {_fleet(one)}", f"all as with {plan.own}", GLANCE, command))
    return found


def _without(overrides: Mapping[str, Any], strategy: Strategy | None) -> dict[str, Any]:
    """The changes of a demand, without those of a better strategy."""
    return {key: value for key, value in overrides.items() if strategy is None or key not in strategy.overrides}


def _demands(plan: FleetPlan) -> list[Sized]:
    return [plan.today] if plan.grown is None else [plan.today, plan.grown]


def _growth(sized: Sized) -> str:
    percent = round(100 * (sized.growth - 1), 6)
    return f"With {percent:g} % more orders" if percent >= 0 else f"With {-percent:g} % fewer orders"


def _when(sized: Sized, when: str) -> str:
    return when if sized.rate is None else f"{when} ({words.number(sized.rate)} an hour)"


def _fleet(shown: Shown) -> str:
    """The robots and chargers of a design."""
    return words.fleet(shown.robots, shown.chargers)


def _is_close(shown: Shown) -> bool:
    return shown.verdict.verdict == "undecided"


def _close(plan: FleetPlan, shown: Shown) -> str:
    """Why a design is neither enough nor too few."""
    if shown.verdict.within_zone:
        return f"better than the target by less than {words.amount(plan.target.indicator, plan.zone)}"
    alone = shown.verdict.outlier
    return "too close to tell" if alone is None else f"too close to tell, for replication {alone} alone"


def _ended(plan: FleetPlan, sized: Sized, when: str) -> str:
    """What is known where the runs allowed ended before there was an answer."""
    aim = f"meet {words.target(plan.target)}"
    left, few = sorted(sized.open), [(one.robots, one.chargers) for one in sized.below]
    parts = [] if sized.best is None else [f"{_fleets([(sized.best.robots, sized.best.chargers)])} {aim}"]
    parts += [f"{_fleets(few)} do not{'' if parts else f' {aim}'}"] if few else []
    parts += [f"{_fleets(left[:_LISTED])}{f' and {len(left) - _LISTED} more' if len(left) > _LISTED else ''} are open"]
    return f"{when} the runs allowed ended before an answer: {', '.join(parts)}."


def _fleets(counts: Sequence[tuple[int, int]]) -> str:
    """Fleets as one says them: `4 and 5 robots`, `4 robots and 2 chargers, or 5 robots and 1 charger`."""
    if any(chargers for _, chargers in counts):
        return ", or ".join(words.fleet(*one) for one in counts)
    return f"{spoken([f'{robots}' for robots, _ in counts])} robot{'s' * (counts[-1][0] != 1)}"


def _sized(plan: FleetPlan, sized: Sized, when: str) -> str:
    """The answer for one demand."""
    if sized.open:
        return _ended(plan, sized, when)
    if sized.best is None:
        largest = sized.below[-1]
        return (
            f"{when} not even {_fleet(largest)} were shown to be enough: {plan.target.indicator} is "
            f"{_found(plan, largest)}."
        )
    line = f"{when} {_fleet(sized.best)}: {plan.target.indicator} is {_found(plan, sized.best)}"
    close = [one for one in sized.below if _is_close(one)]
    if close:
        line += f" ({spoken([_fleet(one) for one in close], 'or')} may do: too close to tell)"
    return f"{line}." + (_worse(plan, sized) if sized.worse else "")


def _strategy(plan: FleetPlan) -> str:
    """Whether another strategy makes do with less."""
    if plan.strategy is not None:
        return f"With {plan.strategy.label} instead of {plan.own} fewer are needed: these numbers are for it."
    judged = [strategy.label for strategy in plan.strategies if strategy.shown]
    same = [strategy.label for strategy in plan.strategies if not strategy.shown]
    if not judged:
        return f"With {spoken(same, 'or')} instead of {plan.own} nothing changes (three runs of each)."
    line = f"With {spoken(judged, 'or')} instead of {plan.own} no fewer are enough"
    changes = f"change{'s' * (len(same) == 1)} nothing (three runs of each)"
    return f"{line}, and {spoken(same)} {changes}." if same else f"{line}."


def _bottleneck(plan: FleetPlan) -> str:
    """What is busiest at the last answer."""
    sized = plan.grown or plan.today
    (part, most), *others = sized.utilisation.items()
    rest = ", ".join(f"{name} {words.share_text(estimate)}" for name, estimate in others)
    are = "The bottleneck is the robots" if part == "robots" else f"The bottleneck is {PARTS[part]}"
    who = {"robots": "they are busy", "chargers": "chargers are in use", "stations": "servers are busy"}[part]
    time = "of the time within their hours" if sized.in_hours else "of the time"
    return f"{are}: {who} {words.share_text(most)} {time}" + (f" ({rest})." if rest else ".")


def _found(plan: FleetPlan, shown: Shown) -> str:
    """The mean of the target's indicator with its interval, or why the design fails in spite of it."""
    text = "no value" if shown.estimate is None else words.interval_text(plan.target.indicator, shown.estimate)
    return f"{text}, but {shown.vetoed}" if shown.vetoed else text


def command_line(
    model: str,
    assignments: tuple[str, ...],
    overrides: Mapping[str, Any],
    runs: int,
    indicators: tuple[str, ...],
    seed: int,
) -> str:
    """The line that shows a number and its interval again."""
    sets = [*assignments, *(f"{key}={_value(value)}" for key, value in overrides.items())]
    parts = ["desim", "what-if", model, *options_of(sets)]
    parts += ["--replications", str(runs), *(part for name in indicators for part in ("--indicator", name))]
    parts += ["--seed", str(seed)] if seed else []
    return " ".join(shlex.quote(part) for part in parts)


def _value(value: Any) -> str:
    """A value as `--set` takes it."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key}: {_value(item)}' for key, item in value.items())}}}"
    return value if isinstance(value, str) else json.dumps(value)


def save(plan: FleetPlan, model: Model, shown: list[Evidence], folder: Path, seconds: float | None = None) -> None:
    """Write plan.json, from which `desim report` makes a page."""
    write_whole(folder / PLAN, json.dumps(content(plan, model, shown) | {"seconds": seconds}, indent=1) + "\n")


def content(plan: FleetPlan, model: Model, shown: list[Evidence]) -> dict[str, Any]:
    """A plan as JSON has it, and the file plan.json."""
    return {
        "name": model.name,
        "question": question(plan),
        "answer": sentences(plan),
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
