"""Parse a planner's target, as in "throughput_per_hour >= 220", and amounts of indicators, as in "5 min".

For `--target` of every command, and for the table of indicators of an answer.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal, cast

from desim_warehouse.errors import StudyError
from desim_warehouse.outcome.indicators import INDICATORS, Indicator, hint, look_up
from desim_warehouse.values.units import UnitNames, quantity

Sense = Literal[">=", "<=", ">", "<"]

_TARGET = re.compile(
    r"\s*(?P<indicator>[A-Za-z_](?:[\w. -]*[\w.-])?(?:[:@][^<>=≥≤]*[^<>=≥≤\s])?)\s*(?P<sense>>=|<=|>|<|≥|≤)\s*"
    r"(?P<value>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(?P<unit>[A-Za-z%/][^<>=≥≤]*?)?\s*"
)
_KINDS = {"time": "time", "length": "length", "tasks per hour": "rate"}
"""Kinds of quantities by the units of indicators that people may write; shares take per cent."""


@dataclass(frozen=True)
class Target:
    """A bound on the mean of an indicator, in the indicator's unit; `unit` is its name, or "" without one."""

    measure: Indicator
    sense: Sense
    value: float
    unit: str = ""

    @property
    def indicator(self) -> str:
        """The name of the indicator."""
        return self.measure.name

    @property
    def sign(self) -> float:
        """+1 if the target is a lower bound, -1 if it is an upper bound."""
        return 1.0 if self.sense in (">=", ">") else -1.0

    @property
    def more_helps(self) -> bool:
        """Whether more robots are expected to help: True unless the indicator usually moves away from the target."""
        return self.measure.with_robots != ("falls" if self.sign > 0 else "rises")

    def met_by(self, mean: float) -> bool:
        """Whether an exactly known mean meets the target."""
        gap = self.sign * (mean - self.value)
        return gap >= 0.0 if self.sense in (">=", "<=") else gap > 0.0

    @property
    def missed(self) -> float:
        """A value that clearly misses the target, for runs that could not go on."""
        return self.value - self.sign * max(1.0, abs(self.value))

    @property
    def text(self) -> str:
        """The target with a plain number, as `parse_target` reads it."""
        return f"{self.indicator} {self.sense} {self.value:.15g}"

    def __str__(self) -> str:
        return f"{self.text} {self.unit}".strip()


def parse_target(text: str, units: UnitNames | None = None) -> Target:
    """Parse a target such as `throughput_per_hour >= 220` or `on_time >= 95 %`, without checking that it makes sense.

    Args:
        text: an indicator, a bound, a number, and optionally a unit, by default the model's.
        units: units of the model; None if not known yet, and the target then has no unit.

    Raises:
        StudyError: the text, the expected form, and the nearest indicator.
    """
    match = _TARGET.fullmatch(text)
    if match is None:
        raise StudyError(
            f"target {text!r}: expected an indicator, one of >= <= > <, and a number, "
            "as in 'throughput_per_hour >= 220'"
        )
    name, number, unit = match["indicator"], match["value"], match["unit"]
    measure = look_up(name)
    if measure is None:
        raise StudyError(f"target {text!r}: unknown indicator {name!r}, {hint(name, INDICATORS)}")
    value = float(number) if unit is None else amount_of(measure, f"{number} {unit}", units, f"target {text!r}")
    sense = cast("Sense", {"≥": ">=", "≤": "<="}.get(match["sense"], match["sense"]))
    named = "" if units is None else {"time": units.time, "length": units.length}.get(measure.unit, "")
    return Target(measure, sense, value, named)


def amount_of(measure: Indicator, text: str, units: UnitNames | None, where: str) -> float:
    """Parse an amount of an indicator, such as `5 min` or `1 %`, and return it in the indicator's unit.

    Args:
        measure: the indicator.
        text: a number, and optionally a unit.
        units: units of the model; None if not known yet.
        where: the option or key as the user wrote it, for the message.

    Raises:
        StudyError: not a number, or a unit of another kind.
    """
    kind = "share" if measure.is_share else _KINDS.get(measure.unit)
    if kind != "share" and text.endswith("%"):
        raise StudyError(f"{where}: {measure.name} is no share, expected a number without %")
    try:
        if kind is None:
            return float(text)
        return quantity(text, kind, units or UnitNames())
    except ValueError as error:
        plain = f"not a number (got {text}), as {measure.name} has no unit" if kind is None else str(error)
        raise StudyError(f"{where}: {plain}") from None
