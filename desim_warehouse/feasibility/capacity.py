"""How much a number of robots gets done where they queue: mean value analysis of a closed network.

A robot goes round and round. For a part of each task it is served where others may be before it, for the rest of it
nobody is in its way (Reiser and Lavenberg, Journal of the ACM 27 (1980) 313-322). Several servers count as one that is
so much faster, and a time without queues (Seidmann, Schweitzer and Shalev-Oren, LSOR 1987). Times of service are taken
to vary as exponential ones do: where they vary less, queues are shorter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

BUSIEST = 0.99
"""Of the time that a place may be busy: beyond, queues grow so long that no number of robots is said to do."""


@dataclass(frozen=True)
class Place:
    """Where robots queue: the time for which a task is served there, and by how many servers it may be.

    `name` is what is said of it where it is the limit.
    """

    name: str
    time: float
    servers: int

    @property
    def most(self) -> float:
        """Tasks per time unit that it lets through, always busy."""
        return self.servers / self.time if self.time else math.inf


class Network:
    """Robots that always have work; `alone` is the time of a task with nobody in the way, service included."""

    def __init__(self, alone: float, places: Sequence[Place]) -> None:
        import numpy as np

        self.alone = alone
        self.places = [place for place in places if place.time]
        self.most = min((place.most for place in self.places), default=math.inf)
        self._each = np.array([place.time / place.servers for place in self.places])
        self._away = alone - float(self._each.sum())
        self._queues = np.zeros(len(self.places))
        self._done = [0.0]

    def throughput(self, robots: int) -> float:
        """Tasks per time unit of so many robots."""
        if not self.alone:
            return math.inf
        if not self.places:
            return robots / self.alone
        while len(self._done) <= robots:
            waits = self._each * (1 + self._queues)
            rate = len(self._done) / (self._away + float(waits.sum()))
            self._queues = rate * waits
            self._done.append(rate)
        return self._done[robots]

    @property
    def longest(self) -> str:
        """The place with the longest queue of the most robots that were asked for."""
        return self.places[int(self._queues.argmax())].name

    def robots_for(self, rate: float) -> float:
        """The robots that it takes for so many tasks per time unit, in fractions; inf where no number does."""
        if rate > BUSIEST * self.most:
            return math.inf
        if not self.places:
            return rate * self.alone
        robots = 1
        while self.throughput(robots) < rate:
            robots += 1
        below = self.throughput(robots - 1)
        return robots - 1 + (rate - below) / (self.throughput(robots) - below)
