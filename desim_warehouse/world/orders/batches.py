"""Batches: the tasks that go together on a tour, by the batching policy, which decides at each new task."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from numbers import Real
from typing import TYPE_CHECKING

from desim_warehouse.errors import PolicyError, shown
from desim_warehouse.model.sections.fleet import Fleet
from desim_warehouse.policies import Batching, Task, TaskBatch, Travel, WaitingTasks
from desim_warehouse.policies.asked import asked_for_all, fault, short
from desim_warehouse.world.orders.dispatch import Dispatcher
from desim_warehouse.world.robots.reach import suits
from desim_warehouse.world.traffic.events import BATCHES, Clock, end_of_instant
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from simpy.events import Event

    Key = tuple[str, tuple[str, ...], str]


class Batcher:
    """Keep tasks until they are in a batch, and pass each batch on as one task.

    Only tasks of one load type, for the same kinds of robots, go together, and of one flow where the policy is `by`
    flow. `to_come` returns whether further tasks like a given one will become known in any case. The `dispatcher`
    learns of every task, and gives out batches.
    """

    def __init__(
        self,
        env: Clock,
        policy: Batching,
        fleet: Fleet,
        travel: Travel,
        *,
        to_come: Callable[[Task, bool], bool],
        dispatcher: Dispatcher,
    ) -> None:
        self.env = env
        self.policy = policy
        self.travel = travel
        self.to_come = to_come
        self.dispatcher = dispatcher
        self._robots = set(zip(fleet.kinds_of_robots(), fleet.robots(), strict=True))
        self._waiting: dict[Key, dict[int, Task]] = {}
        self._by_flow = getattr(policy, "by", None) == "flow"
        self._most: dict[Key, int] = {}
        self._asks_at = math.inf

    @property
    def waiting(self) -> list[Collection[Task]]:
        """The tasks that are in no batch yet."""
        return [tasks.values() for tasks in self._waiting.values()]

    def release(self, task: Task) -> None:
        """Take a new task, which may then go into a batch."""
        self.dispatcher.announce(task)
        key = task.load_type, task.kinds, task.flow if self._by_flow else ""
        self._waiting.setdefault(key, {})[task.number] = task
        self._ask_at(self.env.now)

    def _ask_at(self, time: float) -> None:
        if time < self._asks_at:
            self._asks_at = time
            end_of_instant(self.env, BATCHES, time - self.env.now).callbacks.append(self._ask)

    def _ask(self, _: Event) -> None:
        if self._asks_at > self.env.now + EPS:
            return  # asked meanwhile
        self._asks_at = math.inf
        policy, now, then = self.policy, self.env.now, math.inf
        for key, tasks in self._waiting.items():
            if not tasks:
                continue
            some = list(tasks.values())
            to_come = self.to_come(some[0], self._by_flow)
            view = WaitingTasks(now, some, self._loads(key, some[0]), to_come, self.travel)
            ask, check = partial(policy.batches, view), partial(self._checked, tasks, view.most)
            for batch in asked_for_all("batching", policy, now, ask, check, "some TaskBatch"):
                if batch.at > now + EPS:
                    then = min(then, batch.at)
                else:
                    self.dispatcher.log.batched(now, batch.tasks)
                    self.dispatcher.give_out(tour_of([tasks.pop(number) for number in batch.tasks]))
        if then < math.inf:
            self._ask_at(then)

    def _loads(self, key: Key, task: Task) -> int:
        """Return the largest number of loads carried by any robot that may do tasks of this sort."""
        if key not in self._most:
            able = (robot.capacity for kind, robot in self._robots if suits(task, kind, robot.carries))
            self._most[key] = max(able, default=1)
        return self._most[key]

    def _checked(self, tasks: Mapping[int, Task], most: int, batches: Iterable[object]) -> list[TaskBatch]:
        """Check every batch of the policy's answer, and return them."""
        checked: list[TaskBatch] = []
        seen: set[int] = set()
        for batch in batches:
            if not isinstance(batch, TaskBatch) or not isinstance(batch.at, Real) or math.isnan(batch.at):
                raise self._fault(f"{short(batch)} is no TaskBatch of task numbers and a time")
            if not 1 <= len(batch.tasks) <= most:
                raise self._fault(f"{len(batch.tasks)} tasks in a batch, expected 1 to {most}, as a robot carries")
            for number in batch.tasks:
                if number not in tasks:
                    raise self._fault(f"task {shown(number)} does not wait")
                if number in seen:
                    raise self._fault(f"task {number} is in two batches")
                seen.add(number)
            checked.append(TaskBatch(tuple(tasks[number].number for number in batch.tasks), float(batch.at)))
        return checked

    def _fault(self, text: str) -> PolicyError:
        return fault("batching", self.policy, self.env.now, text)


def tour_of(tasks: list[Task]) -> Task:
    """Join tasks that one robot does on one tour into one task. A single task is returned unchanged."""
    first = tasks[0]
    if len(tasks) == 1:
        return first
    dues = [task.due for task in tasks if task.due is not None]
    return first._replace(
        release=min(task.release for task in tasks),
        due=min(dues, default=None),
        priority=max(task.priority for task in tasks),
        to=(),
        drop=None,
        via=(),
        members=tuple(tasks),
    )
