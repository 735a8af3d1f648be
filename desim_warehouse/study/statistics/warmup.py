"""End of the warm-up: by MSER-5, and for Welch's plot.

For `desim warm-up`, and for `plot.warm_up` and `plot.welch`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from desim_warehouse.errors import StudyError, shown
from desim_warehouse.study.statistics.checks import finite
from desim_warehouse.values.arguments import is_whole
from desim_warehouse.values.arrays import Floats, Ints

Series: TypeAlias = "Sequence[float] | Sequence[Sequence[float]] | Floats"
"""Observations in order of time: shape (n,), or (replications, n)."""
TAIL = 5  # batches that a truncation must leave: the spread of fewer is meaningless


@dataclass(frozen=True, eq=False)
class WarmUp:
    """The end of the warm-up: how many initial observations to discard, and the curve behind it.

    `truncate`: number of observations to discard. `statistic[d]`: MSER after discarding d batches of `batch`
    observations (in the indicator's unit squared; the last values are for the plot only). `means`: the batch means.
    `valid` is False if the truncation point lies in the second half: the run is too short, and `truncate` must not be
    used.
    """

    truncate: int
    valid: bool
    batch: int
    means: Floats
    statistic: Floats
    note: str

    @property
    def positions(self) -> Ints:
        """Observations discarded at each point of `statistic`: the horizontal axis of the plot."""
        return np.arange(self.statistic.size) * self.batch


def mser(values: Series, batch: int = 5) -> WarmUp:
    """Find the truncation point of an indicator observed over time, by MSER-5.

    Args:
        values: equally spaced observations in order of time (the n-th task time, the throughput of the n-th hour),
            shape (n,), or (replications, n), which are averaged first. Observations after the last full batch are
            not used.
        batch: observations per batch, 5 in MSER-5.

    Raises:
        StudyError: fewer than 6 batches, or a value that is not finite.

    Source: White (1997), An effective truncation heuristic for bias reduction in simulation output,
    Simulation 69(6), 323-334: the d that makes Σ_{j>d} (Y_j - mean_{j>d})² / (m-d)² least. Batches of 5:
    White, Cobb & Spratt (2000), WSC. Rejection of a cut in the second half, at least 5 batches left, average
    over replications: Hoad, Robinson & Davies (2008), Automating warm-up length estimation, WSC.
    Assumes: the output settles to a steady state; one that ends (a fixed list of tasks) or cycles (shifts)
    has none.
    """
    if not is_whole(batch, 1):
        raise StudyError(f"batch {shown(batch):.60}: expected a whole number of observations above 0")
    series = averaged(values)
    m = series.size // batch
    if m <= TAIL:
        raise StudyError(f"warm-up from {series.size} observations: expected at least {TAIL + 1} batches of {batch}")
    means = series[: m * batch].reshape(m, batch).mean(axis=1)
    statistic = _statistic(means)
    cut = int(np.argmin(statistic[: m - TAIL + 1]))
    valid = 2 * cut <= m
    note = f"discard the first {cut * batch} of {series.size} observations"
    if not valid:
        note = f"cut at {cut * batch} of {series.size} observations, in the second half: run longer"
    return WarmUp(cut * batch, valid, batch, means, statistic, note)


def welch(values: Series, window: int) -> Floats:
    """Return the moving average of Welch's plot: where it levels off, the warm-up is over.

    Args:
        values: see `mser`; shape (n,), or (replications, n), which are averaged first.
        window: w; each point is the mean of itself and w observations on either side, or of fewer near the start, as
            many as there are on both sides.

    Returns:
        Shape (n - w,): the i-th (from 0) belongs to the i-th observation.

    Raises:
        StudyError: a window below 1 or above n / 4, or a value that is not finite.

    Source: Welch (1983), The statistical analysis of simulation results, in Lavenberg (ed.), Computer Performance
    Modeling Handbook; as in Law (2015), section 9.5.1: at least 5 replications, w at most n / 4, and the smallest w
    with which the curve is reasonably smooth.
    """
    series = averaged(values)
    if not is_whole(window, 1, series.size // 4):
        raise StudyError(
            f"window {shown(window):.60}: expected at least 1 and at most a quarter of the {series.size} observations"
        )
    sums = np.concatenate(([0.0], np.cumsum(series)))
    middle = np.arange(series.size - window)
    beside = np.minimum(middle, window)
    return np.asarray((sums[middle + beside + 1] - sums[middle - beside]) / (2 * beside + 1))


def averaged(values: Series) -> Floats:
    """Return observations over time, shape (n,), averaged over replications if there are several."""
    array = np.asarray(values, dtype=float)
    return finite(array.mean(axis=0) if array.ndim == 2 and array.size else array)  # noqa: PLR2004


def _statistic(means: Floats) -> Floats:
    """Return MSER after discarding 0, 1, ... m-1 batches, shape (m,), from sums over the tail in one pass."""
    centred = means - np.median(means)  # keeps a constant series at exactly 0, and large levels precise
    left = np.arange(means.size, 0, -1)
    total = np.cumsum(centred[::-1])[::-1]
    squares = np.cumsum(centred[::-1] ** 2)[::-1]
    return np.asarray(np.maximum(squares - total**2 / left, 0.0) / left.astype(float) ** 2)
