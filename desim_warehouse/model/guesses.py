"""Which values of a model file are guesses: those that it marks with (!), until somebody takes the mark away."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from desim_warehouse.model.messages import Keys, dotted
from desim_warehouse.model.parse import from_file
from desim_warehouse.model.schema import OUTLINE

_MARK = re.compile(r"#\s*\(!\)")
"""A comment that begins with the mark; `desim new` explains it at the top of its file, in the middle of one."""


def guesses(path: str | Path, changed: Iterable[str] = ()) -> tuple[str, ...]:
    """List the keys that a model file marks as guesses, in the order of the file.

    Args:
        path: the file. A mark is of the outermost key on its line, on a line of its own of the key below.
        changed: dotted keys that overrides set, which are guesses no more.

    Raises:
        ModelError: where the file cannot be read.
    """
    document = from_file(Path(path), str(path), "a model with layout, fleet and tasks", OUTLINE)
    by_line: dict[int, Keys] = {}
    for keys, position in document.positions.keys.items():
        before = by_line.get(position.line)
        if keys and (before is None or len(keys) < len(before)):
            by_line[position.line] = keys
    set_anew = set(changed)
    listed = []
    for number, line in enumerate(document.text.splitlines(), 1):
        if _MARK.search(line):
            entry = min((key for key in by_line if key >= number), default=None)
            keys = () if entry is None else _named(by_line[entry])
            if keys and not any(dotted(keys[:size]) in set_anew for size in range(1, len(keys) + 1)):
                listed.append(dotted(keys))
    return tuple(dict.fromkeys(listed))


def _named(keys: Keys) -> Keys:
    """Return the keys of an entry of a list, where its first key stands on the line."""
    return keys[:-1] if len(keys) > 1 and isinstance(keys[-2], int) else keys
