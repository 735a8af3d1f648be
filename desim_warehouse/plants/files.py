"""The files of an imported model: a large layout or a long list of tasks gets a file of its own."""

from __future__ import annotations

import csv
import io
import tempfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.model import layout_file

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from desim_warehouse.plants.stops import PlantTask

    Content = dict[str, Any]

MOST = 500
"""Entries of a part of the layout, or tasks, that are written into the model file itself."""


def apart(content: Content, path: Path) -> tuple[Content, dict[Path, str]]:
    """Split a model to be written to `path`: its text without the large parts, and the files of these."""
    layout, files = content["layout"], {}
    if any(_size(part) > MOST for part in layout.values()):
        large = {key: part for key, part in layout.items() if _size(part) > MOST or key in {"nodes", "edges"}}
        there = layout_file.beside(path)
        files[there] = layout_file.text(large)
        left = {key: part for key, part in layout.items() if key not in large}
        content = {**content, "layout": {"file": there.name, **left}}
    return content, files


def _size(part: Any) -> int:
    """How many entries a part has, with those of the lists in it."""
    items = part.values() if isinstance(part, dict) else part
    return len(part) + sum(len(item.get("at", ())) for item in items if isinstance(item, dict))


def are_orders(tasks: list[PlantTask]) -> bool:
    """Whether tasks are written as orders, in a file of their own: many, or some with stops on the way."""
    return len(tasks) > MOST or any(task.via for task in tasks)


def orders_text(tasks: Sequence[PlantTask]) -> str:
    """The tasks as a file of orders, earliest first."""
    columns: dict[str, Callable[[PlantTask], str]] = {
        "order": lambda task: task.name,
        "release": lambda task: f"{task.release:g}",
        "from": lambda task: task.source,
        "via": lambda task: " > ".join(task.via),
        "to": lambda task: task.target,
        "due": lambda task: "" if task.due is None else f"{task.due:g}",
    }
    used = [name for name, cell in columns.items() if any(map(cell, tasks))]
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(used)
    table.writerows([columns[name](task) for name in used] for task in sorted(tasks, key=lambda task: task.release))
    return text.getvalue()


def orders_beside(path: Path) -> Path:
    """Where the orders of a model file are written."""
    return path.with_name(f"{path.stem}.orders.csv")


def kept(text: str, name: str) -> Path:
    """A temporary file with this text, kept until the process ends, for a model that is not written."""
    path = Path(_folder().name) / name
    path.write_text(text, encoding="utf-8")
    return path


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="desim-")
