"""A mean with its honest uncertainty: Student's t interval over independent replications."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.checks import check_confidence, finite, is_constant

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

QUANTILES = (0.05, 0.25, 0.75, 0.95)


@dataclass(frozen=True)
class Estimate:
    """What the replications of one design say about one indicator; numbers in the indicator's unit.

    `half_width` is None where no interval can be given: one replication, or a `deterministic` model, whose
    replications cannot differ. `sd` (divisor n-1) is None for one replication of a random model.
    """

    n: int
    mean: float
    half_width: float | None
    sd: float | None
    median: float
    quantiles: dict[float, float]
    deterministic: bool
    confidence: float

    @property
    def interval(self) -> tuple[float, float] | None:
        """Lower and upper end of the confidence interval, or None."""
        if self.half_width is None:
            return None
        return self.mean - self.half_width, self.mean + self.half_width

    @property
    def relative_half_width(self) -> float | None:
        """Half-width as a share of |mean|; None without an interval, infinite for a mean of zero."""
        if self.half_width is None:
            return None
        return self.half_width / abs(self.mean) if self.mean else math.inf

    def __str__(self) -> str:
        if self.deterministic:
            return f"{self.mean:.6g} (deterministic: the same in every replication, n={self.n})"
        if self.half_width is None:
            return f"{self.mean:.6g} (one replication: no interval)"
        return f"{self.mean:.6g} ± {self.half_width:.3g} ({100 * self.confidence:g} %, n={self.n})"


def estimate(
    values: Sequence[float] | NDArray[np.float64],
    confidence: float = 0.95,
    *,
    deterministic: bool = False,
    scale: float | None = None,
) -> Estimate:
    """Mean of an indicator with its t interval, median and quantiles, from one value per replication.

    Args:
        values: one number per replication, any unit, shape (n,).
        confidence: of the two-sided interval, between 0 and 1.
        deterministic: the caller knows that the model has no randomness, so one replication says it all.
            Without it, two or more values that are all equal are called deterministic, a single one is not.
        scale: size of the numbers that `values` were computed from (differences): equal up to the rounding of
            such numbers counts as equal. Default: the largest of `values`.

    Raises:
        StudyError: no values, one that is not finite, a bad confidence, or a model said to be deterministic
            whose values differ.

    Source: Law (2015), Simulation Modeling and Analysis, 5th ed., section 4.5 (t interval) and 9.4.1 (means
    of replications). Quantiles: linear interpolation, type 7 of Hyndman & Fan (1996).
    Assumes: replications independent and identically distributed, their means near normal (the interval is
    exact for normal values; for skew ones the cover grows towards `confidence` with n); n chosen in advance.
    """
    check_confidence(confidence)
    array = finite(values)
    n = array.size
    constant = is_constant(array, scale)
    if deterministic and not constant:
        raise StudyError(f"a deterministic model gave values from {array.min():g} to {array.max():g}")
    fixed = deterministic or (constant and n > 1)
    sd = 0.0 if fixed else float(array.std(ddof=1)) if n > 1 else None
    return Estimate(
        n=n,
        mean=float(array.mean()),
        half_width=None if fixed or sd is None else t_quantile(n - 1, 0.5 + confidence / 2) * sd / math.sqrt(n),
        sd=sd,
        median=float(np.median(array)),
        quantiles=dict(zip(QUANTILES, np.quantile(array, QUANTILES).tolist(), strict=True)),
        deterministic=fixed,
        confidence=confidence,
    )


def t_quantile(df: int, probability: float) -> float:
    """The `probability` quantile of Student's t with `df` degrees of freedom (scipy.special: loads fast)."""
    from scipy.special import stdtrit

    return float(stdtrit(df, probability))


def t_p_value(df: int, t: float) -> float:
    """Two-sided p-value of Student's t with `df` degrees of freedom."""
    from scipy.special import stdtr

    return 2.0 * float(stdtr(df, -abs(t)))
