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
    from desim_warehouse.answer.answer import Answer
    from desim_warehouse.fleet_log.calibrate import Calibration, calibrate
    from desim_warehouse.fleet_log.table import FleetLog
    from desim_warehouse.fleet_log.validate import Validation, validate
    from desim_warehouse.learn.asktell import Decision, Steps, steps
    from desim_warehouse.live import Live, serve
    from desim_warehouse.live.frozen import FrozenPage, what_if_page
    from desim_warehouse.model import Model, load
    from desim_warehouse.model.overrides import UNSET
    from desim_warehouse.orders.day import OrderDay, order_day
    from desim_warehouse.plants import read_layout
    from desim_warehouse.plants.export import write_layout
    from desim_warehouse.plants.plant import Remark
    from desim_warehouse.policies import (
        Allocation,
        Batching,
        BayView,
        Charging,
        Handling,
        Levels,
        OrderAssignment,
        OrderCall,
        Parking,
        PodCall,
        PodChoice,
        PodStorage,
        PutCall,
        PutChoice,
        Roads,
        RobotView,
        Routing,
        Situation,
        StorageCall,
        Task,
        TaskBatch,
        Travel,
        WaitingTasks,
    )
    from desim_warehouse.questions.best import BestOfMany, best
    from desim_warehouse.questions.check import Check, check
    from desim_warehouse.questions.orient import BetterDirections, orient
    from desim_warehouse.questions.plan import Plan
    from desim_warehouse.questions.plan import plan_fleet as plan
    from desim_warehouse.questions.plan.options import OptionsPlan, plan_options
    from desim_warehouse.questions.race import Best
    from desim_warehouse.questions.run import Run, load_run, simulate
    from desim_warehouse.questions.size import Size, size
    from desim_warehouse.questions.study import Comparison, MainEffects, Results, Study
    from desim_warehouse.questions.tipping import TippingPoints, tipping_points
    from desim_warehouse.questions.why import Why, why
    from desim_warehouse.replay import Replay
    from desim_warehouse.report.write import read_answer as load_answer
    from desim_warehouse.report.write import report as write_report
    from desim_warehouse.study.file import schema
    from desim_warehouse.study.search import Search


_HOME = {
    "answer.answer": "Answer",
    "errors": "BatteryError CheckError GridlockError LayoutError ModelError PolicyError ReportError SimulationError "
    "StallError StudyError WarehouseError",
    "fleet_log": "read_log",
    "fleet_log.calibrate": "Calibration calibrate",
    "fleet_log.table": "FleetLog",
    "fleet_log.validate": "Validation validate",
    "learn.asktell": "Decision Steps steps",
    "live": "Live serve",
    "live.frozen": "FrozenPage what_if_page",
    "model": "Model load",
    "model.overrides": "UNSET",
    "orders.day": "OrderDay order_day",
    "plants": "read_layout",
    "plants.export": "write_layout",
    "plants.plant": "Remark",
    "policies": "Allocation Batching BayView Charging Handling Levels OrderAssignment OrderCall Parking PodCall "
    "PodChoice PodStorage PutCall PutChoice Roads RobotView Routing Situation StorageCall Task TaskBatch Travel "
    "WaitingTasks",
    "questions.best": "BestOfMany best",
    "questions.check": "Check check",
    "questions.orient": "BetterDirections orient",
    "questions.plan": "Plan plan",
    "questions.plan.options": "OptionsPlan plan_options",
    "questions.race": "Best",
    "questions.run": "Run load_run simulate",
    "questions.size": "Size size",
    "questions.study": "Comparison MainEffects Results Study",
    "questions.tipping": "TippingPoints tipping_points",
    "questions.why": "Why why",
    "replay": "Replay",
    "report.write": "load_answer write_report",
    "study.file": "schema",
    "study.search": "Search",
}
"""Modules that public names are imported from, each with its names."""
_MODULE_OF = {name: module for module, names in _HOME.items() for name in names.split()}
_CALLED = {"plan": "plan_fleet", "load_answer": "read_answer", "write_report": "report"}
"""Public names of functions that have another name in their module."""

__all__ = [
    "UNSET",
    "Allocation",
    "Answer",
    "Batching",
    "BatteryError",
    "BayView",
    "Best",
    "BestOfMany",
    "BetterDirections",
    "Calibration",
    "Charging",
    "Check",
    "CheckError",
    "Comparison",
    "Decision",
    "FleetLog",
    "FrozenPage",
    "GridlockError",
    "Handling",
    "LayoutError",
    "Levels",
    "Live",
    "MainEffects",
    "Model",
    "ModelError",
    "OptionsPlan",
    "OrderAssignment",
    "OrderCall",
    "OrderDay",
    "Parking",
    "Plan",
    "PodCall",
    "PodChoice",
    "PodStorage",
    "PolicyError",
    "PutCall",
    "PutChoice",
    "Remark",
    "Replay",
    "ReportError",
    "Results",
    "Roads",
    "RobotView",
    "Routing",
    "Run",
    "Search",
    "SimulationError",
    "Situation",
    "Size",
    "StallError",
    "Steps",
    "StorageCall",
    "Study",
    "StudyError",
    "Task",
    "TaskBatch",
    "TippingPoints",
    "Travel",
    "Validation",
    "WaitingTasks",
    "WarehouseError",
    "Why",
    "__version__",
    "best",
    "calibrate",
    "check",
    "load",
    "load_answer",
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
    "write_report",
]


if not TYPE_CHECKING:  # a type checker would let every misspelt name pass

    def __getattr__(name: str) -> Any:
        """Import a public name from its module."""
        from importlib import import_module

        if name == "plot":
            value: Any = import_module(f"{__name__}.plot")
        elif name in _MODULE_OF:
            value = getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), _CALLED.get(name, name))
        else:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted(__all__)
