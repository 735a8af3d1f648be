"""Robots that keep their braking distance: at any time they can stop before the place where they may have to.

A robot that drives at v and brakes at b comes to a stand within B = v²/2b. Robots that keep only D stop at once where
there is need, as in the paper: at the stop line, or D behind the robot ahead. Those that keep their braking distance
look B earlier. Behind another they stay D + B away while they drive (`Lane.free_at`). At B before the place to which
they are sure to get they go on, or begin to brake, and then they come to a stand there whatever happens meanwhile. So
an intersection is claimed D + B ahead of it.

A ring of waiting robots sets off, and brakes, as one: while it turns they are D apart.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.world.traffic.drive import Drive
from desim_warehouse.world.traffic.events import Arrival
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from simpy import Environment
    from simpy.events import Event

    from desim_warehouse.world.traffic.body import Body
    from desim_warehouse.world.traffic.lane import Lane


class LookAhead:
    """A look B ahead for one robot: it decides there whether the robot goes on or brakes.

    `brakes` is the time in which it loses a unit of speed. `when` is the time of the next decision, inf if none is to
    come, and `pending` the time of the event for it, then or before.
    """

    def __init__(self, env: Environment, robot: Body, brakes: float) -> None:
        self.env = env
        self.robot = robot
        self.brakes = brakes
        self.drive: Drive | None = None
        self.when = self.pending = math.inf

    def limit_on(self, lane: Lane) -> float:
        """Return the speed from which it can brake within a lane: the next intersection is claimed from there."""
        room = lane.length if lane.short else lane.stop_line
        return math.sqrt(2 * room / self.brakes)

    def distance(self, pace: float) -> float:
        """Return the braking distance."""
        return pace * pace * self.brakes / 2

    def expect(self) -> None:
        """Decide a braking distance before the place to which the robot is now sure to get."""
        robot = self.robot
        assert robot.stretch is not None
        self.when = robot.until - robot.stretch.braking_distance(robot.braking) / robot.pace
        if self.when < self.pending:
            self._look_again_at(self.when)

    def _look_again_at(self, time: float) -> None:
        self.pending = max(time, self.env.now)
        Arrival(self.env, self.pending).callbacks.append(self._look)

    def _look(self, _: Event) -> None:
        now = self.env.now
        if now < self.pending:  # another event comes up for this decision
            return
        self.pending = math.inf
        if self.when > now + EPS:
            if self.when < math.inf:
                self._look_again_at(self.when)
            return
        self.when = math.inf
        robot, drive = self.robot, self.drive
        if drive is None or robot.lane is None or robot.until < now or not robot.braking:
            return
        if robot.goal - robot.target > EPS or not drive.goes_on_early(now):
            robot.begin_to_brake()
