"""Allocation policies that give one robot after the other a task by a simple rule."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from desim_warehouse.policies.protocols import Task
from desim_warehouse.policies.situation import Situation

CANDIDATES = 1000
"""Open tasks that a decision considers, from the front of the list; more if more robots are free."""
MISSES = 8
"""Pairs that are looked at one by one and may not be given, until all are looked at together."""


@dataclass(frozen=True)
class InOrder:
    """First in, first out: the free robot with the lowest number gets the first task of the list (the paper).

    Source: Liu et al., ROBIO 2017, section V.
    """

    gives_only: ClassVar = True

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Robots by number, tasks by their rank in the list; a robot that may not take the next one is passed over."""
        tasks = iter(situation.tasks)
        task = next(tasks, None)
        for robot in situation.robots:
            if task is None:
                return
            if situation.feasible(robot, task):
                yield robot.number, task.number
                task = next(tasks, None)


@dataclass(frozen=True)
class Nearest:
    """The pair of free robot and open task with the shortest directed driving time, then the next shortest, ...

    Source: nearest-vehicle-first rule; Egbelu and Tanchoco, Int. J. Production Research 22 (1984) 359-374.
    `candidates`: how many open tasks are considered, from the front of the list.
    """

    candidates: int = CANDIDATES
    gives_only: ClassVar = True

    def __post_init__(self) -> None:
        """A policy that considers no task would never assign one."""
        _at_least_one(self.candidates)

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Greedy on the table of driving times; ties go to the earlier task, then to the lower robot number."""
        tasks = situation.first_tasks(self.candidates)
        return greedy(situation, tasks, situation.approach(situation.robots, tasks))


@dataclass(frozen=True)
class NearestAging:
    """Nearest, but a task counts as nearer by `aging` for every time unit it has waited, so that none is left behind.

    Source: aging against starvation, as in Tanenbaum, Modern Operating Systems, on shortest-job-first scheduling.
    `aging`: driving time that a time unit of waiting makes up for. `candidates`: open tasks considered.
    """

    aging: float = 0.2
    candidates: int = CANDIDATES
    gives_only: ClassVar = True

    def __post_init__(self) -> None:
        """Check the parameters."""
        _at_least_one(self.candidates)
        if not self.aging >= 0:
            raise ValueError(f"aging is {self.aging}, expected at least 0")

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Greedy on driving time less `aging` times the task's age."""
        import numpy as np

        tasks = situation.first_tasks(self.candidates)
        ages = np.array([situation.time - task.release for task in tasks])
        return greedy(situation, tasks, situation.approach(situation.robots, tasks) - self.aging * ages)


@dataclass(frozen=True)
class EarliestDue:
    """The task with the highest priority, then the earliest due time, to the robot that is nearest to it.

    Source: Jackson's earliest-due-date rule (1955): least maximum lateness on one machine. Tasks without a due time
    come last, in the order of the list. `candidates`: open tasks considered.
    """

    candidates: int = CANDIDATES
    gives_only: ClassVar = True
    reads: ClassVar = ("priority", "due")

    def __post_init__(self) -> None:
        """Check the parameter."""
        _at_least_one(self.candidates)

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Tasks by urgency, each to the nearest free robot that may take it."""
        import numpy as np

        tasks = situation.first_tasks(self.candidates)
        ranks = sorted(
            range(len(tasks)),
            key=lambda i: (-tasks[i].priority, math.inf if tasks[i].due is None else tasks[i].due, i),
        )
        near = situation.approach(situation.robots, tasks)
        near[~situation.allowed(situation.robots, tasks)] = np.inf
        left = len(situation.robots)
        for rank in ranks:
            if not left:
                return
            robot = int(near[:, rank].argmin())
            if math.isfinite(near[robot, rank]):
                near[robot] = np.inf
                left -= 1
                yield situation.robots[robot].number, tasks[rank].number


def greedy(
    situation: Situation, tasks: Sequence[Task], costs: Any, *, asked: bool = False
) -> Iterable[tuple[int, int]]:
    """The cheapest allowed pair, then the cheapest of those left; ties to the earlier task, the lower robot number.

    Whether a pair is allowed is asked when its turn comes, so of few; after `MISSES` that are not, of all at once.
    `asked`: that is done, and pairs that are not allowed cost inf.
    """
    import numpy as np

    robots, misses = situation.robots, 0
    free, left = set(range(len(robots))), set(range(len(tasks)))
    pairs = costs.T.ravel()
    for pair in pairs.argsort(kind="stable").tolist():
        if pairs[pair] == np.inf:
            return
        task, robot = divmod(pair, len(robots))
        if robot not in free or task not in left:
            continue
        if asked or situation.may(robots[robot], tasks[task]):
            yield robots[robot].number, tasks[task].number
            free.remove(robot)
            left.remove(task)
            if not (free and left):
                return
        elif (misses := misses + 1) == MISSES:
            rest = np.ix_(sorted(free), sorted(left))
            known = np.full(costs.shape, np.inf)
            known[rest] = np.where(situation.allowed(robots, tasks), costs, np.inf)[rest]
            yield from greedy(situation, tasks, known, asked=True)
            return


def _at_least_one(candidates: int) -> None:
    if not (isinstance(candidates, int) and candidates >= 1):
        raise ValueError(f"candidates is {candidates}, expected a whole number of at least 1")
