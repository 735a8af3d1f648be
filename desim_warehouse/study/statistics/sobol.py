"""Sobol indices of a screening study: each factor's share of the variance, alone and with interactions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.checks import check_confidence, finite, is_constant

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray


@dataclass(frozen=True)
class Between:
    """A numeric factor, uniform from `low` to `high`; `integer`: whole numbers, both ends included."""

    low: float
    high: float
    integer: bool = False

    def __post_init__(self) -> None:
        whole = not self.integer or (float(self.low).is_integer() and float(self.high).is_integer())
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high and whole):
            raise StudyError(f"{self}: expected low < high, whole numbers for an integer factor")

    def at(self, u: float) -> float:
        """The value at the share `u` (0 <= u < 1) of the range."""
        if self.integer:
            return int(self.low) + int(u * (self.high - self.low + 1))
        return self.low + u * (self.high - self.low)


@dataclass(frozen=True)
class SaltelliDesign:
    """The n · (d + 2) design points to simulate, each a dict factor -> value, for d factors.

    First n points of A, then n of B, then for each factor in turn the n of A with that factor from B. The
    values go to `saltelli_indices` in this order.
    """

    factors: tuple[str, ...]
    n: int
    points: tuple[dict[str, Any], ...]


@dataclass(frozen=True)
class SobolIndices:
    """Shares of the indicator's variance by factor, with bootstrap intervals (`confidence`, each on its own).

    `first`: what the factor explains alone. `total`: with all interactions it takes part in. Near 0 it means that the
    factor can be left out. All nan, and `variance` 0, where the indicator does not vary.
    """

    first: dict[str, float]
    total: dict[str, float]
    first_interval: dict[str, tuple[float, float]]
    total_interval: dict[str, tuple[float, float]]
    variance: float
    confidence: float


def saltelli_design(factors: Mapping[str, Between | Sequence[Any]], n: int = 128, seed: int = 0) -> SaltelliDesign:
    """The design points from which `saltelli_indices` computes the indices.

    Args:
        factors: at least two, each a range `Between(low, high)` or a sequence of levels, all equally likely.
        n: base sample, a power of 2: n · (d + 2) points for d factors.
        seed: of the scrambling: the same seed, the same points.

    Raises:
        StudyError: fewer than two factors, a factor without levels, or n not a power of 2.

    Source: Saltelli et al. (2010), Variance based sensitivity analysis of model output, Computer Physics
    Communications 181(2), 259-270, section 5: A and B are halves of one 2d-dimensional Sobol sequence.
    """
    from scipy.stats import qmc

    if len(factors) < 2:  # noqa: PLR2004
        raise StudyError(f"Sobol indices of {len(factors)} factors: expected at least two to share the variance")
    if n < 2 or n & (n - 1):  # noqa: PLR2004
        raise StudyError(f"base sample {n}: expected a power of 2, as 64, 128 or 256")
    d = len(factors)
    points = qmc.Sobol(2 * d, rng=np.random.default_rng(seed)).random(n)
    a, b = points[:, :d], points[:, d:]
    blocks = [a, b]
    for i in range(d):
        mixed = a.copy()
        mixed[:, i] = b[:, i]
        blocks.append(mixed)
    rows = np.vstack(blocks).tolist()
    chosen = tuple(
        {name: _level(name, spec, u) for (name, spec), u in zip(factors.items(), row, strict=True)} for row in rows
    )
    return SaltelliDesign(tuple(factors), n, chosen)


def saltelli_indices(
    design: SaltelliDesign,
    values: Sequence[float] | NDArray[np.float64],
    confidence: float = 0.95,
    resamples: int = 500,
    seed: int = 0,
) -> SobolIndices:
    """First-order and total Sobol indices of an indicator from its values at the design's points.

    Args:
        design: from `saltelli_design`.
        values: the indicator at each point, in the design's order, shape (n · (d + 2),).
        confidence: of the bootstrap intervals.
        resamples: bootstrap samples of the n base points.
        seed: draws the bootstrap samples.

    Raises:
        StudyError: the wrong number of values, or one that is not finite (a failed run leaves a gap:
            repeat it).

    Source: Saltelli et al. (2010), as `scipy.stats.sobol_indices` computes them; percentile bootstrap over
    base points.
    Assumes: factors independent and uniform over what the design says. Noise: with common random numbers the
    indices are those of one noise path; average several replications of each point, or noise counts as
    interaction and inflates the totals. Estimates may fall a little outside 0..1.
    """
    check_confidence(confidence)
    y = finite(values, "indicator")
    d, n = len(design.factors), design.n
    if y.size != n * (d + 2):
        raise StudyError(f"Sobol indices: {y.size} values, expected n · (d + 2) = {n * (d + 2)} of the design")
    if is_constant(y):
        nothing = dict.fromkeys(design.factors, math.nan)
        none = dict.fromkeys(design.factors, (math.nan, math.nan))
        return SobolIndices(nothing, nothing, none, none, 0.0, confidence)
    f = y.reshape(d + 2, n)
    rng = np.random.default_rng(seed)
    draws = np.array([_indices(f[:, rng.integers(0, n, n)]) for _ in range(resamples)])
    ends = np.quantile(draws, [0.5 - confidence / 2, 0.5 + confidence / 2], axis=0)  # shape (2, 2, d)
    first, total = (dict(zip(design.factors, row, strict=True)) for row in _indices(f).tolist())
    first_ends, total_ends = (
        {name: (low, high) for name, low, high in zip(design.factors, *ends[:, which].tolist(), strict=True)}
        for which in (0, 1)
    )
    return SobolIndices(first, total, first_ends, total_ends, float(f[:2].var()), confidence)


def _level(name: str, spec: Between | Sequence[Any], u: float) -> Any:
    """The factor's value at a share of its range or levels."""
    if isinstance(spec, Between):
        return spec.at(u)
    if not spec:
        raise StudyError(f"factor {name!r} has no levels")
    return spec[int(u * len(spec))]


def _indices(f: NDArray[np.float64]) -> NDArray[np.float64]:
    """First and total indices, shape (2, d), from values of shape (d + 2, n): A, B, then the mixed."""
    from scipy.stats import sobol_indices

    result = sobol_indices(func={"f_A": f[:1], "f_B": f[1:2], "f_AB": f[2:, None, :]}, n=f.shape[1])
    return np.array([result.first_order, result.total_order])
