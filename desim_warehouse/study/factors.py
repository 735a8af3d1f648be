"""Factors: the keys that a study varies, and their values, as users write them and as tables show them.

For `--vary` of `desim what-if`, `best`, `plan` and `serve`, and for study files.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Field, PlainValidator, WithJsonSchema

from desim_warehouse.errors import got, nearest, spoken
from desim_warehouse.model import Model
from desim_warehouse.model.messages import Keys
from desim_warehouse.model.schema import OUTLINE
from desim_warehouse.outcome.indicators import look_up
from desim_warehouse.study.statistics.limits import MOST_LEVELS
from desim_warehouse.values.fields import Forms, Part, all_wrong, form, wrong

Label: TypeAlias = str | int | float | bool | None

RESERVED = ("replication", "seed", "deterministic", "run_time", "error")
"""Columns of the table of runs that are neither factors nor indicators."""
_STATISTICS = (
    *("indicator", "n", "failed", "mean", "half_width", "low", "high", "median", "q05", "q25", "q75", "q95"),
    *("baseline", "difference", "difference_low", "difference_high", "p", "differs", "runs", "missing"),
)
"""Columns of the tables of means and of differences that are no factors."""
_RANGE = re.compile(r"\s*([+-]?[\d.]+?)\.\.([+-]?\d[\d.]*?)(?:\.\.(\d[\d.]*))?\s*")
_DASHED = re.compile(r"\s*(\d+\.?\d*)\s*[-–]\s*(\d+\.?\d*)\s*")
_DIGITS = 12  # of a value of a range: 0.3, not 0.30000000000000004
_ENDS = "first, last and, if not 1, the step, such as 1..6 or [0.5, 2, 0.5]"
DRAW = "expected lists of values, drawn by SALib or scipy.stats.qmc, with design: paired"
"""What to write instead of a sampled design."""
FORMS = ("named", "cases", "range", "linspace")
"""The keys of a section that gives the values of a factor."""
EXPECTED = "a list of values, a range such as 1..6, or a section with " + spoken(FORMS, "or")


@dataclass(frozen=True)
class Level:
    """A value of a factor: its label in tables, and its changes to the model."""

    label: Label
    overrides: Mapping[str, Any]
    keys: Keys  # where it stands in the study file


@dataclass(frozen=True)
class Factor:
    """A factor of a study: a key of the model (or a name, for `cases`), and its values."""

    key: str
    levels: tuple[Level, ...]


def holder_of(name: str, factors: Iterable[str] = (), columns: Iterable[str] = (*RESERVED, *_STATISTICS)) -> str:
    """Return in words what has a name in the tables of a study, so that no other column may; empty if nothing has."""
    if name in factors:
        return "a factor"
    if look_up(name) is not None:
        return "an indicator"
    return "a column of its tables" if name in columns else ""


def label(value: Any) -> Label:
    """Return a value as the study table has it: numbers and words as they are, a policy as `name(parameter=1)`."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Mapping) and isinstance(value.get("name"), str):
        rest = ", ".join(f"{key}={item}" for key, item in value.items() if key != "name")
        name = value["name"].replace("\\", "/").rpartition("/")[2]  # the user's own: my_policies.py:Patient
        return f"{name}({rest})" if rest else name
    return json.dumps(value, ensure_ascii=False)


# The forms in which a study file gives the values of a factor


def _check_key(key: str, *below: str) -> None:
    """Refuse a dotted key that models do not have, and name the nearest."""
    if not OUTLINE.has(_steps(key)):
        near = OUTLINE.meant(_steps(key))
        hint = f"did you mean '{near}'?" if near else "expected one such as 'fleet.size', or a section with cases"
        raise wrong(f"no key of a model, {hint}", *below)


def _model_key(key: str) -> str:
    _check_key(key)
    return key


