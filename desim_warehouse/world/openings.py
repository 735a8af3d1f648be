"""Tasks held back at the source while a station is closed: nobody sets out only to wait before its hours.

A robot that went to a station that opens in eight hours would stand there for eight hours, with the load, in a slot
that others need. So a task is given to a robot only if, driving freely, it finds open every station on its way; else it
is looked at again when a robot that sets out then comes just as the station opens. Where it cannot be in time for one
station because another closes meanwhile, it goes: the load has to wait somewhere.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

from desim_warehouse.world.rules import EPS
from desim_warehouse.world.stops import between, time_at

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from simpy import Environment

    from desim_warehouse.layout.travel import FreeTravel
    from desim_warehouse.policies import Handling, RobotView, Task
    from desim_warehouse.world.stations import Stations


class Openings:
    """Who would come before the hours of a station; `due`: when the first task that was held back may be given out."""

    def __init__(
        self,
        env: Environment,
        stations: Stations,
        handling: Handling,
        travel: Callable[[float], FreeTravel],
        loaded_speed: Callable[[RobotView], float],
    ) -> None:
        self.env = env
        self.stations = stations
        self.handling = handling
        self.travel = travel
        self.loaded_speed = loaded_speed
        self.due = math.inf
        self._found: dict[tuple[int, str, float, int, str], float] = {}
        self._found_at = -1.0

    def in_time(self, robot: RobotView, task: Task, node: str) -> bool:
        """Whether a robot that sets out for a task to `node` now would wait at no station that is closed."""
        if not self.stations.close:
            return True
        if self._found_at != self.env.now:
            self._found_at = self.env.now
            self._found.clear()
        key = robot.number, robot.node, robot.free_in, task.number, node
        wait = self._found.get(key)
        if wait is None:
            wait = self._found[key] = self._wait(robot, task, node)
        if wait > EPS:
            self.due = min(self.due, self.env.now + wait)
        return wait <= EPS

    def for_somebody(self, robots: Sequence[RobotView], task: Task) -> bool:
        """Whether any of these robots may set out for a task now."""
        return any(self.in_time(robot, task, self.stations.choose(robot, task)) for robot in robots)

    def _wait(self, robot: RobotView, task: Task, node: str) -> float:
        """By how much later it may set out to be at the first station that is closed no later than that opens."""
        travel, with_load = self.travel(robot.speed), self.travel(self.loaded_speed(robot))
        stops = self.stations.stops(robot, task, node)
        first = stops[0]
        time = self.env.now + robot.free_in + travel.half_turn
        time += travel.to_edge(robot.node, first.edge) + travel.along(first.edge, first.offset)[0]
        spare = math.inf
        for stop, then in pairwise([*stops, None]):
            assert stop is not None
            hours = None if stop.station is None else stop.station.hours
            if hours is not None:
                opens, closes = hours.following(time)
                if opens > time:
                    return opens - time if opens - time < spare else 0.0
                spare = min(spare, closes - time)
            if then is not None:
                time += time_at(self.handling, stop) + between(with_load, stop, then)
        return 0.0
