"""`desim fit`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.tables import sheet, show

if TYPE_CHECKING:
    from desim_warehouse.study.fit import Fitted


@click.command("fit")
@click.argument("file")
@click.option("--column", required=True, help="The column with the times.")
@click.option("--unit", default="s", show_default=True, help="What the times are in, for words and figure.")
@click.option("--out", metavar="DIR", help="For the figure: fit.png and fit.svg.")
def command(file: str, column: str, unit: str, out: str | None) -> None:
    """Propose a distribution for the measured times in a column of FILE (CSV).

    Example: desim fit picks.csv --column load_s --out out/fit
    """
    from desim_warehouse.errors import got
    from desim_warehouse.study.fit import fit
    from desim_warehouse.study.fit.times import read_times

    found = fit(read_times(Path(file), column))
    _show(found, unit)
    if found.fits:
        click.echo(f"proposed: {got(found.best.content())}")
    else:
        click.echo(f"proposed, as none of them fits: {{empirical: {{file: {file}, column: {column}}}}}")
    if out is not None:
        from desim_warehouse.report.plot import fitted
        from desim_warehouse.report.plot.style import save

        save(fitted(found, unit=unit).get_figure(root=True), Path(out), "fit")
        click.echo(f"written to {out}")


def _show(found: Fitted, unit: str) -> None:
    times = found.times
    click.echo(
        f"{len(times)} times from {times.min():.4g} to {times.max():.4g} {unit}, mean {times.mean():.4g} {unit}, "
        f"cv {times.std() / times.mean():.4g}" + (f", rounded to {found.step:g} {unit}" if found.step else "")
    )
    table = sheet(None, "distribution", ">AIC")
    for one in found.candidates:
        table.add_row(one.distribution.words(unit), f"{one.aic:,.1f}")
    show(table)
    verdict = "nothing speaks against it" if found.fits else "it does not fit"
    click.echo(
        f"{found.best.kind}: Cramér-von Mises {found.statistic:.3g}, p = {found.p_value:.2g} (Monte Carlo): {verdict}"
    )
