"""What happens in a run besides driving, as columns of numbers: states, tasks, waiting, deliveries, rotations."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from desim_warehouse.log import STATES
from desim_warehouse.model.schema import Consumption
from desim_warehouse.world.battery import RATE_OF, start_levels

if TYPE_CHECKING:
    from desim_warehouse.run import Run

EPS = 1e-6


@dataclass
class TaskTimes:
    """When a task was released, loaded and delivered (inf: never), and its good."""

    good: int
    released: float
    loaded: float = math.inf
    delivered: float = math.inf


@dataclass
class Wait:
    """A collision: counted at `time`, standing from `begin` to `end` for `other` before the end of `edge`."""

    time: float
    robot: int
    other: int
    edge: int
    begin: float
    end: float


@dataclass
class Timeline:
    """What happened, in order of time; `states` holds (time, state, task, energy) for every robot."""

    states: list[list[tuple[float, int, int, float]]]
    tasks: dict[int, TaskTimes] = field(default_factory=dict)
    deliveries: list[tuple[float, str]] = field(default_factory=list)
    recharged: list[float] = field(default_factory=list)
    waits: list[Wait] = field(default_factory=list)


def at_rest(state: str, task: int) -> bool:
    """Whether a robot is in a bay and draws nothing: one that queues without a task does so for a charger."""
    return state == "idle" or (state == "queueing" and task < 0)


def timeline(run: Run) -> Timeline:
    """Everything that the page shows of a run but the robots' ways."""
    return _Reader(run).read()


class _Reader:
    """Reads the rows of a log once."""

    def __init__(self, run: Run) -> None:
        self.run = run
        count = run.model.fleet.size
        levels = start_levels(run.model, run.seed) if run.model.battery is not None else [0.0] * count
        self.result = Timeline([[(0.0, 0, -1, level)] for level in levels])
        self.number = {edge: number for number, edge in enumerate(run.layout.graph.edges)}
        self.on = [-1] * count
        self.arrived = [-math.inf] * count
        self.announced: list[Wait | None] = [None] * count

    def read(self) -> Timeline:
        """All columns."""
        handle: dict[str, Any] = {
            "drive": self._drive,
            "enter": self._enter,
            "collision": self._collision,
            "released": self._released,
            "delivered": self._delivered,
            "recharged": self._recharged,
            "parked": self._off,
            "docked": self._off,
            **dict.fromkeys(STATES, self._state),
        }
        for row in self.run.record.rows:
            act = handle.get(row[1])
            if act is not None:
                act(row)
        for robot in range(len(self.on)):
            self._close(robot)
        return self.result

    def _drive(self, row: tuple[Any, ...]) -> None:
        time, _, robot, _, _, edge, _, until, _ = row
        self.on[robot] = self.number[edge]
        self.arrived[robot] = max(time, until)
        wait = self.announced[robot]
        if wait is not None and wait.edge == self.on[robot]:
            self.announced[robot] = None
            if time > wait.time + EPS:  # it waits from then on, not until then
                wait.begin, wait.end = wait.time, time

    def _enter(self, row: tuple[Any, ...]) -> None:
        time, robot = row[0], row[2]
        self.on[robot] = self.number[row[5]]
        wait, self.announced[robot] = self.announced[robot], None
        if wait is not None and wait.edge == self.on[robot] and time > wait.time + EPS:  # it waits on the node
            wait.begin, wait.end = time - (wait.end - wait.begin), time

    def _off(self, row: tuple[Any, ...]) -> None:
        self.on[row[2]] = -1  # in a place beside its node; it may wait there, but on no edge

    def _collision(self, row: tuple[Any, ...]) -> None:
        time, _, robot, _, _, edge, value, _, other = row
        on = self.on[robot] if edge is None else self.number[edge]
        wait = Wait(time, robot, other, on, time - value, time)
        self.announced[robot] = wait
        self.result.waits.append(wait)

    def _released(self, row: tuple[Any, ...]) -> None:
        time, _, _, task, _, _, good, _, _ = row
        self.result.tasks[task] = TaskTimes(int(good), time)

    def _delivered(self, row: tuple[Any, ...]) -> None:
        self.result.tasks[row[3]].delivered = row[0]
        self.result.deliveries.append((row[0], row[4]))

    def _recharged(self, row: tuple[Any, ...]) -> None:
        self.result.recharged.append(row[0])

    def _state(self, row: tuple[Any, ...]) -> None:
        time, kind, robot, task, _, _, energy, _, _ = row
        self.result.states[robot].append((time, STATES.index(kind), task, energy or 0.0))
        if kind == "loaded":
            self.result.tasks[task].loaded = time

    def _close(self, robot: int) -> None:
        """A last row at the end of the run, with the energy that is left then."""
        spec = self.run.model.battery
        time, state, task, energy = self.result.states[robot][-1]
        end = max(self.run.record.end, time)
        if spec is not None:
            name = STATES[state]
            if name == "charging":
                energy = min(energy + spec.charge_rate * (end - time), spec.capacity)
            elif not at_rest(name, task):
                draw = spec.consumption
                rate = getattr(draw, RATE_OF[name]) if isinstance(draw, Consumption) else draw
                energy -= rate * (end - time)
        self.result.states[robot].append((end, state, task, energy))
