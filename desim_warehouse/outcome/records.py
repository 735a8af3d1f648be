"""Records of a run: its tasks, orders, states, waits and whereabouts.

`History` makes records from the log; indicators, figures, replay and exports read them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from desim_warehouse.states import WAITING, State, seen

Edge: TypeAlias = tuple[str, str]


class Deadline(NamedTuple):
    """A deadline of a task, load unit or order: its due time, and when it was done (inf: not by the end of the run)."""

    due: float
    done: float

    @property
    def missed(self) -> bool:
        """Whether the deadline passed before the task, load unit or order was done."""
        return self.done > self.due

    def overrun(self, end: float) -> float:
        """Return the tardiness: 0 if done in time, and the time up to `end` if not done by then."""
        return max(min(self.done, end) - self.due, 0.0)


@dataclass(slots=True)
class TaskHistory:
    """The times of a task: released, loaded, delivered and done (inf: never), and due (None: no due time).

    `batched`: when the task was put into a batch (inf: never). `begun`, `worked`: when work on its load unit in the
    station began and ended (inf: not yet, or no work). `done`: when the task was delivered or, with
    `tasks.done_when: worked`, worked on. `station`: the node of its delivery. `stored`: whether it was put into a
    storage place there.
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
        """The deadline of the task; None without a due time."""
        return None if self.due is None else Deadline(self.due, self.done)

    @property
    def work_deadline(self) -> Deadline | None:
        """The deadline of the work on the task's load unit; None without a due time."""
        return None if self.due is None else Deadline(self.due, self.worked)


class OrderHistory(NamedTuple):
    """An order: the tasks that belong together, and their flow."""

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
        """The time from the order's release until its last task was done."""
        return self.done - self.released

    @property
    def deadline(self) -> Deadline | None:
        """The deadline of the order; None if no task has a due time.

        An order is due with the first of its tasks that misses its due time, or else with the last task.
        """
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
        """The state as shown, which distinguishes queues for servers from queues for chargers."""
        return seen(self.state, self.task)


class Assignment(NamedTuple):
    """A robot with a task, from assignment to delivery or return.

    `ended`: `delivered` or `returned`, or `open` at the end of the run.
    """

    robot: int
    task: int
    start: float
    end: float
    ended: str


class Trip(NamedTuple):
    """A robot with the tasks of one tour, from their assignment to the last delivery."""

    robot: int
    tasks: tuple[int, ...]
    start: float
    end: float


class Wait(NamedTuple):
    """An episode of waiting in traffic: `robot` waits for `other` (-1: none) before `node`, or behind it on `edge`.

    `on`: the edge on which the robot stands, None in a bay or station. `cause`: `waiting` for a collision, or else the
    reason for which it waits before `node` to enter the edge `into`, by its name in `states.APART`.
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
    """A picker at work for a robot from `start` to `end`: walking to its stop or, if `picks`, handling its load unit.

    The stop is `offset` length units beyond the start of `edge`. `end` may be after the end of the run.
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
    """The place of a robot from `start` on: on an `edge`, or in a bay or station beside `node` if `edge` is None.

    A robot is on an edge until its centre leaves the node at the edge's end, or until it is in a bay or station there.
    """

    start: float
    edge: Edge | None
    node: str


class Blocked(NamedTuple):
    """An edge that no robot enters from `start` to `end`, as a calendar closes it or a person is in it.

    `visit`: number of the person's visit; -1 for a calendar.
    """

    edge: Edge
    start: float
    end: float
    visit: int


class Rotation(NamedTuple):
    """A full ring of robots that turned by one position, and the edges of the robots (`A>B`, "" in a bay)."""

    time: float
    robots: tuple[int, ...]
    edges: tuple[str, ...]
