"""The guard of two-way lanes: it grants a step only if all robots that are out can still come home afterwards.

A test decides whether they can: `home_plan` where robots can make way for others on one-way lanes, `Acyclic` where they
cannot. A test may refuse a safe step, which costs time but never stops work: in every granted state with robots out,
some robot can take its next step (proof below). This is the banker's algorithm applied to routes.

Two conditions must hold. Every robot that is out has declared its whole route, which ends in a reserved slot off the
lanes (a bay, or a station beside a node). Every step and every change of route is checked here. A robot under way
counts as standing at the place that it drives to.

Why work never stops. While all robots are in slots the empty plan is valid, and every grant keeps a valid plan. Suppose
robots are out and none is under way or handling. Let i be the robot of the plan's first move.

- The next step of i is free. Robot i is the first on its stand and claims the next place to stand on its route. By the
  plan everything up to that place is empty, or the place is a refuge with room. Robots at rest on a lane stand D apart
  from the stop line on, so room by the plan is room on the lane.
- The step is granted without a search. Put before the plan, it leaves the plan valid, because nobody moves before i.
- The claim is examined. A refused claim is examined again when a robot that caused the refusal moves, and the claim of
  the plan's first robot at every grant: without that, stalls are rare but real (`tests/laws/test_two_way.py`). A claim
  that finds no room is examined when a robot leaves the lane, or gives back the room that it was granted there, and on
  a two-way lane claims at both of its ends are.

Every grant shortens a finite route, so all robots come home unless others keep setting out. Therefore departures, and
only departures, are held back while a claim waits too long.

Where all lanes are two-way no robot can make way, and `Acyclic` suffices: j *stands in i's way* if j stands on a node
or lane that i has still to use, or ahead of i on i's lane. A state is safe if this relation has no cycle. Then all
robots can drive home one by one in some order, and the first of them finds everything before it free. That order is a
plan of `home_plan` without refuges, and it need not be stored.
"""

from __future__ import annotations

import math
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

    It implements `Test` for the guard.
    """

    __slots__ = ("declared",)

    def __init__(self, declared: Declared) -> None:
        self.declared = declared

    def starts(self, robot: Body) -> None:
        """Accept a robot on the lanes at the start of a run: `check` has verified that the initial state is safe."""

    def left(self, robot: Body) -> None:
        """Note that a robot has left the lanes, which is always safe."""

    def first(self) -> Body | None:
        """Return None: a claim needs another look only after a robot in its way has moved."""
        return None

    def after_step(self, robot: Body) -> Collection[Body] | None:
        """Return the robots that make the state unsafe after a step of a robot; None if it is safe.

        They form a cycle through that robot. The search goes backwards, to the robots that it blocks, those that they
        block, and so on, until one blocks itself. It ends at once if no robot has still to use the stand of the first.
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
    """Find the cycle that a robot closes by taking another route."""


def _behind(member: Body, stand: Stand) -> tuple[Body, ...]:
    """Return the robot behind another on its lane, or the one that is about to enter that lane."""
    lane = member.lane
    if lane is None or lane.lane_of_both is not stand:
        return ()
    if member.behind is not None:
        return (member.behind,)
    return () if lane.entering is None else (lane.entering,)


def _ahead(robot: Body, stand: Stand) -> set[Body] | None:
    """Return the robots ahead of another on its lane, or None for all on the lane if it has yet to enter."""
    if robot.lane is None or robot.lane.lane_of_both is not stand:
        return None
    robots_ahead, other = set(), robot.ahead
    while other is not None:
        robots_ahead.add(other)
        other = other.ahead
    return robots_ahead


DESPERATE = 5
"""A claim that has waited this many times the patience holds back every departure."""


