"""Finding of `desim check` that chargers give less than a fleet draws at rest, where the work comes to an end.

Work without end is judged by its balance in the long run (`batteries.chargers_short`). Where work ends there is no long
run: robots that wait, for a charger or for the next task, draw on, and if the chargers do not make up for that, the
batteries fall until no robot can do what is left. That does not matter as long as no robot has to be charged.

A charger without a slot beside it is idle while the next robot drives up, which counts where batteries are full in a
few seconds. A charge is at most from the level at which robots go to charge up to the level at which they leave, so E
of energy take a charger E / r for the charge, at its rate r, and s for the drive there, from the nearest other bay.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from desim_warehouse.errors import number_of
from desim_warehouse.feasibility.batteries import floor_of, tasks_asked
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.feasibility.needs import edge_times, least_costs
from desim_warehouse.feasibility.power import (
    Power,
    draw_at_rest,
    drawn_at_rest,
    gives_at_rest,
    needed_at_rest,
    off_chargers,
    resting,
)
from desim_warehouse.findings import Finding, amount
from desim_warehouse.layout import Layout
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import (
    by_kind,
    chargers_at,
    charging_rate,
    cycle_levels,
    shares,
    slots_at,
    start_energy,
)
from desim_warehouse.model.facts.demand import last_release


def warnings(model: Model, layout: Layout, estimate: QuickEstimate) -> Iterator[Finding]:
    """Warn of work that ends, for which batteries have to be charged by chargers that give too little at rest."""
    balance = estimate.power
    if balance is None or not balance.chargers or model.tasks.never_end:
        return
    spare = draw_at_rest(model, layout) - balance.slack
    gives = _gives_at_most(model, layout)
    if gives >= spare or _drawn(model, estimate, balance) <= _held(model):
        return
    if gives_at_rest(model, layout) < spare:
        text = resting(model, layout)
        cure = f"need at least {number_of(needed_at_rest(model), 'charger')}, or a higher charge_rate"
    else:
        charge, time = _charge(model), model.units.time
        text = (
            f"{drawn_at_rest(model, layout)}, and {number_of(balance.chargers, 'charger')} "
            f"{'gives' if balance.chargers == 1 else 'give'} {amount(gives)} at most, as robots charge for "
            f"{amount(charge / charging_rate(model))} {time} and the next has to drive up"
        )
        cure = "more chargers, slots beside them (places), a lower level at which robots charge, or a larger battery"
    text += ": the batteries fall while robots wait, and the work may never be done"
    yield Finding("CHARGERS_SHORT", "layout.bays", text, cure)


def _gives_at_most(model: Model, layout: Layout) -> float:
    """Return the rate at which chargers give energy if robots take turns, each charged as far as it can be."""
    charge, slots, chargers = _charge(model), slots_at(model, layout), chargers_at(model, layout)
    times = edge_times(model, layout)
    gives = 0.0
    for node, count in chargers.items():
        others = dict.fromkeys((other for other in layout.bays if other != node), 0.0)
        drive = 0.0 if slots[node] > count else least_costs(times, 1.0, others)[node]
        time = charge / charging_rate(model) + (drive if math.isfinite(drive) else 0.0)
        gives += count * charge / time if time else math.inf
    return gives


def _charge(model: Model) -> float:
    """Return the most energy that a robot is charged with at a time: from where charging begins to where it ends."""
    levels = [cycle_levels(alone) for alone in by_kind(model).values()]
    return max(high - low for low, high in levels)


def _drawn(model: Model, estimate: QuickEstimate, balance: Power) -> float:
    """Return the energy that the fleet draws until its work is done, with robots at all chargers meanwhile."""
    count = tasks_asked(model)
    time = max(last_release(model), count / estimate.capacity if estimate.capacity else math.inf)
    time = min(time, math.inf if model.run.length is None else model.run.length)
    waiting = max(off_chargers(model, model.floor) * time - count * estimate.cycle.time, 0.0)
    return count * balance.task + waiting * balance.standing


def _held(model: Model) -> float:
    """Return the energy that the fleet starts with, above the levels where robots stop working."""
    part = shares(model)
    return model.fleet.size * math.fsum(
        part[kind] * (alone.battery.capacity * sum(start_energy(alone)) / 2 - floor_of(alone))
        for kind, alone in by_kind(model).items()
        if alone.battery is not None
    )
