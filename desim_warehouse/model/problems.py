"""What is wrong with a model, in sentences that can be read aloud."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.model import outline
from desim_warehouse.model.places import Keys, Places, dotted

if TYPE_CHECKING:
    from pydantic import ValidationError
    from pydantic_core import ErrorDetails

_LONGEST = 50
_LARGE = 1e15


@dataclass(frozen=True)
class Problem:
    """One thing to put right: what is wrong at a key, and what is expected there."""

    keys: Keys
    text: str
    at_key: bool = False  # the key is wrong, not its value
    meant: str = ""  # the key that was probably meant
    missing: bool = False  # no such key is given; not reported where it is meant by an unknown one

    @classmethod
    def of(cls, keys: Keys, wrong: str, value: Any, expected: str) -> Problem:
        """What is wrong (got this), expected that."""
        return cls(keys, f"{wrong} (got {got(value)}), expected {expected}")


def report(problems: Iterable[Problem], places: Places) -> list[str]:
    """One line for each key with a problem, in the order of the file."""
    found = list(problems)
    meant = {problem.meant for problem in found}
    first: dict[Keys, Problem] = {}
    for problem in found:
        if not (problem.missing and dotted(problem.keys) in meant):
            first.setdefault(problem.keys, problem)
    lines = [(*places.line(keys, at_key=p.at_key), p.text) for keys, p in first.items()]
    lines.sort(key=lambda line: line[0])
    return [_one_line(f"{begin}: {text}") for _, begin, text in lines]


def _one_line(text: str) -> str:
    """The text with line ends and other unseen characters spelt out."""
    return "".join(char if char.isprintable() else repr(char)[1:-1] for char in text)


def got(value: Any) -> str:
    """A value as it stands in a model file, shortened."""
    said = _flow(value)
    return said if len(said) <= _LONGEST else f"{said[: _LONGEST - 4]} ..."


def _flow(value: Any) -> str:  # noqa: PLR0911 - a return for each kind of value
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    if isinstance(value, float) and value.is_integer() and abs(value) < _LARGE:
        return str(int(value))
    if isinstance(value, int) and abs(value) >= 10**_LONGEST:
        return f"a number of {len(str(abs(value)))} digits"
    if isinstance(value, Mapping):
        inner = ", ".join(f"{key}: {_inner(item)}" for key, item in list(value.items())[:_LONGEST])
        return f"{{{inner}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(_inner(item) for item in value[:_LONGEST])}]"
    return repr(value)


def _inner(value: Any) -> str:
    """A value in a list or a mapping: a plain word needs no quotes."""
    plain = isinstance(value, str) and re.fullmatch(r"[A-Za-z_][\w.-]*", value)
    return str(value) if plain else _flow(value)


def from_pydantic(error: ValidationError, under: Keys = ()) -> list[Problem]:
    """The problems that pydantic found, in our words."""
    errors = error.errors(include_url=False, include_context=False)
    # A list of which every entry is wrong is also too short to pydantic, which counts the right ones.
    return [_problem(item, under) for item in errors if item["type"] != "too_short" or not item["input"]]


_WRONG = {
    "int_type": "not a whole number",
    "int_from_float": "not a whole number",
    "float_type": "not a number",
    "finite_number": "not a finite number",
    "string_type": "not text",
    "string_too_short": "an empty name",
    "tuple_type": "not a list",
    "mapping_type": "not a section",
    "dict_type": "not a section",
    "model_type": "not a section",
    "literal_error": "unknown value",
    "greater_than": "too small",
    "greater_than_equal": "too small",
    "less_than": "too large",
    "less_than_equal": "too large",
    "too_short": "an empty list",
    "too_long": "too long a list",
}


def _problem(error: ErrorDetails, under: Keys) -> Problem:
    keys = under + tuple(key for key in error["loc"] if not (isinstance(key, str) and key.startswith("\0")))
    kind, value = error["type"], error["input"]
    at_key = bool(keys) and keys[-1] == "[key]"
    if at_key:
        keys = keys[:-1]
    if kind == "extra_forbidden":
        return unknown_key(keys)
    if kind == "missing" and isinstance(keys[-1], int):
        return Problem.of(keys[:-1], "too short a list", value, outline.expected(keys[:-1]))
    if kind == "missing":
        return Problem(keys, f"missing, expected {outline.expected(keys)}", missing=True)
    if at_key:
        return Problem.of(keys, "not a name", value, "a name")
    return _bad_value(keys, _WRONG.get(kind, "not understood"), value)


def _bad_value(keys: Keys, wrong: str, value: Any) -> Problem:
    expected = outline.expected(keys)
    if value is None:
        return Problem(keys, f"empty, expected {expected}")
    if wrong == "not a section" and not expected.startswith(("a section", "names")):
        wrong = "not understood"
    if isinstance(value, str):
        near = outline.nearest(value, outline.choices(keys))
        if near is not None:
            expected += f"; did you mean '{near}'?"
        elif wrong.endswith("number") and _numeric(value):
            expected += "; write it without quotes"
        elif wrong == "not a list" and value:
            expected += f"; write [{value}]"
    elif wrong == "not text" and not isinstance(value, list | tuple | Mapping):
        wrong = "not a name" if expected == "a name" else wrong
        expected += f"; write it in quotes: '{_flow(value)}'"
    elif wrong == "not a whole number" and isinstance(value, float):
        return Problem(keys, f"{wrong} (got {value!r}), expected {expected}")
    elif wrong == "not a number" and type(value) is int:
        wrong = "too large a number"
    return Problem.of(keys, wrong, value, expected)


def _numeric(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def unknown_key(keys: Keys) -> Problem:
    """A key that no model has, with the nearest one that can be."""
    near = outline.meant(keys)
    if near is not None:
        return Problem(keys, f"unknown key, did you mean '{near}'?", at_key=True, meant=near)
    known = outline.spoken(outline.keys_at(keys[:-1]), "or")
    return Problem(keys, f"unknown key, expected {known}", at_key=True)
