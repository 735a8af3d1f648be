"""The energy balance of a model: what tasks draw, what chargers give, how many are needed."""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass
from typing import TYPE_CHECKING

from desim_warehouse.findings import amount
from desim_warehouse.model.facts.charging import chargers_at, charging_rate

if TYPE_CHECKING:
    from desim_warehouse.feasibility.cycle import Cycle
    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model


@dataclass(frozen=True)
class Power:
    """Energies in the model's unit, rates per time unit.

    Attributes:
        task: what a task draws in free flow; `share` of a battery's capacity.
        lasts: time for which a full battery lasts a robot that is always at work.
        chargers: all chargers that robots can stand at.
        charging_rate: what a charger gives from the level at which robots come to that at which they leave, the
            change between robots not counted; None without chargers.
        gives: what all chargers give.
        draws: what the fleet draws in the long run, with as many robots charging as must, or as can; None where the
            work comes to an end.
        most: what it would draw with all robots in the state that draws most.
        needed: chargers with which the long run is in balance; None where the work ends.
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

    @property
    def short(self) -> bool:
        """Whether more is drawn in the long run than the chargers give."""
        return self.needed is not None and self.needed > self.chargers

    def lines(self, time: str) -> list[str]:
        """The energy balance in words."""
        lasts = "never runs out" if math.isinf(self.lasts) else f"lasts {amount(self.lasts)} {time} of work"
        lines = [
            f"energy: a task draws {amount(self.task)}, {amount(100 * self.share)} % of a battery; a full one {lasts}"
        ]
        balance = f"chargers: {self.chargers}, which give {amount(self.gives)} per {time}"
        if self.draws is not None and self.needed is not None:
            balance += (
                f"; the fleet draws {amount(self.draws)}, at most {amount(self.most)}: need at least {self.needed}"
            )
        return [*lines, balance]


def power(model: Model, layout: Layout, cycle: Cycle, rate: float | None, at_work: int) -> Power | None:
    """The energy balance; None without battery."""
    battery = model.battery
    if battery is None:
        return None
    draws, robots = battery.draws, model.fleet.size
    task = cycle.energy(draws)
    at_task = task / cycle.time if cycle.time else draws.standing
    chargers = sum(chargers_at(model, layout).values())
    each = charging_rate(model)
    busiest = max(draws.standing, draws.empty, draws.loaded, draws.handling)
    away = idle_away(model, layout)

    def drawn(charging: float) -> float:
        """Drawn by the fleet in the long run, with this number of robots charging."""
        free = max(min(at_work, robots - charging), 0.0)
        work = free if rate is None else min(rate * cycle.time, free)
        return work * at_task + max(robots - charging - work, 0.0) * away * draws.standing

    needed = None
    if model.tasks.never_end:
        needed = bisect_left(range(robots), True, key=lambda k: (k * each if k else 0.0) >= drawn(k))
    return Power(
        task=task,
        share=task / battery.capacity,
        lasts=battery.capacity / at_task if at_task else math.inf,
        chargers=chargers,
        charging_rate=each if chargers else None,
        gives=chargers * each if chargers else 0.0,
        draws=None if needed is None else drawn(min(chargers, needed)),
        most=robots * busiest,
        needed=needed,
    )


def idle_away(model: Model, layout: Layout) -> float:
    """The share of idle robots that stand without a charger, and so draw on."""
    with_charger = chargers_at(model, layout)
    if model.policies.parking.name in {"home", "stay"}:
        home = model.fleet.homes(layout.bays)
        return sum(node not in with_charger for node in home) / len(home)
    return float(any(node not in with_charger for node in layout.bays))
