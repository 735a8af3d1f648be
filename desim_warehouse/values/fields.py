"""Building blocks of the sections of model and study files: kinds of values, frozen sections, keys of several forms."""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TypeVar, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag, ValidationError
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError, core_schema

from desim_warehouse.errors import did_you_mean, got, spoken
from desim_warehouse.values.units import EXAMPLES, TABLE, UnitNames, converted, quantity

if TYPE_CHECKING:
    from pydantic import ValidationInfo
    from pydantic.annotated_handlers import GetCoreSchemaHandler, GetJsonSchemaHandler

Key = TypeVar("Key")
Value = TypeVar("Value")
Checked = TypeVar("Checked", int, float)

LIMITS: dict[str, tuple[int, str]] = {
    "number": (10**12, "any number"),
    "robots": (10_000, "robots, and places or chargers at a node"),
    "nodes": (100_000, "nodes of a layout"),
    "edges": (400_000, "edges of a layout"),
    "places": (1_000_000, "storage places"),
    "tasks": (1_000_000, "tasks: listed, random, or arriving in run.length on average"),
    "open": (100_000, "tasks open at once (saturated)"),
    "loads": (1000, "loads of one robot"),
    "stops": (1000, "stops of one task"),
    "hourly": (100_000, "tasks arriving per hour (poisson)"),
    "lines": (10_000, "lines of an order"),
    "stock": (2_000_000, "items on all pods: pods times items on a pod"),
    "events": (10_000_000, "breakdowns, outages, visits of people, or openings, of one key in run.length"),
    "bytes": (10_000_000, "bytes of a model, study or CSV file"),
    "trips": (500_000, "trips of a log"),
    "columns": (1000, "columns of a table of orders"),
    "texts": (200_000_000, "bytes of texts of a table of orders that are held at once"),
    "sheet": (1_000_000_000, "bytes of a workbook (Excel) when it is unfolded"),
    "json": (100_000_000, "bytes of a layout file (JSON)"),
    "values": (1_000_000, "values in a file, aliases counted at every use"),
    "elements": (500_000, "elements of a file (XML)"),
    "deep": (30, "lists and sections inside one another"),
}
"""Upper limits of what a file may hold: far more than a warehouse has, and still read within seconds."""
SMALLEST = 1e-9
"""The smallest number where one above 0 is expected."""
TOP = "\0top"
"""A mark among the keys of `wrong`: keys after it are counted from the top of the file, not below the value."""
_SUM = 1e-6  # shares written with a few digits add up to 1 within this
_UNSEEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""Control characters except tab and line end, and characters that turn the direction of text around."""
_EMPTY: tuple[Any, ...] = (None, (), {})
"""Defaults of keys that hold nothing unless the file says so."""
_EXACT = 2.0**53  # up to here every whole number is a float
NUMBER = (int, float)
"""Types of a number in a file, for `by_type`."""


def wrong(text: str, *below: str | int) -> PydanticCustomError:
    """Return the error that a validator raises: its text in our words, and the keys below the value that it checks."""
    return PydanticCustomError("wrong", "{text}", {"text": text, "below": below})


def all_wrong(problems: Sequence[PydanticCustomError]) -> ValidationError:
    """Return the error that a validator raises where several things are wrong."""
    return ValidationError.from_exception_data(
        "values", [InitErrorDetails(type=problem, input=None) for problem in problems]
    )


def at_most(limit: str, value: float, *below: str) -> None:
    """Refuse more than a limit."""
    most, what = LIMITS[limit]
    if abs(value) > most:
        raise wrong(f"too large (got {got(value)}), expected at most {most:,} ({what})", *below)


def limited(limit: str = "number") -> AfterValidator:
    """Keep a number within a limit."""

    def check(value: Checked) -> Checked:
        at_most(limit, value)
        return value

    return AfterValidator(check)


def _not_tiny(value: float) -> float:
    if value < SMALLEST:
        raise wrong(f"too small (got {got(value)}), expected at least {got(SMALLEST)}")
    return value


def _none_or_not_tiny(value: float) -> float:
    return _not_tiny(value) if value else value


def see_kinds(named: Iterable[tuple[Key | None, str]], kinds: Sequence[str] | None, *place: str) -> None:
    """Refuse names of no kind of robot, each at its key below `place` (None: there), where `kinds` are known."""
    for key, kind in named if kinds is not None else ():
        if kinds is not None and kind not in kinds:
            expected = f"one of {spoken(kinds, 'or')}" if kinds else "one of fleet.kinds, which has none"
            text = f"no such kind of robot (got {got(kind)}), expected {expected}{did_you_mean(kind, kinds)}"
            raise wrong(text, *place, *(() if key is None else (key,)))


def writable(text: str) -> str:
    """Refuse lone surrogates, which no file can hold, and characters that a terminal would obey rather than show."""
    if not text.isascii() and re.search("[\ud800-\udfff]", text):
        raise wrong(f"not text (got {got(text)}), expected characters that can be written in UTF-8")
    if not text.isprintable() and _UNSEEN.search(text):
        raise wrong(f"a control character in it (got {got(text)}), expected characters that can be seen")
    return text


def see_weights(weights: Sequence[float], number: int, what: str) -> None:
    """Refuse weights that are not one for each of a number of things, or all 0; none at all are fine."""
    if weights and len(weights) != number:
        raise wrong(f"{len(weights)} weights for {number} {what}, expected one for each")
    if weights and not any(weights):
        raise wrong("all weights are 0, expected one above 0")


def see_sum(shares: Iterable[float], what: str = "shares") -> None:
    """Refuse shares that do not add up to 1, as far as a few digits tell."""
    total = math.fsum(shares)
    if abs(total - 1) > _SUM:
        raise wrong(f"{what} do not add up (got {got(round(total, 9))}), expected a sum of 1")


def _one_each(weights: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
    see_weights(weights, len(info.data.get("values", weights)), "values")
    return weights


class Unit:
    """The kind of unit of a number: time, length, speed, acceleration, rate, share, energy, power or angle."""

    def __init__(self, kind: str) -> None:
        self.kind = kind


class Quantity(Unit):
    """A number that may be written with a unit, as in `8 h`. In the model it is in the model's units."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Convert before the number is checked."""

        def convert(value: Any, info: ValidationInfo) -> Any:
            try:
                number = converted(value, self.kind, known(info).units) if isinstance(value, str) else None
            except ValueError as error:
                raise wrong(str(error)) from None
            return value if number is None else number

        return core_schema.with_info_before_validator_function(convert, handler(source))

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Allow a number, or text with a unit."""
        units = "|".join(re.escape(unit) for unit in TABLE[self.kind]).replace("/", " ?/ ?")
        written = {"type": "string", "pattern": rf"^\s*[+-]?[\d.]+\s*({units})\s*$", "examples": [EXAMPLES[self.kind]]}
        return {"anyOf": [handler(core), written]}


@dataclass(frozen=True)
class Usual:
    """Between which values a key usually lies in a warehouse; beyond them `desim check` asks about its unit.

    It stands beside the type of the key, and rules out what is hardly ever meant, not what is rare. 0 is always usual.

    Args:
        low: as a model says it: `1 min`, or 0.5 where the key has no unit.
        high: the same.
        instant: it is a time of the run; of several the last is looked at, as the first may be at the very start.
        price: it is in a currency, which is worth about as much as EUR.
        words: what follows the number in a message, where it has no unit: `hours a year`.
        cure: what is probably meant, where a unit does not say it.
    """

    low: float | str
    high: float | str = math.inf
    instant: bool = False
    price: bool = False
    words: str = ""
    cure: str = ""

    def between(self, kind: str) -> tuple[float, float]:
        """Both ends as numbers, in seconds and metres."""
        low, high = (
            quantity(value, kind, UnitNames()) if isinstance(value, str) else value for value in (self.low, self.high)
        )
        return low, high


class FrozenMap(dict[Key, Value]):
    """A dict that cannot be changed, but compared, hashed, pickled and copied. Its order counts."""

    _hash: int | None = None

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("a model cannot be changed; model.replace({...}) gives a changed copy")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __eq__(self, other: object) -> bool:
        if isinstance(other, FrozenMap):
            return list(self.items()) == list(other.items())
        return dict.__eq__(self, other)

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:  # type: ignore[override]
        if self._hash is None:
            self._hash = hash(tuple(self.items()))
        return self._hash

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Read and written like a dict."""
        return core_schema.no_info_after_validator_function(cls, handler.generate_schema(dict[Any, Any]))

    def __reduce__(self) -> tuple[type[FrozenMap[Key, Value]], tuple[dict[Key, Value]]]:
        return type(self), (dict(self),)

    def __copy__(self) -> FrozenMap[Key, Value]:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> FrozenMap[Key, Value]:
        return self


