"""The page of an answer: its sentences, at most three figures (what answers, the account of time, the floor), the rest.

Nothing is shown of any design but the one that the answer is about; where it is about none, of none.
"""

from __future__ import annotations

from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from desim_warehouse.errors import ReportError, StudyError, WarehouseError, number_of
from desim_warehouse.model import load as load_model
from desim_warehouse.outcome.account import OF_TASKS
from desim_warehouse.report import html
from desim_warehouse.report.answer import Bar, PairGrid, Rows, load
from desim_warehouse.report.floor_svg import floor
from desim_warehouse.report.html import Html
from desim_warehouse.report.kept import PLAN, WHY, kept
from desim_warehouse.report.model_parts import model_facts
from desim_warehouse.report.page import example, in_full
from desim_warehouse.report.palette import HEAT
from desim_warehouse.report.run_parts import lost_time, made_with, resources
from desim_warehouse.report.text import numbers
from desim_warehouse.report.text.printed import how_sure, table
from desim_warehouse.report.text.sentences import capital
from desim_warehouse.report.text.standing import WORDS
from desim_warehouse.report.web import colours
from desim_warehouse.run.folder import ANSWER
from desim_warehouse.study.results import Results
from desim_warehouse.study.table import RESULTS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from desim_warehouse.report.answer import Answer
    from desim_warehouse.run import Run

_LEAST = 0.005
"""Part of a task's time from which on it has a bar of its own."""
_SIGNS = {"met": "●", "not met": "×", "open": "?", "edge": "~", "overloaded": "×", "drained": "×"}
"""Cells of a grid; of what was not tried they are empty."""


def read(folder: str | Path | None) -> Answer:
    """The answer of a folder, also of versions before 0.4; None: that of a small warehouse.

    Raises:
        ReportError: where it is damaged.
    """
    if folder is None:
        from desim_warehouse.study.why import why

        return why(example(), first=5, cap=5).answer
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
    style = colours() + _heat() + files("desim_warehouse.report").joinpath("templates", "report.css").read_text("utf-8")
    figures = [] if run is None else [part for part in (_account(run), floor(run)) if part is not None]
    return html.template("answer.html").render(
        answer=answer,
        style=Html(style),
        tiles=html.tiles((one.value, one.what, one.note) for one in answer.tiles),
        figure=None if answer.figure is None else _figure(answer.figure),
        about="" if run is None or answer.about is None else capital(answer.about.name),
        figures=figures,
        folded=list(_folded(answer, run)),
        made=f"{now.day} {now:%B %Y}",
        replay=None if run is None or replay is None else html.link("Watch this run", Path(replay).name),
    )


def _heat() -> str:
    """The colours of waiting, as on the floors of replays."""
    light, dark = (" ".join(f"--w{n}: {colour};" for n, colour in enumerate(HEAT[ground], 1)) for ground in HEAT)
    return f":root {{ {light} }}\n@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"


def _figure(figure: Rows | PairGrid) -> Html:
    if isinstance(figure, Rows):
        return rows(figure)
    seen = {cell for panel in figure.panels.values() for row in panel for cell in row}
    key = [(_SIGNS[kind], words) for kind, words in WORDS.items() if kind in seen and kind in _SIGNS]
    return html.figure("grid", figure, WORDS, _SIGNS, key)


def rows(figure: Rows) -> Html:
    """Intervals, or bars from 0, one below the other: every row has its words and its number beside it."""
    ends = [end for one in figure.rows for end in (one.low, one.high, one.mean) if end is not None]
    low, high = min([*ends, figure.at or 0.0]), max([*ends, figure.at or 0.0])
    room = 0.04 * (high - low) if figure.at is not None else 0.0
    low, span = low - room, (high - low + 2 * room) or 1.0
    return html.figure("rows", figure, lambda value: round(1000 * (value - low) / span, 1))


def _account(run: Run) -> Html | None:
    """Where the time of a task goes, in one unit of time."""
    if not run.history.tasks:
        return None
    account = run.account("task")
    parts = account.mean().sort_values(ascending=False)
    whole = float(parts.sum())
    if not whole:
        return None
    unit = numbers.times(run.model.units.time, [float(parts.iloc[0])])
    marks = tuple(
        Bar(
            label=OF_TASKS[str(name)].doing,
            mean=float(part),
            text=f"{unit.value(float(part))} · {100 * part / whole:.0f} %",
            standing="part",
        )
        for name, part in parts.items()
        if part >= _LEAST * whole
    )
    tasks = number_of(len(account), "task")
    return rows(Rows(title=f"Where the {unit.value(whole)} of a task go, mean of {tasks}", rows=marks))


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
