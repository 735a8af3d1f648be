"""Motion: how a robot sets off, and who can set off because of it.

A robot commits to a target on its lane that keeps it D behind the target of the robot ahead and drives there in
one timeout. Nothing polls: whoever makes way lets those behind set off at once, down the queue, and serves the
claims for the room it left.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.world.gridlock import Gridlock
from desim_warehouse.world.lanes import EPS
from desim_warehouse.world.reservations import Reservations

if TYPE_CHECKING:
    from simpy import Environment

    from desim_warehouse.layout import Layout
    from desim_warehouse.log import Log
    from desim_warehouse.world.body import Body
    from desim_warehouse.world.lanes import Intersection, Lane
    from desim_warehouse.world.trip import Trip


class Motion(Reservations):
    """Robots on lanes; `node_time` is spent at every node reached (turning and re-planning)."""

    def __init__(
        self,
        env: Environment,
        layout: Layout,
        log: Log,
        *,
        contact: float,
        theta: float,
        node_time: float,
        mixed: bool = True,
        rotate: bool = True,
    ) -> None:
        super().__init__(env, layout, log, contact=contact, theta=theta, mixed=mixed)
        self.gridlock = Gridlock(self, rotate)
        self.node_time = node_time
        self.exits = mixed or log.everything  # whether anybody asks when a robot leaves a lane

    def cross(self, robot: Body, onward: Lane, clear: float, stop: float | None) -> None:
        """Set out over an intersection that is the robot's own, onto the lane beyond; it leaves the node at `clear`."""
        lane, behind, ahead = robot.lane, robot.behind, onward.last
        self.unlink(robot, clear - self.node_time)
        pace = self.pace_on(robot, onward) if self.mixed else robot.speed
        target = robot.goal = onward.stop_line if stop is None else stop
        if ahead is not None:
            target = min(target, max(ahead.target - self.contact, 0.0))  # in a rotation there may be no room yet
            ahead.behind = robot
        until = clear + target / pace
        if self.mixed and (late := self.free_at(onward, ahead, target, pace, clear) - until) > EPS:
            self.count_wait(robot, ahead, onward, late, ahead=clear + late - self.env._now)
            clear += late
            until += late
        robot.lane = onward
        robot.ahead = ahead
        robot.held = robot.granted = None
        robot.pace = pace
        robot.pos = 0.0
        robot.target = target
        robot.since = clear
        robot.until = until
        robot.moves += 1
        onward.last = robot
        onward.entering = False
        onward.passages += 1
        if self.log.moves:
            self.log.cross(self.env._now, robot, lane, clear)
        if lane is not None:
            self._made_room(lane, behind)
        self.leave(robot, onward.start)

    def commit(self, robot: Body, target: float) -> None:
        """Let a robot drive on to `target` on its lane, and all set off who gain by it."""
        self._set_off(robot, target)
        self._made_room(robot.lane, robot.behind)

    def _made_room(self, lane: Lane, behind: Body | None) -> None:
        """There is more room before the robot `behind` on a lane, or (None) at the lane's start, for those who wait."""
        if behind is None:
            if lane.wanted:
                self.serve(lane.start)
        elif behind.waiting_behind is not None:
            self.pull(behind)

    def pull(self, robot: Body | None) -> None:
        """The waiting robot behind one that has made way sets off, then the next behind it, and so on.

        Each is woken when it is at its new target: a queue moves up by one event a robot.
        """
        while robot is not None and robot.waiting_behind is not None:
            ahead = robot.ahead
            limit = robot.goal if ahead is None else min(robot.goal, ahead.target - self.contact)
            if limit <= robot.pos + EPS:
                return
            trip = self._stop_waiting(robot)
            self._set_off(robot, limit)
            trip.due(robot.until)
            lane = robot.lane
            robot = robot.behind
            if robot is None and lane.wanted:
                self.serve(lane.start)

    def _stop_waiting(self, robot: Body) -> Trip:
        """A robot that waited behind another waits no longer; the caller says when its trip goes on."""
        trip, robot.waiting_behind = robot.waiting_behind, None
        assert trip is not None
        robot.stands(waiting=False)
        if self.env._now > robot.waiting_since + EPS:
            self.count_wait(robot, robot.waits_for, robot.lane, self.env._now - robot.waiting_since)
        return trip

    def halt_here(self, robot: Body) -> None:
        """A robot that waits less than a place before its own stop takes where it stands for the stop."""
        robot.goal = robot.pos
        self._stop_waiting(robot).due(self.env._now)

    def _set_off(self, robot: Body, target: float) -> None:
        """Drive to `target`; behind a slower robot later, so that it comes no closer on the way."""
        lane = robot.lane
        since = self.env._now
        until = since + (target - robot.pos) / robot.pace
        if self.mixed and (late := self.free_at(lane, robot.ahead, target, robot.pace, since) - until) > EPS:
            self.count_wait(robot, robot.ahead, lane, late, ahead=late)
            since += late
            until += late
        robot.since = since
        robot.until = until
        robot.target = target
        if self.log.everything:
            self.log.drive(robot)

    def free_at(self, lane: Lane, ahead: Body | None, target: float, pace: float, since: float) -> float:
        """When a robot may be at `target`: D behind the one ahead all the way, on the lane or just off its end.

        Both drive at a steady pace, so it is enough that it keeps D at its target and where the one ahead sets off,
        if that is after `since`, when it could set off itself.
        """
        if ahead is None:
            beyond = target - (lane.length - self.contact)
            return lane.out_at + beyond / (pace if beyond > 0 else lane.out_pace)
        free = ahead.passes(target + self.contact)
        if ahead.since > since:
            free = max(free, ahead.since + max(target - (ahead.pos - self.contact), 0.0) / pace)
        return free

    @staticmethod
    def pace_on(robot: Body, lane: Lane) -> float:
        """Its own speed, the lane's limit, or that of the ring that it turns with, whatever is least."""
        train, robot.train_pace = robot.train_pace, math.inf
        return min(robot.speed, lane.limit, train)

    def enter(self, robot: Body, lane: Lane) -> None:
        """Move a robot's centre from its node onto the start of a lane, behind the last robot there."""
        self.unlink(robot, self.env._now)
        robot.ahead = lane.last
        if lane.last is not None:
            lane.last.behind = robot
        lane.last = robot
        lane.passages += 1
        robot.lane = lane
        robot.pos = robot.target = 0.0
        robot.moves += 1
        robot.pace = self.pace_on(robot, lane)
        if self.log.moves:
            self.log.enter(self.env._now, robot)

    def unlink(self, robot: Body, out: float) -> None:
        """Take a robot off its lane, if it is on one, whose end it leaves at the time `out`."""
        lane, front, behind = robot.lane, robot.ahead, robot.behind
        if lane is None:
            return
        robot.driven += lane.length
        if self.exits and out > lane.out_at:
            lane.out_at = out
            lane.out_pace = robot.pace
        if front is not None:  # in a rotation it may go before the robot ahead, which is on its node
            front.behind = behind
        if behind is None:
            lane.last = front
        else:
            behind.ahead = front
            robot.behind = None

    def into_bay(self, robot: Body) -> None:
        """From the node it stands on into the bay beside it: at once, and the node is open to all."""
        node = robot.held
        lane = robot.lane
        self.unlink(robot, self.env._now)
        if lane is not None:
            lane.out_at = -math.inf  # it is in nobody's way any more
        robot.lane = robot.held = robot.ahead = None
        robot.at = node
        robot.pos = robot.target = 0.0
        if node.holder is robot:
            node.holder = None
        if node.claims:
            self.freed(node)

    def leave(self, robot: Body, node: Intersection) -> None:
        """A robot leaves an intersection along its lane, at the time at which it sets off there."""
        if node.holder is robot:  # in a rotation it may be the next robot's already
            node.holder = None
        node.left_by(robot, robot.lane, robot.since)
        if node.claims:
            self.freed(node)
