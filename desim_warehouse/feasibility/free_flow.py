"""Free driving: how long robots of one speed take to the goods and from them, where nobody is in their way."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from desim_warehouse.layout.travel import travel_on
from desim_warehouse.model.popularity import shares
from desim_warehouse.model.schema import Good
from desim_warehouse.policies import create

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model
    from desim_warehouse.model.schema import Consumption


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
        """All of it."""
        return self.empty + self.load + self.loaded + self.unload + self.clear

    def energy(self, draws: Consumption) -> float:
        """What it draws from the battery."""
        return (
            draws.empty * (self.empty + self.clear)
            + draws.handling * (self.load + self.unload)
            + draws.loaded * self.loaded
        )


class FreeFlow:
    """Driving times between nodes and the edges of the goods that are asked for, at one speed.

    `edges` are these edges, `share` the part of the demand that each has. On its edge a good is `before` the start
    and `after` the end, in time units: means over its goods, the end's node time included.
    """

    def __init__(self, model: Model, layout: Layout, speed: float) -> None:
        import numpy as np

        self.model = model
        node_time = model.traffic.node_time
        policy = model.policies.routing
        cost = getattr(create("routing", policy.name, policy.params), "cost", "time")
        self.stations = tuple(dict.fromkeys(model.tasks.unload_at))
        self.travel = travel_on(
            layout, speed, node_time, cost, (*layout.bays, *layout.stations, *model.tasks.unload_at)
        )
        weights = demand(model, layout)
        self.goods = np.flatnonzero(weights)
        places = [layout.storage[good] for good in self.goods]
        self.weights = weights[self.goods]
        self.edges = list(dict.fromkeys(place.edge for place in places))
        rank = {edge: i for i, edge in enumerate(self.edges)}
        self.edge_of = np.array([rank[place.edge] for place in places])
        lengths = np.array([layout.graph.edges[place.edge]["length"] for place in places])
        offsets = np.array([place.offset for place in places])
        paces = np.array([min(speed, layout.graph.edges[place.edge]["speed"]) for place in places])
        self.before = offsets / paces
        self.after = (lengths - offsets) / paces + node_time

    def to_edges(self, nodes: Sequence[str]) -> Any:
        """Times from nodes (rows) to the starts of the edges (columns)."""
        return self.travel.times(nodes, [edge[0] for edge in self.edges])

    def from_edges(self, nodes: Sequence[str]) -> Any:
        """Times from the ends of the edges (rows) to nodes (columns)."""
        return self.travel.times([edge[1] for edge in self.edges], nodes)

    def station_shares(self) -> Any:
        """Which part of the goods of each edge (rows) is brought to which of `stations` (columns), free of queues."""
        import numpy as np

        tasks = self.model.tasks
        alone = self.model.fleet.size == 1
        if tasks.station_choice == "nearest" or (tasks.station_choice == "least-loaded" and alone):
            nearest = self.from_edges(self.stations).argmin(axis=1)
            return np.eye(len(self.stations))[nearest]
        named = tasks.unload_at
        even = np.array([named.count(node) / len(named) for node in self.stations])
        return np.tile(even, (len(self.edges), 1))

    def cycle(self) -> Cycle:
        """The mean task, goods taken as they come."""
        import numpy as np

        tasks = self.model.tasks
        share = np.bincount(self.edge_of, self.weights, minlength=len(self.edges))
        station = self.station_shares()
        begins = share @ station
        empty = begins @ self.to_edges(self.stations) @ share + self.weights @ self.before
        loaded = share @ (station * self.from_edges(self.stations)).sum(axis=1) + self.weights @ self.after
        return Cycle(float(empty), tasks.load_time, float(loaded), tasks.unload_time, tasks.clear_time)

    def station_demand(self) -> Any:
        """The part of all tasks that each of `stations` gets."""
        import numpy as np

        return np.bincount(self.edge_of, self.weights, minlength=len(self.edges)) @ self.station_shares()


@lru_cache(maxsize=8)
def free_flow(model: Model, layout: Layout, speed: float) -> FreeFlow:
    """The FreeFlow of a model at a speed; runs of one model share it."""
    return FreeFlow(model, layout, speed)


def asked_for(model: Model, layout: Layout) -> list[int]:
    """The storage places that tasks fetch from."""
    goods = model.tasks.goods
    if isinstance(goods, tuple):
        return list(dict.fromkeys(item.good if isinstance(item, Good) else item for item in goods))
    drawn = shares(model.tasks.popularity, layout.storage)
    return [place.number for place in layout.storage if drawn is None or drawn[place.number] > 0]


def demand(model: Model, layout: Layout) -> Any:
    """The part of all tasks that fetch each storage place, a numpy array."""
    import numpy as np

    goods, size = model.tasks.goods, len(layout.storage)
    if isinstance(goods, tuple):
        numbers = [item.good if isinstance(item, Good) else item for item in goods]
        return np.bincount(numbers, minlength=size) / len(numbers)
    drawn = shares(model.tasks.popularity, layout.storage)
    return np.full(size, 1 / size) if drawn is None else drawn
