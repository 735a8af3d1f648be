"""How long loading, unloading and work in a station take: what the model says, drawn for each task where it varies.

A task has a stream of its own for each of them, so it takes as long whichever robot does it. Designs that are compared
thus differ by what they decide, not by luck at the shelves.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.model.facts.places import flow_times, own_times
from desim_warehouse.policies import Handling
from desim_warehouse.values.distributions import drawn, mean_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from desim_warehouse.layout import Layout
    from desim_warehouse.layout.spec import StationSpec
    from desim_warehouse.model import Model
    from desim_warehouse.model.schema import Tasks
    from desim_warehouse.policies import Task
    from desim_warehouse.values.distributions import Distribution
    from desim_warehouse.values.streams import Streams
    from desim_warehouse.world.places.stops import Stop


class HandlingTimes:
    """The handling times of every task."""

    def __init__(self, tasks: Tasks, layout: Layout, stations: Mapping[str, StationSpec], streams: Streams) -> None:
        self.streams = streams
        self._at = {node: stations[item.zone] for node, item in layout.stations.items()}
        self._times = {"": (tasks.load_time, tasks.unload_time)}
        self._visits = {name: flow.stop_time for name, flow in tasks.flows.items()}
        for name, flow in tasks.flows.items():
            load = tasks.load_time if flow.load_time is None else flow.load_time
            unload = tasks.unload_time if flow.unload_time is None else flow.unload_time
            self._times[name] = load, unload

    def time(self, stop: Stop) -> float:
        """How long a stop takes: by what its station says, else by its flow, else as all do."""
        task, station = stop.task, None if stop.station is None else self._at[stop.station.node]
        if stop.act == "visit":
            return self._drawn(f"stop{stop.rank}", self._visits.get(task.flow, 0.0), task)
        load, unload = self._times[task.flow]
        if stop.act == "load":
            own = None if station is None else station.load_time
            return self._drawn("load", load if own is None else own, task)
        own = None if station is None else station.unload_time
        return self._drawn("unload", unload if own is None else own, task)

    def pick(self, line: Task) -> float:
        """How long it takes to pick a line from a pod, or to put one onto it."""
        return self._drawn("pick", self._visits[line.flow], line)

    def work(self, node: str, task: Task) -> float:
        """How long the work takes on a load unit that was put down in the station at a node."""
        time = self._at[node].work_time
        assert time is not None
        return self._drawn("work", time, task)

    def _drawn(self, purpose: str, time: float | Distribution, task: Task) -> float:
        of, number = (f"{purpose}:{task.flow}", task.nth) if task.flow else (purpose, task.number)
        return drawn(time, lambda: self.streams.stream(of, number))


def handling_of(model: Model, layout: Layout) -> Handling:
    """The handling times of a model as policies and estimates use them: the mean of times that vary."""
    tasks, cost = model.tasks, model.cost
    flows = {name: flow_times(tasks, flow) for name, flow in tasks.flows.items()}
    visits = {name: mean_of(flow.stop_time) for name, flow in tasks.flows.items() if flow.stop_time != 0}
    return Handling(
        tasks.mean_load,
        tasks.mean_unload,
        tasks.clear_time,
        cost.distance,
        cost.time,
        cost.collisions,
        flows,
        visits,
        own_times(model, layout),
    )
