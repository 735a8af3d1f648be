"""What leaves a run: one row per event, and the tallies that hold whatever the level of detail.

Rows are plain tuples while the simulation runs and become a DataFrame when somebody looks. Kinds of rows:

    released                                a task is known; `value` is the number of its good
    assigned returned delivered             its life (`returned`: given back by a robot that was called home)
    the STATES                              a robot begins to do this; `value` is its energy
    recharged                               a robot that was charged goes out again: counts in C
    parked docked                           a robot is back in a bay, or in a station beside a node
    rotation                                a full ring of `value` robots turned; `ring` tells which, where
    enter                                   a robot enters an edge (levels `moves` and `all`)
    drive                                   it sets off on an edge for position `value`, there `until` (`all`)
    collision                               it has waited `value` for robot `other` on an edge or at a node (`all`)
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Protocol

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("time", "kind", "robot", "task", "node", "edge", "value", "until", "other")
STATES = ("idle", "empty", "loading", "loaded", "queueing", "unloading", "returning", "charging")
"""What a robot is doing; the time it waits in traffic meanwhile is kept apart. It queues for a server or a charger."""
NONE = -1
"""Stands for no robot or no task."""


class _Lane(Protocol):
    edge: tuple[str, str]
    length: float
    out_at: float


class _Body(Protocol):
    number: int
    task: int
    lane: Any
    target: float
    since: float
    until: float


@dataclass
class Log:
    """The rows of a run at a level of detail: `tasks` (also states and rotations), `moves`, or `all`.

    `robots`, `edges` and `nodes` are the tallies of the counted part of the run: one dict of plain numbers for
    each robot, edge and intersection, counted between `begin` and `end`. `due` holds the due times of tasks.
    """

    level: Literal["all", "moves", "tasks"] = "all"
    rows: list[tuple[Any, ...]] = field(default_factory=list)
    rings: list[tuple[float, tuple[int, ...], tuple[str, ...]]] = field(default_factory=list)
    robots: list[dict[str, float]] = field(default_factory=list)
    edges: list[dict[str, Any]] = field(default_factory=list)
    nodes: list[dict[str, Any]] = field(default_factory=list)
    due: dict[int, float] = field(default_factory=dict)
    begin: float = 0.0
    end: float = 0.0

    def __post_init__(self) -> None:
        """Spare the hot path a comparison of words."""
        self.moves = self.level != "tasks"
        self.everything = self.level == "all"

    def event(self, time: float, kind: str, robot: int, task: int, node: str | None, value: float | None) -> None:
        """Something that happened to a task or a robot, at the node it is at or comes to next."""
        self.rows.append((time, kind, robot, task, node, None, value, None, NONE))

    def released(self, time: float, task: int, good: int, due: float | None) -> None:
        """A new task is known."""
        self.event(time, "released", NONE, task, None, float(good))
        if due is not None:
            self.due[task] = due

    def cross(self, now: float, robot: _Body, lane: _Lane | None, clear: float) -> None:
        """A robot sets out from the stop line of `lane` and leaves the node at `clear` for the lane it is now on."""
        if self.everything and lane is not None and lane.out_at > now:
            row = (now, "drive", robot.number, robot.task, None, lane.edge, lane.length, lane.out_at, NONE)
            self.rows.append(row)
        self.enter(clear, robot)
        if self.everything:
            self.drive(robot, robot.since)

    def enter(self, time: float, robot: _Body) -> None:
        """A robot's centre leaves a node for the lane it is now on."""
        self.rows.append((time, "enter", robot.number, robot.task, None, robot.lane.edge, None, None, NONE))

    def drive(self, robot: _Body, since: float) -> None:
        """A robot sets off at `since`, or drives on from then, for its target."""
        row = (since, "drive", robot.number, robot.task, None, robot.lane.edge, robot.target, robot.until, NONE)
        self.rows.append(row)

    def collision(
        self,
        now: float,
        robot: _Body,
        other: _Body | None,
        node: str | None,
        edge: tuple[str, str] | None,
        waited: float,
    ) -> None:
        """A waiting episode that has just ended, at an intersection (`node`) or behind a robot on an `edge`."""
        whom = NONE if other is None else other.number
        self.rows.append((now, "collision", robot.number, robot.task, node, edge, waited, None, whom))

    def rotation(self, now: float, robots: tuple[int, ...], edges: tuple[str, ...]) -> None:
        """A full ring of robots, on these edges, that turned by one place."""
        self.rows.append((now, "rotation", robots[0], NONE, None, None, float(len(robots)), None, NONE))
        self.rings.append((now, robots, edges))

    def close(self, end: float) -> None:
        """The run is over: put rows in order of time, without what was only announced for later."""
        self.end = end
        self.rows = sorted((row for row in self.rows if row[0] <= end), key=lambda row: row[0])

    def frame(self) -> pd.DataFrame:
        """The rows as a table with the columns of `COLUMNS`; edges as `A>B`, robot, task and other -1 if none."""
        import pandas as pd

        table = pd.DataFrame.from_records(self.rows, columns=list(COLUMNS))
        table["edge"] = [None if edge is None else f"{edge[0]}>{edge[1]}" for edge in table["edge"]]
        for column in ("time", "value", "until"):
            table[column] = table[column].astype(float)
        return table
