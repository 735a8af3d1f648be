"""Values outside the usual range of robots and warehouses, and the unit in which they would be usual."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from desim_warehouse.errors import spoken
from desim_warehouse.feasibility.batteries import MINUTE
from desim_warehouse.findings import Finding, amount
from desim_warehouse.layout.spec import Blocks, StationSpec
from desim_warehouse.model.facts.charging import levels, start_energy
from desim_warehouse.model.facts.demand import order_files
from desim_warehouse.model.facts.kinds import by_kind, said
from desim_warehouse.model.schema import Prices, RunSpec, Tasks
from desim_warehouse.model.sections.fleet import Fleet, Kind, RobotSpec
from desim_warehouse.model.sections.flows import FlowSpec, Profile
from desim_warehouse.model.sections.goods import PoissonGoods, SaturatedGoods
from desim_warehouse.model.sections.people import GiveWay, PeopleSpec
from desim_warehouse.model.sections.policy import Policies
from desim_warehouse.model.sections.traffic import SlowSpec, TrafficSpec
from desim_warehouse.policies import catalogue
from desim_warehouse.values.calendars import Pattern
from desim_warehouse.values.distributions import Distribution, mean_of
from desim_warehouse.values.disturbances import BreakdownSpec, DelaySpec, OutageSpec
from desim_warehouse.values.fields import Part, parts_in
from desim_warehouse.values.units import METRES, SECONDS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from desim_warehouse.feasibility.estimate import HandCalculation
    from desim_warehouse.feasibility.power import Power
    from desim_warehouse.model import Model
    from desim_warehouse.model.schema import Units

HOUR, DAY = 3600.0, 86400.0


class Usual(NamedTuple):
    """Between which values a quantity usually lies, in seconds and metres; 0 and none given are usual, too."""

    low: float
    high: float
    kind: str = "time"


_ROBOT = {
    "radius": Usual(0.05, 2.5, "length"),
    "acceleration": Usual(0.05, 5, "acceleration"),
    "deceleration": Usual(0.05, 10, "acceleration"),
}
_HANDLED = Usual(0.5, HOUR)
_AT_LEAST = Usual(0.5, math.inf)  # of LONG_HANDLING there is a finding already
_DUE = Usual(1, 7 * DAY)
_FAILS = {"every": Usual(600, 1000 * DAY), "repair": Usual(10, 3 * DAY)}
USUAL: dict[type[Part], dict[str, Usual]] = {
    RobotSpec: {**_ROBOT, "margin": Usual(0, 2, "length")},
    Kind: _ROBOT,
    BreakdownSpec: _FAILS,
    OutageSpec: _FAILS,
    DelaySpec: {"time": Usual(0.1, 600)},
    PeopleSpec: {"stay": Usual(2, 4 * HOUR), "per_hour": Usual(0, 2000, "")},
    GiveWay: {"after": Usual(0.5, 600)},
    Fleet: {"exit_time": Usual(0, 600), "first_exit_time": Usual(0, 600)},
    TrafficSpec: {"node_time": Usual(0, 20), "turn_time": Usual(0, 30)},
    SlowSpec: {"speed": Usual(0.05, 3, "speed")},
    Policies: {"interval": Usual(0, 600)},
    PoissonGoods: {"due_within": _DUE},
    SaturatedGoods: {"due_within": _DUE},
    FlowSpec: {"due_within": _DUE, "load_time": _HANDLED, "unload_time": _HANDLED, "stop_time": _HANDLED},
    StationSpec: {"load_time": _HANDLED, "unload_time": _HANDLED, "work_time": Usual(0.5, 8 * HOUR)},
    Profile: {"every": Usual(60, 7 * DAY)},
    Pattern: {"every": Usual(60, 366 * DAY), "lasts": Usual(20, 366 * DAY)},
    Tasks: {
        "demand": Usual(0.01, 20, ""),
        "load_time": _AT_LEAST,
        "unload_time": _AT_LEAST,
        "clear_time": Usual(0, 600),
    },
    RunSpec: {"length": Usual(60, 400 * DAY)},
    Prices: {"hours": Usual(200, 8784, "hours a year")},
    Blocks: {"goods_size": Usual(0.1, 10, "length"), "aisle_width": Usual(0.2, 20, "length")},
}
"""Keys by section."""
_PARAMETERS = {"swap": {"time": Usual(5, HOUR)}, "time-window": {"window": Usual(0.1, 2 * HOUR)}}
"""Parameters of policies, by the policy's name."""
_CURES = {
    "length": "units.length says what lengths are in",
    "hours a year": "all year are 8,760, a shift of 8 h on 250 days 2,000",
    "": "is it as large as that?",
}
MOST_CV = 3.0
"""Times of which the standard deviation is more than three times the mean are hardly ever seen."""
LONGEST_BATTERY, LONGEST_CHARGE = 100 * HOUR, 16 * HOUR
"""A battery of robots lasts no longer at work, and takes no longer to charge."""
FAST_CHARGE, MOST_TO_ONE = 300.0, 20.0
"""A battery that is full within these seconds lasts at most this many times as long."""
ROBOT_A_YEAR, CHARGER_A_YEAR = 15_000.0, 8_000.0
"""More than that a year is rather what they cost to buy."""