class Part(BaseModel):
    """A section of a model file: unknown keys are refused, values cannot be changed after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    def content(self) -> Any:
        """Return the section as plain JSON values, defaults included.

        A key is left out if its value is empty (`_EMPTY`) and its default too, so that the file says nothing about it.
        """
        return {
            info.alias or name: as_json(value)
            for name, info in type(self).model_fields.items()
            if (value := getattr(self, name)) != info.default or value not in _EMPTY
        }

    def is_random(self, model: Any) -> bool:
        """Whether the section draws random numbers in runs of this model: by default, where a part of it does.

        Sections that draw numbers themselves override this; it is known before a run.
        """
        return any(_any_random(getattr(self, name), model) for name in _with_chance(type(self)))


above_tiny = AfterValidator(_not_tiny)

# Numbers are taken as written: no text for a number, no true for 1, no fraction for a whole number.
Whole = Annotated[int, Field(strict=True, ge=0), limited()]
Count = Annotated[int, Field(strict=True, ge=1), limited()]
Integer = Annotated[int, Field(strict=True), limited()]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False), limited()]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0), limited(), above_tiny]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0), limited()]
Flag = Annotated[bool, Field(strict=True)]
Name = Annotated[str, Field(strict=True, min_length=1), AfterValidator(writable)]
Text = Annotated[str, Field(strict=True), AfterValidator(writable)]
Weights = Annotated[tuple[NotNegative, ...], AfterValidator(_one_each)]
"""How often each of the `values` of the same section comes, in comparison with the others; none: all alike."""
Named = Annotated[Mapping[Name, Value], AfterValidator(FrozenMap)]
"""Parts by name, in the order of the file."""
SECTION = (Mapping, Part)
"""Types of a section, in a file or read already, for `by_type`."""

Time = Annotated[NotNegative, Quantity("time")]
Interval = Annotated[NotNegative, AfterValidator(_none_or_not_tiny), Quantity("time")]
"""A time between two instants; 0: none."""
Duration = Annotated[Positive, Quantity("time")]
Coordinate = Annotated[Number, Quantity("length")]
Length = Annotated[Positive, Quantity("length")]
Distance = Annotated[NotNegative, Quantity("length")]
Speed = Annotated[Positive, Quantity("speed")]
Acceleration = Annotated[Positive, Quantity("acceleration")]
Rate = Annotated[Positive, Quantity("rate")]
Energy = Annotated[NotNegative, Unit("energy")]
Power = Annotated[NotNegative, Unit("power")]
Share = Annotated[float, Field(strict=True, ge=0, le=1), Quantity("share")]
Fraction = Annotated[float, Field(strict=True, gt=0, lt=1), above_tiny, Quantity("share")]
"""A share that is neither 0 nor 1."""


@dataclass
class Known:
    """The parts of a model read so far, for checks of the rest. None means not known, or wrong.

    It is the context of pydantic's validators. Sections are read in the order of the schema, so that the floor is
    known before the fleet and the work on it.
    """

    units: UnitNames = field(default_factory=UnitNames)
    calendars: tuple[str, ...] | None = None  # by name
    blocks: bool = False  # the layout is generated
    nodes: Mapping[str, Any] | None = None  # positions by name
    zones: dict[str, dict[str, tuple[str, ...]]] = field(default_factory=dict)  # nodes of bays and stations by name
    edges: dict[tuple[str, str], float | None] = field(default_factory=dict)  # lengths, if they can be told
    places: int | None = None  # storage places
    robots: int | None = None
    kinds: tuple[str, ...] | None = None  # of robots, by name
    carries: Mapping[str, tuple[str, ...]] | None = None  # load types by kind of robot; none for ordinary robots: ""


def known(info: ValidationInfo) -> Known:
    """Return the parts of the model read before this value; none for a section that is read by itself."""
    return info.context if isinstance(info.context, Known) else Known()


def sections_in(annotation: Any) -> list[type[Part]]:
    """Return the sections that a key with this annotation may hold, in any of its forms, by name or in a list."""
    if isinstance(annotation, type) and issubclass(annotation, Part):
        return [annotation]
    return [section for inner in get_args(annotation) for section in sections_in(inner)]


def parts_in(value: Any, wanted: tuple[type[Part], ...], place: str = "") -> Iterator[tuple[str, Part]]:
    """Yield the sections of some kinds in a section, each with its dotted key.

    Long lists that hold none are passed over.
    """
    if isinstance(value, Part):
        if isinstance(value, wanted):
            yield place, value
        for name in _with_parts(type(value), wanted):
            key = type(value).model_fields[name].alias or name
            yield from parts_in(getattr(value, name), wanted, f"{place}.{key}" if place else key)
    elif isinstance(value, Mapping | tuple):
        pairs: Iterable[tuple[Any, Any]] = value.items() if isinstance(value, Mapping) else enumerate(value)
        for key, item in pairs:
            yield from parts_in(item, wanted, f"{place}.{key}")


@cache
def _with_parts(section: type[Part], wanted: tuple[type[Part], ...]) -> tuple[str, ...]:
    """Return the keys of a section that may hold sections of some kinds."""
    return tuple(
        name
        for name, info in section.model_fields.items()
        if any(issubclass(inner, wanted) or _with_parts(inner, wanted) for inner in sections_in(info.annotation))
    )


@cache
def _with_chance(section: type[Part]) -> tuple[str, ...]:
    """Return the keys of a section that may hold something random, so that long lists of edges are skipped."""
    return tuple(
        name
        for name, info in section.model_fields.items()
        if any(inner.is_random is not Part.is_random or _with_chance(inner) for inner in sections_in(info.annotation))
    )


def _any_random(value: Any, model: Any) -> bool:
    """Whether a value is random, or any value in a list or by name."""
    if isinstance(value, Part):
        return value.is_random(model)
    if isinstance(value, Mapping | tuple):
        return any(_any_random(item, model) for item in (value.values() if isinstance(value, Mapping) else value))
    return False


def as_json(value: Any) -> Any:
    """Return a value of a model as JSON knows it, with 4.0 as 4, so that both are one."""
    if isinstance(value, Part):
        return value.content()
    if isinstance(value, Mapping):
        return {key: as_json(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [as_json(item) for item in value]
    if isinstance(value, float) and value.is_integer() and abs(value) < _EXACT:
        return int(value)
    return value


class By:
    """The preposition between a part's name and the meaning of its key: chargers *in* parking; `of` by default."""

    def __init__(self, preposition: str) -> None:
        self.preposition = preposition


