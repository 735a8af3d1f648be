"""An answer as the terminal has it: its sentences, what was tried, and how sure it is."""

from __future__ import annotations

from io import StringIO
from typing import TYPE_CHECKING

from desim_warehouse.errors import number_of
from desim_warehouse.report.text.numbers import number
from desim_warehouse.report.text.sentences import capital
from desim_warehouse.report.text.standing import WORDS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.report.answer import Answer, Option

WIDTH = 100
"""Columns where the output is no terminal."""


def printed(answer: Answer, width: int = WIDTH) -> str:
    """The lines of an answer in so many columns."""
    parts = ["\n".join(answer.answer)]
    for demand in dict.fromkeys(option.demand for option in answer.options):
        shown = [option for option in answer.options if option.demand == demand]
        parts.append(_table(capital(demand), answer.measure, shown, width))
    sure = f"{answer.promise} {number_of(answer.runs, 'run')}.".strip()
    return "\n\n".join([*parts, "\n".join([*answer.notes, sure])])


def _table(title: str, measure: str, options: Sequence[Option], width: int) -> str:
    from rich.console import Console
    from rich.table import Table

    priced = any(option.cost is not None for option in options)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for head, justify in (("option", "left"), (measure, "left"), ("", "left"), ("runs", "right")):
        table.add_column(head, justify=justify)  # type: ignore[arg-type]
    if priced:
        table.add_column("a year", justify="right")
    for one in options:
        cost = [] if not priced else ["" if one.cost is None else number(one.cost)]
        table.add_row(one.full_name, one.text, WORDS[one.standing], number(one.runs), *cost)
    stream = StringIO()
    Console(file=stream, width=width, highlight=False, markup=False).print(table)
    lines = [line.rstrip() for line in stream.getvalue().splitlines()]
    return "\n".join([title, *lines] if title else lines)
