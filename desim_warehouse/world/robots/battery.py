"""A robot's battery: its level at any time, from the last time the rate changed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.model.facts import energy

if TYPE_CHECKING:
    from desim_warehouse.model.sections.battery import BatterySpec


class Battery:
    """Energy drawn at a steady rate since the last change. `used` is what was drawn so far."""

    __slots__ = ("_level", "_since", "capacity", "charging", "rate", "rates", "spec", "started", "used", "varies")

    def __init__(self, spec: BatterySpec | None, rates: dict[str, float]) -> None:
        self.spec = spec
        self.capacity = math.inf if spec is None else spec.capacity
        self.rates = rates
        self._level = self.capacity
        self.rate = 0.0
        self._since = 0.0
        self.used = 0.0
        self.charging = False
        self.started: float | None = None
        """What it held at the start of the run, until it is charged."""
        self.varies = len(set(rates.values())) > 1
        """Whether waiting may draw another rate than what the robot does."""

    def start(self, level: float) -> None:
        """Hold so much at the start of the run."""
        self._level = self.started = level

    def level(self, now: float) -> float:
        """Energy left at `now`: on demand, as between two changes it is a straight line or the charge curve."""
        if self.charging:
            return self._level + self.charge_gain(self._level, now - self._since)
        return self._level - self.rate * (now - self._since)

    def is_full(self, now: float) -> bool:
        """Whether nothing was drawn from a full battery."""
        return self.level(now) >= self.capacity

    def draw(self, now: float, rate: float) -> None:
        """From now on energy is drawn at `rate` per time unit."""
        if rate == self.rate:
            return
        drawn = self.rate * (now - self._since)
        self.used += drawn
        self._level -= drawn
        self.rate = rate
        self._since = now

    def drawn(self, now: float) -> float:
        """Energy drawn since the start of the run."""
        return self.used + self.rate * (now - self._since)

    def plug(self, now: float) -> None:
        """Begin to charge, with nothing drawn meanwhile."""
        self.draw(now, 0.0)
        self._since = now
        self.charging = True
        self.started = None

    def unplug(self, now: float, level: float | None = None) -> None:
        """End charging, at the level reached or at `level`."""
        self._level = min(self.level(now) if level is None else level, self.capacity)
        self._since = now
        self.charging = False

    def lasts_until(self, now: float, level: float) -> float:
        """The time at which the level is reached at the present rate, `now` if it has been."""
        left = self.level(now) - level
        if left <= 0:
            return now
        return now + left / self.rate if self.rate else math.inf

    def charge_time(self, start: float, end: float) -> float:
        """Time to charge from one level to another."""
        return 0.0 if self.spec is None else energy.charge_time(self.spec, start, end)

    def charge_gain(self, start: float, time: float) -> float:
        """Energy taken up in a time at the charger: the inverse of `charge_time`."""
        return 0.0 if self.spec is None else energy.charge_gain(self.spec, start, time)
