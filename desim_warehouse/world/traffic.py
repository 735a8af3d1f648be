"""Collision waiting as contention: how robots drive along lanes and over intersections.

A robot commits to a target on its lane that keeps it D behind the target of the robot ahead, drives there in
one timeout and looks again. At the stop line, D before an intersection, it claims in one step the intersection
and room to stand beyond it; as both are then its own until it is through, the same timeout takes it over the
intersection and on to its next target: one event an edge where nobody is in the way, and the robot's process
sleeps meanwhile. Nothing polls: a waiting robot is set going by whoever made way.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

from simpy.events import Event

from desim_warehouse.world.lanes import EPS, Arrival
from desim_warehouse.world.motion import Motion
from desim_warehouse.world.trip import Trip

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    from desim_warehouse.world.body import Body
    from desim_warehouse.world.lanes import Intersection, Lane
    from desim_warehouse.world.reservations import Steps

    Drive = Generator[Event, object, bool]


class Traffic(Motion):
    """The Highways in use; the options are those of Motion."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.rolls: list[Callable[[Any], None]] = [self.roll]

    def drive(self, robot: Body, route: Sequence[Lane], stop: float | None = None) -> Drive:
        """Drive the lanes of `route` to `stop` on the last of them (None: to its end) from wherever the robot is.

        A stop is at least D from the nodes (see `Lane.clear_stop`). Returns True there, False if the robot was
        recalled: it then stands on the node it came to next.
        """
        if stop is not None:
            stop = route[-1].clear_stop(stop, self.contact)
        trip = Trip(self.env, robot, route, stop, self.rolls)
        if robot.lane is not None:
            robot.goal = robot.lane.stop_line
        while True:
            if robot.lane is None or robot.held is not None:
                arrived = yield from self._from_node(trip)
                if arrived is not None:
                    return arrived
            yield self._under_way(trip)
            onward = trip.onward
            if onward is None and stop is not None:
                return True
            if onward is None or onward.short or robot.recall_at <= self._clear_of_node(robot):
                yield from self._to_node(trip)
            elif not robot.detours or not self._takes_detour(trip):
                yield from self._pass_when_free(trip, onward)

    def _under_way(self, trip: Trip) -> Event:
        """Due when the robot is there, or at an intersection where it cannot just go on."""
        trip.held_up = event = Event(self.env)
        event._ok, event._value = True, None
        if trip.robot.until > self.env._now:
            trip.due(trip.robot.until)
        else:
            self.roll(trip)
        return event

    def roll(self, trip: Trip) -> None:
        """The robot is where it was sure to get to, and drives on if it can: the hot path of every run.

        Along its lane as far as the robot ahead allows, up to its own stop or the stop line; from there over the
        intersection, if nobody is in the way.
        """
        robot = trip.robot
        pos = robot.pos = robot.target
        if pos < robot.goal - EPS:
            ahead = robot.ahead
            limit = robot.goal if ahead is None else min(robot.goal, ahead.target - self.contact)
            if limit > pos + EPS:
                self.commit(robot, limit)
                trip.due(robot.until)
            else:
                self.wait_behind(robot, trip)
            return
        index, count = trip.index, len(trip.route)
        if index < count:
            lane, onward = robot.lane, trip.route[index]
            clear = self.env._now + (lane.length - pos) / robot.pace + self.node_time
            if not onward.short and robot.recall_at > clear and self.is_free(robot, lane, onward):
                trip.index = index = index + 1
                self.cross(robot, onward, clear, trip.stop if index == count else None)
                trip.due(robot.until)
                return
        trip.wake()

    def _clear_of_node(self, robot: Body) -> float:
        """When a robot that sets out from the stop line now leaves the node."""
        lane: Lane = robot.lane
        return self.env._now + (lane.length - robot.pos) / robot.pace + self.node_time

    def _takes_detour(self, trip: Trip) -> bool:
        """Whether a robot held up at an intersection goes another way from there."""
        other = trip.robot.detour(trip.route, trip.index, trip.stop)
        if other is None:
            return False
        trip.route, trip.index = other, 0
        return True

    def _pass_when_free(self, trip: Trip, onward: Lane) -> Steps:
        """Wait at the stop line for the intersection and room beyond it, and set out; or not, if it is recalled."""
        robot = trip.robot
        yield from self.claim(robot, robot.lane.end, onward, robot.lane)
        clear = self._clear_of_node(robot)
        if robot.recall_at > clear and robot.granted is onward:
            trip.index += 1
            self.cross(robot, onward, clear, None if trip.onward else trip.stop)
        else:
            yield from self._to_node(trip)

    def is_free(self, robot: Body, lane: Lane, onward: Lane) -> bool:
        """Whether nobody is in the way from the end of a lane onto the next: neither at the node nor beyond it."""
        node = lane.end
        if node.claims or node.holder is not None:
            return False
        beyond = (self.env._now - node.left_at) * node.left_pace
        return (beyond >= self.contact or self.is_open(robot, node, lane)) and self.has_room(onward)

    # Where a robot stands on an intersection: bays, stations in the lane, lanes too short to stand on, recalls.

    @staticmethod
    def rests_beyond(trip: Trip) -> Lane | None:
        """The lane on which a robot can next stand clear of the intersection before it, if any."""
        for lane in itertools.islice(trip.route, trip.index, None):
            if not lane.inside:
                return None if lane.short else lane
        return None

    def _to_node(self, trip: Trip) -> Steps:
        """From the stop line to stand on the intersection."""
        robot = trip.robot
        if robot.held is None:
            wanted = self.rests_beyond(trip) if robot.recall_at > self.env._now else None
            yield from self.claim(robot, robot.lane.end, wanted, robot.lane)
        yield from self._advance(robot, robot.lane.length)

    def _advance(self, robot: Body, target: float, behind: Intersection | None = None) -> Steps:
        """Along the lane to `target`, all of it granted; the node `behind` is left, then the time at its end spent."""
        self.commit(robot, target)
        if behind is not None:
            self.leave(robot, behind)
        pause = self.node_time if target == robot.lane.length else 0.0
        yield Arrival(self.env, robot.until + pause)
        robot.pos = target

    def _from_node(self, trip: Trip) -> Generator[Event, object, bool | None]:
        """From a bay or an intersection onto the next lane where it can stand.

        Returns whether the drive is over: True: there, False: recalled, None: no.
        """
        robot = trip.robot
        if robot.held is None:
            yield from self.claim(robot, robot.at, self.rests_beyond(trip), None)
            robot.left_bay()
        elif robot.lane is not None and robot.pos < robot.lane.length:
            yield from self._advance(robot, robot.lane.length)
        while True:
            if robot.recall_at <= self.env._now:
                self._give_back(robot)
                return False
            onward = trip.onward
            if onward is None:
                return True
            trip.index += 1
            halt = None if trip.onward else trip.stop
            if not onward.short:
                if robot.granted is not onward:
                    yield from self.claim(robot, robot.held, onward, robot.lane)
                self.cross(robot, onward, self.env._now, halt)
                return None
            yield from self._over_short(trip, onward, halt)
            if halt is not None:
                return True

    def _over_short(self, trip: Trip, onward: Lane, halt: float | None) -> Steps:
        """Over a lane too short to stand on: the robot holds the lane's end before it sets off, also while it halts."""
        robot = trip.robot
        node = robot.held
        if not onward.inside:
            yield from self.claim(robot, onward.end, self.rests_beyond(trip), onward)
        self.enter(robot, onward)
        robot.held = onward.end
        yield from self._advance(robot, onward.length if halt is None else halt, None if onward.inside else node)

    @staticmethod
    def _give_back(robot: Body) -> None:
        """A recalled robot stays on the intersection and leaves the room beyond it to others."""
        if robot.granted is not None:
            robot.granted.entering = False
            robot.granted = None
