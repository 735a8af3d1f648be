"""The battery levels of each robot by the charging policy, with its answers checked."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from desim_warehouse.policies import Levels, RobotView
from desim_warehouse.policies.asked import asked, fault, short
from desim_warehouse.world.traffic.events import Clock

_FIFTH = 0.2
"""A share of capacity below any that a policy means by "full"."""


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
        levels: object = asked("charging", policy, self.env.now, lambda: policy.levels(robot))
        if not isinstance(levels, Levels):
            raise fault("charging", policy, self.env.now, f"robot {robot.number}: {short(levels)} are no Levels")
        wrong = levels.fault() or _shares(levels, robot)
        if wrong is not None:
            raise fault("charging", policy, self.env.now, f"robot {robot.number}: {wrong}")
        self._fixed = levels if getattr(policy, "fixed", False) else None
        return levels


def _shares(levels: Levels, robot: RobotView) -> str | None:
    """Return the hint that charging levels seem to be shares of the capacity; None if they do not.

    No policy charges only to a fifth of a battery, so levels below that are taken for shares.
    """
    if levels.full <= 1 and levels.full < _FIFTH * robot.capacity:
        return (
            f"full is {levels.full:g} of {robot.capacity:g}, so these are shares, as it seems; expected energy, as in "
            "0.8 * robot.capacity"
        )
    return None
