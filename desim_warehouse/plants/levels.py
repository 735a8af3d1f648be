"""Several levels of a building on one floor plan: levels that overlap are drawn side by side."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from desim_warehouse.plants.plant import Plant

_APART = 10.0  # metres


def draw_apart(plant: Plant, level_of: Mapping[str, str]) -> None:
    """Move the points of levels that overlap to the right; lengths of links between levels must be known before.

    Args:
        plant: the plant; what is moved is noted there.
        level_of: the level of every point.
    """
    points: dict[str, list[str]] = {}
    for name, level in level_of.items():
        points.setdefault(level, []).append(name)
    boxes: list[tuple[float, float, float, float]] = []
    moved = []
    for level, names in points.items():
        xs, ys = [plant.points[name].x for name in names], [plant.points[name].y for name in names]
        left, right, top, bottom = min(xs), max(xs), min(ys), max(ys)
        if any(left <= box[1] and box[0] <= right and top <= box[3] and box[2] <= bottom for box in boxes):
            shift = max(box[1] for box in boxes) + _APART - left
            for name in names:
                plant.points[name] = replace(plant.points[name], x=plant.points[name].x + shift)
            left, right = left + shift, right + shift
            moved.append(level)
        boxes.append((left, right, top, bottom))
    plant.note("changed", "level", moved, "over or under another, so drawn beside it")
