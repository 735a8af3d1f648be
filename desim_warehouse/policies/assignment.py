"""Allocation policies that match all free robots with open tasks at once, by least total cost."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from desim_warehouse.policies.allocation import CANDIDATES, _at_least_one
from desim_warehouse.policies.protocols import RobotView, Task
from desim_warehouse.policies.situation import Situation


@dataclass(frozen=True)
class Hungarian:
    """The assignment of free robots to open tasks with the least total driving time to the goods.

    Source: Kuhn, Naval Research Logistics Quarterly 2 (1955) 83-97; solved by scipy's linear_sum_assignment
    (Crouse 2016). Assigns as many tasks as possible. `candidates`: open tasks considered, from the front of the list.
    """

    candidates: int = CANDIDATES
    gives_only: ClassVar = True

    def __post_init__(self) -> None:
        """Check the parameter."""
        _at_least_one(self.candidates)

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """The optimal assignment for the table of driving times."""
        tasks = situation.first_tasks(self.candidates)
        return matched(situation, tasks, situation.approach(situation.robots, tasks))


@dataclass(frozen=True)
class CostAware:
    """The assignment that minimises w_d distance + w_t time + w_c expected collisions on the route to the goods.

    Time includes expected waiting. Waiting and collisions are estimated by their means on the edges of the route in the
    run so far, and an edge not yet used counts one free passage. What follows the good costs the same whichever robot
    fetches it, and is left out. Source: the paper's outlook, Cost_total; means as in a running sample average.

    `distance`, `time`, `collisions`: the weights; by default those of the model's cost section. `candidates`: open
    tasks considered, from the front of the list (fewer than elsewhere, as every route is traversed).
    """

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
        """The optimal assignment for the table of expected costs."""
        tasks = situation.first_tasks(self.candidates)
        return matched(situation, tasks, self.costs(situation, situation.robots, tasks))

    def costs(self, situation: Situation, robots: Sequence[RobotView], tasks: Sequence[Task]) -> Any:
        """Expected cost of every robot (rows) to reach every good (columns)."""
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
    """Sum of a mean per passage over the edges of a route."""
    return math.fsum(means[edge] for edge in itertools.pairwise(way))


def matched(situation: Situation, tasks: Sequence[Task], costs: Any) -> Iterable[tuple[int, int]]:
    """The allowed pairs that assign as many tasks as possible at the least total cost."""
    import numpy as np
    from scipy.optimize import linear_sum_assignment

    robots = situation.robots
    allowed = situation.allowed(robots, tasks) & np.isfinite(costs)
    if not allowed.any():
        return
    known = costs[allowed]
    spread = float(known.max() - known.min())
    table = np.where(allowed, costs - known.min(), (spread + 1) * (min(costs.shape) + 1))
    for i, j in zip(*linear_sum_assignment(table), strict=True):
        if allowed[i, j]:
            yield robots[int(i)].number, tasks[int(j)].number
