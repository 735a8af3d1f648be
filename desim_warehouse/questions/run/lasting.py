"""Whether a run shows that the warehouse keeps up: proved by what is asked of each resource, or not said."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from desim_warehouse.errors import WarehouseError
from desim_warehouse.outcome.resources import off_duty, on_duty, standing, use_of_stations
from desim_warehouse.run.examined import examined
from desim_warehouse.states import TIMES, Phase

if TYPE_CHECKING:
    from desim_warehouse.feasibility.estimate import QuickEstimate
    from desim_warehouse.outcome.history import History
    from desim_warehouse.run import RunData

MOST_ASKED = 0.95
"""Share of what a resource can give from which on a queue may grow without a run of some hours showing it."""
OVERLOADS = ("DEMAND_ABOVE_STATIONS", "DEMAND_ABOVE_FLEET", "CHARGERS_SHORT")
"""Findings of the check by which work, or what batteries lack, grows without bound, the surest first."""
FOR_A_TIME = "PEAK_ABOVE_FLEET"
"""The finding by which work piles up in the busiest hour."""


@dataclass(frozen=True)
class Lasting:
    """What speaks against a run that keeps up.

    `overload`: the code of the check's finding. `scarce`: the resource of which more than `MOST_ASKED` is asked, and
    the share of what it can give; "" and 0 where there is none. `grown`: tasks that more are open, and in no robot's
    hands, at the end than when counting began, where these are more than `allowed`, the square root of those that came;
    else 0. `piles_up_at_peak`: in the busiest hour, by the check. `unknown`: why the model could not be checked.
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
        """Whether the run, with the check of its model, proves that it keeps up."""
        return not (self.overload or self.scarce or self.grown or self.unknown)


def lasting(run: RunData) -> Lasting | None:
    """Judge whether a run keeps up with the tasks that arrive; None where none arrive by themselves."""
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
    grown, allowed = _growth(run.history)
    return Lasting(
        overload=next((code for code in OVERLOADS if code in codes), ""),
        scarce=scarce if is_scarce else "",
        asked=asked[scarce] if is_scarce else 0.0,
        grown=grown if grown > allowed else 0,
        allowed=allowed,
        piles_up_at_peak=FOR_A_TIME in codes,
    )


def _asked(run: RunData, estimate: QuickEstimate | None) -> dict[str, float]:
    """Return for each resource the share of what it can give that is asked of it, measured or worked out.

    The larger of the two: a run alone measures less where fewer tasks come than on average, or batteries still hold
    what they began with.
    """
    kpis, stations = run.kpis, run.layout.stations
    named = {node: f"{item.zone} at {node}" for node, item in stations.items()}
    found = {named[node]: share for node, share in use_of_stations(run.history).items()}
    found["the robots"] = _of_robots(run)
    found["the chargers"] = kpis.get("charger_utilisation", math.nan)
    found["the workers"] = kpis.get("worker_utilisation", math.nan)
    if estimate is not None and estimate.rate is not None:
        for item in estimate.stations:
            name = named.get(item.node, item.node)
            found[name] = _larger(found.get(name), item.serve_busy)
            if item.workers:
                found[f"the workers of {name}"] = _larger(item.work_busy)
        if estimate.fleet_capacity:
            found["the robots"] = _larger(found["the robots"], estimate.rate / estimate.fleet_capacity)
        if estimate.robots_needed is not None and estimate.robots_needed > estimate.robots:
            found["the robots"] = _larger(found["the robots"], estimate.robots_needed / estimate.robots)
        power = estimate.power
        if power is not None and power.gives and power.draws is not None:
            found["the chargers"] = _larger(found["the chargers"], power.draws / power.gives)
    return {name: share for name, share in found.items() if math.isfinite(share)}


def _of_robots(run: RunData) -> float:
    """Return the share of their time on duty that robots need: one that drives back to a bay is free for work."""
    kpis, model = run.kpis, run.model
    back = [f"share_{name}" for name, state in TIMES.items() if state.phase is Phase.TO_BAY and state.applies(model)]
    free = math.fsum(kpis[name] for name in (*_at_rest(run), *back))
    return on_duty(1 - free, off_duty(kpis))


def _at_rest(run: RunData) -> list[str]:
    rests = {name for name, state in TIMES.items() if state.phase is Phase.REST}
    return [name for name in standing(run.model) if name.removeprefix("share_") in rests]


def _larger(*shares: float | None) -> float:
    return max((share for share in shares if share is not None and math.isfinite(share)), default=math.nan)


def _growth(history: History) -> tuple[int, float]:
    """Return by how much the tasks grew that are open and in no robot's hands, and the root of those that came."""
    came = sum(1 for task in history.tasks.values() if history.counts(task.released))
    in_hand = [
        sum(
            1 for one in history.assignments if one.start <= time < one.end or (time == one.end and one.ended == "open")
        )
        for time in (history.begin, history.end)
    ]
    grown = came - len(history.counted_done) - (in_hand[1] - in_hand[0])
    return grown, math.sqrt(came)
