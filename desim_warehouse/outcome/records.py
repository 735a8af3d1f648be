"""Records of a run, with named fields: its tasks, orders, states, waits and whereabouts.

`History` makes them from the log; indicators, figures, replay and exports read them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from desim_warehouse.states import WAITING, State, seen

Edge: TypeAlias = tuple[str, str]


class Deadline(NamedTuple):
    """A deadline: when something was due, and when it was done (inf: not by the end of the run)."""

    due: float
    done: float

    @property
    def missed(self) -> bool:
        """Whether the deadline passed before it was done."""
        return self.done > self.due

    def overrun(self, end: float) -> float:
        """Return the lateness: 0 if it was done in time, and up to `end` if it was not done by then."""
        return max(min(self.done, end) - self.due, 0.0)


@dataclass(slots=True)
class TaskHistory:
    """When a task was released, loaded, delivered and done (inf: never), where, and when it was due (None: never).

    `batched`: when it was put into a batch (inf: never). `begun`, `worked`: when work on its load unit in the station
    began and ended (inf: not yet, or there is none). `done`: when it was delivered, or worked on where
    `tasks.done_when` says so. `station`: the node of its delivery, which was into a storage place there if it is
    `stored`.
    """

    number: int
    good: int
    released: float
    due: float | None
    batched: float = math.inf
    loaded: float = math.inf
    delivered: float = math.inf
    begun: float = math.inf
    worked: float = math.inf
    done: float = math.inf
    station: str = ""
    stored: bool = False
    flow: str = ""
    order: str = ""

    @property
    def cycle_time(self) -> float:
        """The time from the task's release until it was done."""
        return self.done - self.released

    @property
    def deadline(self) -> Deadline | None:
        """When the task was due, and done; None if it was not due."""
        return None if self.due is None else Deadline(self.due, self.done)

    @property
    def work_deadline(self) -> Deadline | None:
        """When the work on its load unit was due, and done; None if it was not due."""
        return None if self.due is None else Deadline(self.due, self.worked)


class OrderHistory(NamedTuple):
    """An order: its tasks, when the first of them was released, and when the last was done (inf: never)."""

    flow: str
    order: str
    tasks: tuple[TaskHistory, ...]

    @property
    def released(self) -> float:
        """When the order's first task was released."""
        return min(task.released for task in self.tasks)

    @property
    def done(self) -> float:
        """When the order's last task was done (inf: never)."""
        return max(task.done for task in self.tasks)

    @property
    def cycle_time(self) -> float:
        """The time from the order's release until the whole of it was done."""
        return self.done - self.released

    @property
    def deadline(self) -> Deadline | None:
        """When the order was due and done: late from the first instant at which a task is; None if no task was due."""
        deadlines = [task.deadline for task in self.tasks if task.deadline is not None]
        if not deadlines:
            return None
        missed = [deadline.due for deadline in deadlines if deadline.missed]
        return Deadline(
            min(missed) if missed else max(deadline.due for deadline in deadlines),
            max(deadline.done for deadline in deadlines),
        )


class StateSpan(NamedTuple):
    """A robot in one state from `start` to `end`, with its task (-1: none), its energy and node at the start.

    `energy` is None without batteries. `node`: where the robot is, or comes to next.
    """

    robot: int
    state: str
    start: float
    end: float
    task: int
    energy: float | None
    node: str

    @property
    def seen(self) -> State:
        """The state as it is shown: queueing for a server is another than for a charger."""
        return seen(self.state, self.task)


class Assignment(NamedTuple):
    """A robot with a task from its assignment to its delivery or return (`ended`, or `open` at the end of the run)."""

    robot: int
    task: int
    start: float
    end: float
    ended: str


class Trip(NamedTuple):
    """A robot with the tasks that it does together, from their assignment to the last delivery."""

    robot: int
    tasks: tuple[int, ...]
    start: float
    end: float


class Wait(NamedTuple):
    """An episode of waiting in traffic: `robot` waits for `other` (-1: none) before `node`, or behind it on `edge`.

    `on` is the edge on which it stands, None in a bay or station. `cause` is `waiting` for a collision, else what it
    waits for before `node`, by its name in `states.APART`, to enter the edge `into`.
    """

    robot: int
    other: int
    start: float
    end: float
    node: str | None
    edge: Edge | None
    on: Edge | None
    cause: str = WAITING.name
    into: Edge | None = None


class PickerSpan(NamedTuple):
    """A picker at work for a robot from `start` to `end`: on the way to its stop, or (`picks`) handling what it loads.

    The stop is `offset` beyond the start of `edge`. `end` may lie after the end of the run.
    """

    picker: int
    robot: int
    task: int
    start: float
    end: float
    picks: bool
    edge: Edge
    offset: float


class ChargeSpan(NamedTuple):
    """A robot at a charger from `start` to `end`, with its energy before and after."""

    robot: int
    start: float
    end: float
    before: float
    after: float


class Whereabouts(NamedTuple):
    """Where a robot is from `start` on: on an `edge`, or (None) in a bay or station beside `node`.

    It is on an edge until its centre leaves the node at the edge's end, or until it is in the bay or station there.
    """

    start: float
    edge: Edge | None
    node: str


class Blocked(NamedTuple):
    """An edge that no robot enters from `start` to `end`: closed by calendar, or with the person of a `visit` in it.

    `visit` is -1 for a calendar.
    """

    edge: Edge
    start: float
    end: float
    visit: int


class Rotation(NamedTuple):
    """A full ring of robots that turned by one position, and the edges that they were on (`A>B`, "" in a bay)."""

    time: float
    robots: tuple[int, ...]
    edges: tuple[str, ...]
