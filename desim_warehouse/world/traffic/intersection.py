"""An intersection: which robot may cross it, and which is next when it opens.

A robot claims the intersection and room to stand at least D beyond it in one step, never one without the other. So no
robot stands in an intersection waiting for room. Claims are served first come, first served among those that can be
granted now. But a claim that only waits for the intersection to clear is not passed over. Otherwise a platoon that goes
straight on, to which the node is never closed, would starve a crossing robot.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from simpy.events import Event, Timeout

from desim_warehouse.world.traffic.events import Arrival, Steps
from desim_warehouse.world.traffic.rulebook import Rules
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from desim_warehouse.world.traffic.body import Body
    from desim_warehouse.world.traffic.closures import Closure
    from desim_warehouse.world.traffic.lane import Lane


class Claim(Event):
    """A robot's request for an intersection and room on the lane beyond, granted together or not at all.

    The claim is an event: the robot yields it and goes on when it is granted. `lane` None: the intersection alone.
    `via` is the lane by which the robot comes (None: from the bay beside the node). `over` is a lane too short to stand
    on that it drives next. The wait is attributed to `because`, the closure of `kept_out_of`, or else to the robot
    `other`; each of its parts is an episode of its own. `begun` is when the first part began, `met` the closure in the
    way then.
    """

    def __init__(
        self, robot: Body, node: Intersection, lane: Lane | None, via: Lane | None, over: Lane | None = None
    ) -> None:
        super().__init__(node.rules.env)
        self.robot = robot
        self.node = node
        self.lane = lane
        self.via = via
        self.over = over
        self.begun: float = node.rules.env._now
        self.other: Body | None = None
        self.met = self.shut_by
        self.attribute(self.met)

    def attribute(self, closure: Closure | None) -> None:
        """Attribute the wait from now on to a closure, or to other robots (None)."""
        self.because = closure
        self.kept_out_of = self.over if self.over is not None and closure in self.over.closures else self.lane

    def go_for(self, lane: Lane | None, over: Lane | None) -> None:
        """Claim room on other lanes from now on: the robot takes another way beyond the node."""
        self.give_up_room()
        self.lane, self.over = lane, over
        if lane is not None:
            lane.wanted += 1

    @property
    def shut_by(self) -> Closure | None:
        """Return the closure that keeps the robot out of a lane now, so that only time keeps it waiting."""
        if self.lane is not None and self.lane.closures and (closure := self.lane.shut_by(self.robot)) is not None:
            return closure
        return None if self.over is None else self.over.shut_by(self.robot)

    def give_up_room(self) -> None:
        """Claim the intersection alone from now on: the robot takes another way beyond the node."""
        if self.because is not None:
            self.node.now_waits_for(self, None, self.env.now)
        if self.lane is not None:
            self.lane.wanted -= 1
        self.lane = self.over = None

    @property
    def has_room(self) -> bool:
        """Whether the lanes beyond are open, with room to stand."""
        return (self.lane is None or self.lane.has_room(self.robot)) and (
            self.over is None or self.over.shut_by(self.robot) is None
        )


class Intersection:
    """One node, or several nodes too close together (nearer than D) to be used at once.

    A robot that stands on it, or is about to, is its `holder`. A robot that passes leaves its centre at `left_at`
    (known as soon as it sets out, so often in the future) for the lane `left_on` at a pace. Until then it is closed to
    all other robots. Afterwards it is closed to those whose path would come too close, at most until the robot is D
    beyond.
    """

    is_lift = False

    __slots__ = (
        "blocked",
        "claims",
        "holder",
        "left_at",
        "left_on",
        "left_pace",
        "name",
        "nodes",
        "opening",
        "outs",
        "reopens",
        "rules",
        "user",
        "waits",
    )

    def __init__(self, rules: Rules, nodes: list[str]) -> None:
        self.rules = rules
        self.name = nodes[0]
        self.nodes = nodes
        self.holder: Body | None = None
        self.user: Body | None = None
        self.claims: list[Claim] = []
        self.left_at = -math.inf
        self.left_pace = 1.0
        self.left_on: Lane | None = None
        self.reopens = self.opening = math.inf
        self.outs: list[Lane] = []
        self.waits = 0
        self.blocked = 0.0

    @property
    def passages(self) -> int:
        """Return the number of robots that left the intersection along a lane."""
        return sum(lane.passages for lane in self.outs)

    # Whether it is open

    def is_open(self, robot: Body, via: Lane | None, now: float) -> bool:
        """Whether a robot that comes `via` a lane (None: from a bay) may use the intersection now."""
        holder = self.holder
        if holder is not None:
            return holder is robot
        # No closing distance exceeds D: once the robot is D beyond, no look at the table is needed.
        if (now - self.left_at) * self.left_pace >= self.rules.headway:
            return True
        return self.opens_at(robot, via) <= now + EPS

    def opens_at(self, robot: Body, via: Lane | None) -> float:
        """Return when the robot that passed last is far enough away for a robot that comes `via` a lane."""
        left_on = self.left_on
        if left_on is None:
            return -math.inf
        if via is None:  # out of a bay it has no heading yet: D whichever way the other went
            return self.left_at + self.rules.headway / self.left_pace
        # Behind a slower robot the gap closes on the way: the distance is larger by the ratio of their speeds.
        ratio = 1.0 if self.left_pace >= robot.speed else min(1.0, self.left_pace / _pace_by(robot, via))
        distance = via.closings.get((left_on, ratio))
        if distance is None:
            distance = via.closings[left_on, ratio] = self.rules.closing_distance(via, left_on, ratio)
        return self.left_at + distance / self.left_pace

    # Claims

    def claim(self, robot: Body, lane: Lane | None, via: Lane | None, over: Lane | None = None) -> Steps:
        """Claim the intersection and room on the lane beyond, in one step, and wait until both are granted."""
        robot.leave_ring()  # it came onto a node with a ring that brought no room beyond
        if self.take(robot, lane, via, over):
            return
        now: float = self.rules.env._now
        guard = self.rules.guard
        claim = Claim(robot, self, lane, via, over)
        robot.wait_for(claim, now)
        self.claims.append(claim)
        if lane is not None:
            lane.wanted += 1
        claim.other = self.holder or self.user
        self.serve(now)
        if robot.claim is not None:
            self.rules.gridlock.check(robot)
        if guard is not None and robot.claim is not None:
            guard.wait_begins(claim)
        robot.driver.notice_wait(waiting=True)
        yield claim
        robot.driver.notice_wait(waiting=False)
        self.count_claim(claim, claim.other, self.rules.env._now)

    def grant(self, robot: Body, lane: Lane | None) -> None:
        """Give the intersection to a robot, and with it room on the lane that the robot goes on to."""
        self.holder = robot
        robot.hold(self, lane)
        if lane is not None:
            lane.entering = robot

    def take(self, robot: Body, lane: Lane | None, via: Lane | None, over: Lane | None = None) -> bool:
        """Grant the intersection at once, with room on the lane beyond, if both are free. Otherwise change nothing."""
        guard = self.rules.guard
        if (
            self.claims  # earlier claims are served first
            or not self.is_open(robot, via, self.rules.env._now)
            or not (lane is None or lane.has_room(robot))
            or not (over is None or over.shut_by(robot) is None)
            or not (guard is None or guard.admit(robot, self, lane))
        ):
            return False
        self.grant(robot, lane)
        return True

    def award(self, claim: Claim, lane: Lane | None) -> None:
        """Grant the intersection to a robot whose claim waited for it, with room on `lane`, and resume its process."""
        self.claims.remove(claim)
        if claim.lane is not None:
            claim.lane.wanted -= 1
        self.grant(claim.robot, lane)
        if self.rules.guard is not None:
            self.rules.guard.wait_ends(claim)
        claim.succeed()

    def serve(self, now: float) -> None:
        """Grant the first waiting claim that can be granted now; otherwise look again when the node opens."""
        guard = self.rules.guard
        for claim in self.claims:  # a claim without room is passed over: the node is for claims with room
            if claim.has_room:
                if claim.because is not None:
                    self.now_waits_for(claim, None, now)
                if not self.is_open(claim.robot, claim.via, now):
                    # Only time keeps it waiting, so it is not passed over: a platoon that goes straight on, to which
                    # the node is never closed, would keep a crossing robot waiting to its end.
                    if self.holder is None:
                        break
                elif guard is None or guard.admit(claim.robot, self, claim.lane):
                    self.award(claim, claim.lane)
                    return
            else:
                self.wait_for_opening(claim, now)
        if self.holder is None:
            self.reopen_later(now)

    def reopen_later(self, now: float) -> None:
        """Serve the claims again when the first of them is past its closing time, the shortest wait possible."""
        when = math.inf
        for claim in self.claims:
            time = self.opens_at(claim.robot, claim.via)
            if now + EPS < time < when:
                when = time
        if when < self.reopens:
            self.reopens = when
            Timeout(self.rules.env, when - now).callbacks.append(self._reopen)

    def _reopen(self, _: Event) -> None:
        self.reopens = math.inf
        if self.claims:
            self.freed(self.rules.env._now)

    def wait_for_opening(self, claim: Claim, now: float) -> None:
        """Schedule another look at a claim that waits for a closed lane, for when the lane opens."""
        closure = claim.shut_by
        if closure is not claim.because:
            self.now_waits_for(claim, closure, now)
        when = math.inf if closure is None else closure.opens_for(claim.robot, now)
        if when < self.opening:
            self.opening = when
            Arrival(self.rules.env, when).callbacks.append(self._opened)

    def _opened(self, _: Event) -> None:
        """Examine robots that were kept out of a lane that has opened: they may now close a ring."""
        self.opening = math.inf
        now: float = self.rules.env._now
        for claim in self.claims:
            if claim.because is not None and claim.shut_by is None:
                self.now_waits_for(claim, None, now)
        if self.claims:
            self.serve(now)
            for claim in list(self.claims):
                self.rules.gridlock.check(claim.robot)

    # Leaving it

    def passed(self, robot: Body, onward: Lane, time: float) -> None:
        """Note that a robot's centre leaves the intersection for a lane at `time`. The last robot to do so counts."""
        if self.holder is robot:  # in a rotation it may be the next robot's already
            self.holder = None
        if time >= self.left_at:
            self.user = robot
            self.left_at = time
            self.left_on = onward
            self.left_pace = robot.pace

    def freed(self, now: float) -> None:
        """Serve the claims of the free intersection. Robots that now wait for room may have closed a ring.

        Rings close at three moments: here, when a robot becomes blocked, and when a node opens again.
        """
        self.serve(now)
        if self.holder is None and math.isinf(self.reopens):
            for claim in list(self.claims):
                self.rules.gridlock.check(claim.robot)

    def now_waits_for(self, claim: Claim, closure: Closure | None, now: float) -> None:
        """Begin a new episode of waiting for another cause, a closure or (None) robots, and count the wait so far.

        Where one person leaves and another stays no new episode begins: the claim still waits for people.
        """
        before = claim.because
        if before is not None and closure is not None and before.wait == closure.wait:
            claim.attribute(closure)
            return
        self.count_claim(claim, claim.other, now)
        claim.attribute(closure)
        claim.other = self.holder or self.user
        claim.robot.waits_anew(now)

    def count_claim(self, claim: Claim, other: Body | None, end: float) -> None:
        """Count an episode of waiting for a claim: a collision, unless a closure is in the way."""
        robot, closure = claim.robot, claim.because
        duration = end - robot.waiting_since
        if duration <= EPS:
            return
        if closure is None:
            self.count_wait(robot, other, duration, end)
            return
        robot.kept_out(closure, duration)
        if self.rules.log.everything:
            assert claim.kept_out_of is not None
            self.rules.log.kept_out(end, robot, closure.wait, self.name, claim.kept_out_of.edge, duration)

    def count_wait(self, robot: Body, other: Body | None, duration: float, end: float) -> None:
        """Count a collision: an episode of waiting before this intersection that ends at `end`."""
        self.waits += 1
        self.blocked += duration
        robot.count_wait_at_node(duration)
        if self.rules.log.everything:
            self.rules.log.collision(end, robot, other, self.name, None, duration)


def _pace_by(robot: Body, via: Lane) -> float:
    """Return the pace at which a robot arrives by a lane: if it is on it already, no slower than it drives there."""
    pace = min(robot.speed, via.limit)
    return max(pace, robot.pace) if robot.lane is via else pace


class FreeIntersection(Intersection):
    """A node at which no robot waits for another, for the question: what if it were no bottleneck?

    It is open to all at once. Robots still spend their time there and wait for room on the lane beyond, where they keep
    D as everywhere (see `Lane.free_at`, which treats such a floor as having mixed speeds).
    """

    __slots__ = ()

    def is_open(self, robot: Body, via: Lane | None, now: float) -> bool:  # noqa: ARG002
        """Return True: the intersection is always open."""
        return True

    def opens_at(self, robot: Body, via: Lane | None) -> float:  # noqa: ARG002
        """Return -inf: the intersection never closes."""
        return -math.inf

    def grant(self, robot: Body, lane: Lane | None) -> None:
        """Let a robot stand on the intersection, with others, with room on `lane`."""
        robot.hold(self, lane)
        if lane is not None:
            lane.entering = robot
