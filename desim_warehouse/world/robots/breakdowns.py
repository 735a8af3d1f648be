"""Breakdowns of a robot, drawn from streams of its own.

Breakdowns depend on time in operation: driving and handling, but neither waiting nor time in a bay. A breakdown is due
when that time reaches the sum of the times drawn so far, and takes effect at the robot's next decision. So a late
effect does not postpone later breakdowns, and of its time in operation and repair the robot works MTBF / (MTBF + MTTR).
If waits were counted, robots waiting for a repair would break down meanwhile, and work might never end.
"""

from __future__ import annotations

import math

from desim_warehouse.values.distributions import draws, mean_left
from desim_warehouse.values.disturbances import BreakdownSpec
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.traffic.rules import EPS


class Breakdowns:
    """The breakdowns of a robot: the time in operation before each, its repair time, and when lanes are clear.

    `count` is the number of breakdowns so far. `mean_left` is how much longer a broken robot is expected to block its
    lane, to an observer who does not know since when.
    """

    def __init__(self, spec: BreakdownSpec, robot: int, streams: Streams) -> None:
        self.count = 0
        self._every = draws(spec.every, streams, "breakdown", robot)
        self._repair = draws(spec.repair, streams, "repair", robot)
        self._clear = None if spec.clear is None else draws(spec.clear, streams, "clear", robot)
        self._due_after = self._every()
        self.mean_left = min(mean_left(time) for time in (spec.repair, spec.clear) if time is not None)

    def least_until_due(self, operated: float) -> float:
        """Return the least time until the next breakdown, given the time in operation so far; waiting prolongs it."""
        return max(self._due_after - operated, 0.0)

    def is_due(self, operated: float) -> bool:
        """Whether the next breakdown is due at a given time in operation."""
        return operated >= self._due_after - EPS

    def begin(self) -> tuple[float, float]:
        """Begin the due breakdown; return the repair time, and the time until the robot is off the lanes."""
        self.count += 1
        self._due_after += self._every()
        return self._repair(), math.inf if self._clear is None else self._clear()
