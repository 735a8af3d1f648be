"""Allocation policies that plan short queues of tasks for the whole fleet, including busy robots.

Both build the queues by insertion: a task may go between any two of a robot's planned tasks. At every decision the
queues are planned anew and only the first tasks of free robots are assigned, unless `commit` is set.
"""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from desim_warehouse.policies.protocols import RobotView, Task
from desim_warehouse.policies.situation import Situation

OBJECTIVES = ("makespan", "total")


@dataclass(frozen=True)
class _Queues(ABC):
    """Parameters and procedure that the policies of this module share."""

    depth: int = 5
    objective: Literal["makespan", "total"] = "makespan"
    candidates: int = 200
    robots: int = 50
    commit: bool = False

    def __post_init__(self) -> None:
        """Check the parameters."""
        for name in ("depth", "candidates", "robots"):
            value = getattr(self, name)
            if not (isinstance(value, int) and value >= 1):
                raise ValueError(f"{name} is {value}, expected a whole number of at least 1")
        if self.objective not in OBJECTIVES:
            raise ValueError(f"objective is {self.objective!r}, expected one of {', '.join(OBJECTIVES)}")

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Plan in groups of at most `robots` robots: the free ones by number, then those that are free next."""
        free = list(situation.robots)
        busy = [robot for robot in situation.fleet() if not robot.free and not robot.queue]
        busy.sort(key=lambda robot: (robot.free_in, robot.number))
        tasks = list(situation.tasks)
        for begin in range(0, len(free), self.robots):
            if not tasks:
                return
            group = free[begin : begin + self.robots]
            most = max(self.candidates, self.depth * len(group))  # enough to fill the queues of all free robots
            taken = set()
            for robot, queue in self._planned(situation, group, busy, tasks[:most]):
                assigned = queue if self.commit else queue[:1]
                taken |= {task.number for task in assigned}
                yield from ((robot.number, task.number) for task in assigned)
            tasks = [task for task in tasks if task.number not in taken]

    def _planned(
        self, situation: Situation, free: list[RobotView], busy: list[RobotView], tasks: list[Task]
    ) -> Iterable[tuple[RobotView, list[Task]]]:
        plan = QueuePlan(situation, free + busy[: self.robots - len(free)], tasks, self.depth, self.objective)
        while (choice := self.choose(plan.bids)) is not None:
            plan.insert(*choice)
        return ((robot, plan.queue(rank)) for rank, robot in enumerate(free))

    @abstractmethod
    def choose(self, bids: Any) -> tuple[int, int] | None:
        """Return the robot (row) and the task (column) to be planned next; None when no bid is left."""


@dataclass(frozen=True)
class Regret(_Queues):
    """Regret-2 insertion: plans first the task that loses most if its best robot does not get it.

    Source: Potvin and Rousseau, European J. Operational Research 66 (1993) 331-340. Regret is the difference between
    the best bids of the two best robots; ties go to the lower bid.

    `depth`: most tasks in a queue. `objective`: a robot bids its completion time (makespan) or the time added (total).
    `candidates`: open tasks, `robots`: robots planned together. `commit`: assign whole queues.
    """

    title: ClassVar = "the task that would lose most first"

    def choose(self, bids: Any) -> tuple[int, int] | None:
        """Return the task with the largest regret, for its best robot; a task for only one robot comes first."""
        import numpy as np

        best = bids.min(axis=0)
        if not np.isfinite(best).any():
            return None
        second = np.partition(bids, 1, axis=0)[1] if len(bids) > 1 else best
        regret = np.where(np.isfinite(second), second, 1e12) - np.where(np.isfinite(best), best, 0.0)
        regret[~np.isfinite(best)] = -np.inf
        task = int(np.lexsort((np.arange(len(best)), best, -regret))[0])
        return int(bids[:, task].argmin()), task


@dataclass(frozen=True)
class Auction(_Queues):
    """Sequential single-item auction: in every round all robots bid for all tasks and the lowest bid wins.

    Source: Lagoudakis et al., Robotics: Science and Systems 2005; bids are for the cheapest insertion into the robot's
    queue. `objective`: makespan (MiniMax: the robot's completion time) or total (MiniSum: the time added). `depth`:
    most tasks in a queue. `candidates`: open tasks, `robots`: robots that bid together. `commit`: assign whole queues.
    """

    title: ClassVar = "the lowest bid"
    objective: Literal["makespan", "total"] = "total"

    def choose(self, bids: Any) -> tuple[int, int] | None:
        """Return the lowest bid; ties go to the lower robot, then to the earlier task."""
        lowest = int(bids.argmin())
        robot, task = divmod(lowest, bids.shape[1])
        return (robot, task) if math.isfinite(bids[robot, task]) else None


class QueuePlan:
    """Queues of a group of robots: the bid of every robot (rows) for every task (columns) not yet planned."""

    def __init__(
        self,
        situation: Situation,
        robots: Sequence[RobotView],
        tasks: Sequence[Task],
        depth: int,
        objective: str,
    ) -> None:
        import numpy as np

        self.tasks = tasks
        self.depth = depth
        self.whole = objective == "makespan"
        self.approach = situation.approach(robots, tasks)
        self.allowed = situation.allowed(robots, tasks)
        self.queues: list[list[int]] = [[] for _ in robots]
        self.open = np.ones(len(tasks), dtype=bool)
        tables: dict[str, tuple[Any, Any]] = {}
        self.of: list[tuple[Any, Any]] = []
        for robot in robots:
            station = situation.station(robot, tasks[0])
            if station not in tables:
                tables[station] = situation.delivery(robot, tasks), situation.onward(robot, tasks)
            self.of.append(tables[station])
        self.bids = np.empty(self.approach.shape)
        self.places = np.zeros(self.approach.shape, dtype=int)
        for rank in range(len(robots)):
            self._bid(rank)

    def length(self, rank: int, queue: Sequence[int]) -> float:
        """Return the time at which a robot would complete a queue."""
        delivery, onward = self.of[rank]
        time = float(self.approach[rank, queue[0]]) if queue else 0.0
        links = math.fsum(float(onward[a, b]) for a, b in itertools.pairwise(queue))
        return time + links + math.fsum(float(delivery[task]) for task in queue)

    def _bid(self, rank: int) -> None:
        """Compute the cheapest insertion of every open task into a robot's queue."""
        import numpy as np

        queue, (delivery, onward) = self.queues[rank], self.of[rank]
        if len(queue) >= self.depth:
            self.bids[rank] = np.inf
            return
        added = []
        for place in range(len(queue) + 1):
            into = self.approach[rank] if place == 0 else onward[queue[place - 1]]
            if place < len(queue):
                behind = queue[place]
                old = self.approach[rank, behind] if place == 0 else onward[queue[place - 1], behind]
                added.append(into + delivery + onward[:, behind] - old)
            else:
                added.append(into + delivery)
        costs = np.array(added)
        self.places[rank] = costs.argmin(axis=0)
        bids = costs.min(axis=0) + (self.length(rank, queue) if self.whole else 0.0)
        self.bids[rank] = np.where(self.allowed[rank] & self.open, bids, np.inf)

    def insert(self, rank: int, task: int) -> None:
        """Insert a task into the queue of a robot where it costs least."""
        self.queues[rank].insert(int(self.places[rank, task]), task)
        self.open[task] = False
        self.bids[:, task] = math.inf
        self._bid(rank)

    def queue(self, rank: int) -> list[Task]:
        """Return the tasks planned for a robot, in order."""
        return [self.tasks[task] for task in self.queues[rank]]
