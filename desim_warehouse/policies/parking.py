"""Parking policies: where a robot goes that has nothing to fetch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.policies.protocols import BayView, RobotView, Travel


@dataclass(frozen=True)
class Home:
    """Back to the bay it started from (the paper); where that is full, to the nearest with a free place."""

    def choose(self, robot: RobotView, bays: Sequence[BayView], travel: Travel) -> str:
        """The home bay if it has a free place."""
        nodes = [bay.node for bay in bays]
        if robot.home in nodes:
            return robot.home
        return min(nodes, key=lambda node: travel.distance(robot.node, node))
