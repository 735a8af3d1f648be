"""The answer of `desim why` in a sentence."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.errors import spoken
from desim_warehouse.outcome.indicators import find
from desim_warehouse.report.text import words

if TYPE_CHECKING:
    from desim_warehouse.model.schema import Units
    from desim_warehouse.study.statistics import Gain
    from desim_warehouse.study.why import Why


def sentence(found: Why, units: Units) -> str:
    """What costs most, and what everything else costs at most."""
    (suspect, most), *others = found.found
    unit = unit_of(found, units)
    name = f"{suspect.name[:1].upper()}{suspect.name[1:]}"
    rest = max((gain.high for _, gain in others), default=0.0)
    if found.gains.none:
        return f"Nothing that was tried costs {amount(found, found.gains.delta)}{unit} or more."
    if found.gains.clear:
        more = f"; nothing else costs more than {amount(found, max(rest, 0.0), up=True)}" if others else ""
        return f"{name} {_costs(suspect.name)} {amount(found, most.mean)}{unit} ({interval(found, most)}){more}."
    near = [(one, gain) for one, gain in found.found if gain.high >= most.low and gain.high > 0]
    listed = spoken([f"{one.name} {amount(found, gain.mean)} ({interval(found, gain)})" for one, gain in near[:4]])
    return f"Too close to tell after {most.n} replications which costs most{unit}: {listed}."


def _costs(name: str) -> str:
    """The verb for a suspect: intersections cost, an intersection costs."""
    first = name.split(maxsplit=1)[0]
    return "cost" if first.endswith("s") or first == "people" else "costs"


def unit_of(found: Why, units: Units) -> str:
    """The unit of the costs, with what they are of."""
    indicator = find(found.indicator)
    if indicator.unit == "tasks per hour":
        return " tasks an hour"
    unit = words.unit(indicator.unit, units)
    if indicator.is_share:
        return f" points of {found.indicator}"
    of = f" of {words.in_sentence(found.indicator)}"
    return f" {unit}{of}" if unit else of


def amount(found: Why, value: float, *, up: bool = False) -> str:
    """A cost with as many digits as count; `up`: rounded up, as a bound is."""
    import math

    value *= 100 if find(found.indicator).is_share else 1
    digits = max(0, 1 - math.floor(math.log10(abs(value)))) if value else 0
    shown = math.ceil(value * 10**digits) / 10**digits if up else value
    return words.number(shown, digits)


def interval(found: Why, gain: Gain) -> str:
    """Its interval in words."""
    if gain.low == gain.high:
        return "exact"
    return f"{amount(found, gain.low)} to {amount(found, gain.high)}"
