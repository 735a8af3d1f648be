"""`desim best`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.options import with_overrides, with_seed
from desim_warehouse.cli.study_options import (
    interruptible,
    number,
    read_assignments,
    read_vary,
    show,
    with_confidence,
    with_execution,
    with_vary,
)

if TYPE_CHECKING:
    from desim_warehouse.study.procedures import Best
    from desim_warehouse.study.study import Study


@click.command("best")
@click.argument("model")
@with_vary
@with_overrides
@click.option("--indicator", required=True, metavar="NAME", help="What is compared, such as T.")
@click.option("--delta", required=True, type=float, help="A difference that does not matter, in its unit.")
@click.option("--minimise", "sense", flag_value="minimise", help="The smallest mean is best (default for T, S, ...).")
@click.option("--maximise", "sense", flag_value="maximise", help="The largest mean is best.")
@click.option("--first", default=10, show_default=True, help="Replications before any design drops out.")
@click.option("--cap", default=1000, show_default=True, help="Most replications of a design.")
@with_confidence
@with_seed
@with_execution
def command(
    model: str,
    vary: tuple[str, ...],
    assignments: tuple[str, ...],
    indicator: str,
    delta: float,
    sense: str | None,
    first: int,
    cap: int,
    confidence: float,
    seed: int,
    workers: str,
    cluster: str | None,
    timeout: float | None,
    out: str | None,
    quiet: bool,
) -> None:
    """Find the best design: of MODEL with what `--vary` says, or of a study file or folder.

    Designs that are clearly worse drop out early (KN: Kim & Nelson 2001). Example: desim best
    models/multibots.yaml --vary fleet.size=1..6 --set 'tasks.goods={random: 20}' --indicator cost --delta 50
    """
    from desim_warehouse.study.procedures import best

    study = _study(model, vary, assignments, seed, confidence, timeout)
    if Path(model).is_dir():
        out = out or model
    with interruptible(study, out):
        found = best(
            study,
            indicator,
            delta,
            maximise=None if sense is None else sense == "maximise",
            first=first,
            cap=cap,
            workers=workers,
            cluster=cluster,
            out=out,
            progress=not quiet,
        )
    _show(study, found)


def _study(
    path: str,
    vary: tuple[str, ...],
    assignments: tuple[str, ...],
    seed: int,
    confidence: float,
    timeout: float | None,
) -> Study:
    """The candidates: of a model with `--vary`, else of a study."""
    from desim_warehouse.study.record import read_record
    from desim_warehouse.study.study import Study

    changes = read_assignments(assignments)
    if vary:
        study = Study(
            path,
            read_vary(vary),
            seed=seed,
            changes=changes,
            confidence=confidence,
            timeout=timeout,
            name="best",
        )
        study.plan = study.plan.unreplicated()
        return study
    study = Study.of(read_record(Path(path))) if Path(path).is_dir() else Study.read(path, changes)
    study.plan = replace(study.plan, confidence=confidence, timeout=timeout or study.plan.timeout)
    return study


def _show(study: Study, found: Best) -> None:
    from rich.table import Table

    selection = found.selection
    table = Table(title=f"{found.indicator}: the candidates", title_justify="left", box=None)
    for name in ("design", "mean", "runs", ""):
        table.add_column(name, justify="left" if name in {"design", ""} else "right")
    for point in study.points:
        out_at = selection.eliminated_at[point.number]
        verdict = "best" if point.number == selection.best else "" if out_at is None else f"out after {out_at}"
        mean, runs = selection.means[point.number], selection.samples[point.number]
        table.add_row(str(point), number(mean), str(runs), verdict)
    show(table)
    sense = "largest" if found.maximise else "smallest"
    click.echo(f"{found.point}: {sense} {found.indicator}; {selection.note}")
