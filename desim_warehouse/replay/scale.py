"""Steps of length and time in which the replay page counts, and the window of the run that it shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.zones import robot_radii
from desim_warehouse.replay.columns import LARGEST
from desim_warehouse.values.arrays import Ints

FINENESS = 100
"""Grains in the radius of the smallest robot."""


@dataclass(frozen=True)
class MapScale:
    """Steps of length and time, and the window of the run in its own time."""

    grain: float
    tick: float
    start: float
    end: float

    def times(self, values: Any) -> Ints:
        """Times in ticks since the start of the window."""
        return np.rint((np.asarray(values, dtype=float) - self.start) / self.tick).astype(np.int64)

    def lengths(self, values: Any) -> Ints:
        """Lengths in grains."""
        return np.rint(np.asarray(values, dtype=float) / self.grain).astype(np.int64)


def scale_of(history: History, start: float, end: float) -> MapScale:
    """Return steps for a run: a hundredth of the smallest robot's radius, and the fastest robot's time for that."""
    grain = min(robot_radii(history.model)) / FINENESS
    longest = max(end - start, history.log.end)
    return MapScale(grain, max(grain / history.model.fleet.fastest, 4 * longest / LARGEST), start, end)
