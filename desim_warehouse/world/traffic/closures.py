"""Lanes that are closed or slow at times.

No robot enters a closed lane. One that is inside drives on and out, and may load there. So a claim for room on it waits
where the robot stands, holding nothing, and only time keeps it waiting: it blocks no ring.

Nothing is scheduled for openings and closings as such. Whether a lane is closed is looked up when needed, and a robot
that has to wait is woken when it opens (`Intersection.wait_for_opening`). So calendars and people cost nothing where no
robot drives, keep no run going, and hide no stall.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from desim_warehouse.layout import Layout
from desim_warehouse.layout.zones import edges_of
from desim_warehouse.model import Model
from desim_warehouse.values.calendars import ALWAYS, Hours
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.lane import Lane
from desim_warehouse.world.traffic.people import PeopleSource
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    Edge = tuple[str, str]


class Closure(Protocol):
    """Something that keeps robots out of lanes at times: a closure by calendar, or people in an aisle.

    `wait`: what waiting for it is counted as, by its name in `states.APART`. `is_person`: to be kept out by it is to
    meet somebody.
    """

    wait: str
    is_person: bool

    def closed_until(self, now: float) -> float:
        """When it opens: not after `now` if it is open, inf if it never opens again."""

    def opens_for(self, robot: Body, now: float) -> float:
        """When it opens for a robot: the same, or earlier if it makes an exception for one that has waited long."""

    def expected_until(self, time: float, now: float) -> float:
        """When it is expected at `now` to be open for a robot that comes at `time`, or an earlier time."""


class ClosedHours:
    """A closure by calendar: known for all times."""

    wait = "waiting_closed"
    is_person = False

    def __init__(self, hours: Hours) -> None:
        self.hours = hours

    def closed_until(self, now: float) -> float:
        """When it opens."""
        begin, end = self.hours.following(now)
        return end if begin <= now + EPS < end else now

    def opens_for(self, robot: Body, now: float) -> float:  # noqa: ARG002 - it is open to all or to none
        """When it opens."""
        return self.closed_until(now)

    def expected_until(self, time: float, now: float) -> float:  # noqa: ARG002 - it is known
        """When it opens for one that comes at `time`."""
        return self.closed_until(time)


class Slowness(NamedTuple):
    """A speed limit, always or at times."""

    speed: float
    hours: Hours = ALWAYS

    def limit(self, now: float) -> float:
        """The limit now, inf if there is none."""
        return self.speed if self.hours.is_open(now) else math.inf


class Restrictions:
    """What keeps robots out of lanes or slows them down, by edge."""

    def __init__(self) -> None:
        self.closures: dict[Edge, list[Closure]] = {}
        self.slow: dict[Edge, list[Slowness]] = {}

    @property
    def edges(self) -> set[Edge]:
        """Edges that are closed or slow at some time."""
        return self.closures.keys() | self.slow.keys()

    @classmethod
    def of(cls, model: Model, layout: Layout, people: Iterable[PeopleSource]) -> Restrictions:
        """Those of a model."""
        found = cls()
        for closure in model.traffic.closures.values():
            found.close(edges_of(layout, closure.members), ClosedHours(model.hours(closure.hours)))
        for slow in model.traffic.slow.values():
            if slow.hours is not None:  # the others are limits of the layout
                found.slow_down(edges_of(layout, slow.members), Slowness(slow.speed, model.hours(slow.hours)))
        for source in people:
            for aisle in source.aisles:
                found.close(aisle.edges, aisle)
        return found

    def close(self, edges: Iterable[Edge], closure: Closure) -> None:
        """Keep robots out of edges."""
        for edge in edges:
            self.closures.setdefault(edge, []).append(closure)

    def slow_down(self, edges: Iterable[Edge], slowness: Slowness) -> None:
        """Limit the speed on edges."""
        for edge in edges:
            self.slow.setdefault(edge, []).append(slowness)


class RestrictedLane(Lane):
    """A lane with `closures`, with speed limits at times, or both. Its own limit is `usual`.

    A robot has the pace of the instant at which it enters the lane as long as it is on it.
    """

    __slots__ = ("closures", "slow", "usual")

    closures: Sequence[Closure]
    slow: Sequence[Slowness]

    def __init__(self, *args: Any, closures: Sequence[Closure], slow: Sequence[Slowness], **of_lane: Any) -> None:
        super().__init__(*args, **of_lane)
        self.closures = closures
        self.slow = (*slow, Slowness(self.usual)) if slow else ()

    @property
    def limit(self) -> float:
        """The speed limit now."""
        return self.limit_at(self.rules.env._now)

    @limit.setter
    def limit(self, limit: float) -> None:
        self.usual = limit

    def limit_at(self, time: float) -> float:
        """The speed limit at a time."""
        return min((slowness.limit(time) for slowness in self.slow), default=self.usual)

    def _late(self, robot: Body, ahead: Body | None, target: float, clear: float) -> float:
        """The same, and its pace is of the instant at which it enters.

        Put off until after the limit has changed, it may enter as it changes, at another pace.
        """
        in_ring = robot.train_pace < math.inf
        late = super()._late(robot, ahead, target, clear)
        if in_ring or not self.slow:
            return late
        planned, entry = robot.limit, clear
        while (change := min(slowness.hours.changes(entry) for slowness in self.slow)) <= clear + late:
            entry = change
            robot.take_pace_of(self, entry)
            late = max(self.free_at(robot, ahead, 0.0, target, clear) - (clear + target / robot.pace), entry - clear)
        if robot.limit != planned:
            robot.start_at_pace(target)
        return late

    def shut_by(self, robot: Body) -> Closure | None:
        """What keeps a robot out now. A robot in a lane of the same closure is not kept out."""
        now: float = self.rules.env._now
        for closure in self.closures:
            if closure.opens_for(robot, now) > now and not self._is_reached_within(closure, robot.lane):
                return closure
        return None

    def _is_reached_within(self, closure: Closure, lane: Lane | None) -> bool:
        """Whether a robot on another lane comes here without leaving the closure, perhaps over a short lane."""
        if lane is None or closure not in lane.closures:
            return False
        return lane.end is self.start or any(out.end is self.start and closure in out.closures for out in lane.end.outs)

    def has_room(self, robot: Body) -> bool:
        """Whether it is open to a robot, which can come to a stand D beyond its start."""
        return not (self.closures and self.shut_by(robot)) and super().has_room(robot)


def hours_closed(model: Model) -> list[Hours]:
    """The calendars of the closures of a model."""
    return [model.hours(name) for name in dict.fromkeys(spec.hours for spec in model.traffic.closures.values())]


def wait_at(lane: Lane, after: float, now: float) -> float:
    """How long a robot is expected to wait before a lane if it comes there `after` from now."""
    time = now + after
    return max([0.0, *(closure.expected_until(time, now) - time for closure in lane.closures)])
