"""`desim best`."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from desim_warehouse.cli.answers import give
from desim_warehouse.cli.completion import AtPath, indicators
from desim_warehouse.cli.options import load_model, with_json, with_overrides
from desim_warehouse.cli.study_options import (
    at_home,
    interruptible,
    read_vary,
    stated,
    study_of,
    study_plan,
    with_search,
    with_vary,
)
from desim_warehouse.cli.tables import NONE_MEETS
from desim_warehouse.cli.warned import warn
from desim_warehouse.study.statistics.limits import MOST_RUNS, RACED, SEARCH_RUNS

if TYPE_CHECKING:
    from desim_warehouse.model import Model
    from desim_warehouse.study.search import Search


@click.command("best")
@click.argument("model", type=AtPath())
@with_vary
@click.option(
    "--indicator",
    required=True,
    shell_complete=indicators,
    metavar="NAME",
    help="Indicator to compare designs by, such as T.",
)
@click.option("--target", help="Target that the best design must also meet, such as 'on_time >= 95 %'.")
@click.option(
    "--place-chargers",
    type=click.IntRange(1),
    metavar="K",
    help="Search for the best K nodes to place chargers at, one each.",
)
@click.option("--directions", is_flag=True, help="Search for the best directions of aisles.")
@click.option(
    "--runs",
    type=click.IntRange(1, MOST_RUNS),
    help=f"Maximum number of runs in all.  [default: {SEARCH_RUNS} for a search; a race ends at --cap]",
)
@click.option(
    "--delta",
    metavar="AMOUNT",
    help="Indifference zone: the largest difference that does not matter, such as 5, 5s or 1%.  "
    "[default: 1 % of the first mean]",
)
@click.option("--minimise", "sense", flag_value="minimise", help="Prefer small values (default for T, S, ...).")
@click.option("--maximise", "sense", flag_value="maximise", help="Prefer large values.")
@click.option("--page", metavar="FILE", help="Write a page about the search: the answer, and all designs tried.")
@with_json()
@with_overrides
@with_search("confidence", "seed", first=RACED[0], cap=RACED[1])
def command(
    model: str,
    vary: tuple[str, ...],
    indicator: str,
    target: str | None,
    place_chargers: int | None,
    delta: str | None,
    sense: str | None,
    page: str | None,
    assignments: tuple[str, ...],
    search: Search,
    *,
    directions: bool,
    as_json: bool,
) -> None:
    """Find the best of the designs of MODEL that --vary describes, or of those in a study file or folder.

    If --runs allows ten runs for each design, all designs race, and those that are clearly worse drop out early (KN:
    Kim & Nelson 2001). With more designs, or with --target, --place-chargers or --directions, four fifths of the runs
    search, and the last fifth judges the best designs on new days. Exit status 3: no design was shown to meet the
    target. For a study, confidence and seed default to those of the study. Examples: desim best models/multibots.yaml
    --vary fleet.size=1..6 --set 'tasks.goods={random: 20}' --indicator cost --delta 50; desim best w.yaml --indicator
    annual_cost --target "on_time >= 95 %" --vary fleet.size=4..14 --place-chargers 3 --directions
    """
    more = None if sense is None else sense == "maximise"
    factors = read_vary(vary)
    sought = [target, place_chargers, directions or None]
    if any(choice is not None for choice in sought) or (factors and _are_many(model, assignments, factors, search)):
        if not factors and Path(model).is_dir():
            raise click.UsageError(f"{model}: a study, all of whose designs race; a search is for a model")
        asked = {"target": target, "place_chargers": place_chargers, "directions": directions, "maximise": more}
        _search(model, assignments, indicator, delta, {**asked, "vary": factors}, page, search, as_json=as_json)
        return
    if page is not None:
        raise click.UsageError("--page is for a search; of designs that all race desim what-if --page makes one")
    _race(model, assignments, factors, indicator, delta, more, search, as_json=as_json)


def _are_many(model: str, assignments: tuple[str, ...], factors: Mapping[str, Any], search: Search) -> bool:
    """Whether there are too many designs for ten runs each; raises at the option whose values are invalid."""
    from desim_warehouse.study.designs.best_of_many import are_few

    alone = [study_of(model, assignments, {key: values}, search, name="best") for key, values in factors.items()]
    return not are_few([factor for study in alone for factor in study.plan.factors], search.runs or SEARCH_RUNS)


def _race(
    model: str,
    assignments: tuple[str, ...],
    factors: Mapping[str, Any],
    indicator: str,
    delta: str | None,
    more: bool | None,
    search: Search,
    *,
    as_json: bool,
) -> None:
    from desim_warehouse.questions.race import best_of_study
    from desim_warehouse.questions.study import Study

    if factors:
        study = study_of(model, assignments, factors, search, name="best", indicators=[indicator])
        study.plan = study.plan.unreplicated()
    else:
        study = Study.of(study_plan(model, assignments, **stated(search)))
        search = at_home(search, model)
        _say_what_is_replaced(search.out)
    warnings = warn(study.plan.base, model if factors else None, assignments, as_json=as_json)
    zone = _delta(delta, indicator, study.plan.base)
    with interruptible(study, search):
        raced = best_of_study(study, indicator, zone, maximise=more, search=search)
    give(raced.answer, search.out, warnings, as_json=as_json)


def _say_what_is_replaced(folder: str | Path | None) -> None:
    """Print which answer of another command in a folder is about to be replaced, as a folder holds one answer."""
    from desim_warehouse.answer.answer import load
    from desim_warehouse.folders import ANSWER

    if folder is not None and Path(folder, ANSWER).is_file() and load(folder).kind != "best":
        click.echo(f"{Path(folder, ANSWER)}: replaced; it answered: {load(folder).question}", err=True)


def _search(
    model: str,
    assignments: tuple[str, ...],
    indicator: str,
    delta: str | None,
    asked: Mapping[str, Any],
    page: str | None,
    search: Search,
    *,
    as_json: bool,
) -> None:
    from desim_warehouse.look.web import WebPage
    from desim_warehouse.questions.best import BestOfMany, best
    from desim_warehouse.report.write import page_of_answer

    base = load_model(model, assignments)
    warnings = warn(base, model, assignments, as_json=as_json)
    zone = _delta(delta, indicator, base)
    with interruptible(None, search):
        result = best(base, indicator, zone, **asked, search=search)
    assert isinstance(result, BestOfMany)  # few designs without a target race above
    answer = give(result.answer, search.out, warnings, as_json=as_json)
    if page is not None:
        WebPage(answer.question, page_of_answer(answer)).save(page)
        click.echo(f"{page}: open it in a browser", err=as_json)
    if result.shown is False:
        sys.exit(NONE_MEETS)


def _delta(text: str | None, indicator: str, model: Model) -> float | None:
    """Return the indifference zone in the unit of its indicator."""
    from desim_warehouse.outcome.indicators import find
    from desim_warehouse.outcome.targets import amount_of

    if text is None:
        return None
    delta = amount_of(find(indicator), text, model.units.names, "--delta")
    if not delta > 0:
        raise click.BadParameter(f"{text} is not above 0.", param_hint="--delta")
    return delta
