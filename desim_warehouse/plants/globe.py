"""Projection of degrees on the globe to metres on a plane that touches it in the middle of a plant.

For the readers of GeoJSON and Open-RMF.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from desim_warehouse.plants.plant import Plant

_RADIUS = 6_371_008.8
"""Mean radius of the earth in metres."""
TURN = 360.0
Spot = tuple[float, float]


def plane(spots: Sequence[Spot], plant: Plant) -> Callable[[Spot], Spot]:
    """Return the projection of degrees (longitude, latitude) to metres around the middle of `spots`.

    The projection is noted in the plant.
    """
    xs, ys = [x for x, _ in spots] or [0.0], [y for _, y in spots] or [0.0]
    centre, middle = (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2
    across = math.cos(math.radians(middle))
    plant.assume("units.length", f"m; degrees are projected around {centre:.6f}, {middle:.6f}")

    def projected(spot: Spot) -> Spot:
        x, y = math.radians(spot[0] - centre) * _RADIUS * across, math.radians(spot[1] - middle) * _RADIUS
        return round(x, 4), round(-y, 4)

    return projected
