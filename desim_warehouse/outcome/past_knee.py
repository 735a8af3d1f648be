"""Whether one run shows that fewer robots under way would do more: its own hours with fewer, beside those with more.

A floor has a most that it lets through, with some number of robots under way, and lets less through with more of them:
the macroscopic fundamental diagram of road networks (Geroliminis and Daganzo, Transportation Research B 42 (2008)
759-770). A run draws a part of that curve only where the number under way changes, and long enough that jams have time
to form or to dissolve. So the counted time is cut into windows in which a robot does two tasks on average. Windows
with many robots under way are compared with those with fewer. Where the number hardly changes, as with work always
waiting, one run cannot say it, and `desim size --key traffic.most_out` tries it out.
"""

from __future__ import annotations

import math
from collections import defaultdict
from itertools import accumulate
from statistics import fmean, variance
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from desim_warehouse.outcome.history import History

LEAST_WAITING = 0.2
"""Part of the fleet's time in traffic below which nothing is past a knee."""
TASKS_A_WINDOW = 2
"""Tasks that a robot under way does in a window, on average."""
LEAST_WINDOWS = 6
"""Windows with many robots, and with fewer, that are needed."""
STANDARD_ERRORS = 4
"""By which more must be done with fewer robots, of the difference of the two means, beside `LEAST_GAIN`."""
LEAST_GAIN = 0.05
BANDS = 10
"""Windows are put together whose number of robots under way is the same to a tenth of the most."""
FEWER = 8
"""Bands up to this one are held against the highest one."""


class PastKnee(NamedTuple):
    """With `cap` robots under way, on average, more was done an hour than with `many`, by the part `gain`."""

    cap: int
    many: int
    gain: float


class Window(NamedTuple):
    """Robots under way on average, and goods loaded and delivered (a half of a task each) for each time unit."""

    under_way: float
    done: float


def past_knee(history: History) -> PastKnee | None:
    """What the counted part of a run shows, or None."""
    fleet = history.counted * len(history.log.robots)
    if not fleet or history.totals["waiting"] < LEAST_WAITING * fleet:
        return None
    found = windows(history)
    most = max((window.under_way for window in found), default=0.0)
    bands: defaultdict[int, list[Window]] = defaultdict(list)
    for window in found:
        bands[math.ceil(window.under_way / most * BANDS - 1e-9)].append(window)
    high = bands[BANDS]
    fewer = [band for number, band in bands.items() if number <= FEWER and len(band) >= LEAST_WINDOWS]
    if len(high) < LEAST_WINDOWS or not fewer:
        return None
    best = max(fewer, key=_done)
    error = math.sqrt(sum(variance(window.done for window in band) / len(band) for band in (best, high)))
    gain = _done(best) - _done(high)
    if gain <= STANDARD_ERRORS * error or gain < LEAST_GAIN * _done(high):
        return None
    cap, many = (round(fmean(one.under_way for one in band)) for band in (best, high))
    return PastKnee(cap, many, gain / _done(high))


def _done(band: list[Window]) -> float:
    return fmean(window.done for window in band)


def windows(history: History) -> list[Window]:
    """The counted time in windows of equal length, about as long as a robot takes for `TASKS_A_WINDOW` tasks."""
    changes: defaultdict[float, int] = defaultdict(int)
    for spans in history.changes:
        for span in spans:
            if span.end > span.start and not span.seen.is_parked:
                changes[max(span.start, history.begin)] += 1
                changes[max(span.end, history.begin)] -= 1
    goods = [time for task in history.tasks.values() for time in (task.loaded, task.delivered) if history.counts(time)]
    goods = sorted(time for time in goods if time <= history.end)
    times = sorted(changes)
    numbers = list(accumulate(changes[time] for time in times))
    total = math.fsum(n * (end - start) for n, start, end in zip(numbers, times, times[1:], strict=False))
    if not goods or not total:
        return []
    count = int(history.counted * len(goods) / 2 / total / TASKS_A_WINDOW)
    if not count:
        return []
    length = history.counted / count
    out, done = [0.0] * count, [0] * count
    for number, start, end in zip(numbers, times, times[1:], strict=False):
        for rank in range(int((start - history.begin) / length), count):
            left, right = history.begin + rank * length, history.begin + (rank + 1) * length
            if left >= end:
                break
            out[rank] += number * max(min(end, right) - max(start, left), 0.0)
    for time in goods:
        done[min(int((time - history.begin) / length), count - 1)] += 1
    return [Window(area / length, n / length) for area, n in zip(out, done, strict=True)]
