"""Wide aisles: a robot that loads or unloads stands beside its lane, and returns by a claim for room on it.

Beside each place there is room for one robot. It is off the lane's queue, so others drive past. To return it needs room
where it stands: no robot nearer than D, none ahead of it whose sure target is nearer than that, and none behind it
whose target is farther. While it waits for room it holds nothing, so no robot waits for it, and no ring closes through
it. Where rings turn, no other robot is let onto the lane meanwhile, so it returns after those that are on it
(`has_room`). A turning ring ignores that.

A robot that finds the room taken waits in the lane. When the one beside it is ready the two change places at once.
Where lanes are two-way the guard may refuse that; then the waiting robot loads in the lane, as in a narrow aisle. It
does so too while the one beside the lane is broken, as a repair would hold up the whole aisle. So it waits for time
alone (proof: docs/why.md, "Wide aisles").
"""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import Any, cast

from simpy.events import Event

from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.events import AFTER_DECISIONS, Arrival, Steps, end_of_instant
from desim_warehouse.world.traffic.intersection import Claim
from desim_warehouse.world.traffic.lane import Lane, RestrictedLane
from desim_warehouse.world.traffic.rules import EPS


class RoomClaim(Event):
    """A robot's request to leave its lane, or to return onto it: a claim whose `node` is the lane.

    It has the attributes of `intersection.Claim` that are read of waiting robots. `lane` is the lane on which the robot
    needs room; None: it waits in the lane for the robot beside it.
    """

    via = over = because = met = shut_by = kept_out_of = None

    def __init__(self, robot: Body, lane: WideLane | None, other: Body | None) -> None:
        self.node: WideLane = robot.lane
        super().__init__(self.node.rules.env)
        self.robot = robot
        self.lane = lane
        self.other = other
        self.begun: float = self.node.rules.env._now


class Side:
    """The places beside a lane, for both directions of a two-way lane.

    `beside` maps positions along the lane to the robots there. `ready` are those that have loaded. `queued` wait in the
    lane for the room beside a place. `claims` are those of robots that wait for room on the lane, the oldest first.
    `looks_at`: when they are examined next.
    """

    def __init__(self) -> None:
        self.beside: dict[float, Body] = {}
        self.ready: dict[Body, None] = {}
        self.queued: dict[float, RoomClaim] = {}
        self.claims: list[RoomClaim] = []
        self.looks_at = math.inf


