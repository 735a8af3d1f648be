"""What an allocation policy offers and decides on, with the tables that most policies need: times, energies."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import islice
from typing import TYPE_CHECKING, Any, Generic, Literal, Protocol, TypeVar, cast

from desim_warehouse.values.distributions import mean_of

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

    from numpy.random import Generator

    from desim_warehouse.policies.protocols import RobotView, Task, Travel

Act = Literal["load", "visit", "unload"]
"""What is done at a stop: a load is picked, handed over on its way, or put down."""
T = TypeVar("T")


@dataclass(frozen=True)
class Handling(Generic[T]):
    """Times spent apart from driving, and the weights of Cost_total; in the units of the model file.

    Policies are given the mean of times that vary. `flows`: loading and unloading of the flows that have times of their
    own; `visits`: of flows a stop on the way (`via`); `stations`: by node, of stations that have times of their own.
    """

    load_time: T
    unload_time: T
    clear_time: float
    distance: float = 1.0
    time: float = 1.0
    collisions: float = 1.0
    flows: Mapping[str, tuple[T, T]] = field(default_factory=dict)
    visits: Mapping[str, T] = field(default_factory=dict)
    stations: Mapping[str, tuple[T | None, T | None]] = field(default_factory=dict)

    def at_stop(self, act: Act, flow: str = "", station: str | None = None) -> T:
        """The time of a stop for a task of a flow: what the station at a node says, else the flow, else all tasks'."""
        if act == "visit":
            return self.visits[flow]
        which = act == "unload"
        own = None if station is None or station not in self.stations else self.stations[station][which]
        return self.flows.get(flow, (self.load_time, self.unload_time))[which] if own is None else own

    def times(self, task: Task, node: str = "") -> tuple[T, T]:
        """The times of loading and unloading a task, given the node where it is unloaded, if that is known."""
        at_pick, at_drop = task.edge[0] if task.good < 0 else None, node if task.drop is None else None
        return self.at_stop("load", task.flow, at_pick), self.at_stop("unload", task.flow, at_drop)

    def means(self) -> Handling[float]:
        """The same with the means of times that vary."""

        def both(times: tuple[Any, Any]) -> tuple[Any, Any]:
            load, unload = (None if time is None else mean_of(time) for time in times)
            return load, unload

        return Handling(
            *both((self.load_time, self.unload_time)),
            self.clear_time,
            self.distance,
            self.time,
            self.collisions,
            {flow: both(times) for flow, times in self.flows.items()},
            {flow: mean_of(cast("Any", time)) for flow, time in self.visits.items()},
            {node: both(times) for node, times in self.stations.items()},
        )


@dataclass(frozen=True)
class Situation:
    """The free robots by number, the open tasks in the order of the list, and what is known about both.

    `station(robot, task)` is the node where the robot would unload the task. `feasible(robot, task)`: whether it may
    take it, as the charging policy allows it at this energy and the station has a free slot. `fleet()` shows all
    robots, busy ones too. `waits()` and `collisions()` are the mean waiting time and number of collisions per passage
    of each edge so far, its end node included. `random()` is the policy's own numpy Generator.
    """

    time: float
    robots: Sequence[RobotView]
    tasks: Collection[Task]
    travel: Travel
    station: Callable[[RobotView, Task], str]
    feasible: Callable[[RobotView, Task], bool]
    may: Callable[[RobotView, Task], bool]
    """Whether a pair is feasible and, driving freely, the robot will not have to give the task back."""
    allowed: Callable[[Sequence[RobotView], Sequence[Task]], Any]
    """`may` for all pairs: a boolean numpy array with a row for each robot, a column for each task."""
    fleet: Callable[[], Sequence[RobotView]]
    waits: Callable[[], Mapping[tuple[str, str], float]]
    collisions: Callable[[], Mapping[tuple[str, str], float]]
    random: Callable[[], Generator]
    handling: Handling[float]
    length: Callable[[tuple[str, str]], float]
    """Length of an edge; 0 of a node for both its ends, as tasks have for a good at a node."""
    tour_time: Callable[[RobotView, Task], float]
    """Of a tour, or a task that stops on its way: the time from standing at the first good to the end, in free flow."""

    def first_tasks(self, number: int) -> list[Task]:
        """The first open tasks of the list, at most `number`, but at least as many as there are free robots."""
        most = max(number, len(self.robots))
        return list(islice(self.tasks, most))

    def approach(self, robots: Sequence[RobotView], tasks: Sequence[Task]) -> Any:
        """Free driving time of every robot (rows) to every good (columns), from where and when it is free."""
        import numpy as np

        driven = self.travel.times([robot.node for robot in robots], [task.edge[0] for task in tasks])
        speeds = np.array([robot.speed for robot in robots])[:, None]
        free_in = np.array([robot.free_in for robot in robots])[:, None]
        return driven + np.array([task.offset for task in tasks]) / speeds + free_in

    def delivery(self, robot: RobotView, tasks: Sequence[Task]) -> Any:
        """Time of every task from standing at the good to being free at the station, handling included."""
        import numpy as np

        handling = self.handling
        if any(task.is_tour for task in tasks):
            clear = handling.clear_time
            return np.array(
                [
                    self.tour_time(robot, task) + clear if task.is_tour else float(self.delivery(robot, [task])[0])
                    for task in tasks
                ]
            )
        fixed: Any = sum(handling.times(tasks[0])) + handling.clear_time if tasks else 0.0
        if handling.flows or handling.stations:
            at = [self.station(robot, task) if handling.stations else "" for task in tasks]
            times = [handling.times(task, node) for task, node in zip(tasks, at, strict=True)]
            fixed = np.array([sum(both) + handling.clear_time for both in times])
        if any(task.drop is not None for task in tasks):
            return self._driven_loaded(robot, tasks) + fixed
        stations = [self.station(robot, task) for task in tasks]
        nodes = list(dict.fromkeys(stations))
        driven = self.travel.times([task.edge[1] for task in tasks], nodes)
        picked = driven[np.arange(len(tasks)), [nodes.index(node) for node in stations]]
        rest = np.array([(self.length(task.edge) - task.offset) / robot.speed for task in tasks])
        return picked + rest + fixed

    def _driven_loaded(self, robot: RobotView, tasks: Sequence[Task]) -> Any:
        """Free driving time of every task with its load: up to the end of the edge, where it is a storage place."""
        import numpy as np

        found = []
        for task in tasks:
            rest = self.length(task.edge) - task.offset
            if task.drop is None:
                goal = self.station(robot, task)
            else:
                goal = task.drop[0][0]
                rest += self.length(task.drop[0])
            found.append(float(self.travel.times([task.edge[1]], [goal])[0, 0]) + rest / robot.speed)
        return np.array(found)

    def onward(self, robot: RobotView, tasks: Sequence[Task]) -> Any:
        """Free driving time from the station of every task (rows) to every good (columns)."""
        import numpy as np

        stations = [self.station(robot, task) for task in tasks]
        driven = self.travel.times(stations, [task.edge[0] for task in tasks])
        return driven + np.array([task.offset / robot.speed for task in tasks])


class Allocation(Protocol):
    """Which free robot takes which open task."""

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Pairs (robot number, task number); robots and tasks left out stay free and open.

        Break ties by number, never by the order of a set: the same seed must give the same log. A further task for the
        same robot, or one for a robot at work, is put into that robot's queue.
        """