def warnings(model: Model, found: HandCalculation) -> Iterator[Finding]:
    """What is unusual. Models whose unit of length is not known are of no certain size, and have none."""
    if found.metre is None:
        return
    yield from _keys(model)
    yield from _parameters(model)
    for place, part in parts_in(model, tuple(Distribution.__subclasses__())):
        assert isinstance(part, Distribution)
        if part.cv > MOST_CV:
            meant = f"; did you mean {part.cv / 100:g} ({part.cv:g} %)?" if MOST_CV < part.cv <= 100 else ""  # noqa: PLR2004
            text = f"a coefficient of variation of {amount(part.cv)}: most times would be far below the mean"
            yield Finding("UNUSUAL", place, text, f"it is standard deviation / mean, mostly 0.1 to 1{meant}")
    for place, part in parts_in(model, (BreakdownSpec, OutageSpec)):
        assert isinstance(part, BreakdownSpec | OutageSpec)
        every, repair = mean_of(part.every), mean_of(part.repair)
        if repair > every:
            text = f"{amount(every)} {model.units.time} from one failure to the next, and {amount(repair)} to repair it"
            yield Finding("UNUSUAL", place, text, f"times are in {model.units.time}")
    yield from _warm_up(model, found)
    yield from _battery(model, found)


def notes(model: Model) -> Iterator[Finding]:
    """What may be meant, and is often a slip."""
    prices = model.prices
    if prices is not None:
        robots = {"robot": prices.robot, **{f"kinds.{name}": price for name, price in prices.kinds.items()}}
        most = {**dict.fromkeys(robots, ROBOT_A_YEAR), "charger": CHARGER_A_YEAR}
        for key, price in {**robots, "charger": prices.charger}.items():
            if price > most[key]:
                text = f"{amount(price)} a year for each"
                yield Finding("PRICE_A_YEAR", f"prices.{key}", text, "a price of purchase: divide by the years of use")
    for file in order_files(model):
        if file.trips and file.tasks > file.rows:
            yield Finding(
                "QUANTITY_IS_TRIPS",
                "tasks.flows",
                f"{file.rows:,} rows of orders are {file.tasks:,} tasks by their quantity: each is a trip",
                "where pieces of a row go together in one load, say quantity: pieces",
            )


# Keys


def _keys(model: Model) -> Iterator[Finding]:
    for place, part in parts_in(model, tuple(USUAL)):
        usual = next(table for kind, table in USUAL.items() if isinstance(part, kind))
        for key, between in usual.items():
            value = getattr(part, key)
            if value is not None:
                yield from _unusual(f"{place}.{key}", mean_of(value), between, model.units)


def _parameters(model: Model) -> Iterator[Finding]:
    for kind, spec in model.policies.specs().items():
        for key, between in _PARAMETERS.get(spec.name, {}).items():
            value = spec.params.get(key)
            if isinstance(value, int | float) and key in catalogue.quantities_of(kind, spec.name):
                yield from _unusual(f"policies.{kind}.{key}", float(value), between, model.units)


def _unusual(place: str, value: float, usual: Usual, units: Units) -> Iterator[Finding]:
    real = value * _si(usual.kind, units)
    if value == 0 or usual.low <= real <= usual.high:
        return
    low = real < usual.low
    meant = _meant(value, usual)
    yield Finding(
        "UNUSUAL",
        place,
        f"{_said(real, usual.kind)} is unusual: {'less' if low else 'more'} than "
        f"{_said(usual.low if low else usual.high, usual.kind)}",
        f"did you mean {meant}?" if meant else _CURES.get(usual.kind, f"times are in {units.time}"),
    )


