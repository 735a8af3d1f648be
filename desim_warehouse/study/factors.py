"""Factors: what a study varies, and the values it takes, as people write them and as tables show them."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from desim_warehouse.model import outline
from desim_warehouse.model.problems import Problem, got

Keys: TypeAlias = tuple[str | int, ...]
Label: TypeAlias = str | int | float | bool | None

FORMS = ("named", "cases", "range", "linspace", "between")
EXPECTED = "a list of values, a range such as 1..6, or a section with " + outline.spoken(FORMS, "or")
_RANGE = re.compile(r"\s*([+-]?[\d.]+?)\.\.([+-]?\d[\d.]*?)(?:\.\.(\d[\d.]*))?\s*")
_MOST = 100_000  # values of one factor
_DIGITS = 12  # of a value of a range: 0.3, not 0.30000000000000004
RESERVED = ("replication", "seed", "deterministic", "run_time", "error")


@dataclass(frozen=True)
class Level:
    """One value of a factor: what tables show, and what it changes in the model."""

    label: Label
    overrides: Mapping[str, Any]
    keys: Keys  # where it stands in the study file


@dataclass(frozen=True)
class Between:
    """A range that sampled designs draw from; `whole` numbers only, or any."""

    low: float
    high: float
    whole: bool


@dataclass(frozen=True)
class Factor:
    """What is varied: a key of the model (or a name, for `cases`), and its values or its range."""

    key: str
    levels: tuple[Level, ...] = field(default=())
    between: Between | None = None

    def level(self, label: Label, keys: Keys) -> Level:
        """A value drawn from the range."""
        return Level(label, {self.key: label}, keys)


def label(value: Any) -> Label:
    """What a table shows for a value: numbers and words as they are, a policy as `name(parameter=1)`."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Mapping) and isinstance(value.get("name"), str):
        rest = ", ".join(f"{key}={item}" for key, item in value.items() if key != "name")
        name = value["name"].replace("\\", "/").rpartition("/")[2]  # the user's own: my_policies.py:Patient
        return f"{name}({rest})" if rest else name
    return json.dumps(value, ensure_ascii=False)


def read_factor(key: str, spec: Any, problems: list[Problem]) -> Factor | None:
    """The factor that a study file describes; what is wrong with it goes to `problems`."""
    here: Keys = ("factors", key)
    if not isinstance(spec, Mapping) and isinstance(spec, bool | int | float):
        spec = [spec]
    if isinstance(spec, str) and not _RANGE.fullmatch(spec):
        problems.append(Problem.of(here, "not understood", spec, f"{EXPECTED}; write [{spec}]"))
        return None
    form = next(iter(spec), None) if isinstance(spec, Mapping) and len(spec) == 1 else None
    if isinstance(spec, str | Sequence):
        form, spec = "values", {"values": spec}
    if form not in (*FORMS, "values"):
        problems.append(_not_a_form(here, spec))
        return None
    if form == "cases":
        return _cases(key, spec["cases"], problems)
    if not outline.known(tuple(_steps(key))):
        problems.append(_no_such_key(here, key))
        return None
    if form == "between":
        between = _between(spec["between"], (*here, "between"), problems)
        return Factor(key, between=between) if between else None
    where = here if form == "values" else (*here, form)
    levels = tuple(_levels(key, form, spec[form], where, problems))
    _no_twice(levels, where, problems)
    return Factor(key, levels) if levels else None


def _steps(key: str) -> Iterator[str | int]:
    """The keys of a dotted key; numbers are ranks in lists."""
    for part in key.split("."):
        yield int(part) if part.isdecimal() else part


def _not_a_form(here: Keys, spec: Any) -> Problem:
    if isinstance(spec, Mapping) and len(spec) == 1:
        word = str(next(iter(spec)))
        near = outline.nearest(word, FORMS)
        hint = f"did you mean '{near}'?" if near else f"expected {outline.spoken(FORMS, 'or')}"
        return Problem((*here, word), f"unknown key, {hint}", at_key=True)
    return Problem.of(here, "not understood", spec, EXPECTED)


def _no_such_key(here: Keys, key: str) -> Problem:
    near = outline.meant(tuple(_steps(key)))
    hint = f"did you mean '{near}'?" if near else "expected one such as 'fleet.size', or a section with cases"
    return Problem(here, f"no key of a model, {hint}", at_key=True)


def _levels(key: str, form: str, given: Any, where: Keys, problems: list[Problem]) -> Iterator[Level]:
    match form:
        case "values":
            yield from _values(key, given, where, problems)
        case "range":
            yield from _range_list(key, given, where, problems)
        case "linspace":
            yield from _linspace(key, given, where, problems)
        case "named":
            if not isinstance(given, Mapping) or not given:
                problems.append(Problem.of(where, "no names", given, "names, each followed by a value"))
                return
            for name, value in given.items():
                yield Level(name, {key: value}, (*where, name))


