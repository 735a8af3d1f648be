"""`desim why`."""

from __future__ import annotations

from pathlib import Path

import click

from desim_warehouse.cli.answers import give
from desim_warehouse.cli.completion import AtPath, indicators
from desim_warehouse.cli.options import load_source, with_json
from desim_warehouse.cli.study_options import (
    ExecutionOptions,
    ModelOptions,
    interruptible,
    with_execution,
    with_first_and_cap,
    with_question,
)
from desim_warehouse.cli.warned import warn
from desim_warehouse.study.limits import FIRST


@click.command("why")
@click.argument("source", type=AtPath(), metavar="MODEL|RUN_DIR")
@click.option(
    "--indicator",
    shell_complete=indicators,
    metavar="NAME",
    help="What costs are counted in.  [default: throughput, cycle time or T]",
)
@with_json()
@with_first_and_cap(FIRST, 160)
@with_question
@with_execution
def command(
    source: str,
    indicator: str | None,
    as_json: bool,
    first: int,
    cap: int,
    question: ModelOptions,
    execution: ExecutionOptions,
) -> None:
    """Find what holds a warehouse up, and what that costs: suspects are relieved one by one and simulated.

    First of all it says what robots waited for in one run, each wait followed to its root.

    Suspects come from the account of time of a run: of RUN_DIR (`log: all`), or of MODEL. Example: desim why w.yaml
    """
    from desim_warehouse.report.text import why_words
    from desim_warehouse.run import Run as Done
    from desim_warehouse.study.why import why

    start = load_source(source, question.assignments)
    looked_at = start.model if isinstance(start, Done) else start
    model = None if Path(source).is_dir() else source
    warnings = warn(looked_at, model, question.assignments, as_json=as_json)
    with interruptible(None, execution.kept):
        found = why(start, indicator=indicator, first=first, cap=cap, **question.search(execution))
    give(why_words.answer(found), execution.out, warnings, as_json=as_json)
