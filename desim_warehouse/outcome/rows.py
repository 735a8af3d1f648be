"""Waits in traffic summed over rows or aisles, on floors whose nodes are in rows.

For the figures on a run's page.
"""

from __future__ import annotations

import math
import re
from collections import defaultdict

from desim_warehouse.outcome.history import History

_NAME = re.compile(r"r(\d+)c(\d+)")
"""The name of a node on a floor of rows: its row and its aisle."""


def waits_by_row(history: History) -> dict[str, float]:
    """Return the share of the fleet's time waited in traffic by row, or by aisle if the largest share is an aisle's.

    The largest share comes first. A wait belongs to the node ahead of the robot. Empty on floors without rows. Needs
    `log: all`.
    """
    fleet = history.counted * history.model.fleet.size
    if not fleet or not all(_NAME.fullmatch(node) for node in history.layout.graph):
        return {}
    waits: tuple[defaultdict[str, list[float]], ...] = (defaultdict(list), defaultdict(list))
    for wait in history.waits:
        node = wait.node or (wait.on or wait.edge or ("", ""))[1]
        lasted, place = history.within(wait.start, wait.end), _NAME.fullmatch(node)
        if place is not None and lasted:
            for kind, number, waits_at in zip(("row", "aisle"), place.groups(), waits, strict=True):
                waits_at[f"{kind} {number}"].append(lasted / fleet)
    sums = [{name: math.fsum(parts) for name, parts in waits_at.items()} for waits_at in waits]
    most = max(sums, key=lambda waits_at: max(waits_at.values(), default=0.0))
    return dict(sorted(most.items(), key=lambda item: -item[1]))
