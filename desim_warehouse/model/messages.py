"""Messages about a file, one line for each value: where it stands, what is wrong, what is expected there.

The words are pydantic's where they are as clear to a planner as ours.
"""

from __future__ import annotations

import difflib
import itertools
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import did_you_mean, got, nearest, spoken, synonym, with_point
from desim_warehouse.values.fields import TOP

if TYPE_CHECKING:
    from pydantic import BaseModel, ValidationError
    from pydantic_core import ErrorDetails

Keys = tuple[str | int, ...]
"""The path to a value: keys of sections and ranks in lists, as in ("fleet", "start", 0)."""
Node = dict[str, Any]

_PAIR: dict[str | int, int] = {"from": 0, "to": 1}  # an edge may be written [A, B]
_MOST = 50
"""Problems that are told at once."""
_MORE: Keys = ("\0more",)
"""Where the number of problems that are not shown stands."""
_OURS = {
    "int_type": "should be a whole number",
    "int_from_float": "should be a whole number",
    "float_type": "should be a number",
    "string_type": "should be text",
    "string_too_short": "should not be empty",
    "string_unicode": "should be text that can be written in UTF-8",
    "tuple_type": "should be a list",
    "too_short": "should not be empty",
}
"""Where pydantic's words say Python rather than what stands in a file."""
_NUMBERS = {"int_type", "int_from_float", "float_type", "form"}
_SECTIONS = {"model_type", "mapping_type", "dict_type"}
_VERY_ALIKE = 0.8  # of 1, as difflib counts
_OPEN = {"additionalProperties": True}  # below the parameters of a policy anything can stand
_KINDS = {"integer": "a whole number", "number": "a number", "string": "text", "array": "a list"}


def dotted(keys: Keys) -> str:
    """Write the path to a value as people and overrides do: `fleet.start.0`."""
    return ".".join(str(key) for key in keys)


# Where values stand


@dataclass(frozen=True, order=True)
class Position:
    """A position that a message points to. FilePositions are ordered as a reader meets them."""

    rank: int  # the file first, then overrides and the tables it names
    line: int
    column: int
    text: str  # how a message names it
    names: int = field(default=0, compare=False)  # how many keys `text` stands for; 0: the message has them, too
    override: str = field(default="", compare=False)  # the key that an override sets, with which `text` ends

    @classmethod
    def in_file(cls, rank: int, file: str, line: int, column: int) -> Position:
        """Make the position of a line and a column of a file, both counted from 1."""
        return cls(rank, line, column, f"{file}:{line}:{column}")


@dataclass
class FilePositions:
    """Where the keys and values of one file were written: at a line and column, or in an override."""

    source: str
    keys: dict[Keys, Position] = field(default_factory=dict)
    values: dict[Keys, Position] = field(default_factory=dict)
    ranks: Iterator[int] = field(default_factory=lambda: itertools.count(1))

    def of(self, keys: Keys, *, at_key: bool = False) -> Position:
        """Return the position of a value (or of its key), or of the nearest section around it that has one."""
        for size in range(len(keys), -1, -1):
            part = keys[:size]
            if part and part[-1] in _PAIR and part not in self.keys:
                part = (*part[:-1], _PAIR[part[-1]])
            first, second = (self.values, self.keys) if size == len(keys) and not at_key else (self.keys, self.values)
            if position := first.get(part) or second.get(part):
                return position
        return Position(0, 0, 0, self.source)

    def line(self, keys: Keys, *, at_key: bool = False) -> tuple[Position, str]:
        """Return the position, and how a message begins: the position and the key, the key once only."""
        position, key = self.of(keys, at_key=at_key), dotted(keys)
        if position.names:  # ranks of values say nothing to a person who wrote 1..6
            key = dotted(tuple(key for key in keys[position.names :] if isinstance(key, str)))
        if position.override and f"{key}.".startswith(f"{position.override}."):
            return position, f"{position.text}{key.removeprefix(position.override)}"
        return position, f"{position.text}: {key}" if key else position.text

    def of_override(self, named: str, key: str) -> Position:
        """Return the position of an override of a key, as messages name it: `--set fleet.size`."""
        return Position(next(self.ranks), 0, 0, f"{named} {key}", override=key)

    def overridden(self, keys: Keys, position: Position) -> None:
        """Note that the value at `keys` and all in it were set at a position outside the file."""
        for written in (self.keys, self.values):
            for stale in [other for other in written if other[: len(keys)] == keys]:
                del written[stale]
            written[keys] = position

    def given(self, keys: Keys, option: str) -> None:
        """Note that the value at `keys` was given by an option of the command line, which messages name instead."""
        self.overridden(keys, Position(next(self.ranks), 0, 0, option, len(keys)))


# What is wrong


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
        """Make a problem that says what is wrong, the value, and what is expected."""
        return cls(keys, f"{wrong} (got {got(value)}), expected {expected}")


