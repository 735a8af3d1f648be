"""Lift users other than robots: people who ride at random, and repairs after outages.

Their calls do not depend on robots, and are drawn only as far as robots call the lift. So they keep no run going, and
are alike in all designs. A person who calls while a robot has the lift waits; a lift that fails then does so after the
ride.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from desim_warehouse.layout.layout import Lift
from desim_warehouse.values.calendars import Hours
from desim_warehouse.values.distributions import draws
from desim_warehouse.values.streams import Streams

WAY = 2
"""Random numbers for one ride: its first floor, and which of the other floors it goes to."""


class PersonRide(NamedTuple):
    """A person who calls the cabin to the floor `begin`, gets in, rides to the floor `end` and gets out."""

    begin: int
    end: int
    getting_in: float
    getting_out: float


class LiftUsers:
    """The people and repairs of one lift, in order of their calls: `due` is the time of the next, inf for none."""

    def __init__(self, lift: Lift, streams: Streams, hours: Hours, hour: float) -> None:
        """Take the random streams of a run, the `hours` in which people ride, and an `hour` in its time units."""
        self._floors = len(lift.nodes)
        self._calls: Iterator[float] = iter(())
        self.calls_at = self.fails_at = math.inf
        if (people := lift.people) is not None:
            purpose = f"lift:{lift.name}:people"
            self._ways = streams.stream(purpose)
            self._transfer = draws(people.transfer, streams, f"{purpose}:transfer", 0)
            gaps = streams.stream(f"{purpose}:arrivals")
            mean = hour / people.per_hour
            self._calls = _times(iter(lambda: float(gaps.exponential(mean)), None), hours)
            self.calls_at = next(self._calls, math.inf)
        if (outages := lift.outages) is not None:
            self._every = draws(outages.every, streams, f"lift-failure:{lift.name}", 0)
            self._repair = draws(outages.repair, streams, f"lift-repair:{lift.name}", 0)
            self.fails_at = self._every()

    @property
    def due(self) -> float:
        """When the next person calls the cabin, or the lift fails next."""
        return min(self.calls_at, self.fails_at)

    def ride(self) -> PersonRide:
        """Return the next person's ride."""
        self.calls_at = next(self._calls, math.inf)
        begin, other = (int(part * (self._floors - rank)) for rank, part in enumerate(self._ways.random(WAY)))
        return PersonRide(begin, other + (other >= begin), self._transfer(), self._transfer())

    def repaired(self, begin: float) -> float:
        """Return when a lift that fails at `begin` works again."""
        until = begin + self._repair()
        self.fails_at = until + self._every()
        return until


def _times(gaps: Iterator[float], hours: Hours) -> Iterator[float]:
    """Iterate over the times of calls: a Poisson process within opening hours."""
    open_time = 0.0
    for gap in gaps:
        open_time += gap
        time = hours.when_open(open_time)
        if math.isinf(time):
            return
        yield time
