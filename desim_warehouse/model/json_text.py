"""JSON from files: numbers that are numbers, every key once, and mistakes by line and column."""

from __future__ import annotations

import json
from typing import Any, NoReturn

from desim_warehouse.errors import ModelError, got


def read_json(content: bytes, name: str, expected: str) -> Any:
    """The value that a JSON file holds.

    Args:
        content: the file, in UTF-8.
        name: what messages call it.
        expected: what it should hold, for messages.

    Raises:
        ModelError: where it is not JSON, holds a key twice in one section, or NaN or Infinity.
    """
    try:
        return json.loads(content.decode("utf-8-sig"), object_pairs_hook=_once, parse_constant=_no_number)
    except UnicodeDecodeError as error:
        line, column = content.count(b"\n", 0, error.start) + 1, error.start - content.rfind(b"\n", 0, error.start)
        wrong = f"not UTF-8 text (got byte 0x{content[error.start]:02x})"
        raise ModelError([f"{name}:{line}:{column}: {wrong}, expected {expected}"]) from None
    except json.JSONDecodeError as error:
        wrong = f"not JSON ({error.msg[:1].lower()}{error.msg[1:]})"
        raise ModelError([f"{name}:{error.lineno}:{error.colno}: {wrong}, expected {expected}"]) from None
    except RecursionError:
        text = f"too many lists or sections inside one another, expected {expected}"
        raise ModelError([f"{name}: {text}"]) from None
    except ValueError as error:  # of the two below, or a number of thousands of digits
        raise ModelError([f"{name}: {error}, expected {expected}"]) from None


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise ValueError(f"the key {got(twice)} stands twice in one section")
    return made


def _no_number(name: str) -> NoReturn:
    raise ValueError(f"{name}, which is no number")
