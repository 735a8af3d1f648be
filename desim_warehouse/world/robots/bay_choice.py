"""The choice of a bay for a robot that leaves its work: by the parking policy, checked, or a charger."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.policies import BayView, RobotView
from desim_warehouse.policies.asked import asked, fault, short
from desim_warehouse.world.places.bays import Bay
from desim_warehouse.world.robots.reach import Reach
from desim_warehouse.world.traffic.events import Clock
from desim_warehouse.world.traffic.rules import EPS


class BayChoice:
    """Choose a bay for a robot that leaves its work: a charger if its battery needs one, else by the policy."""

    def __init__(self, env: Clock, policy: Any, travel: FreeTravel, reaches: Mapping[str, Reach]) -> None:
        self.env = env
        self.policy = policy
        self.travel = travel
        self.reaches = reaches
        self.lets_dwell: bool = getattr(policy, "dwells", False)
        self._own_chargers = len(set(map(id, reaches.values()))) > 1

    def choose(self, robot: RobotView, bays: Sequence[Bay], *, must_charge: bool) -> Bay:
        """Return one of `bays`, which have room, for a robot to go to; with `must_charge` it charges at any level."""
        reach = self.reaches[robot.kind]
        if reach.batteries:
            levels = reach.levels(robot)
            if must_charge or robot.energy <= reach.retreats_at(robot, levels) + EPS * robot.capacity:
                chargers = [bay for bay in bays if robot.kind in bay.charges]
                if chargers:
                    return self._charger(robot, levels.charger, self._theirs(robot, chargers))
                if reach.chargers:
                    return self._near_chargers(robot, bays)
        return self.parking(robot, bays)

    def parking(self, robot: RobotView, bays: Sequence[Bay]) -> Bay:
        """Return the bay of `bays` that the parking policy chooses for a robot."""
        policy, now = self.policy, self.env.now
        bays = self._theirs(robot, bays)
        views = [_view(bay) for bay in bays]

        def bay_at(node: object) -> Bay:
            for bay in bays:
                if bay.node == node:
                    return bay
            raise fault("parking", policy, now, f"{short(node)} is no bay with a free slot for robot {robot.number}")

        return asked("parking", policy, now, lambda: policy.choose(robot, views, self.travel), bay_at)

    def _theirs(self, robot: RobotView, bays: Sequence[Bay]) -> Sequence[Bay]:
        """Return the bays where a robot blocks no other: bays with chargers for other kinds alone come last.

        Bays with chargers for all kinds are left out while a slot is free at chargers for the robot's kind alone.
        """
        if not self._own_chargers:
            return bays
        theirs = [bay for bay in bays if not bay.charges or robot.kind in bay.charges]
        if any(bay.charges and len(bay.charges) < len(self.reaches) for bay in theirs):
            return [bay for bay in theirs if len(bay.charges) < len(self.reaches)]
        return theirs or bays

    def _near_chargers(self, robot: RobotView, bays: Sequence[Bay]) -> Bay:
        """Choose a bay to wait in near chargers that are all taken."""
        ways, reach = self.travel.ways, self.reaches[robot.kind]
        return min(bays, key=lambda bay: ways.time(robot.node, bay.node) + reach.out_of(bay.node, robot))

    def _charger(self, robot: RobotView, choice: str, bays: Sequence[Bay]) -> Bay:
        """Return the charger of the robot's home, the nearest one, or the one with the fewest robots per charger."""
        if choice == "own":
            for bay in bays:
                if bay.node == robot.home:
                    return bay

        def rank(bay: Bay) -> tuple[float, float]:
            time = self.travel.ways.time(robot.node, bay.node)
            assert bay.chargers is not None
            return (bay.taken / bay.chargers.capacity if choice == "least-loaded" else 0.0), time

        return min(bays, key=rank)


def _view(bay: Bay) -> BayView:
    return BayView(bay.node, bay.free, 0 if bay.chargers is None else int(bay.chargers.capacity), bay.taken)
