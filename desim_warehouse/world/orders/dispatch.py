"""Allocation: open tasks, free robots, and the allocation policy, which is asked when either changes."""

from __future__ import annotations

import math
from collections import OrderedDict, deque
from collections.abc import Iterable, Sequence
from typing import Any

from simpy.core import StopSimulation
from simpy.events import Event

from desim_warehouse.errors import PolicyError, StallError
from desim_warehouse.model.sections.policy import Policies
from desim_warehouse.outcome.log import Log
from desim_warehouse.policies import Allocation, RobotView, Situation, Task
from desim_warehouse.policies.asked import asked_for_all, fault, short
from desim_warehouse.world.orders.attempts import Attempts
from desim_warehouse.world.orders.demand import Orders
from desim_warehouse.world.orders.pods import Pods
from desim_warehouse.world.orders.situations import Situations
from desim_warehouse.world.places.bays import Bays
from desim_warehouse.world.places.stations import Stations
from desim_warehouse.world.places.stops import Stop
from desim_warehouse.world.robots.duty import Departures
from desim_warehouse.world.robots.forecast import busy_view
from desim_warehouse.world.robots.mixed_reach import MixedReach
from desim_warehouse.world.robots.reach import Reach, may_do
from desim_warehouse.world.robots.robot import Robot
from desim_warehouse.world.traffic.events import DECISIONS, Clock, end_of_instant
from desim_warehouse.world.traffic.rules import EPS

DECLINED = 20
"""Decisions per robot in a row that assign nothing, while none has a task, after which none ever will: by then robots
that draw energy at rest have been charged several times.
"""
_PAIRS = "pairs (robot number, task number)"
RETURNS = 100
"""The number of times that a task is given back before it counts as impossible."""


