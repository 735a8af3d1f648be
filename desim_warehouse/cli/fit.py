"""`desim fit`."""

from __future__ import annotations

from pathlib import Path

import click

from desim_warehouse.cli.answers import keep
from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.tables import sheet, show
from desim_warehouse.folders import ANSWER, refuse_theirs
from desim_warehouse.values.units import SECONDS


@click.command("fit")
@click.argument("file", type=AtPath())
@click.option("--column", required=True, help="Column with the times.")
@click.option("--unit", type=click.Choice([*SECONDS]), default="s", show_default=True, help="Unit of the times.")
@click.option("--out", metavar="DIR", help="Folder to write the figure to, as fit.png and fit.svg.")
def command(file: str, column: str, unit: str, out: str | None) -> None:
    """Fit distributions to the measured times in a column of FILE (CSV), and propose one.

    Example: desim fit picks.csv --column load_s --out out/fit
    """
    from desim_warehouse.questions import input_words
    from desim_warehouse.study.fit import fit, read_times

    proposal = fit(read_times(Path(file), column))
    measured, verdict = input_words.fitted(proposal, unit)
    click.echo(measured)
    table = sheet(None, "distribution", ">AIC")
    for row in input_words.candidates(proposal, unit):
        table.add_row(*row)
    show(table)
    click.echo(f"{verdict}\n{input_words.proposed(proposal, file, column, unit)}")
    if out is not None:
        from desim_warehouse.plot import fitted
        from desim_warehouse.plot.style import save

        refuse_theirs(Path(out), (ANSWER, "fit.png", "fit.svg"))
        save(fitted(proposal, unit=unit).get_figure(root=True), Path(out), "fit")
        keep(input_words.fit(proposal, file, column, unit), out)
        click.echo(f"written to {out}")
