"""The collision rule of the paper as distances: headway D, the closing distance behind a robot, and the tolerance.

Robot i stops for robot j if j is nearer than D = r_i + r_j + margin and within the collision angle theta of i's
heading (Liu et al. 2017, collision waiting). On a lane this is a headway of D. At an intersection it closes the node
for a while behind a robot that leaves it: this module says for how far.
"""

from __future__ import annotations

import cmath
import math
from functools import lru_cache

EPS = 1e-6
"""Lengths and times closer than this are the same: ties do not count as waiting."""


def exact_length(length: float, headway: float) -> float:
    """Return a lane's length, or D or 2 D where it is within the tolerance of them.

    Lanes of at least D, and of at least 2 D, obey other rules than shorter ones. Which rule holds must not depend on
    rounding, and a lane that is one by the tolerance only has stop lines that do not fit it.
    """
    for exact in (headway, 2 * headway):
        if abs(length - exact) <= EPS:
            return exact
    return length


@lru_cache(maxsize=10_000)
def closing_distance(angle: float, theta: float, headway: float, approach: float) -> float:
    """Return how far a robot must be beyond a node before the next may start towards it from `approach` before it.

    `angle` is between the headings of the one that comes and the one that leaves, `theta` the collision angle (both in
    radians). With x to go and the other y beyond the node, the one that comes would stop for some x on its way iff x +
    y < g. By the law of sines g = D cos(angle/2 - a) / cos(angle/2) with a = min(theta, angle/2). At right angles this
    is D (cos a + sin a), straight on it is D. The same law holds for robots that follow each other round a corner:
    exempting them makes S 11 % too low and lets robots overlap. Never more than D: there the robot that left may stand,
    and counts as clear of the node. Kept for all runs.
    """
    half = min(abs(angle), math.pi) / 2
    if half > math.pi / 2 - 1e-3:  # turning back: the formula's denominator vanishes
        return headway
    gap = headway * math.cos(half - min(theta, half)) / math.cos(half)
    return min(max(gap - approach, 0.0), headway)


@lru_cache(maxsize=10_000)
def closing_distance_apart(
    shift: complex, comes: float, leaves: float, theta: float, headway: float, approach: float, ratio: float
) -> float:
    """Return `closing_distance` for two nodes of one intersection: the robot left at `shift` from the next one's.

    The two paths do not meet in a point, so the largest x + y at which the next one would stop is found by trying a
    grid of x and y, on the safe side by half a grid step. It is kept for all runs of a study. `comes` and `leaves` are
    headings. While the one that comes drives 1, the other drives at least `ratio`.
    """
    steps = 40
    near = (approach + headway) / steps / 2
    # The place of the robot that leaves, and its heading, as the one that comes sees them (ahead is the real axis).
    seen, away = shift * cmath.rect(1, -comes), cmath.rect(1, leaves - comes)
    gap = headway
    for x in (approach * i / steps for i in range(steps + 1)):
        for y in (headway * i / steps for i in range(steps + 1)):
            other = seen + x + y * away
            in_view = other.real > -near and abs(other.imag) * math.cos(theta) - other.real * math.sin(theta) < near
            if in_view and abs(other) < headway + near:
                gap = max(gap, y + x * ratio + near)
    return min(max(gap - approach * ratio, 0.0), headway)


def turn(heading: float, onward: float) -> float:
    """Return the angle between two headings, 0..pi."""
    return abs((heading - onward + math.pi) % (2 * math.pi) - math.pi)
