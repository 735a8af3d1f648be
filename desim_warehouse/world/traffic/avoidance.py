"""Never stalled on two-way lanes: a step is granted only if afterwards no robot blocks itself through others.

j *stands in i's way* if j stands on a node or lane that i has still to use, or ahead of i on i's lane. A step is safe
if the relation has no cycle afterwards. Then there is always an order in which all could drive home one by one, and the
first of them finds everything before it free. So as long as robots are out, one of them can move (proof: docs/why.md).
This is the banker's algorithm on routes, but no order has to be searched for.

It needs that every robot out has declared its whole route, which ends in a reserved slot off the lanes (a bay, or a
station beside a node). And every step and every change of a route must be checked here. A robot under way counts as
standing where it is going to.
"""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, TypeAlias

from desim_warehouse.world.traffic.events import AFTER_DECISIONS, end_of_instant
from desim_warehouse.world.traffic.zones import Exit, ZoneDirection

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from simpy import Environment
    from simpy.events import Event

    from desim_warehouse.world.traffic.body import Body
    from desim_warehouse.world.traffic.intersection import Claim, Intersection
    from desim_warehouse.world.traffic.lane import Lane

    Stand: TypeAlias = Intersection | Lane
    Step: TypeAlias = Stand | ZoneDirection | Exit

DESPERATE = 5
"""A claim that is older than this many times the patience holds back every departure."""


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


