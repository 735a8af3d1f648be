"""Implausible values and combinations: times, rates, capacities, prices and numbers of resources.

For `desim check`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from desim_warehouse.errors import number_of, spoken
from desim_warehouse.feasibility.batteries import MINUTE
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.feasibility.power import Power
from desim_warehouse.findings import Finding, amount
from desim_warehouse.model.facts.charging import by_kind, kind_in_words, levels, start_energy
from desim_warehouse.model.facts.demand import order_files
from desim_warehouse.model.facts.keys import kind_of, whole_annotation
from desim_warehouse.model.schema import Model, Prices, Units
from desim_warehouse.model.sections.fleet import BatterySpec
from desim_warehouse.policies import catalogue
from desim_warehouse.values.distributions import DiscreteTime, Distribution, mean_of
from desim_warehouse.values.disturbances import BreakdownSpec, DelaySpec, OutageSpec
from desim_warehouse.values.fields import Part, Usual, parts_in, sections_in
from desim_warehouse.values.units import METRES, SECONDS

HOUR = 3600.0
MOST_CV = 3.0
"""Largest usual coefficient of variation of a time."""
LONGEST_BATTERY, LONGEST_CHARGE = 100 * HOUR, 16 * HOUR
"""Longest time that a battery lasts at work, and longest time to charge it, in seconds."""
FAST_CHARGE, MOST_TO_ONE = 300.0, 20.0
"""A battery that is full within the first, in seconds, lasts at most the second times as long."""
SHORT_LIFE, LEAST_TO_ONE = 1800.0, 8.0
"""A battery that lasts for less than the first, in seconds, is a capacitor: it lasts at least the second times as long
as it takes to charge.
"""
MOST_LOST = 20.0
"""Largest mean time, in seconds, that robots lose at a node: they slip at a few nodes, for seconds."""
ROBOT_A_YEAR, CHARGER_A_YEAR = 15_000.0, 8_000.0
"""Prices a year above which a purchase price is probably meant."""
FULL_BATTERY = 10.0
"""Largest cost of a full battery, of 20 kWh or so, in EUR or a similar currency."""

ALIKE = ("EUR", "USD", "GBP", "CHF", "CAD", "AUD", "€", "$", "£")
"""Currencies of about equal value, for which the usual prices hold; prices in others are not judged."""
LONG = 3600.0
"""Length of a run, in seconds, from which on events only within its first minute are probably meant in minutes or
hours.
"""
AT_START, MOST_AT_START = 0.01, 300.0
"""Share of a run, and seconds, within which all events of a key are probably meant in minutes or hours."""


def warnings(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    """Find unusual values; none if the model's unit of length is unknown, as its size is then uncertain."""
    if estimate.metre is None:
        return
    yield from _of_keys(model)
    for place, part in parts_in(model, tuple(Distribution.__subclasses__())):
        assert isinstance(part, Distribution)
        yield from _distribution(place, part)
    yield from _disturbances(model)
    yield from _handling(model)
    yield from _kinds(model)
    yield from _energy_price(model)
    yield from _warm_up(model, estimate)
    yield from _battery(model, estimate)


def notes(model: Model) -> Iterator[Finding]:
    """Find unusual values that may be meant, but are often a slip."""
    prices = model.prices
    if prices is not None:
        robots = {"robot": prices.robot, **{f"kinds.{name}": price for name, price in prices.kinds.items()}}
        most = {**dict.fromkeys(robots, ROBOT_A_YEAR), "charger": CHARGER_A_YEAR}
        for key, price in {**robots, "charger": prices.charger}.items():
            if price > most[key]:
                text = f"{amount(price)} a year for each"
                yield Finding("PRICE_A_YEAR", f"prices.{key}", text, "a price of purchase: divide by the years of use")
    for file in order_files(model):
        if file.tasks > file.rows and model.pods is None:  # a visit of a pod serves many lines
            yield Finding(
                "QUANTITY_IS_TRIPS",
                "tasks.flows",
                f"{file.rows:,} rows of orders are {file.tasks:,} tasks by their quantity: each is a trip",
                "where pieces of a row go together in one load, desim orders FILE --quantity pieces",
            )


# Times


