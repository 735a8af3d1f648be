"""The output of a run: one row per event, and tallies, which do not depend on the level of detail.

A row is a plain tuple with the columns of `LogRow` while the simulation runs. `history` reads rows, by the names of
their columns, and `Run.log` shows them as a table. To add a column, add it to `LogRow`, its meaning to `COLUMNS`, and
its value to the methods of `Log` that write it. Each kind of row has an entry in `KINDS`.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import InitVar, dataclass, field
from operator import itemgetter
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol

from desim_warehouse import states
from desim_warehouse._version import __version__
from desim_warehouse.values.frames import typed

if TYPE_CHECKING:
    import pandas as pd

Detail = Literal["all", "moves", "tasks"]
STATES = tuple(states.STATES)
"""Names of the states of a robot; waits in traffic are not among them. `wait`: queueing for a server or a charger."""
NONE = -1
"""No robot, or no task."""

COLUMNS = {
    "time": "when, in the model's time unit",
    "kind": "what happened: see below",
    "robot": "number of the robot, from 0; -1: none",
    "task": "number of the task, in order of release; -1: none",
    "node": "the node it happened at, or that the robot comes to next",
    "edge": "the edge as `A>B`; `delivered`: that of the storage place it was put into, `A>A` of one on a node",
    "value": "a number that depends on the kind",
    "until": "`drive`, `walking`: when the robot, or the picker, will be there; `picking`: when it is handled; "
    "`edge_closed`: when it opens",
    "other": "`collision`: the robot that was waited for; with pods, see below, and `released`: the item; `walking`, "
    "`picking`: the picker; -1: none",
}
"""The meanings of the columns, in their order."""

PLACES = ("enter", "parked", "docked", "cleared")
"""Kinds of rows that change the place of a robot: onto an edge, or off the lanes at a node."""


class LogRow(NamedTuple):
    """A row of the log, with its columns by name."""

    time: float
    kind: str
    robot: int
    task: int
    node: str | None
    edge: tuple[str, str] | None
    value: float | None
    until: float | None
    other: int


class RowKind(NamedTuple):
    """A kind of row: the least detailed `level` of the log that has it, the event, and the meaning of `value`."""

    level: Detail
    meaning: str
    value: str


KINDS = {
    "released": RowKind("tasks", "a task becomes known", "number of the good; -1: it comes from no storage place"),
    "batched": RowKind(
        "tasks",
        "a task is put into a batch, which may be given out; only with `policies.batching`",
        "tasks in the batch",
    ),
    "assigned": RowKind(
        "tasks", "a robot takes up a task: one in its queue when its turn comes, those of a tour all at once", "energy"
    ),
    "returned": RowKind(
        "tasks",
        "a robot recalled to charge, or turned off by a closure, gives its task back, to the front of the list",
        "energy",
    ),
    "delivered": RowKind("tasks", "a task is unloaded; a line is picked, from the pod `other`", "energy"),
    "lifted": RowKind("tasks", "a robot has taken a pod from the storage place `other`", "number of the pod"),
    "stored": RowKind("tasks", "a robot has put a pod down on the storage place `other`", "number of the pod"),
    **{state.name: RowKind("tasks", state.begins, "energy") for state in states.STATES.values()},
    "walking": RowKind(
        "tasks", "the picker `other` sets out for where a robot stops", "distance from the edge's start to there"
    ),
    "picking": RowKind(
        "tasks",
        "the picker `other` begins to handle what a robot has come for",
        "distance from the edge's start to there",
    ),
    "working": RowKind("tasks", "work on a load unit that was put down begins", "time since it was put down"),
    "worked": RowKind("tasks", "a load unit put down in a station has been worked on", "time since it was put down"),
    "recharged": RowKind("tasks", "a charged robot goes out again: counts in C", "energy"),
    "parked": RowKind("tasks", "a robot has entered a bay", "energy"),
    "docked": RowKind("tasks", "a robot has entered a station beside a node", "energy"),
    "cleared": RowKind("tasks", "a broken robot is off the lanes; it comes back at this node", "energy"),
    "rotation": RowKind("tasks", "a full ring of waiting robots turned by one place", "robots in the ring"),
    "enter": RowKind("moves", "a robot's centre leaves a node for this edge", "none"),
    "aside": RowKind(
        "moves", "a robot stands beside its lane, in a wide aisle, and others drive past", "distance from its start"
    ),
    "back": RowKind("moves", "it is on the lane again", "distance from the edge's start"),
    "drive": RowKind(
        "all", "a robot sets off on an edge for a position, there at `until`", "distance from the edge's start"
    ),
    "collision": RowKind("all", "a robot has waited, behind `other` on an `edge` or before a `node`", "how long"),
    **{state.name: RowKind("all", state.begins, "how long") for state in states.APART.values()},
    "edge_closed": RowKind("tasks", "an edge closes by its calendar, until `until`", "none"),
    "edge_opened": RowKind("tasks", "it opens again", "none"),
    "person_in": RowKind("tasks", "a person comes into an aisle, a row for each of its edges", "number of the visit"),
    "person_out": RowKind("tasks", "the person leaves", "number of the visit"),
    "person_rides": RowKind(
        "all",
        "a person has a lift, up to `until`: it comes to `node`, and takes them along `edge`",
        "time since the call",
    ),
    "lift_fails": RowKind("all", "a lift fails with its cabin at `node`, and works again at `until`", "none"),
}
"""The kinds of rows; `energy` is the energy in the robot's battery."""

