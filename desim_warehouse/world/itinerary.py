"""Where a robot drives: the legs of its route, to a good, to the station, to a bay.

The routing policy is asked leg by leg, when the robot sets out on one. Where steps are guarded (`avoidance`) all legs
are declared before it leaves its bay or station, and changed on the way only if that is safe.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from desim_warehouse.layout.travel import RouteOracle
    from desim_warehouse.policies import Task
    from desim_warehouse.world.avoidance import Avoidance
    from desim_warehouse.world.body import Body
    from desim_warehouse.world.lane import Lane
    from desim_warehouse.world.routes import Routes


class Itinerary:
    """The route of one robot: `legs` are what is left of it, `pick` the lane on which it fetches its good, and where.

    A good at a node is fetched standing on the node, as in a station's: `pick` is None. `drop` is the lane on which the
    good is put into storage, and where; None where it is brought to a node or a station.

    `free` knows the free driving times of the robot, `guard` decides on changes (None: nobody need know routes).
    """

    def __init__(
        self,
        body: Body,
        *,
        lanes: Mapping[tuple[str, str], Lane],
        routes: Routes,
        free: RouteOracle,
        guard: Avoidance | None,
    ) -> None:
        self.body = body
        self.lanes = lanes
        self.routes = routes
        self.free = free
        self.guard = guard
        self.pick: tuple[Lane, float] | None = None
        self.drop: tuple[Lane, float] | None = None
        self.legs: list[list[Lane]] = []

    @property
    def is_declared(self) -> bool:
        """Whether others know the route, so that it can be changed only where that is safe."""
        return self.guard is not None

    def edge_of(self, task: Task) -> tuple[str, str]:
        """The edge on which it picks a task's good: of a two-way lane the one that it drives."""
        return task.edge if self.pick is None else self.pick[0].edge

    def take_task(self, node: str, task: Task, station: str, bay: str | None, *, docks: bool = False) -> bool:
        """From `node` to the good, the station and, from one in the lane, to `bay`; False: the change is not safe.

        `docks`: it is loaded in a station, from which the rest of its route is declared (`bring`).
        """
        goal = station if task.drop is None else task.drop[0][0]
        self.pick = self._on_lane(node, task.edge, task.offset, goal)
        start, end = self.edge_of(task)
        legs = [self.routes.route(node, start)]
        if self.pick is not None:
            legs = [[*legs[0], self.pick[0]]]
        if self.guard is not None and not docks:
            legs += self._legs_with_load(end, task, station, bay)
        return self._set(*legs)

    def bring(self, node: str, task: Task, station: str, bay: str | None) -> list[Lane]:
        """The leg with the load, from `node`; out of a station it is declared only now, with that to `bay`."""
        if self.guard is None:
            return self._legs_with_load(node, task, station, None)[0]
        if not self.body.is_on_lanes:
            self._set(*self._legs_with_load(node, task, station, bay))
        return self.legs.pop(0)

    def _legs_with_load(self, node: str, task: Task, station: str, bay: str | None) -> list[list[Lane]]:
        self.drop = None if task.drop is None else self._on_lane(node, *task.drop, station)
        if self.drop is None:
            leg, end = self.routes.route(node, station), station
        else:
            start, end = self.drop[0].edge
            leg = [*self.routes.route(node, start), self.drop[0]]
        return [leg] if bay is None else [leg, self.routes.route(end, bay)]

    def _on_lane(self, node: str, edge: tuple[str, str], offset: float, goal: str) -> tuple[Lane, float] | None:
        """A storage place's lane, and how far along; a two-way lane is driven from the end that is sooner to `goal`."""
        if edge[0] == edge[1]:
            return None
        lane, times = self.lanes[edge], self.free.time
        if lane.twin is None:
            return lane, offset

        def time(way: tuple[Lane, float]) -> float:
            start, end = way[0].edge
            return times(node, start) + times(end, goal)

        return min(((lane, offset), (lane.twin, lane.length - offset)), key=time)

    def go(self, node: str, goal: str) -> bool:
        """Straight from `node` to `goal` instead of what was to come; False: the change is not safe."""
        return self._set(self.routes.route(node, goal))

    def _set(self, *legs: list[Lane]) -> bool:
        if self.guard is not None:
            route = [lane for leg in legs for lane in leg]
            if not self.body.is_on_lanes:
                self.guard.declare(self.body, route)
            elif not self.guard.change(self.body, route):
                return False
        self.legs = list(legs)
        return True

    def start(self, way: Sequence[str]) -> None:
        """On the lanes at the start of a run: over these nodes to the bay, until there is a task or another bay."""
        route = [self.lanes[edge] for edge in pairwise(way)]
        if self.guard is not None:
            self.guard.declare(self.body, route)
        self.legs = [route]

    def leg(self, node: str, goal: str) -> list[Lane]:
        """The next leg, from `node` to `goal`."""
        if self.guard is None:
            return self.routes.route(node, goal)
        if not self.body.is_on_lanes:
            self.go(node, goal)
        return self.legs.pop(0)

    def detour(self, node: str, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:
        """Another leg for a robot held up before `route[index]`, if the routing policy knows one and it is safe."""
        other = self.routes.detour(node, route, index, stop)
        if other is not None and self.guard is not None:
            rest = [lane for leg in self.legs for lane in leg]
            if not self.guard.change(self.body, [*other, *rest]):
                return None
        return other
