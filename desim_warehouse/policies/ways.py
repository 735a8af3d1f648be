"""Expected times of ways: the quickest one, and whether to wait before a closed lane or to go round it."""

from __future__ import annotations

import heapq
import itertools
import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from desim_warehouse.policies.protocols import Roads

    Closed = Callable[[tuple[str, str], float], float] | None
    Waiting = Callable[[tuple[str, str]], float] | None

NEVER = 1e12
"""Cost of an edge that does not open again: more than any other, and routes over it can still be compared."""
DETOURS = 3
"""How often a robot may change its route on one drive, so that it does arrive."""
LESS = 1e-9
"""Part by which another way must be quicker: less is rounding."""


def time_at_end(
    roads: Roads, before: str | None, here: str, there: str, begin: float, closed_for: Closed, waiting: float = 0.0
) -> float:
    """When a robot that is at `here` at `begin`, and came from `before`, is at the end of an edge to `there`."""
    edge = roads.graph.adj[here][there]
    counts = edge.get("counts", 1.0)
    speed = edge["speed"] if roads.limit is None else roads.limit((here, there))
    driving = edge["length"] / min(roads.speed, speed)
    time: float = begin + driving * counts + roads.time_at(there) * counts + waiting
    if closed_for is not None:
        time += min(closed_for((here, there), begin), NEVER)
    if roads.turning is not None and before is not None:
        time += roads.turning(before, here, there)
    return time


def time_along(way: Sequence[str], roads: Roads, closed_for: Closed) -> float:
    """How long a robot takes along the nodes of a way if it sets out now."""
    time, before = 0.0, None
    for here, there in itertools.pairwise(way):
        time = time_at_end(roads, before, here, there, time, closed_for)
        before = here
    return time


def quickest(origin: str, goal: str, roads: Roads, closed_for: Closed, waiting: Waiting = None) -> list[str]:
    """The way with the least expected time, `waiting` at each edge included; ties go to the node reached first.

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
        for there in edges[here]:
            spent = 0.0 if waiting is None else waiting((here, there))
            time = time_at_end(roads, before.get(here), here, there, least[here], closed_for, spent)
            if time < least.get(there, math.inf):
                least[there] = time
                before[there] = here
                rank += 1
                heapq.heappush(ahead, (time + free.counted(there, goal), rank, there))
    way = [goal]
    while way[-1] != origin:
        way.append(before[way[-1]])
    return way[::-1]


def past_closures(way: Sequence[str], roads: Roads) -> Sequence[str]:
    """A way, or another where a robot would wait on it for an edge to open, and is there sooner by the other."""
    if roads.shut_for is None or len(way) < 2:  # noqa: PLR2004 - one node is no way
        return way
    free, usual = (time_along(way, roads, closed_for) for closed_for in (None, roads.shut_for))
    if usual <= free:
        return way
    other = quickest(way[0], way[-1], roads, roads.shut_for)
    return other if time_along(other, roads, roads.shut_for) < usual * (1 - LESS) else way
