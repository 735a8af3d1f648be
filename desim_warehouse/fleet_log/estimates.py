"""Estimate of one key of a model from a log: a value with its interval and evidence, or why there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from desim_warehouse.study.statistics import intervals
from desim_warehouse.values.arrays import Flags, Floats

CONFIDENCE = 0.95
FEWEST = 5
"""Observations below which nothing but a rate is estimated."""
_WIDE = 3.5
"""Standard deviations beyond which an observation is taken for a disturbance."""
_FLOOR = 1e-9


@dataclass(frozen=True)
class KeyEstimate:
    """Estimate of a key of a model from a log.

    Attributes:
        key: of the model, dotted.
        value: what to write there; None: not identified, so that the model keeps what it has.
        mean, low, high: the figure that was estimated, and its interval of 95 %; nan where there is none.
        n: how many observations that rests on, and of `what`.
        why: what it was not identified for, or anything else to be known.
        ranged: the key that the interval is of, where that is a part of the value.
    """

    key: str
    value: Any
    mean: float
    low: float
    high: float
    n: int
    what: str
    why: str = ""
    ranged: str = ""

    @property
    def identified(self) -> bool:
        """Whether the key was identified by the log."""
        return self.value is not None

    def words(self) -> str:
        """Return interval and evidence: `1.31 (1.29 to 1.33), from 812 stretches`."""
        if math.isnan(self.low):
            return self.why
        return f"{self.mean:.4g} ({self.low:.4g} to {self.high:.4g}), from {self.evidence}"

    @property
    def evidence(self) -> str:
        """Evidence of the estimate, such as `812 stretches`; the reason where the key was not identified."""
        if math.isnan(self.low):
            return self.why
        return f"{self.n:,} {self.what}{f'; {self.why}' if self.why else ''}"


def unknown(key: str, why: str, n: int = 0, what: str = "") -> KeyEstimate:
    """Return the estimate of a key that was not identified, with the reason."""
    return KeyEstimate(key, None, math.nan, math.nan, math.nan, n, what, why)


def short(value: float) -> float:
    """Return a number with the digits that a log can carry."""
    return float(f"{value:.4g}")


def t_quantile(degrees: float) -> float:
    """Return Student's quantile for the two-sided interval."""
    return intervals.t_quantile(max(degrees, 1), (1 + CONFIDENCE) / 2)


def poisson_interval(n: int) -> tuple[float, float]:
    """Return the exact confidence interval of a Poisson mean after n events."""
    from scipy.stats import chi2

    tail = (1 - CONFIDENCE) / 2
    return float(chi2.ppf(tail, 2 * n)) / 2 if n else 0.0, float(chi2.ppf(1 - tail, 2 * n + 2)) / 2


def densest(values: Floats) -> float:
    """Return the mean of the values in the shortest interval that holds a fifth of them (an estimate of the mode)."""
    ordered = np.sort(values)
    many = max(len(ordered) // 5, 2)
    spans = ordered[many - 1 :] - ordered[: len(ordered) - many + 1]
    first = int(spans.argmin())
    return float(ordered[first : first + many].mean())


def undisturbed(off: Floats, side: int, least: float = _FLOOR) -> tuple[Flags, float]:
    """Separate residuals of measuring alone from disturbances; return a flag for each, and the standard deviation.

    Disturbances lie on one side only: robots are held up, never pushed. `side` is -1 where they are above 0.
    `least`: the deviation that all measuring has.
    """
    quiet = np.abs(off[off * side >= 0])
    sigma = max(float(np.quantile(quiet, 0.683)) if len(quiet) else 0.0, least)
    return np.abs(off) <= _WIDE * sigma, sigma
