"""Evidence on whether a warehouse keeps up with demand, from a run and the check of its model."""

from __future__ import annotations

import math
from dataclasses import dataclass

from desim_warehouse.errors import WarehouseError
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.feasibility.loads import loads as foreseen_loads
from desim_warehouse.outcome.loads import left_waiting
from desim_warehouse.outcome.loads import loads as measured_loads
from desim_warehouse.run import RunData
from desim_warehouse.run.examined import examined

MOST_ASKED = 0.95
"""Utilisation from which on a queue may grow without showing in a run of some hours."""
OVERLOADS = ("DEMAND_ABOVE_STATIONS", "DEMAND_ABOVE_FLEET", "CHARGERS_SHORT")
"""Findings of the check that imply unbounded growth of work, or of the energy that batteries lack, the surest first."""
FOR_A_TIME = "PEAK_ABOVE_FLEET"
"""The finding that work piles up in the busiest hour."""


@dataclass(frozen=True)
class Lasting:
    """The evidence on whether a run keeps up with the tasks that arrive (a stable queue), from the run and its check.

    `overload`: the code of the check's finding. `scarce`, `asked`: the resource with a utilisation above `MOST_ASKED`,
    and this utilisation; "" and 0 if there is none. `grown`: increase, since counting began, of the number of open
    tasks that no robot has; 0 unless it exceeds `allowed`, the square root of the number of tasks that came.
    `piles_up_at_peak`: whether work piles up in the busiest hour, by the check. `unknown`: the reason why the model
    could not be checked.
    """

    overload: str = ""
    scarce: str = ""
    asked: float = 0.0
    grown: int = 0
    allowed: float = 0.0
    piles_up_at_peak: bool = False
    unknown: str = ""

    @property
    def keeps_up(self) -> bool:
        """Whether the run, with the check of its model, proves that the warehouse keeps up."""
        return not (self.overload or self.scarce or self.grown or self.unknown)


def lasting(run: RunData) -> Lasting | None:
    """Judge whether a run keeps up with the tasks that arrive; None if none arrive by themselves."""
    if "backlog_growth_per_hour" not in run.kpis:
        return None
    try:
        findings, estimate = examined(run.model)
    except WarehouseError as error:  # a file of orders that is no longer there, beside a run that was saved
        return Lasting(unknown=str(error))
    codes = {item.code for item in findings}
    asked = _asked(run, estimate)
    scarce = max(asked, key=asked.__getitem__, default="")
    is_scarce = bool(scarce) and asked[scarce] > MOST_ASKED
    grown, allowed = left_waiting(run.history)
    return Lasting(
        overload=next((code for code in OVERLOADS if code in codes), ""),
        scarce=scarce if is_scarce else "",
        asked=asked[scarce] if is_scarce else 0.0,
        grown=grown if grown > allowed else 0,
        allowed=allowed,
        piles_up_at_peak=FOR_A_TIME in codes,
    )


def _asked(run: RunData, estimate: QuickEstimate | None) -> dict[str, float]:
    """Return for each group the share of its capacity that its peak demands: the larger of measured and foreseen.

    A run alone measures less if fewer tasks come than on average, or while batteries still hold their initial energy.
    What robots wait for keeps them from work, too.
    """
    asked = {
        load.group.name: min(load.worst + load.held, 1.0)
        for load in measured_loads(run.history, run.kpis)
        if load.group.kind != "lanes"
    }
    for load in () if estimate is None or estimate.rate is None else foreseen_loads(run.model, estimate):
        asked[load.group.name] = max(asked.get(load.group.name, 0.0), load.worst)
    needed = 0.0 if estimate is None else estimate.robots_needed or 0.0
    if estimate is not None and not estimate.subfleets and estimate.robots < needed < math.inf:
        asked["robots"] = max(asked.get("robots", 0.0), needed / estimate.robots)
    return {f"the {name}": share for name, share in asked.items()}
