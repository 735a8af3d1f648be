"""Thresholds: the value of an input at which a mean crosses a bound.

For `desim plan --uncertain`.

A parabola interpolates three probes of an input on the same days. The interval holds the points at which the mean does
not differ significantly from the bound (Fieller), or differs by no more than the smallest step between two values.
Without that step, two of seven plants had intervals of zero width: in short runs where work always waits, all six days
may have the same count.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from desim_warehouse.study.statistics.intervals import t_quantile
from desim_warehouse.values.arrays import Floats

_STEPS = 2000
"""Points between two probes at which a crossing is looked for."""


@dataclass(frozen=True)
class Crossing:
    """The point at which a mean crosses a bound, with an interval; -inf and inf for ends beyond the probes."""

    at: float
    low: float
    high: float


def crossing(probes: Sequence[float], values: Floats, bound: float, level: float = 0.975) -> Crossing | None:
    """Find the input at which a mean crosses a bound, from three probes; None if all means lie on one side.

    Args:
        probes: values of the input, ascending, shape (3,).
        values: values of the indicator, each day at every probe, shape (days, 3).
        bound: bound to be crossed.
        level: confidence of each end of the interval.

    The values of each day are interpolated by a parabola. The interval holds the points at which the mean of the days
    does not differ significantly from the bound (Fieller 1954, Some problems in interval estimation, by a test at each
    point). Only means that differ by more than the smallest step between two values count as different, as days may
    agree on a count by chance, or always.
    """
    first, middle, last = probes
    points = np.unique(np.concatenate([np.linspace(first, middle, _STEPS), np.linspace(middle, last, _STEPS)]))
    days = len(values)
    weights = np.array(
        [
            (points - middle) * (points - last) / ((first - middle) * (first - last)),
            (points - first) * (points - last) / ((middle - first) * (middle - last)),
            (points - first) * (points - middle) / ((last - first) * (last - middle)),
        ]
    )
    beyond = values @ weights - bound
    mean, error = beyond.mean(axis=0), beyond.std(axis=0, ddof=1) / math.sqrt(days)
    turns = np.flatnonzero(np.sign(mean[:-1]) != np.sign(mean[1:]))
    if not len(turns) or np.sign(mean[0]) == np.sign(mean[-1]):
        return None
    where = int(turns[len(turns) // 2])
    step = np.diff(np.unique(values)).min()
    inside = np.abs(mean) <= np.maximum(t_quantile(days - 1, level) * error, step)
    before, after = where, where + 1
    while before > 0 and inside[before]:
        before -= 1
    while after < len(points) - 1 and inside[after]:
        after += 1
    low = -math.inf if before == 0 and inside[0] else float(points[before])
    high = math.inf if after == len(points) - 1 and inside[-1] else float(points[after])
    return Crossing(float(points[where]), low, high)
