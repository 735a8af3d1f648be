"""Allocation policies: greedy rules for one robot after the other, or assignments of all free robots at least cost."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from desim_warehouse.policies.protocols import RobotView, Task
from desim_warehouse.policies.situation import Situation

CANDIDATES = 1000
"""The open tasks that a decision considers, from the front of the list; more if more robots are free."""
MISSES = 8
"""The number of pairs checked one by one and not allowed, after which all pairs are checked at once."""
FIRST_LOOK = 8
"""The number of most urgent tasks looked at first; twice as many each time, until every free robot has one."""


@dataclass(frozen=True)
class InOrder:
    """First in, first out: the free robot with the lowest number gets the first task of the list (the paper).

    Source: Liu et al., ROBIO 2017, section V.
    """

    title: ClassVar = "the first free robot"
    gives_only: ClassVar = True

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Yield robots by number with tasks by rank in the list; a robot that may not take a task is passed over."""
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
    """Assigns free robots to open tasks pair by pair, always the pair with the shortest driving time to the good.

    Source: nearest-vehicle-first rule; Egbelu and Tanchoco, Int. J. Production Research 22 (1984) 359-374.
    `candidates`: how many open tasks are considered, from the front of the list.
    """

    title: ClassVar = "the nearest robot"
    candidates: int = CANDIDATES
    gives_only: ClassVar = True

    def __post_init__(self) -> None:
        """Check the parameter: a policy that considers no task would never assign one."""
        _at_least_one(self.candidates)

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Yield pairs, greedily by driving time; ties go to the earlier task, then to the lower robot number."""
        tasks = situation.first_tasks(self.candidates)
        return greedy(situation, tasks, situation.approach(situation.robots, tasks))


@dataclass(frozen=True)
class NearestAging:
    """As `nearest`, but each time unit of waiting brings a task nearer by `aging`, so that no task is left behind.

    Source: aging against starvation, as in Tanenbaum, Modern Operating Systems, on shortest-job-first scheduling.
    `aging`: driving time that a time unit of waiting makes up for. `candidates`: open tasks considered.
    """

    title: ClassVar = "the nearest robot, old tasks first"
    aging: float = 0.2
    candidates: int = CANDIDATES
    gives_only: ClassVar = True

    def __post_init__(self) -> None:
        """Check the parameters."""
        _at_least_one(self.candidates)
        if not self.aging >= 0:
            raise ValueError(f"aging is {self.aging}, expected at least 0")

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Yield pairs, greedily by driving time minus `aging` times the task's age."""
        import numpy as np

        tasks = situation.first_tasks(self.candidates)
        ages = np.array([situation.time - task.release for task in tasks])
        return greedy(situation, tasks, situation.approach(situation.robots, tasks) - self.aging * ages)


@dataclass(frozen=True)
class EarliestDue:
    """Assigns the task with the highest priority, then the earliest due time, to the nearest free robot.

    Source: Jackson's earliest-due-date rule (1955): least maximum lateness on one machine. Tasks without a due time
    come last, in the order of the list. `candidates`: open tasks considered.
    """

    title: ClassVar = "the most urgent task first"
    candidates: int = CANDIDATES
    gives_only: ClassVar = True
    reads: ClassVar = ("priority", "due")

    def __post_init__(self) -> None:
        """Check the parameter."""
        _at_least_one(self.candidates)

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Yield tasks by urgency, each with the nearest free robot that may take it."""
        import numpy as np

        tasks = situation.first_tasks(self.candidates)
        ranks = sorted(
            range(len(tasks)),
            key=lambda i: (-tasks[i].priority, math.inf if tasks[i].due is None else tasks[i].due, i),
        )
        robots, begin, size = list(situation.robots), 0, FIRST_LOOK
        while robots and begin < len(ranks):  # few robots are free: the most urgent tasks are enough for them
            urgent = [tasks[rank] for rank in ranks[begin : begin + size]]
            near = situation.approach(robots, urgent)
            near[~situation.allowed(robots, urgent)] = np.inf
            taken = set()
            for task, times in zip(urgent, near.T, strict=True):
                place = int(times.argmin())
                if math.isfinite(times[place]):
                    near[place] = np.inf
                    taken.add(place)
                    yield robots[place].number, task.number
            robots = [robot for place, robot in enumerate(robots) if place not in taken]
            begin, size = begin + size, 2 * size


def greedy(
    situation: Situation, tasks: Sequence[Task], costs: Any, *, all_checked: bool = False
) -> Iterable[tuple[int, int]]:
    """Yield the cheapest allowed pair, then the next cheapest; ties go to the earlier task, the lower robot number.

    A pair is checked only when its turn comes, so few are; after `MISSES` pairs that are not allowed, all are checked
    at once. `all_checked`: they are already, and pairs that are not allowed cost inf.
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
        if all_checked or situation.may(robots[robot], tasks[task]):
            yield robots[robot].number, tasks[task].number
            free.remove(robot)
            left.remove(task)
            if not (free and left):
                return
        elif (misses := misses + 1) == MISSES:
            rest = np.ix_(sorted(free), sorted(left))
            permitted = np.full(costs.shape, np.inf)
            permitted[rest] = np.where(situation.allowed(robots, tasks), costs, np.inf)[rest]
            yield from greedy(situation, tasks, permitted, all_checked=True)
            return


