"""The most that a study accepts. Anything larger would run for days, or not fit into memory.

For the options of commands, study files and arguments in Python.
"""

from __future__ import annotations

import math
from typing import NamedTuple

MOST_LEVELS = 100_000
"""Values of one factor."""
MOST_POINTS = 1_000_000
"""Designs of one study."""
MOST_REPLICATIONS = 100_000
"""Runs of one design."""
MOST_RUNS = 1_000_000
"""Runs of one study."""
LEAST_DELTA = 1e-9
"""Indifference zone of a choice of the best design, in the indicator's unit."""
MOST_ZONE = 0.2
"""Indifference zone of a share, and else as a part of what is aimed at: a larger one calls nearly all designs alike."""
FIRST = 5
"""Replications at the first look at a share."""
FIRST_OF_MEANS = 10
"""Replications at the first look at an unbounded indicator, such as a time: fewer do not show its skewness."""
_UNSEEN = 0.05
_ROUND = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
RACED = 10, 1000
"""The first look and the cap of a race of designs, in which all but the best drop out."""
RELIEVED = 5, 160
"""The first look and the cap of the suspects of a bottleneck."""
PLAN_RUNS, SEARCH_RUNS = 5000, 500
"""The most runs of a plan, and of a search of designs, by default."""
MOST_YEARS = 20
"""Years that a plan looks ahead."""


class DaysNeeded(NamedTuple):
    """The fewest replications with which a design is said to meet a target, and the most for a design."""

    least: int
    cap: int

    def up_to(self, cap: int) -> DaysNeeded:
        """Replace the cap; the fewest replications are lowered to a cap below them."""
        return DaysNeeded(min(self.least, cap), cap)


COMMON_DAYS = DaysNeeded(33, 80)
"""Where nothing is rarer than one day in ten: with 97 % probability 33 days have such a day among them."""
RARE_DAYS = DaysNeeded(59, 120)
"""Where something is: with 95 % probability 59 days have among them a day that comes once in twenty."""
CAP = COMMON_DAYS.cap
"""The most replications of a design, by default."""


def days_for(chance: float) -> int:
    """Return the days among which an event of this daily probability is seen with 95 %; 0 < chance < 1."""
    return math.ceil(math.log(_UNSEEN) / math.log1p(-chance))


def one_in(days: int) -> int:
    """Return the n of a "one day in n" event, rounded, that so many days (at least 5) include with 95 % probability."""
    rarest = 1 / (1 - _UNSEEN ** (1 / days))
    return max(n for n in _ROUND if n <= rarest)
