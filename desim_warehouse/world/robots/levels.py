"""The battery levels of each robot by the charging policy, with its answers checked."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from desim_warehouse.policies import Levels, RobotView
from desim_warehouse.policies.asked import asked, fault, short
from desim_warehouse.world.traffic.events import Clock


class ChargingLevels:
    """Battery levels of robots by the charging policy, asked only once if all robots have the same levels."""

    def __init__(self, env: Clock, policy: Any) -> None:
        self.env = env
        self.policy = policy
        self._fixed: Levels | None = None

    def of(self, view: Callable[[], RobotView]) -> Levels:
        """Return the levels of a robot, whose state is read only if they depend on it."""
        return self._fixed or self(view())

    def __call__(self, robot: RobotView) -> Levels:
        """Return the levels, checked."""
        if self._fixed is not None:
            return self._fixed
        policy = self.policy
        levels = asked("charging", policy, self.env.now, lambda: policy.levels(robot), partial(self._checked, robot))
        self._fixed = levels if getattr(policy, "fixed", False) else None
        return levels

    def _checked(self, robot: RobotView, levels: object) -> Levels:
        """Check the policy's answer for a robot, and return it."""
        if isinstance(levels, Levels):
            wrong = levels.fault(robot)
            if wrong is None:
                return levels
        else:
            wrong = f"{short(levels)} are no Levels"
        raise fault("charging", self.policy, self.env.now, f"robot {robot.number}: {wrong}")
