"""What-if simulator for robot warehouses: `load` a model, `simulate` it, look at the run."""

from desim_warehouse._version import __version__
from desim_warehouse.errors import (
    BatteryError,
    GridlockError,
    LayoutError,
    ModelError,
    PolicyError,
    ReportError,
    SimulationError,
    StallError,
    StudyError,
    WarehouseError,
)
from desim_warehouse.model import Model, load
from desim_warehouse.run import Run, simulate

__all__ = [
    "BatteryError",
    "GridlockError",
    "LayoutError",
    "Model",
    "ModelError",
    "PolicyError",
    "ReportError",
    "Run",
    "SimulationError",
    "StallError",
    "StudyError",
    "WarehouseError",
    "__version__",
    "load",
    "simulate",
]
