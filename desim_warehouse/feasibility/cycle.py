"""The mean task of a robot in free flow, part by part, and free driving by the routes that its robots take."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from desim_warehouse.layout.travel import travel_on
from desim_warehouse.model.facts.destinations import destinations
from desim_warehouse.policies import create

if TYPE_CHECKING:
    from desim_warehouse.layout import Layout
    from desim_warehouse.layout.travel import FreeTravel
    from desim_warehouse.model import Model
    from desim_warehouse.model.sections.battery import Consumption


@dataclass(frozen=True)
class Cycle:
    """One task as a robot does it when there is always a next one: the mean time of each part, in time units.

    `empty` is the drive from the station of the task before to the good, `loaded` that from there to the station.
    """

    empty: float
    load: float
    loaded: float
    unload: float
    clear: float

    @property
    def time(self) -> float:
        """The mean time of the whole task."""
        return self.empty + self.load + self.loaded + self.unload + self.clear

    def shared(self, loads: int) -> Cycle:
        """The part of one task of a tour with this many loads that takes no longer than one task: the best possible.

        Every load is handled by itself; the drives, and what it takes to clear the last place, are shared.
        """
        return Cycle(self.empty / loads, self.load, self.loaded / loads, self.unload, self.clear / loads)

    def energy(self, draws: Consumption) -> float:
        """The energy that the task draws from the battery."""
        return (
            draws.empty * (self.empty + self.clear)
            + draws.handling * (self.load + self.unload)
            + draws.loaded * self.loaded
        )


def free_travel(model: Model, layout: Layout, speed: float, slowness: float) -> FreeTravel:
    """Driving times by the routes of the model's routing policy at a speed; for `slowness` see `FreeTravel`."""
    policy, traffic = model.policies.routing, model.traffic
    cost = getattr(create("routing", policy.name, policy.params), "cost", "time")
    hubs = (*layout.bays, *layout.stations, *destinations(model, layout))
    times = traffic.node_time, cost, hubs, traffic.turn_time, traffic.node_times, slowness
    return travel_on(layout, speed, *times, estimate=True)