def _values(key: str, given: Any, where: Keys, problems: list[Problem]) -> Iterator[Level]:
    if isinstance(given, str):
        yield from _spread(key, given, where, problems)
        return
    if not given:
        problems.append(Problem.of(where, "no values", given, EXPECTED))
    for rank, value in enumerate(given):
        if isinstance(value, str) and _RANGE.fullmatch(value):
            yield from _spread(key, value, (*where, rank), problems)
        else:
            yield Level(label(value), {key: value}, (*where, rank))


def _spread(key: str, text: str, where: Keys, problems: list[Problem]) -> Iterator[Level]:
    """The values of a range such as 1..6 or 0.5..2..0.5."""
    match = _RANGE.fullmatch(text)
    try:
        numbers = [_number(part) for part in match.groups() if part is not None] if match else []
    except ValueError:
        numbers = []
    yield from _between_ends(key, numbers, text, where, problems)


def _number(text: str) -> float:
    return float(text) if "." in text else int(text)


def _range_list(key: str, given: Any, where: Keys, problems: list[Problem]) -> Iterator[Level]:
    numbers = list(given) if isinstance(given, Sequence) and not isinstance(given, str) else []
    yield from _between_ends(key, numbers, given, where, problems)


def _between_ends(key: str, numbers: list[Any], given: Any, where: Keys, problems: list[Problem]) -> Iterator[Level]:
    expected = "first, last and, if not 1, the step, such as 1..6 or [0.5, 2, 0.5]"
    if len(numbers) not in {2, 3} or not all(map(_finite, numbers)):
        problems.append(Problem.of(where, "not a range", given, expected))
        return
    first, last, step = (*numbers, 1)[:3]
    if step <= 0 or last < first or (last - first) / step > _MOST:
        problems.append(Problem.of(where, "an empty or endless range", given, expected))
        return
    for rank in range(math.floor((last - first) / step + 1e-9) + 1):
        value = first + rank * step
        yield _level(key, round(value, _DIGITS) if isinstance(value, float) else value, where)


def _linspace(key: str, given: Any, where: Keys, problems: list[Problem]) -> Iterator[Level]:
    many = given[2] if isinstance(given, Sequence) and len(given) == 3 else None  # noqa: PLR2004 - a triple
    if isinstance(many, bool) or not isinstance(many, int) or not all(map(_finite, given)):
        many = None
    if many is None or not 2 <= many <= _MOST:  # noqa: PLR2004 - both ends
        expected = "low, high and how many (at least 2), such as [5, 20, 4]"
        problems.append(Problem.of(where, "not understood", given, expected))
        return
    low, high, _ = given
    for rank in range(many):
        value = round(low + (high - low) * rank / (many - 1), _DIGITS)
        whole = isinstance(low, int) and isinstance(high, int) and not (high - low) % (many - 1)
        yield _level(key, int(value) if whole else value, where)


def _level(key: str, value: float, where: Keys) -> Level:
    return Level(value, {key: value}, where)


def _between(given: Any, where: Keys, problems: list[Problem]) -> Between | None:
    pair = isinstance(given, Sequence) and not isinstance(given, str) and len(given) == 2  # noqa: PLR2004
    if not pair or not all(map(_finite, given)) or not given[0] < given[1]:
        problems.append(Problem.of(where, "not a range", given, "low and high, such as [2.0, 5.0]"))
        return None
    return Between(given[0], given[1], all(isinstance(end, int) for end in given))


def _finite(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _cases(name: str, given: Any, problems: list[Problem]) -> Factor | None:
    """A factor that changes several keys together, by name."""
    where: Keys = ("factors", name, "cases")
    expected = "names, each followed by keys of the model and their values"
    if not isinstance(given, Mapping) or not given:
        problems.append(Problem.of(where, "no cases", given, expected))
        return None
    levels = []
    for case, changes in given.items():
        if changes is not None and not isinstance(changes, Mapping):
            problems.append(Problem.of((*where, case), "not a section", changes, expected))
            continue
        problems += [
            _no_such_key((*where, case, key), key) for key in changes or {} if not outline.known(tuple(_steps(key)))
        ]
        levels.append(Level(case, dict(changes or {}), (*where, case)))
    return Factor(name, tuple(levels)) if levels else None


def _no_twice(levels: Sequence[Level], where: Keys, problems: list[Problem]) -> None:
    seen: dict[str, Level] = {}
    for level in levels:
        said = f"{type(level.label).__name__ if isinstance(level.label, bool) else ''}{level.label}"
        if said in seen and level.keys != where:
            problems.append(Problem(level.keys, f"given twice (got {got(level.label)}), expected once"))
        seen[said] = level