_MOVES = frozenset(name for name, kind in KINDS.items() if kind.level == "moves")


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
    """The rows of a run at a level of detail, `tasks` (also states and rotations), `moves` or `all`, and its tallies.

    `robots`, `edges`, `nodes` and `stations`: tallies of the evaluation period between `begin` and `end`, a dict for
    each robot, edge, intersection and station; `stations` is None in logs before 0.4.0. `rings`: time, robots and
    edges of each rotation. `due`, `flows`, `orders`: due times, flows and orders of tasks. `energy`: the energy in each
    robot's battery at the end, empty without batteries. `for_workers`: tasks whose load units are worked on in a
    station, noted at their release if they can go nowhere else, or else when they are put down; None in logs before
    0.4.0. `people`: visits, their time, and the time shared with robots; empty without people. `version`: the version
    of desim-warehouse that wrote the log. `finished`: whether the run ended because all its work was done and its
    robots were back; None in logs before 0.4.0.
    """

    level: Detail = "all"
    rows: list[tuple[Any, ...]] = field(default_factory=list)
    rings: list[tuple[float, tuple[int, ...], tuple[str, ...]]] = field(default_factory=list)
    robots: list[dict[str, float]] = field(default_factory=list)
    edges: list[dict[str, Any]] = field(default_factory=list)
    nodes: list[dict[str, Any]] = field(default_factory=list)
    stations: list[dict[str, Any]] | None = field(default_factory=list)
    due: dict[int, float] = field(default_factory=dict)
    flows: dict[int, str] = field(default_factory=dict)
    orders: dict[int, str] = field(default_factory=dict)
    for_workers: set[int] | None = field(default_factory=set)
    energy: list[float] = field(default_factory=list)
    people: dict[str, float] = field(default_factory=dict)
    begin: float = 0.0
    end: float = 0.0
    finished: bool | None = None
    version: str = __version__
    knows_moves: InitVar[bool] = False
    """Whether moves are written at any level, to be read before the log is finished (see `forget_moves`)."""

    def __post_init__(self, knows_moves: bool) -> None:
        """Store the level as booleans, to save the hot path comparisons of strings."""
        self.moves = knows_moves or self.level != "tasks"
        self.everything = self.level == "all"

    def event(
        self,
        time: float,
        kind: str,
        robot: int,
        task: int,
        node: str | None,
        value: float | None,
        *,
        edge: tuple[str, str] | None = None,
        other: int = NONE,
    ) -> None:
        """Write an event of a task or a robot, at the node where the robot is or comes to next."""
        self.rows.append((time, kind, robot, task, node, edge, value, None, other))

    def released(
        self, time: float, task: int, good: int, due: float | None, flow: str = "", order: str = "", item: int = NONE
    ) -> None:
        """Write that a task is released."""
        self.event(time, "released", NONE, task, None, float(good), other=item)
        if due is not None:
            self.due[task] = due
        if flow:
            self.flows[task] = flow
        if order:
            self.orders[task] = order

    def is_for_workers(self, task: int) -> None:
        """Note that people in a station will work on the load unit of a task."""
        assert self.for_workers is not None
        self.for_workers.add(task)

    def batched(self, time: float, tasks: Sequence[int]) -> None:
        """Write that these tasks go on one tour."""
        for task in tasks:
            self.event(time, "batched", NONE, task, None, float(len(tasks)))

    def cross(self, now: float, robot: _Body, lane: _Lane | None, clear: float) -> None:
        """Write that a robot sets out from the stop line of `lane` and leaves the node at `clear` for its next lane."""
        rows, number, task, edge = self.rows, robot.number, robot.task, robot.lane.edge
        if self.everything and lane is not None and lane.out_at > now:
            rows.append((now, "drive", number, task, None, lane.edge, lane.length, lane.out_at, NONE))
        rows.append((clear, "enter", number, task, None, edge, None, None, NONE))
        if self.everything:
            rows.append((robot.since, "drive", number, task, None, edge, robot.target, robot.until, NONE))

    def enter(self, time: float, robot: _Body) -> None:
        """Write that a robot's centre leaves a node for the lane it is now on."""
        self.rows.append((time, "enter", robot.number, robot.task, None, robot.lane.edge, None, None, NONE))

    def aside(self, now: float, robot: _Body) -> None:
        """Write that a robot has left its lane to stand beside it."""
        self._beside("aside", now, robot)

    def back(self, now: float, robot: _Body) -> None:
        """Write that a robot that stood beside its lane is on the lane again."""
        self._beside("back", now, robot)

    def _beside(self, kind: str, now: float, robot: _Body) -> None:
        if self.moves:
            edge, position = robot.lane.edge, robot.target
            self.rows.append((now, kind, robot.number, robot.task, None, edge, position, None, NONE))

    def drive(self, robot: _Body, since: float) -> None:
        """Write that a robot sets off for its target, or drives on to it, at `since`."""
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
        """Write a waiting episode that has just ended, before an intersection (`node`) or behind a robot on `edge`."""
        whom = NONE if other is None else other.number
        self.event(now, "collision", robot.number, robot.task, node, waited, edge=edge, other=whom)

    def kept_out(self, now: float, robot: _Body, wait: str, node: str, edge: tuple[str, str], waited: float) -> None:
        """Write a wait before a node that has just ended, for an edge that was closed or had a person in it."""
        self.event(now, wait, robot.number, robot.task, node, waited, edge=edge)

    def rotation(self, now: float, robots: tuple[int, ...], edges: tuple[str, ...]) -> None:
        """Write that a full ring of robots, on these edges, turned by one position."""
        self.event(now, "rotation", robots[0], NONE, None, float(len(robots)))
        self.rings.append((now, robots, edges))

    def picker(
        self,
        now: float,
        kind: str,
        picker: int,
        robot: int,
        task: int,
        node: str,
        edge: tuple[str, str],
        offset: float,
        until: float,
    ) -> None:
        """Write that a picker sets out for a stop of a robot, or begins to handle its load unit (`kind`)."""
        self.rows.append((now, kind, robot, task, node, edge, offset, until, picker))

    def closed(self, edge: tuple[str, str], begin: float, until: float) -> None:
        """Write that an edge closes by its calendar, and that it opens again."""
        self.rows.append((begin, "edge_closed", NONE, NONE, None, edge, None, until, NONE))
        self.event(until, "edge_opened", NONE, NONE, None, None, edge=edge)

    def visit(self, number: int, edges: Iterable[tuple[str, str]], begin: float, end: float) -> None:
        """Write that a person comes into an aisle, and leaves."""
        for edge in edges:
            for time, kind in ((begin, "person_in"), (end, "person_out")):
                self.event(time, kind, NONE, NONE, None, float(number), edge=edge)

    def person_rides(self, begin: float, edge: tuple[str, str], waited: float, until: float) -> None:
        """Write that a person uses a lift, from when the cabin sets out to them until its doors close behind them."""
        if self.everything:
            self.rows.append((begin, "person_rides", NONE, NONE, edge[0], edge, waited, until, NONE))

    def lift_fails(self, begin: float, node: str, until: float) -> None:
        """Write that a lift is out of order, with its cabin at a node."""
        if self.everything:
            self.rows.append((begin, "lift_fails", NONE, NONE, node, None, None, until, NONE))

    def of(self, *kinds: str) -> Iterator[LogRow]:
        """Iterate over the rows of some kinds, in order of time if the log is closed."""
        return map(LogRow._make, [row for row in self.rows if row[1] in kinds])

    def written(self) -> int:
        """Return the number of rows so far."""
        return len(self.rows)

    def forget_moves(self) -> None:
        """Remove moves that the level of the log does not include."""
        if self.level == "tasks":
            self.rows = [row for row in self.rows if row[1] not in _MOVES]

    def close(self, end: float) -> None:
        """Close the log at the end of a run: sort rows by time, and remove rows announced for later."""
        self.end = end
        self.rows.sort(key=itemgetter(0))
        del self.rows[bisect_right(self.rows, end, key=itemgetter(0)) :]

    def named_rows(self) -> Iterator[LogRow]:
        """Iterate over the rows, with their columns by name."""
        return map(LogRow._make, self.rows)

    def frame(self) -> pd.DataFrame:
        """Return the rows as a table with the columns of `LogRow`: edges as `A>B`, -1 for no robot, task or other."""
        import pandas as pd

        table = pd.DataFrame.from_records(self.rows, columns=list(LogRow._fields))
        table["edge"] = [None if edge is None else f"{edge[0]}>{edge[1]}" for edge in table["edge"]]
        columns = {"kind": str, "node": str, "edge": str, "robot": int, "task": int, "other": int}
        return typed(table, {**columns, "time": float, "value": float, "until": float})
