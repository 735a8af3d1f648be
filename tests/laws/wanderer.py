"""A routing policy for the laws: ways with random turns at their beginning, and other ways whenever it is held up."""

from dataclasses import dataclass, field
from random import Random
from typing import ClassVar


@dataclass(frozen=True)
class Wanderer:
    """Up to two random turns, then the way of fewest nodes; offers `detours` on every way."""

    seed: int = 0
    detours: int = 4
    cost: ClassVar[str] = "hops"
    random: Random = field(init=False, default_factory=Random)

    def __post_init__(self):
        self.random.seed(self.seed)

    def route(self, origin, goal, roads):
        way = [origin]
        for _ in range(self.random.choice([0, 0, 1, 1, 2])):
            if way[-1] != goal:
                way.append(self.random.choice(list(roads.graph.successors(way[-1]))))
        return [*way, *list(roads.oracle("hops").way(way[-1], goal))[1:]]
