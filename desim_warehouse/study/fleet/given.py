"""What people ask of a fleet, as they write it: `30%` more demand, `6..20` robots, a zone of `1 %`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from desim_warehouse.errors import StudyError, got
from desim_warehouse.model import Model
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.outcome.indicators import refuse_unknown
from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.factors import listed
from desim_warehouse.study.statistics.limits import MOST_YEARS
from desim_warehouse.study.target import indifference, read_targets
from desim_warehouse.values.units import UnitNames, quantity

MOST_TIMES = 10.0
"""Times today's demand; a larger number without % was probably meant in per cent."""
A_YEAR = "/year"


def growth_of(given: float | str | None, named: str) -> float | None:
    """The factor of demand that a growth such as `30%`, or a factor from 1 to 10 such as `1.3`, is; None: not given.

    Raises StudyError, which calls it `named`.
    """
    if given is None:
        return None
    text = f"{given}".strip()
    is_share = text.endswith("%")
    try:
        number = quantity(text, "share", UnitNames())
    except ValueError:
        number = math.nan
    grown = round(1 + number, 12) if is_share else number
    if not 0 < grown < math.inf:
        raise StudyError(f"{named}: {text!r} is no growth such as 30%, or 1.3 times.")
    if not is_share and not 1 < grown <= MOST_TIMES:
        meant = f"{number:g}%" if number > MOST_TIMES else f"{100 * number:g}% or {1 + number:g}"
        raise StudyError(f"{named}: {text} times as much: did you mean {meant}?")
    return grown


def demands_of(growth: float | str | None, years: int | None, named: str) -> list[float]:
    """The factors of the demands after today's: of one growth, or of each of so many years that grow by `20%/year`.

    Raises as `growth_of`.
    """
    text = "" if growth is None else f"{growth}".strip()
    each = text.removesuffix(A_YEAR)
    if (years is None) == (each != text):
        raise StudyError(f"{named}: {text or 'none'}: years need a growth such as 20%/year, and that how many years")
    if years is None:
        times = growth_of(growth, named)
        return [] if times is None else [times]
    if not 1 <= years <= MOST_YEARS:
        raise StudyError(f"years: {years}, expected 1 to {MOST_YEARS}")
    times = growth_of(each, named)
    if times is None or times <= 1:
        raise StudyError(f"{named}: {text}: expected demand that grows, such as 20%/year")
    return [round(times**year, 9) for year in range(1, years + 1)]


def packers_of(given: str | None, named: str) -> tuple[str, list[int] | None] | None:
    """A station and how many packers it could have, such as `packing=1..4`; `packing`: by estimate; None: not given.

    Raises as `growth_of`.
    """
    if given is None:
        return None
    station, _, values = (part.strip() for part in given.partition("="))
    return station, counts_of(values or None, f"{named} {station}")


def counts_of(given: Sequence[int] | str | None, named: str) -> list[int] | None:
    """Whole numbers from 1 upwards, such as `1..8` or `4,6,8`, or a sequence of them; None: not given.

    Raises as `growth_of`.
    """
    if given is None:
        return None
    values: Any = given
    if isinstance(given, str):
        written = read_yaml(f"[{given}]", named)
        values = [] if written.problems else written.data
    try:
        found = listed(values)
    except (TypeError, ValueError):
        found = []
    numbers = [value for value in found if isinstance(value, int) and not isinstance(value, bool) and value > 0]
    if not numbers or len(numbers) < len(found) or numbers != sorted(set(numbers)):
        text = given if isinstance(given, str) else got(given)
        raise StudyError(f"{named} {text}: expected whole numbers upwards from 1, such as 1..8")
    return numbers


def goals_of(
    target: str | Sequence[str], zone: float | str | None, model: Model
) -> tuple[Target, float, tuple[tuple[Target, float], ...]]:
    """Read the first target with its indifference zone, and the further ones with theirs."""
    units = model.units.names
    goal, *others = read_targets(target, units)
    for one in (goal, *others):
        refuse_unknown(one.indicator, [model])
    if others and zone is not None:
        raise StudyError(f"--zone {zone}: for one target alone, expected none beside several targets")
    return goal, indifference(goal, zone, units), tuple((other, indifference(other, None, units)) for other in others)
