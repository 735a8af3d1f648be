"""Policies of one's own: name one in a model file as `policies.allocation: my_policies.py:Patient`.

A policy is a frozen dataclass with one method; its fields are its parameters in the model file:

    policies:
      allocation: {name: my_policies.py:Patient, patience: 600}
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Patient:
    """Nearest robot first, but a task that has waited longer than `patience` goes before all others."""

    patience: float = 600.0

    def assign(self, situation):
        tasks = list(situation.tasks)
        late = [task for task in tasks if situation.time - task.release > self.patience]
        free = list(situation.robots)
        for task in late + [task for task in tasks if task not in late]:
            able = [robot for robot in free if situation.feasible(robot, task)]
            if able:
                nearest = min(able, key=lambda robot: situation.travel.time(robot.node, task.edge[0]))
                free.remove(nearest)
                yield nearest.number, task.number


@dataclass(frozen=True)
class Lottery:
    """Every free robot draws a task, from the policy's own random stream."""

    def assign(self, situation):
        tasks = list(situation.tasks)
        situation.random().shuffle(tasks)
        for robot, task in zip(situation.robots, tasks, strict=False):
            if situation.feasible(robot, task):
                yield robot.number, task.number
