"""Names on a floor that is drawn: of nodes, bays and stations, each where nothing else is.

For `plot.layout` and `plot.congestion`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from desim_warehouse.look.labels import LETTER, Box, Sheet, Side
from desim_warehouse.plot import style as look

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POINTS = 72
"""Points of an inch."""
_GAP = 0.3
"""Room between what is named and its name, as a part of the size of the font."""
_LINE = 1.2
"""Height of a line, as a part of the size of its font."""
_HELD = {-1: "right", 0: "center", 1: "left"}


@dataclass(frozen=True)
class Name:
    """A name to be written, beside a box in the units of the floor.

    Attributes:
        side: where it stands if it can.
        font: its size, as matplotlib calls it.
    """

    text: str
    around: Box
    side: Side
    font: str
    colour: str


def write_names(axes: Axes, names: Iterable[Name], sheet: Sheet) -> list[Box]:
    """Write names where nothing is drawn, and leave out those without such a place; returns the boxes that they fill.

    Limits of the axes must be set, as letters have one size on all floors.
    """
    from matplotlib.font_manager import FontProperties

    point = length_of_a_point(axes)
    boxes = []
    for name in names:
        high = FontProperties(size=name.font).get_size_in_points() * point
        size = LETTER * high * len(name.text), _LINE * high
        if not (put := sheet.put([size], name.around, _GAP * high, name.side)):
            continue
        spot, _ = put
        boxes.append(spot.box)
        axes.text(
            *(spot.x, spot.y, look.text(name.text)),
            ha=_HELD[spot.across],
            va="center",
            fontsize=name.font,
            color=name.colour,
            zorder=4,
        )
    return boxes


def length_of_a_point(axes: Axes) -> float:
    """Return how long a point is in the units of a floor whose limits are set."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    axes.apply_aspect()
    (x0, _), (x1, _) = axes.transData.inverted().transform([(0, 0), (figure.dpi / _POINTS, 0)])
    return float(x1 - x0)
