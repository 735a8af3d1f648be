"""`desim report`."""

from __future__ import annotations

import click


@click.command("report")
@click.argument("folder", metavar="DIR")
@click.option("-o", "--out", metavar="FILE", help="Default: report.html in DIR; report.pdf with --pdf.")
@click.option("--pdf", is_flag=True, help="Print to PDF with an installed Chromium or Chrome.")
@click.option("--code", is_flag=True, help="Show the notebook's code, too.")
@click.option("--notebook", metavar="FILE", help="Write the executed notebook, too.")
@click.option("--replay", is_flag=True, help="Write a replay of one run beside the page, and link to it.")
def command(folder: str, out: str | None, pdf: bool, code: bool, notebook: str | None, replay: bool) -> None:
    """Write the report of DIR, which plan, what-if, study, size, best or run wrote with --out: one self-contained page.

    Its first page has the question, the answer, one figure, and what a year costs if the model has prices.
    """
    from desim_warehouse.report.notebook import report

    click.echo(report(folder, out, pdf=pdf, code=code, keep=notebook, replay=replay))
