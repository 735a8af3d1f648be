"""The hours of a model: the stretches in which stations and robots work and orders come, the longest time between."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from statistics import fmean

from desim_warehouse.model.schema import Model
from desim_warehouse.model.sections.flows import FlowSpec, ProfileArrivals
from desim_warehouse.values.calendars import Hours, Stretch, merged

DAYS = 14
"""Days in which the longest rest of a model is looked for: calendars repeat every week."""
DAY = 24
"""Hours after which calendars and closures repeat."""
STEPS = 1000
"""Times at which a calendar opens or closes that are looked at, to find whether two of them meet."""


def longest_closed(model: Model) -> float:
    """Return the longest time in which a station, or the fleet, is outside its hours, as far as the run goes.

    A fleet whose part f is off for a time g, and that keeps up all the same, falls back by no more than the work that
    comes in f g meanwhile: so for robots it is the mean.
    """
    if not (model.layout.has_hours or model.fleet.has_hours):
        return 0.0
    stations, robots = [station.hours for station in model.layout.stations.values()], model.fleet.hours_of_robots()
    end = model.run.end
    gap = {name: _longest_between(first_stretches(model.hours(name), end), end) for name in {*stations, *robots}}
    return max(fmean(gap[name] for name in robots), *(gap[name] for name in stations), 0.0)


def first_stretches(hours: Hours, end: float) -> Iterator[tuple[float, float]]:
    """Iterate over the first stretches of a calendar before an end, as many as are looked at."""
    time = 0.0
    for _ in range(STEPS):
        begin, close = hours.following(time)
        if not begin < end:
            return
        yield begin, close
        if math.isinf(close):
            return
        time = close


def has_nights(model: Model) -> bool:
    """Whether a model has times without work: hours, rates of 0 in a profile, or a run of a day or more."""
    flows, goods = model.tasks.flows.values(), model.tasks.goods
    hours = [flow.hours for flow in flows] + [getattr(goods, "hours", None)]
    zeros = any(isinstance(flow.when, ProfileArrivals) and not all(flow.when.profile.per_hour) for flow in flows)
    if model.layout.has_hours or model.fleet.has_hours or any(name is not None for name in hours) or zeros:
        return True
    return model.run.length is not None and model.run.length >= 24 * model.units.hour


def longest_rest(model: Model) -> float:
    """Return the longest time in which no orders come, or no station is open, or no robot is in its hours."""
    end = DAYS * 24 * model.units.hour
    stations, robots = [station.hours for station in model.layout.stations.values()], model.fleet.hours_of_robots()
    open_times = [
        [stretch for name in {*names} for stretch in model.hours(name).between(0.0, end)]
        for names in (stations, robots)
        if names
    ]
    if model.tasks.flows:
        open_times.append([stretch for flow in model.tasks.flows.values() for stretch in _asks(model, flow, end)])
    else:
        goods = model.hours(getattr(model.tasks.goods, "hours", None))
        open_times.append(list(goods.between(0.0, end)))
    return max(_longest_between(merged(stretches), end) for stretches in open_times)


def _asks(model: Model, flow: FlowSpec, end: float) -> Iterator[Stretch]:
    """Iterate over the stretches in which tasks of a flow may come."""
    hours = model.hours(flow.hours)
    if not isinstance(flow.when, ProfileArrivals):
        yield from hours.between(0.0, end)
        return
    rates = flow.when.profile.per_hour
    every = flow.when.profile.every or model.units.hour
    for step in range(min(math.ceil(end / every), STEPS * STEPS)):
        if rates[step % len(rates)]:
            yield from hours.between(step * every, min((step + 1) * every, end))


def _longest_between(stretches: Iterable[Stretch], end: float) -> float:
    """Return the longest time outside of stretches in order, up to an end; after the last only where the end comes."""
    closed, last = 0.0, 0.0
    for begin, close in stretches:
        closed, last = max(closed, begin - last), close
    return max(closed, end - last if end < math.inf else 0.0)


def repeats_after(model: Model) -> float:
    """Return the time after which hours, rates and closures repeat, usually a day; 0 where they are always alike."""
    profiles = [flow.when.profile for flow in model.tasks.flows.values() if isinstance(flow.when, ProfileArrivals)]
    hour = model.units.hour
    periods = [len(profile.per_hour) * (hour if profile.every is None else profile.every) for profile in profiles]
    by_clock = model.layout.has_hours or model.fleet.has_hours or model.traffic.closures
    return max([*periods, DAY * hour * bool(by_clock)])
