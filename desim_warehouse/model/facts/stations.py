"""What a model says of handling: its mean times by flow and station, hours of stations, and work on what comes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.values.distributions import mean_of

if TYPE_CHECKING:
    from desim_warehouse.layout import Layout
    from desim_warehouse.layout.spec import StationSpec
    from desim_warehouse.model.schema import Model, Tasks
    from desim_warehouse.model.sections.flows import FlowSpec
    from desim_warehouse.values.distributions import Distribution


def specs(model: Model, layout: Layout) -> dict[str, StationSpec]:
    """What the model says of each station, by its node."""
    return {node: model.layout.stations[item.zone] for node, item in layout.stations.items()}


def own_times(model: Model, layout: Layout) -> dict[str, tuple[float | None, float | None]]:
    """Mean times of loading and unloading, by node, of stations that have such of their own; None: as elsewhere."""
    return {
        node: (_mean(spec.load_time), _mean(spec.unload_time))
        for node, spec in specs(model, layout).items()
        if spec.load_time is not None or spec.unload_time is not None
    }


def flow_times(tasks: Tasks, flow: FlowSpec) -> tuple[float, float]:
    """Mean times of loading and unloading a task of a flow, where stations have none of their own."""
    load, unload = _mean(flow.load_time), _mean(flow.unload_time)
    return tasks.mean_load if load is None else load, tasks.mean_unload if unload is None else unload


def _mean(time: float | Distribution | None) -> float | None:
    return None if time is None else mean_of(time)


def open_share(model: Model, spec: StationSpec) -> float:
    """The part of a run in which a station is open."""
    return model.hours(spec.hours).share(0.0, model.run.end)


def worked_capacity(spec: StationSpec) -> float:
    """Load units per time unit that the workers of an open station get done; inf where there is no such work."""
    time = 0.0 if spec.work_time is None else mean_of(spec.work_time)
    return spec.workers / time if time else math.inf
