"""`desim report`."""

from __future__ import annotations

import click


@click.command("report")
@click.argument("folder", metavar="DIR")
@click.option("-o", "--out", metavar="FILE", help="Default: report.html in DIR.")
@click.option(
    "--notebook", metavar="FILE", help="Write its notebook for Jupyter, too: with the path of DIR, not yet run."
)
@click.option("--replay", is_flag=True, help="Write a replay of one run beside the page, and link to it.")
def command(folder: str, out: str | None, notebook: str | None, replay: bool) -> None:
    """Write the report of DIR, which plan, what-if, study, size, best or run wrote with --out: one self-contained page.

    Its first page has the question, the answer, one figure, and what a year costs if the model has prices. No file of
    DIR is run as code. Print the page from a browser.
    """
    from desim_warehouse.report.write import report

    click.echo(report(folder, out, notebook=notebook, replay=replay))
