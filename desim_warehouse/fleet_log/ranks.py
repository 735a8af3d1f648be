"""Real figures ranked among simulated ones, all at once: a global envelope test, and its simultaneous band.

How far a figure lies out is counted in standard deviations of real and simulated days together, so that all of them
are treated alike. What decides is the largest such distance, of single days and of all days together, and its rank
among the same largest distance of simulated days that take the place of the real ones. So many figures do not make a
refutation more likely, nor do skewed ones: a right model is refuted at most at the stated level.

Source: the studentised global envelope test, Myllymäki, Mrkvička, Grabarnik, Seijo & Hahn (2017).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from desim_warehouse.values.arrays import Flags, Floats

LEVEL = 0.05


@dataclass(frozen=True)
class Ranked:
    """Figures of real days ranked among figures of simulated days.

    Attributes:
        real: a row for each day, a column for each figure; nan: the log does not say.
        simulated: for each day a table, a row for each simulated day.
        middle: mean of each figure on each day, of the real and the simulated days.
        spread: standard deviation of these.
        p_value: the share of days, the real one among them, that lie out as far as the real ones.
        bound: standard deviations beyond which a figure lies out, all of them taken together.
        off: how far each figure lies out: the most of single days and of all days together.
    """

    real: Floats
    simulated: Floats
    middle: Floats
    spread: Floats
    p_value: float
    bound: float
    off: Floats

    @property
    def out(self) -> Flags:
        """Whether each figure lies outside the simultaneous band."""
        return np.asarray(np.abs(self.off) > self.bound)

    def band(self, day: int) -> tuple[Floats, Floats]:
        """Bounds of the simultaneous band for the figures of a day; none is below zero."""
        reach = self.bound * self.spread[day]
        return np.maximum(self.middle[day] - reach, 0.0), self.middle[day] + reach

    def mean_band(self) -> tuple[Floats, Floats]:
        """Bounds of the simultaneous band for the means of all days; none is below zero."""
        middle, spread = self.middle.mean(axis=0), self.spread.mean(axis=0)
        reach = self.bound * spread / math.sqrt(len(self.real))
        return np.maximum(middle - reach, 0.0), middle + reach


def ranked(real: Floats, simulated: Floats, *, alike: bool = False) -> Ranked:
    """Rank the figures of real days among simulated figures, as many simulated days for each real one.

    Args:
        real: a row for each day, a column for each figure.
        simulated: for each day a table, a row for each simulated day.
        alike: the figures are of one kind, and those that hardly vary count as if they varied as the others do.
            Otherwise those that are zero on nearly all days would decide.
    """
    days, runs, _ = simulated.shape
    pooled = np.concatenate([real[:, None, :], simulated], axis=1)  # so that the real day counts like a simulated day
    middle, spread = pooled.mean(axis=1), pooled.std(axis=1, ddof=1)
    if alike:
        spread = np.maximum(spread, np.sqrt((spread**2).mean(axis=1, keepdims=True)))
    off, by = pooled - middle[:, None, :], spread[:, None, :]
    z = np.divide(off, by, out=np.zeros_like(pooled), where=by > 0)
    together = z.sum(axis=0, keepdims=True) / math.sqrt(days)
    far = np.concatenate([z, together]) if days > 1 else z
    largest = np.abs(far).max(axis=(0, 2), initial=0.0)
    p_value = float((largest >= largest[0]).mean())
    bound = float(np.sort(largest[1:])[math.ceil((1 - LEVEL) * (runs + 1)) - 1])
    ours = far[:, 0, :]
    off = np.take_along_axis(ours, np.abs(ours).argmax(axis=0)[None], axis=0)[0]
    return Ranked(real, simulated, middle, spread, p_value, bound, off)
