"""Closing lanes: robots under way turn off where a lane holds tasks back, or detour if waiting takes longer.

Routes already account for closures, so only a robot delayed by traffic meets a closed lane that it expected to be open.
It turns off at its next node.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from desim_warehouse.states import STATES, Phase
from desim_warehouse.values.calendars import Hours

if TYPE_CHECKING:
    from desim_warehouse.world.places.cut_off import CutOff
    from desim_warehouse.world.robots.robot import Robot
    from desim_warehouse.world.traffic.events import Clock


class Closings:
    """The closures that may make a robot with a task turn off; `take_back` takes its task from it.

    It goes home from the next node. If it waits for room beyond that node, it gives up the claim to that room. It goes
    on instead, and waits before the closure, where its way home is closed, too, or where routes are declared and the
    change is unsafe for other robots.
    """

    def __init__(self, env: Clock, robot: Robot, cut_off: CutOff, take_back: Callable[[Robot], None]) -> None:
        self.env = env
        self.robot = robot
        self.cut_off = cut_off
        self.take_back = take_back
        self._looks_at = math.inf

    @property
    def is_cut_off(self) -> bool:
        """Whether the robot's way is closed, on a task for which no robot has turned off before."""
        job, now = self.robot.job, self.env.now
        if job is None or job.number in self.cut_off.turned_back:
            return False
        return self.cut_off.opens(self.robot.node, self.robot.tour.stops, now) > now

    def turn_back(self) -> None:
        """Give the robot's task back, and turn off at the next node."""
        job = self.robot.job
        assert job is not None
        self.cut_off.turned_back.add(job.number)
        self.take_back(self.robot)

    def watch(self) -> None:
        """Check the robot's way again whenever something opens or closes."""
        time = self.cut_off.changes(self.env.now)
        if time < self._looks_at:
            self._looks_at = time
            self.env.tick(time, self._change)

    def _change(self) -> None:
        self._looks_at = math.inf
        if self.robot.job is not None and not self.env.only_ticks:
            self.look()
            self.watch()

    def look(self) -> None:
        """Let the robot turn off at its next node if the way to its good is closed."""
        robot, body, now = self.robot, self.robot.body, self.env.now
        loads = STATES[robot.doing].phase is Phase.TO_GOOD
        if not loads or not body.is_on_lanes or body.is_at_lift or not self.is_cut_off or robot.is_at_good_edge:
            return
        declared, bay = robot.itinerary.is_declared, robot.home if robot.bay is None else robot.bay.node
        if not self.cut_off.has_way(robot.node, bay, now) or (declared and not self._declares_way_to(bay)):
            return
        self.turn_back()
        body.turn_off()
        claim = body.claim
        if claim is not None and self._may_give_up_room:
            claim.give_up_room()
            claim.node.freed(now)

    @property
    def _may_give_up_room(self) -> bool:
        """Whether the robot waits before an intersection, not on one, and found nothing closed on arrival."""
        body = self.robot.body
        return body.claim is None or (body.held is None and body.claim.met is None)

    def _declares_way_to(self, bay: str) -> bool:
        """Declare the way from the next node to the robot's bay, if it can still stop and the change is safe."""
        robot, body = self.robot, self.robot.body
        if body.lane is None or body.granted is not None or not self._may_give_up_room:
            return False
        if body.held not in {None, body.lane.end}:  # let in beyond the next node at this instant
            return False
        return robot.itinerary.go(robot.node, bay)


class WaysRound:
    """Robots under way, which look for a way round whenever a closure begins or ends."""

    def __init__(self, env: Clock, closures: Sequence[Hours]) -> None:
        self.env = env
        self.closures = closures
        self._under_way: dict[int, Robot] = {}
        self._looks_at = math.inf

    def watch(self, robot: Robot) -> None:
        """Register a robot that sets out."""
        self._under_way[robot.number] = robot
        self._watch()

    def _watch(self) -> None:
        if math.isinf(self._looks_at):
            self._looks_at = min((hours.changes(self.env.now) for hours in self.closures), default=math.inf)
            if math.isfinite(self._looks_at):
                self.env.tick(self._looks_at, self._look)

    def _look(self) -> None:
        self._looks_at = math.inf
        self._under_way = {number: robot for number, robot in self._under_way.items() if robot.is_under_way}
        if not self._under_way or self.env.only_ticks:
            return
        for _, robot in sorted(self._under_way.items()):
            robot.look_for_way_round()
        self._watch()
