"""A robot's battery: its level at any time, from the last time something changed."""

from __future__ import annotations


class Battery:
    """Energy drawn (or charged) at a steady rate since the last change; `used` is what was drawn so far."""

    __slots__ = ("capacity", "_level", "_rate", "_since", "used")

    def __init__(self, capacity: float) -> None:
        self.capacity = capacity
        self._level = capacity
        self._rate = 0.0
        self._since = 0.0
        self.used = 0.0

    def level(self, now: float) -> float:
        """Energy left at `now`."""
        return self._level - self._rate * (now - self._since)

    def draw(self, now: float, rate: float) -> None:
        """From now on energy is drawn at `rate` per time unit."""
        drawn = self._rate * (now - self._since)
        self.used += drawn
        self._level -= drawn
        self._rate = rate
        self._since = now

    def fill(self, now: float, level: float) -> None:
        """Charged up to `level`; nothing is drawn until told otherwise."""
        self.draw(now, 0.0)
        self._level = level

    def time_to(self, now: float, level: float) -> float:
        """Time until the level is reached at the present rate; 0 if it has been."""
        left = self.level(now) - level
        return max(left / self._rate, 0.0) if self._rate else float("inf")
