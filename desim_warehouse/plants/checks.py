"""Checks of a drawing: faults are noted by name and position, and corrected if otherwise no model could be made.

For `desim import` and `desim export`, which print the remarks.
"""

from __future__ import annotations

import math
from dataclasses import replace
from statistics import median

from desim_warehouse.plants.plant import Link, Plant

APART = 0.01
"""Distance in metres by which points drawn on one spot are moved apart."""
DIGITS = 4
"""Decimals of coordinates and lengths in metres, the precision of a drawing."""
_SHORT = 0.99  # of the straight distance: shorter links are noted
_FAR_TOO_SHORT = 0.1  # of the straight distance: shorter links may be in another unit
_WIDEST = 1000.0  # metres: a wider floor may be in another unit
_NARROWEST = 1.0  # metres: a smaller floor may be in another unit
_LONG = 200.0  # metres: if half of all links are longer, their unit may be another


def put_right(plant: Plant) -> None:
    """Check a plant before a model is made of it, correct what must be corrected, and note what looks wrong.

    - Locations linked to no point are left out.
    - Links shorter than the straight line between their points keep their length.
    - Links shorter than a tenth of that line, links of several hundred metres, and floors beyond 1 km or below 1 m are
    doubtful: they are probably in another unit.
    - Points on one spot are moved apart a little, as two nodes cannot coincide.
    """
    unlinked = [location for location in plant.locations if not location.operations]
    plant.locations = [location for location in plant.locations if location.operations]
    plant.note_parts("left out", "location", unlinked, "no link to a point, so no vehicle gets there")
    short = [
        link for link in plant.links if length_of(plant, link) < _SHORT * distance(plant, link.source, link.target)
    ]
    why = "shorter than the straight line between its points; the length counts, not the drawing"
    plant.note_parts("changed", "link", short, why)
    slips = [
        link for link in short if length_of(plant, link) < _FAR_TOO_SHORT * distance(plant, link.source, link.target)
    ]
    why = "less than a tenth of the straight line between its points; are lengths in another unit than coordinates?"
    plant.note_parts("doubtful", "link", slips, why)
    wide, high = floor_of(plant)
    if max(wide, high) > _WIDEST:
        why = f"wider than {_WIDEST:,g} m; are coordinates in mm, feet, pixels or degrees?"
        plant.note("doubtful", "floor", [f"{wide:,.0f} x {high:,.0f} m"], why)
    if 0 < max(wide, high) < _NARROWEST:
        why = f"no {_NARROWEST:g} m wide, so no robot fits; are coordinates in km or degrees?"
        plant.note("doubtful", "floor", [f"{wide:.2g} x {high:.2g} m"], why)
    lengths = [distance(plant, link.source, link.target) for link in plant.links if link.source != link.target]
    if lengths and median(lengths) > _LONG:
        why = f"half of the links are longer than {_LONG:g} m; are coordinates in mm, pixels or degrees?"
        plant.note("doubtful", "unit of length", [f"median of {median(lengths):,.0f} m"], why)
    _separate(plant)


def _separate(plant: Plant) -> None:
    beside: dict[tuple[float, float], int] = {}  # points on a spot, or moved away from it
    moved = []
    for point in list(plant.points.values()):
        first, x = (round(point.x, DIGITS), round(point.y, DIGITS)), point.x
        while (spot := (round(x, DIGITS), round(point.y, DIGITS))) in beside:
            x = point.x + APART * beside[first]
            beside[first] += 1
        beside[spot] = 1
        if x != point.x:
            plant.points[point.name] = replace(point, x=x)
            moved.append(point)
    plant.note_parts("changed", "point", moved, f"on the spot of another, so drawn {APART:g} m or more beside it")


def floor_of(plant: Plant) -> tuple[float, float]:
    """Return width and height of the box around all points, in metres."""
    xs, ys = (
        [point.x for point in plant.points.values()] or [0.0],
        [point.y for point in plant.points.values()] or [0.0],
    )
    return max(xs) - min(xs), max(ys) - min(ys)


def length_of(plant: Plant, link: Link) -> float:
    """Return the length of a link in metres: as drawn, or else the straight distance."""
    return distance(plant, link.source, link.target) if link.length is None else link.length


def distance(plant: Plant, source: str, target: str) -> float:
    """Return the straight distance between two points, in metres."""
    a, b = plant.points[source], plant.points[target]
    return math.hypot(b.x - a.x, b.y - a.y)
