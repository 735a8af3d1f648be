"""`desim run`."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.options import load_model, with_overrides, with_seed

if TYPE_CHECKING:
    from desim_warehouse.run import Run


@click.command("run")
@click.argument("model")
@with_overrides
@with_seed
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object: indicators, seed, version.")
@click.option("--out", metavar="DIR", help="Write model, indicators, log and tables to a folder.")
def command(model: str, assignments: tuple[str, ...], seed: int, as_json: bool, out: str | None) -> None:
    """Simulate MODEL once and show its indicators."""
    from desim_warehouse import __version__
    from desim_warehouse.run import simulate
    from desim_warehouse.runfolder import prepare

    loaded = load_model(model, assignments)
    if out is not None:
        prepare(Path(out))  # a folder that cannot be used is told before a long run, not after it
    run = simulate(loaded, seed)
    if out is not None:
        run.save(out)
    if as_json:
        plain = {key: None if math.isnan(value) else value for key, value in run.kpis.items()}
        click.echo(json.dumps({**plain, "seed": seed, "version": __version__}))
    else:
        _show(run)


def _show(run: Run) -> None:
    from rich.console import Console
    from rich.table import Table

    units = run.model.units
    unit_of = {
        "T": f"{units.time} ({run.T * units.seconds:,.1f} s)",
        "distance": units.length,
        "waiting": units.time,
        "cycle_time_mean": units.time,
        "cycle_time_median": units.time,
        "cycle_time_p95": units.time,
    }
    table = Table(title=f"{run.model.name}, seed {run.seed}", title_justify="left", box=None)
    table.add_column("indicator")
    table.add_column("value", justify="right")
    table.add_column("unit")
    for key, value in run.kpis.items():
        shown = "-" if math.isnan(value) else f"{value:,d}" if isinstance(value, int) else f"{value:,.4g}"
        if key in ("T", "distance", "waiting", "cost", "energy") and not isinstance(value, int):
            shown = f"{value:,.1f}"
        table.add_row(key, shown, unit_of.get(key, ""))
    Console(highlight=False).print(table)
