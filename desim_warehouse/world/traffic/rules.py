"""The collision rule of the paper as distances: headway D, the closing distance behind a robot, and the tolerance.

Robot i stops for robot j if j is nearer than D = r_i + r_j + margin and within the collision angle theta of i's heading
(Liu et al. 2017, collision waiting). On a lane this is a headway of D. At an intersection it closes the node behind a
departing robot until that is a distance away, given by this module.
"""

from __future__ import annotations

import cmath
import math
from functools import lru_cache

EPS = 1e-6
"""Tolerance: lengths and times closer than this are equal, and ties do not count as waiting."""


@lru_cache(maxsize=10_000)
def closing_distance(angle: float, theta: float, headway: float, approach: float) -> float:
    """Return how far beyond a node a robot must be before the next may start from `approach` before the node.

    `angle` is between the headings of the next robot and the one that leaves, `theta` the collision angle (both in
    radians). With x to go and the other y beyond the node, the next robot would stop for some x on its way iff x + y <
    g. By the law of sines g = D cos(angle/2 - a) / cos(angle/2) with a = min(theta, angle/2). At right angles this is D
    (cos a + sin a), straight on it is D. The same law holds for robots that follow each other round a corner: exempting
    them makes S 11 % too low and lets robots overlap. The distance never exceeds D, where the robot that left may stand
    and counts as clear of the node. Results are cached for all runs.
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
    """Return `closing_distance` for two nodes of one intersection: the first robot's is at `shift` from the next one's.

    The two paths do not meet in a point, so the largest x + y at which the next robot would stop is found on a grid of
    x and y, on the safe side by half a grid step, and cached for all runs of a study. `comes` and `leaves` are the
    headings of the next robot and of the one that left, which drives at least `ratio` while the next drives 1.
    """
    steps = 40
    near = (approach + headway) / steps / 2
    # The place of the departing robot, and its heading, as seen by the one that comes (ahead is the real axis).
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
