"""The hours of a model: the stretches in which stations and robots work, and the longest time between two."""

from __future__ import annotations

import math
from statistics import fmean
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from desim_warehouse.model.schema import Model
    from desim_warehouse.values.calendars import Hours

STEPS = 1000
"""Times at which a calendar opens or closes that are looked at, to find whether two of them meet."""


def longest_closed(model: Model) -> float:
    """The longest time in which a station, or the fleet, is outside its hours, as far as the run goes.

    A fleet of which a part f is off for a time g, and that keeps up all the same, falls back by no more than what
    comes in f g meanwhile: so of robots it is the mean.
    """
    if not (model.layout.has_hours or model.fleet.has_hours):
        return 0.0
    stations, robots = [station.hours for station in model.layout.stations.values()], model.fleet.hours_of_robots()
    end = model.run.end
    gap = {name: _longest_gap(model.hours(name), end) for name in {*stations, *robots}}
    return max(fmean(gap[name] for name in robots), *(gap[name] for name in stations), 0.0)


def _longest_gap(hours: Hours, end: float) -> float:
    found, last = 0.0, 0.0
    for begin, close in first_stretches(hours, end):
        found, last = max(found, begin - last), close
    return max(found, min(end, 1e300) - last if last < end < math.inf else 0.0)


def first_stretches(hours: Hours, end: float) -> Iterator[tuple[float, float]]:
    """The first stretches of a calendar before an end, as many as are looked at."""
    at = 0.0
    for _ in range(STEPS):
        begin, close = hours.following(at)
        if not begin < end:
            return
        yield begin, close
        if math.isinf(close):
            return
        at = close
