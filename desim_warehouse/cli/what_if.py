"""`desim what-if`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from desim_warehouse.cli.answers import give
from desim_warehouse.cli.completion import AtPath, indicators
from desim_warehouse.cli.options import with_indicator, with_json, with_overrides
from desim_warehouse.cli.study_options import (
    interruptible,
    read_vary,
    refuse_page,
    study_of,
    with_page,
    with_search,
    with_vary,
    write_page,
)
from desim_warehouse.cli.tables import show_failures
from desim_warehouse.cli.warned import warn, warn_of_target
from desim_warehouse.study.statistics.limits import MOST_REPLICATIONS

if TYPE_CHECKING:
    from desim_warehouse.study.search import Search


@click.command("what-if")
@click.argument("model", type=AtPath())
@with_vary
@click.option(
    "--replications",
    default="1",
    show_default=True,
    help="Replications of each design; with --until, how many to begin with.",
)
@click.option(
    "--until",
    shell_complete=indicators,
    metavar="NAME",
    help="Replicate until the mean of this indicator is as precise as --half-width says.",
)
@click.option(
    "--half-width",
    help="Half-width of the confidence interval at which --until stops, as a share of the mean.  [default: 5 %]",
)
@click.option(
    "--cap",
    type=click.IntRange(2, MOST_REPLICATIONS),
    help="Maximum number of replications with --until.  [default: 200]",
)
@click.option(
    "--design",
    default="grid",
    show_default=True,
    help="How values are combined: grid, all with all; paired, the first with the first and so on.",
)
@click.option(
    "--warm-up", type=click.Choice(["auto"]), help="Determine run.warm_up of each design from five pilot runs (MSER-5)."
)
@click.option(
    "--target", help="Target, such as 'on_time >= 95 %': the table and the report show which designs meet it."
)
@with_indicator
@with_page
@with_json()
@with_overrides
@with_search("confidence", "seed")
def command(  # as long as its options are many
    model: str,
    vary: tuple[str, ...],
    replications: str,
    until: str | None,
    half_width: str | None,
    design: str,
    warm_up: str | None,
    target: str | None,
    indicators: tuple[str, ...],
    page: str | None,
    assignments: tuple[str, ...],
    search: Search,
    *,
    as_json: bool,
) -> None:
    """Run MODEL with each of the values in --vary, and show how the indicators change.

    Example: desim what-if models/multibots.yaml --vary fleet.size=1..6 --set 'tasks.goods={random: 20}'
    --replications 20 --workers 2
    """
    from desim_warehouse.model.parse import read_yaml

    often: Any = read_yaml(replications, "--replications").data
    if until is not None:
        often = _until(until, often, half_width or "5 %", search)
    elif half_width is not None or search.cap is not None:
        raise click.UsageError("--half-width and --cap say when --until NAME ends: name an indicator with --until")
    study = study_of(
        model,
        assignments,
        read_vary(vary),
        search,
        name="what-if",
        replications=often,
        indicators=[name for name in indicators if name != "all"] or None,
        design=read_yaml(design, "--design").data,
        warm_up=warm_up,
        target=target,
    )
    refuse_page(page, study.plan)
    warnings = warn(study.plan.base, model, assignments, as_json=as_json)
    warn_of_target(target, study.plan.base)
    with interruptible(study, search):
        study.run_by(search)
    show_failures(study.results)
    give(study.results.answer_in(indicators), search.out, warnings, as_json=as_json)
    write_page(page, study.results)


def _until(indicator: str, often: Any, half_width: str, search: Search) -> dict[str, Any]:
    """Return the stopping rule of `--until` for a study file; `often`: the first number of replications, if above 1."""
    from desim_warehouse.model.parse import read_yaml

    first = {"minimum": often} if isinstance(often, int) and often > 1 else {}
    cap = {} if search.cap is None else {"cap": search.cap}
    half = read_yaml(half_width, "--half-width").data
    return {"indicator": indicator, "half_width": half, "confidence": search.confidence, **first, **cap}