class Avoidance:
    """The guard that decides on steps and changes of route of robots on two-way lanes (deadlock avoidance).

    `patience` is how long the claim of a robot that is out may wait.

    After that, no robot may set out onto the remaining route of the waiting robot, and after `DESPERATE` times as long
    no robot may set out at all. Only departures are held back: holding back robots that are out would break the proof.
    """

    def __init__(self, env: Clock, patience: float, *, has_zones: bool = False) -> None:
        self.env = env
        self.has_zones = has_zones
        self.patience = patience
        self.declared = Declared()
        self.test: Acyclic | HomePlan = Acyclic(self.declared)
        # Refused claims, with the robots that made the step unsafe: examined again when one of them moves.
        self._witness: dict[Body, tuple[Stand, frozenset[Body]]] = {}
        self._asks_again: dict[Body, dict[Body, None]] = defaultdict(dict)
        self._to_serve: dict[Intersection, None] = {}
        self._woken = False
        self._claims: dict[Body, Claim] = {}  # of robots that are out, oldest first

    def rely_on(self, lanes: Iterable[Lane]) -> None:
        """Choose the safety test by the lanes of the floor: on refuges, robots may make way for others.

        Without refuges a plan is an order of drives home: proving that it exists is cheaper than storing it.
        """
        refuges: dict[Step, int] = {
            lane: room(lane.length, lane.headway) for lane in lanes if lane.twin is None and not lane.short
        }
        if refuges:
            self.test = HomePlan(self.declared, refuges)

    # Routes

    def declare(self, robot: Body, route: Iterable[Lane]) -> None:
        """Declare the whole route of a robot about to leave its slot, or on the lanes at the start of a run."""
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
        """Change the route of a robot that is out, if that is safe. The route begins at its present or next node.

        The robot must stop on that node first: on a route that turns back into its present lane it would wait for
        itself. If the change is refused, the declared route stays in force, and the robot may ask again at the next
        node.
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
        """Note that a robot is in a bay or station, where it blocks no other."""
        if robot in self.declared.routes:
            self.declared.drop(robot)
            self.test.left(robot)
            self._moved(robot)

    def leaves(self, robot: Body) -> None:
        """Note that a robot leaves a lane of a zone, for whose way out others may wait."""
        self._look_again(*self._asks_again.pop(robot, ()))

    def stands_aside(self, robot: Body, route: Sequence[Lane]) -> None:
        """Note that a robot stands beside its lane, as if in a slot. Its first step leads back onto the lane."""
        self.left(robot)
        lane: Lane = robot.lane
        if lane.zone_direction is not None:
            lane.zone_direction.robots.pop(robot, None)
        self.declared.add(robot, DeclaredRoute(trail_of(lane.start, [lane, *route])[1:]))

    # Steps

    def admit(self, robot: Body, node: Intersection, onward: Lane | None) -> bool:
        """Whether a robot may step onto `node`, or across it to `onward`. If so, it now counts as standing there."""
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
        """Whether no robot drives the zones of a step in the other direction. If so, it is now in the last zone.

        A robot that has a stand beyond a zone may still be on its way out. The claim is then examined again when it
        leaves its lane (`leaves`), and once it is out.
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
                        if leaves_at is not None and math.isfinite(leaves_at):
                            again = end_of_instant(self.env, AFTER_DECISIONS, leaves_at - now)
                            again.callbacks.append(lambda _: self._look_again(robot))
                        return False
        self.declared.routes[robot].direction = direction
        return True

    def _held_back_by(self, robot: Body, stand: Stand) -> Body | None:
        """Return the robot whose long wait keeps this robot from setting out now, if any."""
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
        """Whether a robot waits, directly or not, for an opening or a repair: holding others back does not help."""
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
                to_follow.append(lane.twin.last)  # the last robot that comes towards it
            blocker = member.blocker
            to_follow += self._witness[member][1] if member in self._witness else ()
            to_follow += () if blocker is None else (blocker,)
        return False

    # Refusals and repeated examination

    def wait_begins(self, claim: Claim) -> None:
        """Note that a claim begins to wait, for any reason."""
        if claim.via is not None:
            self._claims[claim.robot] = claim

    def wait_ends(self, claim: Claim) -> None:
        """Note that a claim has stopped waiting."""
        self._claims.pop(claim.robot, None)

    def _refuse(self, robot: Body, stand: Stand, blockers: Collection[Body]) -> None:
        others = frozenset(blockers) - {robot}
        self._witness[robot] = stand, others
        for other in others:
            self._asks_again[other][robot] = None

    def _moved(self, robot: Body) -> None:
        """Examine again the claims that were refused because of this robot's stand or route.

        Examine also the claim of the plan's first robot, whatever made it unsafe: the proof relies on it.
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
