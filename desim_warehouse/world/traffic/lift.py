"""A lift: an intersection of nodes on several floors, crossed in a cabin that has to come first.

A robot claims the lift and room to stand beyond it on the other floor in one step, as at any intersection. Only then is
the cabin called, and the robot waits for its doors at the stop line. The duration is known beforehand, since waiting
for the cabin and riding depend on no other robot, and robots wait for each other as at other intersections. No event is
scheduled for the cabin. Its position is worked out when it is called, and so are repairs and the rides of people who
called it before.
"""

from __future__ import annotations

import math

from desim_warehouse.layout.layout import Lift
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.events import Arrival, Steps
from desim_warehouse.world.traffic.intersection import Claim, Intersection
from desim_warehouse.world.traffic.lane import Lane
from desim_warehouse.world.traffic.lift_users import LiftUsers
from desim_warehouse.world.traffic.rulebook import Rules
from desim_warehouse.world.traffic.rules import EPS


class LiftCrossing(Intersection):
    """The intersection of a lift: its cabin stands, or will stand, at the `floor` of a robot, free from `free_at` on.

    Floors are ranks in the nodes of its `shaft`. It is free once the robot that left is D beyond it and the doors have
    closed. A ring turns as one, so the cabin first comes to the ring's robot that waits for the lift. It stands open
    there, `ready_for` it, until it is called elsewhere. `users` are people and repairs.
    """

    __slots__ = ("floor", "free_at", "ready_for", "shaft", "users")

    is_lift = True

    def __init__(self, rules: Rules, shaft: Lift) -> None:
        super().__init__(rules, list(shaft.nodes))
        self.shaft = shaft
        self.floor = 0 if shaft.rests is None else shaft.nodes.index(shaft.rests)
        self.free_at = -math.inf
        self.ready_for: Body | None = None
        self.users: LiftUsers | None = None

    def is_open(self, robot: Body, via: Lane | None, now: float) -> bool:  # noqa: ARG002 - to all or to none
        """Whether a robot may have the cabin now."""
        return self.free_at <= now + EPS if self.holder is None else self.holder is robot

    def opens_at(self, robot: Body, via: Lane | None) -> float:  # noqa: ARG002 - to all at once
        """Return when the doors have closed behind the robot that left."""
        return self.free_at

    def take(self, robot: Body, lane: Lane | None, via: Lane | None, over: Lane | None = None) -> bool:  # noqa: ARG002
        """Return False: a robot stops before the doors, even one that claims other intersections on its way."""
        return False

    def claim(self, robot: Body, lane: Lane | None, via: Lane | None, over: Lane | None = None) -> Steps:
        """Wait for the lift and room beyond it, then before the doors for the cabin."""
        inside = self.holder is robot  # it has come without room beyond, in a ring that passes twice
        yield from super().claim(robot, lane, via, over)
        if inside:
            return
        assert via is not None  # nothing stands beside a lift
        now: float = self.rules.env._now
        opens = self._call(robot, via.edge[1], now)
        robot.uses_lift(via, now, opens)
        if opens > now:
            yield Arrival(self.rules.env, opens)

    def is_ready(self, claim: Claim, now: float) -> bool:
        """Whether the cabin stands open before a robot in a ring; if not, it is called, and free for none till then.

        The ring is examined again on its arrival.
        """
        assert claim.via is not None
        if self._stands_open(claim.robot, claim.via.edge[1], now):
            return True
        if self.free_at <= now + EPS:
            self.free_at = self._call(claim.robot, claim.via.edge[1], now)
            self.ready_for = claim.robot
        if self.free_at <= now + EPS:
            return True
        self.reopen_later(now)
        return False

    def _stands_open(self, robot: Body, node: str, now: float) -> bool:
        """Whether the cabin stands open for a robot, or a robot of a ring gets out at the node where it gets in."""
        if self.free_at > now + EPS:
            return self.ready_for is None and self.shaft.nodes[self.floor] == node
        return self.ready_for is robot

    def _call(self, robot: Body, node: str, now: float) -> float:
        """Call the cabin to a robot at a node; returns when the doors are open."""
        if self._stands_open(robot, node, now):
            opens = now
        else:
            if self.users is not None:
                self._let_others_use_it(self.users, now)
            begin = max(now, self.free_at)
            opens = begin + self._takes_to(node, begin) + self.shaft.doors
        self.floor, self.ready_for = self.shaft.nodes.index(node), None
        return opens

    def _let_others_use_it(self, users: LiftUsers, now: float) -> None:
        """Let people who called the cabin before `now` ride first, and repair it if it has failed."""
        shaft, log = self.shaft, self.rules.log
        while (due := users.due) <= now:
            begin = max(due, self.free_at)
            if due == users.fails_at:
                if shaft.rests is not None:  # its place of rest meanwhile
                    self.floor = shaft.nodes.index(shaft.rests)
                self.free_at = users.repaired(begin)
                log.lift_fails(begin, shaft.nodes[self.floor], self.free_at)
            else:
                ride = users.ride()
                way = shaft.nodes[ride.begin], shaft.nodes[ride.end]
                until = begin + self._takes_to(way[0], begin) + shaft.doors + ride.getting_in
                self.free_at = until + shaft.carrying(*way) + ride.getting_out + shaft.doors
                self.floor = ride.end
                log.person_rides(begin, way, begin - due, self.free_at)
            self.ready_for = None

    def _takes_to(self, node: str, now: float) -> float:
        """Return the travel time of the cabin to a node from where it stands, open or closed, or drives to rest."""
        shaft, floor, closing = self.shaft, float(self.floor), 0.0
        if self.ready_for is not None:
            closing = shaft.doors
        elif shaft.rests is not None and now > self.free_at:
            left = shaft.nodes.index(shaft.rests) - floor
            floor += math.copysign(min((now - self.free_at) / shaft.ride, abs(left)), left)
        return closing + abs(shaft.nodes.index(node) - floor) * shaft.ride

    def passed(self, robot: Body, onward: Lane, time: float) -> None:
        """Note that a robot's centre leaves the cabin at a time; the doors close when it is D beyond."""
        super().passed(robot, onward, time)
        self.floor = self.shaft.nodes.index(onward.edge[0])
        self.free_at = time + self.rules.headway / robot.pace + self.shaft.doors


class Ride(Lane):
    """The way in the cabin between two nodes of a lift, without length: doors and cabin take the time."""

    __slots__ = ()

    def enter_standing(self, robot: Body, since: float) -> None:
        """Put a robot into the cabin, standing."""
        robot.onto_short_lane(self, self.last, since)
        self.last = robot
        self.passages += 1

    def set_off(self, robot: Body, target: float, now: float) -> None:  # noqa: ARG002 - there is one
        """Close the doors behind a robot once it stands, and open them on its floor."""
        assert isinstance(self.start, LiftCrossing)
        begin = robot.brake_to_stand(now)
        robot.ride(begin, begin + self.start.shaft.carrying(*self.edge))
        robot.uses_lift(self, begin, robot.until)
        if self.rules.log.everything:
            self.rules.log.drive(robot, begin)
