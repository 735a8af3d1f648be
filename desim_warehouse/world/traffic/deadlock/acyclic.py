"""Never stalled on floors where all lanes are two-way: no robot blocks itself through others.

j *stands in i's way* if j stands on a node or lane that i has still to use, or ahead of i on i's lane. A state is safe
if the relation has no cycle. Then there is always an order in which all could drive home one by one, and the first of
them finds everything before it free. It is the plan of `plan` without refuges, and there no order has to be kept.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

    from desim_warehouse.world.traffic.body import Body
    from desim_warehouse.world.traffic.deadlock.declared import Declared, Stand


class Acyclic:
    """Whether a state is safe, where no robot can make way for another (a `Test` of the guard)."""

    __slots__ = ("declared",)

    def __init__(self, declared: Declared) -> None:
        self.declared = declared

    def starts(self, robot: Body) -> None:
        """A robot stands on the lanes at the start of a run: `check` has seen that all there are safe."""

    def left(self, robot: Body) -> None:
        """A robot is off the lanes: that is always safe."""

    def first(self) -> Body | None:
        """Who is looked at again though nobody in its way has moved: no robot."""
        return None

    def after_step(self, robot: Body) -> Collection[Body] | None:
        """The robots that make the state unsafe now that a robot has taken a step; None if it is safe.

        They are those of a cycle through that robot. The search goes backwards: the robots that it blocks, those that
        they block, and so on, until one blocks itself. If no robot has still to use its stand, the search ends at once.
        """
        routes, all_users = self.declared.routes, self.declared.users
        stand = routes[robot].stands
        if stand is None:
            return None
        in_front = _ahead(robot, stand)
        came_from: dict[Body, Body] = {}
        to_follow = [robot]
        while to_follow:
            member = to_follow.pop()
            there = routes[member].stands
            assert there is not None
            users: Iterable[Body] = all_users[there]
            if (direction := routes[member].direction) is not None:
                users = {**all_users[there], **all_users[direction.opposite]}
            if member is not robot and (
                robot in users or (there is stand and (in_front is None or member in in_front))
            ):
                cycle = [member]
                while cycle[-1] is not robot:
                    cycle.append(came_from[cycle[-1]])
                return cycle
            for other in (*users, *_behind(member, there)):
                if other is not robot and other not in came_from and routes[other].stands is not None:
                    came_from[other] = member
                    to_follow.append(other)
        return None

    after_change = after_step
    """The same of a robot that has taken another route."""


def _behind(member: Body, stand: Stand) -> tuple[Body, ...]:
    """The robot behind another on the lane where that stands, or the one on its way in."""
    lane = member.lane
    if lane is None or lane.lane_of_both is not stand:
        return ()
    if member.behind is not None:
        return (member.behind,)
    return () if lane.entering is None else (lane.entering,)


def _ahead(robot: Body, stand: Stand) -> set[Body] | None:
    """The robots ahead of one on the lane where it stands, or None for all there if it is still on its way in."""
    if robot.lane is None or robot.lane.lane_of_both is not stand:
        return None
    found, other = set(), robot.ahead
    while other is not None:
        found.add(other)
        other = other.ahead
    return found
