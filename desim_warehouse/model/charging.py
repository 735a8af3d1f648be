"""The chargers of a model: where they are, between which levels robots charge, and what a charger gives."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.model import energy
from desim_warehouse.policies import RobotView, create

if TYPE_CHECKING:
    from desim_warehouse.layout import Layout
    from desim_warehouse.model.schema import Model
    from desim_warehouse.policies import Levels


def chargers_at(model: Model, layout: Layout) -> dict[str, int]:
    """Chargers that robots can stand at, by the nodes of their bays; nodes without are left out."""
    home = model.fleet.homes(layout.bays)
    found = {}
    for node, bay in layout.bays.items():
        places = home.count(node) if bay.places is None else bay.places
        chargers = places if bay.chargers is None else min(bay.chargers, places)
        if chargers:
            found[node] = chargers
    return found


def levels(model: Model) -> Levels | None:
    """The levels of a built-in charging policy for a full robot; None for a policy of the user's, which may differ."""
    policy, battery = model.policies.charging, model.battery
    if battery is None or ":" in policy.name:
        return None
    view = RobotView(0, "", "", battery.capacity, battery.capacity, battery.threshold)
    found: Levels = create("charging", policy.name, policy.params).levels(view)
    return found


def charging_rate(model: Model) -> float:
    """Energy per time unit that a charger gives while a robot is at it."""
    battery, known = model.battery, levels(model)
    assert battery is not None
    low, high = (battery.threshold, battery.capacity) if known is None else (known.critical, known.full)
    if known is not None and known.swap_time is not None:
        return (high - low) / known.swap_time if known.swap_time else math.inf
    time = energy.charge_time(battery, low, high)
    return (high - low) / time if time else battery.charge_rate
