"""A planner's target, as in "throughput_per_hour >= 220", and amounts of indicators as people write them.

For `--target` of every command that has it, and for the table of indicators of an answer.
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
"""Kinds of units of indicators that have units of their own; shares are in per cent."""


@dataclass(frozen=True)
class Target:
    """A bound on the mean of an indicator, in the indicator's unit; `unit` is the unit's name, where it has one."""

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
        """+1 where more is better, -1 where less is."""
        return 1.0 if self.sense in (">=", ">") else -1.0

    @property
    def more_helps(self) -> bool:
        """Whether more robots are expected to do no worse: True unless the indicator usually moves the other way."""
        return self.measure.with_robots != ("falls" if self.sign > 0 else "rises")

    def met_by(self, mean: float) -> bool:
        """Whether a mean that is known exactly meets the target."""
        gap = self.sign * (mean - self.value)
        return gap >= 0.0 if self.sense in (">=", "<=") else gap > 0.0

    @property
    def missed(self) -> float:
        """A value that clearly misses the target, for runs that could not go on."""
        return self.value - self.sign * max(1.0, abs(self.value))

    @property
    def text(self) -> str:
        """The target as it is read again: with a plain number."""
        return f"{self.indicator} {self.sense} {self.value:.15g}"

    def __str__(self) -> str:
        return f"{self.text} {self.unit}".strip()


def parse_target(text: str, units: UnitNames | None = None) -> Target:
    """Read a target such as `throughput_per_hour >= 220` or `on_time >= 95 %`, sensible or not.

    Args:
        text: an indicator, a bound, a number, and a unit or none: then it is in the unit of the model.
        units: of the model; None: not known yet, and the target has none.

    Raises:
        StudyError: the text, what was expected, and the nearest indicator.
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
    """Read an amount of an indicator, such as `5 min` or `1 %`, in the unit in which runs give it.

    Args:
        measure: the indicator.
        text: a number, and a unit or none.
        units: of the model; None: not known yet.
        where: the option or key as the user wrote it, for the message.

    Raises:
        StudyError: no number, or a unit of another kind.
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
