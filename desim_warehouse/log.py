"""What leaves a run: one row per event, kept as plain tuples and shown as a DataFrame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("time", "kind", "robot", "task", "node", "edge", "value", "until", "other")
"""Columns of the log; see docs for each kind's meaning."""


class Log:
    """Rows of a run: `tasks` keeps what happens to tasks, robots' states and gridlock rotations;
    `moves` adds every edge entered; `all` adds every stretch driven and every collision.
    """

    def __init__(self, level: Literal["all", "moves", "tasks"] = "all") -> None:
        self.level = level
        self.moves = level != "tasks"
        self.everything = level == "all"
        self.rows: list[tuple[Any, ...]] = []
        self.append = self.rows.append

    def event(self, time: float, kind: str, robot: Any, task: int, node: str | None = None, value: float | None = None) -> None:
        self.append((time, kind, -1 if robot is None else robot.number, task, node, None, value, None, None))

    def cross(self, now: float, robot: Any, lane: Any, clear: float) -> None:
        number, task = robot.number, robot.task
        if self.everything and lane is not None:
            self.append((now, "drive", number, task, None, lane.edge, lane.length, robot.since, None))
        self.append((clear, "enter", number, task, None, robot.lane.edge, None, None, None))
        if self.everything:
            self.append((robot.since, "drive", number, task, None, robot.lane.edge, robot.target, robot.until, None))

    def drive(self, robot: Any) -> None:
        self.append((robot.since, "drive", robot.number, robot.task, None, robot.lane.edge, robot.target, robot.until, None))

    def collision(self, time: float, robot: Any, other: Any, place: Any, duration: float) -> None:
        other = None if other is None else other.number
        if hasattr(place, "edge"):
            self.append((time, "collision", robot.number, robot.task, None, place.edge, duration, None, other))
        else:
            self.append((time, "collision", robot.number, robot.task, place.name, None, duration, None, other))

    def rotation(self, time: float, ring: list[Any]) -> None:
        self.append((time, "rotation", ring[0].number, -1, None, None, float(len(ring)), None, None))
