"""Does the fleet that `plan` names keep its promise? Random drafts, each planned, then run on sixty other days.

    python -m benchmarks.promises [FIRST] [LAST]

The first half of the drafts have breakdowns, a closure, a peak or express orders, in turn; the demand of the others is
constant. The named fleet should meet every demand on the mean of the fresh days, the means that were printed should lie
within their intervals (widened by the error of the fresh mean), and no cheaper fleet that the plan does not call open
should meet by more than the zone. Prints a row for each draft and the counts; seeds of fresh days are never those of
plans.
"""

import math
import random
import sys
import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.model import Model
from desim_warehouse.model.parse import read_yaml, valid
from desim_warehouse.model.schema import OUTLINE
from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.fleet.sizes import Sized

DRAFTS, DAYS, SEEDS = 40, 60, 10**6
FEATURES = ("breakdowns", "closure", "peak", "express")
ERRORS = 2.0
"""Standard errors of the fresh mean by which it may lie beyond a printed interval, or miss a target."""


def feature_of(number: int) -> str:
    """What a draft has beside its orders."""
    return FEATURES[number % len(FEATURES)] if number < DRAFTS // 2 else "constant"


def planned(number: int) -> tuple[Model, list[str]]:
    """A random draft, and what its fleet has to meet."""
    drawn, feature = random.Random(number), feature_of(number)
    words = Draft(size=(drawn.randint(18, 32), drawn.randint(16, 26)), orders=drawn.randint(40, 90))
    model = valid(read_yaml(draft(words), f"draft {number}"), Model, OUTLINE)
    share, changes = drawn.choice([90, 95, 97]), dict[str, Any]({"run.length": "5 h", "run.warm_up": "1 h"})
    tasks = {key: value for key, value in model.content()["tasks"].items() if key not in {"goods", "unload_at"}}
    flow, targets = {"from": "storage", "to": "packing"}, [f"on_time >= {share} %"]
    if feature == "breakdowns":
        changes["fleet.robot.breakdowns"] = {
            "every": {"exponential": f"{drawn.choice([15, 40, 100])} h"},
            "repair": "30 min",
            "clear": "3 min",
        }
    elif feature == "closure":
        edge = drawn.choice(sorted(edge[0] for edge in model.floor.edges))
        changes["calendars"] = {"cleaning": {"every": "1 h", "lasts": "8 min", "first": "20 min"}}
        changes["traffic.closures"] = {"lane": {"members": [list(edge)], "hours": "cleaning", "tasks": "go"}}
        changes["policies.routing"] = "congestion-aware"
    elif feature == "peak":
        rates = [words.orders * factor for factor in (0.7, 0.7, 1.0, drawn.choice([1.4, 1.8]), 0.7)]
        orders = {**flow, "due_within": "12 min", "arrivals": {"profile": {"per_hour": rates}}}
        changes["tasks"] = {**tasks, "flows": {"orders": orders}}
    elif feature == "express":
        quick = {**flow, "due_within": "8 min", "arrivals": {"poisson": words.orders * 0.2}, "priority": 1}
        rest = {**flow, "due_within": "20 min", "arrivals": {"poisson": words.orders * 0.8}}
        changes["tasks"] = {**tasks, "flows": {"quick": quick, "rest": rest}}
        targets = [f"on_time:quick >= {share - 5} %", f"on_time:rest >= {share} %"]
    return model.replace(changes), targets


def fresh(model: Model, overrides: Mapping[str, Any], goals: Sequence[Target]) -> list[tuple[float, float]] | None:
    """The mean of each target's indicator over fresh days with a fleet, and its standard error; None: a day failed."""
    design = model.replace(overrides)
    try:
        runs = [dw.simulate(design, SEEDS + day).kpis for day in range(DAYS)]
    except dw.SimulationError:
        return None
    values = np.array([[run[goal.indicator] for goal in goals] for run in runs])
    errors = values.std(axis=0, ddof=1) / math.sqrt(DAYS)
    return list(zip(values.mean(axis=0).tolist(), errors.tolist(), strict=True))


def cheaper(sized: Sized) -> list[tuple[int, ...]]:
    """Fleets with a robot or a charger fewer than the named fleet that the plan does not call open."""
    assert sized.best is not None
    robots, chargers, *rest = sized.best.counts
    fewer = [(robots - 1, chargers, *rest), (robots, chargers - 1, *rest)]
    return [counts for counts in fewer if counts in sized.counts and counts not in sized.open]


def main() -> None:
    """Plan each draft, and hold its answer against fresh days."""
    first, last = [*(int(text) for text in sys.argv[1:]), *[0, DRAFTS][len(sys.argv) - 1 :]]
    named = met = within = less = missed = 0
    for number in range(first, last):
        model, texts = planned(number)
        start = time.process_time()
        plan = dw.plan(model, texts)
        seconds, sized, goals = time.process_time() - start, plan.today, plan.targets
        row = f"{number:2} {feature_of(number):10} {plan.in_short():24} {plan.runs:4} runs {seconds:4.0f} s"
        if sized.best is None:
            print(row, flush=True)
            continue
        means = fresh(model, plan.overrides, goals) or [(goal.missed, 0.0) for goal in goals]
        judged = list(zip(goals, sized.best.verdict.each or (sized.best.verdict,), means, strict=True))
        does = all(goal.sign * (mean - goal.value) >= -ERRORS * error for goal, _, (mean, error) in judged)
        near = all(
            verdict.low is None
            or verdict.high is None
            or verdict.low - ERRORS * error <= mean <= verdict.high + ERRORS * error
            for _, verdict, (mean, error) in judged
        )
        named, met, within = named + 1, met + does, within + near
        for goal, verdict, (mean, error) in judged:
            row += f"; {goal}: {verdict.mean:.3f} ({verdict.low} to {verdict.high}), fresh {mean:.3f} ± {error:.3f}"
        zones = [plan.zone, *(zone for _, zone in plan.beside)]
        for counts in cheaper(sized):
            values = fresh(model, {**sized.overrides, **plan.designs.overrides(counts)}, goals)
            would = values is not None and all(
                goal.sign * (mean - goal.value) - zone > ERRORS * error
                for goal, zone, (mean, error) in zip(goals, zones, values, strict=True)
            )
            less, missed = less + 1, missed + would
            row += f"; {counts}: {[round(mean, 3) for mean, _ in values or []]}{' WOULD MEET' * would}"
        print(f"{row}{'' if does else ' MISSES'}{'' if near else ' OUTSIDE'}", flush=True)
    print(f"{named} of {last - first} named: {met} meet on {DAYS} fresh days, {within} within their intervals")
    print(f"{less} cheaper fleets that are not called open, {missed} of them meet by more than the zone")


if __name__ == "__main__":
    main()
