"""Who gets which task: open tasks, robots that are free, and the allocation policy asked when either changes."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING

from simpy.events import Event

from desim_warehouse.errors import PolicyError
from desim_warehouse.policies import Situation
from desim_warehouse.world.streams import stream

if TYPE_CHECKING:
    from numpy.random import Generator

    from desim_warehouse.policies import Allocation, RobotView, Task
    from desim_warehouse.world.robot import Robot
    from desim_warehouse.world.world import World

AFTER_ALL = 2
"""Priority of a decision among the events of one instant: after all that happens at that time."""


class Dispatcher:
    """Keeps the list of open tasks and asks the allocation policy once for all that happens at one instant."""

    def __init__(self, world: World, allocation: Allocation) -> None:
        self.world = world
        self.env = world.env
        self.allocation = allocation
        self.open: OrderedDict[int, Task] = OrderedDict()
        self.free: dict[int, tuple[Robot, Event]] = {}
        self.passing: set[int] = set()
        self.unload_at: dict[int, str] = {}
        self.released = 0
        self.done = 0
        self._called = False
        self._stream: Generator | None = None

    # What happens

    def release(self, task: Task) -> None:
        """A new task is known."""
        self.open[task.number] = task
        self.released += 1
        if task.due is not None:
            self.world.log.due[task.number] = task.due
        self.world.record("released", None, task=task.number)
        self._call()

    def wait(self, robot: Robot) -> Event:
        """A robot in a bay is free: the event is due when it is given a task."""
        return self._offer(robot)

    def ask(self, robot: Robot) -> Event:
        """A robot that has just unloaded is free: the event is due at once, with a task or without."""
        self.passing.add(robot.number)
        return self._offer(robot)

    def _offer(self, robot: Robot) -> Event:
        event = Event(self.env)
        self.free[robot.number] = robot, event
        self._call()
        return event

    def give_back(self, robot: Robot) -> None:
        """A robot cannot fetch its good after all: the task goes to the front of the list at once."""
        task = robot.job
        assert task is not None
        self.world.record("returned", robot)
        self._forget(robot)
        self.open[task.number] = task
        self.open.move_to_end(task.number, last=False)
        self._call()

    def delivered(self, robot: Robot) -> None:
        """A task is done."""
        self.world.record("delivered", robot)
        self.done += 1
        robot.delivered += 1
        assert robot.job is not None
        del self.unload_at[robot.job.number]
        robot.job = None
        robot.task = -1

    def _forget(self, robot: Robot) -> None:
        assert robot.job is not None
        del self.unload_at[robot.job.number]
        robot.job = None
        robot.task = -1
        if robot.station is not None:
            robot.station.taken -= 1
            robot.station = None

    # Decisions

    def _call(self) -> None:
        """Have the policy asked at the end of this instant."""
        if not self._called:
            self._called = True
            event = Event(self.env)
            event._ok, event._value = True, None
            event.callbacks.append(self._decide)
            self.env.schedule(event, priority=AFTER_ALL)

    def _decide(self, _: Event) -> None:
        self._called = False
        if self.open and self.free:
            robots = [self.free[number][0].view() for number in sorted(self.free)]
            for number, task in list(self.allocation.assign(self._situation(robots))):
                self._assign(number, task)
        for number in sorted(self.passing):
            self.free.pop(number)[1].succeed()
        self.passing.clear()

    def _situation(self, robots: list[RobotView]) -> Situation:
        world = self.world
        return Situation(
            time=self.env.now,
            robots=robots,
            tasks=self.open.values(),
            travel=world.travel,
            station=world.station_for,
            feasible=self._feasible,
            waits=world.waits_per_edge,
            random=self._random,
        )

    def _random(self) -> Generator:
        if self._stream is None:
            self._stream = stream(self.world.seed, "allocation")
        return self._stream

    def _feasible(self, robot: RobotView, task: Task) -> bool:
        world = self.world
        node = world.station_for(robot, task)
        station = world.stations.get(node)
        if station is not None and station.free <= 0:
            return False
        return world.model.battery is None or world.charging.may_work(
            robot, lambda: world.energy_for(robot, task, node)
        )

    def _assign(self, number: int, task_number: int) -> None:
        fault = None
        if number not in self.free:
            fault = f"robot {number} is not free"
        elif task_number not in self.open:
            fault = f"task {task_number} is not open"
        if fault:
            name = type(self.allocation).__name__
            raise PolicyError(f"policies.allocation ({name}) at time {self.env.now:g}: {fault}")
        robot, event = self.free.pop(number)
        self.passing.discard(number)
        task = self.open.pop(task_number)
        node = self.world.station_for(robot.view(), task)
        self.unload_at[task_number] = node
        robot.station = self.world.stations.get(node)
        if robot.station is not None:
            robot.station.taken += 1
        robot.job = task
        robot.task = task.number
        self.world.record("assigned", robot)
        event.succeed()
        self.world.demand.taken()
