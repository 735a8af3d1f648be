"""Parts of the quick estimate: the mean task, the load of each station, and with pods the lines picked at a visit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from desim_warehouse.errors import number_of

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True)
class MeanTask:
    """One task as a robot does it when there is always a next one: the mean time of each part, in time units.

    `empty` is the drive to the good, `loaded` the drive to the station, `other` all else: drives to chargers and back,
    waiting there, for people and for the next decision. `charging` is not in its `time`. `energy`: what it draws.
    `calm_time` and `calm_energy` are for a task that no other waits for: it begins and ends in a bay.
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
    """Return the mean task of so many robots of each kind: the less time one needs for a task, the more it does."""
    done = {kind: count[kind] / task.time if task.time else 1.0 for kind, task in tasks.items()}
    every = math.fsum(done.values())
    parts = MeanTask.__dataclass_fields__
    return MeanTask(*(math.fsum(done[k] * getattr(tasks[k], part) for k in tasks) / every for part in parts))


@dataclass(frozen=True)
class StationLoad:
    """A station: its share of all tasks, its servers, tasks per time unit that it can serve.

    `busy` is rate x unloading time / servers: above 1 its queue grows. None: the demand has no rate. `workers`: those
    who work on what is put down (0: none), and `work_capacity` and `work_busy` are theirs. With hours all are for the
    run as a whole, closed or not.
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
        """Whether its workers limit it, not its servers."""
        return self.work_capacity < self.serve_capacity

    @property
    def capacity(self) -> float:
        """Tasks per time unit that the station can do."""
        return min(self.serve_capacity, self.work_capacity)

    @property
    def busy(self) -> float | None:
        """The busy share of its servers, or of its workers where they limit it."""
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
    """A lift: its rides for each task, `share`, and the mean `time` for which it is taken by one.

    People and repairs lengthen that time by what they take.
    """

    name: str
    share: float
    time: float

    @property
    def capacity(self) -> float:
        """Rides per time unit that it can do."""
        return 1 / self.time if self.time else math.inf


@dataclass(frozen=True)
class PickerLoad:
    """Pickers who come to robots at storage places: `count` of them, at work for a part of the run (`open`).

    `in_duty`: each task needs one, so that the time in which robots can work is within their hours.
    `share`: stops of a task that need one. `pick`: the mean time of each. `walks`: the mean walk to it, in time, of the
    nearest of 1, 2, ... pickers of a zone who are free, or from a picker to the nearest of so many robots that wait.
    """

    count: int
    open: float
    share: float
    pick: float
    walks: tuple[float, ...]
    in_duty: bool = False

    @property
    def most(self) -> float:
        """Stops per time unit of pickers who never walk."""
        return self.open * self.count / self.pick if self.pick else math.inf

    def most_tasks(self, on_duty: float) -> float:
        """Return the tasks per time unit of pickers who never walk, with robots that are on duty for such a part."""
        part = on_duty if self.in_duty else on_duty * self.open
        return part * self.count / self.pick / self.share if self.pick and self.share else math.inf

    @property
    def least(self) -> float:
        """Stops per time unit where each is as far from the last as any two places of a zone are."""
        time = self.pick + self.walks[0]
        return self.open * self.count / time if time else math.inf

    @property
    def time(self) -> float:
        """The mean time of a picker for a task, with the walk of the nearest where all are free."""
        return self.share * (self.pick + self.walks[-1])

    def busy(self, rate: float) -> float:
        """Return the load of pickers by a rate of tasks: the fewer of them are free, the farther the nearest is.

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
    """Lines picked at a visit of a pod, measured: with `few` lines waiting, and with `many` to choose a pod by.

    `policy` chooses the pods. `pick` is the mean time of a line, `change` the time from one pod to the next,
    `servers` are the servers of all stations.
    """

    few: float
    many: float
    policy: str
    pick: float
    change: float
    servers: int
