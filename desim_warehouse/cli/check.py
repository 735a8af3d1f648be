"""`desim check`."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import sys
from typing import TYPE_CHECKING, Any

import click

from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import load_model, with_json, with_overrides
from desim_warehouse.cli.terminal import BAD, DOUBTFUL, GOOD, show

if TYPE_CHECKING:
    from desim_warehouse.feasibility.estimate import QuickEstimate
    from desim_warehouse.questions.check import Check


@click.command("check")
@click.argument("model", type=AtPath())
@with_overrides
@click.option(
    "--details", is_flag=True, help="Add the figures behind the estimate: floor, parts of a task, energy, rings."
)
@with_json("verdict, findings, answer, quick estimate")
def command(model: str, assignments: tuple[str, ...], details: bool, as_json: bool) -> None:
    """Check MODEL, both the file and its layout, and make a quick estimate of what it can do.

    Exit status 2: there are errors, with which `desim run` would refuse the model.
    """
    from desim_warehouse.cli.waiting import Waiting
    from desim_warehouse.questions.check import check

    with Waiting("checking"):
        report = check(load_model(model, assignments))
    if as_json:
        click.echo(json.dumps(_content(report)))
    else:
        show(f"{report}\n{report.details}" if details else str(report), _colour)
    sys.exit(2 if report.errors else 0)


def _colour(line: str) -> str:
    """Return the colour of a line: the verdict, which comes first, or a finding; "" for none."""
    if re.match(r"\d+ errors?\b|error: ", line):
        return BAD
    if re.match(r"no errors, |warning: |accepted error: ", line):
        return DOUBTFUL
    return GOOD if line == "no errors" else ""


def _content(report: Check) -> dict[str, Any]:
    from desim_warehouse import __version__

    findings = [
        {
            "code": item.code,
            "level": item.level,
            "accepted": item.level == "error" and item.code in report.accepted,
            "place": item.place,
            "text": item.text,
            "cure": item.cure,
        }
        for item in report.findings
    ]
    return {
        "verdict": report.verdict,
        "refused": bool(report.errors),
        "findings": findings,
        "answer": report.sentences,
        "facts": report.facts,
        "calculation": None if report.calculation is None else _plain(_calculated(report.calculation)),
        "version": __version__,
    }


def _calculated(estimate: QuickEstimate) -> dict[str, Any]:
    knee, limit = estimate.knee
    more = {"capacity": estimate.capacity, "robots_needed": estimate.robots_needed, "knee": knee, "limit": limit}
    return {**dataclasses.asdict(estimate), **more}


def _plain(value: Any) -> Any:
    """Convert a value for JSON: infinite and undefined numbers become null."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
