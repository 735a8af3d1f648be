"""Hours of stations, robots and flows in an estimate: shares of time, and hours under which nothing can be done."""

from __future__ import annotations

import math
from statistics import fmean
from typing import TYPE_CHECKING

from desim_warehouse.findings import Finding, amount
from desim_warehouse.model.facts.destinations import destinations
from desim_warehouse.model.facts.hours import STEPS, first_stretches
from desim_warehouse.model.facts.stations import specs
from desim_warehouse.model.schema import reading
from desim_warehouse.model.sections.flows import OrdersArrivals, ScheduleArrivals
from desim_warehouse.model.sections.orders import summary
from desim_warehouse.values.calendars import ALWAYS

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model
    from desim_warehouse.values.calendars import Hours


def on_duty(model: Model) -> float:
    """The part of the run in which a robot can work, on average over the fleet.

    It is in its hours then, and of the stations that tasks go to one is open: for those that are closed they are held
    back.
    """
    layout, end = model.floor, model.run.end
    of = specs(model, layout)
    stations = [model.hours(of[node].hours) if node in of else ALWAYS for node in destinations(model, layout)]
    names = model.fleet.hours_of_robots()
    share = {name: _share_of_both(model.hours(name), stations, end) for name in set(names)}
    return fmean(share[name] for name in names)


def _share_of_both(robot: Hours, stations: Sequence[Hours], end: float) -> float:
    """The part of the time in which a robot is in its hours and one of the stations is open; see `Hours.share`."""
    if ALWAYS in stations:
        return robot.share(0.0, end)
    at = together = 0.0
    for _ in range(STEPS):
        now, at = at, min(end, *(one.changes(at) for one in (robot, *stations)))
        both = robot.is_open(now) and any(station.is_open(now) for station in stations)
        if math.isinf(at):  # it stays so for ever; what ends counts until it ends
            return together / now if now and not both else float(both)
        together += (at - now) * both
        if at >= end:
            break
    return together / at


def nobody_at_work(model: Model) -> Iterator[tuple[float, float]]:
    """The stretches of a run in which no robot is on duty, or no station that tasks go to is open."""
    layout, end = model.floor, model.run.end
    of = specs(model, layout)
    stations = {of[node].hours if node in of else None for node in destinations(model, layout)}
    robots = [model.hours(name) for name in set(model.fleet.hours_of_robots())]
    open_ones = [model.hours(name) for name in stations] or [ALWAYS]
    if ALWAYS in robots and ALWAYS in open_ones:
        return
    at, begin = 0.0, math.nan
    for _ in range(STEPS):
        works = any(one.is_open(at) for one in robots) and any(one.is_open(at) for one in open_ones)
        if works and not math.isnan(begin):
            yield begin, at
        begin = math.nan if works else at if math.isnan(begin) else begin
        if at >= end:
            break
        at = min(end, *(one.changes(at) for one in (*robots, *open_ones)))
    if not math.isnan(begin) and begin < at:
        yield begin, at


def errors(model: Model, layout: Layout) -> Iterator[Finding]:
    """Calendars that never open where they are used, and those of robots and stations that do not meet."""
    end = model.run.end
    never = {place for place, name in _used(model) if not model.hours(name).following(0.0)[0] < end}
    for place in sorted(never):
        name = dict(_used(model))[place]
        when = "" if math.isinf(end) else f" before the run ends at {amount(end)} {model.units.time}"
        yield Finding(
            "NEVER_OPEN",
            place,
            f"calendar '{name}' does not open{when}",
            f"other times in calendars.{name}, another run.start, or a longer run",
        )
    if not never:
        yield from _late_orders(model, layout)
        yield from _never_meet(model, layout, end)


def _used(model: Model) -> list[tuple[str, str]]:
    """Every key of a model that names a calendar, and which."""
    layout, fleet, tasks = model.layout, model.fleet, model.tasks
    places = [(f"layout.stations.{name}.hours", station.hours) for name, station in layout.stations.items()]
    places += [(f"tasks.flows.{name}.hours", flow.hours) for name, flow in tasks.flows.items()]
    places += [("tasks.goods.hours", getattr(tasks.goods, "hours", None)), ("fleet.hours", fleet.hours)]
    places += [(f"fleet.kinds.{name}.hours", kind.hours) for name, kind in fleet.kinds.items()]
    return [(place, name) for place, name in places if name is not None]


def _late_orders(model: Model, layout: Layout) -> Iterator[Finding]:
    """Schedules and files that ask for something after the hours of their flow are over for good."""
    for name, flow in model.tasks.flows.items():
        if flow.hours is None:
            continue
        last = 0.0
        if isinstance(flow.when, ScheduleArrivals):
            last = max(batch.at for batch in flow.when.schedule)
        elif isinstance(flow.when, OrdersArrivals):
            last = summary(flow.when.orders, reading(model, layout)).last
        if math.isinf(model.hours(flow.hours).following(last)[0]):
            yield Finding(
                "NEVER_OPEN",
                f"tasks.flows.{name}.hours",
                f"tasks are asked for at {amount(last)} {model.units.time}, and calendar '{flow.hours}' does not "
                "open again after that",
                f"times in calendars.{flow.hours} that last as long",
            )


def _never_meet(model: Model, layout: Layout, end: float) -> Iterator[Finding]:
    """Stations that are open only long after all robots have ended their hours, so that no task gets there."""
    if not (model.fleet.has_hours and model.layout.has_hours):
        return
    slowest = min(robot.speed for robot in model.fleet.distinct())
    once_round = 10 * sum(data["length"] for *_, data in layout.graph.edges(data=True)) / slowest
    robots = [model.hours(name) for name in dict.fromkeys(model.fleet.hours_of_robots())]
    of = specs(model, layout)
    for node in destinations(model, layout):
        spec = of.get(node)
        if spec is None or spec.hours is None:
            continue
        stretches = list(first_stretches(model.hours(spec.hours), end))
        if not any(_on_duty_in(one, max(a - once_round, 0.0), b) for a, b in stretches for one in robots):
            yield Finding(
                "HOURS_NEVER_MEET",
                f"layout.stations.{layout.stations[node].zone}.hours",
                "no robot is at work when the station is open, or just before",
                "hours in which robots and station both work",
            )


def _on_duty_in(hours: Hours, begin: float, end: float) -> bool:
    return hours.following(begin)[0] < end
