"""`desim compare`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.study_options import number, read_assignments, show, show_summary, with_indicator

if TYPE_CHECKING:
    from desim_warehouse.study.study import Study


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
    from desim_warehouse.study.study import Study
    from desim_warehouse.study.summary import shown_indicators

    study = Study.open(folder)
    for note in study.notes:
        click.echo(note, err=True)
    show_summary(study, indicators)
    few = [name for name in ("T", "S", "C") if name in shown_indicators(study)]
    for indicator in indicators or study.plan.indicators or few:
        _show_comparison(study, indicator, read_assignments(baseline), method)


def _show_comparison(study: Study, indicator: str, baseline: dict[str, object], method: str) -> None:
    from rich.table import Table

    found = study.compare(indicator, baseline or None, method)
    table = Table(title=f"\n{indicator}: difference to {found.baseline}", title_justify="left", box=None)
    for name in ("design", "difference", "from", "to", "p", "verdict"):
        table.add_column(name, justify="left" if name in {"design", "verdict"} else "right")
    verdicts = {True: "differs", False: "not shown to differ", None: "cannot be told (one run)"}
    for one in found.differences:
        interval = one.estimate.interval
        ends = ("exact", "") if one.estimate.deterministic else ("-", "-")
        table.add_row(
            str(one.design),
            number(one.estimate.mean),
            *((number(interval[0]), number(interval[1])) if interval else ends),
            "-" if one.p_adjusted is None else f"{one.p_adjusted:.3g}",
            verdicts[one.differs] + (f" ({one.missing} pairs missing)" if one.missing else ""),
        )
    show(table)
    if not all(one.estimate.deterministic for one in found.differences):
        click.echo(found.statement)
