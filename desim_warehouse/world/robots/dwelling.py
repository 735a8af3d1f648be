"""Rest at the place of unloading: an idle robot stays where it is until that place is needed (`where-it-is`).

It may stand in a lane, on a node or in a slot of a station. In all three it affects others as an unloading robot does:
it goes on by itself, here as soon as any robot could wait for it. So work goes on as with unloading times of any length
(docs/why.md, "Resting where the load was put down"):

- In traffic: each blocked robot waits for exactly one other, and the chain ends at a robot that is not blocked. If that
  one rests, it leaves for a bay (`Gridlock.check`, called whenever a chain grows). Where lanes are two-way a refused
  step may have several reasons, so there all robots resting on lanes leave as soon as any robot waits, and none stays
  while any does.
- For a slot or a departure: if tasks stay open after a decision, robots resting in stations leave, and all resting
  robots do where the number of robots under way is capped (`Dispatcher`).
- Its own battery, hours and closures: the robot leaves at the level at which one that leaves its work goes to a
  charger, when its hours end, and does not rest in a lane that is closed at times.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from simpy.events import AnyOf, Event, Timeout

from desim_warehouse.world.places.bays import Bays
from desim_warehouse.world.robots.duty import Departures
from desim_warehouse.world.robots.surroundings import WorkGiver
from desim_warehouse.world.traffic.events import Clock, Steps
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from desim_warehouse.world.robots.reach import Reach
    from desim_warehouse.world.robots.robot import Robot
    from desim_warehouse.world.traffic.traffic import Traffic


class Dwelling:
    """The rest of a robot where it has unloaded, and what ends it. `is_allowed`: by the parking policy."""

    def __init__(
        self,
        robot: Robot,
        env: Clock,
        *,
        is_allowed: bool,
        dispatcher: WorkGiver,
        departures: Departures,
        bays: Bays,
        reach: Reach,
        traffic: Traffic,
    ) -> None:
        self.robot = robot
        self.env = env
        self.is_allowed = is_allowed
        self.dispatcher = dispatcher
        self.departures = departures
        self.bays = bays
        self.reach = reach
        self.traffic = traffic
        self._called: Event | None = None
        if is_allowed:
            traffic.gridlock.know(robot.body)

    @property
    def may_begin(self) -> bool:
        """Whether the robot may rest where it stands, unloaded and without a task."""
        robot = self.robot
        if not self.is_allowed or robot.charging.must_charge or not self.departures.duty.has(robot.number):
            return False
        lane = robot.body.lane
        if robot.docked is None and lane is not None and lane.closures:
            return False
        if self._low_at() <= self.env.now + EPS:
            return False
        return robot.docked is not None or not self.traffic.gridlock.is_waited_for(robot.body)

    def rest(self) -> Steps:
        """Rest until the robot is given a task or called away, or its battery is low enough for a charger."""
        robot, env = self.robot, self.env
        offer, self._called = self.dispatcher.wait(robot), Event(env)
        self.departures.resting.add(robot.number)
        if robot.docked is None:
            self.traffic.gridlock.rests(robot.body)
        self.dispatcher.came_to_rest()
        low = self._low_at()
        ends = [offer, self._called, *([Timeout(env, low - env.now)] if math.isfinite(low) else [])]
        while not any(end.processed for end in ends) and not self._keeps_a_charger_from_others:
            yield AnyOf(env, ends + ([self.bays.charger_sought()] if self._keeps_a_charger else []))
        self.traffic.gridlock.goes_on(robot.body)
        self.departures.resting.discard(robot.number)
        self._called = None
        if robot.job is None:
            self.dispatcher.withdraw(robot)

    def end(self) -> None:
        """Leave for a bay if the robot rests: the place is needed, or its hours are over."""
        if self._called is not None and not self._called.triggered:
            self._called.succeed()

    def _low_at(self) -> float:
        """Return when the battery will be low enough for the robot to go to a charger; inf if it never will be."""
        if not self.reach.batteries:
            return math.inf
        view = self.robot.view()
        level = self.reach.retreats_at(view, self.reach.levels(view))
        return self.robot.battery.lasts_until(self.env.now, level)

    @property
    def _keeps_a_charger(self) -> bool:
        """Whether the slot that the robot keeps, where lanes are two-way, is a slot at chargers."""
        return self.robot.bay is not None and bool(self.robot.bay.charges)

    @property
    def _keeps_a_charger_from_others(self) -> bool:
        return self._keeps_a_charger and self.bays.wants_room(self.robot)
