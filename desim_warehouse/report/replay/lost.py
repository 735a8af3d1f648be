"""What robots waited for, as the page lists it: the roots of waiting with their sums, and their longest waits."""

from __future__ import annotations

import heapq
from collections import defaultdict
from typing import TYPE_CHECKING, Any

from desim_warehouse.outcome import chains
from desim_warehouse.report.text import numbers
from desim_warehouse.report.text.root_words import root as in_words

if TYPE_CHECKING:
    from desim_warehouse.outcome.chains import Lost, Root
    from desim_warehouse.outcome.history import History
    from desim_warehouse.report.replay.scale import MapScale

_ROOTS = 60
"""Roots in the list."""
_LONGEST = 12
"""Waits that each of them leads to, the longest of the window first."""


def lost_to(history: History, scale: MapScale) -> list[dict[str, Any]]:
    """For each root, most time first: in words, the node, its time and part of all in words, and its longest waits.

    Of a wait: its robot, a moment in the middle of it, and its length, in the time of the run.
    """
    found: defaultdict[Root, list[Lost]] = defaultdict(list)
    for one in chains.lost(history):
        found[one.root].append(one)
    number = {node: i for i, node in enumerate(history.layout.graph.nodes)}
    unit, whole = history.model.units.time, history.counted * history.model.fleet.size
    return [
        {
            "words": in_words(root, history.model),
            "node": number.get(root.at, -1),
            "time": f"{numbers.duration(time, unit)}, {numbers.PERCENT.value(time / whole)}",
            "robots": robots,
            "longest": [
                [one.robot, (one.start + one.end) / 2, one.end - one.start]
                for one in heapq.nlargest(_LONGEST, found[root], key=lambda one: one.end - one.start)
                if scale.start <= (one.start + one.end) / 2 <= scale.end
            ],
        }
        for root, (time, robots) in list(chains.lost_to(history).items())[:_ROOTS]
    ]
