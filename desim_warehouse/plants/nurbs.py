"""How long a curve is: non-uniform rational B-splines, as robots drive along them.

Source: L. Piegl, W. Tiller, The NURBS Book (2nd ed., Springer 1997): de Boor's algorithm in homogeneous coordinates;
the length is integrated with Gauss-Legendre quadrature between the knots, each part halved until both agree.
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
_CHUNK = 2048  # parts at once


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
    return _Curve(degree, knots, points, weights).length()


class _Curve:
    def __init__(
        self, degree: int, knots: Sequence[float], points: Sequence[tuple[float, float]], weights: Sequence[float]
    ) -> None:
        import numpy as np

        self.np = np
        self.degree = degree
        self.knots = np.asarray(knots, dtype=float)
        factors = np.asarray(weights, dtype=float)[:, None]
        self.points = np.hstack([np.asarray(points, dtype=float) * factors, factors])
        self.at, self.share = np.polynomial.legendre.leggauss(_NODES)

    def length(self) -> float:
        np, last = self.np, len(self.points)
        spans = np.arange(self.degree, last)
        spans = spans[self.knots[spans] < self.knots[spans + 1]]
        starts, ends = self.knots[spans], self.knots[spans + 1]
        parts = self.integrals(spans, starts, ends)
        tolerance = _AGREE * max(float(parts.sum()), 1e-12)
        whole = 0.0
        for _ in range(_HALVED):
            middles = (starts + ends) / 2
            left, right = self.integrals(spans, starts, middles), self.integrals(spans, middles, ends)
            open_ = np.abs(left + right - parts) > tolerance / max(len(parts), 1)
            whole += float((left + right)[~open_].sum())
            if not open_.any():
                break
            spans = np.concatenate([spans[open_]] * 2)
            starts, ends = (
                np.concatenate([starts[open_], middles[open_]]),
                np.concatenate([middles[open_], ends[open_]]),
            )
            parts = np.concatenate([left[open_], right[open_]])
        else:
            whole += float(parts.sum())
        return whole

    def integrals(self, spans: Any, starts: Any, ends: Any) -> Any:
        """The lengths of parts of the curve, each inside one span of the knots."""
        np = self.np
        found = [
            self.chunk(spans[at : at + _CHUNK], starts[at : at + _CHUNK], ends[at : at + _CHUNK])
            for at in range(0, len(spans), _CHUNK)
        ]
        return np.concatenate(found)

    def chunk(self, spans: Any, starts: Any, ends: Any) -> Any:
        half = (ends - starts) / 2
        where = starts[:, None] + half[:, None] * (self.at + 1)
        return (self.paces(spans, where) * self.share).sum(axis=1) * half

    def paces(self, spans: Any, where: Any) -> Any:
        """The length of the derivative, at several places of each span."""
        np, degree, knots = self.np, self.degree, self.knots
        near = [self.points[spans - degree + rank][:, None, :] + 0.0 * where[:, :, None] for rank in range(degree + 1)]
        for level in range(1, degree + 1):
            if level == degree:
                width = (knots[spans + 1] - knots[spans])[:, None, None]
                slope = degree * (near[degree] - near[degree - 1]) / width
            for rank in range(degree, level - 1, -1):
                low = knots[spans - degree + rank][:, None]
                high = knots[spans + 1 + rank - level][:, None]
                share = ((where - low) / (high - low))[:, :, None]
                near[rank] = (1 - share) * near[rank - 1] + share * near[rank]
        weight = near[degree][:, :, 2]
        x, y = ((slope[:, :, axis] * weight - near[degree][:, :, axis] * slope[:, :, 2]) / weight**2 for axis in (0, 1))
        return np.hypot(x, y)
