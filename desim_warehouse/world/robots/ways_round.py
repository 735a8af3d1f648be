"""Robots under way go another way when a lane ahead of them closes, if waiting for it would take longer.

Routes are chosen with closures in view. So only a robot that traffic has made late meets a lane that it thought open.
It turns off at the node that it comes to next.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.values.calendars import Hours
    from desim_warehouse.world.robots.robot import Robot
    from desim_warehouse.world.traffic.events import Clock


class WaysRound:
    """Looks at the robots under way whenever one of some closures begins or ends, as long as there are any."""

    def __init__(self, env: Clock, closures: Sequence[Hours]) -> None:
        self.env = env
        self.closures = closures
        self._under_way: dict[int, Robot] = {}
        self._looks_at = math.inf

    def watch(self, robot: Robot) -> None:
        """It sets out."""
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
