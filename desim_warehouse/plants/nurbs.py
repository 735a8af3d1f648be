"""How long a curve is: non-uniform rational B-splines, as robots drive along them.

Source: L. Piegl, W. Tiller, The NURBS Book (2nd ed., Springer 1997): a rational curve is a B-spline in homogeneous
coordinates, divided by its weight. The length is integrated with Gauss-Legendre quadrature between the knots; parts
are halved until both agree.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

_STEEPEST = 30  # degree
_NODES = 16  # of the quadrature
_AGREE = 1e-9  # of the length
_HALVED = 20  # times at most: a cusp converges slowly


def arc_length(
    degree: int, knots: Sequence[float], points: Sequence[tuple[float, float]], weights: Sequence[float]
) -> float:
    """The length of a curve from its first knot of full support to its last.

    Args:
        degree: of the pieces, from 1 to 30.
        knots: not falling, as many as there are points, and degree + 1.
        points: control points, at least degree + 1.
        weights: of the control points, above 0.

    Raises:
        ValueError: where these are no curve, with the reason.
    """
    count = len(points)
    if not 1 <= degree <= _STEEPEST:
        raise ValueError(f"of degree {degree}")
    if count <= degree or len(knots) != count + degree + 1:
        raise ValueError(f"{count} control points and {len(knots)} knots for degree {degree}")
    if any(b < a for a, b in pairwise(knots)) or knots[degree] == knots[count]:
        raise ValueError("knots that fall, or are all the same")
    if min(weights) <= 0:
        raise ValueError("weights that are not above 0")
    if degree == 1:  # along a straight line weights change the pace only
        return sum(math.dist(a, b) for a, b in pairwise(points))
    return _length(degree, knots, points, weights)


def _length(
    degree: int, knots: Sequence[float], points: Sequence[tuple[float, float]], weights: Sequence[float]
) -> float:
    import numpy as np
    from scipy.interpolate import BSpline

    scale = np.asarray(weights, dtype=float)[:, None]
    curve = BSpline(np.asarray(knots, dtype=float), np.hstack([points * scale, scale]), degree)
    at, share = np.polynomial.legendre.leggauss(_NODES)

    def lengths(starts: Any, ends: Any) -> Any:
        """Of parts of the curve, each inside one span of the knots."""
        half = (ends - starts) / 2
        where = starts[:, None] + half[:, None] * (at + 1)
        (x, y, weight), (dx, dy, change) = (np.moveaxis(curve(where, nu), -1, 0) for nu in (0, 1))
        return np.hypot(dx * weight - x * change, dy * weight - y * change) / weight**2 @ share * half

    corners = np.unique(knots[degree : len(points) + 1])
    starts, ends = corners[:-1], corners[1:]
    parts = lengths(starts, ends)
    tolerance = _AGREE * max(float(parts.sum()), 1e-12)
    whole = 0.0
    for _ in range(_HALVED):
        middles = (starts + ends) / 2
        left, right = lengths(starts, middles), lengths(middles, ends)
        again = np.abs(left + right - parts) > tolerance / max(len(parts), 1)
        whole += float((left + right)[~again].sum())
        starts, ends = np.r_[starts[again], middles[again]], np.r_[middles[again], ends[again]]
        parts = np.r_[left[again], right[again]]
    return whole + float(parts.sum())