def _si(kind: str, units: Units) -> float:
    """Seconds or metres in a unit of a model."""
    metre, second = units.metre or 1.0, units.seconds
    return {"time": second, "length": metre, "speed": metre / second, "acceleration": metre / second**2}.get(kind, 1.0)


def _meant(value: float, usual: Usual) -> str:
    """The number with the units in which it would be usual."""
    if usual.kind == "" and usual.low <= value / 100 <= usual.high:
        return f"{value:g} %"
    least = usual.low or usual.high / 40
    table = {"time": SECONDS, "length": METRES}.get(usual.kind, {})
    fits = [f"{value:g} {name}" for name, size in table.items() if least <= value * float(size) <= usual.high]
    return spoken(fits[:2], "or") if fits else ""


def _said(amount_of: float, kind: str) -> str:
    """A quantity in seconds or metres with its unit; times in the largest that is whole or two at least."""
    if kind != "time":
        unit = {"length": " m", "speed": " m/s", "acceleration": " m/s²"}.get(kind, f" {kind}".rstrip())
        return f"{amount_of:,g}{unit}"
    sizes = [(unit, float(size)) for unit, size in reversed(SECONDS.items()) if unit != "ms"]
    unit, size = next((one for one in sizes if amount_of == one[1] or amount_of >= 2 * one[1]), ("s", 1.0))
    return f"{amount(amount_of / size)} {unit}"


# Warm-up and batteries


def _warm_up(model: Model, found: HandCalculation) -> Iterator[Finding]:
    """A warm-up in which no task gets done, in a run that is long enough for one in minutes or hours."""
    run, units = model.run, model.units
    if not (model.tasks.never_end and run.length and 0 < run.warm_up < found.cycle.time):
        return
    times = {name: run.warm_up * float(SECONDS[name]) / units.seconds for name in ("min", "h")}
    meant = [name for name, time in times.items() if found.cycle.time <= time <= run.length / 2]
    if meant:
        text = f"{run.warm_up:g} {units.time}: one task takes {amount(found.cycle.time)} {units.time}"
        yield Finding("UNUSUAL", "run.warm_up", text, f"did you mean {run.warm_up:g} {meant[0]}?")


def _battery(model: Model, found: HandCalculation) -> Iterator[Finding]:
    """Rates that do not fit the capacity, and robots that start nearly flat, by kind where kinds differ."""
    if found.power is None:
        return
    for kind, alone in by_kind(model).items():
        for one in _of_battery(alone, found.power.kinds.get(kind, found.power)):
            yield replace(one, text=f"{said(kind)}: {one.text}") if found.power.kinds else one
        if not found.power.kinds:
            return


def _of_battery(model: Model, power: Power) -> Iterator[Finding]:
    battery = model.battery
    assert battery is not None
    seconds = model.units.seconds
    lasts, fills = power.lasts * seconds, battery.capacity / battery.charge_rate * seconds
    unit = f"capacity, consumption and charge_rate are in one unit of energy, the latter two per {model.units.time}"
    if LONGEST_BATTERY < lasts < math.inf or fills > LONGEST_CHARGE:
        text = f"a full battery lasts {_said(lasts, 'time')} of work, and takes {_said(fills, 'time')} to charge"
        yield Finding("BATTERY_RATES", "battery", text, unit)
    elif MINUTE <= fills < FAST_CHARGE and lasts > MOST_TO_ONE * fills:
        text = f"an empty battery is full in {_said(fills, 'time')}, and lasts {_said(lasts, 'time')} of work"
        yield Finding("BATTERY_RATES", "battery.charge_rate", text, unit)
    known = levels(model)
    start = max(start_energy(model)) * battery.capacity
    if known is not None and start <= known.critical:
        text = (
            f"every robot starts with at most {amount(start)} of {amount(battery.capacity)}, and charges at "
            f"{amount(known.critical)}: none works before it has charged"
        )
        yield Finding("START_LOW", "fleet.start_energy", text, "a share of the capacity, such as {uniform: [0.4, 1]}")
