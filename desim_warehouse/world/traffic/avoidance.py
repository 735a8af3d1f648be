"""The guard of two-way lanes: a step is granted only if all robots that are out can come home afterwards.

What that takes is looked at by a test: `home_plan` where robots can make way for others on one-way lanes, `Acyclic`
where they cannot. Whatever the test misses is refused needlessly, and no more: in each state that was granted some
robot can take its next step, so as long as robots are out one of them can move (below). This is the banker's algorithm
on routes.

It needs that every robot out has declared its whole route, which ends in a reserved slot off the lanes (a bay, or a
station beside a node). And every step and every change of a route must be checked here. A robot under way counts as
standing where it is going to.

Why work never stops. With all robots in slots the empty plan will do, and every grant keeps a plan. Suppose robots are
out and none is under way or handling. Let i be the robot of the first move.

- Its next step is free. i is the first on its stand and claims the next place to stand on its route. All up to there
  is empty by the plan, or the place is the refuge itself, with room: robots at rest on a lane stand D apart from the
  stop line on, so room by the plan is room on the lane.
- It is granted without a search. Put the step before the plan, and the plan still holds: nobody moves before i.
- It is looked at. A refused claim is looked at again when one of those moves for which it was refused. The claim of
  the robot that the plan begins with is looked at again at every grant: without that, stalls are rare but real
  (`tests/laws/test_two_way.py`).

Every grant shortens a finite route, so all come home unless others keep setting out. Therefore departures are held back
where a claim waits too long, and only they.

Where all lanes are two-way no robot can make way, and `Acyclic` does: j *stands in i's way* if j stands on a node or
lane that i has still to use, or ahead of i on i's lane. A state is safe if the relation has no cycle. Then there is
always an order in which all could drive home one by one, and the first of them finds everything before it free. It is
the plan of `home_plan` without refuges, and there no order has to be kept.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING

from desim_warehouse.layout.way_home import room
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.events import AFTER_DECISIONS, Clock, end_of_instant
from desim_warehouse.world.traffic.home_plan import Declared, DeclaredRoute, HomePlan, trail_of
from desim_warehouse.world.traffic.intersection import Claim, Intersection
from desim_warehouse.world.traffic.lane import Lane
from desim_warehouse.world.traffic.zones import Exit, ZoneDirection

if TYPE_CHECKING:
    from simpy.events import Event

    from desim_warehouse.world.traffic.home_plan import Stand, Step


class Acyclic:
    """The safety test (banker's algorithm) where no robot can make way for another: states without a cycle are safe.

    It is a `Test` of the guard.
    """

    __slots__ = ("declared",)

    def __init__(self, declared: Declared) -> None:
        self.declared = declared

    def starts(self, robot: Body) -> None:
        """Take a robot that stands on the lanes at the start of a run: `check` has seen that all there are safe."""

    def left(self, robot: Body) -> None:
        """Note that a robot is off the lanes, which is always safe."""

    def first(self) -> Body | None:
        """Return None: no robot has to be looked at again although nothing in its way moved."""
        return None

    def after_step(self, robot: Body) -> Collection[Body] | None:
        """Return the robots that make the state unsafe now that a robot has taken a step; None if it is safe.

        They form a cycle through that robot. The search goes backwards: the robots that it blocks, those that
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
            place = routes[member].stands
            assert place is not None
            users: Iterable[Body] = all_users[place]
            if (direction := routes[member].direction) is not None:
                users = {**all_users[place], **all_users[direction.opposite]}
            if member is not robot and (
                robot in users or (place is stand and (in_front is None or member in in_front))
            ):
                cycle = [member]
                while cycle[-1] is not robot:
                    cycle.append(came_from[cycle[-1]])
                return cycle
            for other in (*users, *_behind(member, place)):
                if other is not robot and other not in came_from and routes[other].stands is not None:
                    came_from[other] = member
                    to_follow.append(other)
        return None

    after_change = after_step
    """Find the cycle that a robot closes as it takes another route."""


def _behind(member: Body, stand: Stand) -> tuple[Body, ...]:
    """Return the robot behind another on the lane where the other stands, or the one on its way in."""
    lane = member.lane
    if lane is None or lane.lane_of_both is not stand:
        return ()
    if member.behind is not None:
        return (member.behind,)
    return () if lane.entering is None else (lane.entering,)


def _ahead(robot: Body, stand: Stand) -> set[Body] | None:
    """Return the robots ahead of one on the lane where it stands, or None for all there if it is still coming in."""
    if robot.lane is None or robot.lane.lane_of_both is not stand:
        return None
    robots_ahead, other = set(), robot.ahead
    while other is not None:
        robots_ahead.add(other)
        other = other.ahead
    return robots_ahead


DESPERATE = 5
"""A claim that is older than this many times the patience holds back every departure."""


class Avoidance:
    """The guard, which decides on steps and changes of route of robots on two-way lanes (deadlock avoidance).

    `patience` is how long a claim of a robot that is out may wait.

    Past it no robot sets out onto the route that is left to that robot. Past `DESPERATE` times as long none sets out at
    all. Only departures are held back, never robots that are out: holding those would break the proof.
    """

    def __init__(self, env: Clock, patience: float, *, has_zones: bool = False) -> None:
        self.env = env
        self.has_zones = has_zones
        self.patience = patience
        self.declared = Declared()
        self.test: Acyclic | HomePlan = Acyclic(self.declared)
        # Refused claims: the robots that made the step unsafe. While none of them moves they are not looked at again.
        self._witness: dict[Body, tuple[Stand, frozenset[Body]]] = {}
        self._asks_again: dict[Body, dict[Body, None]] = defaultdict(dict)
        self._to_serve: dict[Intersection, None] = {}
        self._woken = False
        self._claims: dict[Body, Claim] = {}  # of robots that are out, oldest first

    def rely_on(self, lanes: Iterable[Lane]) -> None:
        """Take the lanes of the floor: where some are refuges, robots may make way for others on them.

        Where none is, a plan is an order of drives home, and it is cheaper to see that there is one than to keep it.
        """
        refuges: dict[Step, int] = {
            lane: room(lane.length, lane.headway) for lane in lanes if lane.twin is None and not lane.short
        }
        if refuges:
            self.test = HomePlan(self.declared, refuges)

    # Routes

    def declare(self, robot: Body, route: Iterable[Lane]) -> None:
        """Declare the whole route of a robot in a slot that is about to set out, or on the lanes at the start."""
        lane = robot.lane
        if lane is not None:
            declared = DeclaredRoute([lane.lane_of_both, *trail_of(lane.end, route)])
        else:
            declared = DeclaredRoute(trail_of(robot.at, route))
        if robot.is_on_lanes:
            declared.at, declared.stands = 0, robot.at if lane is None else lane.lane_of_both
        self.declared.add(robot, declared)
        if robot.is_on_lanes:
            self.test.starts(robot)

    def change(self, robot: Body, route: Sequence[Lane]) -> bool:
        """Change the route of a robot that is out, if that is safe. It begins at the node it stands on or comes to.

        It is to stand on that node first: a route that turned back into the lane it is on would wait for itself.
        Refused, the declared route stays in force, and the robot may ask again at the next node.
        """
        declared = self.declared.routes[robot]
        node: Intersection = robot.held if robot.held is not None else robot.lane.end
        rest = trail_of(node, route, declared.direction)
        if declared.stands is node:
            rest.remove(node)
        old = self.declared.replace(robot, rest)
        if self.test.after_change(robot) is not None:
            self.declared.replace(robot, old)
            return False
        self._moved(robot)
        return True

    def left(self, robot: Body) -> None:
        """Note that a robot is in a bay or station, and no longer in the way of others."""
        if robot in self.declared.routes:
            self.declared.drop(robot)
            self.test.left(robot)
            self._moved(robot)

    def stands_aside(self, robot: Body, route: Sequence[Lane]) -> None:
        """Note that a robot stands beside its lane, as in a slot, with the way back onto it as its first step."""
        self.left(robot)
        lane: Lane = robot.lane
        if lane.zone_direction is not None:
            lane.zone_direction.robots.pop(robot, None)
        self.declared.add(robot, DeclaredRoute(trail_of(lane.start, [lane, *route])[1:]))

    # Steps

    def admit(self, robot: Body, node: Intersection, onward: Lane | None) -> bool:
        """Whether a robot may step onto `node`, or over it to stand on `onward`. If so, it counts as standing there."""
        stand: Stand = node if onward is None else onward.lane_of_both
        witness = self._witness.get(robot)
        if witness is not None and witness[0] is stand:
            return False
        route = self.declared.routes[robot]
        target = route.trail.index(stand, route.at + 1)
        if route.stands is None and (oldest := self._held_back_by(robot, stand)) is not None:
            self._refuse(robot, stand, (oldest,))
            return False
        before = route.at, route.stands, route.direction
        passed = route.trail[route.at + 1 : target + 1]
        if self.has_zones and not self._enter_zones(robot, stand, passed):
            return False
        self.declared.count(robot, passed, -1)
        route.at, route.stands = target, stand
        blockers = self.test.after_step(robot)
        if blockers is not None:
            route.at, route.stands, route.direction = before
            self.declared.count(robot, passed, 1)
            self._refuse(robot, stand, blockers)
            return False
        if route.direction is not None:
            route.direction.robots[robot] = None
        self._moved(robot)
        return True

    def _enter_zones(self, robot: Body, stand: Stand, passed: Iterable[Step]) -> bool:
        """Whether the zones on a step are free of robots in the other direction. If so, it is in the last one.

        A robot that others count as beyond a zone may still be on its way out. Then it is looked at again when it is.
        """
        direction = self.declared.routes[robot].direction
        now = self.env.now
        for step in passed:
            if isinstance(step, Exit):
                direction = None
            elif isinstance(step, ZoneDirection):
                direction, against = step, step.opposite
                for other in list(against.robots):
                    route = self.declared.routes.get(other)
                    drives = route is not None and route.direction is against
                    leaves_at = None if drives else against.is_in(other, now)
                    if not drives and leaves_at is None:
                        del against.robots[other]
                    elif other is not robot:
                        self._refuse(robot, stand, (other,))
                        if leaves_at is not None:
                            again = end_of_instant(self.env, AFTER_DECISIONS, leaves_at - now)
                            again.callbacks.append(lambda _: self._look_again(robot))
                        return False
        self.declared.routes[robot].direction = direction
        return True

    def _held_back_by(self, robot: Body, stand: Stand) -> Body | None:
        """Return the robot that has waited so long that this one may not set out now."""
        for other, claim in self._claims.items():
            waited = self.env.now - claim.begun
            if other is robot or claim.via is None or waited <= self.patience:
                return None
            if self._waits_for_time(other):
                continue
            if waited > DESPERATE * self.patience or other in self.declared.users[stand]:
                return other
        return None

    def _waits_for_time(self, robot: Body) -> bool:
        """Whether a robot waits for an opening or a repair, directly or not: holding others back is no help."""
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
        """Note that a claim has to wait, for whatever reason."""
        if claim.via is not None:
            self._claims[claim.robot] = claim

    def wait_ends(self, claim: Claim) -> None:
        """Note that a claim waits no longer."""
        self._claims.pop(claim.robot, None)

    def _refuse(self, robot: Body, stand: Stand, blockers: Collection[Body]) -> None:
        others = frozenset(blockers) - {robot}
        self._witness[robot] = stand, others
        for other in others:
            self._asks_again[other][robot] = None

    def _moved(self, robot: Body) -> None:
        """Look again at claims that were refused because of where it stood, or because of its route.

        So is the claim of the robot that the plan begins with, whichever made it unsafe: the proof rests on it.
        """
        first = self.test.first()
        if first is not None:
            self._look_again(first)
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
