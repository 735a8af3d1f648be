"""`desim run`."""

from __future__ import annotations

import json
import math
from contextlib import nullcontext
from pathlib import Path

import click

from desim_warehouse.cli.answers import columns
from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import (
    TimeIn,
    load_model,
    simulated,
    with_indicator,
    with_json,
    with_overrides,
    with_seed,
)
from desim_warehouse.cli.terminal import BAD, show
from desim_warehouse.cli.warned import warn


@click.command("run")
@click.argument("model", type=AtPath())
@with_overrides
@with_seed
@with_json("answer, indicators, verdicts, warnings, seed, version")
@click.option(
    "--timeout",
    type=TimeIn("s"),
    metavar="TIME",
    help="Time limit for the run, in seconds or with a unit, such as 5min.",
)
@with_indicator
@click.option("--out", metavar="DIR", help="Folder to write the model, indicators, log and tables to.")
def command(
    model: str,
    assignments: tuple[str, ...],
    seed: int,
    as_json: bool,
    timeout: float | None,
    indicators: tuple[str, ...],
    out: str | None,
) -> None:
    """Simulate MODEL once; print the result in a few sentences, and the indicators by which it is judged."""
    from desim_warehouse import __version__
    from desim_warehouse.answer.numbers import sentence
    from desim_warehouse.errors import SimulationError
    from desim_warehouse.outcome.indicators import refuse_unknown
    from desim_warehouse.questions.run import words as run_words
    from desim_warehouse.run.folder import prepared
    from desim_warehouse.study.execution.time_limit import TimeLimit, TimeOutError

    loaded = load_model(model, assignments)
    for name in indicators:
        if name != "all":
            refuse_unknown(name, [loaded])
    if out is not None:
        folder = prepared(Path(out))  # before a long run, not after it: the folder may be unusable
        click.get_current_context().with_resource(folder)
    warnings = warn(loaded, model, assignments, as_json=as_json)
    try:
        with nullcontext() if timeout is None else TimeLimit(timeout):
            run = simulated(loaded, seed)
    except TimeOutError:
        raise SimulationError(f"{loaded.name}: not finished after {timeout:g} s (--timeout)") from None
    if out is not None:
        run.save(out)
    if as_json:
        plain = {key: None if math.isnan(value) else value for key, value in run.kpis.items()}
        click.echo(
            json.dumps(
                {
                    **plain,
                    "answer": run_words.sentences(run),
                    "verdicts": [verdict.content() for verdict in run.verdicts],
                    "warnings": warnings,
                    "seed": seed,
                    "version": __version__,
                }
            )
        )
    else:
        bad = {sentence(verdict.text) for verdict in run.verdicts}
        show(run_words.text(run, indicators, columns()), lambda line: BAD if line in bad else "")
