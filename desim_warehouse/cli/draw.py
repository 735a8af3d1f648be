"""`desim draw`."""

from __future__ import annotations

import click

from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import load_model, with_overrides


@click.command("draw")
@click.argument("model", type=AtPath())
@click.option(
    "-o",
    "--out",
    "output",
    default="floor.svg",
    show_default=True,
    metavar="FILE",
    help="The drawing to write: PNG, SVG or PDF, by the extension.",
)
@click.option(
    "--names", is_flag=True, help="Label storage places, too, with their names (layout.storage_names) or numbers."
)
@with_overrides
def command(model: str, output: str, names: bool, assignments: tuple[str, ...]) -> None:
    """Draw the floor of MODEL with names, directions, chargers, stations and storage places, without simulating."""
    from desim_warehouse.plot.floor import save

    save(load_model(model, assignments), output, names=names)
    click.echo(f"{output}: the floor")
