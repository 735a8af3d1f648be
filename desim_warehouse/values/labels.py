"""Levels of factors as text: how a name of a design writes them, and how tables compare them."""

from __future__ import annotations

import json
import math
from typing import Any


def readable(label: Any) -> str:
    """Return a label in the name of a row: lists and sections as in a model file, `[M, N]` or `poisson 200`."""
    if not isinstance(label, str) or not label.startswith(("[", "{")):
        return str(label)
    try:
        value = json.loads(label)
    except ValueError:
        return label
    if isinstance(value, dict):
        return ", ".join(f"{key} {_written(item)}" for key, item in value.items())
    return _written(value)


def _written(value: Any) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, list):
        return f"[{', '.join(map(_written, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key}: {_written(item)}' for key, item in value.items())}}}"
    return json.dumps(value)


def plain(value: Any) -> Any:
    """Return a value of a factor in a form that can be compared and sorted: a list or section as JSON text."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict | list | tuple):
        return json.dumps(value, default=str)
    return None if isinstance(value, float) and math.isnan(value) else value
