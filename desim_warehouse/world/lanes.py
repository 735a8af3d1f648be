"""What robots reserve: lanes (the one-way edges) and intersections (the nodes between them)."""

from __future__ import annotations

import cmath
import math
from functools import lru_cache
from heapq import heappush
from typing import TYPE_CHECKING

from simpy.events import NORMAL, Event

if TYPE_CHECKING:
    from simpy import Environment

    from desim_warehouse.layout import Layout
    from desim_warehouse.world.body import Body

EPS = 1e-6
"""Lengths and times closer than this are the same: ties do not count as waiting."""


class Lane:
    """A one-way edge of the Highways: robots queue on it in order, none overtakes.

    `last` is the robot that entered last and is still on it. `entering` is set while a robot that was granted
    room has not yet set out for it; `wanted` counts the waiting claims for room on it. A *short* lane has no
    place to stand clear of both its ends (length < 2 D): a robot on it holds its end. An *inside* lane joins two
    nodes of one intersection.
    """

    __slots__ = (
        "blocked",
        "edge",
        "end",
        "entering",
        "heading",
        "inside",
        "last",
        "length",
        "limit",
        "out_at",
        "out_pace",
        "passages",
        "short",
        "start",
        "stop_line",
        "waits",
        "wanted",
    )

    def __init__(self, edge: tuple[str, str], length: float, limit: float, heading: float) -> None:
        self.edge = edge
        self.length = length
        self.limit = limit
        self.heading = heading
        self.start: Intersection
        self.end: Intersection
        self.stop_line = 0.0
        self.short = self.inside = False
        self.last: Body | None = None
        self.entering = False
        self.wanted = 0
        self.out_at = -math.inf
        self.out_pace = 1.0
        self.passages = self.waits = 0
        self.blocked = 0.0

    def clear_stop(self, stop: float, contact: float) -> float:
        """Where a robot stops that wants to stop at `stop`: D clear of the nodes, so that it keeps nobody off them."""
        if self.inside:
            return stop
        return max(stop if self.short else min(stop, self.stop_line), contact)


class Intersection:
    """One node, or several nodes too close together to be used at once.

    A robot that stands on it, or is about to, is its `holder`. One that passes leaves its centre at `left_at`
    (known as soon as it sets out, so often in the future) for the lane `left_on` at a pace; until then it is
    closed to all others, and afterwards to those whose path would come too close: at most until that one is D beyond.
    """

    __slots__ = (
        "blocked",
        "claims",
        "holder",
        "left_at",
        "left_on",
        "left_pace",
        "name",
        "nodes",
        "outs",
        "reopens",
        "user",
        "waits",
    )

    def __init__(self, name: str) -> None:
        self.name = name
        self.nodes = [name]
        self.holder: Body | None = None
        self.user: Body | None = None
        self.claims: list[Claim] = []
        self.left_at = -math.inf
        self.left_pace = 1.0
        self.left_on: Lane | None = None
        self.reopens = math.inf
        self.outs: list[Lane] = []
        self.waits = 0
        self.blocked = 0.0

    @property
    def passages(self) -> int:
        """Robots that left it along a lane."""
        return sum(lane.passages for lane in self.outs)

    def left_by(self, robot: Body, lane: Lane, time: float) -> None:
        """A robot's centre leaves it for a lane at `time`; the last to do so counts."""
        if time >= self.left_at:
            self.user = robot
            self.left_at = time
            self.left_on = lane
            self.left_pace = robot.pace


class Arrival(Event):
    """Due at a time known beforehand: a timeout, but to the exact instant and at less cost."""

    def __init__(self, env: Environment, time: float) -> None:
        self.env = env
        self.callbacks = []
        self._value = None
        self._ok = True
        heappush(env._queue, (time, NORMAL, next(env._eid), self))


