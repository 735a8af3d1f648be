"""Lanes made from the links of a drawing: opposite links join to one lane, and of parallel links the shortest stays.

For `desim import` (`plants.model`), and for export to openTCS.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from desim_warehouse.plants.checks import length_of
from desim_warehouse.plants.plant import Link, Plant

ALIKE = 0.05
"""Relative difference in length above which two opposite links are two lanes side by side."""

CRAWL = 0.1
"""Ratio of the speeds of two directions below which the slower direction is probably meant to be forbidden."""


@dataclass(slots=True)
class DrawnLane:
    """A lane from source to target, made of links; with `side_by_side` a separate lane leads back."""

    source: str
    target: str
    length: float
    speed: float
    two_way: bool = False
    side_by_side: bool = False
    against: float = 1.0
    speed_back: float | None = None


@dataclass(slots=True)
class _Direction:
    """A link in one of its directions."""

    link: Link
    source: str
    target: str
    length: float
    speed: float

    @property
    def back(self) -> bool:
        """Whether the direction is from the link's target to its source."""
        return self.source != self.link.source


def lanes_of(plant: Plant) -> list[DrawnLane]:
    """Return the lanes made of the links of a plant, in their order; changes are noted in the plant."""
    directions: dict[tuple[str, str], _Direction] = {}
    loops, doubled = [], []
    for link in plant.links:
        if link.source == link.target:
            loops.append(link)
            continue
        for direction in _directions(plant, link):
            ends = direction.source, direction.target
            other = directions.get(ends)
            if other is not None:
                if direction.back == other.back:
                    doubled.append(max(direction, other, key=lambda item: item.length).link)
                if direction.length >= other.length:
                    continue
            directions[ends] = direction
    plant.note_parts("left out", "link", loops, "from a point to itself")
    why = "beside another between the same points that is as short or shorter"
    plant.note_parts("left out", "link", dict.fromkeys(doubled), why)
    return _joined(plant, directions)


def _directions(plant: Plant, link: Link) -> list[_Direction]:
    length = length_of(plant, link)
    both = ((link.source, link.target, link.speed), (link.target, link.source, link.speed_back))
    return [_Direction(link, a, b, length, speed) for a, b, speed in both if speed > 0]


def _joined(plant: Plant, directions: dict[tuple[str, str], _Direction]) -> list[DrawnLane]:
    lanes, crawls, apart, done = [], [], [], set()
    for (a, b), ahead in directions.items():
        back = directions.get((b, a))
        done.add((a, b))
        if back is None:
            lanes.append(DrawnLane(a, b, ahead.length, ahead.speed))
        elif ahead.link.side_by_side or back.link.side_by_side:
            lanes.append(DrawnLane(a, b, ahead.length, ahead.speed, side_by_side=True))
        elif abs(ahead.length - back.length) > ALIKE * max(ahead.length, back.length):
            lanes.append(DrawnLane(a, b, ahead.length, ahead.speed, side_by_side=True))
            apart.append(ahead.link)
        elif (b, a) not in done:
            # A model cannot represent a limit for the first direction and none for the other.
            first, other = (back, ahead) if ahead.speed < back.speed == math.inf else (ahead, back)
            ends = first.source, first.target
            lanes.append(DrawnLane(*ends, ahead.length, first.speed, two_way=True, speed_back=other.speed))
            if first.link is other.link and not first.back:
                lanes[-1].against = ahead.link.against
            if min(ahead.speed, back.speed) < CRAWL * max(ahead.speed, back.speed):
                crawls.append(ahead.link)
    why = (
        f"in one direction at less than {CRAWL:.0%} of the speed in the other, drawn so to forbid it as a rule: leave "
        "out two_way and speed_back, and the lane is one-way"
    )
    plant.note_parts("doubtful", "link", crawls, why)
    why = f"with one back whose length differs by more than {ALIKE:.0%}, so they are taken for two lanes side by side"
    plant.note_parts("changed", "link", apart, why)
    return lanes
