"""Parking policies: the destination of an idle robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from desim_warehouse.policies.protocols import BayView, RobotView, Travel


@dataclass(frozen=True)
class Home:
    """Returns to the bay it started from (the paper); if that is full, to the nearest with a free slot.

    Source: Liu et al., ROBIO 2017, section IV.
    """

    def choose(self, robot: RobotView, bays: Sequence[BayView], travel: Travel) -> str:
        """Return the home bay, or the nearest if that is full."""
        if any(bay.node == robot.home for bay in bays):
            return robot.home
        return _nearest(robot, bays, travel)


@dataclass(frozen=True)
class Stay:
    """Returns to the bay it stood in last; if that is full, to the nearest with a free slot.

    Source: dwell points of idle vehicles; Egbelu, European J. Operational Research 71 (1993) 32-44.
    """

    def choose(self, robot: RobotView, bays: Sequence[BayView], travel: Travel) -> str:
        """Return the last bay, or the nearest if that is full."""
        if any(bay.node == robot.bay for bay in bays):
            return robot.bay
        return _nearest(robot, bays, travel)


@dataclass(frozen=True)
class NearestBay:
    """Goes to the nearest bay by driving time with a free slot; ties by the order of the model file.

    Source: nearest dwell point; Egbelu (1993).
    """

    def choose(self, robot: RobotView, bays: Sequence[BayView], travel: Travel) -> str:
        """Return the nearest bay."""
        return _nearest(robot, bays, travel)


@dataclass(frozen=True)
class Spread:
    """Goes to the bay with the fewest robots in it or on the way, then the nearest, to spread out idle robots.

    Source: distributed dwell points; Egbelu (1993).
    """

    def choose(self, robot: RobotView, bays: Sequence[BayView], travel: Travel) -> str:
        """Return the emptiest bay."""
        least = min(bay.present for bay in bays)
        return _nearest(robot, [bay for bay in bays if bay.present == least], travel)


@dataclass(frozen=True)
class WhereItIs:
    """Stays where it has put its load or pod down until the place is needed; then the nearest bay with a free slot.

    A robot rests in the lane, on the node or in the slot of the station where it unloaded. It gives way when another
    robot waits for it, and leaves when its battery needs a charger or its hours end. It leaves lanes that are closed at
    times at once; where lanes are two-way it gives way as soon as any robot waits in traffic.

    Source: dwell points of idle vehicles; Egbelu (1993).
    """

    dwells: ClassVar[bool] = True

    def choose(self, robot: RobotView, bays: Sequence[BayView], travel: Travel) -> str:
        """Return the nearest bay, for a robot that may no longer rest where it is."""
        return _nearest(robot, bays, travel)


def _nearest(robot: RobotView, bays: Sequence[BayView], travel: Travel) -> str:
    return min(bays, key=lambda bay: travel.time(robot.node, bay.node)).node
