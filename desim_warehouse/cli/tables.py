"""Tables in the output of subcommands."""

from __future__ import annotations

from collections.abc import Iterable
from re import sub
from textwrap import wrap
from typing import TYPE_CHECKING

import click

from desim_warehouse._version import simulated_with
from desim_warehouse.answer.numbers import NONE, Scale
from desim_warehouse.errors import StudyError, number_of

if TYPE_CHECKING:
    from rich.table import Table

    from desim_warehouse.plants import Remark
    from desim_warehouse.questions.study import Results
    from desim_warehouse.study.statistics.intervals import QuantileEstimate


NONE_MEETS = 3
"""Exit status if no option was shown to meet the target."""
_HEAD = 14
"""Longest line in the head of a column, in characters; longer heads take several lines."""
_FITS = 100
"""Width of a table with sentences if the output is not a terminal, in characters."""
_NAMED = 6
"""Largest number of names in a row of remarks."""


def _factors(results: Results) -> list[str]:
    """Return the column heads of the factors, with their units."""
    from desim_warehouse.answer import words

    return [words.factor_head(factor, results.base.units) for factor in results.factors]


def show_quantiles(results: Results, share: float) -> None:
    """Print a row for each design: its factors, and the quantile over replications of each indicator with its interval.

    `share`: the share of runs below the quantile.
    """
    from desim_warehouse.answer import words
    from desim_warehouse.questions import sentences
    from desim_warehouse.study.statistics.intervals import replications_for_quantile
    from desim_warehouse.values.labels import readable

    quantiles = {
        name: results.quantiles(name, share) for name in results.chosen(results.plan.indicators or results.usual(4))
    }
    scales = {
        name: words.scale(name, results.base, [estimate.value for estimate in of_name.values() if estimate is not None])
        for name, of_name in quantiles.items()
    }
    percent, sure = f"{100 * share:g} %", results.plan.confidence
    title = _title(results, f"{percent} quantiles over runs, {100 * sure:g} % intervals")
    table = sheet(
        title, *_factors(results), *(f">{words.head(name, scale)}" for name, scale in scales.items()), ">runs"
    )
    for point in results.points:
        cells = (_quantile_in_words(quantiles[name][point.number], scale) for name, scale in scales.items())
        table.add_row(*map(readable, point.labels.values()), *cells, str(len(results.by_point[point.number])))
    for line in sentences.wrong(results, lasting=True):
        click.echo(line)
    show(table)
    if any(
        estimate is not None and estimate.high is None and not estimate.deterministic
        for by in quantiles.values()
        for estimate in by.values()
    ):
        click.echo(f"?: unknown; it takes {replications_for_quantile(share, sure)} runs for both ends")
    show_failures(results)


def _quantile_in_words(estimate: QuantileEstimate | None, scale: Scale) -> str:
    if estimate is None:
        return NONE
    if estimate.deterministic:
        return scale.bare(estimate.value)
    low, high = ("?" if end is None else scale.bare(end) for end in (estimate.low, estimate.high))
    return f"{scale.bare(estimate.value)} ({low} to {high})"


def _title(results: Results, shown: str) -> str:
    return ", ".join(filter(None, (f"{results.plan.name}: {shown}", simulated_with(results.version))))


def show_failures(results: Results) -> None:
    """Print the first five errors of runs, each once with its number of runs; raise StudyError if every run failed.

    Errors that differ only in numbers are one error.
    """
    failures: dict[str, list[str]] = {}
    for row in results.rows:
        if (error := row.outcome.error) is not None:
            failures.setdefault(sub(r"\d+", "", error), []).append(error)
    for errors in list(failures.values())[:5]:
        first = ", the first" * (len(set(errors)) > 1)
        click.echo(f"{number_of(len(errors), 'run')} failed{first}: {errors[0]}", err=True)
    if failures and sum(map(len, failures.values())) == len(results.rows):
        raise StudyError("no run was finished")


def sheet(title: str | None, *columns: str, pad_edge: bool = True) -> Table:
    """Make a table without lines; a column whose name begins with > is aligned to the right."""
    from rich.table import Table

    made = Table(title=title, title_justify="left", box=None, pad_edge=pad_edge)
    for name in columns:
        head = "\n".join(wrap(name.removeprefix(">"), _HEAD, break_long_words=False))
        made.add_column(head, justify="right" if name.startswith(">") else "left")
    return made


def show(table: Table, *, err: bool = False, markup: bool = True, fits: bool = False) -> None:
    """Print a table; if the output is not a terminal, 200 characters wide, or 100 if it has sentences (`fits`).

    Without `markup`, brackets are text.
    """
    from rich.console import Console

    console = Console(stderr=err, highlight=False, markup=markup)
    if not console.is_terminal:
        console = Console(stderr=err, highlight=False, markup=markup, width=_FITS if fits else 200)
    if table.title:  # printed before the table, which would wrap a title wider than itself
        console.print(table.title, style="table.title", soft_wrap=True)
        table.title = None
    console.print(table)


def show_remarks(remarks: Iterable[Remark], *, err: bool = False) -> None:
    """Print the remarks on the conversion of a layout, a row for each."""
    from desim_warehouse.model.messages import printable

    table = sheet(None, "", "what", "why, and which", pad_edge=False)
    for remark in remarks:
        kind = remark.kind if remark.what == "assumed" else number_of(len(remark.names), remark.kind)
        why = ": ".join(filter(None, (remark.why, remark.which(_NAMED))))
        table.add_row(*map(printable, (remark.what, kind, why)))
    show(table, err=err, markup=False, fits=True)
