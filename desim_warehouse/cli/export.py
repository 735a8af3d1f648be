"""`desim export`."""

from __future__ import annotations

from pathlib import Path

import click

_DEFAULT = {"csv": "csv", "parquet": "parquet", "trace": "trace.json"}


@click.command("export")
@click.argument("run_dir")
@click.option(
    "--format",
    "form",
    type=click.Choice(list(_DEFAULT)),
    required=True,
    help="csv, parquet: a folder of tables; trace: one file for ui.perfetto.dev or chrome://tracing.",
)
@click.option("-o", "--out", metavar="PATH", help="Default: csv/, parquet/ or trace.json in RUN_DIR.")
def command(run_dir: str, form: str, out: str | None) -> None:
    """Write the run in RUN_DIR (from `desim run --out`) in an open format."""
    from desim_warehouse.report.export import export
    from desim_warehouse.run.folder import load_run

    path = Path(run_dir) / _DEFAULT[form] if out is None else Path(out)
    click.echo(export(load_run(run_dir), form, path))
