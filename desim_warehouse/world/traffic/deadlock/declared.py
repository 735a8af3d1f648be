"""What robots have declared that they will use: the trail of each, and by node and lane who has still to use it."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterable

    from desim_warehouse.world.traffic.body import Body
    from desim_warehouse.world.traffic.intersection import Intersection
    from desim_warehouse.world.traffic.lane import Lane
    from desim_warehouse.world.traffic.zones import Exit, ZoneDirection

    Stand: TypeAlias = Intersection | Lane
    Step: TypeAlias = Stand | ZoneDirection | Exit


class DeclaredRoute:
    """What a robot has still to use, in order, and where it stands: nowhere (-1) while it is in a bay.

    A trail has a mark before the first lane of a zone of one direction, and one after the node at its end there.
    `direction` is the one in which the robot drives a zone now.
    """

    __slots__ = ("at", "direction", "stands", "trail")

    def __init__(self, trail: list[Step]) -> None:
        self.trail = trail
        self.at = -1
        self.stands: Stand | None = None
        self.direction: ZoneDirection | None = None


class Declared:
    """The routes of all robots.

    `users` says of each step of a trail which robots have still to use it, and how often; robots in slots included.
    """

    __slots__ = ("routes", "users")

    def __init__(self) -> None:
        self.routes: dict[Body, DeclaredRoute] = {}
        self.users: dict[Step, dict[Body, int]] = defaultdict(dict)

    def add(self, robot: Body, route: DeclaredRoute) -> None:
        """A robot has declared a route, or another before it has set out."""
        if robot in self.routes:
            self.drop(robot)
        self.routes[robot] = route
        self.count(robot, route.trail[route.at + 1 :], 1)

    def replace(self, robot: Body, rest: list[Step]) -> list[Step]:
        """A robot that is out has other steps still to use. Returned are those that it had."""
        route = self.routes[robot]
        old = route.trail[route.at + 1 :]
        self.count(robot, old, -1)
        self.count(robot, rest, 1)
        route.trail[route.at + 1 :] = rest
        return old

    def drop(self, robot: Body) -> None:
        """A robot is in a bay or station."""
        route = self.routes.pop(robot)
        self.count(robot, route.trail[route.at + 1 :], -1)

    def count(self, robot: Body, steps: Iterable[Step], change: int) -> None:
        """A robot has these steps still to use (1), or no longer (-1)."""
        for step in steps:
            users = self.users[step]
            number = users.get(robot, 0) + change
            if number:
                users[robot] = number
            else:
                del users[robot]


def trail_of(node: Intersection, route: Iterable[Lane], direction: ZoneDirection | None = None) -> list[Step]:
    """The nodes and lanes on which a robot can stand along a route from a node, in order, without short lanes.

    `direction` is that of a zone in which the robot comes to the node, or stands on it.
    """
    trail: list[Step] = [node]
    for lane in route:
        if lane.inside:
            continue
        if lane.zone_direction is not direction:
            if direction is not None:
                trail.append(direction.exit)
            direction = lane.zone_direction
            if direction is not None:
                trail.append(direction)
        if not lane.short:
            trail.append(lane.lane_of_both)
        trail.append(lane.end)
    return trail
