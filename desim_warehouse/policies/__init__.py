"""Decisions as pure functions of their views; a module for each family, a frozen dataclass for each policy."""

from desim_warehouse.policies.catalogue import create, problems
from desim_warehouse.policies.pods import (
    OrderAssignment,
    OrderCall,
    PodCall,
    PodChoice,
    PodStorage,
    PutCall,
    PutChoice,
    StorageCall,
)
from desim_warehouse.policies.protocols import (
    Batching,
    BayView,
    Charging,
    Levels,
    Parking,
    Roads,
    RobotView,
    Routing,
    StopPlace,
    Task,
    TaskBatch,
    Travel,
    WaitingTasks,
)
from desim_warehouse.policies.situation import Allocation, Handling, OpenTasks, Situation

__all__ = [
    "Allocation",
    "Batching",
    "BayView",
    "Charging",
    "Handling",
    "Levels",
    "OpenTasks",
    "OrderAssignment",
    "OrderCall",
    "Parking",
    "PodCall",
    "PodChoice",
    "PodStorage",
    "PutCall",
    "PutChoice",
    "Roads",
    "RobotView",
    "Routing",
    "Situation",
    "StopPlace",
    "StorageCall",
    "Task",
    "TaskBatch",
    "Travel",
    "WaitingTasks",
    "create",
    "problems",
]
