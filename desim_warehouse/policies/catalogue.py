"""The policies by name, the package's and the user's own, with their parameters from the model file."""

from __future__ import annotations

import dataclasses
import importlib
import importlib.util
import inspect
import sys
import zlib
from collections.abc import Mapping
from functools import cache, lru_cache
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any, get_type_hints

from desim_warehouse.errors import PASSED_ON, PolicyError, got, nearest, shown
from desim_warehouse.policies.protocols import RobotView

OURS: dict[str, dict[str, str]] = {
    "allocation": {
        "in-order": "allocation:InOrder",
        "nearest": "allocation:Nearest",
        "nearest-aging": "allocation:NearestAging",
        "earliest-due": "allocation:EarliestDue",
        "hungarian": "allocation:Hungarian",
        "regret": "queues:Regret",
        "auction": "queues:Auction",
        "cost-aware": "allocation:CostAware",
    },
    "routing": {
        "highways": "routing:Highways",
        "shortest": "routing:Shortest",
        "fastest": "routing:Fastest",
        "congestion-aware": "routing:CongestionAware",
    },
    "charging": {
        "threshold": "charging:Threshold",
        "reach-aware": "charging:ReachAware",
        "opportunity": "charging:Opportunity",
        "four-thresholds": "charging:FourThresholds",
        "swap": "charging:Swap",
    },
    "parking": {
        "home": "parking:Home",
        "stay": "parking:Stay",
        "nearest": "parking:NearestBay",
        "spread": "parking:Spread",
        "where-it-is": "parking:WhereItIs",
    },
    "batching": {
        "single": "batching:Single",
        "fixed-size": "batching:FixedSize",
        "time-window": "batching:TimeWindow",
        "by-order": "batching:ByOrder",
    },
    "pod": {"nearest": "pods:NearestPod", "most-lines": "pods:MostLines", "random": "pods:RandomPod"},
    "storage": {
        "nearest": "pods:NearestPlace",
        "own": "pods:OwnPlace",
        "random": "pods:RandomPlace",
        "by-turnover": "pods:ByTurnover",
    },
    "order_station": {"fewest-orders": "pods:FewestOrders", "most-lines-in-common": "pods:MostLinesInCommon"},
    "put": {"emptiest": "pods:Emptiest", "random": "pods:AnyPod"},
}
METHODS = {
    "allocation": "assign",
    "routing": "route",
    "charging": "levels",
    "parking": "choose",
    "batching": "batches",
    **dict.fromkeys(("pod", "storage", "order_station", "put"), "choose"),
}


class _RefusedError(Exception):
    """Raised if a policy cannot be created, with the parameter at fault ("" for the name) and the reason."""

    def __init__(self, parameter: str, message: str) -> None:
        super().__init__(parameter, message)
        self.parameter = parameter
        self.message = message


def find(kind: str, name: str) -> type:
    """Find the class of a policy: ours by its bare name, the user's as `module:Class` or `file.py:Class`.

    Raises PolicyError where there is none.
    """
    try:
        return _find(kind, name)
    except _RefusedError as refused:
        raise PolicyError(f"policies.{kind}: {refused.message}") from refused.__cause__


def create(kind: str, name: str, parameters: Mapping[str, Any]) -> Any:
    """Create a policy with its parameters; raises PolicyError if that is impossible."""
    policy, faults = _attempt(kind, name, parameters)
    if faults:
        parameter, message = faults[0]
        raise PolicyError(f"policies.{kind}{'.' if parameter else ''}{parameter}: {message}")
    return policy