class Avoidance:
    """Decides on steps and changes of route.

    `patience` is how long a claim of a robot that is out may wait.

    Past it no robot sets out onto the route that is left to that robot. Past `DESPERATE` times as long none sets out at
    all. Only departures are held back, never robots that are out: holding those would break the proof.
    """

    def __init__(self, env: Environment, patience: float, *, has_zones: bool = False) -> None:
        self.env = env
        self.has_zones = has_zones
        self.patience = patience
        self._plans: dict[Body, DeclaredRoute] = {}
        self._users: dict[Step, dict[Body, int]] = defaultdict(dict)
        # Refused claims: the robots that made the cycle. As long as none of them has moved the answer is the same.
        self._witness: dict[Body, tuple[Stand, frozenset[Body]]] = {}
        self._asks_again: dict[Body, dict[Body, None]] = defaultdict(dict)
        self._to_serve: dict[Intersection, None] = {}
        self._woken = False
        self._claims: dict[Body, Claim] = {}  # of robots that are out, oldest first

    # Routes

    def declare(self, robot: Body, route: Iterable[Lane]) -> None:
        """The whole route of a robot that is in a bay or station and about to set out, or on the lanes at the start."""
        lane = robot.lane
        if lane is not None:
            plan = DeclaredRoute([lane.lane_of_both, *trail_of(lane.end, route)])
        else:
            plan = DeclaredRoute(trail_of(robot.at, route))
        if robot.is_on_lanes:
            plan.at, plan.stands = 0, robot.at if lane is None else lane.lane_of_both
        self._plans[robot] = plan
        self._count(robot, plan.trail[plan.at + 1 :], 1)

    def change(self, robot: Body, route: Sequence[Lane]) -> bool:
        """Change the route of a robot that is out, if that is safe. It begins at the node it stands on or comes to.

        It is to stand on that node first: a route that turned back into the lane it is on would wait for itself.
        Refused, the declared route stays in force, and the robot may ask again at the next node.
        """
        plan = self._plans[robot]
        node: Intersection = robot.held if robot.held is not None else robot.lane.end
        rest = trail_of(node, route, plan.direction)
        if plan.stands is node:
            rest.remove(node)
        old = plan.trail[plan.at + 1 :]
        self._count(robot, old, -1)
        self._count(robot, rest, 1)
        if self._cycle(robot) is not None:
            self._count(robot, rest, -1)
            self._count(robot, old, 1)
            return False
        plan.trail[plan.at + 1 :] = rest
        self._moved(robot)
        return True

    def left(self, robot: Body) -> None:
        """A robot is in a bay or station, and no longer in the way of others."""
        plan = self._plans.pop(robot, None)
        if plan is not None:
            self._count(robot, plan.trail[plan.at + 1 :], -1)
            self._moved(robot)

    def _count(self, robot: Body, steps: Iterable[Step], change: int) -> None:
        for step in steps:
            users = self._users[step]
            number = users.get(robot, 0) + change
            if number:
                users[robot] = number
            else:
                del users[robot]

    # Steps

    def admit(self, robot: Body, node: Intersection, onward: Lane | None) -> bool:
        """Whether a robot may step onto `node`, or over it to stand on `onward`. If so, it counts as standing there."""
        stand: Stand = node if onward is None else onward.lane_of_both
        witness = self._witness.get(robot)
        if witness is not None and witness[0] is stand:
            return False
        plan = self._plans[robot]
        to = plan.trail.index(stand, plan.at + 1)
        if plan.stands is None and (oldest := self._held_back_by(robot, stand)) is not None:
            self._refuse(robot, stand, (oldest,))
            return False
        before = plan.at, plan.stands, plan.direction
        passed = plan.trail[plan.at + 1 : to + 1]
        if self.has_zones and not self._enter_zones(robot, stand, passed):
            return False
        self._count(robot, passed, -1)
        plan.at, plan.stands = to, stand
        cycle = self._cycle(robot)
        if cycle is not None:
            plan.at, plan.stands, plan.direction = before
            self._count(robot, passed, 1)
            self._refuse(robot, stand, cycle)
            return False
        if plan.direction is not None:
            plan.direction.robots[robot] = None
        self._moved(robot)
        return True

    def _enter_zones(self, robot: Body, stand: Stand, passed: Iterable[Step]) -> bool:
        """Whether the zones on a step are free of robots in the other direction. If so, it is in the last one.

        A robot that others count as beyond a zone may still be on its way out. Then it is looked at again when it is.
        """
        direction = self._plans[robot].direction
        now = self.env.now
        for step in passed:
            if isinstance(step, Exit):
                direction = None
            elif isinstance(step, ZoneDirection):
                direction, against = step, step.opposite
                for other in list(against.robots):
                    plan = self._plans.get(other)
                    drives = plan is not None and plan.direction is against
                    leaves_at = None if drives else against.is_in(other, now)
                    if not drives and leaves_at is None:
                        del against.robots[other]
                    elif other is not robot:
                        self._refuse(robot, stand, (other,))
                        if leaves_at is not None:
                            again = end_of_instant(self.env, AFTER_DECISIONS, leaves_at - now)
                            again.callbacks.append(lambda _: self._look_again(robot))
                        return False
        self._plans[robot].direction = direction
        return True

    def _cycle(self, robot: Body) -> list[Body] | None:
        """The robots of a cycle through `robot`, or None.

        The search goes backwards: the robots that it blocks, those that they block, and so on, until one blocks itself.
        If no robot has still to use its stand, the search ends at once. On one-way rings this is stricter than
        necessary, as a robot that drives round is in the way of all. There rings turn instead (`gridlock`).
        """
        plans = self._plans
        stand = plans[robot].stands
        if stand is None:
            return None
        in_front = _ahead(robot, stand)
        came_from: dict[Body, Body] = {}
        to_follow = [robot]
        while to_follow:
            member = to_follow.pop()
            there = plans[member].stands
            assert there is not None
            users: Iterable[Body] = self._users[there]
            if (direction := plans[member].direction) is not None:
                users = {**self._users[there], **self._users[direction.opposite]}
            if member is not robot and (
                robot in users or (there is stand and (in_front is None or member in in_front))
            ):
                cycle = [member]
                while cycle[-1] is not robot:
                    cycle.append(came_from[cycle[-1]])
                return cycle
            for other in (*users, *_behind(member, there)):
                if other is not robot and other not in came_from and plans[other].stands is not None:
                    came_from[other] = member
                    to_follow.append(other)
        return None

    def _held_back_by(self, robot: Body, stand: Stand) -> Body | None:
        """The robot that has waited so long that this one may not set out now."""
        for other, claim in self._claims.items():
            waited = self.env.now - other.waiting_since
            if other is robot or claim.via is None or waited <= self.patience:
                return None
            if self._waits_for_time(other):
                continue
            if waited > DESPERATE * self.patience or other in self._users[stand]:
                return other
        return None

    def _waits_for_time(self, robot: Body) -> bool:
        """Whether a robot waits for an opening or a repair, or for one that does: holding others back helps none."""
        seen: set[Body] = set()
        to_follow = [robot]
        while to_follow:
            member = to_follow.pop()
            if member in seen:
                continue
            seen.add(member)
            if member.broken or (member.claim is not None and member.claim.shut_by is not None):
                return True
            lane = None if member.claim is None else member.claim.lane
            if lane is not None and lane.twin is not None and lane.twin.last is not None:
                to_follow.append(lane.twin.last)  # who comes towards it
            blocker = member.blocker
            to_follow += self._witness[member][1] if member in self._witness else ()
            to_follow += () if blocker is None else (blocker,)
        return False

    # Refusals, and asking again

    def wait_begins(self, claim: Claim) -> None:
        """A claim has to wait, for whatever reason."""
        if claim.via is not None:
            self._claims[claim.robot] = claim

    def wait_ends(self, claim: Claim) -> None:
        """A claim waits no longer."""
        self._claims.pop(claim.robot, None)

    def _refuse(self, robot: Body, stand: Stand, cycle: Iterable[Body]) -> None:
        others = frozenset(cycle) - {robot}
        self._witness[robot] = stand, others
        for other in others:
            self._asks_again[other][robot] = None

    def _moved(self, robot: Body) -> None:
        """Claims that were refused because of where it stood, or of its route, are looked at again."""
        self._look_again(robot, *self._asks_again.pop(robot, ()))

    def _look_again(self, *robots: Body) -> None:
        for asker in robots:
            if self._witness.pop(asker, None) is not None and asker.claim is not None:
                self._to_serve[asker.claim.node] = None
        if self._to_serve and not self._woken:
            self._woken = True
            end_of_instant(self.env, AFTER_DECISIONS).callbacks.append(self._serve)

    def _serve(self, _: Event) -> None:
        self._woken = False
        nodes, self._to_serve = list(self._to_serve), {}
        for node in nodes:
            if node.claims:
                node.freed(self.env.now)


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
