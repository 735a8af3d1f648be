"""`desim replay`."""

from __future__ import annotations

import click

from desim_warehouse.cli.options import run_of, with_overrides, with_seed


@click.command("replay")
@click.argument("source", metavar="MODEL|RUN_DIR")
@click.option(
    "-o", "--out", "output", metavar="FILE", default="replay.html", show_default=True, help="The page to write."
)
@with_overrides
@with_seed
@click.option(
    "--beside",
    metavar="MODEL|RUN_DIR",
    help="Another run, shown next to it on the same clock; --set and --accept change only MODEL.",
)
@click.option("--from", "start", type=float, metavar="T", help="First moment shown, in the model's time unit.")
@click.option("--to", "end", type=float, metavar="T", help="Last moment shown.")
@click.option(
    "--palette",
    type=click.Choice(["safe", "paper"]),
    default="safe",
    show_default=True,
    help="Colours safe for colour-blind people, or the paper's.",
)
def command(
    source: str,
    output: str,
    assignments: tuple[str, ...],
    seed: int,
    beside: str | None,
    start: float | None,
    end: float | None,
    palette: str,
) -> None:
    """Write a page that plays a run in any browser, without a network: simulated from MODEL, or read from RUN_DIR."""
    run = run_of(source, assignments, seed)
    other = None if beside is None else run_of(beside, (), seed)
    page = run.replay(output, start=start, end=end, palette=palette, beside=other)
    click.echo(f"{output}: {len(page.html) / 1e6:.1f} MB; open it in a browser")
