"""A robot's battery: its level at any time, from the last time the rate changed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.model.schema import Consumption, SpreadEnergy
from desim_warehouse.world.streams import stream

if TYPE_CHECKING:
    from desim_warehouse.model import Model
    from desim_warehouse.model.schema import Battery as Spec

RATE_OF = {
    "idle": "standing",
    "queueing": "standing",
    "waiting": "standing",
    "empty": "empty",
    "returning": "empty",
    "loaded": "loaded",
    "loading": "handling",
    "unloading": "handling",
}
"""Which consumption of the model file holds in which state; a charging robot draws nothing."""


class Battery:
    """Energy drawn at a steady rate since the last change; `used` is what was drawn so far."""

    __slots__ = ("_level", "_rate", "_since", "capacity", "charging", "rates", "spec", "used")

    def __init__(self, spec: Spec | None) -> None:
        self.spec = spec
        self.capacity = math.inf if spec is None else spec.capacity
        self.rates = dict.fromkeys(RATE_OF, 0.0)
        if spec is not None:
            states = spec.consumption
            for state, name in RATE_OF.items():
                self.rates[state] = getattr(states, name) if isinstance(states, Consumption) else states
        self._level = self.capacity
        self._rate = 0.0
        self._since = 0.0
        self.used = 0.0
        self.charging = False

    @property
    def varies(self) -> bool:
        """Whether waiting draws another rate than driving."""
        return (
            self.rates["waiting"] not in (self.rates["empty"], self.rates["loaded"])
            or len(set(self.rates.values())) > 1
        )

    def start(self, level: float) -> None:
        """Hold so much at the start of the run."""
        self._level = level

    def level(self, now: float) -> float:
        """Energy left at `now`."""
        if self.charging:
            return self._level + self.charge_gain(self._level, now - self._since)
        return self._level - self._rate * (now - self._since)

    def is_full(self, now: float) -> bool:
        """Whether nothing was drawn from a full battery."""
        return self.level(now) >= self.capacity

    def draw(self, now: float, rate: float) -> None:
        """From now on energy is drawn at `rate` per time unit."""
        if rate == self._rate:
            return
        drawn = self._rate * (now - self._since)
        self.used += drawn
        self._level -= drawn
        self._rate = rate
        self._since = now

    def drawn(self, now: float) -> float:
        """Energy drawn since the start of the run."""
        return self.used + self._rate * (now - self._since)

    def plug(self, now: float) -> None:
        """Begin to charge; nothing is drawn meanwhile."""
        self.draw(now, 0.0)
        self._since = now
        self.charging = True

    def unplug(self, now: float, level: float | None = None) -> None:
        """End charging, at the level reached or at the one told."""
        self._level = min(self.level(now) if level is None else level, self.capacity)
        self._since = now
        self.charging = False

    def lasts_until(self, now: float, level: float) -> float:
        """The time at which the level is reached at the present rate; `now` if it has been."""
        left = self.level(now) - level
        if left <= 0:
            return now
        return now + left / self._rate if self._rate else math.inf

    def charge_time(self, start: float, end: float) -> float:
        """Time to charge from one level to another."""
        return 0.0 if self.spec is None else self.spec.charge_time(start, end)

    def charge_gain(self, start: float, time: float) -> float:
        """Energy taken up in a time at the charger: the inverse of `charge_time`."""
        if self.spec is None:
            return 0.0
        rate, taper = self.spec.charge_rate, self.spec.taper
        if taper is None:
            return min(rate * time, self.capacity - start)
        knee = taper.start * self.capacity
        steady = min(max(knee - start, 0.0) / rate, time)
        low = max(start, knee)
        slope = (1 - taper.end_rate) / (self.capacity - knee)
        here = 1 - slope * (low - knee)
        gain = here / slope * (1 - math.exp(-slope * rate * (time - steady)))
        return min(rate * steady + gain, self.capacity - start)


def start_levels(model: Model, seed: int) -> list[float]:
    """What the battery of each robot holds at the start of a run of `seed`; inf without battery.

    Drawn from a stream for each robot: another fleet size or policy leaves those of the others as they are.
    """
    if model.battery is None:
        return [math.inf] * model.fleet.size
    capacity, given = model.battery.capacity, model.fleet.start_energy
    if isinstance(given, SpreadEnergy):
        return [
            capacity * float(stream(seed, "start-energy", robot).uniform(*given.uniform))
            for robot in range(model.fleet.size)
        ]
    return [capacity * given] * model.fleet.size
