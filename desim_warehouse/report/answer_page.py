"""The answer in a folder, and its page with a run of the design that the answer is about.

Nothing is shown of any design but the one that the answer is about; where it is about none, of none.

Answers of 0.3, kept as plan.json and why.json, have their sentences, not judged anew. They name no design as later
ones do, so their pages show none.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from desim_warehouse.answer.answer import Answer, load
from desim_warehouse.answer.numbers import NONE, number
from desim_warehouse.answer.page import page as without_run
from desim_warehouse.answer.parts import Folded
from desim_warehouse.errors import ReportError, StudyError, WarehouseError, reason
from desim_warehouse.folders import ANSWER, RESULTS
from desim_warehouse.look import html
from desim_warehouse.model import load as load_model
from desim_warehouse.questions.run.page import drawings, in_full, tables
from desim_warehouse.questions.study import Results
from desim_warehouse.run import RunData
from desim_warehouse.study.record import read_record

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


def read(folder: str | Path) -> Answer:
    """Read the answer of a folder, also of version 0.3; that of a study as far as its runs are finished.

    Returns:
        The answer, as it was kept.

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


def run_of(answer: Answer) -> RunData | None:
    """A run of the design that an answer is about, with everything logged; None where there is none, or it fails."""
    if answer.about is None:
        return None
    try:
        model = load_model(answer.about.model)
    except WarehouseError:  # such as with a user's own policy, which no report may run
        return None
    return in_full(model, answer.about.seed)


def page(answer: Answer, run: RunData | None, replay: str | None = None) -> str:
    """Compose the page of an answer with the `run` of its design; `replay`: the file for its replay, which it links."""
    if run is None:
        return without_run(answer)
    link = None
    if replay is not None:
        run.replay(replay)
        link = html.link("Watch this run", Path(replay).name)
    return without_run(answer, drawings(run), tables(run), link)
