"""The page of an answer: its sentences, at most three figures, everything tried, and how sure it is.

The page knows no run: drawings and tables of the run that is shown with an answer are handed in.
"""

from __future__ import annotations

import platform
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime

from desim_warehouse._version import __version__
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.parts import AnswerData, PairGrid, Rows
from desim_warehouse.answer.standing import WORDS
from desim_warehouse.answer.text import how_sure, table
from desim_warehouse.look import html
from desim_warehouse.look.html import Html
from desim_warehouse.look.page import style

_SIGNS = {"met": "●", "not met": "×", "open": "?", "edge": "~", "overloaded": "×", "drained": "×"}
"""Cells of a grid; of what was not tried they are empty."""


def page(
    answer: AnswerData,
    drawings: Sequence[Html] = (),
    tables: Sequence[tuple[str, Html]] = (),
    replay: Html | None = None,
) -> str:
    """Compose the page, self-contained.

    Args:
        answer: the answer.
        drawings: of a run of the design that the answer is about, shown below the answer.
        tables: of that run, folded away, each with its title.
        replay: a link to the replay of that run.
    """
    now = datetime.now(UTC).astimezone()
    return html.template("answer.html").render(
        answer=answer,
        style=style(),
        tiles=html.tiles((tile.value, tile.what, tile.note) for tile in answer.tiles),
        figure=None if answer.figure is None else _figure(answer.figure),
        about="" if answer.about is None or not tables else capital(answer.about.name),
        figures=drawings,
        folded=list(_folded(answer, tables)),
        made=f"{now.day} {now:%B %Y}",
        replay=replay,
    )


def made_with() -> tuple[str, str]:
    """Name what makes a report; its runs may be older."""
    return "Report made with", f"desim-warehouse {__version__}, Python {platform.python_version()}"


def _figure(figure: Rows | PairGrid) -> Html:
    if isinstance(figure, Rows):
        return rows(figure)
    seen = {cell for panel in figure.panels.values() for row in panel for cell in row}
    key = [(_SIGNS[kind], words) for kind, words in WORDS.items() if kind in seen and kind in _SIGNS]
    return html.figure("grid", figure, WORDS, _SIGNS, key)


def rows(figure: Rows) -> Html:
    """Intervals, or bars from 0, one below the other."""
    ends = [end for one in figure.rows for end in (one.low, one.high, one.mean) if end is not None]
    low, high = min([*ends, figure.at or 0.0]), max([*ends, figure.at or 0.0])
    room = 0.04 * (high - low) if figure.at is not None else 0.0
    low, span = low - room, (high - low + 2 * room) or 1.0
    return html.figure("rows", figure, lambda value: round(1000 * (value - low) / span, 1))


def _folded(answer: AnswerData, of_run: Sequence[tuple[str, Html]]) -> Iterator[tuple[str, Html]]:
    """Yield title and content of each section that is folded away."""
    if answer.options:
        yield "Everything tried", _options(answer)
    for part in answer.tables:
        note = html.paragraph(part.note, "note") if part.note else Html("")
        yield part.title, html.table(part.head, part.rows, words=len(part.head), name=_id(part.title)) + note
    yield from of_run
    sure = html.paragraph(how_sure(answer))
    yield "How sure is this?", sure + (html.bullets(answer.notes) if answer.notes else Html(""))
    facts = html.facts([*answer.made.items(), made_with()], "method")
    yield "See it again", (html.code(answer.command) if answer.command else Html("")) + facts


def _id(title: str) -> str:
    """The id of a table, for programs."""
    return title.lower().replace(" ", "-")


def _options(answer: AnswerData) -> Html:
    """A table of the options of each group, a row for each."""
    made = Html("")
    for group, options in answer.groups().items():
        head, body = table(answer.measures, options)
        made += html.paragraph(capital(group), "note") if group else Html("")
        words = 2 + sum(of in answer.measures.values() for of in head)
        made += html.table(head, body, words=words, name=_id(f"options {group}".strip()))
    return made
