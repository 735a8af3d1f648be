"""Routing policies: which route a robot takes.

`cost` names the oracle whose routes a policy takes, so that other policies see driving times on its routes. `fixed`
says that routes change for closures alone, so that without those each is computed once a run. `knows_closures` says
that they go round lanes that `traffic.closures` closes where waiting takes longer. `goes_round` says that they go round
people and broken robots, too.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator  # noqa: TC003 - the types of parameters are looked up when a model is read
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from desim_warehouse.policies.ways import DETOURS, past_closures, quickest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.policies.protocols import Roads


@dataclass(frozen=True)
class Highways:
    """Algorithm 1 of the paper: breadth-first, fewest nodes; of several routes the first in the order of successors.

    Past lanes that are closed by `traffic.closures`, where waiting would take longer, leads the quickest other route.
    Source: Liu et al., ROBIO 2017, Algorithm 1.
    """

    cost: ClassVar[str] = "hops"
    fixed: ClassVar[bool] = True
    knows_closures: ClassVar[bool] = True

    def route(self, origin: str, goal: str, roads: Roads) -> Sequence[str]:
        """The nodes from origin to goal, both included."""
        return past_closures(roads.oracle("hops").way(origin, goal), roads)


@dataclass(frozen=True)
class Shortest:
    """The shortest route; of several as short, `spread` of them in turn.

    Past lanes that are closed by `traffic.closures`, where waiting would take longer, leads the quickest other route.
    Grids have many equally short routes, and robots that all take the same one jam it. Whichever is taken, length and
    time are the same. Source: Dijkstra, Numerische Mathematik 1 (1959) 269-271.

    `spread`: how many of the equally short routes between two nodes are used; one where turns take time.
    """

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
        """The nodes from origin to goal, both included."""
        return past_closures(roads.oracle(self.cost).way(origin, goal, _tie(self.turns, self.spread)), roads)


@dataclass(frozen=True)
class Fastest(Shortest):
    """The fastest route without traffic, node times and speed limits included; of several, `spread` of them in turn.

    Waiting is not counted, save before lanes that `traffic.closures` closes, as for `shortest`. Whichever is taken,
    length and time are the same. Source: Dijkstra (1959).

    `spread`: how many of the equally fast routes between two nodes are used; one where turns take time.
    """

    cost: ClassVar[str] = "time"


def _tie(turns: Iterator[int], spread: int) -> int:
    """Which of the equally good routes is taken in this turn; 0: the one that is always taken without `spread`."""
    return 0 if spread == 1 else 1 + next(turns) % spread


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
        """The nodes from origin to goal, both included; ties go to the node reached first."""
        headway = roads.contact / roads.speed + roads.node_time

        def waiting(edge: tuple[str, str]) -> float:
            time = self.history * roads.waits[edge] if self.history else 0.0
            return time + self.queues * headway * roads.queued(edge) if self.queues else time

        return quickest(origin, goal, roads, roads.closed_for, waiting)
