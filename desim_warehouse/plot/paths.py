"""Many shapes as a few paths: tens of thousands of shapes by themselves take most of the time of a drawing.

For `plot.layout`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import PathCollection
from matplotlib.path import Path
from matplotlib.transforms import IdentityTransform

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.backend_bases import RendererBase


_AT_ONCE = 5_000
"""Shapes of a path: there is a limit to what can be filled at once."""
_SQUARE = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
_HEAD = 0.5 * np.array([-1 - 1j, -1 + 1j, 1, -1 - 1j])
"""An arrow head of length 1 to the right."""


def lines(axes: Axes, ends: Iterable[Any], colour: str, width: float, zorder: float) -> None:
    """Draw a line between each two points, sharp on pixels."""
    look: dict[str, Any] = {"facecolor": "none", "edgecolor": colour, "linewidth": width, "snap": True}
    _add(axes, PathCollection(_paths(ends), zorder=zorder, **look))


def squares(axes: Axes, middles: Iterable[Any], side: float, zorder: float, **colours: Any) -> None:
    """Draw a square around each point."""
    corners = np.array(list(middles)).reshape(-1, 1, 2) + side * _SQUARE
    _add(axes, PathCollection(_paths(corners), zorder=zorder, **colours))


def heads(axes: Axes, middles: Any, ways: Any, inches: float, colour: str, zorder: float) -> None:
    """Draw an arrow head around each point, in the direction of a vector; both are complex numbers."""
    _add(axes, Heads(middles, ways, inches, facecolor=colour, edgecolor="none", zorder=zorder))


def _add(axes: Axes, collection: PathCollection) -> None:
    axes.add_collection(collection, autolim=False)


def _paths(shapes: Iterable[Any]) -> list[Path]:
    """Return the paths of shapes with equally many points; a shape that ends where it begins is closed."""
    points = np.array(list(shapes), dtype=float)
    if not len(points):
        return []
    codes = np.full(points.shape[:2], Path.LINETO, dtype=Path.code_type)
    codes[:, 0] = Path.MOVETO
    codes[(points[:, 0] == points[:, -1]).all(axis=1), -1] = Path.CLOSEPOLY
    return [
        Path(points[some : some + _AT_ONCE].reshape(-1, 2), codes[some : some + _AT_ONCE].ravel())
        for some in range(0, len(points), _AT_ONCE)
    ]


class Heads(PathCollection):
    """Arrow heads of one size on paper, whatever the scale of the axes."""

    def __init__(self, middles: Any, ways: Any, inches: float, **look: Any) -> None:
        super().__init__([], **look)
        self.set_transform(IdentityTransform())
        self.middles, self.ways, self._points = middles, ways, 72 * inches

    def draw(self, renderer: RendererBase) -> None:
        """Work out the heads on paper, and draw them."""
        middles, tips = (self._on_paper(points) for points in (self.middles, self.middles + self.ways))
        far = np.abs(tips - middles)
        turned = (tips - middles) / np.where(far == 0, 1.0, far) * renderer.points_to_pixels(self._points)
        corners = middles[:, None] + turned[:, None] * _HEAD
        self.set_paths(_paths(np.stack([corners.real, corners.imag], axis=-1)))
        super().draw(renderer)

    def _on_paper(self, points: Any) -> Any:
        assert self.axes is not None
        x, y = self.axes.transData.transform(np.stack([points.real, points.imag], axis=-1)).T
        return x + 1j * y
