"""The part of `Reach` that holds tasks back while a station or the way there would be closed; used by the dispatcher.

A robot sent to a station that opens in eight hours would wait there with its load, in a slot that others need. So a
task is assigned only if the robot, driving freely, finds every station on its way open. Otherwise the task is examined
again when a robot would arrive just as the station opens. If the robot cannot reach one station before another closes,
it sets out all the same: the load has to wait somewhere. `cut_off` gives the places behind a closure.

Sent at ten in the evening to a station that opens at six, a robot would stand there for eight hours, uncharged.
Policies do not see tasks that may not be begun yet: `in-order` would wait for the first of them all night. If the hours
of two stations of a tour follow one another, a tour held back could wait for ever. Rejected: sending no robot to a
station that is closed now (idle for a drive after each opening), and turning round before one that has closed meanwhile
(loads stranded in the lanes).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import count, zip_longest
from typing import overload

from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.policies import Handling, RobotView, Task
from desim_warehouse.world.places.cut_off import CutOff
from desim_warehouse.world.places.stations import Stations
from desim_warehouse.world.places.stops import Stop, between, time_at
from desim_warehouse.world.traffic.events import Clock
from desim_warehouse.world.traffic.rules import EPS

KEPT = 100_000
"""The number of pairs of robot and task whose answers are cached."""


class Admitted(Sequence["Task"]):
    """The open tasks that are not held back, evaluated lazily: a policy may read only a few of thousands."""

    def __init__(self, tasks: Iterator[Task]) -> None:
        self._found: list[Task] = []
        self._rest = tasks

    def __iter__(self) -> Iterator[Task]:
        """Iterate over the tasks in the order of the list."""
        for i in count():
            if i == len(self._found):
                task = next(self._rest, None)
                if task is None:
                    return
                self._found.append(task)
            yield self._found[i]

    def __len__(self) -> int:
        """Return the number of tasks, which evaluates all."""
        self._found.extend(self._rest)
        return len(self._found)

    @overload
    def __getitem__(self, place: int) -> Task: ...
    @overload
    def __getitem__(self, place: slice) -> Sequence[Task]: ...
    def __getitem__(self, place: int | slice) -> Task | Sequence[Task]:
        """Return the task at a place from 0, or the tasks of a slice, which evaluates all."""
        self._found.extend(self._rest)
        return self._found[place]

    def __bool__(self) -> bool:
        """Whether there is any task."""
        return next(iter(self), None) is not None

    def __contains__(self, task: object) -> bool:
        """Whether a task is open and not held back."""
        return any(admitted == task for admitted in self)


class Openings:
    """Decide which robots would arrive before a station or the way to it opens; without `holds`, none.

    `due` is when the first task that was held back may be given out.
    """

    def __init__(
        self,
        env: Clock,
        stations: Stations,
        cut_off: CutOff,
        handling: Handling[float],
        travel: Callable[[float], FreeTravel],
        loaded_speed: Callable[[RobotView], float],
    ) -> None:
        self.env = env
        self.stations = stations
        self.cut_off = cut_off
        self.holds = stations.close or cut_off.holds
        self.handling = handling
        self.travel = travel
        self.loaded_speed = loaded_speed
        self.due = math.inf
        self._known: dict[tuple[int | None, str, str, float, int, str], tuple[bool, float]] = {}
        """By robot kind, and place and time of becoming free: whether robots are held back, and until when.

        For a tour also by robot, as each may have stations of its own.
        """
        self._seen: tuple[frozenset[str], list[tuple[int, str, float]]] = frozenset(), []
        self._held: dict[int, float] = {}
        """Tasks held back from all free robots last seen, with the set of full stations then, and until when."""

    def look_again(self) -> None:
        """Forget the tasks held back, as the lanes blocked by broken robots have changed."""
        self.cut_off.look_again()
        self._known.clear()
        self._held.clear()
        self.due = math.inf
        self.holds = self.stations.close or self.cut_off.holds

    def admit(self, robot: RobotView, task: Task, node: str) -> bool:
        """Let a robot set out for a task to `node` now, or hold the task back until way and stations are open.

        Returns whether the robot may set out. If not, `due` is when the task is examined again.
        """
        if not self.holds:
            return True
        alone = robot.number if task.is_tour else None
        now, key = self.env.now, (alone, robot.kind, robot.node, robot.free_in, task.number, node)
        held, until = self._known.get(key, (False, -math.inf))
        if now >= until - EPS:
            if len(self._known) > KEPT:
                self._known.clear()
            held, until = self._known[key] = self._is_held(robot, task, node)
        if held:
            self.due = min(self.due, until)
        return not held

    def admit_tasks(self, robots: Sequence[RobotView], tasks: Iterable[Task]) -> Admitted:
        """Hold back the tasks for which none of some robots may set out now. Returns the others."""
        seen = frozenset(self.stations.full), [(robot.number, robot.node, robot.free_in) for robot in robots]
        if seen != self._seen:
            self._seen = seen
            self._held.clear()
        return Admitted(task for task in tasks if self._is_admitted(robots, task))

    def _is_admitted(self, robots: Sequence[RobotView], task: Task) -> bool:
        until = self._held.get(task.number, -math.inf)
        if self.env.now >= until - EPS:
            due, self.due = self.due, math.inf
            if any(self.admit(robot, task, self.stations.choose(robot, task)) for robot in robots):
                self.due = min(self.due, due)
                return True
            until, self.due = self.due, due
            self._held[task.number] = until
        self.due = min(self.due, until)
        return False

    def _is_held(self, robot: RobotView, task: Task, node: str) -> tuple[bool, float]:
        """Return whether a robot that sets out now finds the way or a station closed, and until when."""
        stops, now = self.stations.stops(robot, task, node), self.env.now
        opens = self.cut_off.opens(robot.node, stops, now)
        if opens > now + EPS:
            return True, opens
        held, until = self._is_held_by_stations(robot, stops)
        return held, until if held else min(until, self.cut_off.changes(now))

    def _is_held_by_stations(self, robot: RobotView, stops: Sequence[Stop]) -> tuple[bool, float]:
        travel, with_load, now = self.travel(robot.speed), self.travel(self.loaded_speed(robot)), self.env.now
        first = stops[0]
        trip = robot.free_in + travel.half_turn
        trip += travel.to_edge(robot.node, first.edge) + travel.along(first.edge, first.offset)[0]
        until = math.inf
        for stop, then in zip_longest(stops, stops[1:]):
            hours = None if stop.station is None else stop.station.hours
            if hours is not None:
                opens, closes = hours.following(now + trip)
                if opens > now + trip + EPS:  # within: it sets out just in time, and is held back no longer
                    return (True, opens - trip) if opens - trip < until else (False, until)
                until = min(until, closes - trip)
            if then is not None:
                trip += time_at(self.handling, stop) + between(with_load, stop, then)
        return False, until
