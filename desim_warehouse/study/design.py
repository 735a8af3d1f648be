"""The design of a study: the models that it simulates, as design points made of factors by a rule.

For every study: the factors of a study file, of `desim what-if` and of the searches that vary keys.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from desim_warehouse.errors import StudyError
from desim_warehouse.model.messages import Keys
from desim_warehouse.study.factors import Factor, Label, Level
from desim_warehouse.values.labels import readable

Rule: TypeAlias = Literal["grid", "paired"]
"""How points come from factors: all combinations of their values, or their first values, then their second ones."""


@dataclass(frozen=True)
class Point:
    """One design point: its labels in tables, and its changes to the model."""

    number: int
    labels: Mapping[str, Label]
    overrides: Mapping[str, Any]
    positions: Mapping[str, Keys]  # where each change stands in the study file

    def __str__(self) -> str:
        """Return the design in words: `fleet.size=3, battery.threshold=2`."""
        return ", ".join(f"{key}={readable(value)}" for key, value in self.labels.items()) or "the model as it is"


def points(factors: Sequence[Factor], rule: Rule) -> list[Point]:
    """Make the design points, in a fixed order: in a grid the last factor changes fastest."""
    if not factors:
        return [_point(0, [], ())]
    lists = [factor.levels for factor in factors]
    rows = itertools.product(*lists) if rule == "grid" else zip(*lists, strict=True)
    return [_point(number, factors, row) for number, row in enumerate(rows)]


def count(factors: Sequence[Factor], rule: Rule) -> int:
    """Return the number of design points, without making them."""
    lengths = [len(factor.levels) for factor in factors]
    return min(lengths, default=1) if rule == "paired" else math.prod(lengths)


def baseline_point(among: Sequence[Point], wanted: Mapping[str, Label] | None) -> Point:
    """Return the design point that others are compared with: the first that has these values of factors.

    Raises:
        StudyError: where no point has these values.
    """
    for point in among:
        if all(point.labels.get(key) == value for key, value in (wanted or {}).items()):
            return point
    levels = ", ".join(f"{key}={readable(value)}" for key, value in (wanted or {}).items())
    raise StudyError(f"baseline: no design with {levels}, expected values of the factors such as {among[0]}")


def _point(number: int, factors: Sequence[Factor], levels: Sequence[Level]) -> Point:
    labels = {factor.key: level.label for factor, level in zip(factors, levels, strict=True)}
    overrides = {key: value for level in levels for key, value in level.overrides.items()}
    positions = {key: level.keys for level in levels for key in level.overrides}
    return Point(number, labels, overrides, positions)
