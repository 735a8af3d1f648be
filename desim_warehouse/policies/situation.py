"""The situation that an allocation policy decides on, with the tables that most policies need: times, energies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import TYPE_CHECKING, Any, Generic, Literal, NamedTuple, Protocol, TypeVar, cast, overload

from desim_warehouse.values.distributions import mean_of

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

    import numpy as np
    from numpy.random import Generator
    from numpy.typing import NDArray

    from desim_warehouse.policies.protocols import RobotView, Task, Travel

Act = Literal["load", "visit", "unload"]
"""The kind of a stop: a load is picked, handed over on its way, or put down."""
T = TypeVar("T")


@dataclass(frozen=True)
class Handling(Generic[T]):
    """Times of activities other than driving, and the weights of Cost_total, in the units of the model file.

    For times that vary, policies receive the mean. `flows`: loading and unloading times of flows that have their own;
    `visits`: time of a stop on the way (`via`), by flow; `stations`: times of stations that have their own, by node.
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
        """Return the handling time of a stop: of the station at a node, else of the task's flow, else of all tasks."""
        if act == "visit":
            return self.visits[flow]
        which = act == "unload"
        own = None if station is None or station not in self.stations else self.stations[station][which]
        return self.flows.get(flow, (self.load_time, self.unload_time))[which] if own is None else own

    def times(self, task: Task, node: str = "") -> tuple[T, T]:
        """Return times of loading and unloading a task; `node`: where it is unloaded, if that is known."""
        at_pick, at_drop = task.edge[0] if task.good < 0 else None, node if task.drop is None else None
        return self.at_stop("load", task.flow, at_pick), self.at_stop("unload", task.flow, at_drop)

    def least(self: Handling[float], flow: str) -> float:
        """Return the least time that loading and unloading a task of a flow takes together, wherever it is done."""
        load, unload = self.flows.get(flow, (self.load_time, self.unload_time))
        loads = [load, *(time for time, _ in self.stations.values() if time is not None)]
        unloads = [unload, *(time for _, time in self.stations.values() if time is not None)]
        return min(loads) + min(unloads)

    def means(self) -> Handling[float]:
        """Return the handling times with every distribution replaced by its mean."""

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


class OpenTasks(Sequence["Task"]):
    """Open tasks in the order of the list: a sequence that is materialised only on first access to an item."""

    __slots__ = ("_listed", "_tasks")

    def __init__(self, tasks: Collection[Task]) -> None:
        self._tasks = tasks
        self._listed: tuple[Task, ...] | None = None

    def __iter__(self) -> Iterator[Task]:
        """Iterate over the tasks in the order of the list."""
        return iter(self._tasks)

    def __len__(self) -> int:
        """Return the number of open tasks."""
        return len(self._tasks)

    @overload
    def __getitem__(self, place: int) -> Task: ...
    @overload
    def __getitem__(self, place: slice) -> Sequence[Task]: ...
    def __getitem__(self, place: int | slice) -> Task | Sequence[Task]:
        """Return the task at a place from 0, or the tasks of a slice."""
        if self._listed is None:
            self._listed = tuple(self._tasks)
        return self._listed[place]

    def __repr__(self) -> str:
        return repr(list(self._tasks))


