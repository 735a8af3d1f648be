"""A floor of cells drawn as a map: aisles are light, shelves are dark, and colours say what cells are for.

For `plot.layout` and `plot.congestion`, and so for `desim draw`.

On such a floor nodes are as close as robots can stand, so that names, arrows and slots beside them would lie over one
another.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.layout import Layout
from desim_warehouse.look import palette
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.model.facts.places import destinations
from desim_warehouse.outcome.zones import cell_size
from desim_warehouse.plot import style as look

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_FEWEST = 400
"""Cells from which on a floor is drawn as a map."""
ARROWS = 2_500
"""Cells or lanes up to which there are arrows."""
_RASTER = 5_000
"""Cells from which on they are pixels in SVG and PDF files, too."""
DPI = 144
"""Of pictures."""
_PIXELS, _WIDTH, _WIDEST = 5, 14.0, 60.0
"""Pixels of a cell, and inches of a picture."""
_ALIKE = 1.01
"""Times the side of a cell beyond which a lane leads over others."""
_OPEN = 0.9
"""How much of a cell its colour fills."""
SHELF, AISLE, GOODS = palette.GROUND["light"]["border"], "white", "#F3C7A5"


def width(model: Model, floor: Layout) -> float:
    """Return the width in inches at which every cell of a floor can be seen."""
    xs = [x for _, x in floor.graph.nodes(data="x")]
    return float(min(max(_PIXELS * (max(xs) - min(xs)) / cell_size(model, floor) / DPI, _WIDTH), _WIDEST))


def is_map(model: Model, floor: Layout) -> bool:
    """Whether a floor is a grid of so many cells that names of nodes could not be read."""
    return len(floor.graph) >= _FEWEST and cell_size(model, floor) > 0


def draw(axes: Axes, floor: Layout, model: Model) -> None:
    """Draw cells and lanes, coloured by their use, with arrows on one-way lanes, and a key."""
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.lines import Line2D

    step = cell_size(model, floor)
    points = {name: (data["x"], data["y"]) for name, data in floor.graph.nodes(data=True)}
    colours = _colours(model, floor)
    middles = np.array(list(points.values()))
    shapes = []
    for colour, side in ((AISLE, step), *((colour, _OPEN * step) for colour in _KEY.values())):
        chosen = [rank for rank, name in enumerate(points) if colour in {AISLE, colours.get(name)}]
        shapes.append((_squares(middles[chosen], side), colour))
    longer = [(points[a], points[b]) for a, b in floor.lanes if math.dist(points[a], points[b]) > _ALIKE * step]
    axes.add_collection(LineCollection(longer, colors=AISLE, linewidths=1.5, zorder=1))
    axes.set_facecolor(SHELF)
    for squares, colour in shapes:
        drawn = PolyCollection(list(squares), facecolors=colour, edgecolors="none", antialiaseds=False, zorder=1)
        drawn.set_rasterized(len(points) > _RASTER)
        axes.add_collection(drawn)
    if len(points) <= ARROWS:
        _arrows(axes, floor, points, step)
    low, high = middles.min(axis=0) - step, middles.max(axis=0) + step
    look.floor_axes(axes, model, (low[0], high[0]), (low[1], high[1]))
    used = {AISLE, *colours.values()}
    marks = [("shelf or wall", SHELF), ("aisle", AISLE), *_KEY.items()]
    handles = [
        Line2D([], [], linestyle="none", marker="s", markerfacecolor=colour, markeredgecolor=palette.FAINT, label=label)
        for label, colour in marks
        if colour in {SHELF, *used}
    ]
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0), borderaxespad=4, ncols=len(handles))


_KEY = {
    "storage place": GOODS,
    "bay": palette.BAY,
    "charger": palette.CHARGER,
    "station": palette.STATION,
}


def _colours(model: Model, floor: Layout) -> dict[str, str]:
    """Return the colour of each node by its use, the last in the order of the key; none for a use of most nodes."""
    chargers = chargers_at(model, floor) if model.battery is not None else {}
    nodes = {
        "bay": set(floor.bays),
        "charger": {node for node, number in chargers.items() if number},
        "station": {*floor.stations, *destinations(model, floor)},
        "storage place": {node for place in floor.storage for node in place.edge},
    }
    colours: dict[str, str] = {}
    for what, here in nodes.items():
        if len(here) <= len(floor.graph) * 2 / 3:
            colours.update(dict.fromkeys(here, _KEY[what]))
    return colours


def _squares(middles: np.ndarray, side: float) -> np.ndarray:
    """Return the corners of a square around each point."""
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * side / 2
    squares: np.ndarray = middles.reshape(-1, 1, 2) + corners
    return squares


def _arrows(axes: Axes, floor: Layout, points: dict[str, tuple[float, float]], step: float) -> None:
    """Draw an arrow along each one-way lane."""
    edges = [(points[a], points[b]) for a, b, two_way in floor.graph.edges(data="two_way") if not two_way]
    if not edges:
        return
    ends = np.array(edges)
    spans, middles = ends[:, 1] - ends[:, 0], (ends[:, 0] + ends[:, 1]) / 2
    lengths = np.array([math.hypot(*span) for span in spans]).reshape(-1, 1)
    spans = spans / lengths * 0.6 * step
    shape: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "scale": 1, "pivot": "mid", "units": "xy"}
    shape |= {"width": 0.06 * step, "headwidth": 5, "headlength": 4, "headaxislength": 4}
    axes.quiver(*middles.T, *spans.T, color=palette.FAINT, **shape, zorder=2)
