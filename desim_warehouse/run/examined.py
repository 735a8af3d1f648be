"""Examination of a model before it runs, for `desim check`: mistakes, findings of the quick estimate, and the night.

Commands that simulate a model also warn of its findings.
"""

from __future__ import annotations

from functools import lru_cache

from desim_warehouse.feasibility import examine
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.findings import Finding
from desim_warehouse.layout import checks
from desim_warehouse.model import Model
from desim_warehouse.run import night
from desim_warehouse.run.quick import measured


def examined(model: Model) -> tuple[list[Finding], QuickEstimate | None]:
    """Return all findings, the worst first, and the quick estimate; None if there can be none (see `examine`).

    The night is simulated only if the model has no unaccepted error. Long parts are bounded by numbers of tasks and of
    log rows, so that the findings depend on the model and not on the clock.
    """
    findings, calculation = _examined(model)
    return list(findings), calculation


@lru_cache(maxsize=16)
def _examined(model: Model) -> tuple[tuple[Finding, ...], QuickEstimate | None]:
    findings, calculation = examine(model, model.floor, measured)
    if any(item.level == "error" and item.code not in model.accept for item in findings):
        return tuple(findings), calculation
    return tuple(checks.worst_first([*findings, *night.findings(model, model.floor)])), calculation
