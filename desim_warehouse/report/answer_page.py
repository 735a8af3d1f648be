"""The page of an answer: its sentences, at most three figures (what answers, the account of time, the floor), the rest.

Nothing is shown of any design but the one that the answer is about; where it is about none, of none.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from desim_warehouse.errors import ReportError, StudyError, WarehouseError
from desim_warehouse.model import load as load_model
from desim_warehouse.report import html
from desim_warehouse.report.answer import Answer, PairGrid, Rows, load
from desim_warehouse.report.html import Html
from desim_warehouse.report.kept import PLAN, WHY, kept
from desim_warehouse.report.model_parts import model_facts
from desim_warehouse.report.page import in_full, style
from desim_warehouse.report.run_parts import lost_time, made_with, resources
from desim_warehouse.report.svg import account, floor, rows
from desim_warehouse.report.text.printed import how_sure, table
from desim_warehouse.report.text.sentences import capital
from desim_warehouse.report.text.standing import WORDS
from desim_warehouse.run import Run
from desim_warehouse.run.folder import ANSWER
from desim_warehouse.study.results import Results
from desim_warehouse.study.table import RESULTS

_SIGNS = {"met": "●", "not met": "×", "open": "?", "edge": "~", "overloaded": "×", "drained": "×"}
"""Cells of a grid; of what was not tried they are empty."""


def read(folder: str | Path) -> Answer:
    """The answer of a folder, also of versions before 0.4.

    Raises:
        ReportError: where it is damaged.
    """
    if Path(folder, ANSWER).is_file():
        return load(folder)
    old = [path for path in (Path(folder, PLAN), Path(folder, WHY)) if path.is_file()]
    return kept(old[0]) if old else _of_study(folder)


def _of_study(folder: str | Path) -> Answer:
    """The answer of a study folder as far as its runs are finished."""
    try:
        results = Results.load(folder)
    except StudyError as error:
        raise ReportError(str(error)) from error
    errors = [row.outcome.error for row in results.rows]
    if None not in errors:
        why = f"every run failed, the first with: {errors[0]}" if errors else "no run has finished"
        raise ReportError(f"{Path(folder) / RESULTS}: {why}, so there is nothing to report")
    return results.answer


def run_of(answer: Answer) -> Run | None:
    """A run of the design that an answer is about, with everything logged; None where there is none, or it fails."""
    if answer.about is None:
        return None
    try:
        model = load_model(answer.about.model)
    except WarehouseError:  # such as with a user's own policy, which no report may run
        return None
    return in_full(model, answer.about.seed)


def page(answer: Answer, run: Run | None, replay: str | None = None) -> str:
    """The page, self-contained, with the `run` of its design; `replay`: the file for its replay, which it links."""
    if run is not None and replay is not None:
        run.replay(replay)
    now = datetime.now(UTC).astimezone()
    figures = [] if run is None else [part for part in (account(run), floor(run)) if part is not None]
    return html.template("answer.html").render(
        answer=answer,
        style=style(),
        tiles=html.tiles((one.value, one.what, one.note) for one in answer.tiles),
        figure=None if answer.figure is None else _figure(answer.figure),
        about="" if run is None or answer.about is None else capital(answer.about.name),
        figures=figures,
        folded=list(_folded(answer, run)),
        made=f"{now.day} {now:%B %Y}",
        replay=None if run is None or replay is None else html.link("Watch this run", Path(replay).name),
    )


def _figure(figure: Rows | PairGrid) -> Html:
    if isinstance(figure, Rows):
        return rows(figure)
    seen = {cell for panel in figure.panels.values() for row in panel for cell in row}
    key = [(_SIGNS[kind], words) for kind, words in WORDS.items() if kind in seen and kind in _SIGNS]
    return html.figure("grid", figure, WORDS, _SIGNS, key)


def _folded(answer: Answer, run: Run | None) -> Iterator[tuple[str, Html]]:
    """What is folded away below."""
    if answer.options:
        yield "Everything tried", _options(answer)
    for one in answer.tables:
        note = html.paragraph(one.note, "note") if one.note else Html("")
        yield one.title, html.table(one.head, one.rows, words=len(one.head), name=_id(one.title)) + note
    if run is not None:
        parts = {"Stations and chargers": resources(run), "What robots waited for": lost_time(run)}
        yield from ((title, part) for title, part in parts.items() if part is not None)
        yield "The warehouse", model_facts(run.model)
    sure = html.paragraph(how_sure(answer))
    yield "How sure is this?", sure + (html.bullets(answer.notes) if answer.notes else Html(""))
    facts = html.facts([*answer.made.items(), made_with()], "method")
    yield "See it again", (html.code(answer.command) if answer.command else Html("")) + facts


def _id(title: str) -> str:
    """The id of a table, for programs."""
    return title.lower().replace(" ", "-")


def _options(answer: Answer) -> Html:
    """A table of the options of each group, a row for each."""
    made = Html("")
    for group, options in answer.groups().items():
        head, body = table(answer.measures, options)
        made += html.paragraph(capital(group), "note") if group else Html("")
        words = 2 + sum(of in answer.measures.values() for of in head)
        made += html.table(head, body, words=words, name=_id(f"options {group}".strip()))
    return made