def problems(kind: str, name: str, parameters: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the problems of a policy as named in a model: pairs of parameter ("" for the name) and message."""
    return _attempt(kind, name, parameters)[1]


def _attempt(kind: str, name: str, parameters: Mapping[str, Any]) -> tuple[Any, list[tuple[str, str]]]:
    """Create a policy, with no problems; or return None and all problems as pairs of parameter and message."""
    try:
        cls = _find(kind, name)
    except _RefusedError as refused:
        return None, [(refused.parameter, refused.message)]
    accepted = parameters_of(cls)
    faults = [(key, _unknown(name, key, accepted)) for key in parameters if key not in accepted]
    for key, (hint, default) in accepted.items():
        if key not in parameters:
            if default is dataclasses.MISSING:
                faults.append((key, f"missing, {name} must have it"))
        elif not _fits(parameters[key], hint):
            faults.append((key, f"not understood (got {got(parameters[key])}), expected {_type_in_words(hint)}"))
    if faults:
        return None, faults
    try:
        return cls(**parameters), []
    except PASSED_ON:
        raise
    except BaseException as error:  # noqa: BLE001 - whatever a user's class raises is reported at its place
        message = str(error) or repr(error)
        parameter = next((key for key in parameters if message.startswith(key)), "")
        return None, [(parameter, f"{name}: {message}")]


@lru_cache(maxsize=64)  # every run creates its policies: their types are read once
def parameters_of(cls: type) -> dict[str, tuple[Any, Any]]:
    """Return type and default (dataclasses.MISSING: none) of every parameter of a policy, in the order of fields."""
    if not dataclasses.is_dataclass(cls):
        return {}
    try:
        hints = get_type_hints(cls)
    except Exception:  # noqa: BLE001 - types that do not exist at run time are not checked
        hints = {}
    return {
        field.name: (
            hints.get(field.name, Any),
            field.default if field.default_factory is dataclasses.MISSING else field.default_factory(),
        )
        for field in dataclasses.fields(cls)
        if field.init
    }


@lru_cache(maxsize=64)
def quantities_of(kind: str, name: str) -> dict[str, str]:
    """Return the parameters of a policy of ours that are written with a unit, and its kind: `{"window": "time"}`.

    Parameters of a user's policy are unknown before its code is run.
    """
    return {key: note.kind for key, note in notes_of(kind, name) if hasattr(note, "kind")}


def title_of(kind: str, name: str) -> str | None:
    """Return the everyday name of a policy of ours, its class attribute `title`; None without one."""
    return vars(_imported(OURS[kind][name])).get("title") if name in OURS.get(kind, {}) else None


@lru_cache(maxsize=64)
def notes_of(kind: str, name: str) -> tuple[tuple[str, Any], ...]:
    """Return the notes beside the types of parameters of a policy of ours: kinds of units, and usual values."""
    if name not in OURS[kind]:
        return ()
    hints = get_type_hints(_find(kind, name), include_extras=True)
    return tuple((key, note) for key, hint in hints.items() for note in getattr(hint, "__metadata__", ()))


def reads_threshold(name: str, parameters: Mapping[str, Any]) -> bool:
    """Whether the levels of a charging policy depend on the battery's threshold, tested with two thresholds.

    A user's own policy counts as dependent, and one that cannot be created does not.
    """
    if ":" in name:
        return True
    policy, faults = _attempt("charging", name, parameters)
    low, high = (RobotView(0, "", "", 1.0, 1.0, threshold) for threshold in (0.25, 0.5))
    return not faults and policy.levels(low) != policy.levels(high)


def resolved(name: str, folder: Path) -> str:
    """Return the name with the full path of a policy file, relative to the model's folder or the working folder."""
    place, _, cls = name.rpartition(":")
    if not place.endswith(".py"):
        return name
    for base in (folder, Path()):
        if _is_file(base / place):
            return f"{(base / place).resolve()}:{cls}"
    return name


def _is_file(path: Path) -> bool:
    """Whether the file exists; False for a name that no file can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def resolved_in(value: Any, folder: Path) -> Any:
    """Return a part of a study with full paths of all policy files, relative to the study's folder."""
    if isinstance(value, Mapping):
        return {key: resolved_in(item, folder) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [resolved_in(item, folder) for item in value]
    return resolved(value, folder) if isinstance(value, str) and ".py:" in value else value


def source_of(kind: str, name: str) -> str:
    """Return the source text of a policy's class; raises PolicyError where it cannot be read."""
    return inspect.getsource(find(kind, name))


def user_source(name: str) -> bytes:
    """Return the content of the file of a user's policy, without running it; empty for our policies."""
    place, _, _ = name.rpartition(":")
    if not place:
        return b""
    file = Path(place) if place.endswith(".py") else _module_file(place)
    return file.read_bytes() if file is not None and _is_file(file) else b""


def _module_file(name: str) -> Path | None:
    """Return the file of a module; unlike `importlib.util.find_spec`, without importing the packages around it."""
    folders, whole, spec = None, "", None
    for part in name.split("."):
        whole = f"{whole}.{part}" if whole else part
        try:
            spec = PathFinder.find_spec(whole, folders)
        except (ImportError, ValueError):
            return None
        if spec is None or (whole != name and spec.submodule_search_locations is None):
            return None
        folders = spec.submodule_search_locations
    return Path(spec.origin) if spec is not None and spec.origin else None


def _find(kind: str, name: str) -> type:
    ours = OURS[kind]
    if ":" not in name:
        if name not in ours:
            near = nearest(name, ours)
            hint = f"did you mean {near!r}? " if near else ""
            every = ", ".join(ours)
            expected = f"{hint}expected one of {every}, or your own as module:Class or file.py:Class"
            raise _RefusedError("", f"no such policy (got {name!r}), {expected}")
        return _imported(ours[name])
    place, _, cls = name.rpartition(":")
    module = _module(place)
    own = getattr(module, cls, None)
    if not isinstance(own, type):
        classes = [key for key, value in vars(module).items() if isinstance(value, type)]
        near = nearest(cls, classes)
        hint = f", did you mean {near!r}?" if near else ""
        raise _RefusedError("", f"no class {cls!r} in {place}{hint}")
    if not callable(getattr(own, METHODS[kind], None)):
        needed = f"the class has no method {METHODS[kind]}(), which policies.{kind} needs"
        raise _RefusedError("", f"{name}: {needed}{_defined(own)}")
    return own


def _defined(cls: type) -> str:
    """Return the place of a class that was read from a file."""
    try:
        return f" ({inspect.getsourcefile(cls)}, line {inspect.getsourcelines(cls)[1]})"
    except (OSError, TypeError):
        return ""


@cache
def _imported(place: str) -> type:
    """Return a class of ours, by its module and name."""
    module, _, cls = place.partition(":")
    policy_class: type = getattr(importlib.import_module(f"desim_warehouse.policies.{module}"), cls)
    return policy_class


def _module(place: str) -> Any:
    path = Path(place)
    if not place.endswith(".py") and not all(part.isidentifier() for part in place.split(".")):
        raise _RefusedError("", f"no module (got {place!r}), expected module:Class or file.py:Class")
    if place.endswith(".py") and not _is_file(path):
        raise _RefusedError("", f"no file {place}, neither beside the model file nor in {Path.cwd()}")
    try:
        if not place.endswith(".py"):
            return importlib.import_module(place)
        path = path.resolve()
        label = f"desim_policies_{zlib.crc32(path.read_bytes()):08x}_{zlib.crc32(str(path).encode()):08x}"
        if label in sys.modules:
            return sys.modules[label]
        spec = importlib.util.spec_from_file_location(label, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[label] = module
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[label]
            raise
    except PASSED_ON:
        raise
    except BaseException as error:
        raise _RefusedError("", f"{place} cannot be loaded: {shown(error)}") from error
    return module


def _unknown(name: str, key: str, accepted: Mapping[str, Any]) -> str:
    near = nearest(key, accepted)
    if near:
        return f"unknown parameter of {name}, did you mean {near!r}?"
    return f"unknown parameter of {name}, expected {', '.join(accepted) if accepted else 'none'}"


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value is of a plain type (a number, text, a choice of these); others are left to the policy."""
    from pydantic import TypeAdapter, ValidationError

    if hint is Any or isinstance(value, tuple | Mapping):
        return True
    try:
        TypeAdapter(hint).validate_python(value, strict=True)
    except ValidationError:
        return False
    except Exception:  # noqa: BLE001 - a type that pydantic does not know
        return True
    return True


def _type_in_words(hint: Any) -> str:
    names = {int: "a whole number", float: "a number", str: "text", bool: "true or false"}
    return names.get(hint, str(hint).replace("typing.", "").replace("None", "nothing"))
