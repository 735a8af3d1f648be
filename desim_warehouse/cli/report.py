"""`desim report`."""

from __future__ import annotations

from pathlib import Path

import click

from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import run_of, with_overrides, with_seed


@click.command("report")
@click.argument("source", type=AtPath(), metavar="MODEL|DIR")
@with_overrides
@with_seed
@click.option("-o", "--out", metavar="FILE", help="Default: report.html in DIR, of a MODEL in the working folder.")
@click.option(
    "--notebook",
    metavar="FILE",
    help="Write a notebook for Jupyter, too: the runs of DIR as a pandas table, not yet run.",
)
@click.option("--replay", is_flag=True, help="Write a replay of one run beside the page, and link to it.")
def command(
    source: str, assignments: tuple[str, ...], seed: int, out: str | None, notebook: str | None, replay: bool
) -> None:
    """Write the report of a run of MODEL, simulated now, or of what a command wrote to DIR with --out.

    That is one self-contained page. Its first page has the question, the answer, one figure, and what a year costs if
    the model has prices. No file of DIR is run as code. Print the page from a browser.
    """
    from desim_warehouse.report.write import report

    if not Path(source).is_file():
        if assignments:
            raise click.UsageError("--set is for models: what a folder holds is simulated already")
        click.echo(report(source, out, notebook=notebook, replay=replay))
        return
    if notebook is not None:
        raise click.UsageError("--notebook needs a DIR, which desim run MODEL --out DIR writes")
    click.echo(report(run_of(source, assignments, seed, log="all"), out, replay=replay))
