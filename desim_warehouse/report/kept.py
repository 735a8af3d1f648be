"""Answers of versions before 0.4, which kept them as plan.json and why.json: their sentences, not judged anew.

They name no design as later ones do, so their pages show none.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from desim_warehouse.errors import ReportError, WarehouseError, reason
from desim_warehouse.report.answer import Answer, Folded
from desim_warehouse.report.text.numbers import NONE, number
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
    unsure = content.get("uncertain") or {}
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
        notes=tuple(content.get("notes", ())),
        runs=content["runs"],
        confidence=content["confidence"],
        made=dict(record.versions),
    )


def _shown(value: float | None) -> str:
    return NONE if value is None else number(value)
