"""Rules that hold everywhere on a floor: distances and times, and who decides on steps, rings of robots, and drives."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from desim_warehouse.outcome.log import Log
from desim_warehouse.world.traffic.events import Clock, Steps
from desim_warehouse.world.traffic.rules import closing_distance, closing_distance_apart, turn

if TYPE_CHECKING:
    from desim_warehouse.world.traffic.body import Body
    from desim_warehouse.world.traffic.drive import Drive
    from desim_warehouse.world.traffic.intersection import Claim, Intersection
    from desim_warehouse.world.traffic.lane import Lane


class Rings(Protocol):
    """The part that looks for robots that wait for each other in a ring, a deadlock cycle (see `gridlock`)."""

    def check(self, robot: Body) -> None:
        """Follow the chain of waiting robots from one that has just become blocked, and turn a ring that it closes."""


class StepGuard(Protocol):
    """The guard that decides on each step where lanes are two-way (deadlock avoidance; see `avoidance`).

    It goes by the routes that robots have declared.
    """

    def declare(self, robot: Body, route: Iterable[Lane]) -> None:
        """Take the lanes on which a robot in a slot will drive."""

    def change(self, robot: Body, route: Sequence[Lane]) -> bool:
        """Take other lanes for a robot that is under way, if that is safe. Returns whether it is."""

    def admit(self, robot: Body, node: Intersection, onward: Lane | None) -> bool:
        """Whether a robot may cross `node` now and enter the lane `onward` (None: a slot)."""

    def wait_begins(self, claim: Claim) -> None:
        """Note that the robot of a claim waits, so that it can be admitted later."""

    def wait_ends(self, claim: Claim) -> None:
        """Note that a claim has been granted or given up."""

    def stands_aside(self, robot: Body, route: Sequence[Lane]) -> None:
        """Note that a robot stands beside its lane, onto which it comes back, and then drives a route."""

    def left(self, robot: Body) -> None:
        """Note that a robot is off the lanes, in a slot."""


class Driver(Protocol):
    """A robot as its body knows it: the driver decides, and learns what happens to the body."""

    def left_bay(self) -> None:
        """Note that the robot has just left the bay it stood in."""

    def take_detour(self, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:
        """Return another route if held up before `route[index]`, or None to wait. Asked while `detours` are left."""

    def stood_aside(self) -> None:
        """Note that the body stands beside its lane, in a wide aisle, and comes back onto it later."""

    def give_way(self) -> None:
        """End the robot's rest where it unloaded: others wait for the place, and it goes on to a bay."""

    def notice_wait(self, waiting: bool) -> None:
        """Note that the robot begins, or ends, to wait in traffic."""

    def notice_delay(self, begin: float, end: float) -> None:
        """Note that the robot will wait in traffic from `begin` to `end`."""

    def halt(self, drive: Drive) -> Steps:
        """Stand until a due breakdown is repaired, on the lanes or, once cleared, beside them. Never in a bay."""


class NoDriver:
    """A driver of bodies that only follow routes."""

    def left_bay(self) -> None:
        """Do nothing."""

    def take_detour(self, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:  # noqa: ARG002
        """Return None: the body waits."""
        return None

    def stood_aside(self) -> None:
        """Do nothing."""

    def give_way(self) -> None:
        """Do nothing."""

    def notice_wait(self, waiting: bool) -> None:
        """Do nothing."""

    def notice_delay(self, begin: float, end: float) -> None:
        """Do nothing."""

    def halt(self, drive: Drive) -> Steps:  # noqa: ARG002
        """Do nothing: it never breaks down."""
        yield from ()


@dataclass(frozen=True, slots=True)
class Rules:
    """The rules of a floor, for its lanes and intersections.

    `headway` is D, the distance that robots keep: the largest pair's for all, so that in a ring each can take any
    other's position. `theta` is the collision angle in radians. `node_time` is spent at every node reached (turning and
    re-planning), and there `turn_time` for every quarter of a turn that a robot makes. `mixed`: robots or edges differ
    in speed, so that one robot can catch up with another on the way. `exits_matter`: it matters when a robot leaves the
    end of a lane (the log of everything, or a faster follower). `guard` decides on every step where lanes are two-way.
    Where it is None, full rings of waiting robots turn instead.
    """

    env: Clock
    log: Log
    gridlock: Rings
    headway: float
    theta: float
    node_time: float
    mixed: bool
    exits_matter: bool
    guard: StepGuard | None = None
    turn_time: float = 0.0

    def closing_distance(self, via: Lane, left_on: Lane, ratio: float) -> float:
        """Return how far the robot that left by one lane must be before the next may come `via` another.

        `ratio` is how far, at least, the one that leaves drives while the other drives 1.
        """
        approach = via.length if via.short else self.headway
        if via.edge[1] == left_on.edge[0]:
            angle = turn(via.heading, left_on.heading)
            return closing_distance(angle, self.theta, self.headway, approach * ratio)
        shift = left_on.tail - via.head
        return closing_distance_apart(shift, via.heading, left_on.heading, self.theta, self.headway, approach, ratio)
