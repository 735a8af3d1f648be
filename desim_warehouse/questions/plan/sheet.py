"""The sheet beside the answer of a plan: the nearest misses, what would change the answer, and what it rests on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.parts import Folded, Option, Rows
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model import Model
from desim_warehouse.model.facts.disturbances import left_out
from desim_warehouse.outcome.targets import Target
from desim_warehouse.questions import judged
from desim_warehouse.study.fleet import FleetSizes, Strategy

CHANGES, RESTS = "What would change the answer", "What the answer rests on"
GUESSES, OTHER_GUESSES = "Guesses that are wrong", "Other guesses that are wrong"
_NEVER = "robots that overtake, ageing batteries, people who fall ill, rules of your fleet manager"
"""What no model represents, of docs/cannot.md, in the words of a buyer of robots."""


def nearest(options: Iterable[Option], goal: Target) -> tuple[Rows, ...]:
    """Draw for each demand the fleet that is enough, above the fleet that misses the target by least."""
    groups: dict[str, list[Option]] = {}
    for option in options:
        if option.number is not None and option.standing != "known":
            groups.setdefault(option.group, []).append(option)
    figures = []
    for group, shown in groups.items():
        enough = [option for option in shown if option.standing == "met"][:1]
        missing = [option for option in shown if option.standing != "met"]
        miss = sorted(missing, key=lambda option: -goal.sign * (option.number.mean if option.number else 0.0))[:1]
        bars = (judged.bar(row.name, row.number, row.standing) for row in (*enough, *miss) if row.number is not None)
        title = f"{capital(words.in_sentence(goal.indicator))}{f', {group}' if group else ''}"
        figure = judged.figure(title, bars, goal.value, judged.aim(goal))
        figures += [] if figure is None else [figure]
    return tuple(figures)


def tables(plan: FleetSizes, grown: Sequence[tuple[str, str]], guesses: Sequence[str] | None) -> tuple[Folded, Folded]:
    """List what would change the answer of a plan, and what it rests on.

    Args:
        plan: the plan.
        grown: each larger demand with its answer, in words.
        guesses: keys of the model that are guesses; None if unknown.
    """
    tried = ((f"Dispatching by {choice(strategy)}", _with(strategy, plan.strategy)) for strategy in plan.strategies)
    changes = [*grown, *tried]
    if guesses:
        changes.append((GUESSES, "not tried"))
    return (
        Folded(title=CHANGES, rows=tuple(changes), on_sheet=True),
        Folded(title=RESTS, rows=tuple(_rests(plan, guesses)), on_sheet=True),
    )


def choice(strategy: Strategy) -> str:
    """Return the name of a strategy, such as `hungarian`."""
    return words.named_policy(strategy.label)


def _with(tried: Strategy, chosen: Strategy | None) -> str:
    if tried is chosen:
        return "fewer are enough: the answer uses it"
    return "fewer are enough" if tried.saves else "as many" if tried.shown else "no change"


def _rests(plan: FleetSizes, guesses: Sequence[str] | None) -> list[tuple[str, str]]:
    rows = [("Simulated", _simulated(plan.model, plan.runs))]
    if guesses is not None:
        listed = ", ".join(dict.fromkeys(map(words.in_words, guesses)))
        rows.insert(0, ("Guesses left, marked (!)", f"{len(guesses)}: {listed}" if guesses else "none"))
    lacking = left_out(plan.model)
    return [*rows, *([("Not in this model", spoken(lacking))] if lacking else []), ("In no model", _NEVER)]


def _simulated(model: Model, runs: int) -> str:
    if model.run.length is None:
        return number_of(runs, "run")
    counted = numbers.duration(model.run.length - model.run.warm_up, model.units.time)
    warm_up = f" after {numbers.duration(model.run.warm_up, model.units.time)}" if model.run.warm_up else ""
    return f"{number_of(runs, 'day')}, each {counted}{warm_up}"
