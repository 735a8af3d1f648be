"""Times known ahead of a run: how long robots drive on free lanes, and how long their stops take."""

from __future__ import annotations

from desim_warehouse.layout import Layout
from desim_warehouse.layout.travel import FreeTravel, travel_on
from desim_warehouse.model.facts.places import destinations, specs
from desim_warehouse.model.schema import Model
from desim_warehouse.policies import Handling, create
from desim_warehouse.values.distributions import Distribution


def free_travel(model: Model, layout: Layout) -> FreeTravel:
    """Return driving times of the fastest robot by the routes of the model's routing policy."""
    policy, traffic, fleet = model.policies.routing, model.traffic, model.fleet
    cost = getattr(create("routing", policy.name, policy.params), "cost", "time")
    return travel_on(
        layout,
        fleet.fastest_empty,
        traffic.node_time,
        cost,
        (*layout.bays, *layout.stations, *destinations(model, layout)),
        traffic.turn_time,
        traffic.node_times,
        fleet.slowness,
    )


def handling_of(model: Model, layout: Layout) -> Handling[float | Distribution]:
    """Return the handling times of the model: the simulation samples them, forecasts use the means."""
    tasks, cost = model.tasks, model.cost
    return Handling(
        tasks.load_time,
        tasks.unload_time,
        tasks.clear_time,
        cost.distance,
        cost.time,
        cost.collisions,
        {name: tasks.handling_of(flow) for name, flow in tasks.flows.items()},
        {"": 0.0, **{name: flow.stop_time for name, flow in tasks.flows.items()}},
        {
            node: (spec.load_time, spec.unload_time)
            for node, spec in specs(model, layout).items()
            if spec.load_time is not None or spec.unload_time is not None
        },
    )
