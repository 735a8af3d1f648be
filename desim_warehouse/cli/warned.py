"""Print warnings of the check, in a line before the answer of every command that simulates a model."""

from __future__ import annotations

import shlex
from collections import Counter
from typing import TYPE_CHECKING

import click

from desim_warehouse.errors import number_of
from desim_warehouse.findings import Finding

if TYPE_CHECKING:
    from desim_warehouse.model import Model


def warn(
    model: Model, source: str | None = None, assignments: tuple[str, ...] = (), *, as_json: bool = False
) -> list[dict[str, str]]:
    """Print the codes of warnings of `desim check` for a model on standard error, unless `as_json`.

    The line names the `desim check` command for `source` and `assignments`, which prints details, if there is a source.

    Returns:
        The warnings for JSON, each with code and text.
    """
    from desim_warehouse.model import options_of

    warnings = _warnings(model)
    if warnings and not as_json:
        more = "" if source is None else f" ({shlex.join(['desim', 'check', source, *options_of(assignments)])})"
        click.echo(f"{_line(warnings)}{more}", err=True)
    return [{"code": item.code, "text": item.problem} for item in warnings]


def warn_of_target(text: str | None, model: Model) -> None:
    """Print a warning on standard error if no fleet can meet a target."""
    from desim_warehouse.study.target import too_short

    if text is not None and (problem := too_short(text, model)):
        click.echo(f"warning: {problem}", err=True)


def _line(warnings: list[Finding]) -> str:
    codes = Counter(item.code for item in warnings)
    named = ", ".join(code if count == 1 else f"{code} ({count})" for code, count in codes.items())
    return f"{number_of(len(warnings), 'warning')} of the check: {named}"


def _warnings(model: Model) -> list[Finding]:
    """Return the warnings on a model; empty if the model is refused, as its errors are then reported."""
    from desim_warehouse.run.examined import examined

    findings, _ = examined(model)
    if any(item.level == "error" and item.code not in model.accept for item in findings):
        return []
    return [item for item in findings if item.level == "warning"]
