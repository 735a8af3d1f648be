"""`desim size`."""

from __future__ import annotations

import sys
from dataclasses import replace
from itertools import pairwise
from typing import Any

import click

from desim_warehouse.cli.answers import give
from desim_warehouse.cli.completion import AtPath, keys_then
from desim_warehouse.cli.options import load_model, with_json, with_overrides
from desim_warehouse.cli.study_options import BY_DAYS, BY_TARGET, interruptible, read_values, study_of, with_search
from desim_warehouse.cli.tables import NONE_MEETS
from desim_warehouse.cli.warned import warn, warn_of_target
from desim_warehouse.questions.size import most, size
from desim_warehouse.study.procedures import FLEET
from desim_warehouse.study.search import Search
from desim_warehouse.study.statistics.limits import FIRST

MORE_MAY_BE_WORSE = ("traffic.most_out",)
"""Keys whose best value may lie between values that are too small and too large."""


@click.command("size")
@click.argument("model", type=AtPath())
@click.option(
    "--key",
    shell_complete=keys_then(""),
    default="fleet.size",
    show_default=True,
    help="Key whose smallest sufficient value is sought.",
)
@click.option(
    "--range",
    "values",
    metavar="VALUES",
    help="Values of the key to consider, ascending, such as 1..60.  [default for fleet.size: by a quick estimate]",
)
@click.option(
    "--target",
    "targets",
    multiple=True,
    help="Target, such as 'throughput_per_hour >= 220'; may be repeated.  [default: the largest throughput_per_hour]",
)
@click.option(
    "--search",
    "order",
    type=click.Choice(["bisection", "scan"]),
    help="Order in which values are tried; scan: all from the first on, for keys where more may be worse.  "
    "[default: bisection; scan for traffic.most_out]",
)
@with_json()
@with_overrides
@with_search("confidence", "seed", first=BY_TARGET, cap=BY_DAYS)
def command(
    model: str,
    key: str,
    values: str | None,
    targets: tuple[str, ...],
    order: str | None,
    as_json: bool,
    assignments: tuple[str, ...],
    search: Search,
) -> None:
    """Find the smallest value of a key with which MODEL meets a target. Exit status 3: no value was shown to meet it.

    Without a target, find the smallest value whose throughput is within 1 % of the largest. Examples: desim size
    MODEL --key fleet.size --range 1..60 --target "throughput_per_hour >= 220"; desim size MODEL --key traffic.most_out
    --range 100..800..100
    """
    values = _estimated(model, key, assignments) if values is None else values
    varied = f"--range {values} --key"
    sought = {"target": targets[0]} if targets else {"indicators": ["throughput_per_hour"]}
    factors = {key: _read_range(values)}
    study = study_of(model, assignments, factors, search, varied=varied, name="size", **sought)
    study.plan = study.plan.unreplicated()
    _see_upwards(values, [point.labels[key] for point in study.points])
    if not targets and order is not None:
        raise click.UsageError("--search is for a --target: without one every value is looked at")
    for target in targets:
        warn_of_target(target, study.plan.base)
    warnings = warn(study.plan.base, model, assignments, as_json=as_json)
    if not targets:
        with interruptible(study, search):
            doing_most = most(study, search=replace(search, first=search.first or FIRST))
        give(doing_most.answer, search.out, warnings, as_json=as_json)
        return
    scan = (order or ("scan" if key in MORE_MAY_BE_WORSE else "bisection")) == "scan"
    with interruptible(study, search):
        plan = size(study, targets, scan=scan, search=search)
    give(plan.answer, search.out, warnings, as_json=as_json)
    if plan.smallest is None:
        short = any(shown.vetoed for shown in plan.today.below) and study.plan.base.battery is not None
        cure = "more chargers, which desim plan looks for, too, or" if short else "widen it, or"
        if plan.today.is_cut_off:
            cure = "make room for more, or"
        click.echo(f"no answer within --range {values}: {cure} ask for less with --target", err=True)
        sys.exit(NONE_MEETS)


def _estimated(model: str, key: str, assignments: tuple[str, ...]) -> str:
    """Return the range of fleets around the need by the quick estimate, as `desim plan` searches it."""
    from desim_warehouse.study.fleet.designs import Designs

    if key != FLEET:
        raise click.UsageError(f"--key {key}: needs --range VALUES, as only fleets are estimated")
    (robots, *_), _ = Designs(load_model(model, assignments)).ranges(1.0)
    click.echo(f"fleets from {robots[0]} to {robots[-1]}, by a quick estimate (--range looks at others)", err=True)
    return f"{robots[0]}..{robots[-1]}"


def _read_range(values: str) -> Any:
    from desim_warehouse.errors import ModelError

    problems: list[str] = []
    levels = read_values(values, f"--range {values}", problems)
    if problems:
        raise ModelError(problems)
    return levels


def _see_upwards(values: str, searched: list[Any]) -> None:
    """Refuse numbers that do not ascend, as the first that meets the target would not be the smallest."""
    numbers = [value for value in searched if isinstance(value, int | float)]
    if any(after <= before for before, after in pairwise(numbers)):
        raise click.UsageError(f"--range {values}: not ascending, expected the smallest value first")
