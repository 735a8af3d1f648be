"""Key facts about a model in words: floor, fleet, people, lifts, work, batteries, policies and hours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from desim_warehouse.answer import numbers, words
from desim_warehouse.errors import number_of
from desim_warehouse.feasibility import errors
from desim_warehouse.layout import Layout
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import by_kind, charge_alike, kind_in_words, levels
from desim_warehouse.model.facts.disturbances import closures, disturbances
from desim_warehouse.model.facts.places import destinations
from desim_warehouse.model.sections.fleet import RobotSpec
from desim_warehouse.model.sections.flows import in_words
from desim_warehouse.model.sections.goods import SaturatedGoods
from desim_warehouse.model.sections.policy import PolicySpec
from desim_warehouse.values.units import SECONDS


def facts(model: Model) -> list[tuple[str, str]]:
    """Return floor, fleet, pickers, lifts, work, batteries, policies, hours and disturbances, each with its name."""
    floor = model.floor
    units, fleet = model.units, model.fleet
    most = fleet.largest_capacity
    rows = [
        ("Model", model.name),
        ("Floor", _floor(floor) + "".join(f", {width}" for width in _wide_aisles(model))),
        (
            "Robots",
            (
                f"{fleet.size}, radius {numbers.number(fleet.robot.radius)} {units.length}, "
                f"speed {numbers.number(fleet.robot.speed)} {units.length} per {units.time}"
                + _motion(fleet.robot)
                + (f", up to {most} loads each" if most > 1 else "")
            ),
        ),
        *_pickers(model),
        *_lifts(model),
        ("Work", work(model)),
        ("Unloading", f"at {', '.join(destinations(model, floor))}"),
        ("Battery", _batteries(model)),
        ("Policies", _policies(model)),
        *_hours(model),
        *[("What goes wrong", text) for text in (*disturbances(model, floor), *closures(model))],
    ]
    if units.time not in SECONDS:
        rows.append(("Time unit", f"1 {units.time} = {numbers.number(units.seconds)} s"))
    if model.run.length is not None:
        start = f", begun at {model.run.start}" if model.calendars else ""
        length = f"{numbers.duration(model.run.length, units.time)}{start}"
        warm_up = numbers.duration(model.run.warm_up, units.time)
        rows.append(("Run", f"{length}, counted after a warm-up of {warm_up}" if model.run.warm_up else length))
    accepted = [item.problem for item in errors(model) if item.code in model.accept]
    return rows + [("Accepted error", problem) for problem in accepted]


def work(model: Model) -> str:
    """Return the demand in words."""
    goods = model.tasks.goods
    if model.tasks.flows:
        return "; ".join(f"{name}: {in_words(flow, model.tasks.demand)}" for name, flow in model.tasks.flows.items())
    if isinstance(goods, tuple):
        return f"{len(goods)} items, one by one as listed"
    if isinstance(goods, SaturatedGoods):
        return f"{numbers.number(goods.open(model.fleet.size))} tasks always open, without end"
    for name, text in (
        ("random", "{} items drawn at random"),
        ("poisson", "{} tasks an hour on average, without end"),
    ):
        if hasattr(goods, name):
            rate = model.tasks.demand if name == "poisson" else 1
            return text.format(numbers.number(getattr(goods, name) * rate))
    return "as in the model"


def _hours(model: Model) -> Iterator[tuple[str, str]]:
    """Yield the hours of stations, robots, pickers, people, flows and tasks that have a calendar."""
    fleet, tasks = model.fleet, model.tasks
    named = {f"station {name}": station.hours for name, station in model.layout.stations.items()}
    pauses = {f"station {name}" for name, station in model.layout.stations.items() if station.at_close == "pause"}
    named |= {"robots": fleet.hours} | {f"robots of kind {name}": kind.hours for name, kind in fleet.kinds.items()}
    named |= {"pickers": getattr(model.pickers, "hours", None)}
    named |= {f"people {name}": people.hours for name, people in model.people.items()}
    named |= {f"flow {name}": flow.hours for name, flow in tasks.flows.items()}
    named |= {"tasks": getattr(tasks.goods, "hours", None)}
    for who, calendar in named.items():
        if calendar is not None:
            hours = model.calendars[calendar].words(model.units.time)
            yield "Hours", f"{who}: {calendar}, {hours}" + ("; what has begun pauses" if who in pauses else "")


def _motion(robot: RobotSpec) -> str:
    """Return speed with a load, acceleration, deceleration and braking distance in words, if the model has them."""
    parts = [
        f"{numbers.number(value)} {what}"
        for value, what in (
            (robot.speed_loaded, "loaded"),
            (robot.acceleration, "acceleration"),
            (robot.deceleration, "deceleration"),
        )
        if value is not None
    ]
    if robot.keeps == "braking":
        parts.append("keeps its braking distance")
    return f" ({', '.join(parts)})" if parts else ""


def _floor(floor: Layout) -> str:
    two_way = len(floor.two_way)
    lanes = number_of(len(floor.lanes) - two_way, "one-way lane")
    lanes += f", {number_of(two_way, 'two-way lane')}" if two_way else ""
    return f"{number_of(len(floor.graph), 'node')}, {lanes}, {number_of(len(floor.storage), 'storage place')}"


def _wide_aisles(model: Model) -> Iterator[str]:
    """Yield the width of aisles that are not narrow."""
    aisles = model.layout.aisles
    widths = {name: lines.width for name, lines in aisles.items()} if isinstance(aisles, Mapping) else {"": aisles}
    for name, width in widths.items():
        if width != "narrow":
            how = width if isinstance(width, str) else f"{numbers.number(width)} {model.units.length} wide"
            yield f"aisles {name} {how}" if name else f"all aisles {how}"


def _pickers(model: Model) -> Iterator[tuple[str, str]]:
    """Yield the number of pickers, their speed, and what else they do not do as usual."""
    pickers, units = model.pickers, model.units
    if pickers is None:
        return
    unusual = (
        (pickers.zones > 1, f"{pickers.zones} zones"),
        (pickers.choose != "nearest", f"next robot: {pickers.choose}"),
        (pickers.stay == "order", "stay with a robot for all picks of a tour"),
        (pickers.call == "ahead", "called ahead"),
        (bool(pickers.flows), f"for {', '.join(pickers.flows)} only"),
    )
    speed = f"speed {numbers.number(pickers.speed)} {units.length} per {units.time}"
    yield "Pickers", ", ".join([str(pickers.count), speed, *(text for is_so, text in unusual if is_so)])


def _lifts(model: Model) -> Iterator[tuple[str, str]]:
    """Yield the cabins of each lift, and the time of their rides and doors."""
    for name, lift in model.layout.lifts.items():
        ride, doors = (numbers.duration(time, model.units.time) for time in (lift.ride, lift.doors))
        yield "Lift", f"{name}: {number_of(lift.cabins, 'cabin')}, {ride} per floor, doors {doors}"


def _batteries(model: Model) -> str:
    """Return the battery of all robots, or of each kind if they differ, in words."""
    if charge_alike(model):
        return _battery(model)
    return "; ".join(f"{kind_in_words(kind)}: {_battery(alone)}" for kind, alone in by_kind(model).items())


def _battery(model: Model) -> str:
    battery, thresholds = model.battery, levels(model)
    if battery is None:
        return "none: robots never need charging"
    sent = ", when to charge as its policy says"
    if thresholds is not None:
        sent = f", sent to charge at {numbers.number(thresholds.critical or thresholds.good)}"
    return (
        f"capacity {numbers.number(battery.capacity)}{sent}, charging {numbers.number(battery.charge_rate)} "
        f"per {model.units.time}"
    )


def _policies(model: Model) -> str:
    """Return the policies by kind, with their parameters, in words."""
    policies = model.policies
    parts = []
    for kind in type(policies).model_fields:
        spec = getattr(policies, kind)
        if isinstance(spec, PolicySpec) and spec.name != "single":  # `single` means no batching
            parameters = "".join(f", {key} {words.level(value)}" for key, value in spec.params.items())
            parts.append(f"{words.in_words(f'policies.{kind}')}: {words.policy(kind, spec.name)}{parameters}")
    return "; ".join(parts)
