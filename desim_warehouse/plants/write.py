"""Model files as people write them: sections as blocks, small parts in one line, comments beside keys."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Iterator

    Comments = Mapping[tuple[str | int, ...], str]

_PLAIN = re.compile(r"[^\W\d_](?:[\w. /()+-]*[\w()+])?", re.ASCII)
_WORDS = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}
_WIDE = 100  # characters of a part in one line


def written(content: Mapping[str, Any], comments: Comments, head: Iterable[str] = ()) -> str:
    """YAML that `load` reads back as the same.

    Args:
        content: plain values: mappings, lists, text, numbers, true, false.
        comments: words beside a value, by its keys.
        head: lines of comment on top.
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
    """The lines of a key or list item and its value."""
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
    """Whether a part has no further parts but lists of plain values."""
    items = value.values() if isinstance(value, Mapping) else value
    return bool(value) and not any(
        isinstance(item, Mapping) or (isinstance(item, list) and any(isinstance(one, Mapping | list) for one in item))
        for item in items
    )


def _flow(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_scalar(key)}: {_flow(item)}' for key, item in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_flow, value))}]"
    return _scalar(value)


def _scalar(value: Any) -> str:
    """A number, true or false, or text: in quotes where YAML would take it for something else."""
    if not isinstance(value, str):
        return json.dumps(value)
    if _PLAIN.fullmatch(value) and value.lower() not in _WORDS:
        return value
    if value.isprintable():
        return json.dumps(value, ensure_ascii=False)
    return '"' + "".join(one if one.isprintable() and one not in '"\\' else f"\\U{ord(one):08x}" for one in value) + '"'


def one_line(text: str) -> str:
    """The text with blanks for line ends and other unseen characters."""
    return "".join(one if one.isprintable() else " " for one in text)
