"""Pods on the replay page: where each stands or who carries it, what it holds, and the lines that it goes for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.values.streams import Streams
from desim_warehouse.world.orders.shelves import Shelves

if TYPE_CHECKING:
    from desim_warehouse.outcome.history import History
    from desim_warehouse.report.replay.scale import MapScale

ENDLESS = -1
"""Units of an item that never runs out."""


def pod_columns(history: History, scale: MapScale) -> dict[str, Any]:
    """Nothing without pods. Where a pod is, is a storage place or, below 0, the robot -1 - n.

    `pod_at`: where each is at the start of the window, `move_...`: when one is lifted or put down, in order of time.
    `hold_...`: for each pod the items on it at the start of the run and their units. `line_...`: the lines that are
    done, with the time from which a robot is on its way for it, in that order; `line_units` leave the pod.
    """
    spec = history.model.pods
    if spec is None:
        return {}
    shelves = Shelves(spec, history.layout.storage, Streams(history.seed), keep=False)
    at = [pod.place for pod in shelves.pods]
    moves = []
    for row in history.rows("lifted", "stored"):
        pod, where = int(row.value or 0), row.other if row.kind == "stored" else -1 - row.robot
        if row.time < scale.start:
            at[pod] = where
        elif row.time <= scale.end:
            moves.append((row.time, pod, where))
    node = {name: number for number, name in enumerate(history.layout.graph)}
    given = {one.task: one.start for one in history.assignments if one.ended == "delivered"}
    lines = sorted((given[row.task], row) for row in history.rows("delivered"))
    item = {row.task: row.other for row in history.rows("released")}
    puts = {name for name, flow in history.model.tasks.flows.items() if not isinstance(flow.target, tuple)}
    units = [-spec.bundle if history.log.flows[row.task] in puts else 1 for _, row in lines]
    begin, done = scale.times([time for time, _ in lines]), scale.times([row.time for _, row in lines])
    held = [(item, units) for pod in shelves.pods for item, units in sorted(pod.stock.items())]
    return {
        "pod_at": at,
        "move_time": np.diff(scale.times([time for time, _, _ in moves]), prepend=0),
        "move_pod": [pod for _, pod, _ in moves],
        "move_to": [where for _, _, where in moves],
        "hold_count": [len(pod.stock) for pod in shelves.pods],
        "hold_item": [item for item, _ in held],
        "hold_units": [ENDLESS if spec.stock is None else int(units) for _, units in held],
        "line_time": np.diff(begin, prepend=0),
        "line_length": done - begin,
        "line_pod": [row.other for _, row in lines],
        "line_task": [row.task for _, row in lines],
        "line_item": [item[row.task] for _, row in lines],
        "line_node": [node[row.node] for _, row in lines],
        "line_units": units,
    }