def _at_least_one(candidates: int) -> None:
    if not (isinstance(candidates, int) and candidates >= 1):
        raise ValueError(f"candidates is {candidates}, expected a whole number of at least 1")


@dataclass(frozen=True)
class Hungarian:
    """Assigns free robots to open tasks with the least total driving time to the goods.

    Source: Kuhn, Naval Research Logistics Quarterly 2 (1955) 83-97; solved by scipy's linear_sum_assignment (Crouse
    2016). Assigns as many tasks as possible. `candidates`: open tasks considered, from the front of the list.
    """

    title: ClassVar = "the least driving in all"
    candidates: int = CANDIDATES
    gives_only: ClassVar = True

    def __post_init__(self) -> None:
        """Check the parameter."""
        _at_least_one(self.candidates)

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Return the optimal assignment for the table of driving times."""
        tasks = situation.first_tasks(self.candidates)
        return matched(situation, tasks, situation.approach(situation.robots, tasks))


@dataclass(frozen=True)
class CostAware:
    """Minimises w_d distance + w_t time + w_c expected collisions on the route to the goods, over all assignments.

    Time includes expected waiting. Waiting and collisions are estimated by their means on the edges of the route in the
    run so far, where an unused edge counts as one free passage. The part after the good costs the same for every robot,
    and is left out. Source: the paper's outlook, Cost_total; means as in a running sample average.

    `distance`, `time`, `collisions`: the weights; by default those of the model's cost section. `candidates`: open
    tasks considered, from the front of the list (fewer than elsewhere, as every route is traversed).
    """

    title: ClassVar = "the least cost in all"
    distance: float | None = None
    time: float | None = None
    collisions: float | None = None
    candidates: int = 200

    def __post_init__(self) -> None:
        """Check the parameters."""
        _at_least_one(self.candidates)
        for name in ("distance", "time", "collisions"):
            weight = getattr(self, name)
            if weight is not None and not 0 <= weight < math.inf:
                raise ValueError(f"{name} is {weight}, expected a weight of at least 0")

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Return the optimal assignment for the table of expected costs."""
        tasks = situation.first_tasks(self.candidates)
        return matched(situation, tasks, self.costs(situation, situation.robots, tasks))

    def costs(self, situation: Situation, robots: Sequence[RobotView], tasks: Sequence[Task]) -> Any:
        """Return the expected cost of every robot (rows) to reach every good (columns)."""
        import numpy as np

        handling = situation.handling
        w_d = handling.distance if self.distance is None else self.distance
        w_t = handling.time if self.time is None else self.time
        w_c = handling.collisions if self.collisions is None else self.collisions
        origins, goals = [robot.node for robot in robots], [task.edge[0] for task in tasks]
        offsets = np.array([task.offset for task in tasks])
        costs = w_d * (situation.travel.lengths(origins, goals) + offsets)
        costs += w_t * situation.approach(robots, tasks)
        waits, collisions = situation.waits(), situation.collisions()
        if not any(collisions.values()):
            return costs
        expected: dict[tuple[str, str], float] = {}
        for i, origin in enumerate(origins):
            for j, goal in enumerate(goals):
                if (origin, goal) not in expected:
                    way = situation.travel.way(origin, goal)
                    expected[origin, goal] = w_t * along(waits, way) + w_c * along(collisions, way)
                costs[i, j] += expected[origin, goal]
        return costs


def along(means: Mapping[tuple[str, str], float], way: Sequence[str]) -> float:
    """Return the sum of a mean per passage over the edges of a route."""
    return math.fsum(means[edge] for edge in itertools.pairwise(way))


def matched(situation: Situation, tasks: Sequence[Task], costs: Any) -> Iterable[tuple[int, int]]:
    """Yield the allowed pairs of an assignment of as many tasks as possible at the least total cost."""
    import numpy as np
    from scipy.optimize import linear_sum_assignment

    robots = situation.robots
    allowed = situation.allowed(robots, tasks) & np.isfinite(costs)
    if not allowed.any():
        return
    possible = costs[allowed]
    spread = float(possible.max() - possible.min())
    table = np.where(allowed, costs - possible.min(), (spread + 1) * (min(costs.shape) + 1))
    for i, j in zip(*linear_sum_assignment(table), strict=True):
        if allowed[i, j]:
            yield robots[int(i)].number, tasks[int(j)].number
