"""What goods to person is judged by: visits of pods, lines picked at each, idle pickers, and the way for a line."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from desim_warehouse.outcome.history import History


def has_pods(history: History) -> bool:
    return history.model.pods is not None


def pod_visits(history: History) -> int:
    return sum(1 for row in history.rows("stored") if history.counts(row.time))


def pile_on(history: History) -> float:
    visits = pod_visits(history)
    return history.totals["delivered"] / visits if visits else math.nan


def station_idle(history: History) -> float:
    """A server is in use while a line is picked, not while pods are changed."""
    stations, model = history.layout.stations, history.model
    busy = math.fsum(row["busy"] for row in history.log.stations or ())
    time = math.fsum(
        item.servers * model.hours(model.layout.stations[item.zone].hours).share(history.begin, history.end)
        for item in stations.values()
    )
    return 1 - busy / (time * history.counted) if time * history.counted else math.nan


def distance_per_task(history: History) -> float:
    done = history.totals["delivered"]
    return history.totals["distance"] / done if done else math.nan
