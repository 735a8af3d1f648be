"""Breakdowns of a robot, drawn from streams of its own.

A robot breaks down by its time in operation: driving and handling, neither waiting nor in a bay. A breakdown is due
when that has reached the sum of the times drawn so far, and takes effect at the robot's next decision. So one that is
found late does not put off those after it, and of its time in operation and repair it works MTBF / (MTBF + MTTR). Were
waits counted, robots that wait for a repair would break down as they wait, and work might never end.
"""

from __future__ import annotations

import math

from desim_warehouse.values.distributions import draws, mean_left
from desim_warehouse.values.disturbances import BreakdownSpec
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.traffic.rules import EPS


class Breakdowns:
    """The breakdowns of a robot: after which time in operation the next comes, its repair, and when lanes are clear.

    `count` is the number of breakdowns so far. `mean_left`: for how long a broken robot is expected to be in the way
    yet by one who sees it, but not since when.
    """

    def __init__(self, spec: BreakdownSpec, robot: int, streams: Streams) -> None:
        self.count = 0
        self._every = draws(spec.every, streams, "breakdown", robot)
        self._repair = draws(spec.repair, streams, "repair", robot)
        self._clear = None if spec.clear is None else draws(spec.clear, streams, "clear", robot)
        self._due_after = self._every()
        self.mean_left = min(mean_left(time) for time in (spec.repair, spec.clear) if time is not None)

    def least_until_due(self, operated: float) -> float:
        """Return the least time until the next breakdown, after so much in operation: longer if the robot waits."""
        return max(self._due_after - operated, 0.0)

    def is_due(self, operated: float) -> bool:
        """Whether the next breakdown is due after so much time in operation."""
        return operated >= self._due_after - EPS

    def begin(self) -> tuple[float, float]:
        """Begin the breakdown that is due; return the repair time, and the time until the robot is off the lanes."""
        self.count += 1
        self._due_after += self._every()
        return self._repair(), math.inf if self._clear is None else self._clear()
