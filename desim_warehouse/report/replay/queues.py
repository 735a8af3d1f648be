"""Queues in a replay: of robots in stations and bays, and in traffic; how long when, and where they are worst."""

from __future__ import annotations

from bisect import bisect_right
from collections import defaultdict
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.outcome.resources import steps

if TYPE_CHECKING:
    from desim_warehouse.outcome.history import History
    from desim_warehouse.outcome.resources import Resource, Steps
    from desim_warehouse.report.positions import Edges
    from desim_warehouse.report.replay.scale import MapScale

MOST = 12
"""Queues that can be jumped to."""


def resource_columns(found: list[Resource], scale: MapScale) -> dict[str, Any]:
    """For each resource, how many are busy and how many robots queue, from the start of the run on."""
    columns: dict[str, Any] = {}
    for what, curves in (("busy", [one.busy for one in found]), ("queue", [one.queue for one in found])):
        kept = [[(time, count) for time, count in zip(*curve, strict=True) if time <= scale.end] for curve in curves]
        flat = [item for curve in kept for item in curve]
        columns[f"{what}_count"] = [len(curve) for curve in kept]
        columns[f"{what}_time"] = np.diff(scale.times([time for time, _ in flat]), prepend=0)
        columns[f"{what}_now"] = np.diff(np.array([count for _, count in flat], dtype=np.int64), prepend=0)
    return columns


def worst(history: History, edges: Edges, found: list[Resource], scale: MapScale) -> list[dict[str, Any]]:
    """The longest queue of each place in the window, the longest place first.

    `what`: `station`, `chargers` or `lane`; `number`: of the resource, or of the lane's first edge; `robots`: how many
    queue there in the middle of the longest time with that many, which is `time`.
    """
    queues: list[tuple[str, int, Steps]] = [(one.kind, i, one.queue) for i, one in enumerate(found)]
    queues += [("lane", edge, queue) for edge, queue in _lanes(history, edges).items()]
    longest = []
    for what, number, queue in queues:
        robots, time, lasts = _longest(queue, scale)
        if robots:
            longest.append((robots, lasts, {"what": what, "number": number, "robots": robots, "time": time}))
    longest.sort(key=lambda item: (-item[0], -item[1]))
    return [item for _, _, item in longest[:MOST]]


def _lanes(history: History, edges: Edges) -> dict[int, Steps]:
    """For each lane, by the number of its first edge, how many robots that are on it wait in traffic."""
    number = {edge: i for i, edge in enumerate(history.layout.graph.edges)}
    changes: defaultdict[int, list[tuple[float, int]]] = defaultdict(list)
    for wait in history.waits:
        if wait.on is None:
            continue
        edge = number[wait.on]
        back = int(edges.twin[edge])
        changes[edge if back < 0 else min(edge, back)] += [(wait.start, 1), (wait.end, -1)]
    return {lane: steps(found) for lane, found in changes.items()}


def _longest(queue: Steps, scale: MapScale) -> tuple[int, float, float]:
    """The most robots in the window, the middle of the longest time with that many, and how long it is."""
    times, counts = queue
    low = max(bisect_right(times, scale.start) - 1, 0)
    best = (0, 0.0, 0.0)
    for i in range(low, len(times)):
        begin, end = max(times[i], scale.start), min(times[i + 1] if i + 1 < len(times) else scale.end, scale.end)
        if begin >= end:
            continue
        if (counts[i], end - begin) > (best[0], best[2]):
            best = (counts[i], (begin + end) / 2, end - begin)
    return best
