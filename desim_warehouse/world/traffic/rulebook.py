"""Rules for the whole floor, distances and times, and protocols for deciding on steps, rings and drives."""

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
    """The part that searches for rings of robots waiting for each other, deadlock cycles (see `gridlock`)."""

    def check(self, robot: Body) -> None:
        """Follow the chain of waiting robots from one that has just become blocked, and turn a ring that it closes."""


class StepGuard(Protocol):
    """The guard that decides on each step where lanes are two-way (deadlock avoidance; see `avoidance`).

    It relies on the routes that robots have declared.
    """

    def declare(self, robot: Body, route: Iterable[Lane]) -> None:
        """Declare the lanes that a robot in a slot will drive."""

    def change(self, robot: Body, route: Sequence[Lane]) -> bool:
        """Replace the lanes of a robot under way, if that is safe. Returns whether it is."""

    def admit(self, robot: Body, node: Intersection, onward: Lane | None) -> bool:
        """Whether a robot may cross `node` now and enter the lane `onward` (None: a slot)."""

    def wait_begins(self, claim: Claim) -> None:
        """Note that the robot of a claim waits, so that it can be admitted later."""

    def wait_ends(self, claim: Claim) -> None:
        """Note that a claim has been granted or given up."""

    def stands_aside(self, robot: Body, route: Sequence[Lane]) -> None:
        """Note that a robot stands beside its lane, and will come back onto it to drive a route."""

    def left(self, robot: Body) -> None:
        """Note that a robot is off the lanes, in a slot."""

    def leaves(self, robot: Body) -> None:
        """Note that a robot leaves a lane of a zone used in one direction at a time."""


class Driver(Protocol):
    """The driver of a body: it decides where the robot goes, and is notified of what happens to the body."""

    def left_bay(self) -> None:
        """Note that the robot has just left the bay it stood in."""

    def take_detour(self, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:
        """Return another route if held up before `route[index]`, or None to wait. Called while `detours` are left."""

    def stood_aside(self) -> None:
        """Note that the body stands beside its lane, in a wide aisle, and comes back onto it later."""

    def give_way(self) -> None:
        """End the robot's rest where it unloaded, and go on to a bay: others wait for the place."""

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

    `headway` is D, the distance that robots keep: that of the largest pair for all, so that in a ring each can take any
    other's position. `theta` is the collision angle in radians. `node_time` is spent at every node reached (turning and
    re-planning), and `turn_time` there for every quarter turn of a robot. `mixed`: robots or edges differ in speed, so
    one robot can catch up with another on the way. `exits_matter`: the time at which a robot leaves the end of a lane
    is needed (for the full log, or a faster follower). `guard` decides on every step where lanes are two-way. If it is
    None, full rings of waiting robots turn instead.
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

        `ratio` is the least distance that the first robot drives while the other drives 1.
        """
        approach = via.length if via.short else self.headway
        if via.edge[1] == left_on.edge[0]:
            angle = turn(via.heading, left_on.heading)
            return closing_distance(angle, self.theta, self.headway, approach * ratio)
        shift = left_on.tail - via.head
        return closing_distance_apart(shift, via.heading, left_on.heading, self.theta, self.headway, approach, ratio)
