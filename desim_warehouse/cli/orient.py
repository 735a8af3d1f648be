"""`desim orient`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.options import load_model, refuse_files, with_force, with_seed, write_files
from desim_warehouse.cli.size import NONE_MEETS
from desim_warehouse.cli.study_options import ExecutionOptions, interruptible, with_execution_in

if TYPE_CHECKING:
    from desim_warehouse.layout.orient import Orientation
    from desim_warehouse.model import Model

_FAR = 1.3
_SHOWN = 12
_RUNS, _RUNS_SEARCHED = 10, 500


@click.command("orient")
@click.argument("model")
@click.option("-o", "--out", "file", required=True, metavar="FILE", help="The model file to write.")
@click.option("--indicator", metavar="NAME", help="Search by simulation: what should be best, such as on_time.")
@click.option(
    "--runs",
    type=click.IntRange(0),
    help=f"The most runs in all.  [default: {_RUNS}, to compare both floors; with --indicator {_RUNS_SEARCHED}]",
)
@with_seed
@with_execution_in("--study")
@with_force
def command(
    model: str,
    file: str,
    indicator: str | None,
    runs: int | None,
    seed: int,
    execution: ExecutionOptions,
    *,
    force: bool,
) -> None:
    """Make the two-way lanes of MODEL one-way where the floor stays connected, or search better directions.

    Without --indicator: parallel aisles alternate at first; then aisles and lanes are turned as long as that shortens
    the mean trip between goods and stations. Bridges stay two-way. Says how much longer trips are, and by paired runs
    which of the two floors does better.

    With --indicator, aisles that are drawn one-way may be turned, too, and two-way ones become one-way or prefer a
    direction. A search simulates the floors, and the best is compared with the floor as drawn in runs that the search
    did not use, also with other fleets and demands. Exit status 3: nothing better was found, and nothing is written.
    Example: desim orient w.yaml -o turned.yaml --indicator throughput_per_hour
    """
    if indicator is not None:
        _search(model, file, indicator, runs or _RUNS_SEARCHED, seed, execution, force=force)
    else:
        _by_distance(model, file, _RUNS if runs is None else runs, seed, force=force)
    click.echo(f"{file} is written; next: desim check {file}")


def _search(
    model: str, file: str, indicator: str, runs: int, seed: int, execution: ExecutionOptions, *, force: bool
) -> None:
    from desim_warehouse.model.oriented import turned_files
    from desim_warehouse.study.directions import directions, told

    base = load_model(model, ())
    refuse_files([Path(file)], force=force)
    with interruptible(None, execution.kept):
        found = directions(base, indicator, runs=runs, seed=seed, timeout=execution.timeout, **execution.where())
    click.echo("\n".join(told(found)))
    if found.gain is None:
        sys.exit(NONE_MEETS)
    write_files(turned_files(Path(model), base, found.ways, Path(file)), force=force)


def _by_distance(model: str, file: str, runs: int, seed: int, *, force: bool) -> None:
    from desim_warehouse.model.oriented import orientation, oriented_files

    base = load_model(model, ())
    found = orientation(base)
    write_files(oriented_files(Path(model), base, found, Path(file)), force=force)
    click.echo("\n".join(_said(found)))
    if runs > 1:
        click.echo(_compared(base, load_model(file, ()), runs // 2, seed))


def _said(found: Orientation) -> list[str]:
    lines = [f"{len(found.kept)} two-way lanes are one-way now; trips between goods and stations are "]
    lines[0] += f"{found.stretch:.2f} times as long"
    if found.stretch > _FAR:
        lines.append(f"warning: more than {_FAR} times as long; two-way lanes may serve better here")
    if found.bridges:
        names = ", ".join("-".join(lane) for lane in found.bridges[:_SHOWN])
        more = f" and {len(found.bridges) - _SHOWN} more" if len(found.bridges) > _SHOWN else ""
        lines.append(f"{len(found.bridges)} stay two-way, as they alone lead to what is beyond: {names}{more}")
    return lines


def _compared(two_way: Model, one_way: Model, runs: int, first: int) -> str:
    """Compare the two floors by paired runs."""
    from desim_warehouse import simulate
    from desim_warehouse.report.text.printed import said
    from desim_warehouse.study.statistics import paired

    key = "cycle_time_mean" if two_way.run.length else "T"  # what is delivered follows demand on either floor
    kpis = [[simulate(floor, seed).kpis[key] for seed in range(first, first + runs)] for floor in (one_way, two_way)]
    gain = paired(kpis[0], kpis[1])
    interval = gain.interval or (gain.mean, gain.mean)
    verdict = "no significant difference"
    if interval[1] < 0:
        verdict = "one-way does better"
    elif interval[0] > 0:
        verdict = "two-way does better"
    means = " against ".join(f"{sum(values) / runs:,.1f}" for values in kpis)
    return f"{key} of {runs} runs each: one-way {means} two-way, {said(gain)} by pairs: {verdict}"
