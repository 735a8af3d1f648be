"""Who gets which task: open tasks, robots that are free, and the allocation policy asked when either changes."""

from __future__ import annotations

import math
from collections import Counter, OrderedDict, deque
from typing import TYPE_CHECKING, Any

from simpy.core import StopSimulation
from simpy.events import Event, EventPriority

from desim_warehouse.errors import PolicyError
from desim_warehouse.world.decisions import asked
from desim_warehouse.world.lanes import EPS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from desim_warehouse.policies import Allocation, Task
    from desim_warehouse.world.powered import Powered
    from desim_warehouse.world.world import World

AFTER_ALL = EventPriority(2)
"""Priority of a decision among the events of one instant: after all that happens at that time."""


RETURNS = 100
"""A task that is given back so often will never be done."""


class Dispatcher:
    """Keeps the list of open tasks and asks the allocation policy once for all that happens at one instant.

    With policies.interval decisions wait for its next multiple. Without an allocation policy the run stops at every
    decision (`waiting`) until `decide` is told the answer.
    """

    def __init__(self, world: World, allocation: Allocation | None) -> None:
        self.world = world
        self.env = world.env
        self.allocation = allocation
        self.interval = world.model.policies.interval
        self.open: OrderedDict[int, Task] = OrderedDict()
        self.free: dict[int, tuple[Powered, Event]] = {}
        self.passing: set[int] = set()
        self.queues: dict[int, deque[Task]] = {}
        self.unload_at: dict[int, str] = {}
        self.heading: Counter[str] = Counter()
        self.returned: Counter[int] = Counter()
        self.released = 0
        self.done = 0
        self.waiting = False
        self._called = False

    # What happens

    def release(self, task: Task) -> None:
        """A new task is known."""
        self.open[task.number] = task
        self.released += 1
        self.world.log.released(self.env.now, task.number, task.good, task.due)
        self.call()

    def wait(self, robot: Powered) -> Event:
        """A robot in a bay is free: the event is due when it is given a task."""
        return self._offer(robot)

    def ask(self, robot: Powered) -> Event:
        """A robot that has just unloaded is free: the event is due at once, with a task or without."""
        self.passing.add(robot.number)
        return self._offer(robot)

    def _offer(self, robot: Powered) -> Event:
        event = Event(self.env)
        self.free[robot.number] = robot, event
        self.call()
        return event

    def withdraw(self, robot: Powered) -> None:
        """A robot in a bay is no longer free: its battery wants a charger, or another robot wants its place."""
        self.free.pop(robot.number, None)
        self._put_back(robot.number)

    def give_back(self, robot: Powered) -> None:
        """A robot cannot fetch its good after all: the task goes to the front of the list at once."""
        task = robot.job
        assert task is not None
        self.world.record("returned", robot)
        self.returned[task.number] += 1
        if self.returned[task.number] > RETURNS:
            raise PolicyError(
                f"policies.charging ({self.world.model.policies.charging.name}) at time {self.env.now:g}: task "
                f"{task.number} (good {task.good}) was given back {RETURNS} times; no battery seems to last for it"
            )
        self._put_back(robot.number)
        self._forget(robot)
        self.open[task.number] = task
        self.open.move_to_end(task.number, last=False)
        self.call()

    def delivered(self, robot: Powered) -> None:
        """A task is done."""
        self.world.record("delivered", robot)
        self.done += 1
        robot.delivered += 1
        self._forget(robot)

    def _forget(self, robot: Powered) -> None:
        assert robot.job is not None
        self.heading[self.unload_at.pop(robot.job.number)] -= 1
        robot.job = None
        robot.task = -1
        if robot.station is not None:
            robot.station.taken -= 1
            robot.station = None

    def _put_back(self, number: int) -> None:
        """The tasks of a robot's queue go to the front of the list, in their order."""
        for task in reversed(self.queues.pop(number, ())):
            self.open[task.number] = task
            self.open.move_to_end(task.number, last=False)

    # Decisions

    def call(self) -> None:
        """Have the policy asked at the end of this instant, or of the interval."""
        if not self._called:
            self._called = True
            event = Event(self.env)
            event._ok, event._value = True, None
            event.callbacks.append(self._decide)
            delay = 0.0
            if self.interval:
                delay = max(math.ceil(self.env.now / self.interval - 1e-9) * self.interval - self.env.now, 0.0)
            self.env.schedule(event, priority=AFTER_ALL, delay=delay)

    def _decide(self, _: Event) -> None:
        self._called = False
        if self.queues:
            self._next_of_queues()
        if not (self.open and self.free):
            self._pass()
        elif self.allocation is None:
            self.waiting = True
            raise StopSimulation(None)
        else:
            situation = self.world.shown.situation()
            policy = self.allocation
            self.decide(asked("allocation", policy, self.env.now, lambda: list(policy.assign(situation))))

    def decide(self, pairs: Iterable[Any]) -> None:
        """Carry out a decision: pairs of robot number and task number, checked one by one."""
        self.waiting = False
        given: set[int] = set()
        for pair in pairs:
            try:
                number, task_number = (int(part) for part in pair)
            except (TypeError, ValueError):
                raise self._fault(f"{pair!r} is no pair (robot number, task number)") from None
            if task_number in given:
                raise self._fault(f"task {task_number} is given out twice")
            if not 0 <= number < len(self.world.robots):
                raise self._fault(f"there is no robot {number}, only 0 to {len(self.world.robots) - 1}")
            if task_number not in self.open:
                raise self._fault(f"task {task_number} is not open")
            given.add(task_number)
            if number in self.free:
                self._assign(number, task_number)
            else:
                self._queue(number, task_number)
        self._pass()
        if self.open and self.free and self.world.model.battery is not None:
            self._charge_the_short()

    def _charge_the_short(self) -> None:
        """Robots at rest whose energy does not let them take the first open task charge, whatever their level."""
        for number in sorted(self.free):
            robot, event = self.free[number]
            if robot.plugged or robot.short or robot.battery.is_full(self.env.now) or not self.short(robot):
                continue
            if not robot.at_charger and not self.world.parking.charger_for(robot):
                continue
            del self.free[number]
            robot.short = True
            event.succeed()

    def short(self, robot: Powered) -> bool:
        """Whether a robot's energy, below full, does not let it take the first open task."""
        task = next(iter(self.open.values()), None)
        view = robot.view()
        if task is None or view.energy >= self.world.decisions.levels(view).full - EPS * view.capacity:
            return False
        return not self.world.shown.lasts(view, task)

    def _pass(self) -> None:
        """Robots that have unloaded go on, with a task or without."""
        for number in sorted(self.passing):
            self.free.pop(number)[1].succeed()
        self.passing.clear()

    def _fault(self, fault: str) -> PolicyError:
        name = "the answer" if self.allocation is None else type(self.allocation).__name__
        return PolicyError(f"policies.allocation ({name}) at time {self.env.now:g}: {fault}")

    def _queue(self, number: int, task_number: int) -> None:
        robot = self.world.robots[number]
        if robot.job is None:
            raise self._fault(f"robot {number} is not free and has no task, it cannot take task {task_number}")
        self.queues.setdefault(number, deque()).append(self.open.pop(task_number))

    def _next_of_queues(self) -> None:
        """Free robots go on with their queues; a queue that its robot may not go on with goes back to the list."""
        for number in sorted(self.queues.keys() & self.free.keys()):
            queue = self.queues.pop(number)
            task = queue.popleft()
            self.open[task.number] = task
            self.open.move_to_end(task.number, last=False)
            if queue:
                self.queues[number] = queue
            if self.world.shown.feasible(self.free[number][0].view(), task):
                self._assign(number, task.number)
            elif queue:
                self._put_back(number)
                self.open.move_to_end(task.number, last=False)

    def _assign(self, number: int, task_number: int) -> None:
        robot, event = self.free[number]
        task, view, shown = self.open[task_number], robot.view(), self.world.shown
        if not shown.may_work(view, task):
            raise self._fault(
                f"robot {number} may not take task {task_number}: its energy, {view.energy:g}, does not let it by "
                f"policies.charging ({self.world.model.policies.charging.name})"
            )
        node = shown.station(view, task)
        station = self.world.stations.get(node)
        if not shown.room(view, node):
            return  # taken by another pair of this decision: robot and task wait for the next
        del self.free[number], self.open[task_number]
        self.passing.discard(number)
        self.unload_at[task_number] = node
        self.heading[node] += 1
        robot.station = station
        if station is not None:
            station.taken += 1
        robot.job = task
        robot.short = False
        robot.task = task.number
        self.world.record("assigned", robot)
        event.succeed()
        self.world.demand.taken()
