"""Parts of the quick estimate: the mean task, the load of each station and, with pods, the lines picked per visit.

For the answer of `desim check`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from desim_warehouse.errors import number_of


@dataclass(frozen=True)
class MeanTask:
    """The mean task of a robot that always has a next one: mean time of each part, in time units, and energy.

    Attributes:
        empty: the drive to the good.
        loaded: the drive to the station.
        other: all else: drives to chargers and back, waiting there, for people, and for the next decision.
        charging: time at chargers, which `time` does not contain.
        energy: energy drawn from the battery.
        calm_time: time of a task without another waiting task, so that it begins and ends in a bay.
        calm_energy: energy of such a task.
    """

    empty: float
    load: float
    loaded: float
    unload: float
    other: float
    energy: float
    charging: float
    calm_time: float = 0.0
    calm_energy: float = 0.0

    @property
    def time(self) -> float:
        """The mean time of the whole task."""
        return self.empty + self.load + self.loaded + self.unload + self.other


def mixed(tasks: Mapping[str, MeanTask], count: Mapping[str, int]) -> MeanTask:
    """Return the mean task of a fleet with `count` robots of each kind, weighted by the tasks that each kind does.

    The less time a kind needs for a task, the more tasks it does.
    """
    done = {kind: count[kind] / task.time if task.time else 1.0 for kind, task in tasks.items()}
    every = math.fsum(done.values())
    parts = MeanTask.__dataclass_fields__
    return MeanTask(*(math.fsum(done[k] * getattr(tasks[k], part) for k in tasks) / every for part in parts))


@dataclass(frozen=True)
class StationLoad:
    """The load of a station: its share of all tasks, its servers, and the tasks per time unit that it can serve.

    Attributes:
        serve_busy: utilisation of its servers, rate x handling time / servers: above 1 its queue grows; None without a
            rate.
        workers: number of people who work on loads put down; 0: none.
        work_capacity: tasks per time unit that these people can do.
        work_busy: utilisation of these people.
        open: share of the run in which the station is open.
        handling: what its servers do, in words.

    If the station has hours, all numbers are means over the run, closed times included.
    """

    node: str
    share: float
    servers: int
    serve_capacity: float
    serve_busy: float | None
    workers: int = 0
    work_capacity: float = math.inf
    work_busy: float | None = None
    open: float = 1.0
    """The part of the run in which it is open."""
    handling: str = "unloading"
    """What its servers do."""

    @property
    def limited_by_work(self) -> bool:
        """Whether the people who work on loads limit the station, rather than its servers."""
        return self.work_capacity < self.serve_capacity

    @property
    def capacity(self) -> float:
        """Tasks per time unit that the station can do."""
        return min(self.serve_capacity, self.work_capacity)

    @property
    def busy(self) -> float | None:
        """The utilisation of the station's servers, or of its people if they limit it; None without a rate."""
        return self.work_busy if self.limited_by_work else self.serve_busy

    @property
    def doing(self) -> str:
        """The work that limits the station, in words."""
        return f"{'work' if self.limited_by_work else self.handling} at {self.node}"

    @property
    def staff(self) -> str:
        """The servers or workers that limit the station, with their number, in words."""
        count, who = (self.workers, "worker") if self.limited_by_work else (self.servers, "server")
        return number_of(count, who)


@dataclass(frozen=True)
class LiftLoad:
    """The load of a lift: `share`, its rides per task, and `time`, for which a ride keeps it busy on average.

    `time` is longer by the share that people and repairs take. `crowd`: time for which a task keeps the lift busy if
    many tasks wait, so that robots choose tasks with fewer rides; None: not measured.
    """

    name: str
    share: float
    time: float
    crowd: float | None = None

    @property
    def least(self) -> float:
        """The least time for which a task keeps the lift busy."""
        alone = self.share * self.time
        return alone if self.crowd is None else min(alone, self.crowd)

    def busy(self, rate: float) -> float:
        """Return the utilisation of the lift at a rate of tasks.

        Once robots queue, they choose tasks with less riding.
        """
        alone = rate * self.share * self.time
        return alone if alone <= 1 else max(rate * self.least, 1.0)

    @property
    def capacity(self) -> float:
        """Rides per time unit that the lift can do."""
        return 1 / self.time if self.time else math.inf


@dataclass(frozen=True)
class PickerLoad:
    """The load of pickers who come to robots at storage places: their number, and the share of the run that they work.

    `open`: the share of the run in which they work. `share`: mean number of stops of a task that need a picker. `pick`:
    mean time of picking at such a stop. `walks`: mean time of the walk to a stop for the nearest of 1, 2, ... free
    pickers of a zone, or from a picker to the nearest of as many waiting robots. `in_duty`: every task needs a picker,
    so that robots can work only within the pickers' hours. `crowded`: mean time of the walk to a stop while all pickers
    are busy, to the nearest of the robots that they keep waiting.
    """

    count: int
    open: float
    share: float
    pick: float
    walks: tuple[float, ...]
    in_duty: bool = False
    crowded: float = 0.0

    @property
    def most(self) -> float:
        """The stops per time unit that pickers can serve if they never walk."""
        return self.open * self.count / self.pick if self.pick else math.inf

    def most_tasks(self, on_duty: float) -> float:
        """Return the tasks per time unit if pickers never walk, with robots on duty for a share of the run."""
        part = on_duty if self.in_duty else on_duty * self.open
        return part * self.count / self.pick / self.share if self.pick and self.share else math.inf

    @property
    def least(self) -> float:
        """The stops per time unit that pickers can serve if each walk is between two random places."""
        time = self.pick + self.walks[0]
        return self.open * self.count / time if time else math.inf

    @property
    def time(self) -> float:
        """The mean time of a picker for a task, with the walk of the nearest while all are free."""
        return self.share * (self.pick + self.walks[-1])

    def busy(self, rate: float) -> float:
        """Return the utilisation of pickers at a rate of tasks; the fewer are free, the farther the nearest walks.

        If all are busy, robots wait, and walks get shorter again: the utilisation is 1 up to what pickers do with the
        shortest walks of this fleet, and above 1 beyond that.
        """
        stops = rate * self.share / self.open if self.open else math.inf
        for percent in range(101):
            load = percent / 100
            free = max(round(len(self.walks) * (1 - load)), 1)
            if stops * (self.pick + self.walks[free - 1]) <= load * self.count:
                return load
        return max(stops * (self.pick + self.crowded) / self.count, 1.0)


@dataclass(frozen=True)
class PileOn:
    """Lines picked per visit of a pod, as measured with few waiting lines (`few`), and with many (`many`).

    `policy`: the policy that chooses pods. `pick`: mean time of picking a line.
    `change`: time from one pod to the next. `servers`: servers of all stations.
    """

    few: float
    many: float
    policy: str
    pick: float
    change: float
    servers: int
