"""Attempts to give out tasks that hours hold back: how often in a row, and whether one may still succeed.

Such tasks are tried again whenever hours of robots begin or end, or a station or a way opens. This could go on for ever
where hours do not meet. All calendars have been in every position that they take when each that repeats has done so
together with the others, and those that do not repeat are over. So attempts are in vain from then on, but not before:
a station may open once, years after a thousand shifts of robots.
"""

from __future__ import annotations

from collections.abc import Iterable

from desim_warehouse.values.calendars import Hours, repeat_together
from desim_warehouse.world.traffic.events import Clock

LEAST = 1000
"""The number of attempts without success before any count as in vain. Batteries at rest fall, and are charged, too."""
MOST = 1000
"""The number of times that the longest period passes, where periods have no smaller common multiple."""


class Attempts:
    """The attempts since a task was last given out or released, or a robot became free."""

    def __init__(self, clock: Clock, calendars: Iterable[Hours]) -> None:
        self.clock = clock
        calendars = list(calendars)
        self._repeats_from = max((hours.repeats_from for hours in calendars), default=0.0)
        self._period = repeat_together(calendars, MOST)
        self._count = 0
        self._since = 0.0

    def begin(self) -> None:
        """Count from now on, as something other than hours has changed."""
        self._count, self._since = 0, self.clock.now

    def fail(self) -> None:
        """Count an attempt, which counts as failed unless a task is given out."""
        self._count += 1

    @property
    def are_in_vain(self) -> bool:
        """Whether no task will ever be given out, as hours have taken every course that they can."""
        return self._count > LEAST and self.clock.now > max(self._since, self._repeats_from) + self._period
