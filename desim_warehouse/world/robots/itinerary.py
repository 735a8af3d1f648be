"""Itineraries: the legs of a robot's route, to a good, to the station, to a bay.

The routing policy is asked for each leg when the robot sets out on it. Where steps are guarded (`avoidance`) all legs
are declared before it leaves its bay or station, and changed on the way only if that is safe.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TypeAlias

from desim_warehouse.layout.oracle import RouteOracle
from desim_warehouse.policies import Task
from desim_warehouse.world.places.stops import Stop
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.lane import Lane
from desim_warehouse.world.traffic.routes import Routes
from desim_warehouse.world.traffic.rulebook import StepGuard
from desim_warehouse.world.traffic.rules import EPS

Place: TypeAlias = tuple[Lane, float]
Leg: TypeAlias = tuple[list[Lane], Place | None]


class Itinerary:
    """The route of one robot.

    `legs` are its remaining parts, each up to a `place` on its last lane, or to the end of that lane.

    `place` is the lane with the good of the present stop, and the distance along it, or None at a node or in a station.

    `free` gives the robot's free driving times, `guard` decides on changes (None: routes need not be declared).
    """

    def __init__(
        self,
        body: Body,
        *,
        lanes: Mapping[tuple[str, str], Lane],
        routes: Routes,
        free: RouteOracle,
        guard: StepGuard | None,
    ) -> None:
        self.body = body
        self.lanes = lanes
        self.routes = routes
        self.free = free
        self.guard = guard
        self.place: Place | None = None
        self.legs: list[Leg] = []

    @property
    def is_declared(self) -> bool:
        """Whether other robots know the route, so that it can be changed only where that is safe."""
        return self.guard is not None

    def edge_of(self, task: Task) -> tuple[str, str]:
        """Return the edge on which the robot picks a task's good: on a two-way lane, the direction that it drives."""
        return task.edge if self.place is None else self.place[0].edge

    def take(self, node: str, stops: Sequence[Stop], bay: str | None) -> bool:
        """Set the route from `node` over the stops to the first in a station, or from a last stop in the lane to `bay`.

        Returns False if the change is not safe. Out of a station the rest is declared (`onward`).
        """
        legs = [self._leg(node, stops, None)] if self.guard is None else self._legs(node, stops, bay)
        self.place = legs[0][1]
        return self._set(legs)

    def onward(self, node: str, stops: Sequence[Stop], bay: str | None) -> Leg:
        """Return the leg to the next stop, from `node`. Out of a station, declare it now with the legs after it."""
        if self.guard is None:
            leg = self._leg(node, stops, self.place)
        else:
            if not self.body.is_on_lanes:
                self._set(self._legs(node, stops, bay))
            leg = self.legs.pop(0)
        self.place = leg[1]
        return leg

    def _legs(self, node: str, stops: Sequence[Stop], bay: str | None) -> list[Leg]:
        """Return the legs that are declared."""
        legs: list[Leg] = []
        place, after = None, 0.0
        for rank, stop in enumerate(stops):
            leg = self._leg(node, stops[rank:], place, after)
            legs.append(leg)
            place = leg[1]
            begin, node = node, stop.node if place is None else place[0].edge[1]
            after += self.free.time(begin, node)
            if stop.station is not None:
                return legs
        if bay is not None:
            legs.append((self._route(node, bay, after), None))
        return legs

    def _leg(self, node: str, stops: Sequence[Stop], last: Place | None, after: float = 0.0) -> Leg:
        """Return the leg to the first of some stops, from a `last` one on a lane to `node`, or from `node` itself."""
        stop = stops[0]
        if last is not None and stop.joins:
            lane, offset = last[0], stop.offset
            if lane.twin is not None and stop.edge == lane.twin.edge:
                offset = lane.length - offset
            elif stop.edge != lane.edge:
                offset = -1.0
            if offset >= last[1]:
                return [], (lane, offset)
        then = stop.node if stop is stops[-1] else stops[1].edge[0]
        place = self._on_lane(node, stop.edge, stop.offset, then)
        if place is None:
            return self._route(node, stop.node, after), None
        return [*self._route(node, place[0].edge[0], after), place[0]], place

    def _route(self, node: str, goal: str, after: float = 0.0) -> list[Lane]:
        """Return a route from the robot's present or next node, reached `after` some more time.

        Where lanes close, that arrival time and the robot's present speed matter.
        """
        routes, body = self.routes, self.body
        if not routes.passes_closures:
            return routes.route(node, goal)
        return routes.route(node, goal, body.speed, body.time_left + after)

    def _on_lane(self, node: str, edge: tuple[str, str], offset: float, goal: str) -> Place | None:
        """Return a storage place's lane and position on it; on two-way lanes in the direction that is sooner at `goal`.

        The nearer end does not decide alone, as a lane may be slower one way than the other. If both are as soon, up to
        rounding, the robot drives the direction of the storage place: in a dead end it does not drive past its good.
        """
        if edge[0] == edge[1]:
            return None
        lane, times, speed = self.lanes[edge], self.free.time, self.body.speed
        if lane.twin is None:
            return lane, offset

        def along(way: Lane) -> float:
            return way.length / min(speed, way.limit)

        least = min(along(lane), along(lane.twin))  # taken off: where both take as long, nothing is added to a sum

        def time(way: Place) -> float:
            start, end = way[0].edge
            approach, more = times(node, start), along(way[0]) - least
            return approach + more + times(end, goal) + self.routes.delay(node, way[0].edge, speed, approach)

        along_it, against_it = (lane, offset), (lane.twin, lane.length - offset)
        return against_it if time(against_it) < time(along_it) - EPS else along_it

    def go(self, node: str, goal: str) -> bool:
        """Replace the route by the straight way from `node` to `goal`, and return whether that change is safe."""
        return self._set([(self._route(node, goal), None)])

    def _set(self, legs: list[Leg]) -> bool:
        if self.guard is not None:
            route = [lane for leg, _ in legs for lane in leg]
            if not self.body.is_on_lanes:
                self.guard.declare(self.body, route)
            elif not self.guard.change(self.body, route):
                return False
        self.legs = legs
        return True

    def start(self, way: Sequence[str]) -> None:
        """Set the route at the start of a run on the lanes: over these nodes to the bay, until there is other work."""
        route = [self.lanes[edge] for edge in pairwise(way)]
        if self.guard is not None:
            self.guard.declare(self.body, route)
        self.legs = [(route, None)]

    def resume(self, rest: Sequence[Lane]) -> None:
        """Declare the remaining route again after a repair off the lanes: `rest` of this leg, and other legs."""
        if self.guard is not None:
            self.guard.declare(self.body, [*rest, *(lane for leg, _ in self.legs for lane in leg)])

    def stand_aside(self) -> None:
        """Declare the remaining route again, from the lane beside which the robot stands now."""
        if self.guard is not None:
            self.guard.stands_aside(self.body, [lane for leg, _ in self.legs for lane in leg])

    def leg(self, node: str, goal: str) -> list[Lane]:
        """Return the next leg, from `node` to `goal`."""
        if self.guard is None:
            return self._route(node, goal)
        if not self.body.is_on_lanes:
            self.go(node, goal)
        return self.legs.pop(0)[0]

    def detour(self, node: str, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:
        """Return another leg for a robot held up before `route[index]`, if the routing policy knows a safe one."""
        if not self.routes.goes_round and self.routes.passes_closures:
            return self.way_past(node, route[index:], stop)
        return self._if_safe(self.routes.detour(node, route, index, stop))

    def way_past(self, node: str, rest: Sequence[Lane], stop: float | None) -> list[Lane] | None:
        """Return another, safe leg from the next node, `node`, on which the robot waits less for lanes to open."""
        body = self.body
        return self._if_safe(self.routes.way_past(node, rest, stop, body.speed, body.time_left))

    def _if_safe(self, other: list[Lane] | None) -> list[Lane] | None:
        if other is not None and self.guard is not None:
            rest = [lane for leg, _ in self.legs for lane in leg]
            if not self.guard.change(self.body, [*other, *rest]):
                return None
        return other
