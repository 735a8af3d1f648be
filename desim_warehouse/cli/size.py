"""`desim size`."""

from __future__ import annotations

import sys
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import click

from desim_warehouse.cli.answers import give
from desim_warehouse.cli.completion import AtPath, keys_then
from desim_warehouse.cli.options import load_model, with_json
from desim_warehouse.cli.study_options import (
    ExecutionOptions,
    ModelOptions,
    interruptible,
    read_values,
    with_execution,
    with_first_and_cap,
    with_question,
)
from desim_warehouse.cli.tables import NONE_MEETS
from desim_warehouse.cli.warned import warn, warn_of_target
from desim_warehouse.report.text import race_words, size_words, words
from desim_warehouse.study.limits import CAP, FIRST

if TYPE_CHECKING:
    from desim_warehouse.study.study import Study

MORE_MAY_BE_WORSE = ("traffic.most_out",)
"""Keys of which the right value lies between too little and too much."""
FLEET = "fleet.size"
ALIKE = 0.01
"""Part of the most by which values may differ in what they do and still be alike."""


@click.command("size")
@click.argument("model", type=AtPath())
@click.option(
    "--key",
    shell_complete=keys_then(""),
    default="fleet.size",
    show_default=True,
    help="The key whose smallest value is sought.",
)
@click.option(
    "--range",
    "values",
    metavar="VALUES",
    help="Its values, ascending, such as 1..60.  [default: of fleets, by estimate]",
)
@click.option(
    "--target",
    help="The target, such as 'throughput_per_hour >= 220'.  [default: the largest throughput_per_hour]",
)
@click.option(
    "--search",
    type=click.Choice(["bisection", "scan"]),
    help="scan: every value from the first on, where more need not be better.  "
    "[default: bisection; for traffic.most_out scan]",
)
@with_json()
@with_first_and_cap(None, CAP)
@with_question
@with_execution
def command(
    model: str,
    key: str,
    values: str | None,
    target: str | None,
    search: str | None,
    as_json: bool,
    first: int | None,
    cap: int,
    question: ModelOptions,
    execution: ExecutionOptions,
) -> None:
    """Find the smallest value of a key with which MODEL meets a target. Exit status 3: no value was shown to meet it.

    Without a target: the smallest value with which most is done, within 1 %. Examples: desim size MODEL --key
    fleet.size --range 1..60 --target "throughput_per_hour >= 220"; desim size MODEL --key traffic.most_out --range
    100..800..100
    """
    from desim_warehouse.study.procedures import most, size

    values = values or _estimated(model, key, question.assignments)
    varied = f"--range {values} --key"
    sought = {"indicators": ["throughput_per_hour"]} if target is None else {"target": target}
    study = question.study(model, {key: _read_range(values)}, "size", execution, varied, **sought)
    study.plan = study.plan.unreplicated()
    searched = [point.labels[key] for point in study.points]
    _see_upwards(values, searched)
    if target is None and search is not None:
        raise click.UsageError("--search is for a --target: without one every value is looked at")
    warnings = warn(study.plan.base, model, question.assignments, as_json=as_json)
    warn_of_target(target, study.plan.base)
    if target is None:
        with interruptible(study, execution.kept):
            best = most(study, share=ALIKE, first=first or FIRST, cap=cap, **execution.where())
        smallest = words.level(best.first.labels[key])
        what = f"{words.factor_name(key)} {smallest}"
        alike = f"{what} is the smallest that does as much, within {100 * ALIKE:g} % of the most."
        falls = key == FLEET and best.selection.eliminated_at[len(searched) - 1] is not None
        capped = _cap(study, best.indicator, first or FIRST, execution) if falls else ""
        answer = race_words.answer(best, "size", tuple(filter(None, (alike, capped))))
        give(answer, execution.out, warnings, as_json=as_json)
        return
    search = search or ("scan" if key in MORE_MAY_BE_WORSE else "bisection")
    with interruptible(study, execution.kept):
        found = size(study, target, first=first, cap=cap, search=search, **execution.where())
    capped = (
        ""
        if found.smallest is not None or key != FLEET
        else _cap(study, found.target.indicator, first or FIRST, execution)
    )
    give(size_words.answer(found, capped), execution.out, warnings, as_json=as_json)
    if found.smallest is None:
        short = found.vetoed and study.plan.base.battery is not None
        cure = "more chargers, which desim plan looks for, too, or" if short else "widen it, or"
        click.echo(f"no answer within --range {values}: {cure} ask for less with --target", err=True)
        sys.exit(NONE_MEETS)


def _cap(study: Study, indicator: str, first: int, execution: ExecutionOptions) -> str:
    """What a cap on the robots under way gives the largest fleet, if they wait much for each other."""
    from desim_warehouse.study.fleet.capped import tried_cap, waits_much
    from desim_warehouse.study.study import under

    largest = study.points[-1]
    rows = study.results.by_point[largest.number]
    if not waits_much(row.indicators for row in rows):
        return ""
    model = study.plan.base.replace(largest.overrides)
    where = under(execution.where(), "cap")
    found, _ = tried_cap(model, indicator, seed=study.plan.seed, first=first, cap=2 * first, **where)
    if found is None:
        return ""
    return f"{size_words.capped(found, model)}."


def _estimated(model: str, key: str, assignments: tuple[str, ...]) -> str:
    """The fleets that `desim plan` would search, too: around what the quick estimate needs."""
    from desim_warehouse.study.fleet.designs import Designs

    if key != FLEET:
        raise click.UsageError(f"--key {key}: needs --range VALUES, as only fleets are estimated")
    robots, *_ = Designs(load_model(model, assignments)).counts(1.0)
    click.echo(f"fleets from {robots[0]} to {robots[-1]}, by a quick estimate (--range looks at others)", err=True)
    return f"{robots[0]}..{robots[-1]}"


def _read_range(values: str) -> Any:
    from desim_warehouse.errors import ModelError

    problems: list[str] = []
    found = read_values(values, f"--range {values}", problems)
    if problems:
        raise ModelError(problems)
    return found


def _see_upwards(values: str, searched: list[Any]) -> None:
    """Refuse descending numbers: the first that meets the target would not be the smallest."""
    numbers = [value for value in searched if isinstance(value, int | float)]
    if any(after <= before for before, after in pairwise(numbers)):
        raise click.UsageError(f"--range {values}: not ascending, expected the smallest value first")
