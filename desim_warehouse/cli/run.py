"""`desim run`."""

from __future__ import annotations

import json
import math
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.by_hand import warn
from desim_warehouse.cli.options import TimeIn, load_model, with_json, with_overrides, with_seed
from desim_warehouse.cli.tables import sheet, show

if TYPE_CHECKING:
    from desim_warehouse.model.schema import Units
    from desim_warehouse.run import Run


@click.command("run")
@click.argument("model")
@with_overrides
@with_seed
@with_json("indicators, verdicts, warnings, seed, version")
@click.option("--timeout", type=TimeIn("s"), metavar="TIME", help="Time that it may take, in seconds or such as 5min.")
@click.option("--out", metavar="DIR", help="Write model, indicators, log and tables to a folder.")
def command(
    model: str, assignments: tuple[str, ...], seed: int, as_json: bool, timeout: float | None, out: str | None
) -> None:
    """Simulate MODEL once and show its indicators."""
    from desim_warehouse import __version__
    from desim_warehouse.errors import SimulationError
    from desim_warehouse.run import simulate
    from desim_warehouse.run.folder import prepare
    from desim_warehouse.study.execution.time_limit import TimeLimit, TimeOutError

    loaded = load_model(model, assignments)
    if out is not None:
        prepare(Path(out))  # before a long run, not after it: the folder may be unusable
    warnings = warn(loaded, model, assignments, as_json=as_json)
    try:
        with nullcontext() if timeout is None else TimeLimit(timeout):
            run = simulate(loaded, seed)
    except TimeOutError:
        raise SimulationError(f"{loaded.name}: not finished after {timeout:g} s (--timeout)") from None
    if out is not None:
        run.save(out)
    if as_json:
        plain = {key: None if math.isnan(value) else value for key, value in run.kpis.items()}
        said = [verdict.content() for verdict in run.verdicts]
        click.echo(json.dumps({**plain, "verdicts": said, "warnings": warnings, "seed": seed, "version": __version__}))
    else:
        _show(run)


def _show(run: Run) -> None:
    from desim_warehouse.report.text import words

    for verdict in run.verdicts:
        click.echo(verdict.text)
    robots = f"{run.model.fleet.size} robot{'s' * (run.model.fleet.size != 1)}"
    columns = ("indicator", ">value", "unit", "meaning")
    table = sheet(f"{run.model.name}: {robots}, seed {run.seed}", *columns, pad_edge=False)
    for key, value in run.kpis.items():
        shown, unit = with_unit(words.indicator_kind(key), value, run.model.units)
        meaning = words.indicator_name(key).removeprefix("Fleet ")
        table.add_row(key, shown, unit, f"{meaning[:1].upper()}{meaning[1:]}")
    show(table)


def with_unit(kind: str, value: float, units: Units) -> tuple[str, str]:
    """A value and its unit for planners: shares in percent, and times in other units also in seconds."""
    from desim_warehouse.report.text import words
    from desim_warehouse.report.text.printed import number

    if math.isnan(value):
        return "-", ""
    if kind.startswith("share"):
        return f"{100 * value:.1f}", {
            "share of tasks": "% of tasks",
            "share of load units": "% of loads",
            "share of orders": "% of orders",
            "share of capacity": "% full",
        }.get(kind, "% of time")
    if kind == "capacity per hour":
        return f"{100 * value:.1f}", "% of capacity/h"
    if kind == "time" and units.time != "s":
        return number(value), f"{units.time} ({number(value * units.seconds)} s)"
    named = {"energy": "energy units", "weighted": "weighted", "tasks per hour": "tasks/h", "tasks": ""}
    return number(value), named.get(kind, words.unit(kind, units))
