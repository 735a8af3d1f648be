"""Breakdowns of a robot, drawn from streams of its own.

A robot breaks down by its time in operation: driving and handling, neither waiting nor in a bay. A breakdown is due
when that has reached the sum of the times drawn so far, and takes effect at the robot's next decision. So one that is
found late does not put off those after it, and of its time in operation and repair it works MTBF / (MTBF + MTTR). Were
waits counted, robots that wait for a repair would break down as they wait, and work might never end.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.values.distributions import draws
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from desim_warehouse.values.disturbances import BreakdownSpec
    from desim_warehouse.values.streams import Streams


class Breakdowns:
    """After which time in operation a robot breaks down next, and for how long.

    `count` is the number of breakdowns so far.
    """

    def __init__(self, spec: BreakdownSpec, robot: int, streams: Streams) -> None:
        self.count = 0
        self._every = draws(spec.every, streams, "breakdown", robot)
        self._repair = draws(spec.repair, streams, "repair", robot)
        self._due_after = self._every()

    def least_until_due(self, operated: float) -> float:
        """The least time until the next is due, after so much in operation: longer if the robot waits meanwhile."""
        return max(self._due_after - operated, 0.0)

    def is_due(self, operated: float) -> bool:
        """Whether the next is due after so much time in operation."""
        return operated >= self._due_after - EPS

    def begin(self) -> float:
        """Break down, as is due, and return how long the repair takes."""
        self.count += 1
        self._due_after += self._every()
        return self._repair()
