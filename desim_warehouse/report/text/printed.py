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
_WORDS = 3
"""Columns of the table that are words, before those that are numbers."""


def printed(answer: Answer, width: int = WIDTH) -> str:
    """The lines of an answer in so many columns."""
    parts = ["\n".join(answer.answer)]
    for demand in dict.fromkeys(option.demand for option in answer.options):
        shown = [option for option in answer.options if option.demand == demand]
        parts.append(_table(capital(demand), answer.measure, shown, width))
    return "\n\n".join([*parts, "\n".join([*answer.notes, how_sure(answer)])])


def how_sure(answer: Answer) -> str:
    """What holds with which confidence, and of how many runs."""
    return f"{answer.promise} {number_of(answer.runs, 'run')}.".strip()


def table(measure: str, options: Sequence[Option]) -> tuple[list[str], list[list[str]]]:
    """The head and the rows of a table of options; with what they cost where that is known of one."""
    priced = any(one.cost is not None for one in options)
    rows = [
        [
            one.full_name,
            one.text,
            WORDS[one.standing],
            number(one.runs),
            *(["" if one.cost is None else number(one.cost)] * priced),
        ]
        for one in options
    ]
    return ["option", measure, "", "runs", *(["a year"] * priced)], rows


def _table(title: str, measure: str, options: Sequence[Option], width: int) -> str:
    from rich.console import Console
    from rich.table import Table

    heads, rows = table(measure, options)
    made = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for place, head in enumerate(heads):
        made.add_column(head, justify="left" if place < _WORDS else "right")
    for row in rows:
        made.add_row(*row)
    stream = StringIO()
    Console(file=stream, width=width, highlight=False, markup=False).print(made)
    lines = [line.rstrip() for line in stream.getvalue().splitlines()]
    return "\n".join([title, *lines] if title else lines)