def _finite(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise wrong(f"should be a finite number (got {got(value)})")
    return value


Finite = Annotated[int | float, BeforeValidator(_finite)]
"""A finite number, where a whole one stays whole."""


@dataclass(frozen=True)
class Values:
    """The form of a factor whose values are a list, or a single one, each with its keys below the factor's own."""

    values: tuple[tuple[Keys, Any], ...]

    def levels(self, key: str) -> Iterator[Level]:
        """Return the values, in order."""
        return (Level(label(value), {key: value}, ("factors", key, *keys)) for keys, value in self.values)


def _values(content: Any) -> Values:
    """Read a list in which ranges may stand, or a single value or range."""
    if isinstance(content, str) and not _RANGE.fullmatch(content):
        dashed = _DASHED.fullmatch(content)
        write = "{}..{}".format(*dashed.groups()) if dashed else f"[{content}]"
        raise wrong(f"should be {EXPECTED} (got {got(content)}); write {write}")
    listed = isinstance(content, list | tuple)
    if listed and not content:
        raise wrong(f"no values (got []), expected {EXPECTED}")
    values: list[tuple[Keys, Any]] = []
    problems = []
    for rank, item in enumerate(content if listed else [content]):
        keys: Keys = (rank,) if listed else ()
        try:
            spread = _spread(item)
        except ValueError as error:
            problems.append(wrong(f"{error} (got {got(item)}), expected {_ENDS}", *keys))
            continue
        values += [(keys, value) for value in spread]
    if problems:
        raise all_wrong(problems)
    return Values(tuple(values))


def repeated(factor: Factor) -> Iterator[Level]:
    """Yield the levels of a factor that tables would show like an earlier level: true is not 'true', 2 is '2'."""
    before = set()
    for level in factor.levels:
        shown = (isinstance(level.label, bool), str(level.label))
        if shown in before:
            yield level
        before.add(shown)


def listed(items: Sequence[Any]) -> list[Any]:
    """Return the values of a list in which ranges may stand. Raises ValueError for a bad range."""
    return [value for item in items for value in _spread(item)]


def _spread(item: Any) -> Sequence[Any]:
    """Return the values of a range such as 1..6 or 0.5..2..0.5, or anything else itself."""
    match = _RANGE.fullmatch(item) if isinstance(item, str) else None
    if match is None:
        return [item]
    try:
        ends = [float(part) if "." in part else int(part) for part in match.groups() if part]
    except ValueError:
        raise ValueError("not a range") from None
    return _between_ends(ends)


def _between_ends(ends: Sequence[float]) -> Sequence[float]:
    """Return the numbers from the first to the last, which is included, in steps of 1 or of the third number."""
    if len(ends) not in {2, 3}:
        raise ValueError("not a range")
    first, last, step = (*ends, 1)[:3]
    if not all(map(math.isfinite, ends)) or step <= 0 or last < first or (last - first) / step > MOST_LEVELS:
        raise ValueError("an empty or endless range")
    values = (first + rank * step for rank in range(math.floor((last - first) / step + 1e-9) + 1))
    return [round(value, _DIGITS) if isinstance(value, float) else value for value in values]


def _is_range(ends: tuple[float, ...]) -> tuple[float, ...]:
    try:
        _between_ends(ends)
    except ValueError as error:
        raise wrong(f"{error} (got {got(ends)}), expected {_ENDS}") from None
    return ends


class Range(Part):
    """Numbers in equal steps."""

    range: Annotated[tuple[Finite, ...], AfterValidator(_is_range)] = Field(description=_ENDS)

    def levels(self, key: str) -> Iterator[Level]:
        """Return the numbers."""
        return _numbers(key, _between_ends(self.range), "range")


class Linspace(Part):
    """Equally spaced numbers, both ends included."""

    linspace: tuple[Finite, Finite, Annotated[int, Field(strict=True, ge=2, le=MOST_LEVELS)]] = Field(
        description="low, high and how many (at least 2), such as [5, 20, 4]"
    )

    def levels(self, key: str) -> Iterator[Level]:
        """Return the numbers, whole ones if both ends and all between are."""
        low, high, many = self.linspace
        whole = isinstance(low, int) and isinstance(high, int) and not (high - low) % (many - 1)
        values = [round(low + (high - low) * rank / (many - 1), _DIGITS) for rank in range(many)]
        return _numbers(key, [int(value) for value in values] if whole else values, "linspace")


def _numbers(key: str, values: Sequence[float], form: str) -> Iterator[Level]:
    return (Level(value, {key: value}, ("factors", key, form)) for value in values)


class NamedValues(Part):
    """Values with names, which tables and figures show."""

    named: Annotated[Mapping[str, Any], Field(min_length=1)] = Field(description="names, each followed by a value")

    def levels(self, key: str) -> Iterator[Level]:
        """Return the values by name."""
        return (Level(name, {key: value}, ("factors", key, "named", name)) for name, value in self.named.items())


class Cases(Part):
    """Changes to several keys of the model, by name."""

    cases: Annotated[
        Mapping[str, Mapping[Annotated[str, AfterValidator(_model_key)], Any] | None], Field(min_length=1)
    ] = Field(description="names, each followed by keys of the model and their values")

    def levels(self, key: str) -> Iterator[Level]:
        """Return the cases by name."""
        return (
            Level(case, dict(changes or {}), ("factors", key, "cases", case)) for case, changes in self.cases.items()
        )


def _form(content: Any) -> str | None:
    """Return the tag of the form of a factor. A section has one key, which names its form."""
    if not isinstance(content, Mapping):
        return "\0values"
    return f"\0{next(iter(content))}" if len(content) == 1 and content.keys() <= set(FORMS) else None


def _of_a_key(item: tuple[str, Any]) -> Any:
    """Check the key of a factor, which models must have unless there are cases, and return its content."""
    key, content = item
    if holder := holder_of(key):
        raise wrong(f"the name of {holder}, expected another with cases", "[key]")
    section = isinstance(content, Mapping)
    if not (section and "cases" in content):
        _check_key(key, "[key]")
    if section and "between" in content:
        raise wrong(f"no ranges to draw from since 0.4 (got {got(content['between'])}), {DRAW}", "between")
    form = str(next(iter(content))) if section and len(content) == 1 else FORMS[0]
    near = nearest(form, FORMS)
    if near and near != form:
        raise wrong(f"unknown key, did you mean '{near}'?", form, "[key]")
    return content


Form = Annotated[
    Annotated[
        Values,
        PlainValidator(_values),
        WithJsonSchema({"description": EXPECTED, "type": ["array", "string", "number", "boolean"]}),
        form("values"),
    ]
    | Annotated[NamedValues, form("named")]
    | Annotated[Cases, form("cases")]
    | Annotated[Range, form("range")]
    | Annotated[Linspace, form("linspace")],
    Forms(EXPECTED, pick=_form),
    BeforeValidator(_of_a_key),
]
"""What a study file has for a factor, read together with the factor's key."""


def factor_of(key: str, form: Values | NamedValues | Cases | Range | Linspace) -> Factor:
    """Make the factor that a study file describes."""
    return Factor(key, tuple(form.levels(key)))


def level_of(model: Model, key: str) -> Any:
    """Return the value of a model at a dotted key, as a file has it; None where the key is not set."""
    value: Any = model.content()
    for part in key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else value[int(part)] if isinstance(value, list) else None
    return value


def _steps(key: str) -> Keys:
    """Split a dotted key into its keys, where numbers are ranks in lists."""
    return tuple(int(part) if part.isdecimal() else part for part in key.split("."))


def hint(key: str, value: Any) -> str:
    """Return the likely meaning of a value that the model refuses; else an empty text."""
    dashed = _DASHED.fullmatch(value) if isinstance(value, str) else None
    if dashed:
        return f"; write {dashed[1]}..{dashed[2]} for a range"
    below = OUTLINE.keys_at(_steps(key))
    if below and isinstance(value, int | float):
        numbers = [name for name in below if "number" in OUTLINE.expected((*_steps(key), name)).split(" of ")[0]]
        return f"; vary a key in it, such as {key}.{(numbers or below)[0]}"
    return ""