def report(problems: Iterable[Problem], positions: FilePositions) -> list[str]:
    """Write one line for each key with a problem, in the order of the file."""
    all_problems = list(problems)
    meant = {problem.meant for problem in all_problems}
    first: dict[Keys, Problem] = {}
    for problem in all_problems:
        if not (problem.missing and dotted(problem.keys) in meant):
            first.setdefault(problem.keys, problem)
    more = first.pop(_MORE, None)
    lines = [(*positions.line(keys, at_key=p.at_key), p.text) for keys, p in first.items()]
    lines.sort(key=lambda line: line[0])
    return [printable(f"{begin}: {text}") for _, begin, text in lines] + ([more.text] if more else [])


def moved(text: str, override: str, place: str) -> str | None:
    """Return a message about a value that an override set, or about one in it, at another place; None about others.

    A wrong `lvl` in `override policies.charging` is told at `study.yaml:4:9: factors.policies.charging.0.lvl`.
    """
    rest = text.removeprefix(override)
    return f"{place}{rest}" if rest != text and rest.startswith((".", ": ")) else None


def printable(text: str) -> str:
    """Spell out line ends and other unseen characters of a text."""
    return "".join(char if char.isprintable() else repr(char)[1:-1] for char in text)


def from_pydantic(error: ValidationError, outline: Outline, under: Keys = ()) -> list[Problem]:
    """Return the problems that pydantic found with values at `under`, with their cures."""
    # A list whose every entry is wrong is also too short to pydantic, which counts the right ones.
    items = [item for item in error.errors(include_url=False) if item["type"] != "too_short" or not item["input"]]
    problems = [_filled_in(_problem(item, outline, under), outline) for item in items[:_MOST]]
    if len(items) > _MOST:
        problems.append(Problem(_MORE, f"and {len(items) - _MOST:,} more problems"))
    return problems


def _problem(error: ErrorDetails, outline: Outline, under: Keys) -> Problem:
    kind, value, context = error["type"], error["input"], error.get("ctx", {})
    steps = (*under, *error["loc"], *context.get("below", ()))
    steps = steps[steps.index(TOP) + 1 :] if TOP in steps else steps
    at_key = bool(steps) and steps[-1] == "[key]"
    keys = tuple(step for step in steps[: len(steps) - at_key] if not str(step).startswith("\0"))
    if kind == "wrong":
        return Problem(keys, error["msg"], at_key)
    if kind == "extra_forbidden":
        return outline.unknown_key(keys)
    if kind == "missing" and isinstance(keys[-1], str):
        return Problem(keys, f"missing, expected {outline.expected(keys)}", missing=True)
    if kind in {"missing", "too_long"}:
        keys = keys[:-1] if kind == "missing" else keys
        return Problem(keys, f"should have {outline.entries(keys)} (got {got(value)}){_commas(value)}")
    if kind in _SECTIONS:
        complaint = f"should be {outline.section(keys)}"
    elif kind == "float_type" and type(value) is int:
        complaint = "too large a number"
    else:
        complaint = _OURS.get(kind, error["msg"].removeprefix("Input "))
    shown = repr(value) if kind == "int_type" and isinstance(value, float) else got(value)  # 2.0, not 2
    return Problem(keys, f"{complaint} (got {shown}){_cure(kind, value, context)}", at_key)


def _filled_in(problem: Problem, outline: Outline) -> Problem:
    """Add what to do about a key without a value to its problem."""
    if not problem.text.endswith("(got nothing)"):
        return problem
    cure = "; write one, or leave the key out" if outline.may_lack(problem.keys) else "; write one"
    return replace(problem, text=problem.text + cure)


def _cure(kind: str, value: Any, context: Mapping[str, Any]) -> str:
    """Return the words that say what to write instead, where the wrong value shows it; else an empty text."""
    if isinstance(value, str):
        if hint := did_you_mean(value, re.findall(r"'(.*?)'", context.get("expected", ""))):
            return hint
        if kind in _NUMBERS and (_numeric(value) or with_point(value)):
            return "; write it without quotes" if _numeric(value) else f"; a decimal comma? write {with_point(value)}"
        if kind == "tuple_type" and value:
            return f"; write [{value}]"
    elif kind == "int_type" and isinstance(value, float) and got(value).isdecimal():
        return f"; write {got(value)}"
    elif kind == "string_type" and isinstance(value, bool | int | float):
        return f"; write it in quotes: '{got(value)}'"
    return ""


def _commas(values: Any) -> str:
    """Return the hint that a decimal comma makes two entries of a number; empty for a list of anything else."""
    first = values[:2] if isinstance(values, list) else []
    return f"; decimals have a point: {first[0]}.{first[1]}" if [*map(type, first)] == [int, int] else ""


