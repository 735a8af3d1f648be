"""Placement of names on a drawing: beside the object named, without covering anything else.

For the floor that `desim draw`, `plot.layout` and the page of a run show.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

Box = tuple[float, float, float, float]
"""Left, top, right and bottom, in the units of the drawing; y grows downwards."""
Side = tuple[int, int]
"""A direction by its signs along x and y: (0, -1) is above."""
LETTER = 0.62
"""Width of a letter, as a part of the size of its font."""
_SIDES: tuple[Side, ...] = ((0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1))
_FARTHER = (1.0, 2.5, 4.5)
"""Gaps between what is named and its name: one after another they are tried."""


@dataclass(frozen=True)
class Spot:
    """The place of a name on a drawing: its box, and on which side it stands (-1: left, 0: over or below)."""

    box: Box
    across: int

    @property
    def x(self) -> float:
        """The x at which the text is anchored: its end next to what it names, or its middle."""
        left, _, right, _ = self.box
        return (left + right) / 2 - self.across * (right - left) / 2

    @property
    def y(self) -> float:
        """The y of the middle of the text."""
        return (self.box[1] + self.box[3]) / 2


@dataclass
class Sheet:
    """The boxes on a drawing that are occupied already.

    Attributes:
        marks: nodes, slots and names, which no name covers.
        lines: lanes and storage places, which a name covers only where no other place is free.
    """

    marks: list[Box]
    lines: list[Box] = field(default_factory=list)

    def put(
        self, sizes: Sequence[tuple[float, float]], around: Box, gap: float, side: Side, *, again: bool = False
    ) -> tuple[Spot, int] | None:
        """Find a free spot for a name beside a box, and keep it free of later names.

        Args:
            sizes: width and height of the name, the best size first; a smaller one on the best side is preferred to a
                larger one on another.
            around: the box of what is named.
            gap: the least room between the two.
            side: where it stands if it can; else on the sides next to that one, and farther out.
            again: whether the name stands elsewhere already, so that it may not cover lines, either.

        Returns:
            The spot and which of the sizes it has; None where each would cover a mark.
        """
        spots = [list(_spots(size, around, gap, side)) for size in sizes]
        best = [(some[:1], number) for number, some in enumerate(spots)]
        others = [(some[1:], number) for number, some in enumerate(spots)]
        for drawn in (self.marks + self.lines, *([] if again else [self.marks])):
            for some, number in best + others:
                if chosen := _first_free(some, drawn):
                    self.marks.append(chosen.box)
                    return chosen, number
        return None


def box_around(x: float, y: float, half: float) -> Box:
    """Return the square of half a side about a point."""
    return x - half, y - half, x + half, y + half


def boxes_along(start: tuple[float, float], end: tuple[float, float], pitch: float) -> Iterator[Box]:
    """Yield boxes that cover a line: one where it goes along x or y, else one for each `pitch` of its length."""
    (x0, y0), (x1, y1) = start, end
    slanted = min(abs(x1 - x0), abs(y1 - y0)) > 0
    pieces = max(math.ceil(math.dist(start, end) / pitch), 1) if slanted else 1
    points = [(x0 + (x1 - x0) * part / pieces, y0 + (y1 - y0) * part / pieces) for part in range(pieces + 1)]
    for (ax, ay), (bx, by) in pairwise(points):
        yield min(ax, bx), min(ay, by), max(ax, bx), max(ay, by)


def _spots(size: tuple[float, float], around: Box, gap: float, side: Side) -> Iterator[Spot]:
    left, top, right, bottom = around
    wide, high = size
    ordered = sorted(_SIDES, key=lambda other: _angle(side, other))
    for far in _FARTHER:
        for across, down in ordered:
            x = (left + right) / 2 + across * ((right - left + wide) / 2 + far * gap)
            y = (top + bottom) / 2 + down * ((bottom - top + high) / 2 + far * gap)
            yield Spot((x - wide / 2, y - high / 2, x + wide / 2, y + high / 2), across)


def _angle(side: Side, other: Side) -> float:
    return abs(math.remainder(math.atan2(side[1], side[0]) - math.atan2(other[1], other[0]), math.tau))


def _first_free(spots: Iterable[Spot], drawn: list[Box]) -> Spot | None:
    import numpy as np

    if not drawn:
        return next(iter(spots), None)
    left, top, right, bottom = np.array(drawn, dtype=float).T
    for spot in spots:
        x0, y0, x1, y1 = spot.box
        if not ((left < x1) & (right > x0) & (top < y1) & (bottom > y0)).any():
            return spot
    return None
