"""`desim compare`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.options import with_indicator
from desim_warehouse.cli.study_options import read_assignments
from desim_warehouse.cli.tables import sheet, show, show_summary

if TYPE_CHECKING:
    from desim_warehouse.study.results import Results
    from desim_warehouse.study.statistics import Comparison


@click.command("compare")
@click.argument("folder")
@with_indicator
@click.option(
    "--baseline",
    multiple=True,
    metavar="KEY=VALUE",
    help="The design to compare with, such as fleet.size=3; may be repeated. Default: the study's.",
)
@click.option("--method", type=click.Choice(["bonferroni", "holm"]), default="bonferroni", show_default=True)
def command(folder: str, indicators: tuple[str, ...], baseline: tuple[str, ...], method: str) -> None:
    """Compare the designs of a study FOLDER with its baseline, under common random numbers."""
    from desim_warehouse.study.results import Results

    results = Results.load(folder)
    for note in results.notes:
        click.echo(note, err=True)
    base = read_assignments(baseline, "--baseline") or None
    chosen = indicators or results.plan.indicators or results.usual(3)
    found = {name: results.compare(name, base, method) for name in chosen}
    show_summary(results, indicators)
    for indicator, comparison in found.items():
        _show_comparison(results, indicator, comparison)


def _show_comparison(results: Results, indicator: str, found: Comparison) -> None:
    from desim_warehouse.report.text import words

    scale = words.scale_of(indicator, results.base, results.estimates(indicator).values())
    columns = ("design", ">difference", ">from", ">to", ">p", "verdict")
    table = sheet(f"\n{words.head(indicator, scale)}: difference to {found.baseline}", *columns)
    for one in found.differences:
        table.add_row(str(one.design), *scale.difference(one))
    show(table)
    if any(one.estimate.interval for one in found.differences):
        click.echo(found.statement)
