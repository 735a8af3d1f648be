"""Collision waiting as contention: how robots drive along lanes and over intersections.

A robot commits to a target on its lane that keeps it D behind the target of the robot ahead, drives there in
one timeout and looks again. At the stop line, D before an intersection, it claims in one step the intersection
and room to stand beyond it; as both are then its own until it is through, the same timeout takes it over the
intersection and on to its next target: one event an edge where nobody is in the way. Nothing polls: a waiting
robot is woken by whoever made way.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.world.lanes import EPS, Arrival
from desim_warehouse.world.motion import Motion

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from simpy.events import Event

    from desim_warehouse.world.body import Body
    from desim_warehouse.world.lanes import Intersection, Lane
    from desim_warehouse.world.reservations import Steps

    Drive = Generator[Event, object, bool]


class Traffic(Motion):
    """The Highways in use."""

    def drive(  # noqa: C901, PLR0912 - one piece, for speed
        self, robot: Body, route: Sequence[Lane], stop: float | None = None
    ) -> Drive:
        """Drive the lanes of `route` to `stop` on the last of them (None: to its end) from wherever the robot is.

        A stop is at least D from the nodes (see `Lane.clear_stop`). Returns True there, False if the robot was
        recalled: it then stands on the node it came to next. This is the hot path of every run, in one piece.
        """
        env = self.env
        index, count = 0, len(route)
        if stop is not None:
            stop = route[-1].clear_stop(stop, self.contact)
        while True:
            if robot.lane is None or robot.held is not None:
                arrived, index = yield from self._from_node(robot, route, index, stop)
                if arrived is not None:
                    return arrived
            # Along the lane: as far as the robot ahead allows, to the own stop or to the stop line.
            lane = robot.lane
            goal, final = lane.stop_line, False
            if index == count and stop is not None:
                goal, final = stop, True
            while True:
                if robot.until > env._now:
                    yield Arrival(env, robot.until)
                robot.pos = robot.target
                if robot.pos >= goal - EPS:
                    break
                ahead = robot.ahead
                limit = goal if ahead is None else min(goal, ahead.target - self.contact)
                if limit > robot.pos + EPS:
                    self.commit(robot, limit)
                else:
                    robot.goal = goal
                    yield self.wait_behind(robot)
                    robot.until = env._now
                    goal = robot.goal  # nearer, if it may halt where it is
            # At the stop line: the intersection and room beyond it, or neither.
            if final:
                return True
            if index < count:
                onward = route[index]
                if not onward.short:
                    clear = env._now + (lane.length - robot.pos) / robot.pace + self.node_time
                    passes = robot.recall_at > clear
                    if passes and not self.is_free(robot, lane, onward):
                        if robot.detours and (other := robot.detour(route, index, stop)) is not None:
                            route, index, count = other, 0, len(other)
                            continue
                        yield from self.claim(robot, lane.end, onward, lane)
                        clear = env._now + (lane.length - robot.pos) / robot.pace + self.node_time
                        passes = robot.recall_at > clear and robot.granted is onward
                    if passes:
                        index += 1
                        self.cross(robot, onward, clear, stop if index == count else None)
                        continue
            yield from self._to_node(robot, route, index)

    def is_free(self, robot: Body, lane: Lane, onward: Lane) -> bool:
        """Whether nobody is in the way from the end of a lane onto the next: neither at the node nor beyond it."""
        node = lane.end
        if node.claims or node.holder is not None or onward.entering:
            return False
        if node.clear_at > self.env._now + EPS and not self.is_open(robot, node, lane):
            return False
        last = onward.last
        return last is None or last.target >= 2 * self.contact - EPS

    # Where a robot stands on an intersection: bays, stations in the lane, lanes too short to stand on, recalls.

    @staticmethod
    def rests_beyond(route: Sequence[Lane], index: int) -> Lane | None:
        """The lane on which a robot can next stand clear of the intersection before `route[index]`, if any."""
        for lane in route[index:]:
            if not lane.inside:
                return None if lane.short else lane
        return None

    def _to_node(self, robot: Body, route: Sequence[Lane], index: int) -> Steps:
        """From the stop line to stand on the intersection."""
        if robot.held is None:
            wanted = self.rests_beyond(route, index) if robot.recall_at > self.env._now else None
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

    def _from_node(
        self, robot: Body, route: Sequence[Lane], index: int, stop: float | None
    ) -> Generator[Event, object, tuple[bool | None, int]]:
        """From a bay or an intersection onto the next lane where it can stand.

        Returns whether the drive is over (True: there, False: recalled, None: no) and how far on the route it is.
        """
        if robot.held is None:
            yield from self.claim(robot, robot.at, self.rests_beyond(route, index), None)
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
            index += 1
            halt = stop if index == len(route) else None
            if not onward.short:
                if robot.granted is not onward:
                    yield from self.claim(robot, robot.held, onward, robot.lane)
                self.cross(robot, onward, self.env._now, halt)
                return None, index
            yield from self._over_short(robot, onward, route, index, halt)
            if halt is not None:
                return True, index

    def _over_short(self, robot: Body, onward: Lane, route: Sequence[Lane], index: int, halt: float | None) -> Steps:
        """Over a lane too short to stand on: the robot holds the lane's end before it sets off, also while it halts."""
        node = robot.held
        if not onward.inside:
            yield from self.claim(robot, onward.end, self.rests_beyond(route, index), onward)
        self.enter(robot, onward)
        robot.held = onward.end
        yield from self._advance(robot, onward.length if halt is None else halt, None if onward.inside else node)

    @staticmethod
    def _give_back(robot: Body) -> None:
        """A recalled robot stays on the intersection and leaves the room beyond it to others."""
        if robot.granted is not None:
            robot.granted.entering = False
            robot.granted = None
