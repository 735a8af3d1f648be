"""Zones: intersections of many nodes for one robot at a time, and lines of lanes with one direction at a time.

One robot: the nodes and edges of the zone are one intersection, with its edges inside. A robot claims all of it
together with room beyond, so none waits in it for room. Rings turn past it as past a node (`intersection`, `gridlock`).
One direction: a robot that drives a line of two-way lanes blocks robots that have still to enter it the other way
(`avoidance`). No lane of the line is a refuge. A robot is in the zone from the step onto its first lane there until the
step off the node at the end of its last. If no robot stands in i's way, none stands against i in the zone that it
enters, and a robot on its way out is under way, so the step is free. Lanes of the zone are at least 2 D long, so that
every passage of a lane is a step of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING

from desim_warehouse.layout.zones import TrafficZone
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from desim_warehouse.world.traffic.body import Body


class Exit:
    """The place where a route leaves a line of lanes: after the node at the end of the last that it drives."""


class ZoneDirection:
    """One direction of a line of two-way lanes.

    `robots` are in it, or were when they were last looked at.
    """

    __slots__ = ("exit", "opposite", "robots")

    def __init__(self) -> None:
        self.exit = Exit()
        self.opposite: ZoneDirection = self
        self.robots: dict[Body, None] = {}

    def is_in(self, robot: Body, now: float) -> float | None:
        """Return when a robot with a stand beyond the zone will have left it; None if it has.

        It is inf while the robot has not left its lane yet: how long it stands on the node is not known beforehand.
        """
        lane = robot.lane
        if lane is None:
            return None
        if lane.zone_direction is self:  # about to cross, on the way to the node, or turning or held up on it
            return math.inf
        return robot.entered_at if robot.entered_at > now + EPS else None


def directions(zones: Iterable[TrafficZone]) -> dict[tuple[str, str], ZoneDirection]:
    """Return the zone direction of each edge, if any."""
    direction_of = {}
    for zone in zones:
        if zone.rule == "one-direction":
            forth, back = ZoneDirection(), ZoneDirection()
            forth.opposite, back.opposite = back, forth
            for a, b in pairwise(zone.line):
                direction_of[a, b], direction_of[b, a] = forth, back
    return direction_of
