"""Arguments of any type: whether a number is whole, or finite, and one value where several may be given.

For functions called from Python, which refuse anything else in their own words before they begin.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from numbers import Integral, Real
from typing import Any


def each(values: Any) -> list[Any]:
    """Return one value, or an iterable of several, as a list; text is one value."""
    return list(values) if isinstance(values, Iterable) and not isinstance(values, str) else [values]


def is_whole(value: object, least: float = -math.inf, most: float = math.inf) -> bool:
    """Whether a value is a whole number from `least` to `most`; a truth value is none."""
    return isinstance(value, Integral) and not isinstance(value, bool) and least <= int(value) <= most


def is_finite(value: object) -> bool:
    """Whether a value is a finite number that a float can hold; a truth value is none."""
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:
        return False
