"""A routing policy for the laws: routes with random turns at the start, and detours whenever a robot is held up."""

from dataclasses import dataclass, field
from random import Random
from typing import ClassVar


@dataclass(frozen=True)
class Wanderer:
    """Up to two random turns, then the route with the fewest nodes; offers `detours` on every route."""

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
                outside = [node for node in roads.graph[way[-1]] if is_outside(roads.graph, node)]
                way += self.random.choices(outside, k=1) if outside else []
        return [*way, *list(roads.oracle("hops").way(way[-1], goal))[1:]]


def is_outside(graph, node):
    """Whether a node is not in a lift, where a turn would lead through the cabin on one floor."""
    return all(graph.edges[edge]["length"] for edge in graph.out_edges(node))
