"""What the subcommands show: tables and numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from desim_warehouse.errors import StudyError

if TYPE_CHECKING:
    from desim_warehouse.study.study import Study


def show_summary(study: Study, indicators: tuple[str, ...] = ()) -> None:
    """A line for each design: its factors, and mean ± half-width of the indicators."""
    from rich.table import Table

    from desim_warehouse.study.summary import by_point, estimates, shown_indicators

    chosen = shown_indicators(study, indicators or study.plan.indicators or _FEW)
    found = {name: estimates(study, name) for name in chosen}
    by = by_point(study)
    known = any(one is not None and one.half_width is not None for means in found.values() for one in means.values())
    table = Table(title=_title(study, known), title_justify="left", box=None)
    for factor in study.plan.factors:
        table.add_column(factor.key)
    for name in chosen:
        table.add_column(name, justify="right")
    table.add_column("runs", justify="right")
    for point in study.points:
        rows = by[point.number]
        failed = sum(row.outcome.error is not None for row in rows)
        table.add_row(
            *(str(value) for value in point.labels.values()),
            *(said(found[name][point.number]) for name in chosen),
            f"{len(rows)} ({failed} failed)" if failed else str(len(rows)),
        )
    show(table)
    if not (known or study.deterministic) and study.rows:
        click.echo("One run of a design says little where chance plays a part: more replications give intervals.")
    if study.deterministic:
        click.echo("Chance plays no part in these models: every replication is the same, and the means are exact.")
    _show_failures(study)


_FEW = ("T", "S", "C", "throughput_per_hour")


def _title(study: Study, known: bool) -> str:
    percent = f"{100 * study.plan.confidence:g} %"
    return f"{study.plan.name}: means" + (f" ± half-width ({percent})" if known else "")


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
        click.echo(f"{runs(count)} failed: {error}", err=True)
    if failures and sum(failures.values()) == len(study.rows):
        raise StudyError("no run was finished")


def runs(count: int) -> str:
    """So many runs, in words."""
    return f"{count} run{'s' * (count != 1)}"


def show(table: Any) -> None:
    """Print a table, as wide as it is where nobody reads along."""
    from rich.console import Console

    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=200)
    if table.title:  # not within the table: a title that is wider would be broken
        console.print(table.title, style="table.title", soft_wrap=True)
        table.title = None
    console.print(table)
