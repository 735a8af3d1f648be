"""Routes from the routing policy, with its answers checked: the lanes from one node to another."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import PolicyError, shown
from desim_warehouse.policies import Roads
from desim_warehouse.policies.asked import asked
from desim_warehouse.world.traffic.closures import wait_at

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

    from simpy import Environment

    from desim_warehouse.layout import Layout
    from desim_warehouse.layout.travel import FreeTravel
    from desim_warehouse.world.traffic.body import Body
    from desim_warehouse.world.traffic.closures import Restrictions
    from desim_warehouse.world.traffic.lane import Lane

Edge = tuple[str, str]


class PassageMeans(Mapping[Edge, float]):
    """A mean per passage of every edge so far, always up to date."""

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
    """Asks the routing policy.

    `waits` and `collisions` are means per passage of each edge, its end node included. Robots `break_down`: then lanes
    may be blocked.
    """

    def __init__(
        self,
        env: Environment,
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
        self.detours = int(getattr(policy, "detours", 0))
        self.goes_round = bool(getattr(policy, "goes_round", False))
        self.waits = PassageMeans(
            lanes, lambda lane: lane.blocked / (lane.passages + 1) + lane.end.blocked / (lane.end.passages + 1)
        )
        self.collisions = PassageMeans(
            lanes, lambda lane: lane.waits / (lane.passages + 1) + lane.end.waits / (lane.end.passages + 1)
        )
        self.roads = Roads(
            graph=layout.graph,
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
        )
        self._broken: dict[Body, tuple[Collection[Edge], float]] = {}
        self.blocked = self._broken.values()
        """Lanes with a broken robot, and for how long they are expected to be blocked."""
        self._in_lane = layout.in_lane
        self._fixed = bool(getattr(policy, "fixed", False))
        self._known: dict[Edge, list[Lane]] = {}

    def route(self, origin: str, goal: str) -> list[Lane]:
        """The lanes from one node to another, as the routing policy chooses them."""
        lanes = self._known.get((origin, goal)) if self._fixed else None
        if lanes is None:
            lanes = self._ask(origin, goal)
            if self._fixed:
                self._known[origin, goal] = lanes
        return lanes

    def _ask(self, origin: str, goal: str) -> list[Lane]:
        policy, now = self.policy, self.env.now
        names = asked("routing", policy, now, lambda: list(policy.route(origin, goal, self.roads)))
        try:
            lanes = [self.lanes[step] for step in itertools.pairwise(names) if step in self.lanes]
        except TypeError:  # names that cannot be looked up
            lanes = []
        if not names or names[0] != origin or names[-1] != goal or len(lanes) != len(names) - 1:
            known = all(isinstance(name, str) for name in names)
            raise PolicyError(
                f"policies.routing ({type(policy).__name__}) at time {now:g}: "
                f"{' > '.join(names if known else map(shown, names)) or 'nothing'} is no route from {origin} to {goal}"
            )
        closed = self._in_lane.intersection(names[1:-1])
        if closed:
            raise PolicyError(
                f"policies.routing ({type(policy).__name__}) at time {now:g}: {' > '.join(names)} is no route from "
                f"{origin} to {goal}, as {min(closed)} is a bay in the lane (layout.bays: in_lane)"
            )
        return lanes

    def detour(self, node: str, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:
        """Another route for a robot held up before `route[index]` at `node`, or None to wait."""
        last = route[-1]
        goal = last.edge[1] if stop is None else last.edge[0]
        if node == goal:
            return None
        other = self.route(node, goal)
        if stop is not None:
            other = [*other, last]
        return None if other[0] is route[index] else other

    def _turning(self, before: str, node: str, after: str) -> float:
        return self.lanes[before, node].turn_to(self.lanes[node, after])

    def _closed_for(self, edge: Edge, after: float) -> float:
        blocked = max((left for edges, left in self._broken.values() if edge in edges), default=0.0)
        return max(wait_at(self.lanes[edge], after, self.env.now), blocked - after)

    def block(self, robot: Body, left: float) -> None:
        """A robot has broken down: its lane, or all that lead to its node, are expected to be blocked for so long."""
        if robot.held is not None:
            edges = [edge for edge, lane in self.lanes.items() if lane.end is robot.held]
        else:
            lane = robot.lane
            edges = [lane.edge] if lane.twin is None else [lane.edge, lane.twin.edge]
        self._broken[robot] = edges, left

    def unblock(self, robot: Body) -> None:
        """It works again, or is off the lanes."""
        self._broken.pop(robot, None)

    def _limit(self, edge: Edge) -> float:
        return self.lanes[edge].limit

    def _queued(self, edge: Edge) -> int:
        """Robots that wait on an edge now."""
        count, robot = 0, self.lanes[edge].last
        while robot is not None:
            count += robot.is_waiting
            robot = robot.ahead
        return count
