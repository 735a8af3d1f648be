"""The course of a run over time: robots by activity, deliveries, open tasks, queues, chargers, batteries.

For the drawing of a run's course on its page and in its replay, and for `plot.day`.

Cumulative sums hide when something happened. So the run is cut into parts of five minutes, counted from the end of the
warm-up in both directions. Each curve gives the mean of each part, so that it integrates to the run's indicator. Waits
in traffic need `log: all`; without it a robot that waits counts as at work.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from desim_warehouse.outcome.halts import Halt, halts, parts_of_robots, parts_of_time
from desim_warehouse.outcome.history import History
from desim_warehouse.states import CHARGER, FOR_PICKER, FOR_SERVER, OFF_DUTY, PICKER, SHOWN, WAITING, Phase
from desim_warehouse.values.arrays import Floats

PART = 300.0
"""Length of a part in runs of usual length, in seconds."""
LEAST, MOST = 24, 600
"""Fewest and most parts of a run: shorter runs have finer parts, longer runs coarser parts."""
_FINER = (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0)
_COARSER = (600.0, 900.0, 1800.0, 3600.0, 7200.0, 14400.0, 43200.0, 86400.0)

DOING = {
    "work": "at work",
    "queue": FOR_SERVER.doing,
    "traffic": WAITING.doing,
    "picker": FOR_PICKER.doing,
    "charging": "charging",
    "empty": "waiting for a charger",
    "broken": "broken down",
    "free": "without a task",
    "off": "off duty",
}
"""Activities of robots, with their labels, in the order in which figures stack them from below."""
_REST: dict[Phase | None, str] = {
    Phase.CHARGING: "charging",
    Phase.BREAKDOWN: "broken",
    Phase.REST: "free",
    Phase.DECISION: "free",
}
_TIMES_MEDIAN = 2.0
"""The peak of open tasks is a pile-up if it exceeds this multiple of their median by more than one task per robot."""


class PileUp(NamedTuple):
    """A stretch of time with far more open tasks than usual: `most` at its peak, against a median of `usual`.

    `doing`: the activity (see `DOING`) whose share of the fleet exceeds its share in the whole run the most. `share`:
    its share in this time.
    """

    start: float
    end: float
    most: float
    usual: float
    doing: str
    share: float


@dataclass(frozen=True)
class Day:
    """The course of a run in n parts of equal length, except the first and the last part, which may be shorter.

    `begin`: the end of the warm-up. `bounds`: the n + 1 ends of the parts, in the time unit of the model. All curves
    have n values, the means of the parts. `robots`: number of robots by activity, in the order of `DOING`, without
    activities that never occur. `delivered`: tasks per hour. `open`: number of open tasks. `queue`: load units waiting
    for workers of stations or, in models without workers, robots queueing at stations. `chargers`: number in use, None
    without chargers. `battery`: mean level as a share of the capacity, None without batteries. `worst`: the longest
    standstill or else the pile-up, None if nothing stands out.
    """

    begin: float
    bounds: Floats
    robots: dict[str, Floats]
    delivered: Floats
    open: Floats
    queue: Floats
    chargers: Floats | None
    battery: Floats | None
    worst: Halt | PileUp | None


def day(history: History) -> Day:
    """Return the course of a run, for any level of the log."""
    bounds, end = _bounds(history), history.end
    lengths, hour = np.diff(bounds), history.model.units.hour
    delivered = [min(task.delivered, end) for task in history.delivered]
    spans = [(task.released, min(task.done, end)) for task in history.tasks.values()]
    robots = _robots(history, bounds)
    still_open = mean_number(spans, bounds)
    return Day(
        begin=history.begin,
        bounds=bounds,
        robots=robots,
        delivered=np.histogram(delivered, bounds)[0] / lengths * hour,
        open=still_open,
        queue=_queue(history, robots, bounds),
        chargers=_chargers(history, bounds),
        battery=_battery(history, bounds),
        worst=_worst(history, bounds, still_open, robots),
    )


def part_length(seconds: float) -> float:
    """Return the length of the parts, in seconds, into which a run of `seconds` is cut."""
    if seconds < LEAST * PART:
        return max((length for length in _FINER if length * LEAST <= seconds), default=seconds / LEAST)
    return next((length for length in (PART, *_COARSER) if length * MOST >= seconds), _COARSER[-1])


def mean_number(spans: Iterable[tuple[float, float]], bounds: Floats) -> Floats:
    """Return the mean number of intervals (`spans`) under way in each part between consecutive bounds."""
    table = np.array(list(spans), dtype=float).reshape(-1, 2)
    begun, over = _so_far(table[:, 0], bounds), _so_far(table[:, 1], bounds)
    return np.maximum(np.diff(begun - over), 0.0) / np.diff(bounds)


def _so_far(starts: Floats, times: Floats) -> Floats:
    """Return the sum of the time since each start, at each time."""
    ordered = np.sort(starts)
    number = np.searchsorted(ordered, times, side="right")
    sums = np.concatenate([[0.0], np.cumsum(ordered)])
    return np.asarray(number * times - sums[number], dtype=float)


def _bounds(history: History) -> Floats:
    seconds = history.model.units.seconds
    step, begin, end = part_length(history.end * seconds) / seconds, history.begin, history.end
    first, last = -math.floor(begin / step), math.ceil((end - begin) / step)
    inner = [begin + n * step for n in range(first, last)]
    least = 1e-9 * max(end, 1.0)
    return np.array([0.0, *(time for time in inner if least < time < end - least), max(end, least)])


def doing(part: str) -> str:
    """Return the activity in `DOING` of a state of a robot, or of waiting in traffic."""
    if part not in SHOWN:
        return "traffic"
    state = SHOWN[part]
    if state.queue is not None:
        return {CHARGER: "empty", PICKER: "picker"}.get(state.queue, "queue")
    return "off" if part in OFF_DUTY else _REST.get(state.phase, "work")


def _robots(history: History, bounds: Floats) -> dict[str, Floats]:
    spans_of: dict[str, list[tuple[float, float]]] = {name: [] for name in DOING}
    for start, end, part in parts_of_time(history):
        spans_of[doing(part)].append((start, end))
    return {name: mean_number(spans, bounds) for name, spans in spans_of.items() if spans}


def shares_of_robots(history: History) -> dict[str, Floats]:
    """Return the share of each activity in the evaluation period, by robot, in the order of `DOING`.

    Shares are nan without an evaluation period. Activities that never occur are omitted. Waits in traffic need
    `log: all`, as in `day`.
    """
    spent = {name: np.zeros(history.model.fleet.size) for name in DOING}
    for number, robot in enumerate(parts_of_robots(history)):
        for start, end, part in robot:
            spent[doing(part)][number] += history.within(start, end)
    return {name: times / (history.counted or math.nan) for name, times in spent.items() if times.any()}


def _queue(history: History, robots: dict[str, Floats], bounds: Floats) -> Floats:
    if not history.workplaces:
        return robots.get("queue", np.zeros(len(bounds) - 1))
    end = history.end
    return mean_number(((min(task.delivered, end), min(task.begun, end)) for task in history.put_down), bounds)


def _chargers(history: History, bounds: Floats) -> Floats | None:
    if not history.batteries or not history.chargers:
        return None
    return mean_number(((charging.start, charging.end) for charging in history.chargings), bounds)


def _battery(history: History, bounds: Floats) -> Floats | None:
    if not history.batteries:
        return None
    levels = [
        _mean_of_line(np.asarray(curve[0]), np.asarray(curve[1]), bounds) / battery.capacity
        for curve, battery in zip(history.energy_curves, history.batteries, strict=True)
    ]
    return np.asarray(np.mean(levels, axis=0), dtype=float)


def _mean_of_line(times: Floats, values: Floats, bounds: Floats) -> Floats:
    """Return the mean of a piecewise linear curve in each part between consecutive bounds."""
    points = np.sort(np.concatenate([times, bounds]))
    heights = np.interp(points, times, values)
    areas = np.concatenate([[0.0], np.cumsum(np.diff(points) * (heights[:-1] + heights[1:]) / 2)])
    return np.asarray(np.diff(areas[np.searchsorted(points, bounds)]) / np.diff(bounds), dtype=float)


def _worst(history: History, bounds: Floats, still_open: Floats, robots: dict[str, Floats]) -> Halt | PileUp | None:
    """Return the longest standstill of deliveries or, without any, the pile-up of open tasks, if there is one."""
    still = halts(history)
    if still:
        return max(still, key=lambda halt: halt.end - halt.start)
    if not history.model.tasks.arrive:
        return None
    counted = np.flatnonzero(bounds[:-1] >= history.begin)
    if not counted.size:
        return None
    usual, top = float(np.median(still_open[counted])), int(counted[np.argmax(still_open[counted])])
    most = float(still_open[top])
    if most <= _TIMES_MEDIAN * usual + history.model.fleet.size:
        return None
    low, high = _around(still_open, top, (usual + most) / 2, int(counted[0]))
    name, share = _more_than_else(robots, bounds, low, high)
    return PileUp(float(bounds[low]), float(bounds[high]), most, usual, name, share)


def _around(values: Floats, top: int, least: float, first: int) -> tuple[int, int]:
    """Return the first part, and the part after the last, of the stretch around `top` with values of at least `least`.

    Parts before `first` are excluded.
    """
    low = high = top
    while low > first and values[low - 1] >= least:
        low -= 1
    while high < len(values) and values[high] >= least:
        high += 1
    return low, high


def _more_than_else(robots: dict[str, Floats], bounds: Floats, low: int, high: int) -> tuple[str, float]:
    """Return the activity whose share in parts `low` to `high` most exceeds its share in the run, and the former."""
    lengths = np.diff(bounds)
    fleet = float(sum(numbers[0] for numbers in robots.values())) or 1.0

    def share(numbers: Floats, which: slice) -> float:
        return float(np.average(numbers[which], weights=lengths[which])) / fleet

    then, whole = slice(low, high), slice(None)
    name = max(robots, key=lambda activity: share(robots[activity], then) - share(robots[activity], whole))
    return name, share(robots[name], then)
