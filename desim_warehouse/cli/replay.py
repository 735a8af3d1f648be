"""`desim replay`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import run_of, with_overrides, with_seed
from desim_warehouse.folders import refuse_other

if TYPE_CHECKING:
    from desim_warehouse.model import Model
    from desim_warehouse.model.schema import Units


@click.command("replay")
@click.argument("source", type=AtPath(), metavar="MODEL|RUN_DIR")
@click.option(
    "-o", "--out", "output", metavar="FILE", default="replay.html", show_default=True, help="The page to write."
)
@with_overrides
@with_seed
@click.option(
    "--beside",
    metavar="MODEL|RUN_DIR",
    help="Another run to show side by side on the same clock; --set and --accept change only MODEL.",
)
@click.option(
    "--from",
    "start",
    metavar="TIME",
    help="Time at which the replay begins, such as 20min; a plain number is in the time unit of the model.",
)
@click.option(
    "--to", "end", metavar="TIME", help="Time at which the replay ends; a MODEL is simulated only up to then."
)
@click.option(
    "--palette",
    type=click.Choice(["safe", "paper"]),
    default="safe",
    show_default=True,
    help="Colours: safe for colour-blind people, or those of the paper.",
)
def command(
    source: str,
    output: str,
    assignments: tuple[str, ...],
    seed: int,
    beside: str | None,
    start: str | None,
    end: str | None,
    palette: str,
) -> None:
    """Write a page that plays a run in any browser, offline: a new run of MODEL, or the run stored in RUN_DIR."""

    def until(model: Model) -> float | None:
        first, last = (_time(text, option, model.units) for text, option in ((start, "--from"), (end, "--to")))
        if last is not None and not last > max(first or 0.0, 0.0):
            raise click.BadParameter(f"{end} is not after {start or 'the start of the run'}.", param_hint="--to")
        return last

    refuse_other(Path(output), "page")  # before a long run, not after it
    run = run_of(source, assignments, seed, until=until, log="all")
    other = None if beside is None else run_of(beside, (), seed, until=until, log="all")
    first, last = (_time(text, option, run.model.units) for text, option in ((start, "--from"), (end, "--to")))
    page = run.replay(output, start=first, end=last, palette=palette, beside=other)
    click.echo(f"{output}: {len(page.html) / 1e6:.1f} MB; open it in a browser")


def _time(text: str | None, option: str, units: Units) -> float | None:
    """Return a time of a run in the model's unit."""
    from desim_warehouse.values.units import quantity

    try:
        return None if text is None else quantity(text, "time", units.names)
    except ValueError as error:
        raise click.BadParameter(f"{error}.", param_hint=option) from None
