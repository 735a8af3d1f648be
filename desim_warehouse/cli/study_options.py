"""What the subcommands about studies share: options, reading what is varied, showing tables."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from desim_warehouse.study.study import Study

F = TypeVar("F", bound=Callable[..., Any])

with_confidence = click.option(
    "--confidence", type=float, default=0.95, show_default=True, help="Confidence of intervals and verdicts."
)
with_vary = click.option(
    "--vary",
    multiple=True,
    metavar="KEY=VALUES",
    help="What to vary: fleet.size=1..12, battery.threshold=2,3.5,5, or policies.charging=threshold,{name: ...}; "
    "may be repeated: all combinations.",
)
with_indicator = click.option(
    "--indicator", "indicators", multiple=True, metavar="NAME", help="What to look at; may be repeated."
)


def with_execution(function: F) -> F:
    """Add `--workers`, `--cluster`, `--timeout`, `--out` and `--quiet`."""
    options = [
        click.option(
            "--workers",
            default="1",
            show_default=True,
            metavar="N|auto",
            help="Processes on this machine; auto: one for each processor.",
        ),
        click.option("--cluster", metavar="ADDRESS", help="A Dask scheduler such as tcp://10.0.0.1:8786, or local."),
        click.option("--timeout", type=float, metavar="SECONDS", help="Time that a run may take."),
        click.option("--out", metavar="DIR", help="Study folder; runs that are there are used again."),
        click.option("--quiet", is_flag=True, help="Do not show how far it is."),
    ]
    for option in reversed(options):
        function = option(function)
    return function


def read_assignments(assignments: tuple[str, ...]) -> dict[str, Any]:
    """The changes of `--set`."""
    from desim_warehouse.model import parse_assignment

    return dict(parse_assignment(text) for text in assignments)


def read_vary(vary: tuple[str, ...]) -> dict[str, Any]:
    """The factors of `--vary`; values are YAML with commas between them, or one range or section."""
    from desim_warehouse.errors import ModelError
    from desim_warehouse.model.parse import read_yaml

    factors: dict[str, Any] = {}
    problems = []
    for text in vary:
        key, equals, values = text.partition("=")
        if not equals or not values.strip() or not key.strip():
            problems.append(f"--vary {text}: nothing to vary, expected KEY=VALUES such as fleet.size=1..12")
            continue
        if key.strip() in factors:
            problems.append(f"--vary {text}: {key.strip()} given twice, expected all its values once")
            continue
        listed = read_yaml(f"[{values}]", f"--vary {key}")
        problems += [f"--vary {key}: {problem.text}" for problem in listed.problems]
        data = listed.data
        section = len(data) == 1 and isinstance(data[0], Mapping) and "name" not in data[0]
        factors[key.strip()] = data[0] if section else data
    if problems:
        raise ModelError(problems)
    return factors


@contextmanager
def interruptible(study: Study, out: str | None) -> Iterator[None]:
    """Ctrl-C ends with a message about what is kept, and exit status 130."""
    try:
        yield
    except KeyboardInterrupt:
        kept = (
            f"{len(study.rows)} finished runs are kept in {out}; the same command goes on"
            if out
            else ("nothing is kept without --out DIR")
        )
        click.echo(f"stopped: {kept}", err=True)
        sys.exit(130)


def show_summary(study: Study, indicators: tuple[str, ...] = ()) -> None:
    """A line for each design: its factors, and mean ± half-width of the indicators."""
    from rich.table import Table

    from desim_warehouse.study.summary import by_point, estimates, shown_indicators

    chosen = shown_indicators(study, indicators or study.plan.indicators or _FEW)
    found = {name: estimates(study, name) for name in chosen}
    runs = by_point(study)
    table = Table(title=_title(study), title_justify="left", box=None)
    for factor in study.plan.factors:
        table.add_column(factor.key)
    for name in chosen:
        table.add_column(name, justify="right")
    table.add_column("runs", justify="right")
    for point in study.points:
        rows = runs[point.number]
        failed = sum(row.outcome.error is not None for row in rows)
        table.add_row(
            *(str(value) for value in point.labels.values()),
            *(said(found[name][point.number]) for name in chosen),
            f"{len(rows)} ({failed} failed)" if failed else str(len(rows)),
        )
    show(table)
    if study.deterministic:
        click.echo("Chance plays no part in these models: every replication is the same, and the means are exact.")
    _show_failures(study)


_FEW = ("T", "S", "C", "throughput_per_hour")


def _title(study: Study) -> str:
    percent = f"{100 * study.plan.confidence:g} %"
    return f"{study.plan.name}: means" + ("" if study.deterministic else f" ± half-width ({percent})")


def said(found: Any) -> str:
    """An estimate in a table."""
    if found is None:
        return "-"
    if found.half_width is None:
        return number(found.mean)
    return f"{number(found.mean)} ± {number(found.half_width)}"


def number(value: float) -> str:
    """Four digits that mean something."""
    if value == int(value) and abs(value) < 1e6:  # noqa: PLR2004 - counts are shown whole
        return f"{value:,.0f}"
    return f"{value:,.1f}" if abs(value) >= 1000 else f"{value:.4g}"  # noqa: PLR2004


def _show_failures(study: Study) -> None:
    failures: dict[str, int] = {}
    for row in study.rows:
        if row.outcome.error is not None:
            failures[row.outcome.error] = failures.get(row.outcome.error, 0) + 1
    for error, count in list(failures.items())[:5]:
        click.echo(f"{count} runs failed: {error}", err=True)


def show(table: Any) -> None:
    """Print a table, as wide as it is where nobody reads along."""
    from rich.console import Console

    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=200)
    console.print(table)
