"""How long robots of a model drive without traffic."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.layout.travel import travel_on
from desim_warehouse.model.facts.places import destinations
from desim_warehouse.policies import create

if TYPE_CHECKING:
    from desim_warehouse.layout import Layout
    from desim_warehouse.layout.travel import FreeTravel
    from desim_warehouse.model.schema import Model


def free_travel(
    model: Model, layout: Layout, speed: float | None = None, *, at_once: bool = False, estimate: bool = False
) -> FreeTravel:
    """Driving times by the routes of the model's routing policy: of its runs, or at another speed.

    `at_once`: starts and stops take no time. `estimate`: as for `RouteOracle`; not where that of runs will do.
    """
    policy, traffic, fleet = model.policies.routing, model.traffic, model.fleet
    cost = getattr(create("routing", policy.name, policy.params), "cost", "time")
    fastest, slowness = max(robot.speed for robot in fleet.distinct()), 0.0 if at_once else fleet.slowness
    speed = fastest if speed is None else speed
    return travel_on(
        layout,
        speed,
        traffic.node_time,
        cost,
        (*layout.bays, *layout.stations, *destinations(model, layout)),
        traffic.turn_time,
        traffic.node_times,
        slowness,
        estimate=estimate and (cost == "hops" or (speed, slowness) != (fastest, fleet.slowness)),
    )
