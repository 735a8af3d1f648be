"""Decisions: pure functions of what they are shown; one module a family, one frozen dataclass a policy."""

from desim_warehouse.policies.catalogue import create, problems
from desim_warehouse.policies.protocols import (
    Allocation,
    BayView,
    Charging,
    Levels,
    Parking,
    Roads,
    RobotView,
    Routing,
    Task,
    Travel,
)
from desim_warehouse.policies.situation import Handling, Situation

__all__ = [
    "Allocation",
    "BayView",
    "Charging",
    "Handling",
    "Levels",
    "Parking",
    "Roads",
    "RobotView",
    "Routing",
    "Situation",
    "Task",
    "Travel",
    "create",
    "problems",
]
