"""`desim warm-up`."""

from __future__ import annotations

from pathlib import Path

import click

from desim_warehouse.cli.answers import keep
from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import load_model, with_overrides, with_seed
from desim_warehouse.folders import ANSWER, refuse_theirs
from desim_warehouse.plot.style import save
from desim_warehouse.study.statistics.limits import MOST_REPLICATIONS


@click.command("warm-up")
@click.argument("model", type=AtPath())
@with_overrides
@click.option(
    "--replications",
    type=click.IntRange(1, MOST_REPLICATIONS),
    default=10,
    show_default=True,
    help="Number of runs to average.",
)
@click.option(
    "--observations",
    type=click.IntRange(min=1),
    default=200,
    show_default=True,
    help="Number of intervals to divide each run into.",
)
@click.option(
    "--observe",
    type=click.Choice(["throughput", "cycle_time"]),
    default="throughput",
    show_default=True,
    help="Quantity to observe.",
)
@click.option(
    "--window",
    type=click.IntRange(min=1),
    metavar="W",
    help="Window of Welch's plot: observations on either side of each mean.  [default: three windows, one curve each]",
)
@click.option("--out", metavar="DIR", help="Folder to write the plots to: warm-up and welch, each as .png and .svg.")
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
    """Find how long MODEL, which has no end, takes to warm up (MSER-5), as a value for its key run.warm_up."""
    from desim_warehouse.questions import input_words
    from desim_warehouse.study.warm_up import settle

    read = load_model(model, assignments)
    settling = settle(
        read,
        replications=replications,
        observations=observations,
        observed="throughput" if observe == "throughput" else "cycle_time",
        seed=seed,
    )
    click.echo("\n".join(input_words.settled(settling, read, observe, replications)))
    if out is not None:
        from desim_warehouse.plot import welch

        pictures = ("warm-up.png", "warm-up.svg", "welch.png", "welch.svg")
        refuse_theirs(Path(out), (ANSWER, *pictures))
        curves = welch(settling, window).get_figure(root=True)
        save(settling.figure(), Path(out), "warm-up")
        save(curves, Path(out), "welch")
        keep(input_words.warm_up(settling, read, observe, replications), out)
        click.echo(f"written to {out}")
