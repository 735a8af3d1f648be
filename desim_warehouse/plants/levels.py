"""Levels of a plant and the lifts between them: drawn beside each other, with room for the cabin on each level.

For `desim import`.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Container
from dataclasses import replace

from desim_warehouse.plants.checks import length_of
from desim_warehouse.plants.plant import Link, Plant, Waypoint, unique

RIDE, DOORS = 12.0, 4.0
"""Assumed seconds from one level to the next, and for the doors to open, if no file states them."""
_APART = 10.0  # metres
_LONGER = 1.01  # times the least length, as places are rounded
_DIRECTIONS = 8
_EPS = 1e-6


def draw_apart(plant: Plant) -> None:
    """Move the points of overlapping levels to the right; lengths of links between levels must be known before.

    Moved levels are noted in the plant.
    """
    points: dict[str, list[str]] = {}
    for name, level in plant.level_of.items():
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


def make_room_for_cabins(plant: Plant, contact: float) -> None:
    """Move the cabins of lifts away from points at which robots work or pass, or which are too close to the next point.

    There is one robot at a time in a cabin, and only one lane, of at least twice the distance `contact`, leads there on
    each level. Otherwise the cabin gets its own point with such a lane.
    """
    used = plant.work().keys() | {vehicle.start for vehicle in plant.vehicles}
    used |= {member for area in plant.areas for member in area.members}
    links: defaultdict[str, list[Link]] = defaultdict(list)
    for link in plant.links:
        links[link.source].append(link)
        links[link.target].append(link)
    taken: set[str] = set()
    moved = []
    for lift, stops in plant.lifts.items():
        cabins = []
        for point in stops:
            if point in taken or not _is_in_front(plant, point, links[point], used, contact):
                cabins.append(_beside(plant, point, _LONGER * 2 * contact))
                moved.append(point)
            else:
                cabins.append(point)
            taken.add(cabins[-1])
        plant.lifts[lift] = tuple(cabins)
    why = "in front of a lift: the cabin is beside it, as no robot works in a cabin, waits there or drives through it"
    plant.note("changed", "point", moved, why, [plant.points[name].position for name in moved])


def _is_in_front(plant: Plant, point: str, links: list[Link], used: Container[str | None], contact: float) -> bool:
    """Return whether a cabin may be at a point: one lane leads there and back, and nothing else is there."""
    if point in used or any(link.name in used for link in links):
        return False
    beside = {link.source if link.target == point else link.target for link in links}
    into = [link.speed if link.target == point else link.speed_back for link in links]
    out_of = [link.speed if link.source == point else link.speed_back for link in links]
    long = all(length_of(plant, link) >= 2 * contact - _EPS for link in links)
    return len(beside) == 1 and any(into) and any(out_of) and long


def _beside(plant: Plant, name: str, reach: float) -> str:
    """Add a point at a distance from another, with a two-way lane, where there is most room; return its name."""
    origin = plant.points[name]
    turns = (2 * math.pi * part / _DIRECTIONS for part in range(_DIRECTIONS))
    spots = [(origin.x + reach * math.cos(turn), origin.y + reach * math.sin(turn)) for turn in turns]

    def room(spot: tuple[float, float]) -> float:
        return min(math.dist(spot, (point.x, point.y)) for point in plant.points.values())

    x, y = max(spots, key=lambda spot: round(room(spot), 6))
    cabin = unique(f"{name} cabin", plant.points)
    plant.points[cabin] = Waypoint(cabin, x, y, position=origin.position)
    plant.level_of[cabin] = plant.level_of.get(name, "")
    plant.links.append(Link(f"{name} - {cabin}", name, cabin, reach, math.inf, math.inf))
    return cabin