class Dispatcher:
    """Keep the list of open tasks, and ask the allocation policy once for all events of one instant.

    So the policy sees robots that become free at the same instant together, by number, and tasks in the order of the
    list. With policies.interval decisions wait for its next multiple. Without an allocation policy the run stops at
    every decision until `decide` is called with the answer.
    """

    def __init__(
        self,
        env: Clock,
        log: Log,
        policies: Policies,
        allocation: Allocation | None,
        *,
        open_tasks: OrderedDict[int, Task],
        robots: Sequence[Robot],
        stations: Stations,
        bays: Bays,
        departures: Departures,
        reach: Reach | MixedReach,
        situations: Situations,
        demand: Orders,
        finished: Event,
    ) -> None:
        self.env = env
        self.log = log
        self.allocation = allocation
        self._gives_only = vars(type(allocation)).get("gives_only", False)  # not inherited: a heir may do more
        self.interval = policies.interval
        self.charging = policies.charging.name
        self.robots = robots
        self.stations = stations
        self.bays = bays
        self.departures = departures
        self.reach = reach
        self.situations = situations
        self.demand = demand
        self.finished = finished
        self.open = open_tasks
        self.free: dict[int, tuple[Robot, Event]] = {}
        self.queues: dict[int, deque[Task]] = {}
        self.released = 0
        self.done = 0
        self._passing: set[int] = set()
        self._seen: dict[int, RobotView] = {}
        self._decides_at = self._looks_at = math.inf
        self.attempts = Attempts(
            env, (*departures.duty.calendars, *stations.calendars, *reach.openings.cut_off.calendars)
        )
        self._declined = 0
        self._pods: Pods | None = None

    def carry(self, pods: Pods) -> None:
        """Use the pods of a model with goods to person: tasks are then lines, which robots do by visits of pods."""
        self._pods = pods

    # Events

    def release(self, task: Task) -> None:
        """Add a new task to the list, from which it may be allocated."""
        self.announce(task)
        self.give_out(task)

    def announce(self, task: Task) -> None:
        """Record a new task that is known but not open yet."""
        self.released += 1
        self.attempts.failed = 0
        self.log.released(self.env.now, task.number, task.good, task.due, task.flow, task.order, task.item)
        if self.stations.are_for_workers(task):
            self.log.is_for_workers(task.number)

    def give_out(self, task: Task) -> None:
        """Release a task (or a whole batch) for allocation."""
        self.open[task.number] = task
        self.call()

    def wait(self, robot: Robot) -> Event:
        """Offer a robot in a bay as free; the returned event is due when it is given a task."""
        return self._offer(robot)

    def ask(self, robot: Robot) -> Event:
        """Offer a robot that has just unloaded; the returned event is due when a decision gives it a task or none."""
        self._passing.add(robot.number)
        return self._offer(robot, at_once=robot.docked is None)

    def _offer(self, robot: Robot, *, at_once: bool = False) -> Event:
        event = Event(self.env)
        self._seen.pop(robot.number, None)
        self.attempts.failed = 0
        self.free[robot.number] = robot, event
        self.call(at_once=at_once)
        return event

    def withdraw(self, robot: Robot) -> None:
        """Withdraw a robot in a bay: its battery needs a charger, or another robot needs its slot."""
        self.free.pop(robot.number, None)
        self._put_back(robot.number)

    def give_back(self, robot: Robot) -> None:
        """Take back the task of a robot whose battery does not suffice to fetch its good after all."""
        task = robot.job
        assert task is not None
        robot.charging.require()  # otherwise it would take the task again at once
        if self.reach.give_back(task) > RETURNS:
            raise PolicyError(
                f"at time {self.env.now:g} task {task.number} (good {task.good}) was given back {RETURNS} times; "
                f"no battery seems to last for it: {self.reach.why_none_lasts([robot.view()], task)}"
            )
        self.take_back(robot)

    def take_back(self, robot: Robot) -> None:
        """Take back, at once to the front of the list, the task of a robot that does not fetch its good."""
        task = robot.job
        assert task is not None
        self._record("returned", robot, task)
        if self._pods is not None:
            self._pods.returned(robot, task)
        self._put_back(robot.number)
        self._forget(robot)
        self.open[task.number] = task
        self.open.move_to_end(task.number, last=False)
        if self._pods is None:
            self.demand.returned(task)
        self.call()

    def delivered(self, robot: Robot, stop: Stop) -> None:
        """Note that a task is done. After the last task of a tour the robot is free."""
        if self._pods is not None:
            self._pods.stored(robot, stop)
        else:
            robot.record_delivery(stop)
            self.done += 1
        self.stations.forget(stop.task)
        if stop is robot.tour.stops[-1]:
            self._forget(robot)
        else:
            self.stations.release((stop,), ())

    def line_done(self, line: Task) -> None:
        """Note that a line was picked from a pod or put onto one, and so is no longer in hand."""
        self.done += 1
        self.demand.taken(line)

    def came_home(self, robot: Robot) -> None:
        """Note that a robot is back in a bay. The last one, with all goods done, ends the run (the paper's T)."""
        departures = self.departures
        if departures.is_full:
            self.call()
        departures.under_way.discard(robot.number)
        departures.changing_bay.discard(robot.number)
        self.end_if_done()

    def came_to_rest(self) -> None:
        """Note that a robot rests where it has unloaded, which may complete the run."""
        self.end_if_done()

    def end_if_done(self) -> None:
        """End the run when no robot works and the last load is delivered and, where that counts, worked on.

        Robots that take turns at chargers do not put off the end: where chargers are few, one of them is always out.
        """
        if self.departures.have_work or self.finished.triggered:
            return
        if self.done == self.demand.total and not self.stations.unfinished:
            self.finished.succeed()

    def _forget(self, robot: Robot) -> None:
        assert robot.job is not None
        self.reach.forget(robot.job)
        self.stations.release(robot.tour.stops, robot.tour.slots)
        robot.lay_down()

    def _record(self, kind: str, robot: Robot, task: Task) -> None:
        """Write a row of the log for each task of a tour."""
        for member in task.tasks:
            robot.body.work_on(member.number)
            robot.record(kind)

    def queue_of(self, robot: int) -> tuple[Task, ...]:
        """Return the tasks queued for a robot after its present one."""
        return tuple(self.queues.get(robot, ()))

    def _put_back(self, number: int) -> None:
        """Put the tasks of a robot's queue at the front of the list, in their order."""
        for task in reversed(self.queues.pop(number, ())):
            self.open[task.number] = task
            self.open.move_to_end(task.number, last=False)

    def hours_change(self, robots: Iterable[int]) -> bool:
        """Note that hours of robots begin or end, and put their queues back on the list.

        Returns False if no further change can lead to a task given out.
        """
        for number in robots:
            if not self.departures.duty.has(number):
                self._put_back(number)
        if not self.open and (self._pods is None or not self._pods.wait):
            return False
        self.call()
        self.attempts.fail()
        return not self.attempts.are_in_vain

    # Decisions

    def call(self, *, at_once: bool = False) -> None:
        """Schedule the allocation policy for the end of this instant, or of the interval.

        It comes after all other events of the instant, so that robots that become free together are seen together.
        `at_once`: for a robot that has unloaded in the lane, where it would block others until the interval is over.
        """
        now = self.env.now
        time = now
        if self.interval and not at_once:
            time = max(math.ceil(now / self.interval - 1e-9) * self.interval, now)
        if time < self._decides_at and (self.open or self._passing or self.queues or self._pods is not None):
            self._decides_at = time
            end_of_instant(self.env, DECISIONS, time - now).callbacks.append(self._decide)

    @property
    def decides_later(self) -> bool:
        """Whether the policy is asked next at a later instant."""
        return self._decides_at > self.env.now

    def _decide(self, _: Event) -> None:
        self._decides_at = math.inf
        if self.queues:
            self._next_of_queues()
        if self._pods is not None:
            self._pods.call([self._view(number) for number in self._able()])
        able = self._able() if self.open else ()
        if not able:
            self._pass()
        elif self._gives_only and self.stations.out_of_room(able):
            self._carry_out(())
        else:
            self._ask()

    def _ask(self) -> None:
        """Ask the allocation policy, unless all tasks are held back because stations or ways to them are closed."""
        situation, policy = self.situation(), self.allocation
        if not situation.tasks:
            self._carry_out(())
        elif policy is None:
            raise StopSimulation(None)
        else:
            now = self.env.now
            pairs = asked_for_all("allocation", policy, now, lambda: policy.assign(situation), self._checked, _PAIRS)
            self._carry_out(pairs)

    def _look_again(self) -> None:
        """Schedule a decision for when the first task held back by a closed station or way can be given out."""
        openings = self.reach.openings
        due, openings.due = openings.due, math.inf
        if due < self._looks_at - EPS and not self.attempts.are_in_vain:
            self._looks_at = due
            end_of_instant(self.env, DECISIONS, due - self.env.now).callbacks.append(self._look)

    def _look(self, event: Event) -> None:
        self._looks_at = math.inf
        self.attempts.fail()
        self._decide(event)

    def situation(self) -> Situation:
        """Return the situation that the allocation policy decides on now: free robots and open tasks."""
        return self.situations.now([self._view(number) for number in self._able()], self._fleet)

    def _view(self, number: int) -> RobotView:
        """Return a free robot as policies see it. While it rests only its energy can change."""
        robot, view = self.free[number][0], self._seen.get(number)
        if view is None:
            view = self._seen[number] = robot.view()
        elif view.energy != (level := robot.battery.level(self.env.now)):
            view = self._seen[number] = view._replace(energy=level)
        return view

    def _able(self) -> list[int]:
        """Return the free robots on duty, by number; robots in bays only if the cap under way is not reached."""
        free = self.free.keys() & self.departures.under_way if self.departures.is_full else self.free
        return self.departures.duty.among(sorted(free))

    def _fleet(self) -> list[RobotView]:
        """Return all robots that may be given work, by number, busy ones as they will be when free."""
        now, free, may_work, duty = self.env.now, self.free, self.departures.may_work, self.departures.duty
        return [
            self._view(robot.number) if robot.number in free else busy_view(robot, robot.reach, now)
            for robot in self.robots
            if (robot.number not in free or may_work(robot.number)) and duty.has(robot.number)
        ]

    def decide(self, pairs: Iterable[Any]) -> None:
        """Carry out a decision made outside: pairs of robot number and task number.

        Raises PolicyError if it cannot be carried out; nothing has changed then.
        """
        self._carry_out(self._checked(pairs))

    def _checked(self, pairs: Iterable[Any]) -> list[tuple[int, int]]:
        """Return the pairs of a decision as numbers; raises PolicyError if one of them cannot be carried out."""
        robots: dict[int, int] = {}
        for pair in pairs:
            try:
                number, task_number = (_whole(part) for part in pair)
            except (TypeError, ValueError, OverflowError):
                raise self._fault(f"{short(pair)} is no pair (robot number, task number){_objects(pair)}") from None
            if task_number in robots:
                raise self._fault(f"task {task_number} is given out twice")
            if not 0 <= number < len(self.robots):
                raise self._fault(f"there is no robot {number}, only 0 to {len(self.robots) - 1}")
            if task_number not in self.open:
                raise self._fault(f"task {task_number} is not open")
            robot, task = self.robots[number], self.open[task_number]
            if number not in self.free and robot.job is None:
                raise self._fault(f"robot {number} is not free and has no task, it cannot take task {task_number}")
            view = self._view(number) if number in self.free else robot.view()
            if not may_do(view, task):
                raise self._fault(f"robot {number} {_unfit(view, task)}")
            robots[task_number] = number
        return [(number, task_number) for task_number, number in robots.items()]

    def _carry_out(self, pairs: Iterable[tuple[int, int]]) -> None:
        """Carry out a checked decision."""
        before = len(self.open)
        for rank, (number, task_number) in enumerate(pairs):
            if number in self.free:
                self._assign(number, task_number, first=rank == 0)
            else:
                self._queue(number, task_number)
        self._pass()
        if self.free and self.reach.batteries:
            self._charge_the_short()
        self._look_again()
        self._declined = self._declined + 1 if len(self.open) == before and self._is_at_rest() else 0
        if self._declined > DECLINED * len(self.robots):
            raise StallError(self._nothing_given_out())

    def _is_at_rest(self) -> bool:
        """Whether only a decision can change anything: all tasks are known, none is in hand, and nothing is closed."""
        if not self.open or self.released != self.demand.total or any(robot.job is not None for robot in self.robots):
            return False
        on_duty = all(self.departures.duty.has(robot.number) for robot in self.robots)
        return on_duty and math.isinf(self.reach.openings.due) and math.isinf(self._looks_at)

    def _nothing_given_out(self) -> str:
        who = "the answers" if self.allocation is None else type(self.allocation).__name__
        return (
            f"stalled at time {self.env.now:g}: {self.done} of {self.demand.total} tasks are done; policies.allocation "
            f"({who}) gave out none of {len(self.open)} open tasks in {self._declined} decisions in a row, while "
            f"robots rested and were charged; open tasks: {list(self.open)[:10]}"
        )

    def _charge_the_short(self) -> None:
        """Send robots at rest that lack energy for the first open task to a charger, or let them wait for one."""
        for number in sorted(self.free):
            robot, event = self.free[number]
            if robot.charging.is_charging or robot.charging.must_charge or robot.battery.is_full(self.env.now):
                continue
            if not (self.open and self.reach.must_charge(self._view(number))):
                robot.have_charge()
            elif robot.at_charger or self.bays.charger_for(robot):
                del self.free[number]
                robot.charging.require()
                event.succeed()
            else:
                robot.lack_charge()

    def _pass(self) -> None:
        """Let robots that have unloaded drive on, with a task or without."""
        for number in sorted(self._passing):
            self.free.pop(number)[1].succeed()
        self._passing.clear()
        if self.open and self.departures.resting:
            self._call_to_bays()

    def _call_to_bays(self) -> None:
        """Send robots to their bays if an open task may need the station slot or departure that they hold."""
        for number in sorted(self.departures.resting):
            robot = self.robots[number]
            if robot.job is None and (robot.docked is not None or self.departures.most is not None):
                robot.give_way()

    def _fault(self, text: str) -> PolicyError:
        if self.allocation is None:
            return PolicyError(f"policies.allocation (the answer) at time {self.env.now:g}: {text}")
        return fault("allocation", self.allocation, self.env.now, text)

    def _queue(self, number: int, task_number: int) -> None:
        if not self.departures.duty.has(number):
            return  # its hours end before it could begin: the task stays on the list
        self.queues.setdefault(number, deque()).append(self.open.pop(task_number))

    def _next_of_queues(self) -> None:
        """Give free robots the tasks of their queues; tasks that are not possible return to the list."""
        for number in sorted(self.queues.keys() & self.free.keys()):
            queue = self.queues.pop(number)
            task = queue.popleft()
            self.open[task.number] = task
            self.open.move_to_end(task.number, last=False)
            if queue:
                self.queues[number] = queue
            if self.reach.feasible(self.free[number][0].view(), task) and self.departures.may_work(number):
                self._assign(number, task.number)
            elif queue:
                self._put_back(number)
                self.open.move_to_end(task.number, last=False)

    def _assign(self, number: int, task_number: int, *, first: bool = True) -> None:
        """Give a free robot a task.

        `first`: no earlier pair of this decision has been given a station's slot.
        """
        if not self.departures.may_work(number):
            return  # the cap under way is reached: robot and task wait for the next decision
        robot, event = self.free[number]
        task, view = self.open[task_number], self._view(number)
        node = self.stations.choose(view, task)
        if not self.stations.has_room(view, task, node) or not self.reach.openings.admit(view, task, node):
            return  # taken by another pair of this decision, or closed: robot and task wait for the next
        if not self.reach.may_take(view, task, node):
            if not first:
                return  # another pair of this decision took the slot at a nearer station
            # No other pair has been carried out, so the whole decision is refused.
            raise self._fault(
                f"robot {number} may not take task {task_number}: its energy, {view.energy:g}, does not let it by "
                f"policies.charging ({self.charging})"
            )
        del self.free[number], self.open[task_number]
        self.attempts.failed = 0
        self._passing.discard(number)
        stops = self.stations.stops(view, task, node)
        robot.take_up(task, stops, self.stations.reserve(stops, robot.docked))
        self.departures.under_way.add(number)
        self.departures.changing_bay.discard(number)
        self._record("assigned", robot, task)
        if self._pods is not None:
            self._pods.assigned(robot, task)
        robot.body.work_on(task.number)
        event.succeed()
        if self._pods is None:
            self.demand.taken(task)


def _whole(part: Any) -> int:
    """Return a number of a pair as int; raises ValueError, TypeError or OverflowError if it is no whole number."""
    if part != int(part):
        raise ValueError
    return int(part)


def _objects(pair: object) -> str:
    """Return the hint that a policy must return numbers, if its pair has views instead; otherwise an empty text."""
    views = isinstance(pair, tuple) and any(isinstance(part, RobotView | Task) for part in pair)
    return ", expected robot.number, task.number" if views else ""


def _unfit(robot: RobotView, task: Task) -> str:
    """Return why a robot may not do a task, in words."""
    if task.kinds and robot.kind not in task.kinds:
        return f"is of no kind that does task {task.number}: {', '.join(task.kinds)}"
    if len(task.members) > robot.loads:
        return f"carries {robot.loads}, not the {len(task.members)} loads of the tour of task {task.number}"
    return f"carries {', '.join(robot.carries)}, not the load of task {task.number}: {task.load_type}"
