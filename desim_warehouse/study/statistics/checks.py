"""Checks of input: finite numbers, enough of them, a confidence or a share between 0 and 1."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from desim_warehouse.errors import StudyError, shown
from desim_warehouse.values.arguments import is_finite
from desim_warehouse.values.arrays import Floats

ROUNDING = 1e-12  # a spread below this share of the values is rounding, not randomness


def finite(values: Sequence[float] | Floats, what: str = "values") -> Floats:
    """Return the values of an indicator as a one-dimensional float array without missing values.

    Raises:
        StudyError: if there are no values; or naming those that are not finite, such as of failed runs.
    """
    array = np.asarray(values, dtype=float)
    if array.ndim != 1:
        raise StudyError(f"{what}: expected one row of numbers, got an array of shape {array.shape}")
    if array.size == 0:
        raise StudyError(f"{what}: no values, expected at least one run")
    bad = np.flatnonzero(~np.isfinite(array))
    if bad.size:
        where = ", ".join(str(i) for i in bad[:5]) + (", ..." if bad.size > 5 else "")  # noqa: PLR2004
        raise StudyError(f"{what}: not a finite number at position {where} (failed runs must be left out)")
    return array


def check_confidence(confidence: float) -> None:
    """Check that a confidence lies strictly between 0 and 1.

    Raises:
        StudyError: if it does not, with a hint if it looks like a percentage.
    """
    number = confidence if is_finite(confidence) else 0.0
    if not 0.0 < number < 1.0:
        hint = f", did you mean {number / 100:g}?" if 1.0 < number < 100.0 else ""  # noqa: PLR2004
        raise StudyError(f"confidence {shown(confidence):.60}: expected a number between 0 and 1{hint}")


def check_share(share: float) -> None:
    """Raise StudyError unless the share that defines a quantile lies strictly between 0 and 1."""
    if not (is_finite(share) and 0.0 < share < 1.0):
        raise StudyError(f"quantile {shown(share):.60}: expected a share between 0 and 1, such as 0.95")


def check_same(values: Floats) -> None:
    """Raise StudyError if values of a deterministic model differ."""
    if not is_constant(values):
        raise StudyError(f"a deterministic model gave values from {values.min():g} to {values.max():g}")


def is_constant(values: Floats, scale: float | None = None) -> bool:
    """Whether values differ by no more than floating-point rounding of numbers of size `scale`."""
    size = float(np.abs(values).max()) if scale is None else scale
    return float(np.ptp(values)) <= ROUNDING * size
