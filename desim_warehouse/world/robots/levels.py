"""The charging policy, asked and its answer checked: the battery levels that hold for a robot."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import PolicyError, shown
from desim_warehouse.policies import Levels, RobotView
from desim_warehouse.policies.asked import asked

if TYPE_CHECKING:
    from simpy import Environment


class ChargingLevels:
    """Asks the charging policy for the battery levels that hold for a robot, only once if they are the same for all."""

    def __init__(self, env: Environment, policy: Any) -> None:
        self.env = env
        self.policy = policy
        self._fixed: Levels | None = None

    def of(self, view: Callable[[], RobotView]) -> Levels:
        """Those of a robot, which is looked at only if they depend on what it does."""
        return self._fixed or self(view())

    def __call__(self, robot: RobotView) -> Levels:
        """The levels, checked."""
        if self._fixed is not None:
            return self._fixed
        policy = self.policy
        levels: object = asked("charging", policy, self.env.now, lambda: policy.levels(robot))
        fault = levels.fault() if isinstance(levels, Levels) else f"{shown(levels)} are no Levels"
        if fault is None and isinstance(levels, Levels):
            self._fixed = levels if getattr(policy, "fixed", False) else None
            return levels
        raise PolicyError(
            f"policies.charging ({type(policy).__name__}) at time {self.env.now:g}, robot {robot.number}: {fault}"
        )
