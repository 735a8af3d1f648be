"""Places cut off by closures that hold tasks back (`tasks: hold`): all ways to them are closed now.

A robot that set out for such a place would stand before the closure and block others. So its task waits until there is
a way, and a robot on its way to load turns off at the next node. A robot with a load goes on, as the load has to wait
somewhere. Where routes do not go round closed lanes, a place is cut off if the usual way is closed.

Where routes go round lanes with a broken robot, tasks also wait if all ways to a place lead over such lanes, and these
are expected to be blocked for longer than the drive there takes.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from itertools import pairwise

from desim_warehouse.layout import Layout
from desim_warehouse.layout.layout import Edge
from desim_warehouse.layout.oracle import RouteOracle
from desim_warehouse.layout.zones import edges_of
from desim_warehouse.model import Model
from desim_warehouse.values.calendars import Hours
from desim_warehouse.world.places.stops import Stop
from desim_warehouse.world.traffic.closures import ClosedHours

TRIES = 100
"""The number of openings in a row, each with other closures in the way, after which a task is no longer held back."""


class CutOff:
    """The closures of a model that hold tasks back.

    `ways` are the routes that robots take; with `goes_round` they take others when those are closed. `blocked` maps
    lanes with a broken robot to the expected end of the block. `turned_back` are tasks whose robot has turned off on
    the way. Their next robot completes the way, so that recurring closures cannot postpone a task for ever.
    """

    def __init__(
        self,
        model: Model,
        layout: Layout,
        ways: RouteOracle,
        *,
        goes_round: bool,
        blocked: Collection[tuple[Collection[Edge], float]] = (),
    ) -> None:
        self.layout = layout
        self.ways = ways
        self.goes_round = goes_round
        self.blocked = blocked
        self.closures = [
            (frozenset(edges_of(layout, closure.members)), ClosedHours(model.hours(closure.hours)))
            for closure in model.traffic.closures.values()
            if closure.tasks == "hold"
        ]
        self.turned_back: set[int] = set()
        self._reached: dict[tuple[str, frozenset[Edge]], set[str]] = {}
        self._open: dict[tuple[str, str, frozenset[Edge]], bool] = {}

    def opens(self, node: str, stops: Sequence[Stop], now: float) -> float:
        """Return when a robot at a node has a way to all of some stops: `now` if it has one already, inf if never."""
        time = now
        blocked = self._blocked(node, stops, now) if self.blocked else []
        for _ in range(TRIES):
            shut, until = self._shut(time, blocked)
            if not shut or not self._is_behind(node, stops, shut):
                return time
            if math.isinf(until):
                break
            time = until
        return now

    def has_way(self, origin: str, goal: str, now: float) -> bool:
        """Whether robots find a way from one node to another that is open now."""
        return self._leads(origin, goal, self._shut(now)[0])

    def changes(self, now: float) -> float:
        """Return when a closure begins or ends next, inf if none does."""
        return min((hours.hours.changes(now) for _, hours in self.closures), default=math.inf)

    @property
    def calendars(self) -> list[Hours]:
        """The calendars of the closures, which say when they are in force."""
        return [hours.hours for _, hours in self.closures]

    @property
    def holds(self) -> bool:
        """Whether a place may be behind a closure, or is behind a broken robot."""
        return bool(self.closures or self.blocked)

    def look_again(self) -> None:
        """Forget the ways found around lanes, as blocked lanes have changed."""
        self._reached.clear()

    def _blocked(self, node: str, stops: Sequence[Stop], now: float) -> list[tuple[frozenset[Edge], float]]:
        """Return the lanes expected to be blocked still when a robot reaches the first stop, and until when."""
        way = self.ways.time(node, stops[0].edge[0])
        return [(frozenset(edges), now + left) for edges, left in self.blocked if left > way]

    def _shut(
        self, time: float, blocked: Iterable[tuple[frozenset[Edge], float]] = ()
    ) -> tuple[frozenset[Edge], float]:
        """Return the edges that are closed or `blocked` at a time, and when the first of them opens."""
        until = [(edges, hours.closed_until(time)) for edges, hours in self.closures]
        until += blocked
        shut = [(edges, opens) for edges, opens in until if opens > time]
        closed = frozenset().union(*(edges for edges, _ in shut))
        return closed, min((opens for _, opens in shut), default=time)

    def _is_behind(self, node: str, stops: Sequence[Stop], shut: frozenset[Edge]) -> bool:
        """Whether the way from a node to one of some stops, in their order, is closed."""
        for rank, stop in enumerate(stops):
            if stop.edge[0] == stop.edge[1]:
                if not self._leads(node, stop.node, shut):
                    return True
                node = stop.node
                continue
            then = stop.node if rank + 1 == len(stops) else stops[rank + 1].edge[0]
            onto = [edge for edge in self._approaches(node, stop, then) if edge not in shut]
            edge = next((edge for edge in onto if self._leads(node, edge[0], shut)), None)
            if edge is None:
                return True
            node = edge[1]
        return False

    def _approaches(self, node: str, stop: Stop, then: str) -> list[Edge]:
        """Return the edges by which a robot may come to a storage place: its usual one, or any if it goes round."""
        edges = [edge for edge, _ in self.layout.approaches(stop.edge, stop.offset)]
        time = self.ways.time
        edges.sort(key=lambda edge: time(node, edge[0]) + time(edge[1], then))
        return edges if self.goes_round else edges[:1]

    def _leads(self, origin: str, goal: str, shut: frozenset[Edge]) -> bool:
        """Whether robots find a way from one node to another that is not closed."""
        if self.goes_round:
            return goal in self._from(origin, shut)
        key = origin, goal, shut
        if key not in self._open:
            self._open[key] = shut.isdisjoint(pairwise(self.ways.way(origin, goal)))
        return self._open[key]

    def _from(self, origin: str, shut: frozenset[Edge]) -> set[str]:
        """Return the nodes to which a way leads that is not closed; none leads on through a bay in the lane."""
        key = origin, shut
        if key not in self._reached:
            reached, line, after = {origin}, [origin], self.layout.graph.adj
            for here in line:
                if here == origin or here not in self.layout.in_lane:
                    further = [
                        neighbour
                        for neighbour in after[here]
                        if neighbour not in reached and (here, neighbour) not in shut
                    ]
                    reached.update(further)
                    line += further
            self._reached[key] = reached
        return self._reached[key]
