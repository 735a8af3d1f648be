"""`desim orders`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import refuse_files, with_dates, with_force
from desim_warehouse.errors import ModelError, number_of

if TYPE_CHECKING:
    from desim_warehouse.orders.day import OrderDay


def _plain_table(_context: click.Context, _option: click.Parameter, path: str | None) -> str | None:
    """Return the path of a table that models read; raises BadParameter for another ending."""
    from desim_warehouse.model.sections.orders import PARQUET

    if path is not None and Path(path).suffix.lower() not in (endings := (*PARQUET, ".csv")):
        raise click.BadParameter(
            f"{path!r} is no table that models read, expected one that ends in {' or '.join(endings)}"
        )
    return path


@click.command("orders")
@click.argument("file", type=AtPath())
@click.option("--model", required=True, metavar="MODEL", help="Model file with the places that the orders name.")
@click.option(
    "--out",
    metavar="PATH",
    callback=_plain_table,
    help="File to write the orders to, for the model: .parquet or .csv.",
)
@with_force
@click.option(
    "--map",
    "columns",
    multiple=True,
    metavar="OURS=THEIRS",
    help="Heading that FILE uses for a column, such as 'release=Created'; may be repeated.  [default: common headings]",
)
@click.option("--sheet", metavar="NAME", help="Sheet of an Excel file to read.  [default: the first]")
@with_dates
@click.option(
    "--quantity",
    type=click.Choice(["tasks", "pieces"]),
    help="What the quantities in FILE count.  [default: pieces on one load]",
)
@click.option(
    "--pieces-per-load",
    type=click.IntRange(min=1),
    metavar="N",
    help="Largest number of pieces on one load.  [default: no limit]",
)
@click.option("--skip-bad", is_flag=True, help="Skip rows with problems, and list them in a file beside --out.")
def command(
    file: str, model: str, out: str | None, force: bool, columns: tuple[str, ...], skip_bad: bool, **settings: Any
) -> None:
    """Read one day of orders exported from a WMS or ERP, and check it against the places of MODEL.

    FILE is CSV, Excel or Parquet. The command summarises the orders, states its assumptions, and lists problems by
    kind. Example: desim orders day.csv --model w.yaml --out orders.parquet
    """
    from desim_warehouse.orders.day import files, order_day, write

    day = order_day(file, model, columns=dict(map(_column, columns)), **settings)
    if day.problems and not skip_bad:
        left = f"--skip-bad leaves out {number_of(len(day.skipped), 'row')}; row 1 is the first below the header"
        raise ModelError([*day.problems, f"{file}: {left}"])
    if not day.lines:
        raise ModelError([*day.problems, f"{file}: no rows, expected at least one order"])
    for problem in day.problems:
        click.echo(f"left out: {problem}", err=True)
    _show(file, day)
    if out is not None:
        _, *beside = names = files(day, Path(out))
        refuse_files(names, force=force)
        write(day, Path(out))
        click.echo(f"{out}: {number_of(len(day.lines), 'line')}, for arrivals: {{orders: {{file: {out}}}}}")
        for path in beside:
            click.echo(f"{path}: {number_of(len(day.skipped), 'row')} left out")


def _column(text: str) -> tuple[str, str]:
    ours, equals, theirs = text.partition("=")
    if not equals:
        raise click.BadParameter(f"{text!r}, expected OURS=THEIRS such as 'release=Created'", param_hint="--map")
    return ours.strip(), theirs.strip()


def _show(file: str, day: OrderDay) -> None:
    first, last = (day.time_of(line.release) for line in (day.lines[0], day.lines[-1]))
    date = "" if day.midnight is None else f", from {day.midnight:%Y-%m-%d} on"
    parts = ((day.orders, "order"), (len(day.lines), "line"), (day.pieces, "piece"), (day.trips, "trip"))
    begin, trips = day.busiest
    busiest = f"busiest hour: {_clock(begin)} to {_clock(begin + 3600)}, {number_of(trips, 'trip')}"
    times = f"{_clock(first)} to {_clock(last)}{date}, {number_of(round(day.a_day), 'order')} a day, {busiest}"
    click.echo(f"{file}: {', '.join(number_of(*part) for part in parts)}, {times}")
    if first - day.how.clock >= 2 * 3600:
        click.echo(f"the run starts at {_clock(day.how.clock)}: nobody works until then; run.start says when it does")
    if day.unread:
        click.echo(f"not read: {', '.join(day.unread)}")
    for assumption in day.assumed:
        click.echo(f"assumed: {assumption}")


def _clock(seconds: float) -> str:
    days, rest = divmod(int(seconds), 86400)
    return f"{rest // 3600:02}:{rest % 3600 // 60:02}{f' (day {days + 1})' * (days > 0)}"
