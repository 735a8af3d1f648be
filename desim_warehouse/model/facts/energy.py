"""The battery model: what is drawn in each state, and how the level rises at a charger.

Kept together, for the simulation and for whatever works out a battery's level from the log.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.model.sections.battery import Consumption
from desim_warehouse.states import TIMES

if TYPE_CHECKING:
    from desim_warehouse.model.sections.battery import BatterySpec


def consumption(spec: BatterySpec | None) -> Consumption:
    """Energy per time unit; without a battery nothing."""
    drawn = 0.0 if spec is None else spec.consumption
    if isinstance(drawn, Consumption):
        return drawn
    return Consumption(standing=drawn, empty=drawn, loaded=drawn, handling=drawn)


def rates(spec: BatterySpec | None) -> dict[str, float]:
    """Energy per time unit in every state but charging. At rest in a slot with a charger nothing is drawn instead."""
    drawn = consumption(spec)
    return {name: getattr(drawn, state.draws) for name, state in TIMES.items() if state.draws is not None}


def charge_time(spec: BatterySpec, start: float, end: float) -> float:
    """Time to charge from one level to another: at the full rate, tapering off towards full if so modelled.

    Tapered, the rate falls linearly with the level l above `taper.start`: dl/dt = r(l), so the time is an
    integral of 1 / r(l), a logarithm. No battery is ever charged beyond its capacity.
    """
    if end <= start:
        return 0.0
    if end > spec.capacity:
        return math.inf
    rate, taper = spec.charge_rate, spec.taper
    if taper is None:
        return (end - start) / rate
    knee = taper.start * spec.capacity
    time = max(min(end, knee) - start, 0.0) / rate
    low, high = max(start, knee), max(end, knee)
    slope = (1 - taper.end_rate) / (spec.capacity - knee)
    return time + math.log((1 - slope * (low - knee)) / (1 - slope * (high - knee))) / (rate * slope)


def charge_gain(spec: BatterySpec, start: float, time: float) -> float:
    """Energy charged in a time at the charger, from the level `start` on: the inverse of `charge_time`."""
    rate, taper = spec.charge_rate, spec.taper
    if taper is None:
        return min(rate * time, spec.capacity - start)
    knee = taper.start * spec.capacity
    steady = min(max(knee - start, 0.0) / rate, time)
    low = max(start, knee)
    slope = (1 - taper.end_rate) / (spec.capacity - knee)
    here = 1 - slope * (low - knee)
    gain = here / slope * (1 - math.exp(-slope * rate * (time - steady)))
    return min(rate * steady + gain, spec.capacity - start)
