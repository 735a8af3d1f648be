"""Allocation policies: which free robot does which open task."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from desim_warehouse.policies.protocols import Situation


@dataclass(frozen=True)
class InOrder:
    """First in, first out: the free robot with the lowest number gets the first task of the list (the paper)."""

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Robots by number, tasks by their place in the list."""
        tasks = iter(situation.tasks)
        for robot in situation.robots:
            task = next(tasks, None)
            if task is None:
                return
            if situation.feasible(robot, task):
                yield robot.number, task.number
