"""The answer of `desim plan` and `desim size`, put together from its sentences, rows, tables and promise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.parts import Folded, Subject
from desim_warehouse.errors import spoken
from desim_warehouse.outcome.targets import Target
from desim_warehouse.questions import judged
from desim_warehouse.questions.plan import hours, promise, rows, sentences, sheet, years
from desim_warehouse.questions.plan.planned import Planned, more_orders
from desim_warehouse.questions.sentences import not_tried
from desim_warehouse.study.fleet import FleetSizes, OneKey, Sized


def answer(plan: FleetSizes, guesses: Sequence[str] | None = None) -> Answer:
    """Put the sizes of a fleet into words; `guesses`: keys of the model whose values are guesses, None if unknown."""
    planned = Planned(plan)
    sized = [
        line
        for sized in planned.demands
        for line in (
            sentences.of_demand(planned, sized),
            *sentences.of_each_target(planned, sized),
            *([] if sized.best else not_tried(sized.not_tried)),
        )
    ]
    lines = (
        list(dict.fromkeys(sized))
        + years.lasts(planned)
        + sentences.of_strategies(planned)
        + sentences.of_busiest(planned)
    )
    options = tuple(option for sized in planned.demands for option in rows.options(planned, sized))
    return Answer(
        kind="plan" if planned.key is None else "size",
        name=planned.model.name,
        description=planned.model.description,
        question=_question(planned),
        answer=tuple(lines),
        measures={goal.indicator: words.in_sentence(goal.indicator) for goal in plan.targets},
        tiles=tuple(rows.tiles(planned)),
        options=options,
        figure=rows.grid(planned) if planned.key is None else rows.intervals(planned, options),
        nearest=() if planned.key is not None else sheet.nearest(options, planned.goal),
        about=_about(planned),
        tables=(*years.table(planned), *hours.table(planned), *_sheet(planned, guesses)),
        promise=promise.promise(planned),
        notes=tuple(promise.notes(planned, options)),
        runs=plan.runs,
        confidence=plan.confidence,
        made={"seed": str(plan.seed), "model": planned.model.digest()},
        feasible=plan.feasible,
        target=_bound(planned.goal),
        **({"targets": [_bound(goal) for goal in plan.targets]} if plan.beside else {}),
        zone=plan.zone,
        strategy=plan.strategy.label if plan.strategy else plan.own,
        today=_facts(planned, plan.today),
        grown=None if plan.grown is None else _facts(planned, plan.grown),
        **({"years": [_facts(planned, sized) for sized in plan.demands]} if planned.yearly else {}),
        **({} if planned.key is None else {"key": planned.key.of, "smallest": _smallest(planned, planned.key)}),
    )


def _smallest(planned: Planned, key: OneKey) -> Any:
    best = planned.plan.today.best
    return None if best is None else key.value(best.counts)


def _question(planned: Planned) -> str:
    if planned.key is not None:
        return f"What is the smallest {words.in_words(planned.key.of)} that gives {planned.targets()}?"
    designs = planned.plan.designs
    fleet = spoken(["robots", *["chargers"] * (designs.zone is not None), *(kind.name for kind in designs.people)])
    later = f"in {len(planned.plan.demands) - 1} years" if planned.yearly else more_orders(planned.demands[-1].growth)
    grown = "" if planned.plan.grown is None else f", today and {later}"
    return f"How many {fleet} does it take for {planned.targets()}{grown}?"


def _about(planned: Planned) -> Subject | None:
    sized = planned.answered
    if sized is None or sized.best is None:
        return None
    made = planned.model.replace({**sized.overrides, **sized.best.overrides})
    when = "" if planned.key is not None else f", {planned.when(sized)}"
    days = sized.best.days
    sorted_days = None if days is None else (days, planned.goal)
    return judged.about(f"{planned.fleet(sized.best.counts)}{when}", made, planned.plan.seed, sorted_days)


def _facts(planned: Planned, sized: Sized) -> dict[str, Any]:
    best = sized.best
    return {
        "study": sized.name.replace(" ", "-"),
        "growth": sized.growth,
        "orders_per_hour": sized.rate,
        "best": best and {**planned.counted(best.counts), "cost": best.cost},
        "capped": None if sized.capped is None else asdict(sized.capped),
        "open": [planned.counted(counts) for counts in sized.open],
        "busy": {load.group.name: load.mean for load in sized.loads},
        **({"most": asdict(sized.most)} if sized.most else {}),
        **({"not_tried": list(map(asdict, sized.not_tried))} if sized.not_tried else {}),
    }


def _sheet(planned: Planned, guesses: Sequence[str] | None) -> tuple[Folded, ...]:
    """Return the tables beside the answer on its sheet; none if one key is sized."""
    if planned.key is not None:
        return ()
    grown = [(capital(planned.when(sized)), _in_short(planned, sized)) for sized in planned.demands[1:]]
    return sheet.tables(planned.plan, grown, guesses)


def _in_short(planned: Planned, sized: Sized) -> str:
    if sized.open or sized.undecided:
        return "not decided"
    return planned.none_is(sized, "enough") if sized.best is None else planned.fleet(sized.best.counts)


def _bound(goal: Target) -> dict[str, Any]:
    """Return a target for JSON."""
    return {"indicator": goal.indicator, "sense": goal.sense, "value": goal.value}
