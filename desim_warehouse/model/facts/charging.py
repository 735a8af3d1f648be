"""Charging in a model: where chargers are, how much they give, what states draw, and which kinds share chargers.

The simulation and whatever works out a level from the log have one model of the battery.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from functools import lru_cache

from desim_warehouse.layout import Layout
from desim_warehouse.model.schema import Model
from desim_warehouse.model.sections.fleet import BatterySpec, Consumption, SpreadEnergy
from desim_warehouse.model.sections.flows import ProfileArrivals
from desim_warehouse.policies import Levels, RobotView, create
from desim_warehouse.states import TIMES
from desim_warehouse.values.fields import FrozenMap
from desim_warehouse.values.streams import Streams

LEAST_CHARGE = 0.05
"""Part of its capacity that a robot which must charge takes up before it is free again."""


def consumption(spec: BatterySpec | None) -> Consumption:
    """Return the energy per time unit; without a battery nothing."""
    drawn = 0.0 if spec is None else spec.consumption
    if isinstance(drawn, Consumption):
        return drawn
    return Consumption(standing=drawn, empty=drawn, loaded=drawn, handling=drawn)


def rates(spec: BatterySpec | None) -> dict[str, float]:
    """Return the energy per time unit in every state but charging; at rest in a slot with a charger it is 0 instead."""
    drawn = consumption(spec)
    return {name: getattr(drawn, state.draws) for name, state in TIMES.items() if state.draws is not None}


def charge_time(spec: BatterySpec, start: float, end: float) -> float:
    """Return the time to charge from one level to another: at the full rate, tapering off towards full if so modelled.

    Tapered, the rate falls linearly with the level l above `taper.start`: dl/dt = r(l), so the time is an
    integral of 1 / r(l), a logarithm. No battery is ever charged beyond its capacity.
    """
    if end <= start:
        return 0.0
    if end > spec.capacity:
        return math.inf
    rate, taper = spec.charge_rate, spec.taper
    if taper is None:
        return (end - start) / rate
    knee = taper.start * spec.capacity
    time = max(min(end, knee) - start, 0.0) / rate
    low, high = max(start, knee), max(end, knee)
    slope = (1 - taper.end_rate) / (spec.capacity - knee)
    return time + math.log((1 - slope * (low - knee)) / (1 - slope * (high - knee))) / (rate * slope)


def charge_gain(spec: BatterySpec, start: float, time: float) -> float:
    """Return the energy charged in a time at the charger, from the level `start` on: the inverse of `charge_time`."""
    rate, taper = spec.charge_rate, spec.taper
    if taper is None:
        return min(rate * time, spec.capacity - start)
    knee = taper.start * spec.capacity
    steady = min(max(knee - start, 0.0) / rate, time)
    low = max(start, knee)
    slope = (1 - taper.end_rate) / (spec.capacity - knee)
    here = 1 - slope * (low - knee)
    gain = here / slope * (1 - math.exp(-slope * rate * (time - steady)))
    return min(rate * steady + gain, spec.capacity - start)


def slots_at(model: Model, layout: Layout) -> dict[str, int]:
    """Return the number of slots of each bay, by its node."""
    homes = Counter(model.fleet.homes(layout.bays))
    return {node: bay.slots(homes[node]) for node, bay in layout.bays.items()}


def chargers_at(model: Model, layout: Layout) -> dict[str, int]:
    """Count the chargers that robots can stand at, by the nodes of their bays; nodes without are left out."""
    chargers_by_node = {}
    for node, places in slots_at(model, layout).items():
        count = layout.bays[node].chargers
        chargers = places if count is None else min(count, places)
        if chargers:
            chargers_by_node[node] = chargers
    return chargers_by_node


def without_charger(model: Model) -> Counter[str]:
    """Count the robots of each kind ("": ordinary) that no charger serves, where there are chargers for others."""
    bays, nodes = model.floor.bays, chargers_at(model, model.floor)
    kinds = model.fleet.kinds_of_robots() if model.battery is not None and nodes else ()
    return Counter(kind for kind in kinds if not any(bays[node].charges(kind) for node in nodes))


def spare_batteries(model: Model) -> dict[str, int]:
    """Count the spare batteries for robots of each kind; only kinds for which they are counted."""
    counts = {kind: alone.policies.charging.params.get("batteries") for kind, alone in by_kind(model).items()}
    return {} if model.battery is None else {kind: count for kind, count in counts.items() if count is not None}


def swapped_at(layout: Layout, kind: str) -> list[str]:
    """Return the nodes of the bays where batteries of a kind are swapped, among which its spare ones are shared out."""
    return [node for node, bay in layout.bays.items() if bay.charges(kind)]


def levels(model: Model) -> Levels | None:
    """Return the levels of a built-in charging policy for a full robot; None for a policy of the user's own."""
    policy, battery = model.policies.charging, model.battery
    if battery is None or ":" in policy.name:
        return None
    view = RobotView(0, "", "", battery.capacity, battery.capacity, battery.threshold)
    thresholds: Levels = create("charging", policy.name, policy.params).levels(view)
    return thresholds


