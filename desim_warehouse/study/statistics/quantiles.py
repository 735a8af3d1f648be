"""A quantile over replications, such as the T that 19 of 20 days stay below, with its interval."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.study.statistics.checks import check_confidence, check_same, check_share, finite

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray


@dataclass(frozen=True)
class QuantileEstimate:
    """A quantile over replications, in the indicator's unit.

    An end of the interval is None where there are too few replications for it, or none is needed: `deterministic`.
    """

    share: float
    n: int
    value: float
    low: float | None
    high: float | None
    confidence: float
    deterministic: bool = False

    def __str__(self) -> str:
        if self.deterministic:
            return f"{self.value:.6g} (deterministic: the same in every replication, n={self.n})"
        low, high = ("unknown" if end is None else f"{end:.6g}" for end in (self.low, self.high))
        return f"{self.value:.6g}, from {low} to {high} ({100 * self.confidence:g} %, n={self.n})"


def quantile(
    values: Sequence[float] | NDArray[np.float64],
    share: float,
    confidence: float = 0.95,
    *,
    deterministic: bool = False,
) -> QuantileEstimate:
    """A quantile of an indicator from one value per replication, with an interval between two of the values.

    Args:
        values: one number per replication, any unit, shape (n,).
        share: which quantile, between 0 and 1.
        confidence: of the two-sided interval; it holds at least as often, whatever the values follow.
        deterministic: the runs used no random numbers, so one replication is enough.

    Raises:
        StudyError: no values, one that is not finite, a share or confidence that is none, or a model said to be
            deterministic whose values differ.

    Source: `scipy.stats.quantile_test` (Conover 1999, Practical Nonparametric Statistics, section 3.2): how many
    values lie below the quantile is binomial. Quantile: type 7 of Hyndman & Fan (1996).
    Assumes: values independent and identically distributed, n chosen in advance.
    """
    array = finite(values)
    check_confidence(confidence)
    check_share(share)
    if deterministic:
        check_same(array)
    value = float(np.quantile(array, share))
    if deterministic:
        return QuantileEstimate(share, array.size, value, None, None, confidence, deterministic=True)
    from scipy.stats import quantile_test

    found: Any = quantile_test(array, q=0.0, p=share).confidence_interval(confidence)
    low, high = (None if math.isnan(end) else float(end) for end in (found.low, found.high))
    return QuantileEstimate(share, array.size, value, low, high, confidence)


def replications_for_quantile(share: float, confidence: float = 0.95) -> int:
    """The fewest replications with which `quantile` gives both ends of an interval.

    With n values all lie below the quantile with probability share^n, and all above it with (1 - share)^n.
    """
    tail = (1.0 - confidence) / 2
    return math.ceil(math.log(tail) / math.log(max(share, 1.0 - share)))
