"""Routing policies: the choice of a robot's route.

`cost` names the oracle whose routes a policy takes, so that other policies see driving times on its routes. `fixed`
routes change for closures alone, so without those each is computed once a run. With `knows_closures` routes go round
lanes closed by `traffic.closures` if waiting takes longer. With `goes_round` they go round people and broken robots,
too.

The policies share the way with the least expected time (`quickest`), and the choice between waiting before a closed
lane and going round it (`past_closures`), both below.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, TypeAlias

from desim_warehouse.policies.protocols import Roads

Closed: TypeAlias = Callable[[tuple[str, str], float], float] | None
Waiting: TypeAlias = Callable[[tuple[str, str]], float] | None

NEVER = 1e12
"""The cost of an edge that does not open again: larger than any other, but finite, so that routes over it compare."""
DETOURS = 3
"""How often a robot may change its route on one drive, so that it does arrive."""
LESS = 1e-9
"""The relative gain that another way must have: smaller gains are rounding."""


@dataclass(frozen=True)
class Highways:
    """Takes the route with the fewest nodes, by breadth-first search (the paper); ties by order of successors.

    Around lanes closed by `traffic.closures`, where waiting would take longer, it takes the quickest other route.
    Source: Liu et al., ROBIO 2017, Algorithm 1.
    """

    title: ClassVar = "the fewest nodes"
    cost: ClassVar[str] = "hops"
    fixed: ClassVar[bool] = True
    knows_closures: ClassVar[bool] = True

    def route(self, origin: str, goal: str, roads: Roads) -> Sequence[str]:
        """Return the nodes from origin to goal, both included."""
        return past_closures(roads.oracle("hops").way(origin, goal), roads)


@dataclass(frozen=True)
class Shortest:
    """Takes the shortest route; of equally short ones, `spread` of them in turn.

    Around lanes closed by `traffic.closures`, where waiting would take longer, it takes the quickest other route. Grids
    have many equally short routes, and robots that all take the same one jam it. Length and time do not depend on which
    is taken. Source: Dijkstra, Numerische Mathematik 1 (1959) 269-271.

    `spread`: how many of the equally short routes between two nodes are used; one where turns take time.
    """

    title: ClassVar = "the shortest route"
    spread: int = 1
    cost: ClassVar[str] = "length"
    knows_closures: ClassVar[bool] = True
    turns: Iterator[int] = field(init=False, repr=False, compare=False, default_factory=itertools.count)

    def __post_init__(self) -> None:
        """Check the parameter."""
        if not self.spread >= 1:
            raise ValueError(f"spread is {self.spread}, expected at least 1 route")

    @property
    def fixed(self) -> bool:
        """Whether the route between two nodes is always the same."""
        return self.spread == 1

    def route(self, origin: str, goal: str, roads: Roads) -> Sequence[str]:
        """Return the nodes from origin to goal, both included."""
        return past_closures(roads.oracle(self.cost).way(origin, goal, _tie(self.turns, self.spread)), roads)


@dataclass(frozen=True)
class Fastest(Shortest):
    """Takes the fastest route without traffic, with node times and speed limits; of several, `spread` of them in turn.

    Waiting counts only before lanes closed by `traffic.closures`, as for `shortest`. Length and time do not depend on
    which route is taken. Source: Dijkstra (1959).

    `spread`: how many of the equally fast routes between two nodes are used; one where turns take time.
    """

    title: ClassVar = "the fastest route"
    cost: ClassVar[str] = "time"


def _tie(turns: Iterator[int], spread: int) -> int:
    """Return the rank of the equally good route to take in this turn; 0: the route taken without `spread`."""
    return 0 if spread == 1 else 1 + next(turns) % spread


@dataclass(frozen=True)
class CongestionAware:
    """Takes the route with the least expected time: free driving, mean waiting on each edge so far, and present queues.

    A closed edge, or one with a person or a broken robot in it, costs the time until it is expected to open; slow zones
    count as they are now. A robot held up at a node decides again there, at most `detours` times on a route, so that it
    does arrive. A queue of n robots before a node counts as n times the time in which one clears it. Source: A* search,
    Hart, Nilsson and Raphael, IEEE Trans. Systems Science and Cybernetics 4 (1968) 100-107, with the free time left as
    its estimate.

    `history`: weight of the mean waiting so far. `queues`: weight of the queues now. `detours`: see above.
    """

    title: ClassVar = "around queues"
    history: float = 1.0
    queues: float = 1.0
    detours: int = DETOURS
    cost: ClassVar[str] = "time"
    knows_closures: ClassVar[bool] = True
    goes_round: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the parameters."""
        for name in ("history", "queues"):
            if not 0 <= getattr(self, name) < math.inf:
                raise ValueError(f"{name} is {getattr(self, name)}, expected a weight of at least 0")
        if not (isinstance(self.detours, int) and self.detours >= 0):
            raise ValueError(f"detours is {self.detours}, expected a whole number of at least 0")

    def route(self, origin: str, goal: str, roads: Roads) -> Sequence[str]:
        """Return the nodes from origin to goal, both included; ties go to the node reached first."""
        headway = roads.contact / roads.speed + roads.node_time

        def waiting(edge: tuple[str, str]) -> float:
            time = self.history * roads.waits[edge] if self.history else 0.0
            return time + self.queues * headway * roads.queued(edge) if self.queues else time

        return quickest(origin, goal, roads, roads.closed_for, waiting)


