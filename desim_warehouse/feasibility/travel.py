"""Free driving by the routes that a model's robots take."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.layout.travel import travel_on
from desim_warehouse.model.facts.destinations import destinations
from desim_warehouse.policies import create

if TYPE_CHECKING:
    from desim_warehouse.layout import Layout
    from desim_warehouse.layout.travel import FreeTravel
    from desim_warehouse.model import Model


def free_travel(model: Model, layout: Layout, speed: float, slowness: float) -> FreeTravel:
    """Driving times by the routes of the model's routing policy at a speed; for `slowness` see `FreeTravel`."""
    policy, traffic = model.policies.routing, model.traffic
    cost = getattr(create("routing", policy.name, policy.params), "cost", "time")
    hubs = (*layout.bays, *layout.stations, *destinations(model, layout))
    times = traffic.node_time, cost, hubs, traffic.turn_time, traffic.node_times, slowness
    return travel_on(layout, speed, *times, estimate=True)
