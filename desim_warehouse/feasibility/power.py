"""The energy balance of a model: energy drawn by tasks, energy supplied by chargers, and the chargers needed.

For `desim check`, and for the chargers that `desim new` writes.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import networkx as nx

from desim_warehouse.errors import number_of
from desim_warehouse.feasibility.parts import MeanTask
from desim_warehouse.findings import amount
from desim_warehouse.layout import Layout
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import (
    by_kind,
    charge_alike,
    chargers_at,
    charging_rate,
    draw_standing,
    given_by_spares,
    night_after_run,
    shares,
    slots_at,
    stored_overnight,
)

_STEPS = 1 << 20
"""Number of parts of a charger to which the need of a kind is computed."""
_EPS = 1e-5
FALLING = 0.01
"""Share of its capacity an hour from which on a battery counts as falling, as in runs (outcome/verdicts.py)."""


@dataclass(frozen=True)
class SharedChargers:
    """Chargers that some kinds of robots share: these kinds, and how many chargers they need and have."""

    kinds: tuple[str, ...]
    needed: int
    chargers: int


@dataclass(frozen=True)
class Power:
    """The energy balance of a fleet in the long run: energies in the model's unit, rates per time unit.

    Attributes:
        task: energy that a task draws in free flow, without other robots in the way.
        share: that energy as a share of a battery's capacity.
        lasts: time for which a full battery lasts a robot that is always at work.
        chargers: number of chargers that robots can stand at.
        charging_rate: mean rate at which a charger gives energy, from the level at which robots come to the level at
            which they leave, without the time in which one robot makes way for the next; None without chargers.
        gives: rate at which all chargers together give energy.
        draws: rate at which the fleet draws energy in the long run, with as many robots charging as must, or as
            chargers allow; None if the work ends.
        most: rate at which the fleet would draw energy with all robots in the state that draws most.
        needed: number of chargers with which the long run is in balance, nights included, none of them shared by kinds
            that share no charger; None if the work ends.
        standing: rate at which a robot draws energy while it stands and waits.
        slack: rate by which the fleet may draw more than chargers give: what nights store in its batteries, below 0 if
            they empty them or, without such nights, what does not yet count as falling.
        most_slack: that rate with as many chargers as could be of use, so that batteries are the limit.
        spares_give: rate at which spare batteries that are counted give energy, at most; inf without any.
        night: the time from the end of a run to the beginning of the next, as a multiple of the length of a run; None
            if a run is no day that repeats.
        by_chargers: share of the energy drawn that chargers give during the run; less than 1 if nights store some.
        at_once: number of robots that must charge at once, with fractions; 0 if the work ends.
        kinds: the balance of each kind ("": robots without a kind), with its robots and the chargers that these can
            stand at, if kinds differ in battery, charging or chargers; kinds share all work evenly. The other entries
            are then for the mean task (`task`, `share`), the battery that is empty first (`lasts`), and the whole
            fleet.
        groups: the kinds that share chargers, if kinds differ and the work never ends.
    """

    task: float
    share: float
    lasts: float
    chargers: int
    charging_rate: float | None
    gives: float
    draws: float | None
    most: float
    needed: int | None
    standing: float = 0.0
    slack: float = 0.0
    most_slack: float = 0.0
    spares_give: float = math.inf
    night: float | None = None
    by_chargers: float = 1.0
    at_once: float = 0.0
    kinds: Mapping[str, Power] = field(default_factory=dict)
    groups: tuple[SharedChargers, ...] = ()

    @property
    def enough(self) -> bool:
        """Whether there are as many chargers as needed, wherever kinds of robots need their own."""
        if self.groups:
            return all(group.needed <= group.chargers for group in self.groups)
        return self.needed is None or self.needed <= self.chargers

    @property
    def short(self) -> bool:
        """Whether the fleet draws more in the long run than chargers supply, by more than `slack`: batteries fall."""
        return self.draws is not None and self.draws - self.gives > self.slack


def power(
    model: Model, layout: Layout, cycle: MeanTask, cycles: Mapping[str, MeanTask], rate: float | None, at_work: int
) -> Power | None:
    """Return the energy balance of a fleet whose mean task may differ by kind (`cycles`); None without battery.

    `cycle`: the mean task of the fleet. `rate`: tasks per time unit, None if work always waits. `at_work`: the number
    of robots that can be on a task.
    """
    if model.battery is None:
        return None
    if charge_alike(model):
        return _alike(model, layout, cycle, rate, at_work)
    part, own = shares(model), _shared_out(model, layout)
    balances = {
        kind: _alike(alone, alone.floor, cycles.get(kind, cycle), rate, at_work, part[kind], own[kind])
        for kind, alone in by_kind(model).items()
    }
    at_once = math.fsum(balance.at_once for balance in balances.values())
    task = math.fsum(part[kind] * balance.task for kind, balance in balances.items())
    charging = math.fsum(
        part[kind] * balance.task / balance.charging_rate for kind, balance in balances.items() if balance.charging_rate
    )
    chargers = sum(chargers_at(model, layout).values())
    each = task / charging if charging else None
    groups = tuple(_groups(model, layout, balances)) if model.tasks.never_end else ()
    return Power(
        task=task,
        share=math.fsum(part[kind] * balance.share for kind, balance in balances.items()),
        lasts=min(balance.lasts for balance in balances.values()),
        chargers=chargers,
        charging_rate=each,
        gives=chargers * (each or 0.0),
        draws=math.fsum(balance.draws or 0.0 for balance in balances.values()) if model.tasks.never_end else None,
        most=math.fsum(balance.most for balance in balances.values()),
        needed=sum(group.needed for group in groups) if groups else None,
        standing=math.fsum(part[kind] * balance.standing for kind, balance in balances.items()),
        slack=math.fsum(balance.slack for balance in balances.values()),
        most_slack=math.fsum(balance.most_slack for balance in balances.values()),
        spares_give=math.fsum(balance.spares_give for balance in balances.values()),
        night=next(balance.night for balance in balances.values()),
        by_chargers=math.fsum(part[kind] * balance.by_chargers for kind, balance in balances.items()),
        at_once=at_once,
        kinds=balances,
        groups=groups,
    )


def _groups(model: Model, layout: Layout, balances: Mapping[str, Power]) -> Iterator[SharedChargers]:
    """Yield the kinds that share chargers, with the chargers that they need and have together."""
    sharing = nx.Graph()
    sharing.add_nodes_from(balances)
    count_by_kinds: dict[tuple[str, ...], int] = {}
    for node, count in chargers_at(model, layout).items():
        served = tuple(kind for kind in balances if layout.bays[node].charges(kind))
        nx.add_path(sharing, served)
        count_by_kinds[served] = count_by_kinds.get(served, 0) + count
    for group in nx.connected_components(sharing):
        at_once = math.fsum(balances[kind].at_once for kind in group)
        chargers = sum(count for served, count in count_by_kinds.items() if group.issuperset(served) and served)
        kinds = tuple(kind for kind in balances if kind in group)
        yield SharedChargers(kinds, math.ceil(at_once - _EPS), chargers)


def _shared_out(model: Model, layout: Layout) -> dict[str, float]:
    """Return the chargers of each kind, with fractions, if kinds use those that they share in proportion to robots."""
    part = shares(model)
    own = dict.fromkeys(part, 0.0)
    for node, count in chargers_at(model, layout).items():
        served = [kind for kind in part if layout.bays[node].charges(kind)]
        robots = math.fsum(part[kind] for kind in served)
        for kind in served:
            own[kind] += count * part[kind] / robots
    return own


def _alike(
    model: Model,
    layout: Layout,
    cycle: MeanTask,
    rate: float | None,
    at_work: int,
    part: float = 1.0,
    own: float | None = None,
) -> Power:
    """Return the balance of a share (`part`) of a fleet that charges alike.

    `own`: the part of the chargers that it uses, with fractions, where others share them; None for all.
    """
    battery = model.battery
    assert battery is not None
    draws, robots = battery.draws, model.fleet.size
    task = cycle.energy
    at_task = task / cycle.time if cycle.time else draws.standing
    time, energy = _at_rate(cycle, rate, at_work)
    chargers = sum(chargers_at(model, layout).values())
    each = task / cycle.charging if task and cycle.charging else charging_rate(model)
    busiest = max(draws.standing, draws.empty, draws.loaded, draws.handling)
    away, night, length = idle_away(model, layout), night_after_run(model), model.run.end
    at_hand = (chargers if own is None else own) / part  # as if the whole fleet were alike

    def drawn(charging: float, chargers: float) -> float:
        """Return the rate at which the fleet draws energy in the long run, with so many robots charging at chargers."""
        work = max(min(at_work, robots - charging), 0.0)
        by_work = work * at_task
        if rate is not None and rate * time < work:
            work, by_work = rate * time, rate * energy
        idle = max(robots - charging - work, 0.0)
        connected = min((1 - away) * idle, max(chargers - charging, 0.0))
        return by_work + (idle - connected) * draws.standing

    def stored(chargers: float) -> float:
        """Return the rate at which the run may draw what these chargers store in the night."""
        return (stored_overnight(model, chargers) or 0.0) / length

    def suffices(charging: float, chargers: float) -> bool:
        """Whether so many robots charging, and the night at so many chargers, give what the fleet draws."""
        return (charging * each if charging else 0.0) + stored(chargers) >= drawn(charging, chargers)

    needed, used, at_once = None, 0.0, 0.0
    if model.tasks.never_end:
        used = _least(lambda charging: suffices(charging, at_hand), robots)
        at_once = part * _least(lambda charging: suffices(charging, charging), robots)
        needed = math.ceil(at_once - _EPS)
    draws_in_all = drawn(min(at_hand, used), at_hand)
    falling = robots * FALLING * battery.capacity / model.units.hour
    return Power(
        task=task,
        share=task / battery.capacity,
        lasts=battery.capacity / at_task if at_task else math.inf,
        chargers=chargers,
        charging_rate=each if chargers else None,
        gives=chargers * each if chargers else 0.0,
        draws=None if needed is None else part * draws_in_all,
        most=part * robots * busiest,
        needed=needed,
        standing=draws.standing,
        slack=part * (falling if night is None else stored(at_hand)),
        most_slack=part * (falling if night is None else stored(robots)),
        spares_give=given_by_spares(model),
        night=None if night is None else night / length,
        by_chargers=max(1 - stored(at_hand) / draws_in_all, 0.0) if draws_in_all else 1.0,
        at_once=at_once,
    )


def _least(suffices: Callable[[float], bool], robots: int) -> float:
    """Return the least number of robots, with fractions, that suffices; all of them if no number does."""
    below = bisect_left(range(robots), True, key=suffices) - 1  # the last is needed only in part
    return max(below + bisect_left(range(_STEPS), True, key=lambda k: suffices(below + k / _STEPS)) / _STEPS, 0.0)


def _at_rate(cycle: MeanTask, rate: float | None, robots: int) -> tuple[float, float]:
    """Return time and energy of a task at a rate of arrivals: robots go home in between whenever no task waits.

    Source: the share of the time in which tasks wait for one of n robots with utilisation ρ is about ρ^√(2 (n + 1))
    (Sakasegawa 1977, An approximation formula L_q ≈ α ρ^β / (1 - ρ), Annals of the Institute of Statistical Mathematics
    29, 67-75).
    """
    if rate is None or not robots or not cycle.calm_time:
        return cycle.time, cycle.energy
    busy = min(rate * cycle.time / robots, 1.0)
    waits = busy ** math.sqrt(2 * (robots + 1))
    return (
        waits * cycle.time + (1 - waits) * cycle.calm_time,
        waits * cycle.energy + (1 - waits) * cycle.calm_energy,
    )


def idle_away(model: Model, layout: Layout) -> float:
    """Return the share of idle robots that would rest in slots without a charger if no robot took their place.

    Each robot that is charged in a slot where another rests keeps that one away from the charger, so that it draws on.
    """
    if model.policies.parking.name == "where-it-is":
        return 1.0
    home = model.fleet.homes(layout.bays)
    slots = slots_at(model, layout)
    with_charger = {node for node, chargers in chargers_at(model, layout).items() if chargers >= slots[node]}
    if model.policies.parking.name in {"home", "stay"}:
        return sum(node not in with_charger for node in home) / len(home)
    return float(any(node not in with_charger for node in layout.bays))


def needed_at_rest(model: Model) -> int:
    """Return the number of chargers that supply a fleet without work."""
    each, standing = charging_rate(model), draw_standing(model)
    return math.ceil(model.fleet.size * standing / (each + standing) - _EPS)


def draw_at_rest(model: Model, layout: Layout) -> float:
    """Return the rate at which a fleet without work draws energy while robots stand at all its chargers."""
    return off_chargers(model, layout) * draw_standing(model)


def gives_at_rest(model: Model, layout: Layout) -> float:
    """Return the rate at which all chargers together give energy, averaged over the levels of a charge."""
    return sum(chargers_at(model, layout).values()) * charging_rate(model)


def drawn_at_rest(model: Model, layout: Layout) -> str:
    """Return in words what a fleet without work draws."""
    count, drawn = off_chargers(model, layout), amount(draw_at_rest(model, layout))
    who = f"{number_of(count, 'robot')} without a charger {'draws' if count == 1 else 'draw'}"
    return f"at rest, {who} {drawn} per {model.units.time}"


def resting(model: Model, layout: Layout) -> str:
    """Return in words what a fleet without work draws, and what it gets from its chargers."""
    chargers, charged = sum(chargers_at(model, layout).values()), amount(gives_at_rest(model, layout))
    supply = f"{number_of(chargers, 'charger')} {'supplies' if chargers == 1 else 'supply'} {charged}"
    return f"{drawn_at_rest(model, layout)}, and {supply}"


def at_rest(model: Model, layout: Layout) -> str:
    """Return in words what a fleet without work draws, against the supply of its chargers."""
    text = resting(model, layout)
    if draw_at_rest(model, layout) > gives_at_rest(model, layout):
        needed = number_of(needed_at_rest(model), "charger")
        return f"{text}: at least {needed} {'is' if needed.startswith('1 ') else 'are'} needed"
    return f"{text}, less the energy for driving there and back"


def off_chargers(model: Model, layout: Layout) -> int:
    """Return how many robots of a fleet without work stand at no charger."""
    return max(model.fleet.size - sum(chargers_at(model, layout).values()), 0)
