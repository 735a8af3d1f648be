"""Disturbances: what keeps robots, chargers or lifts of a model from work at times, and how much time it takes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from desim_warehouse.errors import number_of
from desim_warehouse.findings import amount
from desim_warehouse.layout import Layout
from desim_warehouse.layout.layout import Edge
from desim_warehouse.model.facts.lifts import called, with_people
from desim_warehouse.model.schema import Model
from desim_warehouse.model.sections.fleet import RobotSpec
from desim_warehouse.model.sections.traffic import PeopleSpec
from desim_warehouse.values.distributions import mean_of
from desim_warehouse.values.disturbances import BreakdownSpec, OutageSpec, availability


def disturbances(model: Model, layout: Layout) -> list[str]:
    """List the disturbances that keep robots or chargers from work at times, a line for each."""
    return [*_failures(model), *_delays(model), *_people(model, layout)]


def left_out(model: Model) -> list[str]:
    """List the disturbances of robots, chargers and people that the model leaves out."""
    layout, traffic = model.layout, model.traffic
    parts = {
        "breakdowns": bool(breakdowns(model)),
        "outages of chargers": model.battery is None or any(bay.outages for bay in layout.bays.values()),
        "outages of lifts": not layout.lifts or any(lift.outages for lift in layout.lifts.values()),
        "people in lifts": not layout.lifts or any(lift.people for lift in layout.lifts.values()),
        "time lost at nodes": any(robot.delays is not None for _, robot in _kinds(model)),
        "people in the aisles": bool(model.people),
        "closed lanes": bool(traffic.closures),
        "shifts": bool(model.calendars),
    }
    return [what for what, is_there in parts.items() if not is_there]


def _failures(model: Model) -> Iterator[str]:
    """Describe which robots and chargers fail, and what is left of their time."""
    lasts = model.units.lasts
    failing: dict[str, BreakdownSpec | OutageSpec | None] = {}
    failing |= {_robots(kind): robot.breakdowns for kind, robot in _kinds(model)}
    if model.battery is not None:
        failing |= {f"chargers of {name}": bay.outages for name, bay in model.layout.bays.items()}
    for name, spec in failing.items():
        if spec is not None:
            yield (
                f"{name} fail every {lasts(mean_of(spec.every))} and take {lasts(mean_of(spec.repair))} to repair: "
                f"{amount(100 * availability(spec))} % of their time is left"
            )


def failing_lifts(model: Model, layout: Layout) -> Iterator[str]:
    """Describe which lifts fail, and how much time that takes; lifts alike in one line."""
    failing: dict[OutageSpec, list[str]] = {}
    for lift in layout.lifts:
        if lift.outages is not None:
            failing.setdefault(lift.outages, []).append(lift.name)
    for spec, names in failing.items():
        every, repair = (model.units.lasts(mean_of(time)) for time in (spec.every, spec.repair))
        left, several = amount(100 * availability(spec)), len(names) > 1
        yield (
            f"{called(names)} fail{'' if several else 's'} every {every} and "
            f"take{'' if several else 's'} {repair} to repair: {left} % of "
            f"{'the time of each' if several else 'its time'} is left, and robots wait for the repairs"
        )


def ridden_lifts(model: Model, layout: Layout) -> Iterator[str]:
    """Describe which lifts people use, and for how much of the time; lifts alike in one line."""
    shared: dict[str, list[str]] = {}
    for lift in layout.lifts:
        if lift.people is not None:
            shared.setdefault(f"{100 * with_people(model, lift):.3g}", []).append(lift.name)
    for share, names in shared.items():
        each = "each of " if len(names) > 1 else ""
        yield f"people use {each}{called(names)} for {share} % of the time on average, and robots wait for them"


def breakdowns(model: Model) -> dict[str, BreakdownSpec]:
    """Return the breakdowns of robots by the key at which they stand."""
    fleet = model.fleet
    specs = {"fleet.robot.breakdowns": fleet.robot.breakdowns} | {
        f"fleet.kinds.{name}.breakdowns": kind.breakdowns for name, kind in fleet.kinds.items()
    }
    return {key: spec for key, spec in specs.items() if spec is not None}


def _delays(model: Model) -> Iterator[str]:
    for kind, robot in _kinds(model):
        if robot.delays is not None and robot.delays.share:
            time, share = mean_of(robot.delays.time), robot.delays.share
            yield f"{_robots(kind)} lose {amount(time)} {model.units.time} at {100 * share:.3g} % of the nodes"


def _kinds(model: Model) -> Iterable[tuple[str, RobotSpec]]:
    """Return a robot of each kind."""
    return dict(zip(model.fleet.kinds_of_robots(), model.fleet.robots(), strict=True)).items()


def _robots(kind: str) -> str:
    return f"robots of kind {kind}" if kind else "robots"


def _people(model: Model, layout: Layout) -> Iterator[str]:
    for name, people in model.people.items():
        occupied_share = occupied(model, layout, people)
        if occupied_share is not None:
            share = occupied_share * model.hours(people.hours).share(0.0, model.run.end)
            yield f"people ({name}): an aisle has somebody in it for {100 * share:.3g} % of the time on average"
        else:
            yield f"people ({name}): {number_of(len(people.times), 'visit')}"


def closures(model: Model) -> Iterator[str]:
    """Describe what is closed or slow at times, if it ever is."""
    end = model.run.end
    for place, (what, calendar) in at_times(model).items():
        hours, are = model.hours(calendar), f"the lanes of {place.split('.', 2)[2]} are {what}"
        if math.isinf(end) and math.isinf(hours.period):  # for some time of a run that has no end
            yield f"{are} at times"
        elif not never_in_run(model, calendar):
            yield f"{are} for {100 * hours.share(0.0, end):.3g} % of the time"


def at_times(model: Model) -> dict[str, tuple[str, str]]:
    """Return the closures, and slow zones with hours, each with its effect and its calendar."""
    closures, slow = model.traffic.closures.items(), model.traffic.slow.items()
    closed = {f"traffic.closures.{name}": ("closed", spec.hours) for name, spec in closures}
    return closed | {f"traffic.slow.{name}": ("slow", spec.hours) for name, spec in slow if spec.hours is not None}


def never_in_run(model: Model, calendar: str) -> bool:
    """Whether a calendar does not open before the run ends."""
    return model.hours(calendar).following(0.0)[0] >= model.run.end


def occupied(model: Model, layout: Layout, people: PeopleSpec) -> float | None:
    """Return the share of time in which somebody is in an aisle, while people come: by the queue M/G/infinity.

    It is None if people come at times that are given, or nowhere.
    """
    aisles = len(people.aisles) or len({frozenset(edge) for edge in with_storage(layout)})
    if people.per_hour is None or not aisles:
        return None
    return -math.expm1(-people.per_hour / model.units.hour * mean_of(people.stay) / aisles)


def with_storage(layout: Layout) -> set[Edge]:
    """Return the edges with storage places; places at nodes are in no aisle."""
    return {place.edge for place in layout.storage if place.edge[0] != place.edge[1]}
