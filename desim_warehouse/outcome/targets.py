"""A planner's target, as in "throughput_per_hour >= 220"."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal, cast

from desim_warehouse.errors import StudyError, nearest

Sense = Literal[">=", "<=", ">", "<"]

_TARGET = re.compile(
    r"\s*(?P<indicator>[A-Za-z_](?:[\w. -]*[\w.-])?(?:[:@][^<>=≥≤]*[^<>=≥≤\s])?)\s*(?P<sense>>=|<=|>|<|≥|≤)\s*"
    r"(?P<value>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*"
)


@dataclass(frozen=True)
class Target:
    """A bound on the mean of an indicator, in the indicator's unit; `unit` is the name of it, where it has one."""

    indicator: str
    sense: Sense
    value: float
    unit: str = ""

    @property
    def sign(self) -> float:
        """+1 where more is better, -1 where less is."""
        return 1.0 if self.sense in (">=", ">") else -1.0

    def met_by(self, mean: float) -> bool:
        """Whether a mean that is known exactly meets the target."""
        gap = self.sign * (mean - self.value)
        return gap >= 0.0 if self.sense in (">=", "<=") else gap > 0.0

    @property
    def missed(self) -> float:
        """A value that clearly misses it, for runs that could not go on."""
        return self.value - self.sign * max(1.0, abs(self.value))

    @property
    def text(self) -> str:
        """As it is read again: a plain number."""
        return f"{self.indicator} {self.sense} {self.value:.15g}"

    def __str__(self) -> str:
        return f"{self.text} {self.unit}".strip()


def parse_target(text: str, known: Collection[str] | None = None) -> Target:
    """Read a target such as "throughput_per_hour >= 220" or "T < 95.5".

    With `known`, the indicator must be one of these names.

    Raises:
        StudyError: the text, what was expected, and the nearest known name.
    """
    match = _TARGET.fullmatch(text)
    if match is None:
        raise StudyError(
            f"target {text!r}: expected an indicator, one of >= <= > <, and a number, "
            "as in 'throughput_per_hour >= 220'"
        )
    indicator = match["indicator"]
    if known is not None and indicator not in known:
        near = nearest(indicator, known)
        hint = f", did you mean {near!r}?" if near else f", expected one of {', '.join(sorted(known))}"
        raise StudyError(f"target {text!r}: unknown indicator {indicator!r}{hint}")
    sense = cast("Sense", {"≥": ">=", "≤": "<="}.get(match["sense"], match["sense"]))
    return Target(indicator, sense, float(match["value"]))
