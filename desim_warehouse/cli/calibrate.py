"""`desim calibrate`."""

from __future__ import annotations

from pathlib import Path

import click

from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import with_dates, with_force, write_files
from desim_warehouse.values.dates import Slashes


@click.command("calibrate")
@click.argument("logs", type=AtPath(), nargs=-1, required=True, metavar="LOG...")
@click.option("--model", required=True, metavar="PLANT", help="Model file of the plant.")
@click.option("--orders", metavar="ORDERS", help="Orders written by desim orders, to be used as the demand unchanged.")
@click.option(
    "--out",
    required=True,
    metavar="FILE",
    help="Calibrated model file to write; the ranges are written to FILE.ranges.yaml.",
)
@with_dates
@with_force
def command(
    logs: tuple[str, ...], model: str, orders: str | None, out: str, dates: Slashes | None, force: bool
) -> None:
    """Estimate the parameters of PLANT from one or more LOGs of its real fleet, each of one day.

    A LOG is a file of VDA 5050 state messages (JSON lines), a file of trips (CSV), or the folder of a run.
    """
    from desim_warehouse.cli.answers import columns, say
    from desim_warehouse.fleet_log.calibrate import calibrate

    calibration = calibrate(model, logs, orders=orders, dates=dates)
    write_files(calibration.files(Path(out)), force=force)
    say(calibration.text(columns()))
    click.echo(f"{out} is written; next: desim validate {out} --against LOG")
