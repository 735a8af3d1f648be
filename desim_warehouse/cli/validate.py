"""`desim validate`."""

from __future__ import annotations

import click

from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import load_model, with_dates, with_json, with_overrides
from desim_warehouse.values.dates import Slashes


@click.command("validate")
@click.argument("model", type=AtPath())
@click.option(
    "--against", "logs", multiple=True, required=True, metavar="LOG", help="Log of a real day; may be repeated."
)
@click.option(
    "--orders",
    multiple=True,
    metavar="ORDERS",
    help="File with the orders of a real day; repeat it for each LOG, in the same order.",
)
@click.option(
    "--runs",
    type=click.IntRange(39),
    default=40,
    show_default=True,
    help="Number of days to simulate for each real day.",
)
@click.option(
    "--page",
    metavar="FILE",
    help="Write a page with the verdict, the real day among the simulated ones, and the lanes.",
)
@with_dates
@with_overrides
@with_json("verdict, p, bound, and for each measure the real and simulated means and their distance")
def command(
    model: str,
    logs: tuple[str, ...],
    orders: tuple[str, ...],
    runs: int,
    page: str | None,
    dates: Slashes | None,
    assignments: tuple[str, ...],
    as_json: bool,
) -> None:
    """Test MODEL against logs of real days, whose measures are ranked jointly among the measures of simulated days.

    A LOG is a file of VDA 5050 state messages (JSON lines), a file of trips (CSV), or the folder of a run.
    """
    import json

    from desim_warehouse.cli.answers import columns, say, typed
    from desim_warehouse.fleet_log.validate import validate

    validation = validate(load_model(model, assignments), logs, orders=orders, runs=runs, dates=dates)
    if page is not None:
        from desim_warehouse.look.web import WebPage
        from desim_warehouse.report import validation_page

        WebPage(page, validation_page.page(validation, typed())).save(page)
    if as_json:
        keys = ("real", "simulated", "off")
        measures = {row.name: {key: getattr(row, key) for key in keys} for row in validation.rows()}
        ranks = validation.measures
        verdict = {
            "refuted": validation.refuted,
            "p": ranks.p_value,
            "bound": ranks.bound,
            "outside": validation.outside,
        }
        click.echo(json.dumps({**verdict, "measures": measures}))
        return
    say(validation.text(columns()))
    if page is not None:
        click.echo(f"{page}: open it in a browser")