class Claim(Event):
    """A robot's wish for an intersection and, with it or not at all, for room on the lane beyond.

    It is an event: the robot yields it and goes on when it is granted. `lane` None: the intersection alone.
    `via` is the lane by which it comes (None: from the bay beside it).
    """

    def __init__(self, env: Environment, robot: Body, node: Intersection, lane: Lane | None, via: Lane | None) -> None:
        super().__init__(env)
        self.robot = robot
        self.node = node
        self.lane = lane
        self.via = via


def closing_distance(angle: float, theta: float, contact: float, approach: float) -> float:
    """How far a robot must be beyond a node before the next may start towards it from `approach` before it.

    `angle` is between the heading of the one that comes and of the one that leaves (radians), `contact` is D.
    The one that comes would stop if the other were nearer than D and within theta of its heading. With x to
    go and the other y beyond the node this happens for some x on the way iff x + y < g, by the law of sines
    g = D cos(angle/2 - a) / cos(angle/2) with a = min(theta, angle/2); at right angles g = D (cos a + sin a).
    Never more than D: there the leaving robot may stand, and is clear of the node.
    """
    half = min(abs(angle), math.pi) / 2
    if half > math.pi / 2 - 1e-3:  # turning back
        return contact
    gap = contact * math.cos(half - min(theta, half)) / math.cos(half)
    return min(max(gap - approach, 0.0), contact)


@lru_cache(maxsize=10_000)
def closing_apart(
    shift: complex, comes: float, leaves: float, theta: float, contact: float, approach: float, ratio: float
) -> float:
    """The same for two nodes of one intersection: the one that leaves did so `shift` from where the next one comes to.

    Found by trial of x and y, once for all runs of a study, on the safe side by a step or two; `ratio` is how far the
    one that leaves drives, at least, while the other drives 1.
    """
    steps = 40
    near = (approach + contact) / steps / 2  # how far apart any x, y and those tried are
    seen, away = shift * cmath.rect(1, -comes), cmath.rect(1, leaves - comes)  # by the one that comes, ahead of it
    gap = contact
    for x in (approach * i / steps for i in range(steps + 1)):
        for y in (contact * i / steps for i in range(steps + 1)):
            other = seen + x + y * away
            in_view = other.real > -near and abs(other.imag) * math.cos(theta) - other.real * math.sin(theta) < near
            if in_view and abs(other) < contact + near:
                gap = max(gap, y + x * ratio + near)
    return min(max(gap - approach * ratio, 0.0), contact)


def turn(one: float, other: float) -> float:
    """The angle between two headings, 0..pi."""
    return abs((one - other + math.pi) % (2 * math.pi) - math.pi)


def network(layout: Layout, contact: float) -> tuple[dict[tuple[str, str], Lane], dict[str, Intersection]]:
    """Lanes by edge and intersections by node, for robots that keep `contact` (D) apart.

    Nodes joined by an edge shorter than D cannot both be occupied and become one intersection.
    """
    nodes = {name: Intersection(name) for name in layout.graph}
    edges = list(layout.graph.edges(data=True))
    for source, target, data in edges:
        one, other = nodes[source], nodes[target]
        if data["length"] < contact - EPS and one is not other:
            one.nodes += other.nodes
            for name in other.nodes:
                nodes[name] = one
    lanes = {}
    same: dict[float, float] = {}  # equal lengths as one object, so that thousands of lanes use less of the cache
    for source, target, data in edges:
        length = same.setdefault(data["length"], data["length"])
        lane = Lane((source, target), length, data["speed"], layout.heading((source, target)))
        lane.start, lane.end = nodes[source], nodes[target]
        lane.start.outs.append(lane)
        lane.short = lane.length < 2 * contact - EPS
        lane.inside = lane.short and lane.start is lane.end
        stop_line = 0.0 if lane.short else lane.length - contact
        lane.stop_line = same.setdefault(stop_line, stop_line)
        lanes[source, target] = lane
    return lanes, nodes
