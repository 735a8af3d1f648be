"""Routing policies: which route a robot takes.

`cost` names the oracle whose routes a policy takes, so that other policies see driving times on its routes. `fixed`
says that routes never change, so that each is computed once a run. `goes_round` says that they go round closed lanes.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator  # noqa: TC003 - the types of parameters are looked up when a model is read
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.policies.protocols import Roads


@dataclass(frozen=True)
class Highways:
    """Algorithm 1 of the paper: breadth-first, fewest nodes; of several routes the first in the order of successors.

    Source: Liu et al., ROBIO 2017, Algorithm 1.
    """

    cost: ClassVar[str] = "hops"
    fixed: ClassVar[bool] = True

    def route(self, origin: str, goal: str, roads: Roads) -> Sequence[str]:
        """The nodes from origin to goal, both included."""
        return roads.oracle("hops").way(origin, goal)


@dataclass(frozen=True)
class Shortest:
    """The shortest route; of several as short, `spread` of them in turn.

    Grids have many equally short routes, and robots that all take the same one jam it. Whichever is taken, length and
    time are the same. Source: Dijkstra, Numerische Mathematik 1 (1959) 269-271.

    `spread`: how many of the equally short routes between two nodes are used; one where turns take time.
    """

    spread: int = 1
    cost: ClassVar[str] = "length"
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
        """The nodes from origin to goal, both included."""
        return roads.oracle(self.cost).way(origin, goal, _tie(self.turns, self.spread))


@dataclass(frozen=True)
class Fastest(Shortest):
    """The fastest route without traffic, node times and speed limits included; of several, `spread` of them in turn.

    Waiting is not counted. Whichever is taken, length and time are the same. Source: Dijkstra (1959).

    `spread`: how many of the equally fast routes between two nodes are used; one where turns take time.
    """

    cost: ClassVar[str] = "time"


def _tie(turns: Iterator[int], spread: int) -> int:
    """Which of the equally good routes is taken in this turn; 0: the one that is always taken without `spread`."""
    return 0 if spread == 1 else 1 + next(turns) % spread


NEVER = 1e12
"""Cost of an edge that does not open again: more than any other, and routes over it can still be compared."""


@dataclass(frozen=True)
class CongestionAware:
    """The route with the least expected time: free driving, mean waiting on each edge so far, and the queues there now.

    A closed edge, or one with a person or a broken robot in it, costs the time until it is expected to open; slow zones
    count as they are now.
    A robot held up at a node decides again there, at most `detours` times on a route, so that it does arrive. A queue
    of n robots before a node counts as n times the time in which one clears it. Source: A* search, Hart, Nilsson and
    Raphael, IEEE Trans. Systems Science and Cybernetics 4 (1968) 100-107, with the free time left as its estimate.

    `history`: weight of the mean waiting so far. `queues`: weight of the queues now. `detours`: see above.
    """

    history: float = 1.0
    queues: float = 1.0
    detours: int = 3
    cost: ClassVar[str] = "time"
    goes_round: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the parameters."""
        for name in ("history", "queues"):
            if not 0 <= getattr(self, name) < math.inf:
                raise ValueError(f"{name} is {getattr(self, name)}, expected a weight of at least 0")
        if not (isinstance(self.detours, int) and self.detours >= 0):
            raise ValueError(f"detours is {self.detours}, expected a whole number of at least 0")

    def route(self, origin: str, goal: str, roads: Roads) -> Sequence[str]:
        """The nodes from origin to goal, both included; ties go to the node reached first."""
        free = roads.oracle("time")
        edges = roads.graph.adj
        headway = roads.contact / roads.speed + roads.node_time
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
            for there, edge in edges[here].items():
                waiting = self.history * roads.waits[here, there] if self.history else 0.0
                if self.queues:
                    waiting += self.queues * headway * roads.queued((here, there))
                counts = edge.get("counts", 1.0)
                speed = edge["speed"] if roads.limit is None else roads.limit((here, there))
                driving = edge["length"] / min(roads.speed, speed)
                time = least[here] + driving * counts + roads.time_at(there) * counts + waiting
                if roads.closed_for is not None:
                    time += min(roads.closed_for((here, there), least[here]), NEVER)
                if roads.turning is not None and here in before:
                    time += roads.turning(before[here], here, there)
                if time < least.get(there, math.inf):
                    least[there] = time
                    before[there] = here
                    rank += 1
                    heapq.heappush(ahead, (time + free.counted(there, goal), rank, there))
        way = [goal]
        while way[-1] != origin:
            way.append(before[way[-1]])
        return way[::-1]
