"""Reservations: who may have an intersection and room beyond it, and who is next when one opens.

Claims are served first come, first served among those that can be granted now; but a claim that only waits
for the intersection to clear is not passed over, so that a stream of robots cannot starve a crossing one.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from simpy.events import Timeout

from desim_warehouse.world.lanes import EPS, Claim, Lane, closing_apart, closing_distance, network, turn

if TYPE_CHECKING:
    from collections.abc import Generator, Iterable

    from simpy import Environment
    from simpy.events import Event

    from desim_warehouse.layout import Layout
    from desim_warehouse.log import Log
    from desim_warehouse.world.body import Body
    from desim_warehouse.world.gridlock import Gridlock
    from desim_warehouse.world.lanes import Intersection
    from desim_warehouse.world.trip import Trip

    Steps = Generator[Event, object, None]


class Reservations:
    """The Highways as a set of lanes and intersections that robots reserve.

    `contact` is D, the distance that robots keep (the largest pair's for all, so that each can take any other's
    place); `theta` the collision angle in radians.
    `mixed`: robots or edges differ in speed, so that one robot can catch up with another on the way.
    """

    def __init__(
        self,
        env: Environment,
        layout: Layout,
        log: Log,
        *,
        contact: float,
        theta: float,
        mixed: bool = True,
    ) -> None:
        self.env = env
        self.log = log
        self.contact = contact
        self.theta = theta
        self.mixed = mixed
        self.lanes, self.nodes = network(layout, contact)
        self.layout = layout
        self.gridlock: Gridlock
        self._closings: dict[tuple[Lane | None, Lane, float], float] = {}

    def has_room(self, lane: Lane) -> bool:
        """Whether a robot can come to a stand D beyond the lane's start, with nobody else on the way in."""
        if lane.entering:
            return False
        last = lane.last
        return last is None or last.target >= 2 * self.contact - EPS

    def is_open(self, robot: Body, node: Intersection, via: Lane | None) -> bool:
        """Whether an intersection is clear for a robot that comes `via` a lane (None: a bay)."""
        holder = node.holder
        return holder is robot or (holder is None and self.opens_at(robot, node, via) <= self.env._now + EPS)

    def opens_at(self, robot: Body, node: Intersection, via: Lane | None) -> float:
        """When the robot that passed last is far enough beyond an intersection for one that comes `via` a lane."""
        left_on = node.left_on
        if left_on is None:
            return -math.inf
        ratio = 1.0
        if self.mixed and via is not None:
            ratio = min(1.0, node.left_pace / min(robot.speed, via.limit))
        key = (via, left_on, ratio)
        distance = self._closings.get(key)
        if distance is None:
            distance = self._closings[key] = self._closing(via, left_on, ratio)
        return node.left_at + distance / node.left_pace

    def _closing(self, via: Lane | None, left_on: Lane, ratio: float) -> float:
        if via is None:
            return self.contact
        approach = via.length if via.short else self.contact
        if via.edge[1] != left_on.edge[0]:
            shift = self.layout.point(left_on.edge[0]) - self.layout.point(via.edge[1])
            return closing_apart(shift, via.heading, left_on.heading, self.theta, self.contact, approach, ratio)
        angle = turn(via.heading, left_on.heading)
        return closing_distance(angle, self.theta, self.contact, approach * ratio)

    def claim(self, robot: Body, node: Intersection, lane: Lane | None, via: Lane | None) -> Steps:
        """Claim an intersection and room beyond it, and wait until both are granted."""
        if not node.claims and self.is_open(robot, node, via) and (lane is None or self.has_room(lane)):
            self._grant(robot, node, lane)
            return
        claim = robot.claim = Claim(self.env, robot, node, lane, via)
        node.claims.append(claim)
        if lane is not None:
            lane.wanted += 1
        other = node.holder or node.user
        self.serve(node)
        if robot.claim is not None:
            self.gridlock.check(robot)
        robot.waiting_since = since = self.env._now
        robot.stands(waiting=True)
        yield claim
        robot.stands(waiting=False)
        if self.env._now > since + EPS:
            self.count_wait(robot, other, node, self.env._now - since)

    def _grant(self, robot: Body, node: Intersection, lane: Lane | None) -> None:
        node.holder = robot
        robot.held = node
        robot.granted = lane
        if lane is not None:
            lane.entering = True

    def award(self, claim: Claim, lane: Lane | None) -> None:
        """Grant a waiting claim, with room on `lane`, and wake its robot."""
        claim.node.claims.remove(claim)
        claim.robot.claim = None
        if claim.lane is not None:
            claim.lane.wanted -= 1
        self._grant(claim.robot, claim.node, lane)
        claim.succeed()

    def serve(self, node: Intersection) -> None:
        """Grant the first of the waiting claims that can be granted now, or see that they are looked at in time."""
        for claim in node.claims:
            if claim.lane is None or self.has_room(claim.lane):
                if self.is_open(claim.robot, node, claim.via):
                    self.award(claim, claim.lane)
                    return
                if node.holder is None:
                    break
        if node.holder is None:
            self.reopen_later(node)

    def reopen_later(self, node: Intersection) -> None:
        """Look at an intersection's claims again when the first of them is past the closing time."""
        now = self.env._now
        when = math.inf
        for claim in node.claims:
            time = self.opens_at(claim.robot, node, claim.via)
            if now + EPS < time < when:
                when = time
        if when < node.reopens:
            node.reopens = when
            Timeout(self.env, when - now).callbacks.append(lambda _: self._reopen(node))

    def _reopen(self, node: Intersection) -> None:
        node.reopens = math.inf
        if node.claims:
            self.freed(node)

    def freed(self, node: Intersection) -> None:
        """An intersection with claims is free: serve them; those that now wait for room may have closed a ring."""
        self.serve(node)
        if node.holder is None and math.isinf(node.reopens):
            for claim in list(node.claims):
                self.gridlock.check(claim.robot)

    def wait_behind(self, robot: Body, trip: Trip) -> None:
        """Wait until the robot ahead makes way: the trip is due when the robot has then moved up."""
        robot.waiting_behind = trip
        robot.waiting_since = self.env._now
        robot.waits_for = robot.ahead
        robot.stands(waiting=True)
        self.gridlock.check(robot)

    def count_wait(
        self, robot: Body, other: Body | None, place: Lane | Intersection, duration: float, *, ahead: float = 0.0
    ) -> None:
        """One collision: a waiting episode that ends now (or `ahead` of now), at the place where it happened."""
        place.waits += 1
        place.blocked += duration
        robot.waited += duration
        now = self.env._now + ahead
        if isinstance(place, Lane):
            robot.rear_ends += 1
            if self.log.everything:
                self.log.collision(now, robot, other, None, place.edge, duration)
        else:
            robot.crossings += 1
            if self.log.everything:
                self.log.collision(now, robot, other, place.name, None, duration)

    def end_waits(self, robots: Iterable[Body]) -> None:
        """At the end of a run, count the episodes that are under way."""
        now = self.env._now
        for robot in robots:
            if robot.waiting_since < now - EPS:
                waited = now - robot.waiting_since
                if robot.claim is not None:
                    self.count_wait(robot, robot.claim.node.holder, robot.claim.node, waited)
                elif robot.waiting_behind is not None:
                    self.count_wait(robot, robot.waits_for, robot.lane, waited)
                robot.waiting_since = now
