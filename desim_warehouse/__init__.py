"""What-if simulator for robot warehouses: `load` a model, `simulate` it, look at the run.

Public names are imported on first use, so that `import desim_warehouse` is quick.
"""

from __future__ import annotations

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
    from desim_warehouse import plot
    from desim_warehouse.fleet_log.calibrate import calibrate
    from desim_warehouse.fleet_log.validate import validate
    from desim_warehouse.learn.asktell import steps
    from desim_warehouse.live import serve
    from desim_warehouse.live.frozen import what_if_page
    from desim_warehouse.model import Model, load
    from desim_warehouse.model.overrides import UNSET
    from desim_warehouse.orders.day import order_day
    from desim_warehouse.plants import read_layout
    from desim_warehouse.plants.export import write_layout
    from desim_warehouse.questions.best import best
    from desim_warehouse.questions.check import check
    from desim_warehouse.questions.orient import orient
    from desim_warehouse.questions.plan import plan_fleet as plan
    from desim_warehouse.questions.plan_options import plan_options
    from desim_warehouse.questions.run import Run, load_run, simulate
    from desim_warehouse.questions.size import size
    from desim_warehouse.questions.study import Results, Study
    from desim_warehouse.questions.tipping import tipping_points
    from desim_warehouse.questions.why import why
    from desim_warehouse.study.file import schema
    from desim_warehouse.study.search import Search


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
    "orders.day": ("order_day",),
    "model.overrides": ("UNSET",),
    "plants": ("read_layout",),
    "plants.export": ("write_layout",),
    "questions.best": ("best",),
    "questions.check": ("check",),
    "questions.orient": ("orient",),
    "questions.plan": ("plan_fleet",),
    "questions.plan_options": ("plan_options",),
    "questions.run": ("Run", "load_run", "simulate"),
    "questions.size": ("size",),
    "questions.study": ("Results", "Study"),
    "questions.tipping": ("tipping_points",),
    "questions.why": ("why",),
    "study.file": ("schema",),
    "study.search": ("Search",),
}
_MODULE_OF = {name: module for module, names in _HOME.items() for name in names}
_CALLED = {"plan": "plan_fleet"}
"""Public names of what has another name in its module."""
_PACKAGES = {"plot": "plot"}
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
        value = getattr(import_module(f"{__name__}.{_MODULE_OF[there]}"), there)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
