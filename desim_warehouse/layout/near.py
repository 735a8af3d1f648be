"""Pairs of edges that come near each other as drawn: those that cross, and those that run side by side.

Edges are straight lines between their nodes, numbered in the layout's order; of a two-way pair there is one.
"""

from __future__ import annotations

import math
from collections import defaultdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from desim_warehouse.layout.layout import Layout

EPS = 1e-6
PARALLEL = math.sin(math.radians(5))
BENT = 1.05
"""An edge longer than this multiple of the straight line between its nodes is not drawn true to shape."""


class Near:
    """The pairs of edges that may come nearer to each other than `apart`: arrays of points, one entry a pair."""

    def __init__(self, layout: Layout, apart: float) -> None:
        import numpy as np

        self.edges = list({frozenset(edge): edge for edge in layout.graph.edges}.values())
        ends = np.array([[layout.points[node] for node in edge] for edge in self.edges], dtype=complex).reshape(-1, 2)
        drawn = np.abs(ends[:, 1] - ends[:, 0])
        self._straight = np.array([layout.length(edge) for edge in self.edges]) < BENT * drawn
        self.first, self.second = _pairs(ends, apart, float(drawn.mean()) + apart if len(drawn) else 1.0)
        self._a, self._b = ends[self.first].T
        self._c, self._d = ends[self.second].T

    def named(self, pairs: Any) -> list[str]:
        """The names of some pairs, sorted; `pairs` says of each whether it is one of them."""
        return sorted(
            f"{'>'.join(self.edges[i])} and {'>'.join(self.edges[j])}"
            for i, j in zip(self.first[pairs].tolist(), self.second[pairs].tolist(), strict=True)
        )

    def cross(self) -> Any:
        """Of each pair whether the edges cross away from their ends, and share no node."""
        import numpy as np

        def apart(start: Any, end: Any, one: Any, other: Any) -> Any:
            """Whether two points lie on different sides of the line from one point to another."""
            way = end - start
            sides = [
                (way.conj() * (point - start)).imag / np.where(way == 0, 1.0, np.abs(way)) for point in (one, other)
            ]
            return (np.minimum(*sides) < -EPS) & (np.maximum(*sides) > EPS)

        found = apart(self._a, self._b, self._c, self._d) & apart(self._c, self._d, self._a, self._b)
        for pair in np.flatnonzero(found):
            found[pair] = not {*self.edges[self.first[pair]]} & {*self.edges[self.second[pair]]}
        return found

    def are_along(self, apart: float) -> Any:
        """Of each pair whether the edges run side by side, less than `apart` from each other for longer than that."""
        import numpy as np

        first, second = self._b - self._a, self._d - self._c
        long = np.abs(first)
        unit = first / np.where(long == 0, 1.0, long)
        ends = [unit.conj() * (point - self._a) for point in (self._c, self._d)]
        beside = np.minimum(long, np.maximum(ends[0].real, ends[1].real)) - np.maximum(
            0.0, np.minimum(ends[0].real, ends[1].real)
        )
        return (
            (self._straight[self.first] & self._straight[self.second])
            & ((first != 0) & (second != 0))
            & (np.abs((unit.conj() * second).imag) <= PARALLEL * np.abs(second))
            & (np.maximum(np.abs(ends[0].imag), np.abs(ends[1].imag)) < apart - EPS)
            & (beside > apart)
        )


def _pairs(ends: Any, apart: float, size: float) -> tuple[Any, Any]:
    """The pairs of edges whose surroundings share a square of a grid: each once, by their numbers."""
    import numpy as np

    corners = np.stack([ends.real, ends.imag])
    low, high = (
        np.floor(side / size).astype(int).T.tolist() for side in (corners.min(2) - apart, corners.max(2) + apart)
    )
    squares = defaultdict(list)
    for edge, ((left, lower), (right, upper)) in enumerate(zip(low, high, strict=True)):
        for x in range(left, right + 1):
            for y in range(lower, upper + 1):
                squares[x, y].append(edge)
    by_count = defaultdict(list)
    for inside in squares.values():
        by_count[len(inside)].append(inside)
    found = [np.empty(0, dtype=int)]
    for count, alike in by_count.items():
        numbers, (one, other) = np.array(alike), np.triu_indices(count, 1)
        found.append((numbers[:, one] * len(ends) + numbers[:, other]).ravel())
    return np.divmod(np.unique(np.concatenate(found)), max(len(ends), 1))
