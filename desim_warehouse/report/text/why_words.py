"""The answer of `desim why` in sentences."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.errors import number_of, spoken
from desim_warehouse.outcome.indicators import find
from desim_warehouse.report.text import numbers, words
from desim_warehouse.report.text.root_words import root

if TYPE_CHECKING:
    from desim_warehouse.model import Model
    from desim_warehouse.model.schema import Units
    from desim_warehouse.study.reliefs.suspect import Suspect
    from desim_warehouse.study.statistics import Gain
    from desim_warehouse.study.why import Failure, Health, Why

_ROOTS_SAID = 3
_MANY = 1000  # per cent
_FAILS = {"BatteryError": "runs flat", "StallError": "stalls", "GridlockError": "jams for good"}
"""What a run does that could not go on, by its error."""


def sentence(found: Why, units: Units) -> str:
    """What holds the warehouse up and what that costs, or that nothing does."""
    failure = found.failures.get(0)
    if failure is not None:
        return f"As it is, it {fails(failure)}. {_said(failure)}"
    if not found.is_held_up and found.state is not None:
        known = found.gains.none or found.is_clear
        return f"Nothing holds it up: {state(found.state)}.{f' {_gains(found, units)}' if known else ''}"
    return _gains(found, units)


def batched(found: Why) -> str:
    """How long tasks waited for others to go with them; empty where none did."""
    if not found.batched:
        return ""
    return f"{numbers.PERCENT.value(found.batched)} of a task's time was waiting for a batch in the run looked at."


def lost(found: Why, model: Model) -> str:
    """How long robots waited in the run that was looked at, and for what most of it; empty where nobody waited."""
    if not found.lost:
        return ""
    most = [
        f"{numbers.PERCENT.value(share)} {root(one, model)}" for one, share in list(found.lost.items())[:_ROOTS_SAID]
    ]
    whole = numbers.PERCENT.value(math.fsum(found.lost.values()))
    return f"Robots waited {whole} of their time in the run looked at: {spoken(most)}."


def state(now: Health) -> str:
    """How the warehouse does as it is."""
    due = [] if now.on_time is None else [f"{100 * now.on_time:.3g} % on time"]
    return ", ".join([f"robots idle {100 * now.idle:.0f} %", *due])


def fails(failure: Failure) -> str:
    """How often runs could not go on."""
    verb = next((said for kind, said in _FAILS.items() if failure.text.startswith(kind)), "fails")
    return f"{verb} in {failure.failed} of {number_of(failure.runs, 'run')}"


def _said(failure: Failure) -> str:
    text = failure.text.partition(": ")[2] or failure.text
    return f"{text[:1].upper()}{text[1:]}."


def _gains(found: Why, units: Units) -> str:
    """What gains most for an equal dose, and what everything else gains at most."""
    unit = unit_of(found, units)
    competing = [(suspect, gain) for suspect, gain in found.found if gain.competes]
    if not competing:
        return f"Nothing that was tried made a difference in {number_of(found.gains.runs, 'run')}."
    (suspect, most), *others = competing
    if found.gains.none:
        return f"Nothing that was tried gains {amount(found, found.gains.delta)}{unit} or more."
    if found.is_clear and not found.is_held_up:
        return f"{suspect.relief.capitalize()} gains {amount(found, most.mean)}{unit} ({interval(found, most)})."
    if found.is_clear:
        rest = max((gain.each.high for one, gain in others if one.name != suspect.name), default=None)
        per = f" for {DOSE}" if any(one.dose is not None for one, _ in competing) else ""
        more = "" if rest is None else f"; nothing else gains more than {amount(found, max(rest, 0.0), up=True)}{per}"
        if len(found.found) > 1 and all(gain.same for _, gain in found.found[1:]):
            more = f"; nothing else made a difference in {number_of(most.n, 'run')}"
        return f"{_answer(found, suspect, most, unit)}{more}.{_largest(found, competing[:1], competing)}"
    leader = most.each.low
    near = [(one, gain) for one, gain in competing if gain.each.high >= leader and gain.high > 0]
    listed = spoken(
        [f"{one.relief} {amount(found, gain.each.mean)} ({interval(found, gain.each)})" for one, gain in near[:4]]
    )
    unclear = f"Too close to tell after {most.n} replications what gains most{unit} for {DOSE}: {listed}."
    return unclear + _largest(found, near[:4], competing)


def _largest(found: Why, named: list[tuple[Suspect, Gain]], competing: list[tuple[Suspect, Gain]]) -> str:
    """What is sure to gain most as a whole, however large a change it takes; empty where it is named first anyway."""
    suspect, most = max(competing, key=lambda item: item[1].mean)
    if suspect is named[0][0] or any(gain.high >= most.low for one, gain in named if one is not suspect):
        return ""
    return f" As a whole {suspect.relief} gains most: {amount(found, most.mean)} ({interval(found, most)})."


DOSE = "each 10 %"


def _answer(found: Why, suspect: Suspect, gain: Gain, unit: str) -> str:
    """What the winner costs, where it is in the way, or what more of it gains."""
    name = f"{suspect.name[:1].upper()}{suspect.name[1:]}"
    whole = f"{amount(found, gain.mean)}{unit} ({interval(found, gain)})"
    if suspect.dose is None:
        several = sum(one.name == suspect.name for one, _ in found.found) > 1
        return f"{name} {_costs(suspect.name)} {whole}{f' by this relief: {suspect.relief}' if several else ''}"
    each = f", {amount(found, gain.each.mean)} for {DOSE}"
    return (
        f"{name} {'holds' if _costs(suspect.name) == 'costs' else 'hold'} it up: {suspect.relief} gains {whole}{each}"
    )


def _costs(name: str) -> str:
    """The verb for a suspect: intersections cost, an intersection costs."""
    first = name.split(maxsplit=1)[0]
    return "cost" if first.endswith("s") or name.endswith("lanes") or first == "people" else "costs"


def dose(suspect: Suspect) -> str:
    """A relief as a part of what is there."""
    if suspect.dose is None:
        return "all"
    percent = 100 * suspect.dose
    text = f"{percent:+,.0f} %" if abs(percent) >= _MANY else f"{percent:+.3g} %"
    return text.replace("-", "\N{MINUS SIGN}")


def unit_of(found: Why, units: Units) -> str:
    """The unit of the costs, with what they are of."""
    indicator = find(found.indicator)
    if indicator.unit == "tasks per hour":
        return " tasks an hour"
    unit = words.unit(indicator.unit, units)
    if indicator.is_share:
        return f" points of {found.indicator}"
    named = words.in_sentence(found.indicator)
    if indicator.unit == "count":
        return f" {named}"
    return f" {unit} of {named}" if unit else f" of {named}"


def amount(found: Why, value: float, *, up: bool = False) -> str:
    """A cost with as many digits as count; `up`: rounded up, as a bound is."""
    value *= 100 if find(found.indicator).is_share else 1
    digits = max(0, 1 - math.floor(math.log10(abs(value)))) if value else 0
    shown = math.ceil(value * 10**digits) / 10**digits if up else value
    return numbers.number(shown, digits)


def interval(found: Why, gain: Gain) -> str:
    """Its interval in words."""
    if gain.low == gain.high:
        return "exact"
    return f"{amount(found, gain.low)} to {amount(found, gain.high)}"
