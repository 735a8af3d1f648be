"""Collision waiting as contention: how robots drive along lanes and over intersections.

A robot commits to a target on its lane that keeps it D behind the target of the robot ahead, drives there in
one timeout and looks again. At the stop line, D before an intersection, it claims in one step the intersection
and room to stand beyond it; as both are then its own until it is through, the same timeout takes it over the
intersection and on to its next target: one event an edge where nobody is in the way. Nothing polls: a waiting
robot is woken by whoever made way.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from simpy.events import Timeout

from desim_warehouse.world.lanes import EPS
from desim_warehouse.world.reservations import Reservations

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from simpy import Environment
    from simpy.events import Event

    from desim_warehouse.layout import Layout
    from desim_warehouse.log import Log
    from desim_warehouse.world.body import Body
    from desim_warehouse.world.lanes import Intersection, Lane
    from desim_warehouse.world.reservations import Steps

Route = "Sequence[Lane]"


class Traffic(Reservations):
    """The Highways in use; `node_time` is spent at every node reached (turning and re-planning)."""

    def __init__(
        self,
        env: Environment,
        layout: Layout,
        log: Log,
        *,
        contact: float,
        theta: float,
        node_time: float,
        rotate: bool = True,
    ) -> None:
        super().__init__(env, layout, log, contact=contact, theta=theta, rotate=rotate)
        self.node_time = node_time

    def drive(self, robot: Body, route: Sequence[Lane], stop: float | None = None) -> Steps:
        """Drive the lanes of `route` to `stop` on the last of them (None: to its end) from wherever the robot is.

        Returns True there, False if the robot was recalled: it then stands on the node it came to next.
        This is the hot path of every run.
        """
        env = self.env
        contact = self.contact
        index, count = 0, len(route)
        while True:
            if robot.lane is None or robot.held is not None:
                arrived, index = yield from self._from_node(robot, route, index, stop)
                if arrived is not None:
                    return arrived
            # Along the lane: as far as the robot ahead allows, to the own stop or to the stop line.
            lane = robot.lane
            goal = lane.stop_line
            if index == count and stop is not None and stop < goal:
                goal = stop
            while True:
                if robot.until > env._now:
                    yield Timeout(env, robot.until - env._now)
                robot.pos = robot.target
                if robot.pos >= goal - EPS:
                    break
                ahead = robot.ahead
                limit = goal if ahead is None else min(goal, ahead.target - ahead.gap - robot.gap)
                if limit > robot.pos + EPS:
                    self.commit(robot, limit)
                else:
                    robot.goal = goal
                    yield self.wait_behind(robot)
            if index == count:
                if stop is not None and stop <= goal + EPS:
                    return True
                onward = None
            else:
                onward = route[index]
            # At the stop line: the intersection, and room beyond it, or neither.
            clear = env._now + (lane.length - robot.pos) / robot.pace + self.node_time
            if (
                onward is not None
                and not onward.short
                and robot.recall_at > clear
                and (index < count - 1 or stop is None or stop >= contact)
            ):
                node = lane.end
                last = onward.last
                if (
                    node.claims
                    or node.holder is not None
                    or node.clear_at > env._now + EPS
                    and not self.is_open(robot, node, lane)
                    or onward.entering
                    or last is not None
                    and last.target - last.gap - robot.gap < contact - EPS
                ):
                    yield from self.claim(robot, node, onward, lane)
                    clear = env._now + (lane.length - robot.pos) / robot.pace + self.node_time
                if robot.recall_at > clear:
                    index += 1
                    self.cross(robot, onward, clear, stop if index == count else None)
                    continue
            if (yield from self._to_node(robot, route, index, stop)):
                return True

    def cross(self, robot: Body, onward: Lane, clear: float, stop: float | None) -> None:
        """Set out over an intersection that is the robot's own, onto the lane beyond; it leaves the node at `clear`."""
        lane = robot.lane
        behind = robot.behind
        ahead = onward.last
        pace = robot.speed if robot.speed < onward.limit else onward.limit
        target = onward.stop_line if stop is None or stop > onward.stop_line else stop
        until = clear + target / pace
        if ahead is not None:
            gap = ahead.gap + robot.gap
            if ahead.target - gap < target:
                target = ahead.target - gap
                until = clear + target / pace
            if ahead.until > until:
                late = ahead.passes(target + gap) - until
                if late > EPS:
                    self.count_wait(robot, ahead, onward, late)
                    clear += late
                    until += late
            ahead.behind = robot
        if lane is not None:
            robot.driven += lane.length
            lane.out_at = clear - self.node_time
            lane.out_pace = robot.pace
        robot.lane = onward
        robot.ahead = ahead
        robot.behind = robot.held = robot.granted = None
        robot.pace = pace
        robot.pos = 0.0
        robot.target = target
        robot.since = clear
        robot.until = until
        robot.moves += 1
        onward.last = robot
        onward.entering = False
        onward.passages += 1
        node = onward.start
        node.holder = None
        node.user = robot
        node.passages += 1
        node.left_at = clear
        node.left_on = onward
        node.left_pace = pace
        node.clear_at = clear + self.contact / pace
        if self.log.moves:
            self.log.cross(self.env._now, robot, lane, clear)
        # Whoever gains sets off: the robots behind, whoever waits for room on the lane left, the node's claims.
        if behind is not None:
            behind.ahead = None
            if behind.waiting_behind is not None:
                self.pull(behind)
        elif lane is not None:
            lane.last = None
            if lane.start.claims:
                self.serve(lane.start)
        if node.claims:
            self.serve(node)

    def commit(self, robot: Body, target: float) -> None:
        """Let a robot drive on to `target` on its lane, and all set off who gain by it."""
        self._set_off(robot, target)
        behind = robot.behind
        if behind is not None:
            if behind.waiting_behind is not None:
                self.pull(behind)
        elif robot.lane.start.claims:
            self.serve(robot.lane.start)

    def pull(self, robot: Body | None) -> None:
        """The waiting robot behind one that has made way sets off, then the next behind it, and so on.

        Each is woken when it is at its new target: a queue moves up by one event a robot.
        """
        env = self.env
        while robot is not None and robot.waiting_behind is not None:
            ahead = robot.ahead
            limit = robot.goal if ahead is None else min(robot.goal, ahead.target - ahead.gap - robot.gap)
            if limit <= robot.pos + EPS:
                return
            event, robot.waiting_behind = robot.waiting_behind, None
            robot.stands(waiting=False)
            if env._now > robot.waiting_since + EPS:
                self.count_wait(robot, ahead, robot.lane, env._now - robot.waiting_since)
            self._set_off(robot, limit)
            event._ok = True
            event._value = None
            env.schedule(event, delay=robot.until - env._now)
            lane = robot.lane
            robot = robot.behind
            if robot is None and lane.start.claims:
                self.serve(lane.start)

    def _set_off(self, robot: Body, target: float) -> None:
        """Drive to `target`; behind a slower robot later, so that it comes no closer on the way."""
        lane = robot.lane
        since = self.env._now
        until = since + (target - robot.pos) / robot.pace
        ahead = robot.ahead
        free = until
        if ahead is None:
            if lane.out_at > until:
                free = lane.out_at - (lane.length - self.contact - target) / lane.out_pace
        elif ahead.until > until:
            free = ahead.passes(target + ahead.gap + robot.gap)
        if free > until + EPS:
            self.count_wait(robot, ahead, lane, free - until)
            since += free - until
            until = free
        robot.since = since
        robot.until = until
        robot.target = target
        if self.log.everything:
            self.log.drive(robot)
        if robot.trailing is not None and target >= self.contact - EPS:
            self._leave(robot, robot.trailing)
            robot.trailing = None

    # Where a robot stands on an intersection: bays, stations in the lane, lanes too short to stand on, recalls.

    def rests_beyond(self, route: Sequence[Lane], index: int, stop: float | None) -> Lane | None:
        """The lane on which a robot can next stand clear of the intersection before `route[index]`, if any."""
        for i in range(index, len(route)):
            lane = route[i]
            if not lane.inside:
                near = i == len(route) - 1 and stop is not None and stop < self.contact - EPS
                return None if lane.short or near else lane
        return None

    def _to_node(self, robot: Body, route: Sequence[Lane], index: int, stop: float | None) -> Steps:
        """From the stop line to stand on the intersection, or at a stop close before it (then: True)."""
        lane = robot.lane
        final = index == len(route) and stop is not None
        if robot.held is None:
            wanted = self.rests_beyond(route, index, stop) if robot.recall_at > self.env._now else None
            yield from self.claim(robot, lane.end, wanted, lane)
        yield from self._advance(robot, stop if final else lane.length)
        return final

    def _advance(self, robot: Body, target: float) -> Generator[Event, object, None]:
        """Along the lane to `target`, nothing more to ask for; at its end the node's time is spent."""
        self.commit(robot, target)
        pause = self.node_time if target == robot.lane.length else 0.0
        yield Timeout(self.env, robot.until - self.env._now + pause)
        robot.pos = target

    def _from_node(
        self, robot: Body, route: Sequence[Lane], index: int, stop: float | None
    ) -> Generator[Event, object, tuple[bool | None, int]]:
        """From a bay or an intersection onto the next lane where it can stand.

        Returns whether the drive is over (True: there, False: recalled, None: no) and how far on the route it is.
        """
        if robot.held is None:
            yield from self.claim(robot, robot.at, self.rests_beyond(route, index, stop), None)
            robot.left_bay()
        elif robot.lane is not None and robot.pos < robot.lane.length:
            yield from self._advance(robot, robot.lane.length)
        while True:
            if robot.recall_at <= self.env._now:
                self._give_back(robot)
                return False, index
            if index == len(route):
                return True, index
            onward = route[index]
            if self.rests_beyond(route[index : index + 1], 0, stop if index + 1 == len(route) else None):
                if robot.granted is not onward:
                    yield from self.claim(robot, robot.held, onward, robot.lane)
                index += 1
                self.cross(robot, onward, self.env._now, stop if index == len(route) else None)
                return None, index
            index += 1
            if (yield from self._over_short(robot, onward, route, index, stop)):
                return True, index

    def _over_short(
        self, robot: Body, onward: Lane, route: Sequence[Lane], index: int, stop: float | None
    ) -> Steps:
        """Over a lane too short to stand on, or to a stop close behind the node; True at the own stop."""
        node = robot.held
        if not onward.short:
            yield from self.claim(robot, node, onward, robot.lane)
        elif not onward.inside:
            yield from self.claim(robot, onward.end, self.rests_beyond(route, index, stop), onward)
        self._enter(robot, onward)
        robot.held = onward.end if onward.short else None
        if not onward.short:
            onward.entering = False
            robot.granted = None
        if not onward.inside:
            robot.trailing = node
        final = index == len(route) and stop is not None
        yield from self._advance(robot, stop if final else onward.length)
        return final

    def _enter(self, robot: Body, lane: Lane) -> None:
        """Move a robot's centre from its node onto the start of a lane, behind the last robot there."""
        self._unlink(robot)
        robot.ahead = lane.last
        if lane.last is not None:
            lane.last.behind = robot
        came_by = robot.lane
        lane.last = robot
        lane.passages += 1
        robot.lane = lane
        robot.pos = robot.target = 0.0
        robot.moves += 1
        robot.pace = min(robot.speed, lane.limit)
        if self.log.moves:
            self.log.cross(self.env._now, robot, None, self.env._now)

    def _unlink(self, robot: Body) -> None:
        """Take a robot that stands at the end of its lane off the lane."""
        lane = robot.lane
        if lane is None:
            return
        robot.driven += lane.length
        lane.out_at = self.env._now
        behind = robot.behind
        if behind is not None:
            behind.ahead = robot.behind = None
        else:
            lane.last = None

    def into_bay(self, robot: Body) -> None:
        """From the node it stands on into the bay beside it: at once, and the node is open to all."""
        node = robot.held
        self._unlink(robot)
        robot.lane = robot.held = robot.ahead = None
        robot.at = node
        robot.pos = robot.target = 0.0
        if node.holder is robot:
            node.holder = None
        if node.claims:
            self.serve(node)

    def _leave(self, robot: Body, node: Intersection) -> None:
        """A robot that stood on an intersection, or close behind it, sets off along its lane."""
        if node.holder is robot:
            node.holder = None
        node.user = robot
        node.passages += 1
        node.left_on = robot.lane
        node.left_pace = robot.pace
        node.left_at = robot.since - robot.pos / robot.pace
        node.clear_at = node.left_at + self.contact / robot.pace
        if node.claims:
            self.serve(node)

    @staticmethod
    def _give_back(robot: Body) -> None:
        """A recalled robot stays on the intersection and leaves the room beyond it to others."""
        if robot.granted is not None:
            robot.granted.entering = False
            robot.granted = None
