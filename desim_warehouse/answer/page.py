"""The page of an answer: its sentences and figures, all options tried, and its confidence.

For `--page` of commands, and for `desim report`.

If a run is shown with the answer, the caller passes its drawings and tables, as this module does not know runs.
"""

from __future__ import annotations

import platform
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING
from urllib.parse import quote

from markupsafe import Markup

from desim_warehouse._version import __version__
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.parts import AnswerData, Folded, PairGrid, Points, Rows
from desim_warehouse.answer.standing import WORDS
from desim_warehouse.answer.text import how_sure, table
from desim_warehouse.look import html

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    Drawing = Rows | PairGrid | Points | Markup | Axes

_SIGNS = {"met": "●", "not met": "×", "open": "?", "edge": "~", "overloaded": "×", "drained": "×"}
"""Cells of a grid; cells of untried options are empty."""
_WIDE, _HIGH, _EDGE = 1000, 380, 0.06
"""Width and height of a figure of points, and the margin on each side as a share of them."""
_LEAD = 160
"""Longest description that is put before the answer, in letters; longer ones, as of imported plants, follow it."""


def page(
    answer: AnswerData,
    drawings: Mapping[str, Sequence[Drawing]] | None = None,
    of_run: Sequence[Folded] = (),
    replay: str = "",
) -> str:
    """Compose the self-contained page of an answer, without scripts and external links, as HTML.

    Args:
        answer: the answer.
        drawings: drawings by the title of the table above which they are shown, folded with it; those under "" are
            shown below the answer.
        of_run: tables of a run of the design that the answer is about, of which the drawings under "" are too.
        replay: name of the file beside the page that replays the run.
    """
    now = datetime.now(UTC).astimezone()
    figure = "" if answer.figure is None else _drawn(answer.figure)
    drawn = {title: [_drawn(drawing) for drawing in several] for title, several in (drawings or {}).items()}
    every = "".join([figure, *(drawing for several in drawn.values() for drawing in several)])
    return html.template("page.html").render(
        answer=answer,
        style=html.style([kind for kind in html.FIGURES if f'<figure class="{kind}"' in every]),
        is_short=len(answer.description) <= _LEAD,
        figure=figure,
        about="" if answer.about is None else capital(answer.about.name),
        drawings=drawn,
        nearest=_alike(answer.nearest),
        sheet=[part for part in answer.tables if part.on_sheet and part.rows],
        tables=[part for part in (*answer.tables, *of_run) if not part.on_sheet],
        has_run=bool(of_run),
        replay=quote(replay),
        options=list(_options(answer)),
        sure=how_sure(answer),
        made=[
            *answer.made.items(),
            ("Report made with", f"desim-warehouse {__version__}, Python {platform.python_version()}"),
        ],
        today=f"{now.day} {now:%B %Y}",
    )


def _drawn(drawing: Drawing) -> Markup:
    if isinstance(drawing, Rows):
        return _rows(drawing)
    if isinstance(drawing, PairGrid):
        seen = {cell for panel in drawing.panels.values() for row in panel for cell in row}
        key = [(_SIGNS[kind], words) for kind, words in WORDS.items() if kind in seen and kind in _SIGNS]
        return html.figure("grid", drawing, _SIGNS, key)
    if isinstance(drawing, Points):
        return _points(drawing)
    return drawing if isinstance(drawing, Markup) else html.picture(drawing)


def _points(figure: Points) -> Markup:
    """Draw options by two indicators; options that stand out are drawn last, on top of the others."""
    xs, ys = [*(point.x for point in figure.points), figure.at], [point.y for point in figure.points]

    def place(value: float, values: Sequence[float], size: int) -> float:
        low, span = min(values), max(values) - min(values)
        return round(size * (_EDGE + (1 - 2 * _EDGE) * ((value - low) / span if span else 0.5)), 1)

    marks = [(place(point.x, xs, _WIDE), _HIGH - place(point.y, ys, _HIGH), point) for point in figure.points]
    marks.sort(key=lambda mark: bool(mark[2].name))
    return html.figure("points", figure, marks, place(figure.at, xs, _WIDE), (_WIDE, _HIGH))


def _alike(figures: Sequence[Rows]) -> list[Markup]:
    """Draw figures of one indicator on a common scale, with one key for all."""
    ends = _ends(figures)
    return [_rows(figure, ends) for figure in figures]


def _ends(figures: Sequence[Rows]) -> tuple[float, float]:
    """Return the least and the largest value in figures."""
    rows = [row for figure in figures for row in figure.rows]
    values = [end for row in rows for end in (row.low, row.high, row.mean) if end is not None]
    values += [figure.at or 0.0 for figure in figures]
    return min(values, default=0.0), max(values, default=0.0)


def _rows(figure: Rows, ends: tuple[float, float] | None = None) -> Markup:
    """Draw intervals, or bars from 0, in rows, on a scale between `ends` (None: the ends of the figure itself)."""
    low, high = ends or _ends([figure])
    room = 0.04 * (high - low) if figure.at is not None else 0.0
    low, span = low - room, (high - low + 2 * room) or 1.0
    return html.figure("rows", figure, lambda value: round(1000 * (value - low) / span, 1), ends is None)


def _options(answer: AnswerData) -> Iterator[tuple[str, list[str], list[list[str]], int]]:
    """Yield the name of each group of options, the head and rows of its table, and its number of text columns."""
    for group, options in answer.groups().items():
        head, rows = table(answer.measures, options)
        yield capital(group), head, rows, 1 + sum(not column or column in answer.measures.values() for column in head)
