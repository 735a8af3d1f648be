"""`desim orient`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.options import load_model, with_force, write_files

if TYPE_CHECKING:
    from desim_warehouse.layout.orient import Orientation
    from desim_warehouse.model import Model

_FAR = 1.3
_SHOWN = 12


@click.command("orient")
@click.argument("model")
@click.option("-o", "--out", required=True, metavar="FILE", help="The model file to write.")
@click.option("--runs", type=click.IntRange(0), default=5, show_default=True, help="Of either floor, to compare them.")
@with_force
def command(model: str, out: str, runs: int, *, force: bool) -> None:
    """Make the two-way lanes of MODEL one-way where the floor stays connected; bridges stay two-way.

    Parallel aisles alternate at first; then aisles and lanes are turned as long as that shortens the mean trip between
    goods and stations. Says how much longer trips are, and by paired runs which of the two floors does better.
    """
    from desim_warehouse.model.oriented import orientation, oriented_files

    base = load_model(model, ())
    found = orientation(base)
    write_files(oriented_files(Path(model), base, found, Path(out)), force=force)
    click.echo("\n".join(_said(found)))
    if runs:
        click.echo(_compared(base, load_model(out, ()), runs))
    click.echo(f"{out} is written; next: desim check {out}")


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


def _compared(two_way: Model, one_way: Model, runs: int) -> str:
    """Compare the two floors by paired runs."""
    from desim_warehouse import simulate
    from desim_warehouse.report.text import words
    from desim_warehouse.study.statistics import paired

    key = "cycle_time_mean" if two_way.run.length else "T"  # what is delivered follows demand on either floor
    kpis = [[simulate(floor, seed).kpis[key] for seed in range(runs)] for floor in (one_way, two_way)]
    gain = paired(kpis[0], kpis[1])
    interval = gain.interval or (gain.mean, gain.mean)
    verdict = "no significant difference"
    if interval[1] < 0:
        verdict = "one-way does better"
    elif interval[0] > 0:
        verdict = "two-way does better"
    means = [math.fsum(values) / runs for values in kpis]
    scale = words.scale(key, two_way, means)
    said = " against ".join(map(scale.value, means))
    name = words.in_sentence(key)
    return f"{name} of {runs} runs each: one-way {said} two-way, {scale.cell(gain)} by pairs: {verdict}"
