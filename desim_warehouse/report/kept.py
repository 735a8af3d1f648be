"""Read answers of version 0.3 from plan.json and why.json; they are shown with their own sentences, without designs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.numbers import NONE, number
from desim_warehouse.answer.parts import Folded
from desim_warehouse.errors import ReportError, WarehouseError, reason
from desim_warehouse.study.record import read_record

PLAN, WHY = "plan.json", "why.json"


def read_kept(path: Path) -> Answer:
    """Read the answer in a file plan.json or why.json.

    Raises:
        ReportError: the file, or the study beside it, is damaged.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        is_plan = path.name == PLAN
        record = read_record(path.parent / content["today"]["study"] if is_plan else path.parent)
        base = record.plan.base
        return Answer(
            kind=path.stem,
            description=base.description,
            runs=content["runs"],
            confidence=content["confidence"],
            made=dict(record.versions),
            **(_of_plan(content) if is_plan else {"name": base.name, **_of_why(content)}),
        )
    except (OSError, ValueError, KeyError, TypeError, RecursionError, WarehouseError) as error:
        raise ReportError(f"{path}: damaged ({reason(error)})") from error


def _of_why(content: Mapping[str, Any]) -> dict[str, Any]:
    gains = [(relief["relief"], relief["gain"], str(relief["runs"])) for relief in content["reliefs"]]
    rows = tuple((name, NONE if gain is None else number(gain), runs) for name, gain, runs in gains)
    head = ("change", f"gain in {content['indicator']}", "runs")
    table = Folded(title="Everything tried", head=head, rows=rows)
    return {"question": "What is the bottleneck?", "answer": (content["answer"],), "tables": (table,)}


def _of_plan(content: Mapping[str, Any]) -> dict[str, Any]:
    rows = tuple((option["what"], option["found"], str(option["runs"])) for option in content["evidence"])
    unsure = content["uncertain"] or {}
    tables = [Folded(title="What shows it", head=("option", "found", "runs"), rows=rows)]
    if unsure:
        head, *lines = unsure["table"]
        tables.append(Folded(title="What is not known exactly", note=unsure["answer"][0], head=head, rows=lines))
    return {
        "answer": (*content["answer"], *([unsure["in_short"]] if unsure else [])),
        "tables": tuple(tables),
        "notes": tuple(content["notes"]),
        **{key: content[key] for key in ("name", "question", "promise")},
    }