def _distribution(place: str, times: Distribution) -> Iterator[Finding]:
    """Find times with an implausible variation, and weights that do not add up to 1."""
    if times.cv > MOST_CV:
        meant = f"; did you mean {times.cv / 100:g} ({times.cv:g} %)?" if times.cv <= 100 else ""  # noqa: PLR2004
        text = f"a coefficient of variation of {amount(times.cv)}: most times would be far below the mean"
        yield Finding("UNUSUAL", place, text, f"it is standard deviation / mean, mostly 0.1 to 1{meant}")
    weights = (times.discrete.weights or ()) if isinstance(times, DiscreteTime) else ()
    total = math.fsum(weights)
    if weights and max(weights) < 1 and not math.isclose(total, 1, abs_tol=0.005):
        text = f"chances that add up to {amount(total)}: each is taken as its part of that"
        yield Finding("UNUSUAL", f"{place}.discrete.weights", text, "chances that add up to 1, or whole numbers")


def _disturbances(model: Model) -> Iterator[Finding]:
    """Find repairs longer than the time between failures, and delays that take most of the time."""
    unit = model.units.time
    for place, part in parts_in(model, (BreakdownSpec, OutageSpec)):
        assert isinstance(part, BreakdownSpec | OutageSpec)
        every, repair = mean_of(part.every), mean_of(part.repair)
        if repair > every:
            text = f"{amount(every)} {unit} from one failure to the next, and {amount(repair)} to repair it"
            yield Finding("UNUSUAL", place, text, f"times are in {unit}")
        if isinstance(part, BreakdownSpec) and part.clear is not None and mean_of(part.clear) > repair:
            text = f"it is cleared from the lanes after {amount(mean_of(part.clear))} {unit}, and repaired after "
            cure = "clear: until it is off the lanes; repair: until it works again, both from the breakdown on"
            yield Finding("UNUSUAL", f"{place}.clear", f"{text}{amount(repair)}", cure)
    for place, part in parts_in(model, (DelaySpec,)):
        assert isinstance(part, DelaySpec)
        lost = part.share * mean_of(part.time)
        if lost * model.units.seconds > MOST_LOST and model.units.has_seconds:
            text = f"robots lose {amount(lost)} {unit} at every node on average: {part.share:.0%} of {part.time}"
            if isinstance(part.time, Distribution):
                text = f"robots lose {amount(lost)} {unit} at every node on average"
            yield Finding("UNUSUAL", place, text, f"a smaller share of nodes, or a shorter time; times are in {unit}")


def _handling(model: Model) -> Iterator[Finding]:
    """Find loading or unloading that takes no time, if no other key gives it a time."""
    tasks, stations = model.tasks, model.layout.stations.values()
    if not tasks.never_end:  # a list of tasks may be one of a benchmark of routes
        return
    for key in ("load_time", "unload_time"):
        others = [
            *(getattr(flow, key) for flow in tasks.flows.values()),
            *(getattr(station, key) for station in stations),
        ]
        if mean_of(getattr(tasks, key)) == 0 and not any(others):
            doing = key.removesuffix("_time")
            yield Finding("UNUSUAL", f"tasks.{key}", f"robots {doing} in no time", f"a time such as {key}: 10 s")


