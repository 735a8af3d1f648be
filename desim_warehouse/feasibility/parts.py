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
    """The mean task of a robot that always has a next one: the mean time of each part, in time units, and the energy.

    Attributes:
        empty: the drive to the good.
        loaded: the drive to the station.
        other: all else: drives to chargers and back, waiting there, for people and for the next decision.
        charging: time at chargers, which `time` does not contain.
        energy: energy drawn from the battery.
        calm_time: time of a task that no other task waits for, so that it begins and ends in a bay.
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
    """Return the mean task of a fleet with so many robots of each kind: kinds weigh by the tasks that they do.

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
        busy: utilisation of its servers, rate x unloading time / servers: above 1 its queue grows; None without a rate.
        workers: number of people who work on what is put down; 0: none.
        work_capacity: tasks per time unit that these can do.
        work_busy: utilisation of these people.

    Where the station has hours, all of that is for the run as a whole, closed times included.
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
        """Whether the station is limited by the people who work on loads, not by its servers."""
        return self.work_capacity < self.serve_capacity

    @property
    def capacity(self) -> float:
        """Tasks per time unit that the station can do."""
        return min(self.serve_capacity, self.work_capacity)

    @property
    def busy(self) -> float | None:
        """The utilisation of the station's servers, or of its people where they limit it; None without a rate."""
        return self.work_busy if self.limited_by_work else self.serve_busy

    @property
    def doing(self) -> str:
        """The work that limits it, in words."""
        return f"{'work' if self.limited_by_work else self.handling} at {self.node}"

    @property
    def staff(self) -> str:
        """The servers or workers that limit it, and their number."""
        count, who = (self.workers, "worker") if self.limited_by_work else (self.servers, "server")
        return number_of(count, who)


@dataclass(frozen=True)
class LiftLoad:
    """The load of a lift: `share`, its rides for each task, and `time`, for which one ride keeps it busy on average.

    People and repairs lengthen that time by what they take. `crowd`: time for which a task keeps it busy where many
    tasks wait, so that robots choose those for which they ride less; None: not measured.
    """

    name: str
    share: float
    time: float
    crowd: float | None = None

    @property
    def least(self) -> float:
        """The least time for which a task keeps it busy."""
        alone = self.share * self.time
        return alone if self.crowd is None else min(alone, self.crowd)

    def busy(self, rate: float) -> float:
        """Return the utilisation of the lift by a rate of tasks: as soon as robots queue, they choose and ride less."""
        alone = rate * self.share * self.time
        return alone if alone <= 1 else max(rate * self.least, 1.0)

    @property
    def capacity(self) -> float:
        """Rides per time unit that it can do."""
        return 1 / self.time if self.time else math.inf


@dataclass(frozen=True)
class PickerLoad:
    """The load of pickers who come to robots at storage places: how many they are, and how much of the run they work.

    `open`: the share of the run in which they work. `share`: stops of a task that need a picker, on average. `pick`:
    mean time of picking at one of these. `walks`: mean time of the walk to a stop for the nearest of 1, 2, ... free
    pickers of a zone, or from a picker to the nearest of as many waiting robots. `in_duty`: each task needs a picker,
    so that robots can work only within the pickers' hours.
    """

    count: int
    open: float
    share: float
    pick: float
    walks: tuple[float, ...]
    in_duty: bool = False

    @property
    def most(self) -> float:
        """The stops per time unit that pickers can serve if they never walk."""
        return self.open * self.count / self.pick if self.pick else math.inf

    def most_tasks(self, on_duty: float) -> float:
        """Return the tasks per time unit of pickers who never walk, with robots that are on duty for such a part."""
        part = on_duty if self.in_duty else on_duty * self.open
        return part * self.count / self.pick / self.share if self.pick and self.share else math.inf

    @property
    def least(self) -> float:
        """The stops per time unit that pickers can serve if each is as far from the last as two random places."""
        time = self.pick + self.walks[0]
        return self.open * self.count / time if time else math.inf

    @property
    def time(self) -> float:
        """The mean time of a picker for a task, with the walk of the nearest where all are free."""
        return self.share * (self.pick + self.walks[-1])

    def busy(self, rate: float) -> float:
        """Return the utilisation of pickers by a rate of tasks: the fewer are free, the farther the nearest walks.

        Where all are busy, robots wait, and walks are shorter again: the load is 1 up to what they do without a step.
        """
        stops = rate * self.share / self.open if self.open else math.inf
        for percent in range(101):
            load = percent / 100
            free = max(round(len(self.walks) * (1 - load)), 1)
            if stops * (self.pick + self.walks[free - 1]) <= load * self.count:
                return load
        return max(stops * self.pick / self.count, 1.0)


@dataclass(frozen=True)
class PileOn:
    """Lines picked at a visit of a pod, as measured with `few` lines waiting, and with `many` to choose a pod by.

    `policy` chooses the pods. `pick`: mean time of picking a line, `change`: time from one pod to the next, `servers`:
    servers of all stations.
    """

    few: float
    many: float
    policy: str
    pick: float
    change: float
    servers: int
