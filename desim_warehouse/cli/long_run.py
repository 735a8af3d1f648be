"""`desim long-run`."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.options import run_of, with_confidence, with_indicator, with_json, with_overrides, with_seed
from desim_warehouse.cli.tables import sheet, show

if TYPE_CHECKING:
    from desim_warehouse.run import Run
    from desim_warehouse.study.statistics import OneRun


@click.command("long-run")
@click.argument("source", metavar="MODEL|RUN_DIR")
@with_overrides
@with_indicator
@with_confidence
@with_seed
@with_json()
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
        "worth": found.worth,
        "note": found.note,
    }


def _show(run: Run, found: dict[str, OneRun], confidence: float) -> None:
    from desim_warehouse.report.text import numbers, words

    units = run.model.units
    begin = f"a warm-up of {numbers.duration(run.history.begin, units.time)}" if run.history.begin else "the start"
    counted = f"{numbers.duration(run.history.counted, units.time)} counted from {begin} on"
    table = sheet(f"{run.model.name}: one run, {counted}", "indicator", ">value", ">from", ">to", "unit", "note")
    for name, one in found.items():
        scale = words.scale(name, run.model, (one.value,))
        cells = [scale.bare(value) if math.isfinite(value) else "?" for value in (one.value, *one.interval)]
        table.add_row(name, *cells, scale.unit, one.note)
    show(table)
    click.echo(f"from, to: {100 * confidence:g} % interval by batches of the run")
