"""`desim paper`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    import pandas as pd


@click.command("paper")
@click.option("--study", default="studies/paper.yaml", show_default=True, help="Study file with the 30 cells.")
@click.option(
    "--out",
    default="reports/out/paper",
    show_default=True,
    metavar="DIR",
    help="Folder to write the table and the figures to.",
)
def command(study: str, out: str) -> None:
    """Repeat the paper's experiment: T, S and C of 1 to 6 robots and 5 goods groups, beside the published figures.

    Writes paper.csv, paper.parquet and figure_6, figure_7, figure_8 (PNG and SVG).
    """
    from desim_warehouse.report.paper import reproduce

    reproduction = reproduce(study)
    _show(reproduction.table)
    for line in reproduction.verdict():
        click.echo(line)
    click.echo(f"written to {reproduction.save(out)}")


def _show(table: pd.DataFrame) -> None:
    from desim_warehouse.cli.tables import sheet, show

    heads = ("robots", "group", "T steps", "program", "diff", "T s", "paper s")
    names = (*heads, "S", "program", "paper", "diff", "C", "program", "paper", "diff")
    shown = sheet("The paper's experiment, here | program | paper's figure", *(f">{name}" for name in names))
    for row in table.to_dict("records"):
        counts = (f"{row[name + ending]:{sign}d}" for name in "SC" for ending, sign in _COUNTS)
        shown.add_row(
            f"{row['robots']}",
            f"{row['group']}",
            f"{row['T']:,.1f}",
            f"{row['T_steps_program']:,d}",
            f"{100 * row['T_difference']:+.2f} %",
            f"{row['T_seconds']:.1f}",
            f"{row['T_seconds_figure']:.1f}",
            *counts,
        )
    show(shown)


_COUNTS = (("", ""), ("_program", ""), ("_figure", ""), ("_difference", "+"))