def quickest(origin: str, goal: str, roads: Roads, closed_for: Closed, waiting: Waiting = None) -> list[str]:
    """Find the way with the least expected time, `waiting` at each edge included; ties go to the node reached first.

    A* search with the free time left as its estimate.
    """
    free = roads.oracle("time")
    edges = roads.graph.adj
    least = {origin: 0.0}
    before: dict[str, str] = {}
    rank = 0
    ahead = [(free.counted(origin, goal), rank, origin)]
    done: set[str] = set()
    while ahead:
        _, _, here = heapq.heappop(ahead)
        if here == goal:
            break
        if here in done or (here != origin and roads.graph.nodes[here].get("in_lane")):
            continue
        done.add(here)
        for successor in edges[here]:
            spent = 0.0 if waiting is None else waiting((here, successor))
            time = time_at_end(roads, before.get(here), here, successor, least[here], closed_for, spent)
            if time < least.get(successor, math.inf):
                least[successor] = time
                before[successor] = here
                rank += 1
                heapq.heappush(ahead, (time + free.counted(successor, goal), rank, successor))
    way = [goal]
    while way[-1] != origin:
        way.append(before[way[-1]])
    return way[::-1]


def past_closures(way: Sequence[str], roads: Roads) -> Sequence[str]:
    """Return the way, or a quicker one if the robot would wait on it for a closed edge to open."""
    if roads.shut_for is None or len(way) < 2:  # noqa: PLR2004 - one node is no way
        return way
    free, usual = (time_along(way, roads, closed_for) for closed_for in (None, roads.shut_for))
    if usual <= free:
        return way
    other = quickest(way[0], way[-1], roads, roads.shut_for)
    return other if time_along(other, roads, roads.shut_for) < usual * (1 - LESS) else way


def time_along(way: Sequence[str], roads: Roads, closed_for: Closed) -> float:
    """Return the time that a robot takes along the nodes of a way if it sets out now."""
    time, before = 0.0, None
    for here, successor in itertools.pairwise(way):
        time = time_at_end(roads, before, here, successor, time, closed_for)
        before = here
    return time


def time_at_end(
    roads: Roads, before: str | None, here: str, target: str, begin: float, closed_for: Closed, waiting: float = 0.0
) -> float:
    """Return the time at which a robot reaches `target` from `here`, at `begin`, where it came from `before`."""
    edge = roads.graph.adj[here][target]
    counts = edge.get("counts", 1.0)
    speed = edge["speed"] if roads.limit is None else roads.limit((here, target))
    driving = edge["length"] / min(roads.speed, speed)
    time: float = begin + driving * counts + roads.time_at(target) * counts + waiting
    if not driving:
        time += edge["takes"]  # a ride in a lift
    if closed_for is not None:
        time += min(closed_for((here, target), begin), NEVER)
    if roads.turning is not None and before is not None:
        time += roads.turning(before, here, target)
    return time
