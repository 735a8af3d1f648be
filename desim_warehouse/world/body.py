"""Where a robot is and what it has committed to: all that traffic knows of it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.world.lanes import Claim, Intersection, Lane
    from desim_warehouse.world.trip import Trip


class Body:
    """A robot on the floor.

    It is in one of three places: in a bay (`lane` None, `at` its node), on a lane (`held` None), or on an
    intersection that it holds, at the end of the lane that it came by. It drives from `pos`, where it looked
    last, to `target`, the position on the lane that it is sure to reach without asking for more; it sets off
    at `since` and is there at `until`.
    `train_pace` bounds its pace on the next lane, when it turns with a ring of slower robots.
    From `recall_at` on it is wanted elsewhere: it stops on the next node that it comes to.
    """

    __slots__ = (
        "ahead",
        "at",
        "behind",
        "claim",
        "crossings",
        "detours",
        "driven",
        "goal",
        "granted",
        "held",
        "lane",
        "mark",
        "moves",
        "number",
        "pace",
        "pos",
        "rear_ends",
        "recall_at",
        "since",
        "speed",
        "target",
        "task",
        "train_pace",
        "until",
        "waited",
        "waiting_behind",
        "waiting_since",
        "waits_for",
    )

    def __init__(self, number: int, speed: float, at: Intersection) -> None:
        self.number = number
        self.speed = self.pace = speed
        self.at = at
        self.lane: Any = None  # a Lane; typed loosely, as the hot path knows when there is one
        self.held: Any = None  # an Intersection
        self.granted: Lane | None = None
        self.ahead: Body | None = None
        self.behind: Body | None = None
        self.pos = self.target = self.goal = 0.0
        self.since = self.until = -math.inf
        self.claim: Claim | None = None
        self.waiting_behind: Trip | None = None
        self.waiting_since = 0.0
        self.waits_for: Body | None = None
        self.recall_at = self.train_pace = math.inf
        self.mark = 0
        self.detours = 0
        self.task = -1
        self.moves = self.rear_ends = self.crossings = 0
        self.driven = self.waited = 0.0

    def passes(self, position: float) -> float:
        """The time at which it passes `position` on its lane, no farther than its target; the past if it has."""
        if position <= self.pos:
            return self.since if position == self.pos else -math.inf
        return self.until - (self.target - position) / self.pace

    @property
    def is_waiting(self) -> bool:
        """Whether it waits in traffic now."""
        return self.claim is not None or self.waiting_behind is not None

    def waited_by(self, now: float) -> float:
        """Time waited in traffic so far, the present episode included."""
        return self.waited + (now - self.waiting_since if self.is_waiting else 0.0)

    def distance(self, now: float) -> float:
        """Length driven so far."""
        return self.driven + self.position(now)

    def left_bay(self) -> None:
        """It has just left the bay it stood in."""

    def detour(self, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:  # noqa: ARG002
        """Another way for a robot held up before `route[index]`; None: it waits. Asked while `detours` are left."""
        return None

    def stands(self, waiting: bool) -> None:
        """It begins (or ends) to wait in traffic."""

    def position(self, now: float) -> float:
        """Where it is on its lane."""
        if now >= self.until:
            return self.target
        return max(self.pos, self.target - (self.until - max(now, self.since)) * self.pace)

    def place(self, now: float) -> str:
        """Where it is, in words."""
        if self.lane is None:
            return f"in the bay at {self.at.name}"
        if self.held is not None and self.position(now) >= self.lane.length:
            return f"on node {self.lane.edge[1]}"
        return f"on edge {self.lane.edge[0]}>{self.lane.edge[1]} at {self.position(now):g}"
