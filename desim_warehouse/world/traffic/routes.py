"""Routes from the routing policy, with its answers checked: the lanes from one node to another."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import networkx as nx

from desim_warehouse.errors import PolicyError, nearest, shown
from desim_warehouse.layout import Layout
from desim_warehouse.layout.layout import Edge
from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.policies import Roads
from desim_warehouse.policies.asked import asked_for_all, fault, is_ours
from desim_warehouse.policies.routing import DETOURS, LESS, time_along
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.closures import Restrictions
from desim_warehouse.world.traffic.events import Clock
from desim_warehouse.world.traffic.lane import Lane

_ATTRIBUTES = ("length", "speed")
_USUAL = "weight"
"""The weight attribute that networkx uses by default."""


class PassageMeans(Mapping[Edge, float]):
    """Running means per passage of every edge, always up to date."""

    def __init__(self, lanes: Mapping[Edge, Lane], mean: Callable[[Lane], float]) -> None:
        self._lanes = lanes
        self._mean = mean

    def __getitem__(self, edge: Edge) -> float:
        return self._mean(self._lanes[edge])

    def __iter__(self) -> Iterator[Edge]:
        return iter(self._lanes)

    def __len__(self) -> int:
        return len(self._lanes)


class Routes:
    """The routes of robots by the routing policy, whose answers are checked.

    `waits` and `collisions` are means per passage of each edge, its end node included. `break_down`: robots break down,
    so lanes may be blocked.
    """

    # All that a routing policy may ask, long as the list is.
    def __init__(
        self,
        env: Clock,
        policy: Any,
        layout: Layout,
        travel: FreeTravel,
        lanes: Mapping[Edge, Lane],
        contact: float,
        restrictions: Restrictions,
        *,
        break_down: bool = False,
    ) -> None:
        self.env = env
        self.policy = policy
        self.lanes = lanes
        self.goes_round = bool(getattr(policy, "goes_round", False))
        self._closes = {
            edge: by_hours
            for edge, closures in restrictions.closures.items()
            if (by_hours := [closure for closure in closures if not closure.is_person])
        }
        self.passes_closures = bool(self._closes) and bool(getattr(policy, "knows_closures", False))
        self.detours = int(getattr(policy, "detours", DETOURS if self.passes_closures else 0))
        self.waits = PassageMeans(
            lanes, lambda lane: lane.blocked / (lane.passages + 1) + lane.end.blocked / (lane.end.passages + 1)
        )
        self.collisions = PassageMeans(
            lanes, lambda lane: lane.waits / (lane.passages + 1) + lane.end.waits / (lane.end.passages + 1)
        )
        self.roads = Roads(
            graph=layout.graph if is_ours(policy) else _strict(layout.graph),
            oracle=travel.oracle,
            waits=self.waits,
            queued=self._queued,
            speed=travel.speed,
            node_time=travel.node_time,
            node_times=travel.node_times,
            contact=contact,
            turning=self._turning if travel.turn_time else None,
            closed_for=self._closed_for if restrictions.closures or break_down else None,
            limit=self._limit if restrictions.slow else None,
            shut_for=partial(self._shut_for, 0.0, contact / travel.speed) if self._closes else None,
        )
        self._broken: dict[Body, tuple[Collection[Edge], float]] = {}
        self.blocked = self._broken.values()
        """Lanes with a broken robot, and for how long they are expected to be blocked."""
        self._in_lane = layout.in_lane
        self._shafts = layout.lifts
        self._fixed = bool(getattr(policy, "fixed", False)) and not self.passes_closures
        self._known: dict[Edge, list[Lane]] = {}

    def route(self, origin: str, goal: str, speed: float | None = None, after: float = 0.0) -> list[Lane]:
        """Return the lanes from one node to another, as the routing policy chooses them.

        Where lanes close, the route is for a robot of a `speed` that sets out `after` some time.
        """
        lanes = self._known.get((origin, goal)) if self._fixed else None
        if lanes is None:
            lanes = self._ask(origin, goal, self._roads(speed, after))
            if self._fixed:
                self._known[origin, goal] = lanes
        return lanes

    def _roads(self, speed: float | None, after: float) -> Roads:
        """Return the Highways as the routing policy sees them, for a robot's speed and departure time."""
        roads = self.roads
        if not self.passes_closures or (after == 0 and speed in {None, roads.speed}):
            return roads
        speed = roads.speed if speed is None else speed
        shut_for = partial(self._shut_for, after, self.roads.contact / speed)
        return replace(roads, speed=speed, shut_for=shut_for, closed_for=partial(self._closed_later, after))

    def _ask(self, origin: str, goal: str, roads: Roads) -> list[Lane]:
        policy, now, check = self.policy, self.env.now, partial(self._checked, origin, goal)
        nodes = "the nodes of a route"
        return asked_for_all("routing", policy, now, lambda: policy.route(origin, goal, roads), check, nodes)

    def _checked(self, origin: str, goal: str, names: Sequence[Any]) -> list[Lane]:
        """Check the nodes of a route from the policy, and return its lanes."""
        try:
            lanes = [self.lanes[step] for step in itertools.pairwise(names) if step in self.lanes]
        except TypeError:  # names that cannot be looked up
            lanes = []
        if not names or names[0] != origin or names[-1] != goal or len(lanes) != len(names) - 1:
            raise self._no_route(names, origin, goal)
        closed = self._in_lane.intersection(names[1:-1])
        if closed:
            raise self._no_route(names, origin, goal, f", as {min(closed)} is a bay in the lane (layout.bays: in_lane)")
        if self._shafts and (through := self._through_lift(lanes)) is not None:
            why = f", as {through} is in a lift, through which it leads on one floor"
            raise self._no_route(names, origin, goal, why)
        return lanes

    def _no_route(self, names: Sequence[object], origin: str, goal: str, why: str = "") -> PolicyError:
        """Make the error for an answer of the policy that is no route; `why` continues its sentence."""
        are_names = all(isinstance(name, str) for name in names)
        route = " > ".join(map(str if are_names else shown, names)) or "nothing"
        return fault("routing", self.policy, self.env.now, f"{route} is no route from {origin} to {goal}{why}")

    def _through_lift(self, lanes: Sequence[Lane]) -> str | None:
        """Return the node of a lift through which lanes lead in and out on the same floor."""
        for lane, onward in itertools.pairwise(lanes):
            if lane.end.is_lift and not lane.inside and not onward.inside:
                return lane.edge[1]
        return None

    def detour(self, node: str, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:
        """Return another route for a robot held up before `route[index]` at `node`, or None to wait."""
        last = route[-1]
        goal = last.edge[1] if stop is None else last.edge[0]
        if node == goal:
            return None
        other = self.route(node, goal)
        if stop is not None:
            other = [*other, last]
        return None if other[0] is route[index] else other

    def way_past(
        self, node: str, rest: Sequence[Lane], stop: float | None, speed: float, after: float
    ) -> list[Lane] | None:
        """Return another route by which a robot that comes to `node` after some time arrives sooner than by `rest`.

        Return None if no lane on the rest would keep the robot waiting for its opening.
        """
        last = rest[-1]
        goal = last.edge[1] if stop is None else last.edge[0]
        roads = self._roads(speed, after)
        names = [node, *(lane.edge[1] for lane in rest)]
        free, present = (time_along(names, roads, closed_for) for closed_for in (None, roads.shut_for))
        if node == goal or present <= free:
            return None
        other = self.route(node, goal, speed, after)
        if stop is not None:
            other = [*other, last]
        time = time_along([node, *(lane.edge[1] for lane in other)], roads, roads.shut_for)
        return other if time < present * (1 - LESS) else None

    def delay(self, origin: str, edge: Edge, speed: float, usual: float) -> float:
        """Return how much later than by the `usual` time a robot is at the end of an edge because lanes close."""
        if not self.passes_closures:
            return 0.0
        roads = self._roads(speed, 0.0)
        names = [origin, *(lane.edge[1] for lane in self.route(origin, edge[0], speed)), edge[1]]
        later = time_along(names, roads, roads.shut_for) - usual - time_along(edge, roads, None)
        return later if later > LESS * usual else 0.0

    def _turning(self, before: str, node: str, after: str) -> float:
        return self.lanes[before, node].turn_to(self.lanes[node, after])

    def _closed_for(self, edge: Edge, after: float) -> float:
        blocked = max((left for edges, left in self._broken.values() if edge in edges), default=0.0)
        return max(wait_at(self.lanes[edge], after, self.env.now), blocked - after)

    def _closed_later(self, begin: float, edge: Edge, after: float) -> float:
        return self._closed_for(edge, begin + after)

    def _shut_for(self, begin: float, approach: float, edge: Edge, after: float) -> float:
        """Return how long an edge is closed to a robot that sets out `begin` from now, `approach` before the node."""
        closures = self._closes.get(edge)
        if closures is None:
            return 0.0
        now = self.env.now
        claims = max(now, now + begin + after - approach)
        return max(0.0, *(closure.closed_until(claims) - claims for closure in closures))

    def block(self, robot: Body, left: float) -> None:
        """Record for how long the lane of a broken robot, or all lanes to its node, are expected to be blocked."""
        if robot.held is not None:
            edges = [edge for edge, lane in self.lanes.items() if lane.end is robot.held]
        else:
            lane = robot.lane
            edges = [lane.edge] if lane.twin is None else [lane.edge, lane.twin.edge]
        self._broken[robot] = edges, left

    def unblock(self, robot: Body) -> None:
        """Free the lanes of a robot that works again, or is off the lanes."""
        self._broken.pop(robot, None)

    def _limit(self, edge: Edge) -> float:
        return self.lanes[edge].limit

    def _queued(self, edge: Edge) -> int:
        """Return the number of robots that wait on an edge now."""
        count, robot = 0, self.lanes[edge].last
        while robot is not None:
            count += robot.is_waiting
            robot = robot.ahead
        return count


def wait_at(lane: Lane, after: float, now: float) -> float:
    """Return the expected wait of a robot before a lane that it reaches `after` from now."""
    time = now + after
    return max([0.0, *(closure.expected_until(time, now) - time for closure in lane.closures)])


class _EdgeData(dict[str, Any]):
    """An edge as a user's own policy sees it, where a misspelt attribute is an error.

    Algorithms of networkx take 1 for a missing weight: `weight="lenght"` counts edges unnoticed.
    """

    def get(self, key: str, default: Any = None) -> Any:
        """Return the attribute; raises KeyError for an attribute that no edge has."""
        if key not in self and key not in _ATTRIBUTES and key != _USUAL:
            near = nearest(key, _ATTRIBUTES)
            raise KeyError(f"edges have no {key!r}, {f'did you mean {near!r}?' if near else 'but length and speed'}")
        return super().get(key, default)


def _strict(graph: nx.DiGraph) -> nx.DiGraph:
    """Copy a graph for a user's own policy, so that to `get` a misspelt attribute raises KeyError."""
    strict = nx.DiGraph()
    strict.edge_attr_dict_factory = _EdgeData
    strict.add_nodes_from(graph.nodes(data=True))
    strict.add_edges_from(graph.edges(data=True))
    return strict
