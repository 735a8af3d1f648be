"""Model files in readable form: sections as blocks, small parts in one line, comments beside keys.

A large layout or a long list of tasks gets its own file beside the model file.

For the files that `desim import` writes.
"""

from __future__ import annotations

import csv
import io
import json
import re
import tempfile
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.model import layout_file
from desim_warehouse.plants.stops import PlantTask

if TYPE_CHECKING:
    Comments = Mapping[tuple[str | int, ...], str]
    Content = dict[str, Any]

_PLAIN = re.compile(r"[^\W\d_](?:[\w. /()+-]*[\w()+])?", re.ASCII)
_WORDS = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}
_WIDE = 100  # characters of a part in one line

MOST = 500
"""Most entries of a part of the layout, or tasks, that are written into the model file itself."""


def written(content: Mapping[str, Any], comments: Comments, head: Iterable[str] = ()) -> str:
    """Return the text of a model file: YAML that `load` reads back as an equal model.

    Args:
        content: plain values: mappings, lists, text, numbers, true, false.
        comments: comments on values, by their keys.
        head: comment lines on top.
    """
    lines = [f"# {one_line(line)}" for line in head]
    about = {keys[:length] for keys in comments for length in range(1, len(keys))}  # parts with comments inside
    for key, value in content.items():
        if isinstance(value, Mapping):
            lines.append("")
        lines += _entry(f"{_scalar(key)}:", value, (key,), comments, about, 0)
    unplaced = [
        f"# {one_line('.'.join(map(str, keys)) + ': ' + text)}"
        for keys, text in comments.items()
        if not _has(content, keys)
    ]
    return "\n".join([*lines, *([""] if unplaced else []), *unplaced, ""])


def _has(content: Any, keys: tuple[str | int, ...]) -> bool:
    for key in keys:
        try:
            content = content[key]
        except (KeyError, IndexError, TypeError):
            return False
    return True


def _entry(
    begin: str,
    value: Any,
    keys: tuple[str | int, ...],
    comments: Comments,
    about: Container[tuple[str | int, ...]],
    depth: int,
) -> Iterator[str]:
    """Yield the lines of a key or list item and its value."""
    indent, comment = "  " * depth, comments.get(keys)
    beside = f"  # {one_line(comment)}" if comment else ""
    inside = keys in about
    flow = _flow(value)
    if not isinstance(value, Mapping | list) or (not inside and depth and _is_small(value) and len(flow) <= _WIDE):
        yield f"{indent}{begin} {flow}{beside}"
        return
    yield f"{indent}{begin}{beside}"
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _entry(f"{_scalar(key)}:", item, (*keys, key), comments, about, depth + 1)
    else:
        for rank, item in enumerate(value):
            yield from _entry("-", item, (*keys, rank), comments, about, depth + 1)


def _is_small(value: Any) -> bool:
    """Return whether a part has no other inner parts than lists of plain values."""
    items = value.values() if isinstance(value, Mapping) else value
    return bool(value) and not any(
        isinstance(item, Mapping)
        or (isinstance(item, list) and any(isinstance(entry, Mapping | list) for entry in item))
        for item in items
    )


def _flow(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_scalar(key)}: {_flow(item)}' for key, item in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_flow, value))}]"
    return _scalar(value)


def _scalar(value: Any) -> str:
    """Return a number, truth value or text as YAML, with quotes only if YAML would read the text as something else."""
    if not isinstance(value, str):
        return json.dumps(value)
    if _PLAIN.fullmatch(value) and value.lower() not in _WORDS:
        return value
    if value.isprintable():
        return json.dumps(value, ensure_ascii=False)
    return (
        '"'
        + "".join(
            character if character.isprintable() and character not in '"\\' else f"\\U{ord(character):08x}"
            for character in value
        )
        + '"'
    )


def one_line(text: str) -> str:
    """Return the text in one line, with blanks for line ends and other invisible characters."""
    return "".join(character if character.isprintable() else " " for character in text)


def apart(content: Content, path: Path) -> tuple[Content, dict[Path, str]]:
    """Return a model to be written to `path` without its large parts, and the texts of their files by path."""
    layout, files = content["layout"], {}
    if any(_size(part) > MOST for part in layout.values()):
        large = {key: part for key, part in layout.items() if _size(part) > MOST or key in {"nodes", "edges"}}
        beside = layout_file.beside(path)
        files[beside] = layout_file.text(large)
        left = {key: part for key, part in layout.items() if key not in large}
        content = {**content, "layout": {"file": beside.name, **left}}
    return content, files


def _size(part: Any) -> int:
    """Return the number of entries of a part, with the entries of the lists in it."""
    items = part.values() if isinstance(part, dict) else part
    return len(part) + sum(len(item.get("at", ())) for item in items if isinstance(item, dict))


def are_orders(tasks: list[PlantTask]) -> bool:
    """Return whether tasks are written as orders, in their own file, as they are many or have stops on the way."""
    return len(tasks) > MOST or any(task.via for task in tasks)


def orders_text(tasks: Sequence[PlantTask]) -> str:
    """Return the tasks as a file of orders, in the order of release."""
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
    """Return the path of the orders beside a model file."""
    return path.with_name(f"{path.stem}.orders.csv")


def kept(text: str, name: str) -> Path:
    """Return a temporary file with this text, kept until the process ends, for a model that is not written."""
    path = Path(_folder().name) / name
    path.write_text(text, encoding="utf-8")
    return path


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="desim-")
