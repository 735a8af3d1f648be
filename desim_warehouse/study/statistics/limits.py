"""Upper limits and defaults of studies; anything larger would run for days, or not fit into memory.

For the options of commands, study files and arguments in Python.
"""

from __future__ import annotations

import math
from typing import NamedTuple

MOST_LEVELS = 100_000
"""The largest number of values of one factor."""
MOST_POINTS = 1_000_000
"""The largest number of designs of one study."""
MOST_REPLICATIONS = 100_000
"""The largest number of runs of one design."""
MOST_RUNS = 1_000_000
"""The largest number of runs of one study."""
LEAST_DELTA = 1e-9
"""The smallest indifference zone when choosing the best design, in the indicator's unit."""
MOST_ZONE = 0.2
"""The largest indifference zone, of a share or relative to the target; a larger one makes nearly all designs alike."""
FIRST = 5
"""Replications at the first look at a share."""
FIRST_OF_MEANS = 10
"""Replications at the first look at an unbounded indicator, such as a time: fewer do not show its skewness."""
_UNSEEN = 0.05
_ROUND = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
RACED = 10, 1000
"""Replications at the first look, and the cap, of a race of designs in which all but the best drop out."""
RELIEVED = 5, 160
"""Replications at the first look, and the cap, of the suspects of a bottleneck."""
PLAN_RUNS, SEARCH_RUNS = 5000, 500
"""The most runs of a plan, and of a search of designs, by default."""
MOST_YEARS = 20
"""The largest number of years that a plan looks ahead."""


class DaysNeeded(NamedTuple):
    """The fewest replications for a verdict that a design meets a target (`least`), and the most (`cap`)."""

    least: int
    cap: int

    def up_to(self, cap: int) -> DaysNeeded:
        """Return these limits with another cap; `least` is lowered to a smaller cap."""
        return DaysNeeded(min(self.least, cap), cap)


COMMON_DAYS = DaysNeeded(33, 80)
"""Replications if no event is rarer than one day in ten: 33 days include such a day with 97 % probability."""
RARE_DAYS = DaysNeeded(59, 120)
"""Replications if an event is rarer than that: 59 days include a one-in-twenty day with 95 % probability."""
CAP = COMMON_DAYS.cap
"""The largest number of replications of a design, by default."""


def days_for(chance: float) -> int:
    """Return the days needed to see an event of a daily probability, 0 < chance < 1, with 95 % probability."""
    return math.ceil(math.log(_UNSEEN) / math.log1p(-chance))


def one_in(days: int) -> int:
    """Return the n, rounded, of the "one day in n" event that `days` (at least 5) include with 95 % probability."""
    rarest = 1 / (1 - _UNSEEN ** (1 / days))
    return max(n for n in _ROUND if n <= rarest)
