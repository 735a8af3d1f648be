"""`desim warm-up`."""

from __future__ import annotations

from pathlib import Path

import click

from desim_warehouse.cli.options import load_model, with_overrides, with_seed
from desim_warehouse.errors import number_of
from desim_warehouse.report.plot.style import save
from desim_warehouse.study.limits import MOST_REPLICATIONS


@click.command("warm-up")
@click.argument("model")
@with_overrides
@click.option(
    "--replications",
    type=click.IntRange(1, MOST_REPLICATIONS),
    default=10,
    show_default=True,
    help="Runs that are averaged.",
)
@click.option(
    "--observations",
    type=click.IntRange(min=1),
    default=200,
    show_default=True,
    help="Intervals that a run is divided into.",
)
@click.option(
    "--observe",
    type=click.Choice(["throughput", "cycle_time"]),
    default="throughput",
    show_default=True,
    help="What is observed.",
)
@click.option(
    "--window",
    type=click.IntRange(min=1),
    metavar="W",
    help="Of Welch's plot: observations on either side of a mean.  [default: three curves]",
)
@click.option("--out", metavar="DIR", help="For the plots: warm-up and welch, as .png and .svg.")
@with_seed
def command(
    model: str,
    assignments: tuple[str, ...],
    replications: int,
    observations: int,
    observe: str,
    window: int | None,
    out: str | None,
    seed: int,
) -> None:
    """Find how long lifelong MODEL takes to settle (MSER-5), for its key run.warm_up."""
    from desim_warehouse.study.warm_up import settle

    read = load_model(model, assignments)
    found = settle(
        read,
        replications=replications,
        observations=observations,
        observed="throughput" if observe == "throughput" else "cycle_time",
        seed=seed,
    )
    click.echo(f"{observe}, {number_of(replications, 'run')}, one observation each {found.width:g} {found.time_unit}")
    if found.time is None:
        click.echo(f"not settled: {found.found.note}")
        if read.calendars:
            click.echo("what changes by calendars never settles: let run.length and run.warm_up be whole periods")
    else:
        click.echo(f"{found.found.note}: run.warm_up: {found.time:g}  # {found.time_unit}")
    if out is not None:
        from desim_warehouse.report.plot import welch

        curves = welch(found, window).get_figure(root=True)
        save(found.figure(), Path(out), "warm-up")
        save(curves, Path(out), "welch")
        click.echo(f"written to {out}")
