"""The limit of a fleet where it is not its robots, in words, and the flows whose tasks need it.

For the sentences and findings of `desim check`.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from desim_warehouse.errors import number_of, spoken
from desim_warehouse.feasibility.estimate import PICKERS, THE_ROBOTS, QuickEstimate, limiting
from desim_warehouse.feasibility.parts import PickerLoad, StationLoad
from desim_warehouse.model import Model
from desim_warehouse.model.facts.demand import flow_rates
from desim_warehouse.model.facts.workers import Group, work_of


def fleet(estimate: QuickEstimate) -> str:
    """Return the robots in words, after what limits them if not they: `with the pickers as the limit, 6 robots`."""
    robots, limit = number_of(estimate.robots, "robot"), estimate.bottleneck
    if limit == THE_ROBOTS:
        return robots
    item = _place(estimate, limit)
    who = [item.staff] if isinstance(item, StationLoad) else []
    if item is not None and item.open < 1:
        who.append(f"at work {100 * item.open:.3g} % of the time")
    details = f" ({', '.join(who)})" if who else ""
    return f"with {limit}{details} as the limit, {robots}"


def reason(estimate: QuickEstimate, place: str) -> str:
    """Return why more robots do not do more: `, as the chargers are the limit`; empty if `fleet` names this place."""
    if place == estimate.bottleneck:
        return ""
    item = _place(estimate, place)
    return f", as {limiting(place, item.staff if isinstance(item, StationLoad) else '')}"


def of_flows(model: Model, estimate: QuickEstimate, limit: str, words: Callable[[float], str]) -> str:
    """Return how much of a limit is for the flows that need it: ` (60 of flow orders)`; empty where all flows do.

    `words`: the words for a part of all tasks.
    """
    flows, rates = _needing(model, estimate, limit), flow_rates(model)
    if len(flows) == len(rates):
        return ""
    part = math.fsum(rates[name] for name in flows) / math.fsum(rates.values())
    return f" ({words(part)} of {'flow' if len(flows) == 1 else 'flows'} {spoken(flows)})"


def _needing(model: Model, estimate: QuickEstimate, limit: str) -> list[str]:
    """Return the flows whose tasks need a limit; all if it is at no place, or with pods."""
    item = _place(estimate, limit)
    if item is None or estimate.pile_on is not None:
        return list(model.tasks.flows)
    group = Group("pickers")
    if isinstance(item, StationLoad):
        group = Group("people" if item.limited_by_work else "servers", nodes=(item.node,))
    return [name for name in model.tasks.flows if work_of(model, group, name)]


def _place(estimate: QuickEstimate, limit: str) -> StationLoad | PickerLoad | None:
    """Return the station or the pickers by whose name a limit goes."""
    if limit == PICKERS:
        return estimate.pickers
    return next((item for item in estimate.stations if item.doing == limit), None)
