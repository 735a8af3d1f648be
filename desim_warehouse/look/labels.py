"""Place names on a drawing beside their objects, without covering anything else.

For the floor in `desim draw`, in `plot.layout` and on the page of a run.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

Box = tuple[float, float, float, float]
"""A rectangle as left, top, right and bottom, in the units of the drawing; y grows downwards."""
Side = tuple[int, int]
"""A direction as its signs along x and y: (0, -1) is above."""
LETTER = 0.62
"""Width of a letter, as a share of the font size."""
_SIDES: tuple[Side, ...] = ((0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1))
_FARTHER = (1.0, 2.5, 4.5)
"""Gaps between an object and its name, in the order in which they are tried, as multiples of the least gap."""


@dataclass(frozen=True)
class Spot:
    """The place of a name on a drawing: its box, and its side of the object (-1: left, 0: above or below, 1: right)."""

    box: Box
    across: int

    @property
    def x(self) -> float:
        """The x at which the text is anchored: its end next to the object, or its middle."""
        left, _, right, _ = self.box
        return (left + right) / 2 - self.across * (right - left) / 2

    @property
    def y(self) -> float:
        """The y of the middle of the text."""
        return (self.box[1] + self.box[3]) / 2


@dataclass
class Sheet:
    """The occupied boxes on a drawing.

    Attributes:
        marks: nodes, slots and names, which no name covers.
        lines: lanes and storage places, which a name covers only if no other spot is free.
    """

    marks: list[Box]
    lines: list[Box] = field(default_factory=list)

    def put(
        self, sizes: Sequence[tuple[float, float]], around: Box, gap: float, side: Side, *, again: bool = False
    ) -> tuple[Spot, int] | None:
        """Find a free spot for a name beside a box, and reserve it.

        Args:
            sizes: width and height of the name, the best size first; a smaller size on the best side is preferred to a
                larger size on another side.
            around: the box of the object.
            gap: the least distance between the two.
            side: the preferred side; the adjacent sides, and larger gaps, are tried next.
            again: whether the name is already shown elsewhere, so that it may not cover lines.

        Returns:
            The spot and the index of its size; None if every spot would cover a mark.
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
    """Return the square around a point with half side `half`."""
    return x - half, y - half, x + half, y + half


def boxes_along(start: tuple[float, float], end: tuple[float, float], pitch: float) -> Iterator[Box]:
    """Yield boxes that cover a line: one box if it is parallel to x or y, else a box for each `pitch` of its length."""
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
