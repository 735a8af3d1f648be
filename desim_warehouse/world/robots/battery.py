"""A robot's battery: its level at any time, computed from the last change of the rate at which energy is drawn.

Alarms predict when the battery will be flat, or must recall the robot from the way to a good.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from simpy.events import Event, Timeout

from desim_warehouse.errors import BatteryError
from desim_warehouse.model.facts import charging
from desim_warehouse.model.sections.fleet import BatterySpec
from desim_warehouse.policies import Levels
from desim_warehouse.states import STATES, TOO_LOW, Phase
from desim_warehouse.world.robots.forecast import need_now
from desim_warehouse.world.robots.reach import Reach
from desim_warehouse.world.traffic.events import Clock
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from desim_warehouse.world.robots.robot import Robot


class Battery:
    """A battery drawn from at a steady rate since the last change. `used` is the energy drawn so far."""

    __slots__ = ("_level", "_since", "capacity", "charging", "rate", "rates", "spec", "started", "used", "varies")

    def __init__(self, spec: BatterySpec | None, rates: dict[str, float]) -> None:
        self.spec = spec
        self.capacity = math.inf if spec is None else spec.capacity
        self.rates = rates
        self._level = self.capacity
        self.rate = 0.0
        self._since = 0.0
        self.used = 0.0
        self.charging = False
        self.started: float | None = None
        """Energy held at the start of the run, until the battery is charged."""
        self.varies = len(set(rates.values())) > 1
        """Whether waiting may draw at another rate than the robot's activity."""

    def start(self, level: float) -> None:
        """Set the level at the start of the run."""
        self._level = self.started = level

    def level(self, now: float) -> float:
        """Return the energy left at `now`: between changes of the rate, along a straight line or the charge curve."""
        if self.charging:
            return self._level + self.charge_gain(self._level, now - self._since)
        return self._level - self.rate * (now - self._since)

    def is_full(self, now: float) -> bool:
        """Whether the battery was full and nothing has been drawn."""
        return self.level(now) >= self.capacity

    def draw(self, now: float, rate: float) -> None:
        """Draw energy at `rate` per time unit from now on."""
        if rate == self.rate:
            return
        drawn = self.rate * (now - self._since)
        self.used += drawn
        self._level -= drawn
        self.rate = rate
        self._since = now

    def drawn(self, now: float) -> float:
        """Return the energy drawn since the start of the run."""
        return self.used + self.rate * (now - self._since)

    def plug(self, now: float) -> None:
        """Begin to charge: the robot draws nothing from the battery meanwhile."""
        self.draw(now, 0.0)
        self._since = now
        self.charging = True
        self.started = None

    def unplug(self, now: float, level: float | None = None) -> None:
        """End charging, at the level reached or at `level`."""
        self._level = min(self.level(now) if level is None else level, self.capacity)
        self._since = now
        self.charging = False

    def lasts_until(self, now: float, level: float) -> float:
        """Return when the battery falls to a level at the present rate; `now` if it already has."""
        left = self.level(now) - level
        if left <= 0:
            return now
        return now + left / self.rate if self.rate else math.inf

    def charge_time(self, start: float, end: float) -> float:
        """Return the time to charge from one level to another."""
        return 0.0 if self.spec is None else charging.charge_time(self.spec, start, end)

    def charge_gain(self, start: float, time: float) -> float:
        """Return the energy taken up in a time at the charger: the inverse of `charge_time`."""
        return 0.0 if self.spec is None else charging.charge_gain(self.spec, start, time)


class Alarms:
    """Time-outs of a robot's battery, reset when its rate changes: when it is flat, and when the robot is recalled.

    The level is computed on demand. `give_back` takes the robot's task away.
    """

    def __init__(self, env: Clock, robot: Robot, reach: Reach, give_back: Callable[[Robot], None]) -> None:
        self.env = env
        self.robot = robot
        self.reach = reach
        self.give_back = give_back
        self.looks_ahead = False
        self._flat_at = self._low_at = math.inf
        self._rate = 0.0

    def watch(self) -> None:
        """Schedule when the battery will be flat and, on the way to a good, when the robot must be recalled."""
        now, robot = self.env.now, self.robot
        battery = robot.battery
        if battery.spec is None:
            return
        if battery.rate > self._rate:  # else it is flat when the last timeout comes up, or later
            self._rate = battery.rate
            flat_at = battery.lasts_until(now, -battery.spec.reserve)
            if flat_at < self._flat_at:
                self._flat_at = flat_at
                Timeout(self.env, flat_at - now).callbacks.append(self._flat)
        if robot.job is None or robot.phase is not Phase.TO_GOOD:
            return
        levels = self.reach.levels.of(robot.view)
        self.looks_ahead = levels.margin is not None
        recall_at = self._recall_at(levels)
        robot.body.recall_from(recall_at)
        if recall_at < self._low_at:
            self._low_at = recall_at
            Timeout(self.env, self._low_at - now).callbacks.append(self._low)

    def _recall_at(self, levels: Levels) -> float:
        """Return when the task must be given back: at the critical level, or when finishing it is no longer safe.

        While the robot drives, the task's remaining need falls as fast as the energy, so only waiting reduces the spare
        energy.
        """
        now, robot = self.env.now, self.robot
        recall_at = robot.battery.lasts_until(now, levels.critical)
        if levels.margin is not None and robot.body.is_waiting and not robot.is_at_good_edge:
            need = need_now(robot, self.reach, now, levels.charger)
            recall_at = min(recall_at, robot.battery.lasts_until(now, need + levels.margin))
        return recall_at

    def _flat(self, _: Event) -> None:
        self._flat_at = math.inf
        self._rate = 0.0
        robot, now = self.robot, self.env.now
        spec = robot.battery.spec
        if spec is None or robot.battery.level(now) > 1e-9 * spec.capacity - spec.reserve:
            self.watch()
            return
        started = robot.battery.started
        low = started if started is not None and started < spec.capacity else None
        drew = robot.battery.drawn(now) / now if now else 0.0
        did = STATES[robot.state].doing if robot.state in TOO_LOW else robot.state
        raise BatteryError(
            f"robot {robot.number} ran flat at time {now:g}, {robot.body.place(now)}, {did}: "
            f"{self.reach.why_flat(low, drew, robot.view(), resting=STATES[robot.state].is_parked)}"
        )

    def _low(self, _: Event) -> None:
        self._low_at = math.inf
        robot = self.robot
        if robot.job is None or robot.phase is not Phase.TO_GOOD:
            return
        if robot.body.recall_at > self.env.now + EPS:
            self.watch()
        elif robot.is_at_good_edge:  # so near that it finishes the task
            robot.body.recall_from(math.inf)
        elif not robot.itinerary.is_declared:
            self.give_back(robot)
        elif robot.waits_to_come_out:
            self._stay()
        # else only at a node, and if another route is safe from there

    def _stay(self) -> None:
        """Give the task back beside the lanes: the robot comes onto the node as soon as that is free, and goes to bay.

        Had it to wait for room beyond the node, too, it would drive out over a lane where only one robot can be at a
        time, and back. Robots with too little energy would then keep those from their goods that have been charged.
        """
        robot, claim = self.robot, self.robot.body.claim
        assert robot.bay is not None
        assert claim is not None
        robot.itinerary.go(robot.node, robot.bay.node)
        self.give_back(robot)
        robot.body.turn_off()
        claim.give_up_room()
        claim.node.freed(self.env.now)
