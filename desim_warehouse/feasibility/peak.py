"""The quick estimate of the busiest hour, in which all are at work and each station has its own busiest hour.

For the sentences of `desim check` on the busiest hour, and PEAK_ABOVE_FLEET.
"""

from __future__ import annotations

import math
from dataclasses import replace

from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.feasibility.parts import StationLoad
from desim_warehouse.model import Model
from desim_warehouse.model.facts.workers import Group, Kind, peak_factor


def with_busiest_hour(model: Model, mean: QuickEstimate) -> QuickEstimate:
    """Add the estimate of the busiest hour to an estimate; return the latter unchanged where the demand is steady.

    The busiest hour of each station, and of pickers, counts as if it were that of the whole fleet, so that whoever is
    overloaded in an hour of its own is the limit. A task takes a robot as long as on the mean.
    """
    if mean.peak is None or not mean.rate or not mean.on_duty:
        return mean
    times, to_full = mean.peak / mean.rate, mean.unbroken / mean.on_duty

    def share(of_tasks: float, group: Group) -> float:
        return of_tasks * (peak_factor(model, group) or 1.0) / times

    def at_peak(item: StationLoad) -> StationLoad:
        kind: Kind = "people" if item.limited_by_work else "servers"
        part = item.open or 1.0
        return replace(
            item,
            share=share(item.share, Group(kind, nodes=(item.node,))),
            serve_capacity=item.serve_capacity / part,
            work_capacity=item.work_capacity / part,
            serve_busy=None,
            work_busy=None,
            open=1.0,
        )

    pickers = mean.pickers
    if pickers is not None:
        pickers = replace(pickers, share=share(pickers.share, Group("pickers")), open=1.0)
    busy = replace(
        mean,
        rate=mean.peak,
        peak=None,
        on_duty=mean.unbroken,
        fleet_capacity=mean.fleet_capacity * to_full,
        stations=tuple(map(at_peak, mean.stations)),
        pickers=pickers,
        measured=None,
    )
    if mean.measured is not None and mean.throughput_of_queues:
        more = busy.throughput_of_queues / mean.throughput_of_queues
        least, likely, most = (min(value * more, *busy.places_limit.values(), math.inf) for value in mean.measured)
        busy = replace(busy, measured=(least, likely, most))
    return replace(mean, busiest_hour=busy)