def charging_rate(model: Model) -> float:
    """Return the energy per time unit that a charger gives a robot at it; the fleet mean where kinds differ."""
    if not charge_alike(model):
        return mean_over_fleet(model, charging_rate)
    battery, thresholds, (low, high) = model.battery, levels(model), cycle_levels(model)
    assert battery is not None
    if thresholds is not None and thresholds.swap_time is not None:
        return (high - low) / thresholds.swap_time if thresholds.swap_time else math.inf
    time = charge_time(battery, low, high)
    return (high - low) / time if time else battery.charge_rate


def given_by_spares(model: Model) -> float:
    """Return the rate at which batteries outside robots give energy, at most; inf where spare ones are not counted.

    A battery charges from when it is taken out of a robot, which may wait at the charger for a full one. So as many
    charge at once as there are spare batteries and chargers.
    """
    spares, chargers = spare_batteries(model), sum(chargers_at(model, model.floor).values())
    if model.battery is None or not spares:
        return math.inf
    return (min(spares.values()) + min(chargers, model.fleet.size)) * model.battery.charge_rate


def cycle_levels(model: Model) -> tuple[float, float]:
    """Return the levels between which batteries move in the long run: where charging begins, and where it ends.

    Of a policy of the user's only the battery's threshold is known.
    """
    battery, thresholds = model.battery, levels(model)
    assert battery is not None
    return (battery.threshold, battery.capacity) if thresholds is None else (thresholds.critical, thresholds.full)


def working_levels(model: Model) -> tuple[float, float]:
    """Return the lowest and the highest usual battery level of a fleet that is seldom at rest, in energy.

    The lowest is where charging begins; the highest is where a robot at rest is charged or where work may interrupt
    charging, whichever is higher.
    """
    (low, high), thresholds = cycle_levels(model), levels(model)
    if thresholds is not None:
        high = min(high, max(thresholds.good, thresholds.sufficient))
    return low, high


def draw_standing(model: Model) -> float:
    """Return the mean rate at which a standing robot draws energy."""
    return mean_over_fleet(model, lambda alone: consumption(alone.battery).standing)


def night_after_run(model: Model) -> float | None:
    """Return the time from the end of a run to the beginning of the next; None if a run is no day that repeats.

    A day is a run by the clock, counted from its start, of less than 24 hours, which begins with full batteries.
    """
    time = 24 * model.units.hour - model.run.end
    flows = model.tasks.flows.values()
    clocked = model.run.start != "00:00" or model.layout.has_hours or model.fleet.has_hours
    clocked = clocked or any(isinstance(flow.when, ProfileArrivals) for flow in flows)
    if model.battery is None or not clocked or model.run.warm_up or start_energy(model) != (1.0, 1.0) or time <= 0:
        return None
    return time


def mean_capacity(model: Model) -> float:
    """Return the mean energy that a full battery has."""
    return mean_over_fleet(model, lambda alone: math.inf if alone.battery is None else alone.battery.capacity)


def usable(model: Model) -> float:
    """Return the mean energy that a full battery has above the level where charging begins."""
    if not charge_alike(model):
        return mean_over_fleet(model, usable)
    assert model.battery is not None
    return model.battery.capacity - cycle_levels(model)[0]


def gained_at_rest(model: Model, chargers: float) -> float:
    """Return the rate at which a fleet without work gains energy: chargers give, and robots beside them draw.

    It is below 0 where too many robots share a charger. `chargers`: may have fractions.
    """
    charging = min(chargers, model.fleet.size)
    return (charging * charging_rate(model) if charging else 0.0) - (model.fleet.size - charging) * draw_standing(model)


def stored_overnight(model: Model, chargers: float) -> float | None:
    """Return the energy that a night adds to the batteries of a fleet; None if a run is no day that repeats.

    It is what the fleet gains at rest, but at most what a day can have drawn from full batteries. `chargers`: may have
    fractions.
    """
    time = night_after_run(model)
    return None if time is None else min(gained_at_rest(model, chargers) * time, usable(model) * model.fleet.size)


def refills_overnight(model: Model, lack: float | None = None) -> bool:
    """Whether a run is a day whose night adds what the batteries lack in the evening.

    `lack`: the mean, as a share of the capacity; None for all that a day can have drawn.
    """
    time, chargers = night_after_run(model), sum(chargers_at(model, model.floor).values())
    if time is None:
        return False
    lacking = usable(model) if lack is None else lack * mean_capacity(model)
    return gained_at_rest(model, chargers) * time >= lacking * model.fleet.size


def start_levels(model: Model, streams: Streams) -> list[float]:
    """Draw the energy in the battery of each robot at the start of a run; inf without battery.

    Drawn from a stream for each robot: another fleet size or policy leaves the levels of the others as they are.
    """
    return _drawn(model, streams, start_energy)


