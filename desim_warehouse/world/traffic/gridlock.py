"""Deadlock resolution: rings of waiting robots are found when they close, and turned, so work never stalls.

A blocked robot waits for exactly one other: the robot ahead on its lane, the holder of the intersection it claims, or
the last robot on the lane where it wants room. So the waits-for relation is a set of chains, and work can only stop
where a chain closes on itself: a *ring*. Every member could move if all moved at once, so they do: the ring turns by
one position, and each member is nearer to its destination.

A member whose own stop is less than a position ahead cannot move on by a whole position. It handles its good from where
it stands. When it is blocked again, the ring is complete.

A ring that passes a free intersection twice would cross itself there. Then one of the two robots drives onto the
intersection and waits on it. This leaves a gap behind it, and the rings on either side turn one by one.
"""

from __future__ import annotations

from collections import Counter
from functools import partial
from typing import Literal, cast

from simpy.events import Event, Timeout

from desim_warehouse.errors import GridlockError
from desim_warehouse.outcome.log import Log
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.events import Clock
from desim_warehouse.world.traffic.intersection import Claim
from desim_warehouse.world.traffic.lift import LiftCrossing
from desim_warehouse.world.traffic.rules import EPS

_NAMED = 6  # robots of a ring that an error names
Rule = Literal["rotate", "avoid", "stop"]


