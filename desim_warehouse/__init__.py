"""What-if simulator for robot warehouses: `load` a model, `simulate` it, look at the run.

Public names are imported on first use, so that `import desim_warehouse` is quick.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

from desim_warehouse._version import __version__
from desim_warehouse.errors import (
    BatteryError,
    CheckError,
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
from desim_warehouse.fleet_log import read_log

if TYPE_CHECKING:
    from desim_warehouse.fleet_log.calibrate import calibrate
    from desim_warehouse.fleet_log.validate import validate
    from desim_warehouse.learn.asktell import steps
    from desim_warehouse.live import serve
    from desim_warehouse.live.frozen import what_if_page
    from desim_warehouse.model import Model, load
    from desim_warehouse.model.order_day import order_day
    from desim_warehouse.model.overrides import UNSET
    from desim_warehouse.plants import read_layout
    from desim_warehouse.plants.export import write_layout
    from desim_warehouse.questions.tipping import tipping_points
    from desim_warehouse.report import plot
    from desim_warehouse.run import Run, check, simulate
    from desim_warehouse.run.folder import load_run
    from desim_warehouse.study.designs.best_of_many import best
    from desim_warehouse.study.designs.directions import orient
    from desim_warehouse.study.file import schema
    from desim_warehouse.study.fleet import plan_fleet as plan
    from desim_warehouse.study.fleet import plan_options
    from desim_warehouse.study.procedures import size
    from desim_warehouse.study.results import Results
    from desim_warehouse.study.search import Search
    from desim_warehouse.study.study import Study
    from desim_warehouse.study.why import why


_HOME = {
    "errors": (
        "BatteryError",
        "CheckError",
        "GridlockError",
        "LayoutError",
        "ModelError",
        "PolicyError",
        "ReportError",
        "SimulationError",
        "StallError",
        "StudyError",
        "WarehouseError",
    ),
    "fleet_log": ("read_log",),
    "fleet_log.calibrate": ("calibrate",),
    "fleet_log.validate": ("validate",),
    "learn.asktell": ("steps",),
    "live": ("serve",),
    "live.frozen": ("what_if_page",),
    "model": ("Model", "load"),
    "model.order_day": ("order_day",),
    "model.overrides": ("UNSET",),
    "plants": ("read_layout",),
    "plants.export": ("write_layout",),
    "questions.tipping": ("tipping_points",),
    "run": ("Run", "check", "simulate"),
    "run.folder": ("load_run",),
    "study.designs.best_of_many": ("best",),
    "study.designs.directions": ("orient",),
    "study.file": ("schema",),
    "study.fleet": ("plan_fleet", "plan_options"),
    "study.procedures": ("size",),
    "study.results": ("Results",),
    "study.search": ("Search",),
    "study.study": ("Study",),
    "study.why": ("why",),
}
_MODULE_OF = {name: module for module, names in _HOME.items() for name in names}
_CALLED = {"plan": "plan_fleet"}
"""Public names of what has another name in its module."""
_PACKAGES = {"plot": "report.plot"}
"""Public modules by name."""

__all__ = [
    "UNSET",
    "BatteryError",
    "CheckError",
    "GridlockError",
    "LayoutError",
    "Model",
    "ModelError",
    "PolicyError",
    "ReportError",
    "Results",
    "Run",
    "Search",
    "SimulationError",
    "StallError",
    "Study",
    "StudyError",
    "WarehouseError",
    "__version__",
    "best",
    "calibrate",
    "check",
    "load",
    "load_run",
    "order_day",
    "orient",
    "plan",
    "plan_options",
    "plot",
    "read_layout",
    "read_log",
    "schema",
    "serve",
    "simulate",
    "size",
    "steps",
    "tipping_points",
    "validate",
    "what_if_page",
    "why",
    "write_layout",
]


def __getattr__(name: str) -> Any:
    """Import a public name from its module."""
    from importlib import import_module

    if name in _PACKAGES:
        value: Any = import_module(f"{__name__}.{_PACKAGES[name]}")
    elif (there := _CALLED.get(name, name)) in _MODULE_OF:
        module = _MODULE_OF[there]
        if "IPython" in sys.modules:
            import_module(f"{__name__}.report.in_cells")  # how Jupyter shows things
        if module.startswith("study."):
            import_module(f"{__name__}.questions")  # what a search finds is worded there
        value = getattr(import_module(f"{__name__}.{module}"), there)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
