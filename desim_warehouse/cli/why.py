"""`desim why`."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from desim_warehouse.cli.by_hand import warn
from desim_warehouse.cli.options import load_source, with_json
from desim_warehouse.cli.study_options import (
    ExecutionOptions,
    ModelOptions,
    interruptible,
    with_execution,
    with_first_and_cap,
    with_question,
)
from desim_warehouse.errors import number_of
from desim_warehouse.run.folder import STUDY, WHY, write_whole

if TYPE_CHECKING:
    from desim_warehouse.model import Model
    from desim_warehouse.study.statistics import Gain
    from desim_warehouse.study.why import Why


_PASTED = 4000
"""Letters of a line that terminals take when it is pasted."""


@click.command("why")
@click.argument("source", metavar="MODEL|RUN_DIR")
@click.option("--indicator", metavar="NAME", help="What costs are counted in.  [default: throughput, cycle time or T]")
@with_json()
@with_first_and_cap(160)
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
    model = source if not Path(source).is_dir() else "MODEL"
    warnings = warn(looked_at, None if model == "MODEL" else model, question.assignments, as_json=as_json)
    with interruptible(None, execution.kept):
        found = why(
            start,
            indicator=indicator,
            first=first,
            cap=cap,
            **question.search(execution),
        )
    said = why_words.sentence(found, looked_at.units)
    lines = _commands(found, model, question)
    content = _content(found, said, lines)
    if execution.out is not None and Path(execution.out, STUDY).is_file():
        write_whole(Path(execution.out, WHY), json.dumps(content, indent=1) + "\n")
    if as_json:
        click.echo(json.dumps({**content, "warnings": warnings}))
        return
    of_one_run = why_words.lost(found, looked_at), why_words.batched(found)
    for line in (*of_one_run, *(verdict.text for verdict in found.verdicts), said):
        if line:
            click.echo(line)
    if found.found:
        _show(found, lines, looked_at)


def _commands(found: Why, model: str, question: ModelOptions) -> list[str]:
    """The line that simulates each relief again."""
    from desim_warehouse.report.text.fleet_words import command_line

    return [
        command_line(model, question.assignments, suspect.overrides, gain.n, (found.indicator,), question.seed or 0)
        for suspect, gain in found.found
    ]


def _show(found: Why, lines: list[str], model: Model) -> None:
    from desim_warehouse.cli.tables import sheet, show
    from desim_warehouse.report.text import words
    from desim_warehouse.report.text.numbers import PERCENT
    from desim_warehouse.report.text.why_words import dose

    columns = ("relief", ">dose", ">waited", ">gain", ">from", ">to", ">per 10 %", ">runs", "")
    scale = words.scale(found.indicator, model, [gain.mean for _, gain in found.found])
    table = sheet(f"what a relief gains in {words.head(found.indicator, scale).lower()}", *columns)
    for suspect, gain in found.found:
        waited = "" if suspect.waited is None else PERCENT.value(suspect.waited)
        bounds = ("", "") if math.isnan(gain.low) else (scale.bare(gain.low), scale.bare(gain.high))
        per = "" if suspect.dose is None or math.isnan(gain.mean) else scale.bare(suspect.scale * gain.mean)
        mean = "" if math.isnan(gain.mean) else scale.bare(gain.mean)
        table.add_row(suspect.relief, dose(suspect), waited, mean, *bounds, per, str(gain.n), _standing(found, gain))
    show(table)
    percent = 100 * found.gains.confidence
    click.echo(f"waited: part of the robots' time, in one run; all intervals hold at once with {percent:g} %")
    for line in found.left_out:
        click.echo(f"not tried: {line}")
    click.echo("each relief again:")
    for (suspect, _), line in zip(found.found, lines, strict=True):
        long = f"{suspect.relief}: {len(suspect.overrides)} keys, more than a terminal takes at once; --json has them"
        click.echo(f"  {line if len(line) <= _PASTED else long}")


def _standing(found: Why, gain: Gain) -> str:
    """What is to be said of a relief that is not in the contest."""
    from desim_warehouse.report.text.why_words import fails

    if gain.change in found.failures:
        return fails(found.failures[gain.change])
    if gain.failed:
        return f"no value in {gain.failed} of {number_of(gain.n, 'run')}"
    if gain.same:
        return f"no difference in {number_of(gain.n, 'run')}"
    return "less work: not in the contest" if gain.scale is None else ""


def _content(found: Why, said: str, lines: list[str]) -> dict[str, Any]:
    return {
        "answer": said,
        "indicator": found.indicator,
        "clear": found.is_clear,
        "confidence": found.gains.confidence,
        "base": _finite(found.gains.base),
        "held_up": found.is_held_up,
        "lost_time": [{"root": root.cause, "at": root.at, "share": share} for root, share in found.lost.items()],
        "waiting_for_batch": found.batched,
        "failed": found.gains.failed,
        "left_out": list(found.left_out),
        "verdicts": [verdict.content() for verdict in found.verdicts],
        "runs": found.gains.runs,
        "reliefs": [
            {
                "name": suspect.name,
                "relief": suspect.relief,
                "set": dict(suspect.overrides),
                "waited": suspect.waited,
                "dose": suspect.dose,
                "gain": _finite(gain.mean),
                "low": _finite(gain.low),
                "high": _finite(gain.high),
                "per_10_percent": None if suspect.dose is None else _finite(suspect.scale * gain.mean),
                "runs": gain.n,
                "failed": gain.failed,
                "competes": gain.competes,
                "command": line,
            }
            for (suspect, gain), line in zip(found.found, lines, strict=True)
        ],
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
