"""`desim compare`."""

from __future__ import annotations

from typing import Literal

import click

from desim_warehouse.cli.answers import give
from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import with_indicator, with_json
from desim_warehouse.cli.study_options import read_assignments


@click.command("compare")
@click.argument("folder", type=AtPath())
@with_indicator
@click.option(
    "--baseline",
    multiple=True,
    metavar="KEY=VALUE",
    help="Compare each design with the design that has this value, such as fleet.size=3, all else equal; may be "
    "repeated.  [default: the baseline of the study]",
)
@click.option(
    "--method",
    type=click.Choice(["bonferroni", "holm"]),
    default="bonferroni",
    show_default=True,
    help="Correction for multiple comparisons.",
)
@with_json()
def command(
    folder: str,
    indicators: tuple[str, ...],
    baseline: tuple[str, ...],
    method: Literal["bonferroni", "holm"],
    *,
    as_json: bool,
) -> None:
    """Compare the designs of the study in FOLDER with its baseline, under common random numbers."""
    from desim_warehouse.questions import compare_words
    from desim_warehouse.questions.study import Results

    results = Results.load(folder)
    for note in results.notes:
        click.echo(note, err=True)
    base = read_assignments(baseline, "--baseline") or None
    chosen = indicators or results.plan.indicators or results.usual(3)
    comparisons = {name: results.compare(name, base, method) for name in chosen}
    give(compare_words.answer(results, comparisons), None, None, as_json=as_json)