class WideLane(Lane):
    """A lane in a wide aisle, with the places beside it.

    Attributes:
        yields: whether no robot is let in while another waits to come back.
        looks: whether robots that drive past decide again before each robot beside the lane, so that a robot ready
            there goes first; not where robots brake for everything that they are not sure of.
    """

    holder = None
    is_lift = False

    def __init__(self, *args: Any, yields: bool, looks: bool, twin: Lane | None = None, **of_lane: Any) -> None:
        self.side: Side = twin.side if isinstance(twin, WideLane) else Side()
        self.yields = yields
        self.looks = looks
        super().__init__(*args, twin=twin, **of_lane)

    @property
    def claims(self) -> list[RoomClaim]:
        """The claims of robots that wait for room on this lane or its twin."""
        return self.side.claims

    # Attributes that others read and set: on any change the robots beside the lane are examined.

    @property
    def entering(self) -> Body | None:
        """The robot that was granted room and has not yet set out for it."""
        return self._entering

    @entering.setter
    def entering(self, robot: Body | None) -> None:
        self._entering = robot
        self.freed()

    @property
    def last(self) -> Body | None:
        """The robot that entered last and is still on it."""
        return self._last

    @last.setter
    def last(self, robot: Body | None) -> None:
        self._last = robot
        self.freed()

    def made_room(self, behind: Body | None, now: float) -> None:
        """Let robots use the room before `behind`, or at the lane's start, and examine those beside the lane."""
        super().made_room(behind, now)
        self.freed()

    def has_room(self, robot: Body) -> bool:
        """Whether a robot can enter at the start. It yields to those that wait to return, unless a ring turns.

        To make room, robots not yet sure of their way past others beside the lane are made so.
        """
        claims = self.side.claims
        if claims and (self.yields or any(claim.robot is robot for claim in claims)):
            return False
        if self._last is not None and self.side.beside and self._last.target < 2 * self.headway - EPS:
            first = self._last
            while first.ahead is not None:
                first = first.ahead
            self.move_up(first, self.rules.env._now)
        return super().has_room(robot)

    # Robots that drive past: up to D before each place with a robot beside it, and then on

    def enter(self, robot: Body, clear: float, stop: float | None, now: float) -> None:
        """Let a robot enter as the last, sure of its way up to the first place with a robot beside the lane."""
        goal = self.stop_line if stop is None else stop
        super().enter(robot, clear, self._first_of(0.0, goal), now)
        robot.head_for(goal)

    def first_target(self, stop: float | None) -> float:
        """Return how far a robot that enters the lane now commits to drive on it (see `enter`)."""
        goal = self.stop_line if stop is None else stop
        return super().first_target(self._first_of(0.0, goal))

    def commit(self, robot: Body, target: float, now: float) -> None:
        """Let a robot drive on, up to the next place with a robot beside the lane."""
        super().commit(robot, self._first_of(robot.target, target), now)

    def _first_of(self, place: float, target: float) -> float:
        """Return the target, or D before the first robot beside the lane between `place` and the target.

        Positions within 2 D of the lane's start do not count, so that the next robot can come in.
        """
        if not self.looks:
            return target
        headway, first = self.headway, target
        for other in self.side.beside.values():
            before = other.pos - headway
            if other.lane is self and place + EPS < before < first and before >= 2 * headway:
                first = before
        return first

    # Off the lane

    def has_place(self, robot: Body, stop: float | None) -> bool:
        """Whether a robot stands at its place on the lane, not short of it in a ring that turned."""
        return robot.lane is self and robot.held is None and stop is not None and abs(robot.pos - stop) <= EPS

    def stand_aside(self, robot: Body) -> Generator[Event, object, bool]:
        """Leave the lane once there is room beside it. Returns whether it has; if not, it loads in the lane."""
        side, place = self.side, self._place(robot)
        other = side.beside.get(place)
        if other is None:
            self._leave(robot)
            return True
        if other.broken:
            return False
        if other in side.ready:
            return self._change_places(robot, other)
        claim = side.queued[place] = RoomClaim(robot, None, other)
        yield from self._wait(claim)
        return bool(claim.value)

    def break_down(self, robot: Body) -> None:
        """Let a robot that waits for the room beside the lane load in the lane, as a broken robot keeps the room."""
        queued = self.side.queued.pop(self._place(robot), None)
        if queued is not None:
            queued.robot.resume()
            queued.succeed(value=False)

    def come_back(self, robot: Body) -> Steps:
        """Return onto the lane once there is room, where the robot left it."""
        side = self.side
        side.ready[robot] = None
        queued = side.queued.pop(self._place(robot), None)
        if queued is not None:
            queued.robot.resume()
            queued.succeed(self._change_places(queued.robot, robot))
        if robot in side.ready and (side.claims or not self._joins(robot)):
            claim = RoomClaim(robot, self, self.last)
            side.claims.append(claim)
            self.freed()
            yield from self._wait(claim)

    @staticmethod
    def _place(robot: Body) -> float:
        """Return the position of a robot along its lane, in the direction that stands for both."""
        lane: WideLane = robot.lane
        return round(robot.pos if lane.lane_of_both is lane else lane.length - robot.pos, 6)

    def _wait(self, claim: RoomClaim) -> Steps:
        robot = claim.robot
        robot.wait_for(cast("Claim", claim), self.rules.env._now)
        self.rules.gridlock.check(robot)
        robot.driver.notice_wait(waiting=True)
        yield claim
        robot.driver.notice_wait(waiting=False)
        self.count_claim(claim, claim.other, self.rules.env._now)

    def _leave(self, robot: Body) -> None:
        """Take a robot off the lane's queue; those behind it move up."""
        behind, now = robot.behind, self.rules.env._now
        self._unlink(robot)
        self._stands_aside(robot)
        self.made_room(behind, now)
        if self.end.claims:  # at a two-way lane's end others wait to come in
            self.end.freed(now)

    def _stands_aside(self, robot: Body) -> None:
        self.side.beside[self._place(robot)] = robot
        robot.driver.stood_aside()
        self.rules.log.aside(self.rules.env._now, robot)

    # Returning onto the lane

    def _joins(self, robot: Body) -> bool:
        """Put a robot back onto the lane now, if there is room."""
        twin, guard, last = self.twin, self.rules.guard, self.last
        if self.entering is not None or (twin is not None and (twin.last is not None or twin.entering is not None)):
            return False
        if last is not None and last.target < self.headway - EPS:  # a ring turns
            return False
        ahead, behind = self._neighbours(robot.pos)
        if self._clear_for(robot, ahead) > self.rules.env._now + EPS or (guard is not None and behind is not None):
            return False
        self._link(robot, ahead, behind)
        if guard is not None and not guard.admit(robot, self.end, self):
            self._unlink(robot)
            return False
        del self.side.beside[self._place(robot)]
        self._is_back(robot)
        return True

    def _neighbours(self, place: float) -> tuple[Body | None, Body | None]:
        """Return the last robot that goes nearer than D to a place, or beyond it, and the robot behind that."""
        ahead, behind = self.last, None
        while ahead is not None and ahead.target <= place - self.headway + EPS:
            ahead, behind = ahead.ahead, ahead
        return ahead, behind

    def _clear_for(self, robot: Body, ahead: Body | None) -> float:
        """Return when a robot beside the lane can return, with no other nearer than D, ahead or behind.

        It is inf if the robot ahead is not sure to get that far. The last robot in the other direction must be through,
        too.
        """
        if ahead is not None and ahead.target < robot.pos + self.headway - EPS:
            return math.inf
        through = -math.inf if self.twin is None else self.twin.out_at
        return max(self._clear_at(ahead, robot.pos, robot.pace), through)

    def _change_places(self, robot: Body, other: Body) -> bool:
        """Let a robot beside the lane change places at once with the one that stands in it, if that is safe.

        The guard is asked as if it returned behind that robot, which leaves the lane only then.
        """
        guard = self.rules.guard
        if robot.lane is not other.lane:
            return False
        if guard is not None:
            if robot.behind is not None or self.entering is not None:
                return False
            self._link(other, robot, None)
            admitted = guard.admit(other, self.end, self)
            self._unlink(other)
            if not admitted:
                return False
        ahead, behind = robot.ahead, robot.behind
        self._unlink(robot)
        self._stands_aside(robot)
        self._link(other, ahead, behind)
        self._is_back(other)
        return True

    def _is_back(self, robot: Body) -> None:
        """Note that a robot is on the lane again, and wake it if it waited for that."""
        side = self.side
        del side.ready[robot]
        now = self.rules.env._now
        robot.be_on_lane_again(now)
        self.rules.log.back(now, robot)
        for claim in side.claims:
            if claim.robot is robot:
                side.claims.remove(claim)
                robot.resume()
                claim.succeed()
                break

    def _link(self, robot: Body, ahead: Body | None, behind: Body | None) -> None:
        robot.queue_between(ahead, behind)
        if behind is None:
            self._last = robot  # a change of its own, after which there is no more room than before

    def _unlink(self, robot: Body) -> None:
        ahead = robot.ahead
        robot.leave_queue()
        if self._last is robot:
            self._last = ahead

    # As the `node` of claims

    def freed(self, now: float | None = None) -> None:
        """Look at robots that wait to come back, at the end of this instant or at a later time."""
        side, env = self.side, self.rules.env
        if not side.claims:
            return
        time = env._now if now is None else now
        if time < side.looks_at:
            side.looks_at = time
            event = end_of_instant(env, AFTER_DECISIONS) if time <= env._now else Arrival(env, time)
            event.callbacks.append(self._look)

    def wait_for_opening(self, claim: RoomClaim, now: float) -> None:
        """Do nothing: the lane is not closed to a robot that is in the aisle already."""

    def count_claim(self, claim: RoomClaim, other: Body | None, end: float) -> None:
        """Count a wait for room, beside the lane or on it, as a wait behind a robot on the lane."""
        duration = end - claim.robot.waiting_since
        if duration > EPS:
            self.count_wait(claim.robot, other or claim.other, duration, end)

    def _look(self, _: Event) -> None:
        side, now = self.side, self.rules.env._now
        if side.looks_at > now:  # it was looked at before this
            return
        side.looks_at = math.inf
        for claim in list(side.claims):
            claim.node._joins(claim.robot)
        due = math.inf
        for claim in side.claims:
            lane = claim.node
            clear = lane._clear_for(claim.robot, lane._neighbours(claim.robot.pos)[0])
            due = clear if now + EPS < clear < due else due
        if due < math.inf:
            self.freed(due)
        if self.wanted:
            self.start.serve(now)


class WideRestrictedLane(WideLane, RestrictedLane):
    """A lane in a wide aisle that is closed or slow at times. Coming back onto it is not entering it."""
