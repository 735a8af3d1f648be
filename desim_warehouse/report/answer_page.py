"""The page of an answer: its sentences, at most three figures (what answers, the account of time, the floor), the rest.

Nothing is shown of any design but the one that the answer is about; where it is about none, of none.

Answers of 0.3, kept as plan.json and why.json, have their sentences, not judged anew. They name no design as later
ones do, so their pages show none.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from desim_warehouse.answer.answer import Answer, Folded, PairGrid, Rows, how_sure, load, table
from desim_warehouse.answer.numbers import NONE, capital, number
from desim_warehouse.answer.standing import WORDS
from desim_warehouse.errors import ReportError, StudyError, WarehouseError, reason
from desim_warehouse.folders import ANSWER
from desim_warehouse.look import html
from desim_warehouse.look.html import Html
from desim_warehouse.model import load as load_model
from desim_warehouse.report.page import in_full, style
from desim_warehouse.report.run_parts import lost_time, made_with, model_facts, resources
from desim_warehouse.report.svg import account, floor, rows
from desim_warehouse.run import Run
from desim_warehouse.study.record import read_record
from desim_warehouse.study.results import Results
from desim_warehouse.study.table import RESULTS

PLAN, WHY = "plan.json", "why.json"


def kept(path: Path) -> Answer:
    """The answer in plan.json or why.json.

    Raises:
        ReportError: where it is damaged.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return (_plan if path.name == PLAN else _why)(content, path.parent)
    except (OSError, ValueError, KeyError, TypeError, RecursionError, WarehouseError) as error:
        raise ReportError(f"{path}: damaged ({reason(error)})") from error


def _why(content: Mapping[str, Any], folder: Path) -> Answer:
    record = read_record(folder)
    rows = tuple((one["relief"], _shown(one["gain"]), str(one["runs"])) for one in content["reliefs"])
    head = ("change", f"gain in {content['indicator']}", "runs")
    return Answer(
        kind="why",
        name=record.plan.base.name,
        description=record.plan.base.description,
        question="What holds it up?",
        answer=(content["answer"],),
        tables=(Folded(title="Everything tried", head=head, rows=rows),),
        runs=content["runs"],
        confidence=content["confidence"],
        made=dict(record.versions),
    )


def _plan(content: Mapping[str, Any], folder: Path) -> Answer:
    record = read_record(folder / content["today"]["study"])
    rows = tuple((one["what"], one["found"], str(one["runs"])) for one in content["evidence"])
    unsure = content["uncertain"] or {}
    tables = [Folded(title="What shows it", head=("option", "found", "runs"), rows=rows)]
    if unsure:
        head, *lines = unsure["table"]
        tables.append(Folded(title="What is not known exactly", note=unsure["answer"][0], head=head, rows=lines))
    return Answer(
        kind="plan",
        name=content["name"],
        description=record.plan.base.description,
        question=content["question"],
        answer=(*content["answer"], *([unsure["in_short"]] if unsure else [])),
        tables=tuple(tables),
        promise=content["promise"],
        notes=tuple(content["notes"]),
        runs=content["runs"],
        confidence=content["confidence"],
        made=dict(record.versions),
    )


def _shown(value: float | None) -> str:
    return NONE if value is None else number(value)


_SIGNS = {"met": "●", "not met": "×", "open": "?", "edge": "~", "overloaded": "×", "drained": "×"}
"""Cells of a grid; of what was not tried they are empty."""


def read(folder: str | Path) -> Answer:
    """The answer of a folder, also of version 0.3.

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
