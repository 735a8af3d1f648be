"""`desim long-run`."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.options import run_of, with_overrides, with_seed
from desim_warehouse.cli.run import with_unit
from desim_warehouse.cli.study_options import with_indicator
from desim_warehouse.cli.tables import show

if TYPE_CHECKING:
    from desim_warehouse.run import Run
    from desim_warehouse.study.statistics import OneRun


@click.command("long-run")
@click.argument("source", metavar="MODEL|RUN_DIR")
@with_overrides
@with_indicator
@click.option(
    "--confidence",
    type=click.FloatRange(0, 1, min_open=True, max_open=True),
    default=0.95,
    show_default=True,
    help="Of the intervals.",
)
@with_seed
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    source: str,
    assignments: tuple[str, ...],
    indicators: tuple[str, ...],
    confidence: float,
    seed: int,
    as_json: bool,
) -> None:
    """Show what one long run says about a steady state: indicators of tasks, with intervals by batch means.

    The run is that of RUN_DIR, or one of a lifelong MODEL. It says so where it is too short.
    """
    from desim_warehouse.study.long_run import long_run

    run = run_of(source, assignments, seed)
    found = long_run(run, indicators or None, confidence)
    if as_json:
        click.echo(json.dumps({name: _content(one) for name, one in found.items()}))
    else:
        _show(run, found, confidence)


def _content(found: OneRun) -> dict[str, float | bool | str | None]:
    low, high = (end if math.isfinite(end) else None for end in found.interval)
    return {
        "value": found.value,
        "low": low,
        "high": high,
        "observations": found.observations,
        "correlation": found.correlation,
        "independent": found.independent,
        "note": found.note,
    }


def _show(run: Run, found: dict[str, OneRun], confidence: float) -> None:
    from rich.table import Table

    from desim_warehouse.report.text import words

    units = run.model.units
    counted = f"counted from {run.history.begin:,g} to {run.T:,g} {units.time}"
    table = Table(title=f"{run.model.name}: one run, {counted}", title_justify="left", box=None, pad_edge=False)
    table.add_column("indicator")
    for head in ("value", "from", "to"):
        table.add_column(head, justify="right")
    table.add_column("unit")
    table.add_column("note")
    for name, one in found.items():
        kind = words.indicator_kind(name)
        cells = [
            with_unit(kind, value, units)[0] if math.isfinite(value) else "?" for value in (one.value, *one.interval)
        ]
        table.add_row(name, *cells, with_unit(kind, one.value, units)[1], one.note)
    show(table)
    click.echo(f"from, to: {100 * confidence:g} % interval by 20 batches of the run")
