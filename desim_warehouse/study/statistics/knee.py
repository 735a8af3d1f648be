"""Knee of a throughput curve, where further robots stop paying off, and the smallest fleet near its maximum.

For the throughput curve of a study, in words and in `plot.throughput`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.checks import finite
from desim_warehouse.values.arrays import Floats


@dataclass(frozen=True)
class Knee:
    """The shape of a curve that rises and levels off; sizes and outputs in their own units.

    `at` is the size at the knee; None if the curve has none, as a straight line, on which every robot adds equally.
    `maximum_at` is the smallest size with the largest output. `prominence`, 0..1, is how far the knee stands
    above the chord from the first size to the maximum at the last, both axes scaled to 0..1.
    """

    at: float | None
    output: float | None
    prominence: float
    maximum_at: float
    maximum: float


def knee(sizes: Sequence[float] | Floats, outputs: Sequence[float] | Floats, sensitivity: float = 1.0) -> Knee:
    """Find the knee of mean output (throughput per hour, say) over size (robots, say).

    Args:
        sizes: strictly rising, shape (n,).
        outputs: mean output at each, shape (n,).
        sensitivity: how far, in mean steps of size, the knee must stand above the chord; larger is stricter.

    Raises:
        StudyError: different lengths, fewer than 3 sizes, not rising, or a value that is not finite.

    Source: Satopaa, Albrecht, Irwin & Raghavan (2011), Finding a "kneedle" in a haystack, ICDCS Workshops,
    the highest point of normalised output over normalised size, if the curve then falls
    below a threshold. Here without their smoothing: the
    points are means. A fall beyond the maximum (congestion) does not move the knee.
    Assumes: noise is small compared with the bend. The knee depends on the range of sizes, and too few sizes show
    none.
    """
    x, y = _curve(sizes, outputs)
    top = int(np.argmax(y))
    maximum_at, maximum = float(x[top]), float(y[top])
    if not y[0] < maximum:
        return Knee(None, None, 0.0, maximum_at, maximum)
    above = (y - y[0]) / (maximum - y[0]) - (x - x[0]) / (x[-1] - x[0])
    index = int(np.argmax(above))
    prominence = float(above[index])  # at least 0: the curve starts on the chord
    if prominence <= sensitivity / (x.size - 1):  # the last point, at 0 or less, is not below the threshold
        return Knee(None, None, prominence, maximum_at, maximum)
    return Knee(float(x[index]), float(y[index]), prominence, maximum_at, maximum)


def smallest_within(sizes: Sequence[float] | Floats, outputs: Sequence[float] | Floats, share: float = 0.05) -> float:
    """Return the smallest size whose mean output is within `share` (0.05: 5 %) of the largest.

    Raises:
        StudyError: as `knee`, a share outside 0..1, or an output below zero.

    Assumes: means are taken as exact; for a size that meets a number with confidence use `cheapest_meeting_steps`.
    """
    x, y = _curve(sizes, outputs, least=1)
    if not 0.0 <= share < 1.0:
        raise StudyError(f"share {share!r}: expected at least 0 and less than 1")
    if y.min() < 0.0:
        raise StudyError(f"output {y.min():g}: expected none below 0, or a share of the maximum means nothing")
    return float(x[np.argmax(y >= (1.0 - share) * y.max())])


def _curve(sizes: Sequence[float] | Floats, outputs: Sequence[float] | Floats, least: int = 3) -> tuple[Floats, Floats]:
    """Check sizes and outputs, and return them as arrays."""
    x, y = finite(sizes, "sizes"), finite(outputs, "outputs")
    if x.size != y.size or x.size < least:
        raise StudyError(f"{x.size} sizes with {y.size} outputs: expected as many of each, at least {least}")
    if (np.diff(x) <= 0.0).any():
        raise StudyError("sizes: expected in strictly rising order")
    return x, y
