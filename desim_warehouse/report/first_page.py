"""The first page of a report: the question, the answer, the date, and a replay to watch."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from desim_warehouse.errors import WarehouseError
from desim_warehouse.report import html

if TYPE_CHECKING:
    from collections.abc import Iterable

    from desim_warehouse.model import Model
    from desim_warehouse.report.html import Html
    from desim_warehouse.run import Run


def first_page(
    title: str, description: str, question: str, answer: Iterable[str], run: Run | None, replay: str | None
) -> Html:
    """Title, question and answer; then the date, and a link to the replay of `run`, written to the path `replay`."""
    now = datetime.now(UTC).astimezone()
    parts = html.heading(title)
    parts += html.paragraph(description, "lead") if description else html.Html("")
    parts += html.paragraph(question, "question") + html.bullets(answer, "answers")
    made = f"{now.day} {now:%B %Y}"
    if run is None or replay is None:
        return parts + html.paragraph(made, "note")
    run.replay(replay)
    return parts + html.paragraph(f"{made}. ", "note", html.link("Watch a run", Path(replay).name))


def in_full(model: Model, seed: int) -> Run | None:
    """A run with everything logged; None where it fails, or would run code: a report is opened without fear."""
    from desim_warehouse.run import simulate

    if model.policies.own():
        return None
    try:
        return simulate(model.replace({"log": "all"}), seed)
    except WarehouseError:
        return None


def example() -> Model:
    """A small warehouse for reports of no folder."""
    from desim_warehouse.draft import Draft, draft
    from desim_warehouse.model import load
    from desim_warehouse.model.parse import read_yaml

    words = Draft(size=(16.0, 14.0), orders=60.0, due=2.5, name="an example")
    content = read_yaml(draft(words), "the example").data
    return load({**content, "run": {"length": 3600, "warm_up": 600}})
