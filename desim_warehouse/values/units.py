"""Quantities with units in values, such as `8 h`, `600 mm`, `1.5 m/s`, `0.5 m/s^2`, `200 / h` or `25 %`.

A table of our own: six kinds of units, converted as fractions, so that `600 mm` is exactly 0.6 where lengths are in m.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction

from desim_warehouse.errors import did_you_mean, got, spoken

METRES = {
    "mm": Fraction(1, 1000),
    "cm": Fraction(1, 100),
    "dm": Fraction(1, 10),
    "m": Fraction(1),
    "km": Fraction(1000),
    "in": Fraction(254, 10_000),
    "ft": Fraction(3048, 10_000),
}
SECONDS = {"ms": Fraction(1, 1000), "s": Fraction(1), "min": Fraction(60), "h": Fraction(3600), "d": Fraction(86400)}
SPEEDS = {f"{length}/{time}": METRES[length] / SECONDS[time] for length in METRES for time in SECONDS}
SPEEDS["mph"] = Fraction(1_609_344, 3_600_000)
ACCELERATIONS = {
    f"{length}/s{square}": METRES[length] for length in ("mm", "cm", "m", "ft") for square in ("^2", "²", "2")
}
RATES = {f"/{time}": 3600 / SECONDS[time] for time in SECONDS}

TABLE = {
    "length": METRES,
    "time": SECONDS,
    "speed": SPEEDS,
    "acceleration": ACCELERATIONS,
    "rate": RATES,
    "share": {"%": Fraction(1, 100)},
}
EXAMPLES = {
    "length": "600 mm",
    "time": "15 min",
    "speed": "1.5 m/s",
    "acceleration": "0.5 m/s^2",
    "rate": "200 / h",
    "share": "25 %",
}
_POWERS = {"length": (1, 0), "time": (0, 1), "speed": (1, -1), "acceleration": (1, -2)}
"""Of the length and the time in the quantities of a kind."""

_WRITTEN = re.compile(r"\s*([+-]?(?:\d{1,20}\.?\d{0,20}|\.\d{1,20}))\s*([A-Za-z%/].*?)\s*")


@dataclass(frozen=True)
class UnitNames:
    """The units of a model: names of its length and time unit, and the seconds in the latter."""

    length: str = "m"
    time: str = "s"
    seconds: float = 1.0


def quantity(text: str, kind: str, units: UnitNames, bare: str = "") -> float:
    """Return a number, with a unit or without, in the units of a model.

    Args:
        text: such as `5 min` or `300`.
        kind: see `converted`.
        units: those of the model.
        bare: the unit of a number without one; empty: the unit of the model.

    Raises:
        ValueError: no such quantity.
    """
    size = converted(text, kind, units)
    if size is None and bare:
        size = converted(f"{text} {bare}", kind, units)
    if size is not None:
        return size
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"not a number or {_a(kind)} (got {got(text)}), expected one such as {EXAMPLES[kind]}")
    return number


def _a(kind: str) -> str:
    return f"an {kind}" if kind == "acceleration" else f"a {kind}"


def converted(text: str, kind: str, units: UnitNames) -> float | None:
    """Return a quantity in the units of a model, or None where the text is none.

    Args:
        text: a number and a unit.
        kind: length, time, speed, acceleration, rate (becomes a number an hour) or share (a number from 0 to 1).
        units: those of the model.

    Raises:
        ValueError: where the unit is not one of this kind, or the model's units have no known size.
    """
    written = _WRITTEN.fullmatch(text)
    if written is None:
        return None
    number, unit = Fraction(written[1]), written[2].replace(" ", "")
    units_of_kind = TABLE[kind]
    if unit not in units_of_kind:
        what = _a(kind)
        expected = f"{what} such as {EXAMPLES[kind]}"
        if kind not in {"speed", "acceleration"}:
            expected += f", in {spoken(units_of_kind, 'or')}"
        raise ValueError(f"not {what} (got {got(text)}), expected {expected}{did_you_mean(unit, units_of_kind)}")
    size = number * units_of_kind[unit]
    length_power, time_power = _POWERS.get(kind, (0, 0))
    if length_power:
        if units.length not in {"mm", "cm", "m"}:
            cure = f"write a plain number of {units.length}, or mm, cm or m in units.length"
            raise ValueError(f"cannot be converted (got {got(text)}), as units.length is '{units.length}'; {cure}")
        size /= METRES[units.length]
    if time_power:
        seconds = Fraction(repr(units.seconds))
        if SECONDS.get(units.time, seconds) != seconds:
            wrong = f"units.time is '{units.time}', but units.seconds is {got(units.seconds)}"
            raise ValueError(f"cannot be converted (got {got(text)}): {wrong}; correct one of the two")
        size /= seconds**time_power
    return float(size)
