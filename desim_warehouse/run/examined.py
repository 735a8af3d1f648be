"""Examination of a model before it runs, for `desim check`: mistakes, findings of the quick estimate, and the night.

Commands that simulate a model warn by it, too.
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
    """Return all findings, the worst first, and the quick estimate; None where there can be none (see `examine`).

    The night is looked at only where the model has no error that it does not accept. What takes long is bounded by
    counts, of tasks and of rows of a log, so that the findings follow from the model and not from the clock.
    """
    findings, calculation = _examined(model)
    return list(findings), calculation


@lru_cache(maxsize=16)
def _examined(model: Model) -> tuple[tuple[Finding, ...], QuickEstimate | None]:
    findings, calculation = examine(model, model.floor, measured)
    if any(item.level == "error" and item.code not in model.accept for item in findings):
        return tuple(findings), calculation
    return tuple(checks.worst_first([*findings, *night.findings(model, model.floor)])), calculation