class Forms:
    """The expected forms of a key, in words, for messages and, as `errorMessage`, for editors.

    Args:
        text: the words.
        more: further forms, which reading turns into those of the annotated type.
        pick: which form a value has, by the tag of `form`; None where it has none of them.
    """

    def __init__(
        self, text: str, *more: type[Part] | dict[str, Any], pick: Callable[[Any], str | None] | None = None
    ) -> None:
        self.text = text
        self.more = more
        self.pick = pick

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """A union in which the value's form decides what is wrong with it."""
        if self.pick is None:
            return handler(source)
        choice = Discriminator(self.pick, custom_error_type="form", custom_error_message=f"should be {self.text}")
        return choice.__get_pydantic_core_schema__(source, handler)

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Add the words and the other forms to the schema of the annotated type."""
        schema = handler(core)
        more = [
            copy.deepcopy(other) if isinstance(other, dict) else handler(other.__pydantic_core_schema__)
            for other in self.more
        ]
        return {**({"anyOf": [schema, *more]} if more else schema), "errorMessage": f"expected {self.text}"}


def form(tag: str) -> Tag:
    """Tag one form of a key. The tag is left out of the positions in errors."""
    return Tag(f"\0{tag}")


def by_type(**forms: type | tuple[type, ...]) -> Callable[[Any], str | None]:
    """Return a function that chooses a key's form by the type of its value; a section may be a mapping or a Part."""

    def pick(value: Any) -> str | None:
        return next((f"\0{tag}" for tag, types in forms.items() if isinstance(value, types)), None)

    return pick
