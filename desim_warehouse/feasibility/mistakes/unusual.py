"""Values outside the usual range of their key, and the unit in which they would be usual.

What is usual stands beside the type of each key (`Usual`); here is only how it is looked at and said.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import spoken
from desim_warehouse.findings import Finding, amount
from desim_warehouse.model.facts.keys import kind_of, whole_annotation
from desim_warehouse.model.schema import Model, Prices
from desim_warehouse.policies import catalogue
from desim_warehouse.values.distributions import Distribution, mean_of
from desim_warehouse.values.fields import Part, Usual, parts_in, sections_in
from desim_warehouse.values.units import METRES, SECONDS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from desim_warehouse.model.schema import Units

ALIKE = ("EUR", "USD", "GBP", "CHF", "CAD", "AUD", "€", "$", "£")
"""Currencies of about the same worth, for which the usual prices hold; in others nothing is said of them."""
LONG = 3600.0
"""Seconds of a run in which something within the first minute is rather meant in minutes or hours."""
AT_START, MOST_AT_START = 0.01, 300.0
"""The same of a run of which it all happens in the first hundredth, within these seconds."""


def warnings(model: Model) -> Iterator[Finding]:
    """What is unusual of the keys, and of the parameters of policies."""
    for place, part in parts_in(model, _with_usual()):
        for name, key, usual, kind in _usual_keys(type(part)):
            if not _judged(model, part, usual, kind):
                continue
            since = _begins(model) if usual.instant else 0.0
            for below, value in _numbers(getattr(part, name), usual):
                yield from _unusual(f"{place}.{key}{below}", value, usual, kind, model.units, since)
    for decision, spec in model.policies.specs().items():
        kinds = catalogue.quantities_of(decision, spec.name)
        for key, note in catalogue.notes_of(decision, spec.name):
            given = spec.params.get(key)
            if isinstance(note, Usual) and isinstance(given, int | float):
                yield from _unusual(f"policies.{decision}.{key}", float(given), note, kinds[key], model.units)


@cache
def _usual_keys(section: type[Part]) -> tuple[tuple[str, str, Usual, str], ...]:
    """The fields of a section that say what is usual: name, key in files, range, kind of unit."""
    return tuple(
        (name, field.alias or name, note, kind_of(whole_annotation(field)))
        for name, field in section.model_fields.items()
        for note in field.metadata
        if isinstance(note, Usual)
    )


@cache
def _with_usual() -> tuple[type[Part], ...]:
    """The sections of a model with such fields."""
    found: dict[type[Part], None] = {}
    left: list[type[Part]] = [Model]
    while left:
        section = left.pop()
        if section not in found:
            found[section] = None
            left += [inner for field in section.model_fields.values() for inner in sections_in(field.annotation)]
    return tuple(section for section in found if _usual_keys(section))


def _judged(model: Model, part: Part, usual: Usual, kind: str) -> bool:
    """Whether a key of this model can be held against what is usual."""
    if isinstance(part, Prices) and usual.price and not comparable(part.currency):
        return False
    if kind in {"time", "speed", "acceleration"} and not model.units.has_seconds:
        return False
    return not usual.instant or model.run.end * model.units.seconds >= LONG


def _begins(model: Model) -> float:
    """Seconds from the start of the run within which not all that happens at some times is to be expected."""
    end = model.run.end
    return min(AT_START * end * model.units.seconds, MOST_AT_START) if math.isfinite(end) else 0.0


def comparable(currency: str | None) -> bool:
    """Whether prices in a currency are about as high as in EUR; where it has no name they are taken to be."""
    return currency is None or currency in ALIKE


def _numbers(value: Any, usual: Usual) -> Iterator[tuple[str, float]]:
    """The numbers of a key with what stands after it; of instants the last, of distributions the mean."""
    if isinstance(value, int | float | Distribution):
        yield "", float(mean_of(value))
    elif isinstance(value, Mapping):
        yield from ((f".{name}", float(number)) for name, number in value.items())
    elif isinstance(value, tuple) and value:
        numbers = [number for item in value for _, number in _numbers(item, usual)]
        yield from [("", max(numbers))] if usual.instant else (("", number) for number in numbers)


def _unusual(place: str, value: float, usual: Usual, kind: str, units: Units, since: float = 0.0) -> Iterator[Finding]:
    low, high = usual.between(kind)
    low = max(low, since)
    real = value * _si(kind, units)
    if value == 0 or low <= real <= high:
        return
    below = real < low
    meant = "" if usual.cure else _meant(value, low, high, kind)
    said, bound = (f"{with_unit(number, kind)} {usual.words}".rstrip() for number in (real, low if below else high))
    yield Finding(
        "UNUSUAL",
        place,
        f"{said} is unusual: {'less' if below else 'more'} than {bound}",
        f"did you mean {meant}?" if meant else usual.cure or _plain(kind, units),
    )


def _si(kind: str, units: Units) -> float:
    """Seconds or metres in a unit of a model."""
    metre, second = units.metre or 1.0, units.seconds
    return {"time": second, "length": metre, "speed": metre / second, "acceleration": metre / second**2}.get(kind, 1.0)


def _meant(value: float, low: float, high: float, kind: str) -> str:
    """The number with the units in which it would be usual."""
    if kind == "share":
        return f"{value:g} %" if low <= value / 100 <= high else f"{1 + value:g}, which is {value:.0%} more"
    least = low or high / (400 if kind == "time" else 40)  # in ms, but not in mm
    table = {"time": SECONDS, "length": METRES}.get(kind, {})
    fits = [f"{amount(value)} {name}" for name, size in table.items() if least <= value * float(size) <= high]
    return spoken(fits[:2], "or") if fits else ""


def _plain(kind: str, units: Units) -> str:
    """In which unit plain numbers are."""
    if kind == "length":
        return "units.length says what lengths are in"
    return f"times are in {units.time}" if kind else "is it as large as that?"


def with_unit(amount_of: float, kind: str) -> str:
    """A quantity in seconds or metres with its unit; times in the largest that is whole or two at least."""
    if kind != "time":
        unit = {"length": " m", "speed": " m/s", "acceleration": " m/s²", "rate": " an hour"}.get(kind, "")
        return f"{amount_of:,g}{unit}"
    sizes = [(unit, float(size)) for unit, size in reversed(SECONDS.items()) if unit != "ms"]
    unit, size = next((one for one in sizes if amount_of == one[1] or amount_of >= 2 * one[1]), ("s", 1.0))
    return f"{amount(amount_of / size)} {unit}"
