"""Batching policies: the tasks that a robot with several loads does on one tour.

All loads of a tour are picked, then all are unloaded. The policy orders the picks: the policies here begin with the
task that has waited longest and go on to the nearest place each time (nearest neighbour).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

from desim_warehouse.policies.protocols import Task, TaskBatch, Travel, WaitingTasks
from desim_warehouse.values.fields import Unit, Usual


@dataclass(frozen=True)
class Single:
    """Makes every task a batch by itself: no task waits for another (the paper).

    Source: Liu et al., ROBIO 2017, section V.
    """

    title: ClassVar = "every task a trip of its own"

    def batches(self, waiting: WaitingTasks) -> Iterable[TaskBatch]:
        """Yield a batch for each task."""
        return [TaskBatch((task.number,)) for task in waiting.tasks]


@dataclass(frozen=True)
class FixedSize:
    """Batches tasks as soon as `size` of them wait, in the order of release; the last batch may be smaller.

    Source: variable time window batching; Van Nieuwenhuyse and de Koster, Int. J. Production Economics 121 (2009)
    654-664. `size`: loads of a tour; by default as many as a robot carries. `by`: flow, only tasks of one flow.
    """

    title: ClassVar = "so many tasks together"
    size: int | None = None
    by: str | None = None

    def __post_init__(self) -> None:
        """Check the parameters."""
        _at_least_one(self.size)
        _by_flow(self.by)

    def batches(self, waiting: WaitingTasks) -> Iterable[TaskBatch]:
        """Yield full batches, and also the rest if no other tasks are to come."""
        size = min(self.size or waiting.most, waiting.most)
        for tasks in _cut(waiting.tasks, size):
            if len(tasks) == size or not waiting.to_come:
                yield TaskBatch(nearest_next(tasks, waiting.travel))


@dataclass(frozen=True)
class TimeWindow:
    """Batches tasks that become known within `window` of the first of them; a full batch goes at once.

    Source: fixed time window batching; Van Nieuwenhuyse and de Koster, Int. J. Production Economics 121 (2009) 654-664,
    here with a limit. `window`: in the model's time unit. `size`: most loads of a tour; by default as many as a robot
    carries. `by`: flow, only tasks of one flow.
    """

    title: ClassVar = "tasks of a time window together"
    window: Annotated[float, Unit("time"), Usual("5 s", "2 h")]
    size: int | None = None
    by: str | None = None

    def __post_init__(self) -> None:
        """Check the parameters."""
        _at_least_one(self.size)
        _by_flow(self.by)
        if not 0 <= self.window < math.inf:
            raise ValueError(f"window is {self.window}, expected a time of at least 0")

    def batches(self, waiting: WaitingTasks) -> Iterable[TaskBatch]:
        """Yield full batches now, and the rest when its first task's window ends or no other tasks are to come."""
        size = min(self.size or waiting.most, waiting.most)
        for tasks in _cut(waiting.tasks, size):
            whole = len(tasks) == size or not waiting.to_come
            start = waiting.time if whole else tasks[0].release + self.window
            yield TaskBatch(nearest_next(tasks, waiting.travel), start)


@dataclass(frozen=True)
class ByOrder:
    """Batches the known tasks of one order, as many as a robot carries; tasks without an order go by themselves.

    Source: strict order picking, in which an order is not mixed with others; with several `orders`, sort-while-pick; de
    Koster, Le-Duc and Roodbergen, European J. Operational Research 182 (2007) 481-501. `size`: most loads of a tour; by
    default as many as a robot carries. `orders`: whole orders of a tour, in the order of release; fewer if another is
    too large for the rest of it, or no other tasks are to come. `window`: in the model's time unit, the longest that
    orders wait for others; by default until there are enough.
    """

    title: ClassVar = "tasks of an order together"
    size: int | None = None
    orders: int = 1
    window: Annotated[float | None, Unit("time"), Usual("5 s", "2 h")] = None

    def __post_init__(self) -> None:
        """Check the parameters."""
        _at_least_one(self.size)
        _at_least_one(self.orders, "orders")
        if self.window is not None and not 0 <= self.window < math.inf:
            raise ValueError(f"window is {self.window}, expected a time of at least 0")

    def batches(self, waiting: WaitingTasks) -> Iterable[TaskBatch]:
        """Yield full batches of whole orders, a large order in several, and the rest once it need not wait."""
        orders: dict[tuple[str, str, int], list[Task]] = {}
        for task in waiting.tasks:
            alone = -1 if task.order else task.number
            orders.setdefault((task.flow, task.order, alone), []).append(task)
        size = min(self.size or waiting.most, waiting.most)
        gathered: list[list[Task]] = []
        for order in orders.values():
            if gathered and sum(map(len, gathered)) + len(order) > size:
                yield _together(gathered, waiting)
                gathered = []
            if len(order) > size:
                for tasks in _cut(order, size):
                    yield TaskBatch(nearest_next(tasks, waiting.travel))
                continue
            gathered.append(order)
            if len(gathered) == self.orders:
                yield _together(gathered, waiting)
                gathered = []
        if gathered and not waiting.to_come:
            yield _together(gathered, waiting)
        elif gathered and self.window is not None:
            first = min(task.release for order in gathered for task in order)
            yield TaskBatch(_together(gathered, waiting).tasks, first + self.window)


def _together(orders: Iterable[Sequence[Task]], waiting: WaitingTasks) -> TaskBatch:
    return TaskBatch(nearest_next([task for order in orders for task in order], waiting.travel))


def nearest_next(tasks: Sequence[Task], travel: Travel) -> tuple[int, ...]:
    """Return the numbers of tasks in nearest-neighbour order from the first on, by driving time.

    Ties go by the order of the tasks.
    """
    left, tour = list(tasks), [tasks[0]]
    left.remove(tasks[0])
    while left:
        last = tour[-1]

        def time(task: Task, last: Task = last) -> tuple[float, float]:
            is_ahead = task.edge == last.edge and task.offset >= last.offset
            return 0.0 if is_ahead else travel.time(last.edge[1], task.edge[0]), task.offset

        tour.append(min(left, key=time))
        left.remove(tour[-1])
    return tuple(task.number for task in tour)


def _cut(tasks: Sequence[Task], size: int) -> Iterator[Sequence[Task]]:
    return (tasks[begin : begin + size] for begin in range(0, len(tasks), size))


def _by_flow(by: str | None) -> None:
    if by not in {None, "flow"}:
        raise ValueError(f"by is {by!r}, expected flow, or nothing")


def _at_least_one(number: int | None, name: str = "size") -> None:
    if number is not None and number < 1:
        raise ValueError(f"{name} is {number}, expected a whole number of at least 1")