def _warm_up(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    """Find a warm-up in which no task gets done, if the number is plausible in minutes or hours."""
    run, units = model.run, model.units
    if not (model.tasks.never_end and run.length and 0 < run.warm_up < estimate.cycle.time):
        return
    times = {name: run.warm_up * float(SECONDS[name]) / units.seconds for name in ("min", "h")}
    meant = [name for name, time in times.items() if estimate.cycle.time <= time <= run.length / 2]
    if meant:
        text = f"{run.warm_up:g} {units.time}: one task takes {amount(estimate.cycle.time)} {units.time}"
        yield Finding("UNUSUAL", "run.warm_up", text, f"did you mean {run.warm_up:g} {meant[0]}?")


# Totals


def _kinds(model: Model) -> Iterator[Finding]:
    """Find kinds that make up nearly the whole fleet, so that few robots are left without a kind."""
    fleet = model.fleet
    counted = sum(kind.count for kind in fleet.kinds.values())
    left = fleet.size - counted
    if len(fleet.kinds) > 1 and 0 < left <= counted / 2:
        text = (
            f"{' + '.join(str(kind.count) for kind in fleet.kinds.values())} of fleet.size, {fleet.size}: "
            f"{number_of(left, 'robot')} of no kind, as fleet.robot says"
        )
        yield Finding("KINDS_AND_SIZE", "fleet.kinds", text, f"fleet.size: {counted}, or counts that add up to it")


def _energy_price(model: Model) -> Iterator[Finding]:
    """Find a price of energy at which a full battery costs more than any does."""
    prices, battery = model.prices, model.battery
    if prices is None or battery is None or not comparable(prices.currency):
        return
    full = prices.energy * battery.capacity
    if full > FULL_BATTERY:
        text = f"a full battery of {amount(battery.capacity)} would cost {amount(full)}"
        yield Finding("UNUSUAL", "prices.energy", text, "the price of one unit of battery.capacity, such as a Wh")


# Batteries


def _battery(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    """Find charging rates that do not fit the capacity, and robots that start nearly flat; by kind if kinds differ."""
    if estimate.power is None:
        return
    for kind, alone in by_kind(model).items():
        for finding in _of_battery(alone, estimate.power.kinds.get(kind, estimate.power)):
            yield replace(finding, text=f"{kind_in_words(kind)}: {finding.text}") if estimate.power.kinds else finding
        if not estimate.power.kinds:
            return


def _of_battery(model: Model, power: Power) -> Iterator[Finding]:
    battery = model.battery
    assert battery is not None
    seconds = model.units.seconds
    lasts, fills = power.lasts * seconds, battery.capacity / battery.charge_rate * seconds
    unit = f"capacity, consumption and charge_rate are in one unit of energy, the latter two per {model.units.time}"
    work_and_charge = f"lasts {with_unit(lasts, 'time')} of work, and takes {with_unit(fills, 'time')} to charge"
    if LONGEST_BATTERY < lasts < math.inf or fills > LONGEST_CHARGE:
        yield Finding("BATTERY_RATES", "battery", f"a full battery {work_and_charge}", unit)
    elif MINUTE <= fills < FAST_CHARGE and lasts > MOST_TO_ONE * fills:
        text = f"an empty battery is full in {with_unit(fills, 'time')}, and lasts {with_unit(lasts, 'time')} of work"
        yield Finding("BATTERY_RATES", "battery.charge_rate", text, unit)
    elif lasts < SHORT_LIFE and lasts < LEAST_TO_ONE * fills:
        yield Finding("BATTERY_RATES", "battery.consumption", f"a full battery {work_and_charge}", unit)
    yield from _states(battery)
    thresholds = levels(model)
    start = max(start_energy(model)) * battery.capacity
    if thresholds is not None and start <= thresholds.critical:
        text = (
            f"every robot starts with at most {amount(start)} of {amount(battery.capacity)}, and charges at "
            f"{amount(thresholds.critical)}: none works before it has charged"
        )
        yield Finding("START_LOW", "fleet.start_energy", text, "a share of the capacity, such as {uniform: [0.4, 1]}")


def _states(battery: BatterySpec) -> Iterator[Finding]:
    """Find states in which a robot draws less than in others that need less work."""
    draws, place = battery.draws, "battery.consumption"
    if not any((draws.standing, draws.empty, draws.loaded, draws.handling)):
        text = "robots draw no energy at all, so none ever has to charge"
        yield Finding("CHANGES_NOTHING", place, text, "what they draw, or a model without battery")
    elif draws.loaded < draws.empty:
        text = f"robots draw {draws.loaded:g} with a load, and {draws.empty:g} without"
        yield Finding("BATTERY_RATES", f"{place}.loaded", text, f"at least as much as empty, {draws.empty:g}")
    elif draws.standing > draws.empty:
        text = f"robots draw {draws.standing:g} standing, and {draws.empty:g} driving"
        yield Finding("BATTERY_RATES", f"{place}.standing", text, f"at most as much as empty, {draws.empty:g}")


# Single keys: the usual range stands beside the type of a field (`Usual`)


def _of_keys(model: Model) -> Iterator[Finding]:
    """Find unusual values of keys, and of parameters of policies; of the instants of a list the last is looked at."""
    last: dict[str, tuple[float, str, Usual, str]] = {}
    for place, part in parts_in(model, _with_usual()):
        of_list, _, rank = place.rpartition(".")
        for name, key, usual, kind in _usual_keys(type(part)):
            if not _judged(model, part, usual, kind):
                continue
            for below, value in _numbers(getattr(part, name), usual):
                named = f"{place}.{key}{below}"
                if not usual.instant:
                    yield from _unusual(named, value, usual, kind, model.units)
                    continue
                listed = f"{of_list}.{key}{below}" if rank.isdigit() else named
                if listed not in last or value > last[listed][0]:
                    last[listed] = value, named, usual, kind
    for value, named, usual, kind in last.values():
        yield from _unusual(named, value, usual, kind, model.units, _begins(model))
    for decision, spec in model.policies.specs().items():
        kinds = catalogue.quantities_of(decision, spec.name)
        for key, note in catalogue.notes_of(decision, spec.name):
            parameter = spec.params.get(key)
            if isinstance(note, Usual) and isinstance(parameter, int | float):
                yield from _unusual(f"policies.{decision}.{key}", float(parameter), note, kinds[key], model.units)


@cache
def _usual_keys(section: type[Part]) -> tuple[tuple[str, str, Usual, str], ...]:
    """Return the fields of a section with a usual range: name, key in files, range, kind of unit."""
    return tuple(
        (name, field.alias or name, note, kind_of(whole_annotation(field)))
        for name, field in section.model_fields.items()
        for note in field.metadata
        if isinstance(note, Usual)
    )


@cache
def _with_usual() -> tuple[type[Part], ...]:
    """Return the sections of a model that have fields with a usual range."""
    sections: dict[type[Part], None] = {}
    left: list[type[Part]] = [Model]
    while left:
        section = left.pop()
        if section not in sections:
            sections[section] = None
            left += [inner for field in section.model_fields.values() for inner in sections_in(field.annotation)]
    return tuple(section for section in sections if _usual_keys(section))


def _judged(model: Model, part: Part, usual: Usual, kind: str) -> bool:
    """Return whether a key of this model can be compared with its usual range."""
    if isinstance(part, Prices) and usual.price and not comparable(part.currency):
        return False
    if kind in {"time", "speed", "acceleration"} and not model.units.has_seconds:
        return False
    return not usual.instant or model.run.end * model.units.seconds >= LONG


def _begins(model: Model) -> float:
    """Return the time from the start of the run, in s, before which scheduled events need not have happened."""
    end = model.run.end
    return min(AT_START * end * model.units.seconds, MOST_AT_START) if math.isfinite(end) else 0.0


def comparable(currency: str | None) -> bool:
    """Return whether prices in a currency are about as high as in EUR; a nameless currency is taken to be."""
    return currency is None or currency in ALIKE


def _numbers(value: Any, usual: Usual) -> Iterator[tuple[str, float]]:
    """Yield the numbers of a key, each with its suffix: the last of instants, the mean of a distribution."""
    if isinstance(value, int | float | Distribution):
        yield "", float(mean_of(value))
    elif isinstance(value, Mapping):
        yield from ((f".{name}", float(number)) for name, number in value.items())
    elif isinstance(value, tuple):
        numbers = [number for item in value for _, number in _numbers(item, usual)]
        if usual.instant and numbers:
            yield "", max(numbers)
        elif not usual.instant:
            yield from (("", number) for number in numbers)


def _unusual(place: str, value: float, usual: Usual, kind: str, units: Units, since: float = 0.0) -> Iterator[Finding]:
    low, high = usual.between(kind)
    low = max(low, since)
    real = value * _si(kind, units)
    if value == 0 or low <= real <= high:
        return
    below = real < low
    meant = "" if usual.cure else _meant(value, low, high, kind)
    value_shown, bound = (
        f"{with_unit(number, kind)} {usual.words}".rstrip() for number in (real, low if below else high)
    )
    yield Finding(
        "UNUSUAL",
        place,
        f"{value_shown} is unusual: {'less' if below else 'more'} than {bound}",
        f"did you mean {meant}?" if meant else usual.cure or _plain(kind, units),
    )


def _si(kind: str, units: Units) -> float:
    """Return the size of a model's unit in seconds or metres."""
    metre, second = units.metre or 1.0, units.seconds
    return {"time": second, "length": metre, "speed": metre / second, "acceleration": metre / second**2}.get(kind, 1.0)


def _meant(value: float, low: float, high: float, kind: str) -> str:
    """Return the number with each unit in which it would be usual, in words; empty if there is none."""
    if kind == "share":
        return f"{value:g} %" if low <= value / 100 <= high else f"{1 + value:g}, which is {value:.0%} more"
    least = low or high / (400 if kind == "time" else 40)  # in ms, but not in mm
    table = {"time": SECONDS, "length": METRES}.get(kind, {})
    fits = [f"{amount(value)} {name}" for name, size in table.items() if least <= value * float(size) <= high]
    return spoken(fits[:2], "or") if fits else ""


def _plain(kind: str, units: Units) -> str:
    """Return the hint on the unit of plain numbers: `times are in s`."""
    if kind == "length":
        return "units.length says what lengths are in"
    return f"times are in {units.time}" if kind else "is it as large as that?"


def with_unit(amount_of: float, kind: str) -> str:
    """Return a quantity in seconds or metres with its unit; times in the largest unit that is whole or at least two."""
    if kind != "time":
        unit = {"length": " m", "speed": " m/s", "acceleration": " m/s²", "rate": " an hour"}.get(kind, "")
        return f"{amount_of:,g}{unit}"
    sizes = [(unit, float(size)) for unit, size in reversed(SECONDS.items()) if unit != "ms"]
    unit, size = next((pair for pair in sizes if amount_of == pair[1] or amount_of >= 2 * pair[1]), ("s", 1.0))
    return f"{amount(amount_of / size)} {unit}"
