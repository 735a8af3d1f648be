"""Tours in wide aisles: a robot stands beside its lane while it loads or unloads, and then returns onto it."""

from __future__ import annotations

import math

from simpy.events import Timeout

from desim_warehouse.world.places.stops import Stop
from desim_warehouse.world.robots.tour import Tour
from desim_warehouse.world.traffic.events import Steps
from desim_warehouse.world.traffic.wide import WideLane


class TourAside(Tour):
    """A tour on which the robot leaves the lane at storage places beside wide aisles.

    `aside`: the lane beside which the robot stands now.
    """

    aside: WideLane | None = None

    def _handle(self, stop: Stop) -> Steps:
        """Load or unload beside the lane, where the aisle is wide, at all consecutive stops at one place."""
        robot, lane = self.robot, self.robot.body.lane
        place = None if robot.driving is None else robot.driving.stop
        if self.aside is None and isinstance(lane, WideLane) and lane.has_place(robot.body, place):
            is_aside = yield from lane.stand_aside(robot.body)
            robot.body.recall_from(math.inf)  # too late, now that it is at its place
            self.aside = lane if is_aside else None
        yield from super()._handle(stop)
        lane = self.aside
        if lane is not None:
            yield from self._break_down(lane)
            if not self._stays(stop):
                yield from lane.come_back(robot.body)
                self.aside = None

    def _stays(self, stop: Stop) -> bool:
        """Whether the robot's next stop is at its present place, so that it need not drive on."""
        following = self.stops[0] if self.stops else None
        if following is None or not following.joins:
            return False
        return (following.edge, following.offset) == (stop.edge, stop.offset)

    def _break_down(self, lane: WideLane) -> Steps:
        """Repair the robot beside the lane, where it blocks no other, if a breakdown is due."""
        robot, breakdowns = self.robot, self.robot.breakdowns
        if breakdowns is None:
            return
        body = robot.body
        while body.halts_at <= self.env.now and breakdowns.is_due(robot.operated()):
            repair, _ = breakdowns.begin()
            robot.enter("broken")
            body.break_down()
            lane.break_down(body)
            yield Timeout(self.env, repair)
            body.be_repaired()
            robot.enter(robot.doing)
            body.break_down_at(self.env.now + breakdowns.least_until_due(robot.operated()))
