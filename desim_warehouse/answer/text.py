"""An answer as text: its sentences, tables within the width of the terminal, and its confidence.

For the terminal, and for `print` in Python.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from io import StringIO

from desim_warehouse.answer.numbers import capital, number, p_value
from desim_warehouse.answer.parts import AnswerData, Option
from desim_warehouse.answer.standing import DELIVERED, WORDS
from desim_warehouse.errors import number_of

WIDTH = 100
"""Width of output that is not a terminal, in characters."""
MOST = 2000
"""Longest text of an answer in bytes: about a screen, or a cell of a notebook."""
FEWEST = 3
"""Fewest options that are shown, however long the text."""
_SHOWN = {"first", "met", "best", "differs"}
_OUT = {"worse", "same", "alike", "apart", "untried", "overloaded", "drained", "fails"}
_NAME = 28
"""Width that the column of option names keeps, in characters, if the names are that long."""
_GAP = 2
_NUMBERS = {"p", "runs", "a year", "effect", "value", "Real", "Simulated", "Band"}
"""Heads of right-aligned columns."""


def printed(answer: AnswerData, width: int = WIDTH) -> str:
    """Return the text of an answer, `width` characters wide, and at most `MOST` bytes long if possible.

    If it is too long, the least important options are left out, then other tables, with a line on where to find them.
    """
    text = _printed(answer, answer.options, width)
    if len(text.encode()) <= MOST or not answer.options:
        return text
    ranked = sorted(answer.options, key=partial(_rank, " ".join(answer.answer)))
    for short in (False, True):
        fewest, most = min(FEWEST, len(ranked)), len(ranked)
        while fewest < most:  # the largest number that fits
            many = (fewest + most + 1) // 2
            if len(_printed(answer, ranked[:many], width, short=short).encode()) <= MOST:
                fewest = many
            else:
                most = many - 1
        text = _printed(answer, ranked[:fewest], width, short=short)
        if len(text.encode()) <= MOST:
            break
    return text


def _printed(answer: AnswerData, options: Sequence[Option], width: int, *, short: bool = False) -> str:
    """Return the text of an answer with some of its options; `short`: with one table for each group, and no others."""
    parts = ["\n".join(answer.answer)]
    printed = [part for part in answer.tables if part.printed and not short]
    parts += [printed_table(part.title, part.head, part.rows, width) for part in printed]
    kept = set(map(id, options))
    for group, all_of_it in answer.groups().items():
        if some := [option for option in all_of_it if id(option) in kept]:
            parts += list(_tables(capital(group), answer.measures, some, width))[: 1 if short else None]
    left = len(answer.options) - len(options)
    more = [number_of(left, "more option")] if left else []
    more += ["more tables"] if short else []
    are = "is" if left == 1 and not short else "are"
    lines = [f"{capital(' and '.join(more))} {are} on the page and in the table (.table; --json)."] if more else []
    return "\n\n".join([*parts, "\n".join([*lines, *answer.notes, how_sure(answer)])])


def printed_rows(title: str, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return the text of a table, at most `MOST` bytes long, with a line on how many rows are left out."""
    text, many = printed_table(title, heads, rows), len(rows)
    while len(text.encode()) > MOST and many > 1:
        many = min(many - 1, int(many * MOST / len(text.encode())))
        table = printed_table(title, heads, rows[:many])
        rest = len(rows) - many
        text = f"{table}\n{number_of(rest, 'more row')} {'is' if rest == 1 else 'are'} in the table (.table)."
    return text


def _rank(sentences: str, option: Option) -> int:
    """Return the rank of an option: 0 for options that sentences name or that stand out, 2 for the least important."""
    if option.name in sentences or option.standing in _SHOWN:
        return 0
    return 2 if option.standing in _OUT else 1


def how_sure(answer: AnswerData) -> str:
    """Return the promise of an answer, with its confidence, and the number of runs."""
    runs = f"{number_of(answer.runs, 'run')}." if answer.runs else ""
    return f"{answer.promise} {runs}".strip()


