"""`desim import`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import with_force, write_files
from desim_warehouse.cli.tables import show_remarks
from desim_warehouse.plants.formats import CELLS, FORMATS, TASK_FILES, names_with, titles

_HELP = f"""Convert FILE, a layout from another program, into a model.

FILE may be {titles(FORMATS)}. A table lists what could not be converted, what is unreachable, and what is assumed
because the file does not specify it.
"""


@click.command("import", help=_HELP)
@click.argument("file", type=AtPath())
@click.option("-o", "--out", metavar="MODEL", help="The model file to write.  [default: standard output]")
@with_force
@click.option(
    "--operation",
    "operations",
    multiple=True,
    metavar="NAME=WHAT",
    help="What robots do at locations with this operation: load, unload, charge, park or none, such as "
    "'Pack=unload'; may be repeated.  [default: guessed from its name]",
)
@click.option(
    "--fleet",
    "robots",
    type=click.IntRange(min=1),
    metavar="N",
    help="Number of robots.  [default: as many as FILE shows]",
)
@click.option(
    "--robot", metavar="FILE", help="YAML file with the model sections robot and battery.  [default: typical values]"
)
@click.option("--tasks", metavar="FILE", help=f"File with tasks: {titles(TASK_FILES)}.")
@click.option(
    "--layout", metavar="NAME", help=f"{names_with('layout')}: the layout or level to read, if FILE has several."
)
@click.option(
    "--vehicle-type",
    metavar="NAME",
    help=f"{names_with('vehicle_type')}: the type whose nodes and edges are read.  [default: the one with most edges]",
)
@click.option(
    "--graph",
    type=click.IntRange(min=0),
    metavar="N",
    help=f"{names_with('graph')}: the graph_idx to read.  [default: the graph with most lanes]",
)
@click.option("--two-way", is_flag=True, default=None, help=f"{names_with('two_way')}: make every edge two-way.")
@click.option(
    "--cell",
    type=click.FloatRange(*CELLS),
    metavar="METRES",
    help=f"{names_with('cell')}: side length of a cell.  [default: 1]",
)
@click.option(
    "--lanes",
    multiple=True,
    metavar="LAYER",
    help=f"{names_with('lanes')}: a layer whose lines are lanes; may be repeated.  [default: guessed from its name]",
)
@click.option(
    "--strict", is_flag=True, default=None, help=f"{names_with('strict')}: refuse files that violate the format."
)
def command(
    file: str, out: str | None, force: bool, operations: tuple[str, ...], robots: int | None, **others: Any
) -> None:
    """Convert a layout into a model; see `_HELP`."""
    from desim_warehouse.plants import import_layout

    chosen = {option: value for option, value in others.items() if value not in {None, ()}}
    made = import_layout(file, operations=dict(map(_operation, operations)), robots=robots, **chosen)
    if out is None and made.orders:
        raise click.UsageError("the tasks of this file are written beside the model; name one with -o")
    in_short = made.in_short()
    if out is None:
        click.echo(in_short, err=True)
        click.echo(made.text(), nl=False)
    else:
        write_files(made.files(Path(out)), force=force)
        click.echo(f"{out}: {in_short}")
    show_remarks(made.remarks, err=out is None)


def _operation(text: str) -> tuple[str, str]:
    name, equals, what = text.rpartition("=")
    if not equals:
        raise click.BadParameter(f"{text!r}, expected NAME=WHAT such as 'Pack=unload'", param_hint="--operation")
    return name.strip(), what.strip()
