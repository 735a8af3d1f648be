"""Digests of functions by what they compute: equal for equal functions, in another process too.

A function counts by its code, its defaults, the values that it closes over, and the functions, classes and constants
that it uses by name, each looked into in the same way; so do methods, and objects that can be called. What is installed
or part of Python counts by its name.
"""

from __future__ import annotations

import copyreg
import dis
import functools
import hashlib
import pickle
import secrets
import sys
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, GetSetDescriptorType, ModuleType, SimpleNamespace
from typing import Any

_LENGTH = 12
_PROTOCOL = 5
_CODE = (
    *("co_code", "co_exceptiontable", "co_consts", "co_names", "co_varnames", "co_freevars", "co_cellvars"),
    *("co_flags", "co_argcount", "co_posonlyargcount", "co_kwonlyargcount"),
)
"""Attributes of code that say what it does, unlike those with its lines and its file."""
_GLOBAL = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS")
_ATTRIBUTE = ("LOAD_ATTR", "LOAD_METHOD")
_CACHED = type(functools.cache(len))
_KEPT = {"_abc_impl"}
"""What Python keeps with a class under a name without underscores at its end."""
_INSTALLED = {"site-packages", "dist-packages"}


def digest_of(value: object) -> str:
    """Return the digest of a value; a random one, equal to no other, if its content cannot be determined."""
    content = hashlib.sha256()
    try:
        _Content(content.update).dump(value)
    except Exception:  # noqa: BLE001 - whatever objects of the user's own raise
        return secrets.token_hex(_LENGTH // 2)
    return content.hexdigest()[:_LENGTH]


class _Content(pickle.Pickler):
    """A pickler for digests: functions and classes are written by content, sets in order, and equal values alike."""

    def __init__(self, write: Callable[[bytes], object]) -> None:
        super().__init__(SimpleNamespace(write=write), protocol=_PROTOCOL)
        self.fast = True  # an object is written in full each time, so that copies of it are no different
        self.begun: list[object] = []  # functions and classes, which may use themselves

    def persistent_id(self, value: Any) -> object:
        """Return what is written for a value; None for what pickle writes."""
        content: object = None
        if type(value) is set or type(value) is frozenset:
            content = "set", sorted(map(digest_of, value))
        elif isinstance(value, CodeType):
            content = "code", [getattr(value, name) for name in _CODE]
        elif isinstance(value, staticmethod | classmethod | _CACHED):
            content = type(value), value.__wrapped__
        elif isinstance(value, functools.cached_property):
            content = type(value), value.func
        elif isinstance(value, property):
            content = property, value.fget, value.fset, value.fdel
        elif isinstance(value, ModuleType):
            content = "module", _installed(value.__name__)
        elif isinstance(value, FunctionType | type) and not _has_installed_name(value):
            ranks = [rank for rank, other in enumerate(self.begun) if other is value]
            if ranks:
                return "again", ranks
            self.begun.append(value)
            content = _of_function(value) if isinstance(value, FunctionType) else _of_class(value)
        return content

    def reducer_override(self, value: Any) -> Any:
        """Return how an object is pickled; raise PicklingError for one of the user's that counts by its name alone."""
        if isinstance(value, FunctionType | BuiltinFunctionType | type) or type(value) in copyreg.dispatch_table:
            return NotImplemented
        reduced = value.__reduce_ex__(_PROTOCOL)
        if isinstance(reduced, str):
            _installed(value.__module__)
        return reduced


def _of_function(function: FunctionType) -> tuple[object, ...]:
    closed = [cell.cell_contents for cell in function.__closure__ or ()]
    defaults = function.__defaults__, function.__kwdefaults__
    return "function", function.__code__, defaults, closed, function.__dict__, _globals_of(function)


def _of_class(kind: type) -> tuple[object, ...]:
    """Return the content of a class: its bases and attributes, but for those that Python keeps with every class."""
    attributes = {
        name: value
        for name, value in vars(kind).items()
        if _is_method(value) or not (name in _KEPT or (name.startswith("__") and name.endswith("__")))
    }
    return "class", kind.__qualname__, type(kind), kind.__bases__, attributes


def _is_method(value: object) -> bool:
    """Whether an attribute of a class does something: it is called, or computes what is read."""
    if isinstance(value, type | GetSetDescriptorType):
        return False
    return callable(value) or hasattr(type(value), "__get__")


def _globals_of(function: FunctionType) -> dict[str, object]:
    """Return the globals that a function uses, by name; of modules of the user's the parts used: `helpers.mean`."""
    used: dict[str, object] = {}
    for code in _codes(function.__code__):
        steps = [step for step in dis.get_instructions(code) if step.opname != "EXTENDED_ARG"]
        for number, step in enumerate(steps):
            if step.opname == "IMPORT_NAME":
                _installed(step.argval)
            elif step.opname in _GLOBAL and step.argval in function.__globals__:
                name, value = step.argval, function.__globals__[step.argval]
                for part in steps[number + 1 :]:
                    if part.opname not in _ATTRIBUTE or not _is_of_the_user(value) or not hasattr(value, part.argval):
                        break
                    name, value = f"{name}.{part.argval}", getattr(value, part.argval)
                used[name] = value
    return used


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Iterate over code and the code of functions and classes in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _is_of_the_user(value: object) -> bool:
    """Whether a value is a module that is neither installed nor a part of Python or of this package."""
    return isinstance(value, ModuleType) and not _is_installed(value.__name__)


def _installed(module: str) -> str:
    """Return the name of an installed module; raise PicklingError for one of the user's."""
    if not _is_installed(module):
        raise pickle.PicklingError(f"module {module}: not known which parts of it are used")
    return module


def _is_installed(module: str) -> bool:
    """Whether a module is installed, or a part of Python or of this package."""
    top = module.partition(".")[0]
    if top in sys.stdlib_module_names or top == __name__.partition(".")[0]:
        return True
    try:
        spec = None if top == "__main__" else find_spec(top)
    except (ImportError, ValueError):
        return False
    places = [] if spec is None else [spec.origin or "", *(spec.submodule_search_locations or ())]
    return any(_INSTALLED.intersection(Path(place).parts) for place in places)


def _has_installed_name(value: FunctionType | type) -> bool:
    """Whether a function or class is what a module that is installed calls by its name."""
    if not isinstance(value.__module__, str) or not _is_installed(value.__module__):
        return False
    named: object = sys.modules.get(value.__module__)
    for part in value.__qualname__.split("."):
        named = getattr(named, part, None)
    return named is value
