"""`desim study`."""

from __future__ import annotations

import click

from desim_warehouse.cli.options import with_overrides
from desim_warehouse.cli.study_options import (
    ExecutionOptions,
    interruptible,
    refuse_page,
    study_plan,
    with_execution,
    with_page,
    write_page,
)
from desim_warehouse.cli.tables import show_summary


@click.command("study")
@click.argument("study")
@with_overrides
@with_page
@with_execution
def command(study: str, assignments: tuple[str, ...], page: str | None, execution: ExecutionOptions) -> None:
    """Run STUDY, a study file such as studies/paper.yaml, or resume the study of a folder.

    Runs that are already in the folder are not repeated. DIR/results.parquet has a row for each run.
    """
    from desim_warehouse.study.study import Study

    whole = Study.of(study_plan(study, assignments, timeout=execution.timeout))
    execution = execution.at_home(study)
    refuse_page(page, whole.plan)
    with interruptible(whole, execution.out):
        whole.run(**execution.where())
    show_summary(whole.results)
    write_page(page, whole.results)
