"""`desim why`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.answers import give
from desim_warehouse.cli.completion import AtPath, indicators
from desim_warehouse.cli.options import load_source, with_json, with_overrides
from desim_warehouse.cli.study_options import interruptible, with_search
from desim_warehouse.cli.warned import warn
from desim_warehouse.study.statistics.limits import RELIEVED

if TYPE_CHECKING:
    from desim_warehouse.study.search import Search


@click.command("why")
@click.argument("source", type=AtPath(), metavar="MODEL|RUN_DIR")
@click.option(
    "--indicator",
    shell_complete=indicators,
    metavar="NAME",
    help="Indicator in which costs are measured.  [default: throughput, cycle time or T]",
)
@with_json()
@with_overrides
@with_search("confidence", "seed", first=RELIEVED[0], cap=RELIEVED[1])
def command(source: str, indicator: str | None, as_json: bool, assignments: tuple[str, ...], search: Search) -> None:
    """Find the bottlenecks of a warehouse, and what each costs: suspects are relieved one by one, and simulated.

    The answer begins with what robots waited for in one run, each wait traced to its root cause. Suspects come from the
    breakdown of robots' time in a new run of MODEL, or in the run stored in RUN_DIR (with `log: all`).
    Example: desim why w.yaml
    """
    from desim_warehouse.questions.run import Run as Done
    from desim_warehouse.questions.why import why

    start = load_source(source, assignments)
    looked_at = start.model if isinstance(start, Done) else start
    model = None if Path(source).is_dir() else source
    warnings = warn(looked_at, model, assignments, as_json=as_json)
    with interruptible(None, search):
        costs = why(start, indicator=indicator, search=search)
    give(costs.answer, search.out, warnings, as_json=as_json)
