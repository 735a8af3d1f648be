"""The policies by name, ours and the user's own, with their parameters from the model file."""

from __future__ import annotations

import dataclasses
import importlib
import importlib.util
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from desim_warehouse.errors import PolicyError

OURS: dict[str, dict[str, str]] = {
    "allocation": {"in-order": "allocation:InOrder"},
    "routing": {"highways": "routing:Highways"},
    "charging": {"threshold": "charging:Threshold"},
    "parking": {"home": "parking:Home"},
}
METHODS = {"allocation": "assign", "routing": "route", "charging": "recall_level", "parking": "choose"}


def find(kind: str, name: str) -> type:
    """The class of a policy: one of ours by its bare name, or the user's own as `module:Class` or `file.py:Class`."""
    ours = OURS[kind]
    if ":" not in name:
        if name not in ours:
            raise PolicyError(
                f"policies.{kind}: no policy {name!r}; there are {', '.join(sorted(ours))}, "
                "or your own as module:Class or file.py:Class"
            )
        module, _, cls = ours[name].partition(":")
        return getattr(importlib.import_module(f"desim_warehouse.policies.{module}"), cls)
    place, _, cls = name.rpartition(":")
    found = getattr(_module(kind, place), cls, None)
    if not isinstance(found, type) or not callable(getattr(found, METHODS[kind], None)):
        raise PolicyError(f"policies.{kind}: {name}: no class {cls} with a method {METHODS[kind]}()")
    return found


def _module(kind: str, place: str) -> Any:
    try:
        if not place.endswith(".py"):
            return importlib.import_module(place)
        path = Path(place).resolve()
        label = f"desim_policies_{abs(hash(str(path))):x}"
        if label in sys.modules:
            return sys.modules[label]
        spec = importlib.util.spec_from_file_location(label, path)
        if spec is None or spec.loader is None or not path.is_file():
            raise PolicyError(f"policies.{kind}: no file {place}")
        module = importlib.util.module_from_spec(spec)
        sys.modules[label] = module
        spec.loader.exec_module(module)
    except PolicyError:
        raise
    except Exception as error:
        raise PolicyError(f"policies.{kind}: {place} cannot be loaded: {error!r}") from error
    return module


def create(kind: str, name: str, parameters: Mapping[str, Any]) -> Any:
    """The policy itself, with its parameters."""
    cls = find(kind, name)
    known = {field.name for field in dataclasses.fields(cls)} if dataclasses.is_dataclass(cls) else set()
    unknown = sorted(set(parameters) - known)
    if unknown:
        takes = f"it takes {', '.join(sorted(known))}" if known else "it takes none"
        raise PolicyError(f"policies.{kind}: {name} has no parameter {unknown[0]!r}; {takes}")
    try:
        return cls(**parameters)
    except (TypeError, ValueError) as error:
        raise PolicyError(f"policies.{kind}: {name}: {error}") from error
