"""How long loading and unloading take: what the model says, drawn for each task where it varies.

A task has a stream of its own for each of the two, so it takes as long whichever robot does it, and whatever else
happens: designs that are compared differ by what they decide, not by luck at the shelves.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.distributions import Distribution

if TYPE_CHECKING:
    from desim_warehouse.model.schema import Tasks
    from desim_warehouse.policies import Task
    from desim_warehouse.streams import Streams


class HandlingTimes:
    """The handling times of every task."""

    def __init__(self, tasks: Tasks, streams: Streams) -> None:
        self.streams = streams
        self._times = {"": (tasks.load_time, tasks.unload_time)}
        self._visits = {name: flow.stop_time for name, flow in tasks.flows.items()}
        for name, flow in tasks.flows.items():
            load = tasks.load_time if flow.load_time is None else flow.load_time
            unload = tasks.unload_time if flow.unload_time is None else flow.unload_time
            self._times[name] = load, unload

    def load(self, task: Task) -> float:
        """How long loading a task takes."""
        return self._drawn("load", self._times[task.flow][0], task)

    def unload(self, task: Task) -> float:
        """How long unloading a task takes."""
        return self._drawn("unload", self._times[task.flow][1], task)

    def visit(self, task: Task, rank: int) -> float:
        """How long the stop of a task on its way takes, by its rank among those."""
        return self._drawn(f"stop{rank}", self._visits.get(task.flow, 0.0), task)

    def _drawn(self, purpose: str, time: float | Distribution, task: Task) -> float:
        if isinstance(time, Distribution):
            if task.flow:
                return time.draw(self.streams.stream(f"{purpose}:{task.flow}", task.nth))
            return time.draw(self.streams.stream(purpose, task.number))
        return time