class Gridlock:
    """Find rings and turn them.

    With `stop`, for fleets that cannot turn, a ring is an error. With `avoid` no ring forms.
    """

    def __init__(self, env: Clock, log: Log, *, headway: float, mixed: bool, rule: Rule) -> None:
        self.env = env
        self.log = log
        self.headway = headway
        self.mixed = mixed
        self.rule = rule
        self.rotations = 0
        self._bodies: list[Body] = []
        self._resting: dict[Body, None] = {}

    # Robots that rest on lanes or nodes, until others wait for them

    def know(self, robot: Body) -> None:
        """Register a robot that may rest on lanes, or wait for a resting robot."""
        self._bodies.append(robot)

    def rests(self, robot: Body) -> None:
        """Note that a robot rests where it stands until others wait for it."""
        self._resting[robot] = None

    def goes_on(self, robot: Body) -> None:
        """Note that a robot no longer rests where it stands."""
        self._resting.pop(robot, None)

    def is_waited_for(self, robot: Body) -> bool:
        """Return whether others wait for a robot, which then may not rest; with `avoid`, whether any robot waits."""
        if self.rule == "avoid":
            return any(other.is_waiting for other in self._bodies)
        return any(other.blocker is robot for other in self._bodies)

    def check(self, robot: Body) -> None:
        """Follow the chain of waiting robots from one that has just become blocked, and turn the ring if there is one.

        A blocked robot waits for exactly one other, so work can stop for good only where a chain closes on itself or
        ends at a resting robot. The resting robot then gives way.
        """
        if self.rule == "avoid":  # why a step is refused has no single reason
            for resting in list(self._resting):
                resting.driver.give_way()
            return
        last, member, seen = robot, robot.blocker, {robot}
        while member is not None and member not in seen:
            seen.add(member)
            last, member = member, member.blocker
        if member is None:
            if last.claim is not None:  # the chain may be a ring when a lane that is closed opens
                last.claim.node.wait_for_opening(last.claim, self.env._now)
            elif last in self._resting:
                last.driver.give_way()
            return
        ring = [member]
        while (after := ring[-1].blocker) is not member:
            assert after is not None
            ring.append(after)
        if self._is_open(ring):
            self._turn(ring)

    def _is_open(self, ring: list[Body]) -> bool:
        """Whether all robots of a ring can go; if not, the ring is examined again later.

        No intersection may still be closing behind a robot, no robot may be turning on a node, and none may wait for
        the cabin of a lift, which is called for it.
        """
        now: float = self.env._now
        calls: list[tuple[LiftCrossing, Claim]] = []
        for robot in ring:
            claim = robot.claim
            if (
                claim is not None and robot.held is not None and robot.ready_at > now + EPS
            ):  # it turns on its node first
                Timeout(self.env, robot.ready_at - now).callbacks.append(partial(self._look_again, robot))
                return False
            if claim is None or claim.node.holder is not None:
                continue
            if not claim.node.is_open(robot, claim.via, now):
                claim.node.reopen_later(now)
                return False
            if claim.node.is_lift:
                calls.append((cast("LiftCrossing", claim.node), claim))
        return not calls or self._cabins_are_there(calls, now)

    @staticmethod
    def _cabins_are_there(calls: list[tuple[LiftCrossing, Claim]], now: float) -> bool:
        """Whether the cabins of lifts stand open before robots of a ring; a lift passed twice is exempt."""
        passed = Counter(lift for lift, _ in calls)
        ready = [lift.is_ready(claim, now) for lift, claim in calls if passed[lift] == 1]  # all of them are called
        return all(ready)

    def _look_again(self, robot: Body, _: Event) -> None:
        self.check(robot)

    def _turn(self, ring: list[Body]) -> None:
        """Move the heads of a ring's lanes all at once, or only one of them where the ring would cross itself.

        Each comes nearer to its destination, and routes are finite, so all work ends.
        """
        now = self.env.now
        if self.rule == "stop":
            raise GridlockError(_describe(ring, now))
        near = [robot for robot in ring if robot.waiting_behind is not None and self._is_near(robot)]
        if near:
            for robot in near:
                robot.head_for(robot.pos)  # it handles its good from here, and the ring is complete when it goes on
                robot.stop_waiting(now).due(now)
            return
        self.rotations += 1
        edges = tuple("" if robot.lane is None else ">".join(robot.lane.edge) for robot in ring)
        self.log.rotation(now, tuple(robot.number for robot in ring), edges)
        claims = [robot.claim for robot in ring if robot.claim is not None]
        passed = set()
        for claim in claims:
            # A figure of eight passes this free node twice. The robot that waits on it makes a gap, and the two loops
            # turn one after the other; sent another way, two full loops would change places for ever.
            if claim.node.holder is None and claim.node in passed:
                claim.node.award(claim, None)
                return
            passed.add(claim.node)
        if self.mixed:
            self._keep_together(ring, now)
        # Robots waiting for room come first: only then does what a holder leaves go to the next in the ring.
        followers = [claim for claim in claims if claim.node.holder not in (None, claim.robot)]
        for claim in claims:
            if claim not in followers:
                claim.node.award(claim, claim.lane)
        for claim in followers:
            room = claim.lane is not None and claim.lane.has_room(claim.robot)
            claim.node.award(claim, claim.lane if room else None)

    def _is_near(self, robot: Body) -> bool:
        """Whether a robot's own stop is less than a position ahead, so that it would not make room for the next."""
        return robot.goal - robot.pos < self.headway - EPS

    @staticmethod
    def _keep_together(ring: list[Body], now: float) -> None:
        """Turn a ring as one train, at the pace of its slowest robot, on the lanes that its robots are on or enter.

        All robots start at one time, when the last of them has braked and accelerated.
        """
        claims = [robot.claim for robot in ring if robot.claim is not None]
        drives = [(claim.robot, lane) for claim in claims for lane in (claim.lane, claim.via) if lane is not None]
        slowest = min(
            *(min(robot.speed, robot.pace) for robot in ring), *(member.pace_on(lane, now) for member, lane in drives)
        )
        for robot in ring:
            robot.turn_with_ring(slowest)
        driven = [(robot, robot.stretch) for robot in ring if robot.stretch is not None]
        if driven:
            begin = max(max(now, robot.until + stretch.stopped[0], robot.stands_at) for robot, stretch in driven)
            begin += max(stretch.motion.gathers for _, stretch in driven) * slowest / 2
            for robot, stretch in driven:
                robot.start_with_ring(begin, stretch.at_speed(slowest))


def _describe(ring: list[Body], now: float) -> str:
    members = "; ".join(f"robot {robot.number} {robot.place(now)}" for robot in ring[:_NAMED])
    if len(ring) > _NAMED:
        members += f"; and {len(ring) - _NAMED} more"
    return (
        f"gridlock at time {now:g}: {len(ring)} robots wait for each other in a ring ({members}); "
        "traffic.gridlock: rotate lets such rings turn"
    )
