"""`desim best`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.by_hand import warn
from desim_warehouse.cli.study_options import (
    ExecutionOptions,
    ModelOptions,
    interruptible,
    read_vary,
    study_plan,
    with_execution,
    with_first_and_cap,
    with_question,
    with_vary,
)
from desim_warehouse.cli.tables import sheet, show, show_verdicts
from desim_warehouse.errors import spoken
from desim_warehouse.report.text import words

if TYPE_CHECKING:
    from desim_warehouse.model import Model
    from desim_warehouse.study.procedures import Best
    from desim_warehouse.study.statistics import Selection
    from desim_warehouse.study.study import Study


@click.command("best")
@click.argument("model")
@with_vary
@click.option("--indicator", required=True, metavar="NAME", help="The indicator to compare, such as T.")
@click.option(
    "--delta",
    required=True,
    metavar="AMOUNT",
    help="Indifference zone: a difference that does not matter, such as 5, 5s or 1%.",
)
@click.option("--minimise", "sense", flag_value="minimise", help="The smallest mean is best (default for T, S, ...).")
@click.option("--maximise", "sense", flag_value="maximise", help="The largest mean is best.")
@with_first_and_cap(1000)
@with_question
@with_execution
def command(
    model: str,
    vary: tuple[str, ...],
    indicator: str,
    delta: str,
    sense: str | None,
    first: int,
    cap: int,
    question: ModelOptions,
    execution: ExecutionOptions,
) -> None:
    """Find the best design: of MODEL with what `--vary` says, or of a study file or folder.

    Designs that are clearly worse drop out early (KN: Kim & Nelson 2001). A study keeps its own confidence and seed
    by default. Example: desim best
    models/multibots.yaml --vary fleet.size=1..6 --set 'tasks.goods={random: 20}' --indicator cost --delta 50
    """
    from desim_warehouse.study.procedures import best
    from desim_warehouse.study.study import Study

    if vary:
        study = question.study(model, read_vary(vary), "best", execution, indicators=[indicator])
        study.plan = study.plan.unreplicated()
    else:
        stated = {"confidence": question.confidence, "seed": question.seed, "timeout": execution.timeout}
        study = Study.of(study_plan(model, question.assignments, **stated))
        execution = execution.at_home(model)
    warn(study.plan.base, model if vary else None, question.assignments)
    more = None if sense is None else sense == "maximise"
    with interruptible(study, execution.kept):
        found = best(
            study,
            indicator,
            _delta(delta, indicator, study.plan.base),
            maximise=more,
            first=first,
            cap=cap,
            **execution.where(),
        )
    show_best(study, found)


def _delta(text: str, indicator: str, model: Model) -> float:
    """The indifference zone in the unit of its indicator."""
    from desim_warehouse.study.target import amount_of

    delta = amount_of(indicator, text, model.units.names, "--delta")
    if not delta > 0:
        raise click.BadParameter(f"{text} is not above 0.", param_hint="--delta")
    return delta


def show_best(study: Study, found: Best, besides: str | None = None) -> None:
    """Print the answer, what is to be said besides, and the candidates."""
    show_verdicts(study.results)
    selection = found.selection
    scale = words.scale(found.indicator, study.plan.base, selection.means)
    table = sheet(f"{words.head(found.indicator, scale)}: the candidates", "design", ">mean", ">runs", "")
    for point in study.points:
        verdict = _verdict(selection, point.number)
        mean, runs = selection.means[point.number], selection.samples[point.number]
        table.add_row(str(point), scale.bare(mean), str(runs), verdict)
    sense = "largest" if found.maximise else "smallest"
    click.echo(f"{found.point}: {sense} {found.indicator}; {selection.note}")
    if found.within:
        percent = "" if selection.deterministic else f" ({100 * selection.confidence:g} %)"
        names = spoken([str(point) for point in found.within])
        click.echo(f"less than {selection.delta:g} from it{percent}: {names}; take any")
    if besides is not None:
        click.echo(besides)
    show(table)


def _verdict(selection: Selection, design: int) -> str:
    """The verdict on a design, for the table."""
    out_at = selection.eliminated_at[design]
    if design == selection.best:
        return "best"
    if design in selection.within:
        return f"within {selection.delta:g}"
    near = abs(selection.means[design] - selection.means[selection.best]) < selection.delta
    parts = [f"perhaps within {selection.delta:g}"] if near else []
    return ", ".join([*parts, *([] if out_at is None else [f"out after {out_at}"])]) or "not told from the best"
