"""`desim study`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from desim_warehouse.cli.options import with_overrides
from desim_warehouse.cli.study_options import interruptible, read_assignments, show_summary, with_execution


@click.command("study")
@click.argument("study")
@with_overrides
@with_execution
def command(
    study: str,
    assignments: tuple[str, ...],
    workers: str,
    cluster: str | None,
    timeout: float | None,
    out: str | None,
    quiet: bool,
) -> None:
    """Run STUDY, a study file such as studies/paper.yaml, or go on with that of a study folder.

    Runs that are in the folder already are not done again. DIR/results.parquet has a row for each run.
    """
    from desim_warehouse.study.record import read_record
    from desim_warehouse.study.study import Study

    if Path(study).is_dir():
        whole = Study.of(read_record(Path(study)))
        out = out or study
    else:
        whole = Study.read(study, read_assignments(assignments))
    if timeout is not None:
        whole.plan = replace(whole.plan, timeout=timeout)
    with interruptible(whole, out):
        whole.run(workers=workers, cluster=cluster, out=out, progress=not quiet)
    show_summary(whole)
