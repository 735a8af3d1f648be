"""Reading of the inputs of a plan as users write them: `30%` more demand, `6..20` robots, a zone of `1 %`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from desim_warehouse.errors import StudyError, got, shown
from desim_warehouse.model import Model
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.outcome.indicators import refuse_unknown
from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.factors import listed
from desim_warehouse.study.statistics.limits import MOST_YEARS
from desim_warehouse.study.target import indifference, read_targets
from desim_warehouse.values.arguments import is_whole
from desim_warehouse.values.units import UnitNames, quantity

MOST_TIMES = 10.0
"""Largest factor of today's demand; a larger number without % was probably meant in per cent."""
A_YEAR = "/year"


def growth_of(growth: float | str | None, named: str) -> float | None:
    """Read growth such as `30%`, or a factor from 1 to 10 such as `1.3`, as a factor of demand; None without growth.

    Raises StudyError, which calls it `named`.
    """
    if growth is None:
        return None
    text = f"{growth}".strip()
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
    """Return the factors of later demands: of one growth, or of each of some years with growth such as `20%/year`.

    Raises as `growth_of`.
    """
    text = "" if growth is None else f"{growth}".strip()
    each = text.removesuffix(A_YEAR)
    is_yearly = each != text
    if years is not None and not is_yearly:
        raise StudyError(f"--years {years}: also needs a yearly growth (--growth 20%/year)")
    if years is None and is_yearly:
        raise StudyError(f"--growth {text}: also say for how many years (--years 3)")
    if years is None:
        times = growth_of(growth, named)
        return [] if times is None else [times]
    if not is_whole(years, 1, MOST_YEARS):
        raise StudyError(f"years: {shown(years):.60}, expected a whole number from 1 to {MOST_YEARS}")
    times = growth_of(each, named)
    if times is None or times <= 1:
        raise StudyError(f"{named}: {text}: expected demand that grows, such as 20%/year")
    return [round(times**year, 9) for year in range(1, years + 1)]


def counts_of(counts: Sequence[int] | str | None, named: str) -> list[int] | None:
    """Read positive whole numbers such as `1..8` or `4,6,8`, or a sequence of them; return None for None.

    Raises as `growth_of`.
    """
    if counts is None:
        return None
    values: Any = counts
    if isinstance(counts, str):
        written = read_yaml(f"[{counts}]", named)
        values = [] if written.problems else written.data
    try:
        items = listed(values)
    except (TypeError, ValueError):
        items = []
    numbers = [value for value in items if isinstance(value, int) and not isinstance(value, bool) and value > 0]
    if not numbers or len(numbers) < len(items) or numbers != sorted(set(numbers)):
        text = counts if isinstance(counts, str) else got(counts)
        raise StudyError(f"{named} {text}: expected whole numbers upwards from 1, such as 1..8")
    return numbers


def goals_of(
    target: str | Sequence[str], zone: float | str | None, model: Model
) -> tuple[Target, float, tuple[tuple[Target, float], ...]]:
    """Read the first target with its indifference zone, and the further ones with theirs."""
    units = model.units.names
    goal, *others = read_targets(target, units)
    for each_goal in (goal, *others):
        refuse_unknown(each_goal.indicator, [model])
    if others and zone is not None:
        raise StudyError(f"--zone {zone}: for one target alone, expected none beside several targets")
    return goal, indifference(goal, zone, units), tuple((other, indifference(other, None, units)) for other in others)
