"""What the hand calculation knows nothing of, and how much there is of it: `desim check` says so beside it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.feasibility.closures import occupied
from desim_warehouse.findings import amount
from desim_warehouse.values.distributions import mean_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model
    from desim_warehouse.values.disturbances import BreakdownSpec, OutageSpec


def left_out(model: Model, layout: Layout) -> list[str]:
    """A line for each thing that keeps robots or chargers from work at times, for what never does, for two-way lanes.

    Estimates of tasks do not choose the end of a lane at which a robot begins: which is nearer depends on where it is.
    """
    found = [f"{text}; estimates do not know of it" for text in disturbances(model, layout)]
    for place, (what, calendar) in _at_times(model).items():
        if _never(model, calendar):
            found.append(f"{place} is never {what} in this run, by calendar '{calendar}'")
    two_way = sum(len(layout.approaches(place.edge, place.offset)) > 1 for place in layout.storage)
    if two_way:
        found.append(
            f"{two_way} of {len(layout.storage)} storage places are on two-way lanes; robots come to them from the "
            "nearer end, estimates assume the end named first, so tasks may take less time"
        )
    return found


def disturbances(model: Model, layout: Layout) -> list[str]:
    """A line for each thing that keeps robots or chargers from work at times."""
    return [*_failures(model), *_delays(model), *_people(model, layout), *_closures(model)]


def _failures(model: Model) -> Iterator[str]:
    """Which robots and chargers fail, and what is left of their time."""
    unit, kinds = model.units.time, dict(zip(model.fleet.kinds_of_robots(), model.fleet.robots(), strict=True))
    failing: dict[str, BreakdownSpec | OutageSpec | None] = {}
    failing |= {_robots(kind): robot.breakdowns for kind, robot in kinds.items()}
    failing |= {f"chargers of {name}": bay.outages for name, bay in model.layout.bays.items()}
    for name, spec in failing.items():
        if spec is not None:
            every, repair = mean_of(spec.every), mean_of(spec.repair)
            yield (
                f"{name} fail every {amount(every)} {unit} and take {amount(repair)} {unit} to repair: "
                f"{amount(100 * every / (every + repair))} % of their time is left"
            )


def _delays(model: Model) -> Iterator[str]:
    for kind, robot in dict(zip(model.fleet.kinds_of_robots(), model.fleet.robots(), strict=True)).items():
        if robot.delays is not None and robot.delays.share:
            time, share = mean_of(robot.delays.time), robot.delays.share
            yield f"{_robots(kind)} lose {amount(time)} {model.units.time} at {amount(100 * share)} % of the nodes"


def _robots(kind: str) -> str:
    return f"robots of kind {kind}" if kind else "robots"


def _people(model: Model, layout: Layout) -> Iterator[str]:
    for name, people in model.people.items():
        there = occupied(model, layout, people)
        if there is not None:
            share = there * model.hours(people.hours).share(0.0, _end(model))
            yield f"people.{name}: an aisle has somebody in it for {amount(100 * share)} % of the time on average"
        else:
            yield f"people.{name}: visits at {len(people.times)} times"


def _closures(model: Model) -> Iterator[str]:
    """What is closed or slow at times, if it ever is."""
    end = _end(model)
    for place, (what, calendar) in _at_times(model).items():
        hours = model.hours(calendar)
        if math.isinf(end) and math.isinf(hours.period):  # for some time of a run that has no end
            yield f"{place} is {what} at times"
        elif not _never(model, calendar):
            yield f"{place} is {what} for {amount(100 * hours.share(0.0, end))} % of the time"


def _at_times(model: Model) -> dict[str, tuple[str, str]]:
    """Closures, and slow zones with hours: what they are then, and their calendars."""
    closures, slow = model.traffic.closures.items(), model.traffic.slow.items()
    found = {f"traffic.closures.{name}": ("closed", spec.hours) for name, spec in closures}
    return found | {f"traffic.slow.{name}": ("slow", spec.hours) for name, spec in slow if spec.hours is not None}


def _never(model: Model, calendar: str) -> bool:
    return model.hours(calendar).following(0.0)[0] >= _end(model)


def _end(model: Model) -> float:
    return math.inf if model.run.length is None else model.run.length
