"""Charging in a model: where chargers are and what they give, between which levels robots charge and begin."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.model.facts import energy
from desim_warehouse.model.facts.kinds import by_kind, charge_alike, shares
from desim_warehouse.model.sections.fleet import SpreadEnergy
from desim_warehouse.model.sections.flows import ProfileArrivals
from desim_warehouse.policies import RobotView, create

if TYPE_CHECKING:
    from desim_warehouse.layout import Layout
    from desim_warehouse.model.schema import Model
    from desim_warehouse.policies import Levels
    from desim_warehouse.values.streams import Streams


LEAST_CHARGE = 0.05
"""Part of its capacity that a robot which must charge takes up before it is free again."""


def chargers_at(model: Model, layout: Layout) -> dict[str, int]:
    """Chargers that robots can stand at, by the nodes of their bays; nodes without are left out."""
    home = model.fleet.homes(layout.bays)
    found = {}
    for node, bay in layout.bays.items():
        places = bay.slots(home.count(node))
        chargers = places if bay.chargers is None else min(bay.chargers, places)
        if chargers:
            found[node] = chargers
    return found


def spare_batteries(model: Model) -> dict[str, int]:
    """How many spare batteries there are for robots of each kind; only kinds for which they are counted."""
    found = {kind: alone.policies.charging.params.get("batteries") for kind, alone in by_kind(model).items()}
    return {} if model.battery is None else {kind: count for kind, count in found.items() if count is not None}


def swapped_at(layout: Layout, kind: str) -> list[str]:
    """The nodes of the bays where batteries of a kind are swapped, among which its spare ones are shared out."""
    return [node for node, bay in layout.bays.items() if bay.charges(kind)]


def levels(model: Model) -> Levels | None:
    """The levels of a built-in charging policy for a full robot; None for a policy of the user's, which may differ."""
    policy, battery = model.policies.charging, model.battery
    if battery is None or ":" in policy.name:
        return None
    view = RobotView(0, "", "", battery.capacity, battery.capacity, battery.threshold)
    found: Levels = create("charging", policy.name, policy.params).levels(view)
    return found


def charging_rate(model: Model) -> float:
    """Energy per time unit that a charger gives while a robot is at it; the mean over the fleet where kinds differ."""
    if not charge_alike(model):
        part = shares(model)
        return math.fsum(part[kind] * charging_rate(alone) for kind, alone in by_kind(model).items())
    battery, known = model.battery, levels(model)
    assert battery is not None
    low, high = (battery.threshold, battery.capacity) if known is None else (known.critical, known.full)
    if known is not None and known.swap_time is not None:
        return (high - low) / known.swap_time if known.swap_time else math.inf
    time = energy.charge_time(battery, low, high)
    return (high - low) / time if time else battery.charge_rate


def cycle_levels(model: Model) -> tuple[float, float]:
    """The levels between which batteries move in the long run: where charging begins, and where it ends.

    Of a policy of the user's nothing is known but the battery's threshold.
    """
    battery, known = model.battery, levels(model)
    assert battery is not None
    return (battery.threshold, battery.capacity) if known is None else (known.critical, known.full)


def refills_overnight(model: Model) -> bool:
    """Whether a run is a day that begins with full batteries, which its chargers fill again before the next.

    That is a run by the clock, counted from its start, of less than 24 hours. In the others of the 24 the chargers
    could fill the whole fleet from empty.
    """
    night = 24 * model.units.hour - model.run.end
    flows = model.tasks.flows.values()
    clocked = model.run.start != "00:00" or model.layout.has_hours or model.fleet.has_hours
    clocked = clocked or any(isinstance(flow.when, ProfileArrivals) for flow in flows)
    if model.battery is None or not clocked or model.run.warm_up or start_energy(model) != (1.0, 1.0) or night <= 0:
        return False
    capacity = max(alone.battery.capacity for alone in by_kind(model).values() if alone.battery is not None)
    chargers = min(sum(chargers_at(model, model.floor).values()), model.fleet.size)
    return chargers * charging_rate(model) * night >= capacity * model.fleet.size


def start_levels(model: Model, streams: Streams) -> list[float]:
    """What the battery of each robot holds at the start of a run; inf without battery.

    Drawn from a stream for each robot: another fleet size or policy leaves those of the others as they are.
    """
    if model.battery is None:
        return [math.inf] * model.fleet.size
    ranges = {}
    for kind, alone in by_kind(model).items():
        assert alone.battery is not None
        ranges[kind] = alone.battery.capacity, *start_energy(alone)
    return [
        capacity * (low if low == high else float(streams.stream("start-energy", robot).uniform(low, high)))
        for robot, (capacity, low, high) in enumerate(ranges[kind] for kind in model.fleet.kinds_of_robots())
    ]


def start_energy(model: Model) -> tuple[float, float]:
    """The range of battery levels at the start, as shares of the capacity."""
    given = model.fleet.start_energy
    if isinstance(given, SpreadEnergy):
        return given.uniform
    if not isinstance(given, str):
        return given, given
    assert model.battery is not None
    low, high = cycle_levels(model)
    return low / model.battery.capacity, high / model.battery.capacity
