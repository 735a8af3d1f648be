"""JSON from strangers: plain values, every key of an object once, no number that JSON does not have."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from desim_warehouse.errors import ModelError, reason
from desim_warehouse.values.fields import LIMITS


class JsonError(ValueError):
    """Text that is no JSON as strangers may send it: `where` in the text, "" for all of it, and what was `expected`."""

    def __init__(self, message: str, where: str = "", expected: str | None = None) -> None:
        super().__init__(message)
        self.where = where
        self.expected = expected


def read_json(path: Path, content: bytes, expected: str, most: int = LIMITS["values"][0]) -> Any:
    """Read the value that a file holds.

    Args:
        path: the file, for messages.
        content: what stands in it.
        expected: what it should hold, for messages.
        most: values, about.

    Raises:
        ModelError: where it is not JSON, has too many values, or a key twice in an object.
    """
    try:
        return value_of(content, most)
    except JsonError as error:
        raise ModelError([f"{path}{error.where}: {error}, expected {error.expected or expected}"]) from None


def value_of(content: bytes, most: int = LIMITS["values"][0]) -> Any:
    """Return the value of a JSON text; raises JsonError, as for `read_json`."""
    doubled: list[tuple[dict[str, Any], str]] = []
    strange: list[str] = []

    def made(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        items = dict(pairs)
        if len(items) < len(pairs):
            [(key, _)] = Counter(key for key, _ in pairs).most_common(1)
            doubled.append((items, key))
        return items

    def constant(name: str) -> float:
        strange.append(name)
        return math.nan

    try:
        text = content.decode(json.detect_encoding(content))
        if sum(map(text.count, ",[{")) > most:
            raise JsonError("too many values", expected=f"{most:,} at most")  # noqa: TRY301 - said as the others
        value = json.loads(text.removeprefix("\ufeff"), object_pairs_hook=made, parse_constant=constant)
    except json.JSONDecodeError as error:
        message = f"not JSON ({error.msg[:1].lower()}{error.msg[1:]})"
        raise JsonError(message, f":{error.lineno}:{error.colno}") from None
    except RecursionError:
        raise JsonError("too many lists or objects inside one another") from None
    except JsonError:
        raise
    except ValueError as error:  # not text, or a number of thousands of digits
        raise JsonError(f"not JSON ({reason(error)})") from None
    if doubled:
        item, key = doubled[-1]  # whatever is around it is read later, and has every key once
        where = _path(value, lambda part: part is item)
        raise JsonError(f"key {key!r} given twice", f": {where}", "once")
    if strange:
        where = _path(value, lambda part: isinstance(part, float) and math.isnan(part))
        raise JsonError(f"not a number (got {strange[0]})", f": {where}", "one")
    return value


def _path(root: Any, fits: Callable[[Any], bool]) -> str:
    """Return the JSON path to the first value that fits, such as `layouts[0].nodes[3]`."""
    rest: list[tuple[str, Any]] = [("", root)]
    while rest:
        path, value = rest.pop()
        if fits(value):
            break
        if isinstance(value, dict):
            rest += [(f"{path}.{key}" if path else key, item) for key, item in reversed(value.items())]
        elif isinstance(value, list):
            rest += [(f"{path}[{rank}]", item) for rank, item in reversed(list(enumerate(value)))]
    return path or "the top level"
