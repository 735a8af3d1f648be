"""Expected utilisation of each group of workers, by the quick estimate.

For `desim check`, and for the loads of plans and their live page.
"""

from __future__ import annotations

import math

from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.feasibility.parts import StationLoad
from desim_warehouse.model import Model
from desim_warehouse.model.facts.demand import flow_rates
from desim_warehouse.model.facts.subfleets import Subfleet
from desim_warehouse.model.facts.workers import Group, Load, at_nodes, groups, in_peak, of_slots
from desim_warehouse.model.sections.flows import SaturatedArrivals


def loads(model: Model, estimate: QuickEstimate) -> tuple[Load, ...]:
    """Return the expected load of each group, such as robots or packers, at the demand or, without a rate, at capacity.

    Nodes at which robots unload without a station serve one robot at a time, and are groups of one.
    """
    rate = estimate.capacity if estimate.rate is None else estimate.rate
    if not math.isfinite(rate) or not rate:
        return ()
    foreseen = list[Load | None]()
    of_servers = {item.node: rate * item.share / item.serve_capacity for item in estimate.stations}
    of_people = {item.node: rate * item.share / item.work_capacity for item in estimate.stations if item.workers}
    of_lifts = {item.name: item.busy(rate) for item in estimate.lifts}
    for group in (*groups(model), *_places(model, estimate.stations)):
        if group.kind == "robots":
            foreseen.append(_of_robots(model, group, estimate, rate))
        elif group.kind == "chargers":
            power = estimate.power
            if power is not None and power.gives and power.draws is not None:
                drawn = power.by_chargers * power.draws / power.gives
                foreseen.append(Load(group, drawn, None, drawn) if drawn else None)
        elif group.kind == "pickers" and not group.zone:
            pickers = estimate.pickers
            if pickers is not None:
                mean = pickers.busy(rate)
                foreseen.append(Load(group, mean, in_peak(model, group, mean), mean))
        elif group.kind == "lifts":
            mean = of_lifts.get(group.zone, 0.0)
            foreseen.append(Load(group, mean, in_peak(model, group, mean), mean))
        else:
            foreseen.append(at_nodes(model, group, of_people if group.kind == "people" else of_servers))
    foreseen.append(of_slots(model, rate * estimate.cycle.time / (estimate.on_duty or math.inf)))
    return tuple(load for load in foreseen if load is not None)


def _of_robots(model: Model, group: Group, estimate: QuickEstimate, rate: float) -> Load | None:
    """Return the load of robots relative to their own capacity, whatever stations let through at the peak.

    A fleet that can choose among waiting tasks drives less, and is measured to do more than its robots one by one.
    """
    if not estimate.fleet_capacity or not math.isfinite(estimate.fleet_capacity):
        return None
    mean = rate / max(estimate.fleet_capacity, estimate.capacity)
    if group.subfleet is not None:
        mean = _of_subfleet(model, group.subfleet, estimate.subfleets[group.subfleet.name])
    return Load(group, mean, in_peak(model, group, mean), mean)


def _of_subfleet(model: Model, subfleet: Subfleet, capacity: float) -> float:
    """Return the load of a subfleet, by the rates of its flows: always busy with those that are always open."""
    if any(isinstance(model.tasks.flows[name].when, SaturatedArrivals) for name in subfleet.flows):
        return 1.0
    rates = flow_rates(model)
    asked = math.fsum(rates[name] for name in subfleet.flows) / model.units.hour
    return asked / capacity if asked else 0.0


def _places(model: Model, stations: tuple[StationLoad, ...]) -> list[Group]:
    """Return the nodes at which robots unload without a station, as groups."""
    bare = [item.node for item in stations if item.node not in model.floor.stations]
    return [Group("servers", node, nodes=(node,)) for node in bare]
