"""Lanes that are closed or slow at times.

No robot enters a closed lane. A robot inside drives on and out, and may load there. A claim for room on the lane waits
where the robot stands and holds nothing, and only time keeps it waiting: it blocks no ring.

Openings and closings are not events. Whether a lane is closed is looked up when needed, and a robot that has to wait is
woken when it opens (`Intersection.wait_for_opening`). So calendars and people cost nothing where no robot drives, keep
no run going, and hide no stall.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple, Protocol

from desim_warehouse.layout import Layout
from desim_warehouse.layout.layout import Edge
from desim_warehouse.layout.zones import edges_of
from desim_warehouse.model import Model
from desim_warehouse.values.calendars import ALWAYS, Hours
from desim_warehouse.world.traffic.people import Passer, PeopleSource
from desim_warehouse.world.traffic.rules import EPS


class Closure(Protocol):
    """A closure that keeps robots out of lanes at times: by calendar, or because people are in an aisle.

    `wait` is the name in `states.APART` under which waiting for it is counted. `is_person`: a robot that it keeps out
    meets somebody.
    """

    wait: str
    is_person: bool

    def closed_until(self, now: float) -> float:
        """Return when the closure opens: a time up to `now` if it is open, inf if it never opens again."""

    def opens_for(self, robot: Passer, now: float) -> float:
        """Return when the closure opens for a robot: as `closed_until`, or earlier for a robot that has waited long."""

    def expected_until(self, time: float, now: float) -> float:
        """Return when the closure is expected to open for a robot that comes at `time`; earlier if it is open."""


class ClosedHours:
    """A closure by calendar, known for all times."""

    wait = "waiting_closed"
    is_person = False

    def __init__(self, hours: Hours) -> None:
        self.hours = hours

    def closed_until(self, now: float) -> float:
        """Return when the closure opens."""
        begin, end = self.hours.following(now)
        return end if begin <= now + EPS < end else now

    def opens_for(self, robot: Passer, now: float) -> float:  # noqa: ARG002 - it is open to all or to none
        """Return when the closure opens."""
        return self.closed_until(now)

    def expected_until(self, time: float, now: float) -> float:  # noqa: ARG002 - it is known
        """Return when the closure opens for a robot that comes at `time`."""
        return self.closed_until(time)


class Slowness(NamedTuple):
    """A speed limit, always or at times."""

    speed: float
    hours: Hours = ALWAYS

    def limit(self, now: float) -> float:
        """Return the speed limit of the edge now, inf if there is none."""
        return self.speed if self.hours.is_open(now) else math.inf


class Restrictions:
    """Restrictions by edge: closures that keep robots out of lanes, and limits that slow them down."""

    def __init__(self) -> None:
        self.closures: dict[Edge, list[Closure]] = {}
        self.slow: dict[Edge, list[Slowness]] = {}

    @property
    def edges(self) -> set[Edge]:
        """Edges that are closed or slow at some time."""
        return self.closures.keys() | self.slow.keys()

    @classmethod
    def of(cls, model: Model, layout: Layout, people: Iterable[PeopleSource]) -> Restrictions:
        """Collect the closures and speed limits of a model."""
        restrictions = cls()
        for closure in model.traffic.closures.values():
            restrictions.close(edges_of(layout, closure.members), ClosedHours(model.hours(closure.hours)))
        for slow in model.traffic.slow.values():
            if slow.hours is not None:  # other limits belong to the layout
                restrictions.slow_down(edges_of(layout, slow.members), Slowness(slow.speed, model.hours(slow.hours)))
        for source in people:
            for aisle in source.aisles:
                restrictions.close(aisle.edges, aisle)
        return restrictions

    def close(self, edges: Iterable[Edge], closure: Closure) -> None:
        """Add a closure that keeps robots out of edges."""
        for edge in edges:
            self.closures.setdefault(edge, []).append(closure)

    def slow_down(self, edges: Iterable[Edge], slowness: Slowness) -> None:
        """Limit the speed on edges."""
        for edge in edges:
            self.slow.setdefault(edge, []).append(slowness)


def hours_closed(model: Model) -> list[Hours]:
    """Collect the calendars of a model's closures."""
    return [model.hours(name) for name in dict.fromkeys(spec.hours for spec in model.traffic.closures.values())]
