"""Arguments that are numbers: whether they are whole, or finite, whatever has been given.

For functions called from Python, which refuse anything else in their own words before they begin.
"""

from __future__ import annotations

import math
from numbers import Integral, Real


def is_whole(value: object, least: float = -math.inf, most: float = math.inf) -> bool:
    """Whether a value is a whole number from `least` to `most`; a truth value is none."""
    return isinstance(value, Integral) and not isinstance(value, bool) and least <= int(value) <= most


def is_finite(value: object) -> bool:
    """Whether a value is a finite number that a float can hold; a truth value is none."""
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:
        return False
