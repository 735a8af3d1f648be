"""A layout in a file of its own, JSON, beside the model file that names it (`layout.file`): for large layouts.

A JSON file of 50,000 nodes is read within a second, a YAML file within minutes.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from desim_warehouse.errors import ModelError, got, reason
from desim_warehouse.model.json_text import read_json
from desim_warehouse.values.fields import LIMITS

EXPECTED = "a JSON file with keys of the layout section, such as nodes and edges"

_MOST = 5_000_000  # values: some for each node and edge


def beside(model: Path) -> Path:
    """Return the path at which the layout file of a model file is written."""
    return model.with_name(f"{model.stem}.layout.json")


def read(path: Path) -> dict[str, Any]:
    """Read the keys of the layout section that a file holds.

    Raises:
        ModelError: where it cannot be read, is no JSON, or holds something else.
    """
    most = LIMITS["json"][0]
    if path.exists() and not path.is_file():  # a pipe or a device may never end
        raise ModelError([f"not a file (got '{path}'), expected {EXPECTED}"])
    try:
        with path.open("rb") as file:
            content = file.read(most + 1)
    except (OSError, ValueError) as error:
        raise ModelError([f"cannot be read (got '{path}': {reason(error)}), expected {EXPECTED}"]) from None
    if len(content) > most:
        raise ModelError([f"too large (got '{path}'), expected {EXPECTED}, of at most {most:,} bytes"])
    section = read_json(path, content, EXPECTED, _MOST)
    if not isinstance(section, dict):
        raise ModelError([f"{path}: not a section (got {got(section)}), expected {EXPECTED}"])
    return section


def text(section: Mapping[str, Any]) -> str:
    """Write a layout file with keys of a layout section: an entry a line."""
    parts = []
    for key, value in section.items():
        entries = [_json(item) for item in value] if isinstance(value, list) else None
        if isinstance(value, dict):
            entries = [f"{_json(name)}:{_json(item)}" for name, item in value.items()]
        begin, end = "{}" if isinstance(value, dict) else "[]"
        parts.append(f"{_json(key)}:" + (_json(value) if entries is None else begin + ",\n".join(entries) + end))
    return "{" + ",\n".join(parts) + "}\n"


def _json(value: Any) -> str:
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False)
