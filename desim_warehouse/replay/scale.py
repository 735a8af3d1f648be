"""Units of length and time of the replay page, and the window of the run that it shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.zones import robot_radii
from desim_warehouse.replay.columns import LARGEST
from desim_warehouse.values.arrays import Ints

FINENESS = 100
"""Number of grains in the radius of the smallest robot."""


@dataclass(frozen=True)
class MapScale:
    """Units of length (`grain`) and time (`tick`) of the page, in units of the model, and the window of the run."""

    grain: float
    tick: float
    start: float
    end: float

    def times(self, values: Any) -> Ints:
        """Return times of the run in ticks since the start of the window, rounded."""
        return np.rint((np.asarray(values, dtype=float) - self.start) / self.tick).astype(np.int64)

    def lengths(self, values: Any) -> Ints:
        """Return lengths in grains, rounded."""
        return np.rint(np.asarray(values, dtype=float) / self.grain).astype(np.int64)


def scale_of(history: History, start: float, end: float) -> MapScale:
    """Return the scale for a window of a run.

    A grain is a hundredth of the smallest robot's radius. A tick is the fastest robot's time for a grain, or longer if
    the run would not fit into 32 bits.
    """
    grain = min(robot_radii(history.model)) / FINENESS
    longest = max(end - start, history.log.end)
    return MapScale(grain, max(grain / history.model.fleet.fastest, 4 * longest / LARGEST), start, end)