def settling_levels(model: Model, streams: Streams) -> list[float]:
    """Draw the energy in the battery of each robot at the start of a settling run, between levels of robots at work."""
    return _drawn(model, streams, lambda alone: _as_shares(alone, working_levels(alone)))


def _drawn(model: Model, streams: Streams, between: Callable[[Model], tuple[float, float]]) -> list[float]:
    """Draw the energy of each robot between two shares of the capacity, which depend on its kind."""
    if model.battery is None:
        return [math.inf] * model.fleet.size
    ranges = {}
    for kind, alone in by_kind(model).items():
        assert alone.battery is not None
        ranges[kind] = alone.battery.capacity, *between(alone)
    return [
        capacity * (low if low == high else float(streams.stream("start-energy", robot).uniform(low, high)))
        for robot, (capacity, low, high) in enumerate(ranges[kind] for kind in model.fleet.kinds_of_robots())
    ]


def start_energy(model: Model) -> tuple[float, float]:
    """Return the range of battery levels at the start, as shares of the capacity."""
    start = model.fleet.start_energy
    if isinstance(start, SpreadEnergy):
        return start.uniform
    if not isinstance(start, str):
        return start, start
    return _as_shares(model, cycle_levels(model))


def _as_shares(model: Model, energies: tuple[float, float]) -> tuple[float, float]:
    """Return two levels as shares of the capacity."""
    assert model.battery is not None
    low, high = energies
    return low / model.battery.capacity, high / model.battery.capacity


def charge_alike(model: Model) -> bool:
    """Whether all robots have the same battery, charging policy and chargers, or none has a battery."""
    if model.battery is None:
        return True
    own = any(kind.battery is not None or kind.charging is not None for kind in model.fleet.kinds.values())
    return not own and not any(bay.kinds for bay in model.layout.bays.values())


@lru_cache(maxsize=64)
def as_kind(model: Model, kind: str) -> Model:
    """Return the model as if all robots had the battery, charging policy and chargers of a kind ("": ordinary).

    All else is as before: robots start where they do, with their sizes and speeds.
    """
    own = model.fleet.kinds.get(kind)
    battery = model.battery if own is None or own.battery is None else own.battery
    charging = model.policies.charging if own is None or own.charging is None else own.charging
    homes = tuple(model.fleet.homes(model.floor.bays))
    none = {"chargers": 0, "total_chargers": None, "outages": None, "kinds": ()}
    kinds = {
        name: item.model_copy(update={"battery": None, "charging": None}) for name, item in model.fleet.kinds.items()
    }
    bays = {
        name: bay.model_copy(update={"kinds": ()} if not bay.kinds or kind in bay.kinds else none)
        for name, bay in model.layout.bays.items()
    }
    return model.model_copy(
        update={
            "battery": battery,
            "policies": model.policies.model_copy(update={"charging": charging}),
            "fleet": model.fleet.model_copy(update={"kinds": FrozenMap(kinds), "start": homes}),
            "layout": model.layout.model_copy(update={"bays": FrozenMap(bays)}),
        }
    )


def sharing_with(model: Model, layout: Layout, kind: str) -> Model:
    """Return a model `as_kind` with only the robots that may use chargers which this kind may use, as its whole fleet.

    `layout`: the floor of the model itself, with the kinds that may use each charger.
    """
    bays, fleet = layout.bays.values(), model.fleet
    kinds = fleet.kinds_of_robots()
    sharing = {other for other in kinds if any(bay.charges(kind) and bay.is_for(other) for bay in bays)} | {kind}
    homes = [home for other, home in zip(kinds, fleet.homes(layout.bays), strict=True) if other in sharing]
    alone = {"size": len(homes), "start": tuple(homes), "kinds": FrozenMap({})}
    return model.model_copy(update={"fleet": fleet.model_copy(update=alone)})


def by_kind(model: Model) -> dict[str, Model]:
    """Return for each kind with robots ("": ordinary) the model `as_kind`: itself where all robots charge alike."""
    kinds = dict.fromkeys(model.fleet.kinds_of_robots(), model)
    return kinds if charge_alike(model) else {kind: as_kind(model, kind) for kind in kinds}


def shares(model: Model) -> dict[str, float]:
    """Return the part of the fleet that is of each kind that has robots."""
    kinds = model.fleet.kinds_of_robots()
    return {kind: kinds.count(kind) / len(kinds) for kind in dict.fromkeys(kinds)}


def mean_over_fleet(model: Model, value: Callable[[Model], float]) -> float:
    """Return the mean over all robots of a value that depends on their kind; `value` takes the model `as_kind`."""
    part = shares(model)
    return math.fsum(part[kind] * value(alone) for kind, alone in by_kind(model).items())


def kind_in_words(kind: str) -> str:
    """Return the words for the robots of a kind, at the beginning of a line."""
    return f"kind {kind}" if kind else "robots of no kind"
