"""`desim plan`."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from desim_warehouse.cli.answers import give, keep, say
from desim_warehouse.cli.completion import AtPath, keys_then
from desim_warehouse.cli.options import load_model, with_json, with_overrides
from desim_warehouse.cli.study_options import (
    BY_DAYS,
    BY_TARGET,
    interruptible,
    read_assignments,
    read_vary,
    with_search,
    with_vary,
)
from desim_warehouse.cli.tables import NONE_MEETS
from desim_warehouse.cli.warned import warn, warn_of_target
from desim_warehouse.errors import ModelError, reason, spoken
from desim_warehouse.study.statistics.limits import MOST_RUNS, MOST_YEARS, PLAN_RUNS

if TYPE_CHECKING:
    from desim_warehouse.answer.answer import Answer
    from desim_warehouse.model import Model
    from desim_warehouse.questions.plan import Plan
    from desim_warehouse.questions.plan.options import OptionsPlan
    from desim_warehouse.study.search import Search


ALL_YEAR = 8760.0
"""Hours of a year."""


@click.command("plan")
@click.argument("model", type=AtPath())
@click.option(
    "--target",
    "targets",
    required=True,
    multiple=True,
    metavar="TARGET",
    help="Target, such as 'on_time >= 95 %'; may be repeated, and a fleet then has to meet all targets.",
)
@click.option(
    "--growth",
    metavar="AMOUNT",
    help="Plan for more demand, too: 30% for 30 % more, 1.3 for 1.3 times as much; with --years, such as 20%/year.",
)
@click.option(
    "--option",
    "options",
    multiple=True,
    metavar="NAME: WHAT",
    help="An option to consider, such as 'A: fleet.robot.speed=1.5; prices.robot=6000' or 'B: other.yaml', or a file "
    "that lists options; may be repeated. Each option is planned, and the cheapest are compared.",
)
@click.option("--years", type=click.IntRange(1, MOST_YEARS), help="Number of years to plan for after today.")
@with_vary
@click.option(
    "--robots", metavar="VALUES", help="Numbers of robots to consider, such as 1..20.  [default: by a quick estimate]"
)
@click.option(
    "--chargers",
    metavar="VALUES",
    help="Numbers of chargers to consider, such as 1..8.  [default: by a quick estimate]",
)
@click.option(
    "--packers",
    metavar="STATION[=VALUES]",
    help="Numbers of people to consider at each node of a station, such as packing=1..4.  [default: as in the model]",
)
@click.option(
    "--pickers",
    metavar="VALUES",
    help="Numbers of pickers on foot to consider, such as 3..9; auto: by a quick estimate.  [default: as in the model]",
)
@click.option(
    "--price-robot",
    type=click.FloatRange(0),
    help="Annual cost of a robot, instead of prices.robot; with prices, the cheapest fleet is sought, not the "
    "smallest.",
)
@click.option("--price-charger", type=click.FloatRange(0), help="Annual cost of a charger, instead of prices.charger.")
@click.option(
    "--zone",
    metavar="AMOUNT",
    help="Indifference zone around the target.  [default: 1 % for shares, otherwise 1 % of the target]",
)
@click.option(
    "--runs", type=click.IntRange(1, MOST_RUNS), default=PLAN_RUNS, show_default=True, help="Maximum number of runs."
)
@click.option(
    "--uncertain",
    shell_complete=keys_then("="),
    multiple=True,
    metavar="KEY=LOW..HIGH|FILE",
    help="Range of an input that is not known exactly, or a file of ranges written by desim calibrate: find up to "
    "which value the fleet is enough, in at most 60 runs for each input.",
)
@with_json()
@with_overrides
@with_search("confidence", "seed", first=BY_TARGET, cap=BY_DAYS)
def command(  # as long as its options are many
    model: str,
    targets: tuple[str, ...],
    options: tuple[str, ...],
    growth: str | None,
    years: int | None,
    vary: tuple[str, ...],
    robots: str | None,
    chargers: str | None,
    packers: str | None,
    pickers: str | None,
    price_robot: float | None,
    price_charger: float | None,
    zone: str | None,
    uncertain: tuple[str, ...],
    as_json: bool,
    assignments: tuple[str, ...],
    search: Search,
) -> None:
    """Find how many robots, chargers and people MODEL needs, today and later, with which strategy, and what is scarce.

    The strategies nearest, hungarian and earliest-due are tried, or those in --vary. With --uncertain, each input is
    then varied within its range to find up to which value the planned fleet is enough, with runs on both sides of it.
    Exit status 3: no fleet was shown to be enough, or --runs were used up before there was an answer.
    Example: desim plan w.yaml --target "on_time >= 95 %" --growth 30% --workers 2
    """
    from desim_warehouse.model.guesses import guesses
    from desim_warehouse.questions.plan import plan_fleet
    from desim_warehouse.questions.plan.options import plan_options
    from desim_warehouse.study.fleet.given import counts_of

    loaded = _priced(load_model(model, assignments), robot=price_robot, charger=price_charger)
    for target in targets:
        warn_of_target(target, loaded)
    warnings = warn(loaded, model, assignments, as_json=as_json)
    ranges = _ranges(uncertain, loaded)
    if len(targets) > 1 and (options or ranges):
        raise click.UsageError("--option and --uncertain: with one --target alone")
    if options and (growth or ranges):
        raise click.UsageError("--option: without --growth and --uncertain")
    how: dict[str, Any] = {
        "robots": counts_of(robots, "--robots"),
        "chargers": counts_of(chargers, "--chargers"),
        "packers": packers,
        "pickers": pickers,
        "zone": zone,
        **({"strategies": read_vary(vary)} if vary else {}),
    }
    plan: Plan | OptionsPlan
    with interruptible(None, search):
        if options:
            plan = plan_options(_options(options, loaded), targets[0], search=search, **how)
            best = None
        else:
            left = guesses(model, read_assignments(assignments))
            plan = plan_fleet(loaded, targets, search=search, growth=growth, years=years, guesses=left, **how)
            best = _best(plan, loaded)
    if ranges and best is not None:
        _give_with_thresholds(plan.answer, (best, targets[0], ranges), search, warnings, as_json=as_json)
    else:
        give(plan.answer, search.out, warnings, as_json=as_json)
    if not plan.feasible:
        click.echo(f"Try --runs {4 * (search.runs or PLAN_RUNS)}." if plan.ended else _none(plan), err=True)
        sys.exit(NONE_MEETS)


def _none(plan: Plan | OptionsPlan) -> str:
    """Return the message that no fleet is enough, with the options that bound it, and scarce people not counted."""
    from desim_warehouse.model.facts.workers import scarce
    from desim_warehouse.study.fleet import ComparedOptions
    from desim_warehouse.study.fleet.people import SIZED

    plans = list(plan.plans.values()) if isinstance(plan, ComparedOptions) else [plan]
    counted = [kind.name for kind in plans[0].designs.people]
    options = spoken(["--robots", "--chargers", *(f"--{name}" for name in counted)])
    if plan.undecided:
        return f"No fleet within {options} is shown to be enough, and the largest is not shown to be too small."
    loads = (load for sizes in plans for sized in sizes.demands if sized.best is None for load in scarce(sized.loads))
    names = dict.fromkeys(load.group.name for load in loads)
    others = [name for name in names if name in SIZED and name not in counted]
    also = "".join(f"; {name} are scarce, and --{name} counts them, too" for name in others)
    if any(sized.is_cut_off for sizes in plans for sized in sizes.demands if sized.best is None):
        options += " that could be tried"
    return f"No fleet within {options} is enough{also}; desim why finds the bottleneck."


def _priced(model: Model, **prices: float | None) -> Model:
    """Return the model with prices from options; without a section `prices` it runs all year."""
    changes = {key: price for key, price in prices.items() if price is not None}
    before = {"hours": ALL_YEAR} if model.prices is None else model.prices.content()
    return model.replace({"prices": {**before, **changes}}) if changes else model


def _ranges(texts: tuple[str, ...], model: Model) -> dict[str, tuple[float, float]]:
    """Read the ranges of `--uncertain`: for keys, or in a file that `desim calibrate` wrote beside the model."""
    ranges: dict[str, tuple[float, float]] = {}
    for text in texts:
        if "=" in text:
            key, _, ends = (part.strip() for part in text.partition("="))
            ranges[key] = _ends(key, ends.split(".."), model)
            continue
        for key, ends in _of_file(text).items():
            if ends.get("high") is None:
                click.echo(f"{text}: {key} has no upper end, and is left out (--uncertain {key}=LOW..HIGH)", err=True)
            elif ends["low"] < ends["high"]:
                ranges[key] = float(ends["low"]), float(ends["high"])
    if texts and not ranges:
        raise ModelError([f"--uncertain {' '.join(texts)}: no range in it, expected KEY=LOW..HIGH or such a file"])
    return ranges


def _ends(key: str, ends: list[str], model: Model) -> tuple[float, float]:
    """Return the two ends of a range, in the units of the model; each may have a unit of its own."""
    from desim_warehouse.model.facts.keys import about
    from desim_warehouse.values.units import quantity

    entry = about(key)
    if entry is None or len(ends) != 2:  # noqa: PLR2004
        what = "no key of a model" if entry is None else "no range"
        raise ModelError([f"--uncertain {key}={'..'.join(ends)}: {what}, expected such as tasks.load_time=7..19"])
    try:
        low, high = (quantity(end, entry.kind, model.units.names) if entry.kind else float(end) for end in ends)
    except ValueError as error:
        raise ModelError([f"--uncertain {key}={'..'.join(ends)}: {error}"]) from None
    if not low < high:
        raise ModelError([f"--uncertain {key}={'..'.join(ends)}: no range, expected the lower value first"])
    return low, high


def _of_file(path: str) -> Mapping[str, Any]:
    from desim_warehouse.model.parse import read_yaml

    try:
        document = read_yaml(Path(path).read_text(encoding="utf-8"), path)
    except (OSError, ValueError) as error:
        raise ModelError([f"--uncertain {path}: no KEY=LOW..HIGH, and no file ({reason(error)})"]) from None
    data: Any = document.data
    ends = data.values() if isinstance(data, dict) and not document.problems else [None]
    if not all(isinstance(pair, dict) and isinstance(pair.get("low"), int | float) for pair in ends):
        raise ModelError([f"--uncertain {path}: not as desim calibrate writes it, expected keys with low and high"])
    ranges: Mapping[str, Any] = data
    return ranges


def _best(plan: Plan, model: Model) -> Model | None:
    """Return the model with the planned fleet for the last demand; None if no fleet is enough."""
    sized = plan.grown or plan.today
    return None if sized.best is None else model.replace({**sized.overrides, **sized.best.overrides})


def _give_with_thresholds(
    answer: Answer,
    asked: tuple[Model, str, Mapping[str, tuple[float, float]]],
    search: Search,
    warnings: Sequence[Any] | None,
    *,
    as_json: bool,
) -> None:
    """Save and print a plan, then the thresholds of its fleet, so that a failure of the latter loses nothing.

    With `as_json` print one object, with the thresholds unless they fail.
    """
    from desim_warehouse.questions.tipping import tipping_points, with_thresholds

    if not as_json:
        give(answer, search.out, warnings)
        click.echo()
    try:
        with interruptible(None, search):
            points = tipping_points(*asked, search=replace(search.under("uncertain"), runs=None))
    except BaseException:
        if as_json:
            give(answer, search.out, warnings, as_json=True)
        raise
    whole = keep(with_thresholds(answer, points), search.out)
    if as_json:
        give(whole, search.out, warnings, as_json=True)
    else:
        say(str(points.answer))


# Named options


def _options(texts: tuple[str, ...], model: Model) -> dict[str, Model]:
    """Read options as models: `A: prices.robot=6000; fleet.robot.speed=1.5`, `B: other.yaml`, or files that list them.

    Raises:
        ModelError: a text that is no option, a duplicate name, or an invalid model.
    """
    options: dict[str, Model] = {}
    for text in texts:
        for name, what in _named(text):
            if name in options:
                raise ModelError([f"--option {name}: there twice, expected each once"])
            options[name] = _model(name, what, model)
    return options


def _named(text: str) -> Iterator[tuple[str, Any]]:
    """Yield the name and content of the option in a text, or of all options in a file."""
    from desim_warehouse.model.parse import read_yaml

    name, colon, what = text.partition(":")
    if colon and what.strip():
        yield name.strip(), what.strip()
        return
    try:
        document = read_yaml(Path(text).read_text(encoding="utf-8"), text)
    except (OSError, ValueError) as error:
        raise ModelError(
            [f"--option {text}: no NAME: KEY=VALUE, and no file ({reason(error)}), expected such as 'A: fleet.size=9'"]
        ) from None
    if document.problems or not isinstance(document.data, Mapping):
        raise ModelError([f"--option {text}: expected names, each with keys and values or the name of a model"])
    yield from ((str(name), what) for name, what in document.data.items())


def _model(name: str, what: Any, model: Model) -> Model:
    from desim_warehouse.model import load

    if isinstance(what, Mapping):
        return model.replace(what)
    if "=" not in str(what):
        return load(str(what))
    parts = tuple(part.strip() for part in str(what).split(";") if part.strip())
    return model.replace(read_assignments(parts, f"--option {name}:"))
