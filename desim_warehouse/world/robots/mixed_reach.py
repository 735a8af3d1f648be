"""`MixedReach`, used by the dispatcher in place of a `Reach` where kinds differ in battery, charging or chargers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from desim_warehouse.policies import RobotView, Task
from desim_warehouse.world.robots.reach import Reach, may_do


class MixedReach:
    """The `reaches` of a fleet's kinds, as one object for questions about any of its robots."""

    def __init__(self, reaches: Mapping[str, Reach]) -> None:
        self.of = reaches
        first = next(iter(reaches.values()))
        self.batteries = first.batteries
        self.stations, self.handling, self.tour_time = first.stations, first.handling, first.tour_time
        self.openings = first.openings
        for reach in reaches.values():  # tasks held back or given back are common to all
            reach.share(first)

    def feasible(self, robot: RobotView, task: Task) -> bool:
        """Return `Reach.feasible` of the robot's kind."""
        return self.of[robot.kind].feasible(robot, task)

    def may(self, robot: RobotView, task: Task) -> bool:
        """Return `Reach.may` of the robot's kind."""
        return self.of[robot.kind].may(robot, task)

    def may_take(self, robot: RobotView, task: Task, station: str) -> bool:
        """Return `Reach.may_take` of the robot's kind."""
        return self.of[robot.kind].may_take(robot, task, station)

    def lasts(self, robot: RobotView, task: Task) -> bool:
        """Whether a robot's battery lasts for a task: `Reach.lasts` of the robot's kind."""
        return self.of[robot.kind].lasts(robot, task)

    def must_charge(self, robot: RobotView) -> bool:
        """Return `Reach.must_charge` of the robot's kind."""
        return self.of[robot.kind].must_charge(robot)

    def allowed(self, robots: Sequence[RobotView], tasks: Sequence[Task]) -> Any:
        """Return `Reach.allowed` for all pairs, each row by the robot's kind."""
        import numpy as np

        table = np.ones((len(robots), len(tasks)), dtype=bool)
        for kind, reach in self.of.items():
            rows = [row for row, robot in enumerate(robots) if robot.kind == kind]
            if rows:
                table[rows] = reach.allowed([robots[row] for row in rows], tasks)
        return table

    def why_none_lasts(self, robots: Iterable[RobotView], task: Task) -> str:
        """Return `Reach.why_none_lasts` of the kind whose robot is closest to having enough."""
        able = [robot for robot in robots if may_do(robot, task)]
        kind = min(able, key=lambda robot: self.of[robot.kind].missing(robot, task)).kind
        return self.of[kind].why_none_lasts([robot for robot in able if robot.kind == kind], task)

    def give_back(self, task: Task) -> int:
        """Note that a robot gives a task back, and return the number of times so far."""
        return next(iter(self.of.values())).give_back(task)

    def forget(self, task: Task) -> None:
        """Forget a task that is done, or given back."""
        for reach in self.of.values():
            reach.forget(task)
