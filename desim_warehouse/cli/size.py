"""`desim size`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from desim_warehouse.cli.options import with_overrides, with_seed
from desim_warehouse.cli.study_options import (
    interruptible,
    number,
    read_assignments,
    read_vary,
    show,
    with_confidence,
    with_execution,
)

if TYPE_CHECKING:
    from desim_warehouse.study.statistics import Sizing


@click.command("size")
@click.argument("model")
@click.option("--key", default="fleet.size", show_default=True, help="The key whose smallest value is sought.")
@click.option("--range", "values", required=True, metavar="VALUES", help="Its values upwards, such as 1..60.")
@click.option("--target", required=True, help="What is to be met, such as 'throughput_per_hour >= 220'.")
@click.option(
    "--search",
    type=click.Choice(["bisection", "scan"]),
    default="bisection",
    show_default=True,
    help="scan: every value from the first on, where more need not be better.",
)
@click.option("--first", default=10, show_default=True, help="Replications at the first look at a value.")
@click.option("--cap", default=320, show_default=True, help="Most replications of a value.")
@with_overrides
@with_confidence
@with_seed
@with_execution
def command(
    model: str,
    key: str,
    values: str,
    target: str,
    search: str,
    first: int,
    cap: int,
    assignments: tuple[str, ...],
    confidence: float,
    seed: int,
    workers: str,
    cluster: str | None,
    timeout: float | None,
    out: str | None,
    quiet: bool,
) -> None:
    """Find the smallest value of a key with which MODEL meets a target.

    Example: desim size MODEL --key fleet.size --range 1..60 --target "throughput_per_hour >= 220"
    """
    from desim_warehouse.study.procedures import size
    from desim_warehouse.study.study import Study

    study = Study(
        model,
        read_vary((f"{key}={values}",)),
        seed=seed,
        changes=read_assignments(assignments),
        confidence=confidence,
        timeout=timeout,
        name="size",
    )
    study.plan = study.plan.unreplicated()
    with interruptible(study, out):
        found = size(
            study,
            target,
            first=first,
            cap=cap,
            search=search,
            workers=workers,
            cluster=cluster,
            out=out,
            progress=not quiet,
        )
    _show(key, found)


def _show(key: str, found: Sizing[Any]) -> None:
    from rich.table import Table

    table = Table(title=f"{found.target}: the values looked at", title_justify="left", box=None)
    for name in (key, "mean", "from", "to", "runs", "verdict"):
        table.add_column(name, justify="left" if name == "verdict" else "right")
    for one in sorted(found.decisions, key=lambda decision: decision.value):
        ends = ("exact", "") if one.low is None or one.high is None else (number(one.low), number(one.high))
        table.add_row(str(one.value), number(one.mean), *ends, str(one.n), one.verdict)
    show(table)
    click.echo(f"{key}: {found.note} (confidence {100 * found.confidence:g} %, {found.runs} runs)")
