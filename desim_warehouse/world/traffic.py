"""Collision waiting as contention: how robots drive along lanes and over intersections, and who waits for whom.

The rules are those of docs/why.md: a robot commits to a target on its lane that keeps it D behind the target
of the robot ahead, drives there in one timeout and looks again; before an intersection it claims, in one step,
the intersection and room to stand beyond it. Nothing polls: a waiting robot is woken by whoever made way.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from simpy.events import Event, Timeout

from desim_warehouse.world.gridlock import Gridlock
from desim_warehouse.world.lanes import EPS, Claim, Lane, closing_distance, network, turn

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from simpy import Environment

    from desim_warehouse.layout import Layout
    from desim_warehouse.log import Log
    from desim_warehouse.world.body import Body
    from desim_warehouse.world.lanes import Intersection

    Steps = Generator[Event, object, bool]


class Traffic:
    """The Highways in use.

    `contact` is D, the distance robots keep (the largest pair's); `theta` the collision angle in radians.
    """

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
        self.env = env
        self.log = log
        self.contact = contact
        self.theta = theta
        self.node_time = node_time
        self.lanes, self.nodes = network(layout, contact)
        self.gridlock = Gridlock(self, rotate)
        self._closings: dict[tuple[Lane | None, Lane, bool], float] = {}

    # Driving

    def drive(self, robot: Body, route: Sequence[Lane], stop: float | None = None) -> Steps:  # noqa: C901, PLR0912
        """Drive the lanes of `route` to `stop` on the last of them (None: to its end) from wherever the robot is.

        Returns True there, False if the robot was recalled: it then stands on the node it came to next.
        The hot path of every run, so the two ever-repeated steps stand here in one piece.
        """
        env = self.env
        index, count = 0, len(route)
        lane = robot.lane
        if lane is None:
            yield from self._leave_bay(robot, route)
        elif robot.held is not None and robot.pos < lane.length - EPS:
            yield from self._to_centre(robot, lane)
        while True:
            if robot.held is None:
                # On a lane: as far as the robot ahead allows, to the own stop or the stop line.
                final = index == count and stop is not None
                goal = min(stop, lane.stop_line) if final else lane.stop_line
                while True:
                    if robot.target > robot.pos:
                        yield Timeout(env, robot.until - env._now)
                        robot.pos = robot.target
                    if robot.pos >= goal - EPS:
                        break
                    limit = goal
                    ahead = robot.ahead
                    if ahead is not None:
                        room = ahead.target - ahead.gap - robot.gap
                        if room < limit:
                            limit = room
                    if limit > robot.pos + EPS:
                        self.commit(robot, limit)
                        if robot.trailing is not None:
                            self._clear_trailing(robot)
                    else:
                        yield from self._wait_behind(robot)
                if final and stop <= lane.stop_line + EPS:
                    return True
                # At the stop line: claim the intersection, and room beyond it.
                wanted = self._beyond(route, index) if index < count and not robot.recalled else None
                node = lane.end
                if not node.claims and self.can_grant(robot, node, wanted, lane):
                    self.grant(robot, node, wanted)
                else:
                    yield from self._claim(robot, node, wanted, lane)
                if final:
                    self.commit(robot, stop)
                    yield Timeout(env, robot.until - env._now)
                    robot.pos = stop
                    return True
                self.commit(robot, lane.length)
                yield Timeout(env, robot.until - env._now + self.node_time)
                robot.pos = lane.length
            # On an intersection, at the end of the lane that it came by.
            if robot.recalled:
                self._give_back(robot)
                return False
            if index == count:
                return True
            lane = route[index]
            index += 1
            if lane.short:
                yield from self._over_short(robot, lane, route, index, stop)
                if index == count and stop is not None:
                    return True
                continue
            if robot.granted is not lane:
                yield from self._claim(robot, robot.held, lane, robot.lane)
            node = robot.held
            ahead = lane.last
            goal = lane.stop_line
            if index == count and stop is not None and stop < goal:
                goal = stop
            if ahead is not None:
                room = ahead.target - ahead.gap - robot.gap
                if room < goal:
                    goal = room
            self.enter(robot, lane)
            lane.entering = False
            robot.granted = robot.held = None
            self.commit(robot, goal)
            if goal >= self.contact - EPS:
                self._leave(robot, node)
            else:
                robot.trailing = node

    def _leave_bay(self, robot: Body, route: Sequence[Lane]) -> Steps:
        """Out of the bay onto its node, with room on the lane it will take."""
        yield from self._claim(robot, robot.at, self._beyond(route, 0), None)
        return True

    def _to_centre(self, robot: Body, lane: Lane) -> Steps:
        """From a stop close before an intersection that it holds, onto the intersection."""
        self.commit(robot, lane.length)
        self._clear_trailing(robot)
        yield Timeout(self.env, robot.until - self.env._now + self.node_time)
        robot.pos = lane.length
        return True

    def _over_short(
        self, robot: Body, lane: Lane, route: Sequence[Lane], index: int, stop: float | None
    ) -> Steps:
        """Over a lane too short to stand on clear of its ends: it holds the lane's end before it sets off."""
        node = robot.held
        assert node is not None
        if not lane.inside:
            wanted = self._beyond(route, index) if index < len(route) else None
            yield from self._claim(robot, lane.end, wanted, lane)
        self.enter(robot, lane)
        robot.held = lane.end
        halt = stop if index == len(route) else None
        self.commit(robot, lane.length if halt is None else halt)
        if not lane.inside:
            robot.trailing = node
            if robot.target >= self.contact - EPS:
                self._clear_trailing(robot)
        yield Timeout(self.env, robot.until - self.env._now + (self.node_time if halt is None else 0.0))
        robot.pos = robot.target
        return True

    @staticmethod
    def _beyond(route: Sequence[Lane], index: int) -> Lane | None:
        """The lane on which a robot needs room to pass the next intersection; None: it stands on the intersection."""
        lane = route[index]
        while lane.inside:
            index += 1
            if index == len(route):
                return None
            lane = route[index]
        return None if lane.short else lane

    def commit(self, robot: Body, target: float) -> None:
        """Let a robot drive to `target`, and wake whoever gains by it.

        Behind a slower robot it sets off later, so that it comes no closer on the way.
        """
        since = self.env._now
        until = since + (target - robot.pos) / robot.pace
        ahead = robot.ahead
        if ahead is not None and ahead.until > until:
            clear = ahead.passes(target + ahead.gap + robot.gap)
            if clear > until + EPS:
                self._count_wait(robot, ahead, robot.lane, clear - until)
                since += clear - until
                until = clear
        robot.since = since
        robot.until = until
        robot.origin = robot.pos
        robot.distance += target - robot.pos
        robot.target = target
        if self.log.everything:
            self.log.drive(since, robot, target, until)
        behind = robot.behind
        if behind is not None:
            if behind.waiting_behind is not None:
                behind.waiting_behind.succeed()
                behind.waiting_behind = None
        elif robot.lane.start.claims:
            self.serve(robot.lane.start)

    def enter(self, robot: Body, lane: Lane) -> None:
        """Move a robot's centre from where it is onto the start of a lane, behind the last robot there."""
        self.unlink(robot)
        ahead = lane.last
        robot.ahead = ahead
        if ahead is not None:
            ahead.behind = robot
        lane.last = robot
        lane.passages += 1
        robot.came_by = robot.lane
        robot.lane = lane
        robot.pos = robot.target = 0.0
        robot.moves += 1
        robot.pace = robot.speed if robot.speed < lane.limit else lane.limit
        if self.log.moves:
            self.log.enter(self.env._now, robot)

    @staticmethod
    def unlink(robot: Body) -> None:
        """Take a robot, the first of its lane, off its lane."""
        behind = robot.behind
        if behind is not None:
            behind.ahead = None
            robot.behind = None
        elif robot.lane is not None:
            robot.lane.last = None

    def into_bay(self, robot: Body) -> None:
        """From the node it stands on into the bay beside it: at once, and the node is open to all."""
        node = robot.held
        assert node is not None
        self.unlink(robot)
        robot.lane = robot.held = robot.ahead = None
        robot.at = node
        robot.pos = robot.target = 0.0
        if node.holder is robot:
            node.holder = None
        if node.claims:
            self.serve(node)

    # Claims

    def can_grant(self, robot: Body, node: Intersection, lane: Lane | None, via: Lane | None) -> bool:
        """Whether a robot that comes `via` a lane (None: a bay) may have an intersection and room beyond, now."""
        holder = node.holder
        if holder is None:
            now = self.env._now + EPS
            if node.open_at > now and self.opens_at(robot, node, via) > now:
                return False
        elif holder is not robot:
            return False
        return lane is None or self.has_room(robot, lane)

    def has_room(self, robot: Body, lane: Lane) -> bool:
        """Whether a robot can come to a stand D beyond the lane's start, with nobody else on the way in."""
        if lane.entering:
            return False
        last = lane.last
        return last is None or last.target - last.gap - robot.gap >= self.contact - EPS

    def opens_at(self, robot: Body, node: Intersection, via: Lane | None) -> float:
        """When an intersection that was just left is open to a robot that comes `via` a lane."""
        left_on = node.left_on
        if left_on is None or (via is node.left_from and not via.short):
            return -math.inf
        ratio = 1.0 if via is None else min(1.0, node.left_pace / min(robot.speed, via.limit))
        key = (via, left_on, ratio)
        distance = self._closings.get(key)
        if distance is None:
            distance = self._closings[key] = self._closing(via, left_on, ratio)
        return node.left_at + distance / node.left_pace

    def _closing(self, via: Lane | None, left_on: Lane, ratio: float) -> float:
        if via is None:
            return self.contact
        approach = via.length if via.short else self.contact
        angle = turn(via.heading, left_on.heading)
        return closing_distance(angle, self.theta, self.contact, approach * ratio)

    def grant(self, robot: Body, node: Intersection, lane: Lane | None) -> None:
        """Give a robot what it claimed."""
        node.holder = robot
        robot.held = node
        if lane is not None:
            lane.entering = True
            robot.granted = lane

    def award(self, claim: Claim, lane: Lane | None) -> None:
        """Grant a waiting claim and wake its robot."""
        claim.node.claims.remove(claim)
        claim.robot.claim = None
        self.grant(claim.robot, claim.node, lane)
        claim.succeed()

    def serve(self, node: Intersection) -> None:
        """Grant the first of the waiting claims that can be granted now; if none can, see that it re-opens in time."""
        for claim in node.claims:
            if self.can_grant(claim.robot, node, claim.lane, claim.via):
                self.award(claim, claim.lane)
                return
        if node.holder is None and node.open_at > self.env._now + EPS:
            self.reopen_later(node)

    def reopen_later(self, node: Intersection) -> None:
        """Serve an intersection's claims again when the first of them is past the closing time."""
        now = self.env._now
        times = [self.opens_at(claim.robot, node, claim.via) for claim in node.claims]
        when = min((time for time in times if time > now + EPS), default=math.inf)
        if when < node.reopens:
            node.reopens = when
            Timeout(self.env, when - now).callbacks.append(lambda _: self._reopen(node))

    def _reopen(self, node: Intersection) -> None:
        node.reopens = math.inf
        if not node.claims:
            return
        self.serve(node)
        if node.holder is None:
            for claim in list(node.claims):
                self.gridlock.check(claim.robot)

    def _leave(self, robot: Body, node: Intersection) -> None:
        """A robot's centre has left an intersection for the lane that it is now on, at its last commitment."""
        if node.holder is robot:
            node.holder = None
        lane = robot.lane
        node.left_on = lane
        node.left_from = robot.came_by
        node.left_pace = robot.pace
        node.left_at = robot.since - robot.origin / robot.pace
        node.open_at = node.left_at + self.contact / robot.pace
        if node.claims:
            self.serve(node)

    def _clear_trailing(self, robot: Body) -> None:
        trailing, robot.trailing = robot.trailing, None
        if trailing is not None:
            self._leave(robot, trailing)

    def _give_back(self, robot: Body) -> None:
        """A recalled robot stays on the intersection and leaves the room beyond it to others."""
        if robot.granted is not None:
            robot.granted.entering = False
            robot.granted = None

    # Waiting

    def _claim(self, robot: Body, node: Intersection, lane: Lane | None, via: Lane | None) -> Steps:
        """Claim an intersection and room beyond it, and wait until both are granted."""
        if not node.claims and self.can_grant(robot, node, lane, via):
            self.grant(robot, node, lane)
            return True
        claim = robot.claim = Claim(self.env, robot, node, lane, via)
        node.claims.append(claim)
        other = node.holder
        self.serve(node)
        if robot.claim is not None:
            self.gridlock.check(robot)
        robot.waiting_since = since = self.env._now
        yield claim
        if self.env._now > since + EPS:
            self._count_wait(robot, other, node, self.env._now - since)
        return True

    def _wait_behind(self, robot: Body) -> Steps:
        """Wait until the robot ahead makes way."""
        event = robot.waiting_behind = Event(self.env)
        robot.waiting_since = since = self.env._now
        other = robot.ahead
        self.gridlock.check(robot)
        yield event
        if self.env._now > since + EPS:
            self._count_wait(robot, other, robot.lane, self.env._now - since)
        return True

    def _count_wait(self, robot: Body, other: Body | None, place: Lane | Intersection, duration: float) -> None:
        """One collision: a waiting episode of the active robot, at the place where it happened."""
        place.waits += 1
        place.blocked += duration
        robot.waited += duration
        if isinstance(place, Lane):
            robot.rear_ends += 1
        else:
            robot.crossings += 1
        if self.log.everything:
            self.log.collision(self.env._now, robot, other, place, duration)
