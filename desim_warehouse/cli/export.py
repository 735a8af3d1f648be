"""`desim export`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import with_force

if TYPE_CHECKING:
    from desim_warehouse.model import Model


_RUN = {
    "csv": ("csv", "a folder of tables"),
    "parquet": ("parquet", "a folder of tables"),
    "trace": ("trace.json", "one file for ui.perfetto.dev or chrome://tracing"),
    "vda5050": ("states.jsonl", "VDA 5050 state messages, one per line"),
}
"""Formats of a run: the default name of the file or folder, and its description."""
_MODEL = {
    "lif": (".lif", "JSON"),
    "rmf": (".building.yaml", "a building map of Open-RMF"),
    "opentcs": (".xml", "a plant model"),
    "graphml": (".graphml", "a graph"),
    "csv": ("", "a folder with nodes.csv and edges.csv"),
    "svg": (".svg", "a drawing"),
}
"""Formats of a layout: the ending of the default name, and the description."""


def _listed(formats: Mapping[str, tuple[str, str]]) -> str:
    return ", ".join(f"{form} ({what})" for form, (_, what) in formats.items())


@click.command("export")
@click.argument("path", type=AtPath())
@click.option(
    "--format",
    "form",
    type=click.Choice(list(dict.fromkeys([*_RUN, *_MODEL]))),
    required=True,
    help=f"File format. For a run: {_listed(_RUN)}. For a model: {_listed(_MODEL)}.",
)
@click.option(
    "-o",
    "--out",
    metavar="PATH",
    help="File or folder to write.  [default: named after the format, in the run folder or beside the model]",
)
@click.option(
    "--noise",
    type=click.FloatRange(0),
    default=0.0,
    help="vda5050: standard deviation of the noise added to positions.",
)
@click.option("--gaps", type=click.FloatRange(0), default=0.0, help="vda5050: number of gaps per robot and hour.")
@with_force
def command(path: str, form: str, out: str | None, noise: float, gaps: float, force: bool) -> None:
    """Export PATH in an open format: a run (a folder written by `desim run --out`), or the layout of a model file.

    For a layout, a table lists what the model contains but the format cannot represent.
    """
    from desim_warehouse.questions.run import load_run
    from desim_warehouse.report.export import export

    place = Path(path)
    if form in _RUN and (place.is_dir() or form not in _MODEL or place.suffix.lower() not in {".yaml", ".yml"}):
        target = place / _RUN[form][0] if out is None else Path(out)
        click.echo(export(load_run(path), form, target, noise=noise, gaps=gaps, force=force))
        return
    if place.is_dir():
        _layout(load_run(path).model, form, Path(out or place / f"layout{_MODEL[form][0]}"), force)
    else:
        from desim_warehouse.model import load

        _layout(load(path), form, Path(out or place.with_name(place.stem + _MODEL[form][0])), force)


def _layout(model: Model, form: str, out: Path, force: bool) -> None:
    from desim_warehouse.cli.tables import show_remarks
    from desim_warehouse.errors import ReportError
    from desim_warehouse.plants.export import write_layout
    from desim_warehouse.plants.tables import EDGES_FILE, NODES_FILE

    for file in (out / NODES_FILE, out / EDGES_FILE) if form == "csv" else (out,):
        if file.exists() and not force:
            raise ReportError(f"{file}: the file exists; choose another name with -o, or overwrite it with --force")
    if form == "svg":
        from desim_warehouse.plot.floor import save

        out.unlink(missing_ok=True)  # with --force only
        click.echo(save(model, out))
        return
    remarks = write_layout(model, out, form)
    click.echo(out)
    show_remarks(remarks)
