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
@click.option(
    "-o",
    "--out",
    metavar="FILE",
    help="The page to write.  [default: report.html, in DIR or, for a MODEL, in the working folder]",
)
@click.option(
    "--notebook",
    metavar="FILE",
    help="Also write a Jupyter notebook, not yet executed, with the runs of DIR as a pandas table.",
)
@click.option("--replay", is_flag=True, help="Also write a replay of one run beside the page, and link to it.")
def command(
    source: str, assignments: tuple[str, ...], seed: int, out: str | None, notebook: str | None, replay: bool
) -> None:
    """Write a report on a new run of MODEL, or on the run, study or answer that a command wrote to DIR with --out.

    The report is one self-contained HTML page, to be printed from a browser. Its first sheet has the question, the
    answer, one figure and, if the model has prices, the annual cost. No file in DIR is executed as code.
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