class Situation(NamedTuple):
    """Decision situation of an allocation policy, read-only: free robots, open tasks, and the state of both.

    Times, lengths and energies are in the units of the model; an edge is a pair of nodes. Tables are numpy arrays with
    a row for each robot or origin, and a column for each task or goal.

    Attributes:
        time: now.
        robots: free robots by number.
        tasks: open tasks in the order of the list.
        travel: free driving times, distances and ways between nodes.
        station: `station(robot, task)` is the node where the robot would unload the task.
        feasible: `feasible(robot, task)`: whether the charging policy lets the robot take the task at this energy, and
            the station has a free slot.
        may: `may(robot, task)`: whether that is so and the robot, driving freely, will not have to give the task back.
        allowed: `allowed(robots, tasks)` is `may` for all pairs: truth values, robots x tasks.
        fleet: `fleet()` shows all robots, busy ones too, with where and when they will be free.
        waits: `waits()` is the mean waiting time per passage of each edge so far, its end node included.
        collisions: `collisions()` is the mean number of collisions per passage of each edge so far, likewise.
        random: `random()` is the policy's own numpy Generator; use no other, so that a seed gives one log.
        handling: times of loading and unloading, and the weights of the paper's cost.
        length: `length(edge)`; 0 of a node for both its ends, as tasks have for a good at a node.
        tour_time: `tour_time(robot, task)` of a tour, or a task that stops on its way: the time from standing at the
            first good to the end, driving freely.
    """

    time: float
    robots: Sequence[RobotView]
    tasks: Sequence[Task]
    travel: Travel
    station: Callable[[RobotView, Task], str]
    feasible: Callable[[RobotView, Task], bool]
    may: Callable[[RobotView, Task], bool]
    allowed: Callable[[Sequence[RobotView], Sequence[Task]], NDArray[np.bool_]]
    fleet: Callable[[], Sequence[RobotView]]
    waits: Callable[[], Mapping[tuple[str, str], float]]
    collisions: Callable[[], Mapping[tuple[str, str], float]]
    random: Callable[[], Generator]
    handling: Handling[float]
    length: Callable[[tuple[str, str]], float]
    tour_time: Callable[[RobotView, Task], float]

    def first_tasks(self, number: int) -> list[Task]:
        """Return the first open tasks of the list, at most `number`, but at least as many as there are free robots."""
        most = max(number, len(self.robots))
        return list(islice(self.tasks, most))

    def approach(self, robots: Sequence[RobotView], tasks: Sequence[Task]) -> NDArray[np.float64]:
        """Return each robot's free driving time to each good from where it becomes free: robots x tasks."""
        import numpy as np

        driven = self.travel.times([robot.node for robot in robots], [task.edge[0] for task in tasks])
        speeds = np.array([robot.speed for robot in robots])[:, None]
        free_in = np.array([robot.free_in for robot in robots])[:, None]
        reached: NDArray[np.float64] = driven + np.array([task.offset for task in tasks]) / speeds + free_in
        return reached

    def delivery(self, robot: RobotView, tasks: Sequence[Task]) -> NDArray[np.float64]:
        """Return each task's time from the good to being free at the station, handling included: one per task."""
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
        fixed: Any = math.fsum(handling.times(tasks[0])) + handling.clear_time if tasks else 0.0
        if handling.flows or handling.stations:
            ends = [self.station(robot, task) if handling.stations else "" for task in tasks]
            times = [handling.times(task, node) for task, node in zip(tasks, ends, strict=True)]
            fixed = np.array([sum(both) + handling.clear_time for both in times])
        if any(task.drop is not None for task in tasks):
            put_down: NDArray[np.float64] = self._driven_loaded(robot, tasks) + fixed
            return put_down
        stations = [self.station(robot, task) for task in tasks]
        nodes = list(dict.fromkeys(stations))
        driven = self.travel.times([task.edge[1] for task in tasks], nodes)
        picked = driven[np.arange(len(tasks)), [nodes.index(node) for node in stations]]
        rest = np.array([(self.length(task.edge) - task.offset) / robot.speed for task in tasks])
        done: NDArray[np.float64] = picked + rest + fixed
        return done

    def _driven_loaded(self, robot: RobotView, tasks: Sequence[Task]) -> NDArray[np.float64]:
        """Return the free driving time of every task with its load: up to the end of the edge, for a storage place."""
        import numpy as np

        driven = []
        for task in tasks:
            rest = self.length(task.edge) - task.offset
            if task.drop is None:
                goal = self.station(robot, task)
            else:
                goal = task.drop[0][0]
                rest += self.length(task.drop[0])
            driven.append(float(self.travel.times([task.edge[1]], [goal])[0, 0]) + rest / robot.speed)
        return np.array(driven)

    def onward(self, robot: RobotView, tasks: Sequence[Task]) -> NDArray[np.float64]:
        """Return the free driving time from the station of each task (rows) to each good (columns): tasks x tasks."""
        import numpy as np

        stations = [self.station(robot, task) for task in tasks]
        driven = self.travel.times(stations, [task.edge[0] for task in tasks])
        reached: NDArray[np.float64] = driven + np.array([task.offset / robot.speed for task in tasks])
        return reached


class Allocation(Protocol):
    """Decides which free robot takes which open task."""

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Return pairs (robot number, task number); robots and tasks left out stay free and open.

        Break ties by number, never by the order of a set: the same seed must give the same log. A further task for the
        same robot, or one for a robot at work, is put into that robot's queue.
        """
