"""Charging at a bay's chargers: when it begins, how far it goes, and when the robot is free for work again.

Robots at rest take turns at chargers. Where there are fewer slots at chargers than robots, a free slot goes to the
robot with the least energy among those that seek one. A robot being charged leaves its charger to a seeker, if it can
drive to a bay and rest there for a while, and

- it is free for work, and has 20 % of its capacity more than the seeker, or
- the seeker's need is urgent: it has lost a quarter of the energy that it had beyond the way to a charger when it began
  to seek one. Then the first must have more by half of that energy, and by 5 % of its capacity at least, and it must
  have been charged for as long as the seeker takes to drive up.

Why robots do not run flat. Let n robots rest that draw d each, at c chargers that give r, with (n - c) d <= c r. If all
seek at once, a charger passes on when a robot has gained X on the next, after X / (r + d). The last waits for n / c - 1
such turns, and so falls by no more than X, as d <= c r / (n - c). X is half of the energy that robots have beyond the
way, and they have three quarters. The first condition makes turns longer where the level is below that half: with m for
the remaining part, a turn gains 1 - m, and after the other half of the round the last has 1 - 0.5 e^0.5, 18 % of the
energy beyond the way. So no robot runs flat except for the cost of changing places: the time to drive up, and the drive
there and back, which no proof covers (`tests/laws/test_nights.py` tests it). Swaps are not broken off.

A bay with a charger for each slot keeps its robots at rest full, so they draw nothing, as in the paper's zones.
Elsewhere a robot that rests or queues draws as a standing one does, and is charged again at the level at which a robot
that leaves its work would go to charge.

So at least half of the time goes into charging. Otherwise, with batteries that are full within a minute, chargers stood
idle for most of the time while robots drove up, and levels fell together, as lower ones make turns shorter still: no
robot had enough for a task any more, though a full charge would have taken less time than the drive.

Each turn takes up 5 % of a battery or more, so nothing oscillates. Robots that wait in a bay with more slots than
chargers take part: otherwise three queued and ran flat until the fourth was full.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import TYPE_CHECKING

from simpy.events import AnyOf, Event, Timeout

from desim_warehouse.model.facts.charging import LEAST_CHARGE
from desim_warehouse.policies import Levels
from desim_warehouse.states import Phase
from desim_warehouse.world.places.bays import Bay, Bays
from desim_warehouse.world.places.chargers import Chargers, FailingChargers, NewBattery
from desim_warehouse.world.robots.surroundings import WorkGiver
from desim_warehouse.world.traffic.events import AFTER_DECISIONS, Clock, Steps, end_of_instant
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from desim_warehouse.world.robots.reach import Reach
    from desim_warehouse.world.robots.robot import Robot


TURN = 0.2
"""The lead, as a share of its capacity, at which a robot leaves its charger to a seeker that is not in urgent need."""


class ChargingStop:
    """The stay of a robot at the chargers of its bay.

    If its charger fails, the robot is interrupted and continues at another. `must_charge`: it takes no task before it
    has charged. `is_charging`: it charges or queues for a charger, and takes no task meanwhile. `has_charged`: it has
    charged since it last went out. If it goes out to work, C counts the charge.
    """

    def __init__(self, robot: Robot, env: Clock, *, dispatcher: WorkGiver, reach: Reach, bays: Bays) -> None:
        self.robot = robot
        self.env = env
        self.dispatcher = dispatcher
        self.reach = reach
        self.bays = bays
        self.must_charge = self.is_charging = self.has_charged = False
        self._begun = 0.0

    def require(self) -> None:
        """Require the robot to charge before it takes a task."""
        self.must_charge = True

    def waive(self) -> None:
        """Let the robot take a task without charging."""
        self.must_charge = False

    def begins_again_at(self) -> float:
        """Return the level at which a robot that rests beside chargers, not connected, is charged again."""
        levels = self.reach.levels.of(self.robot.view)
        return min(max(levels.good, levels.critical), levels.full - LEAST_CHARGE * self.robot.battery.capacity)

    def charge(self, *, again: bool = False) -> Generator[Event, object, Event | None]:
        """Charge at one of the bay's chargers if the battery needs it; the robot is free once it has enough for a task.

        `again`: charge above `good`, too, as the robot was charging when the run began, or has rested until it was low.

        Returns the event of a robot that is free now, as given by `wait` of the dispatcher.
        """
        robot = self.robot
        battery, bay = robot.battery, robot.bay
        assert bay is not None
        if battery.spec is None or bay.chargers is None or robot.kind not in bay.charges:
            return None
        robot.enter(robot.at_rest)
        levels, level = self.reach.levels.of(robot.view), battery.level(self.env.now)
        if level < levels.full and (again or levels.top_up or self.must_charge or level <= levels.good):
            ready = level >= levels.sufficient and not self.must_charge
            return (yield from self._charge_at(bay, bay.chargers, self.dispatcher.wait(robot) if ready else None))
        return None

    def _charge_at(
        self, bay: Bay, chargers: Chargers | FailingChargers, offer: Event | None
    ) -> Generator[Event, object, Event | None]:
        """Charge up to `sufficient` in any case, and from there to `full` only until there is a task.

        A robot that must charge takes up `LEAST_CHARGE` at least. Otherwise it could be recalled and take the next task
        over and over at one instant. `offer` is the event of a robot that is free already. Returns the event of a robot
        that is free now.
        """
        env, robot = self.env, self.robot
        battery, levels = robot.battery, self.reach.levels.of(robot.view)
        least = levels.sufficient
        if self.must_charge:
            least = min(max(least, battery.level(env.now) + LEAST_CHARGE * battery.capacity), levels.full)
        self.is_charging, self.must_charge = True, False
        new = None if levels.swap_time is None else NewBattery(levels.swap_time, bay.spares.get(robot.kind))
        failed = True
        while failed:
            has_lost_one = robot.phase is Phase.CHARGING
            with chargers.turn(first=has_lost_one) as turn:
                if not turn.triggered:
                    robot.enter("queueing" if offer is None else robot.at_rest)
                    yield from self._wait(turn if offer is None else turn | offer)
                else:
                    yield turn
                self.is_charging = robot.job is None
                if robot.job is not None:
                    return offer
                robot.enter("charging")
                begun, lost = env.now, chargers.outage_of(turn)
                if new is None:
                    offer, failed = yield from self._fill(levels, least, offer, lost)
                else:
                    failed = yield from self._swap(new, levels.full, lost)
                self.has_charged = self.has_charged or env.now > begun
        self.is_charging = False
        return offer

    def _wait(self, due: Event) -> Steps:
        """Wait for a charger or a task; robots at a charger know of the wait."""
        bay = self.robot.bay
        assert bay is not None
        bay.waiting.append(self.robot)
        self.bays.tell_sought()
        yield due
        bay.waiting.remove(self.robot)

    def _swap(self, new: NewBattery, full: float, lost: Event | None) -> Generator[Event, object, bool]:
        """Swap the battery: take it out, wait for a full one if spares are counted, and put that in.

        Returns True if the charger fails (`lost`) before the end; the robot then continues the swap at another.
        """
        env, battery = self.env, self.robot.battery
        for wait in new.waits(env, battery.charge_time(battery.level(env.now), full)):
            yield wait if lost is None else wait | lost
            if not wait.processed:
                new.interrupt(env.now)
                return True
        battery.unplug(env.now, full)
        return False

    def _fill(
        self, levels: Levels, least: float, offer: Event | None, lost: Event | None
    ) -> Generator[Event, object, tuple[Event | None, bool]]:
        """Fill the battery up to `least` and then, free for a task, to the need of the first open one.

        Returns, beside the event, True if the charger fails (`lost`) before the end.
        """
        env, robot, battery = self.env, self.robot, self.robot.battery
        level, self._begun = battery.level(env.now), env.now
        battery.plug(env.now)
        if offer is None:
            done = Timeout(env, battery.charge_time(level, least))
            while not (done.processed or _has_failed(lost) or self._is_needed()):
                yield self._first_of(done, lost)
            if not done.processed:
                battery.unplug(env.now)
                if not _has_failed(lost):
                    self._make_room()
                return None, _has_failed(lost)
            level = max(level, least)
            if level < levels.full:
                offer = self.dispatcher.wait(robot)
                if self.reach.scarce:
                    yield offer | end_of_instant(env, AFTER_DECISIONS)  # a task, or robots that seek a charger
        while offer is not None and level < levels.full and robot.job is None:
            if self._is_needed(free=True):
                self._make_room()
                offer = None
                break
            goal = self.reach.enough_for_first(robot.view(), levels)
            goal = goal if level < goal < levels.full else levels.full
            done = Timeout(env, battery.charge_time(level, goal))
            yield self._first_of(offer, done, lost, free=True)
            level = goal if done.processed else battery.level(env.now)
            if _has_failed(lost) and robot.job is None and not done.processed:
                battery.unplug(env.now, level)
                return offer, True
            if done.processed and robot.job is None:
                self.dispatcher.call()
        battery.unplug(env.now, level)
        return offer, False

    @property
    def _takes_turns(self) -> bool:
        """Whether other robots may need the charger, because robots outnumber chargers or the slots at them."""
        bay = self.robot.bay
        return self.reach.scarce or (bay is not None and not bay.charges_every_slot)

    def _make_room(self) -> None:
        """Leave the charger to a robot that waits in the bay, or the slot to a robot elsewhere."""
        assert self.robot.bay is not None
        if self.bays.neediest(self.robot) in self.robot.bay.waiting:
            self.dispatcher.withdraw(self.robot)
        else:
            self.robot.make_room()

    def _first_of(self, *events: Event | None, free: bool = False) -> Event:
        """Return an event for the first of some events, or for the next check whether another needs the charger more.

        It is made anew for every check, from plain events: SimPy removes those of a nested condition once that has
        occurred.
        """
        awaited = [event for event in events if event is not None]
        if self._takes_turns:
            awaited.append(self.bays.charger_sought())
            time = self._needed_in(free=free)
            if EPS < time < math.inf:
                awaited.append(Timeout(self.env, time))
        return AnyOf(self.env, awaited) if len(awaited) > 1 else awaited[0]

    def _is_needed(self, *, free: bool = False) -> bool:
        """Whether the robot cedes its charger to one in greater need; a robot `free` for work remains able to work."""
        if not self._takes_turns or self._needed_in(free=free) > EPS:
            return False
        bay = self.robot.bay
        assert bay is not None
        if self.bays.neediest(self.robot) not in bay.waiting and not self.bays.wants_room(self.robot):
            return False
        if self._needed_in() <= EPS:
            return True
        view = self.robot.view()
        return view.energy >= self.reach.enough_after_parking(view, self.reach.levels(view))

    def _needed_in(self, *, free: bool = False) -> float:
        """Return the time until the robot has so much more energy than the neediest seeker that it makes way.

        A robot that is `free` for work makes way for any seeker; otherwise it does so only for a seeker in urgent need.
        """
        robot, now = self.robot, self.env.now
        battery, seeker = robot.battery, self.bays.neediest(robot)
        if seeker is None:
            return math.inf
        urgent, ahead = seeker.need_of_charger()

        view, level = robot.view(), battery.level(now)
        stays = battery.charge_time(level, self.reach.rests_elsewhere_from(view, self.reach.levels(view)))

        def gains(part: float) -> float:
            return max(stays, battery.charge_time(level, battery.capacity * (seeker.charge_left() + part)))

        bay = robot.bay
        assert bay is not None
        comes_in = 0.0 if seeker in bay.waiting else seeker.comes_in(bay.node)
        needed = max(urgent - now, gains(ahead), self._begun + comes_in - now)
        return min(needed, gains(TURN)) if free else needed


def _has_failed(lost: Event | None) -> bool:
    """Whether a charger has failed; with `lost` None it never does."""
    return lost is not None and lost.processed
