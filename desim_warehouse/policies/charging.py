"""Charging policies: when a robot leaves its work to charge, and when it is ready again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from desim_warehouse.policies.protocols import RobotView


@dataclass(frozen=True)
class Threshold:
    """At the battery's threshold an empty robot gives its task back and goes home, to charge full (the paper)."""

    def recall_level(self, robot: RobotView) -> float | None:
        """The threshold of the model's battery."""
        return robot.threshold

    def may_work(self, robot: RobotView, need: Callable[[], float]) -> bool:
        """Above the threshold, whatever the task."""
        return robot.energy > robot.threshold

    def ready_level(self, robot: RobotView) -> float:
        """Full."""
        return robot.capacity
