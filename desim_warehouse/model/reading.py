"""First working draft; error places follow."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from desim_warehouse.errors import ModelError
from desim_warehouse.model.schema import Model


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return value


def load(source: str | Path | Mapping[str, Any], overrides: Mapping[str, Any] | None = None) -> Model:
    """Read a model from a file or a mapping."""
    if isinstance(source, Mapping):
        data = _plain(source)
    else:
        from ruamel.yaml import YAML

        data = YAML(typ="safe", pure=True).load(Path(source).read_text(encoding="utf-8"))
    for key, value in (overrides or {}).items():
        node = data
        *parents, last = key.split(".")
        for part in parents:
            if isinstance(node, list):
                node = node[int(part)]
            else:
                child = node.setdefault(part, {})
                if isinstance(child, str):
                    child = node[part] = {"name": child}
                node = child
        if isinstance(node, list):
            node[int(last)] = copy.deepcopy(value)
        else:
            node[last] = copy.deepcopy(value)
    try:
        return Model.model_validate(data)
    except ValidationError as error:
        raise ModelError([f"{source}: {'.'.join(map(str, e['loc']))}: {e['msg']} (got {e['input']!r})" for e in error.errors()]) from None


def parse_assignment(text: str) -> tuple[str, Any]:
    """Split `KEY=VALUE`."""
    from ruamel.yaml import YAML

    key, sep, value = text.partition("=")
    if not sep:
        raise ModelError([f"--set {text}: no '='"])
    return key.strip(), YAML(typ="safe", pure=True).load(value)


def json_schema() -> dict[str, Any]:
    """The JSON Schema of model files."""
    return Model.model_json_schema()