def _numeric(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


# Which keys there are


class Outline:
    """The keys that a file can have, read off the JSON Schema of its model."""

    def __init__(self, model: type[BaseModel]) -> None:
        self._model = model

    @property
    def schema(self) -> Node:
        """The JSON Schema, which is shared and must not be changed."""
        return _schema(self._model)

    def has(self, keys: Keys) -> bool:
        """Whether a file can have such a key."""
        return bool(self._at(keys))

    def may_lack(self, keys: Keys) -> bool:
        """Whether a section can do without a key; an entry of a list is none."""
        needed = (form.get("required", ()) for form in self._at(keys[:-1]))
        return isinstance(keys[-1] if keys else 0, str) and not any(keys[-1] in names for names in needed)

    def keys_at(self, keys: Keys) -> list[str]:
        """Return the keys that a section can have."""
        return list(dict.fromkeys(key for form in self._at(keys) for key in form.get("properties", {})))

    def expected(self, keys: Keys) -> str:
        """Return the words that say what a missing key expects, and what it means."""
        node = next(step for form in self._at(keys[:-1]) for step in self._step(form, keys[-1]))
        if "errorMessage" in node:
            return str(node["errorMessage"]).removeprefix("expected ")
        kind = next(self._forms(node)).get("type")
        return self.section(keys) if kind == "object" else f"{_KINDS[str(kind)]} ({node['description']})"

    def section(self, keys: Keys) -> str:
        """Describe a section in words, with the keys that it must have, or else can have."""
        needed = dict.fromkeys(key for form in self._at(keys) for key in form.get("required", ()))
        return f"a section with {spoken(needed or self.keys_at(keys) or ['names', 'what each stands for'])}"

    def entries(self, keys: Keys) -> str:
        """Return the words that say how many entries a list must have, and what they mean: `2 entries, x and y`."""
        node = next(form for form in self._at(keys) if "maxItems" in form)
        return f"{node['maxItems']} entries" + (f", {node['description']}" if "description" in node else "")

    def unknown_key(self, keys: Keys) -> Problem:
        """Report a key that no such file has, with the nearest valid one, or a key of another form of its section."""
        forms = [form for form in self._at(keys[:-1]) if keys[-1] in form.get("properties", {})]
        if forms:
            others = " or ".join(spoken(form.get("required") or form["properties"]) for form in forms)
            return Problem(keys, f"not in this form, expected only in a section with {others}", at_key=True)
        near = self.meant(keys)
        if near is not None:
            return Problem(keys, f"unknown key, did you mean '{near}'?", at_key=True, meant=near)
        beside = self.keys_at(keys[:-1])
        rest = f", expected {spoken(beside, 'or')}" if beside else f": '{dotted(keys[:-1])}' has no keys below it"
        return Problem(keys, f"unknown key{rest}", at_key=True)

    def named(self, word: str) -> str | None:
        """Return the key that has a name, or that people call so, wherever it is."""
        every = list(self._below(()))
        return synonym(word, every) or min((key for key in every if key.endswith(f".{word}")), key=len, default=None)

    def meant(self, keys: Keys) -> str | None:
        """Return the key most like an unknown one: beside it, with the same name elsewhere, or called so."""
        *parents, last = keys
        if not parents and (called := self.named(str(last))):
            return called
        beside = nearest(str(last), self.keys_at(tuple(parents)))
        if beside is not None:
            return dotted((*parents, beside))
        every = list(self._below(()))
        leaves = [key.rpartition(".")[2] for key in every]
        leaf = next(iter(difflib.get_close_matches(str(last), leaves, n=1, cutoff=_VERY_ALIKE)), None)
        same = [key for key, name in zip(every, leaves, strict=True) if name == leaf]
        return max(same, key=lambda key: difflib.SequenceMatcher(None, key, dotted(keys)).ratio(), default=None)

    def _below(self, keys: Keys) -> Iterator[str]:
        for key in self.keys_at(keys):
            yield dotted((*keys, key))
            yield from self._below((*keys, key))

    def _at(self, keys: Keys) -> list[Node]:
        """Return the forms that a value can have."""
        forms = list(self._forms(self.schema))
        for key in keys:
            forms = [form for node in forms for step in self._step(node, key) for form in self._forms(step)]
        return forms

    def _step(self, node: Node, key: str | int) -> Iterator[Node]:
        if node.get("type") == "array" and str(key).isdecimal():
            yield node.get("items") or node["prefixItems"][0]
        elif key in node.get("properties", {}):
            yield node["properties"][key]
        elif node.get("additionalProperties"):
            yield _OPEN if node["additionalProperties"] is True else node["additionalProperties"]

    def _forms(self, node: Node) -> Iterator[Node]:
        if "$ref" in node:
            yield from self._forms(self.schema["$defs"][node["$ref"].rsplit("/", 1)[1]])
        elif "anyOf" in node or "oneOf" in node:
            for form in (*node.get("anyOf", ()), *node.get("oneOf", ())):
                yield from self._forms(form)
        elif node.get("type") != "null":
            yield node


@cache
def _schema(model: type[BaseModel]) -> Node:
    return model.model_json_schema()
