"""`desim what-if`."""

from __future__ import annotations

from typing import Any

import click

from desim_warehouse.cli.options import with_overrides, with_seed
from desim_warehouse.cli.study_options import (
    interruptible,
    read_assignments,
    read_vary,
    show_summary,
    with_confidence,
    with_execution,
    with_indicator,
    with_vary,
)


@click.command("what-if")
@click.argument("model")
@with_vary
@with_overrides
@click.option("--replications", default="1", show_default=True, help="Of each design, or with --until the first.")
@click.option("--until", metavar="NAME", help="Replicate until the mean of this indicator is known well enough:")
@click.option("--half-width", default="5 %", show_default=True, help="... up to this share of the mean ...")
@click.option("--cap", default=200, show_default=True, help="... but not more often than this.")
@click.option("--design", default="grid", show_default=True, help="grid, paired, or such as '{sobol: 64}'.")
@with_indicator
@with_confidence
@with_seed
@with_execution
def command(
    model: str,
    vary: tuple[str, ...],
    assignments: tuple[str, ...],
    replications: str,
    until: str | None,
    half_width: str,
    cap: int,
    design: str,
    indicators: tuple[str, ...],
    confidence: float,
    seed: int,
    workers: str,
    cluster: str | None,
    timeout: float | None,
    out: str | None,
    quiet: bool,
) -> None:
    """What if MODEL were different? Run it with the values to vary, and show the indicators.

    Example: desim what-if models/multibots.yaml --vary fleet.size=1..6 --set 'tasks.goods={random: 20}'
    --replications 20 --workers 2
    """
    from desim_warehouse.model.parse import read_yaml
    from desim_warehouse.study.study import Study

    often: Any = read_yaml(replications, "--replications").data
    if until is not None:
        first = max(2, often) if isinstance(often, int) and often > 1 else 10
        often = {
            "indicator": until,
            "half_width": half_width,
            "confidence": confidence,
            "minimum": first,
            "cap": cap,
        }
    study = Study(
        model,
        read_vary(vary),
        replications=often,
        seed=seed,
        indicators=indicators or None,
        design=read_yaml(design, "--design").data,
        changes=read_assignments(assignments),
        confidence=confidence,
        timeout=timeout,
        name="what-if",
    )
    with interruptible(study, out):
        study.run(workers=workers, cluster=cluster, out=out, progress=not quiet)
    show_summary(study)
