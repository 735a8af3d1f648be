"""Events that happen whatever robots do: breakdowns, outages, visits and rides of people, openings; their limits.

A rate or a period too small by a slip would keep a run busy with nothing else for ever.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import got
from desim_warehouse.values.calendars import Pattern
from desim_warehouse.values.distributions import mean_of
from desim_warehouse.values.disturbances import BreakdownSpec, OutageSpec
from desim_warehouse.values.fields import LIMITS, TOP, wrong

if TYPE_CHECKING:
    from pydantic_core import PydanticCustomError

    from desim_warehouse.layout.spec import LayoutSpec


Cause = tuple[tuple[str, ...], str, float]
"""A key, what it causes, and how many of them there are about in a run."""


def too_many(model: Mapping[str, Any]) -> list[PydanticCustomError]:
    """Report keys of a model that cause more events than a run can get through.

    `model`: its sections by name, those that are right. Work that ends has no length: then an hour counts, and of the
    causes that hold work up, that much work.
    """
    most = LIMITS["events"][0]
    when = "an hour" if model["run"].length is None else "run.length"
    return [
        wrong(
            f"about {got(float(f'{count:.3g}'))} {what} in {when}, expected at most {most:,}; is the unit right?",
            TOP,
            *keys,
        )
        for keys, what, count in _causes(model)
        if count > most
    ]


def _causes(model: Mapping[str, Any]) -> Iterator[Cause]:
    units, fleet, layout = model.get("units"), model.get("fleet"), model.get("layout")
    length = model["run"].length
    if units is None:
        return
    time = units.hour if length is None else length
    if fleet is not None:
        yield from _breakdowns(("fleet", "robot"), fleet.robot.breakdowns, fleet.size, length, time)
        for name, kind in fleet.kinds.items():
            yield from _breakdowns(("fleet", "kinds", name), kind.breakdowns, kind.count, length, time)
    if layout is not None:
        yield from _in_layout(layout, time, units.hour)
    for name, people in (model.get("people") or {}).items():
        if people.per_hour is not None:
            yield ("people", name, "per_hour"), "visits", people.per_hour * time / units.hour
    at_work = fleet.hours_of_robots() if fleet is not None else []
    for name, calendar in (model.get("calendars") or {}).items():
        hours = calendar.hours(model["run"].start, 1 / units.seconds)
        if math.isfinite(hours.period):
            a_period = hours.period if length is not None else math.fsum(end - begin for begin, end in hours.stretches)
            changes = 2 * len(hours.stretches) * time / a_period
            keys = ("calendars", name, *(("every" if length is not None else "lasts",) * isinstance(calendar, Pattern)))
            yield keys, "openings and closings", changes * max(at_work.count(name), 1)


def _in_layout(layout: LayoutSpec, time: float, hour: float) -> Iterator[Cause]:
    for name, bay in layout.bays.items():
        if bay.outages is not None:
            chargers = bay.total_chargers or bay.chargers or bay.places or 1
            yield ("layout", "bays", name, "outages", "every"), "outages", chargers * time / _cycle(bay.outages)
    for name, lift in layout.lifts.items():
        if lift.outages is not None:
            yield ("layout", "lifts", name, "outages", "every"), "outages", time / _cycle(lift.outages)
        if lift.people is not None:
            yield ("layout", "lifts", name, "people", "per_hour"), "rides", lift.people.per_hour * time / hour


def _breakdowns(
    keys: tuple[str, ...], spec: BreakdownSpec | None, robots: int, length: float | None, time: float
) -> Iterator[Cause]:
    if spec is not None:
        between = mean_of(spec.every) if length is None else _cycle(spec)
        yield (*keys, "breakdowns", "every"), "breakdowns", robots * time / between


def _cycle(spec: BreakdownSpec | OutageSpec) -> float:
    return mean_of(spec.every) + mean_of(spec.repair)
