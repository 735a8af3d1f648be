"""Tiles of a replay page: indicators of the run so far, as functions of time.

The last value of a tile is the indicator of the run. Tiles that do not apply to the run are left out.
"""

from __future__ import annotations

import math
from bisect import bisect_right, insort
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from desim_warehouse.model.sections.goods import SaturatedGoods
from desim_warehouse.outcome.history import Curve, History
from desim_warehouse.outcome.indicators import INDICATORS, kpis
from desim_warehouse.outcome.measures import quantile, task_time
from desim_warehouse.replay.scale import MapScale

SHARE = 1_000_000
"""Number of steps in a share of 1."""
LATE = 0.95
"""Quantile of the cycle time that a tile shows."""

_IN_COURSE = {"open", "rate", "battery", "chargers", "tasks", "C"}
"""Forms and keys of tiles whose curves are lanes in the course of the run."""
_STEPS = 500
"""Approximate number of steps of the curve of waiting: more than are visible, and far fewer than waits."""


@dataclass(frozen=True)
class Tile:
    """An indicator of the run so far.

    `key`: name of the indicator. `title`: title of the tile. `form`: how the page computes and formats the value.
    `curve`: times, and the values from these times on. The forms `count`, `share`, `time` and `open` (a count that can
    fall) read this step function. `lost` divides it by the time of all robots; `rate` is the count of another tile per
    hour. `battery` and `chargers` read other columns of the page.
    """

    key: str
    title: str
    form: str
    curve: Curve = ((), ())  # type: ignore[assignment]  # none

    @property
    def is_drawn(self) -> bool:
        """Whether the curve is drawn, as the course of the run has no lane of it."""
        return self.form not in _IN_COURSE and self.key not in _IN_COURSE


def tiles(history: History) -> list[Tile]:
    """Return the tiles of a run, the most important first."""
    has, tasks = kpis(history), history.model.tasks
    ends = not tasks.never_end
    saturated = isinstance(tasks.goods, SaturatedGoods)
    shown = []
    if not saturated:
        shown.append(Tile("backlog", "Open tasks", "open", _backlog(history)))
    shown += [
        Tile("tasks", "Delivered", "count", _count(history, (task.delivered for task in history.delivered))),
        Tile("throughput_per_hour", "Delivered an hour", "rate"),
    ]
    if "on_time" in has:
        shown.append(Tile("on_time", INDICATORS["on_time"].title, "share", _on_time(history)))
    if (tasks.flows or not ends) and history.cycle_times:
        shown.append(Tile("cycle_time_p95", "Cycle time p95", "time", _cycle_time(history)))
    if ends:
        shown.append(
            Tile("S", "Waits for other robots", "count", _count(history, (wait.end for wait in history.collisions)))
        )
    else:
        shown.append(Tile("share_waiting", "Waiting in traffic", "lost", _waited(history)))
    if history.model.battery is not None:
        shown.append(Tile("C", INDICATORS["C"].title, "count", _count(history, history.recharges)))
        shown.append(Tile("battery", "Battery, and the lowest", "battery"))
    if "charger_utilisation" in has:
        shown.append(Tile("charger_utilisation", "Chargers in use", "chargers"))
    return shown


def _count(history: History, times: Iterable[float]) -> Curve:
    """Return the count of events since the warm-up as a step function; events after the end count at the end."""
    counted = sorted(min(time, history.end) for time in times if history.counts(time))
    return counted, list(range(1, len(counted) + 1))


def _backlog(history: History) -> Curve:
    """Return the number of tasks released and not done as a step function."""
    changes = [(task.released, 1) for task in history.tasks.values()]
    changes += [(task.done, -1) for task in history.done]
    changes.sort()
    return [time for time, _ in changes], np.cumsum([by for _, by in changes]).tolist()


def _waited(history: History) -> Curve:
    """Return the cumulative waiting time of all robots in the evaluation period as a step function of ends of waits."""
    waits = sorted((min(wait.end, history.end), history.within(wait.start, wait.end)) for wait in history.collisions)
    sums = np.cumsum([lasted for _, lasted in waits]).tolist()
    every = max(len(waits) // _STEPS, 1)
    kept = range(len(waits) - 1, -1, -every)[::-1]  # the last wait is kept
    return [waits[i][0] for i in kept], [sums[i] for i in kept]


def _on_time(history: History) -> Curve:
    """Return the share of tasks due so far that were done on time; tasks due after the end count at the end."""
    deadlines = history.deadlines
    late = np.cumsum([deadline.missed for deadline in deadlines])
    shares = 1 - late / np.arange(1, len(deadlines) + 1)
    return [min(deadline.due, history.end) for deadline in deadlines], shares.tolist()


def _cycle_time(history: History) -> Curve:
    """Return the 95 % quantile of the cycle times of the tasks done so far."""
    ordered: list[float] = []
    values = []
    for task in history.counted_done:
        insort(ordered, task.cycle_time)
        values.append(quantile(ordered, LATE))
    return [task.done for task in history.counted_done], values


def figures(history: History, shown: list[Tile], scale: MapScale) -> dict[str, float]:
    """Return the indicators that tiles show at the end of the window, by name, without those that have no value."""
    at_end = {tile.key: _value(tile, scale.end) for tile in shown if tile.form in {"count", "share", "lost"}}
    length = min(scale.end, history.end) - history.begin
    hours, fleet = length / history.model.units.hour, length * history.model.fleet.size
    at_end["throughput_per_hour"] = at_end["tasks"] / hours if hours > 0 else math.nan
    if "share_waiting" in at_end:
        at_end["share_waiting"] = at_end["share_waiting"] / fleet if fleet > 0 else math.nan
    if not history.model.tasks.never_end and scale.end >= history.end:
        at_end["T"] = task_time(history)
    times = [task.cycle_time for task in history.counted_done if task.done <= scale.end]
    at_end["cycle_time_mean"] = math.fsum(times) / len(times) if times else math.nan
    return {key: value for key, value in at_end.items() if math.isfinite(value)}


def _value(tile: Tile, time: float) -> float:
    """Return the value of a tile's curve at a time; before the first step, 0 for a count or sum, nan for a share."""
    number = bisect_right(tile.curve[0], time) - 1
    if number < 0:
        return math.nan if tile.form == "share" else 0.0
    return tile.curve[1][number]


def tile_columns(shown: list[Tile], scale: MapScale) -> dict[str, Any]:
    """Return the steps of each tile's curve in the window, beginning with the last step before it."""
    columns: dict[str, Any] = {}
    for tile in shown:
        times, values = np.asarray(tile.curve[0], dtype=float), np.asarray(tile.curve[1], dtype=float)
        low = max(int(np.searchsorted(times, scale.start, side="right")) - 1, 0)
        high = int(np.searchsorted(times, scale.end, side="right"))
        unit = {"share": 1 / SHARE, "time": scale.tick, "lost": scale.tick}.get(tile.form, 1.0)
        columns[f"{tile.key}_time"] = np.diff(scale.times(times[low:high]), prepend=0)
        columns[f"{tile.key}_value"] = np.diff(np.rint(values[low:high] / unit).astype(np.int64), prepend=0)
    return columns
