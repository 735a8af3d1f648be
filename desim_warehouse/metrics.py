"""The indicators of a run, from its log: T, S, C and what planners ask for besides."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.log import STATES as DOING

if TYPE_CHECKING:
    from desim_warehouse.log import Log
    from desim_warehouse.model import Model

STATES = (*DOING, "waiting")


def kpis(log: Log, model: Model) -> dict[str, float]:
    """All indicators, in the units of the model file; counted from the end of the warm-up to the end of the run.

    T: time until the last robot is back with all goods delivered (lifelong demand: the length of the run).
    S: collisions, that is waiting episodes, in lanes (`rear_ends`) and before intersections (`crossings`).
    C: chargings after which a robot went out again. `cost`: distance x w_d + counted time x w_t + S x w_c
    (the paper's outlook; without a warm-up the counted time is T). `cycle_time_*`: from a task's release to its
    delivery. `backlog`: tasks not delivered at the end.
    `share_*`: part of the fleet's time in each state, waiting in traffic counted apart; they add up to 1.
    """
    total = {key: math.fsum(robot[key] for robot in log.robots) for key in log.robots[0]}
    counted = log.end - log.begin
    collisions = int(total["rear_ends"] + total["crossings"])
    weights = model.cost
    result: dict[str, float] = {
        "T": log.end,
        "S": collisions,
        "C": int(total["recharged"]),
        "tasks": int(total["delivered"]),
        "moves": int(total["moves"]),
        "distance": total["distance"],
        "energy": total["energy"],
        "waiting": total["waiting"],
        "cost": total["distance"] * weights.distance + counted * weights.time + collisions * weights.collisions,
        "rear_ends": int(total["rear_ends"]),
        "crossings": int(total["crossings"]),
        "rotations": sum(1 for time, _, _ in log.rings if time >= log.begin),
    }
    hours = counted / model.units.hour
    result["throughput_per_hour"] = total["delivered"] / hours if hours else math.nan
    result |= _tasks(log)
    time = counted * len(log.robots)
    result |= {f"share_{state}": total[state] / time if time else math.nan for state in STATES}
    return result


def _tasks(log: Log) -> dict[str, float]:
    """Cycle times of the tasks delivered in the counted part, backlog at the end, tardiness where tasks are due."""
    released: dict[int, float] = {}
    times: list[float] = []
    late: list[float] = []
    open_tasks = 0
    for row in log.rows:
        kind = row[1]
        if kind == "released":
            released[row[3]] = row[0]
            open_tasks += 1
        elif kind == "delivered":
            open_tasks -= 1
            if row[0] >= log.begin:
                times.append(row[0] - released[row[3]])
                due = log.due.get(row[3])
                if due is not None:
                    late.append(max(row[0] - due, 0.0))
    times.sort()
    result = {
        "cycle_time_mean": math.fsum(times) / len(times) if times else math.nan,
        "cycle_time_median": _quantile(times, 0.5),
        "cycle_time_p95": _quantile(times, 0.95),
        "backlog": open_tasks,
    }
    if late:
        result["tardiness_mean"] = math.fsum(late) / len(late)
        result["on_time"] = sum(1 for item in late if not item) / len(late)
    return result


def _quantile(ordered: list[float], part: float) -> float:
    """Linear interpolation between order statistics, as numpy's default (kept here to start up without numpy)."""
    if not ordered:
        return math.nan
    place = part * (len(ordered) - 1)
    low = math.floor(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (place - low) * (ordered[high] - ordered[low])
