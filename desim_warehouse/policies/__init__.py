"""Decisions: pure functions of what they are shown; one module a kind, one frozen dataclass a policy."""

from desim_warehouse.policies.catalogue import create
from desim_warehouse.policies.protocols import (
    Allocation,
    BayView,
    Charging,
    Parking,
    RobotView,
    Routing,
    Situation,
    Task,
    Travel,
)

__all__ = [
    "Allocation",
    "BayView",
    "Charging",
    "Parking",
    "RobotView",
    "Routing",
    "Situation",
    "Task",
    "Travel",
    "create",
]
