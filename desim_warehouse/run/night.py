"""A night without orders: the real engine with all robots and no tasks, which takes only milliseconds.

For `desim check`, and for the chargers that `desim new` writes.

Arithmetic can tell whether chargers supply the consumption of robots, but not which robot gets a charger when.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from simpy.events import Timeout

from desim_warehouse.errors import BatteryError
from desim_warehouse.feasibility.power import at_rest
from desim_warehouse.findings import Finding
from desim_warehouse.layout import Layout
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import chargers_at, slots_at
from desim_warehouse.model.facts.hours import has_nights, longest_rest
from desim_warehouse.world import World
from desim_warehouse.world.orders.demand import NoOrders

DAY = 24.0
"""The least number of hours without orders that are simulated."""
MOST_ROWS = 6_000
"""The number of log rows after which the simulation of a night is stopped."""


class _LongEnoughError(Exception):
    """Raised to end the simulation of a night when it has lasted long enough."""


@dataclass(frozen=True)
class Flat:
    """The finding that a battery runs flat in a night: the first robot to do so, and after how many hours.

    `tried`: how many hours were simulated.
    """

    robot: int
    hours: float
    tried: float


def night(model: Model) -> Flat | None:
    """Simulate a night without orders from the energy at the start; return the robot that runs flat first, or None.

    It lasts a day, or the longest time in which the model is closed; less with a fleet that moves a lot.
    """
    hour = model.units.hour
    tried = max(DAY, longest_rest(model) / hour)
    run = model.run.model_copy(update={"length": tried * hour, "warm_up": 0.0})
    world = World(model.model_copy(update={"run": run, "log": "tasks"}), demand=NoOrders)
    _watch(world, hour)
    try:
        world.run()
    except BatteryError:
        now = world.env.now
        return Flat(min(world.robots, key=lambda robot: robot.charge_left()).number, now / hour, tried)
    except _LongEnoughError:
        pass
    return None


def _watch(world: World, hour: float) -> None:
    """Stop a night in which hundreds of robots take turns at a few chargers, which would take minutes."""

    def look(_: object) -> None:
        if world.log.written() > MOST_ROWS:
            raise _LongEnoughError
        Timeout(world.env, hour / 4).callbacks.append(look)

    look(None)


def findings(model: Model, layout: Layout) -> Iterator[Finding]:
    """Warn of batteries that run flat in the model's nights, for runs with a length, in models with chargers.

    Policies of the user's own are not simulated: a check does not run foreign code.
    """
    charging = [model.policies.charging, *(kind.charging for kind in model.fleet.kinds.values())]
    if model.policies.own() or any(spec is not None and spec.own for spec in charging):
        return
    if model.battery is None or model.run.length is None or not chargers_at(model, layout):
        return
    flat = night(model)
    if flat is not None:
        text = (
            f"without orders, robot {flat.robot} runs flat after {flat.hours:.1f} h ({flat.tried:g} h were simulated); "
            f"{at_rest(model, layout)}"
        )
        cure = "more or faster chargers, or less consumption while standing"
        if sum(slots_at(model, layout).values()) <= model.fleet.size:
            cure = f"one more slot than robots, as none can change places while all rest (places); {cure}"
        if has_nights(model):
            yield Finding("NIGHT_FLAT", "layout.bays", text, cure)
        else:
            yield Finding("REST_FLAT", "layout.bays", text, cure)