def table(measures: Mapping[str, str], options: Sequence[Option]) -> tuple[list[str], list[list[str]]]:
    """Return the head and rows of a table of options: name, measures, verdict, worst day, p-value, runs and cost.

    Text instead of a number is in the first column of measures, or in one of its own if it would hide a number there.
    Columns without values are left out.
    """
    with_numbers = {reading.of for option in options for reading in option.numbers}
    shown = [measure for measure in measures if measure in with_numbers] or list(measures)[:1]
    apart = any(option.instead and _hidden(option, shown[:1]) for option in options)
    rows = [[option.full_name, *_cells(option, shown, apart=apart)] for option in options]
    heads = ["option", *(measures[measure] for measure in shown)]
    more: list[tuple[str, list[str]]] = [
        ("", [option.instead * apart for option in options]),
        ("", [WORDS[option.standing] for option in options]),
        ("worst day, days missed", [option.days for option in options]),
        ("p", [p_value(option.p) if option.p is not None else "" for option in options]),
        ("runs", [number(option.runs) for option in options]),
        ("a year", ["" if option.cost is None else number(option.cost) for option in options]),
    ]
    for head, column in more:
        if any(column):
            heads.append(head)
            rows = [[*row, cell] for row, cell in zip(rows, column, strict=True)]
    return heads, rows


def _hidden(option: Option, measures: Sequence[str]) -> bool:
    """Whether the option has a number of one of these measures that its text instead of a number does not state."""
    stated = "throughput_per_hour" if option.instead.endswith(DELIVERED) else ""
    return any(reading.of in measures and reading.of != stated for reading in option.numbers)


def _cells(option: Option, shown: Sequence[str], *, apart: bool) -> list[str]:
    """Return the cells of measures; `apart`: text instead of a number has a column of its own."""
    texts = {reading.of: reading.text for reading in option.numbers}
    first = option.text if not shown else option.instead * (not apart) or texts.get(shown[0], "")
    return [first, *(texts.get(measure, "") for measure in shown[1:])]


def _tables(title: str, measures: Mapping[str, str], options: Sequence[Option], width: int) -> Iterator[str]:
    """Yield a table, or several tables if not all measures fit into the width."""
    fit = _that_fit(measures, options, width)
    first = dict(list(measures.items())[:fit])
    yield printed_table(title, *table(first, options), width)
    rest = {measure: name for measure, name in measures.items() if measure not in first}
    bare = [option.model_copy(update={"instead": "", "same": (), "number": None}) for option in options if option.also]
    while rest and bare:
        fit = _that_fit(rest, bare, width)
        heads, rows = table(dict(list(rest.items())[:fit]), bare)
        yield printed_table("", heads[: fit + 1], [row[: fit + 1] for row in rows], width)
        rest = dict(list(rest.items())[fit:])


def _that_fit(measures: Mapping[str, str], options: Sequence[Option], width: int) -> int:
    """Return the number of measures that fit into the width, at least one."""
    for many in range(len(measures), 1, -1):
        heads, rows = table(dict(list(measures.items())[:many]), options)
        widths = [max(map(len, column)) + _GAP for column in zip(heads, *rows, strict=True)]
        if min(widths[0], _NAME) + sum(widths[1:]) <= width:
            return many
    return 1


def printed_table(title: str, heads: Sequence[str], rows: Sequence[Sequence[str]], width: int = WIDTH) -> str:
    """Return the text of a table below its title; columns of numbers, such as `runs`, are right-aligned."""
    from rich.console import Console
    from rich.table import Table

    made = Table(box=None, pad_edge=False, padding=(0, _GAP, 0, 0))
    for head in heads:
        made.add_column(head, justify="right" if head in _NUMBERS else "left")
    for row in rows:
        made.add_row(*row)
    stream = StringIO()
    plain = Console(
        file=stream,
        width=width,
        highlight=False,
        markup=False,
        force_jupyter=False,  # else Jupyter shows the table, and the text is empty
        force_terminal=False,  # else variables such as FORCE_COLOR colour the text
        color_system=None,
    )
    plain.print(made)
    lines = [line.rstrip() for line in stream.getvalue().splitlines()]
    return "\n".join([title, *lines] if title else lines)
