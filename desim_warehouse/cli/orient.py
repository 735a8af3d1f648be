"""`desim orient`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.options import load_model, with_force, write_files

if TYPE_CHECKING:
    from desim_warehouse.layout.orient import Orientation
    from desim_warehouse.model import Model

_AGAINST = (1.5, 2)
_OPEN = "throughput_per_hour"
_FAR = 1.3
_SHOWN = 12


@click.command("orient")
@click.argument("model")
@click.option("-o", "--out", required=True, metavar="FILE", help="The model file to write.")
@click.option("--runs", type=click.IntRange(0), default=5, show_default=True, help="Of each floor, to compare them.")
@click.option(
    "--prefer", is_flag=True, help="Try two-way lanes that prefer these directions, too; write what does best."
)
@with_force
def command(model: str, out: str, runs: int, *, prefer: bool, force: bool) -> None:
    """Make the two-way lanes of MODEL one-way where the floor stays connected; bridges stay two-way.

    Parallel aisles alternate at first; then aisles and lanes are turned as long as that shortens the mean trip between
    goods and stations. Says how much longer trips are, and by paired runs which of the two floors does better. With
    --prefer the floor that does best is written: two-way lanes as they are (then nothing is), one-way ones, or two-way
    ones that count 1.5 or 2 times when they are driven the other way (against), bridges as they are.
    """
    from desim_warehouse.model.oriented import orientation, oriented_files

    if prefer and not runs:
        raise click.UsageError("--prefer chooses by runs; expected --runs 1 or more")
    base = load_model(model, ())
    found = orientation(base)
    if prefer:
        _prefer(model, base, found, Path(out), runs, force=force)
        return
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


def _prefer(path: str, base: Model, found: Orientation, out: Path, runs: int, *, force: bool) -> None:
    """Write the best of the floors by paired runs, and say how each of them does."""
    from desim_warehouse.model.oriented import oriented, oriented_files
    from desim_warehouse.report.text.printed import said
    from desim_warehouse.study.statistics import paired

    key = _judged_by(base)
    floors: dict[str, float | None] = {"one-way": None} | {f"preferred, {factor:g}": factor for factor in _AGAINST}
    kpis = {"two-way": _runs(base, key, runs)}
    kpis |= {name: _runs(oriented(base, found, factor), key, runs) for name, factor in floors.items()}
    means = {name: sum(values) / runs for name, values in kpis.items()}
    best = (max if key == _OPEN else min)(means, key=means.__getitem__)
    click.echo(f"{key} of {runs} runs each, and the difference to two-way by pairs:")
    for name, values in kpis.items():
        gain = "" if name == "two-way" else f"  {said(paired(values, kpis['two-way']))}"
        click.echo(f"  {name:15}{means[name]:10,.1f}{gain}{'  best' if name == best else ''}")
    if best == "two-way":
        click.echo(f"two-way lanes as they are do best: {out} is not written")
        return
    write_files(oriented_files(Path(path), base, found, out, floors[best]), force=force)
    if floors[best] is None:
        click.echo("\n".join(_said(found)))
    else:
        click.echo(f"{len(found.kept)} two-way lanes prefer a direction: against: {floors[best]:g} on each")
    click.echo(f"{out} is written; next: desim check {out}")


def _judged_by(model: Model) -> str:
    """What floors are compared by: what is delivered follows demand on any floor, but where tasks are always open."""
    if model.tasks.never_end and not model.tasks.arrive:
        return _OPEN
    return "cycle_time_mean" if model.run.length else "T"


def _runs(floor: Model, key: str, runs: int) -> list[float]:
    from desim_warehouse import simulate

    return [simulate(floor, seed).kpis[key] for seed in range(runs)]


def _compared(two_way: Model, one_way: Model, runs: int) -> str:
    """Compare the two floors by paired runs."""
    from desim_warehouse.report.text.printed import said
    from desim_warehouse.study.statistics import paired

    key = _judged_by(two_way)
    kpis = [_runs(floor, key, runs) for floor in (one_way, two_way)]
    gain = paired(kpis[0], kpis[1])
    interval = gain.interval or (gain.mean, gain.mean)
    verdict = "no significant difference"
    if key == _OPEN:
        interval = -interval[1], -interval[0]
    if interval[1] < 0:
        verdict = "one-way does better"
    elif interval[0] > 0:
        verdict = "two-way does better"
    means = " against ".join(f"{sum(values) / runs:,.1f}" for values in kpis)
    return f"{key} of {runs} runs each: one-way {means} two-way, {said(gain)} by pairs: {verdict}"
