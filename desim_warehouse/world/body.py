"""Where a robot is and what it has committed to: all that traffic knows of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simpy.events import Event

    from desim_warehouse.world.lanes import Claim, Intersection, Lane


class Body:
    """A robot on the floor.

    It is in one of three places: in a bay (`lane` None, `at` its node), on a lane (`held` None), or on an
    intersection, whose `held` it is, at the end of the lane that it came by. `target` is the position on
    the lane that it is sure to reach without asking for more, `until` the time when it is there; it drives
    there from `origin` at `since`. `trailing` is an intersection behind it that it has not yet cleared.
    """

    __slots__ = (
        "ahead",
        "at",
        "behind",
        "came_by",
        "claim",
        "crossings",
        "distance",
        "gap",
        "granted",
        "held",
        "lane",
        "mark",
        "moves",
        "number",
        "origin",
        "pace",
        "pos",
        "rear_ends",
        "recalled",
        "since",
        "speed",
        "target",
        "task",
        "trailing",
        "until",
        "waited",
        "waiting_behind",
        "waiting_since",
    )

    def __init__(self, number: int, speed: float, gap: float, at: Intersection) -> None:
        self.number = number
        self.speed = self.pace = speed
        self.gap = gap
        self.at = at
        self.lane: Lane | None = None
        self.came_by: Lane | None = None
        self.held: Intersection | None = None
        self.trailing: Intersection | None = None
        self.granted: Lane | None = None
        self.ahead: Body | None = None
        self.behind: Body | None = None
        self.pos = self.target = self.origin = 0.0
        self.since = self.until = 0.0
        self.claim: Claim | None = None
        self.waiting_behind: Event | None = None
        self.waiting_since = 0.0
        self.recalled = False
        self.mark = 0
        self.task = -1
        self.moves = 0
        self.distance = 0.0
        self.waited = 0.0
        self.rear_ends = self.crossings = 0

    def passes(self, position: float) -> float:
        """The time at which it passes `position` on its lane, no farther than its target; the past if it has."""
        if position <= self.origin:
            return self.since if self.since > 0 and position > self.pos else 0.0
        return self.since + (position - self.origin) / self.pace

    def place(self) -> str:
        """Where it is, in words."""
        if self.lane is None:
            return f"in the bay at {self.at.name}"
        if self.held is not None and self.pos >= self.lane.length:
            return f"on node {self.lane.edge[1]}"
        return f"on edge {self.lane.edge[0]}>{self.lane.edge[1]} at {self.pos:g}"
