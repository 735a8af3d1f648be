"""How busy each group is at a design, by its runs: the loads of `model.facts.workers`, as means over runs.

Runs of a study keep indicators alone. These have the whole load of robots and chargers, but the time of servers and of
people only for all stations together, which is shared among stations as the quick estimate shares the work. The
estimate is used for a group with more work than it can do, which no run shows, and where runs that begin empty show
less of a station.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from statistics import fmean

from desim_warehouse.errors import SimulationError
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.feasibility.loads import loads as foreseen
from desim_warehouse.model import Model
from desim_warehouse.model.facts.workers import LANES, Group, Load, groups, in_peak, peak_factor, ranked
from desim_warehouse.outcome.loads import RobotTime, of_robots
from desim_warehouse.run.quick import estimate as quick_estimate
from desim_warehouse.study.design import Point
from desim_warehouse.study.statistics.intervals import Estimate, estimate
from desim_warehouse.study.study import StudyEngine
from desim_warehouse.study.table import Row

TRIP = "cycle_time_mean"
"""What a task takes: little more than the trip of its robot where nothing is scarce."""
_PICKERS_IDLE = "station_idle"
_BEYOND = 1.05
"""The load from which on the estimate, good to five per cent, says that robots and chargers are asked for too much."""


def loads_at(study: StudyEngine, point: Point) -> dict[Load, Estimate]:
    """Measure `loads` in the runs of a design."""
    rows = study.results.by_point[point.number]
    return loads(rows, study.plan.base.replace(point.overrides), study.plan.confidence)


def loads(runs: Sequence[Row], model: Model, confidence: float) -> dict[Load, Estimate]:
    """Measure the load of each group in the runs of a design, the largest first, with the interval of its mean.

    Where robots wait in traffic longer than they work, that is a load of its own, of the lanes.
    """
    rows = [row for row in runs if row.outcome.error is None]
    exact = bool(rows) and all(row.outcome.deterministic for row in rows)
    if not rows:
        return {}
    quick = _quick_estimate(model)
    beyond = {} if quick is None or quick.rate is None else {load.group: load for load in foreseen(model, quick)}
    factor, measured = peak_factor(model), dict[Load, Estimate]()
    times = [of_robots(row.indicators, model) for row in rows]
    for group, values in _values(rows, times, model, quick).items():
        if not values or not all(map(math.isfinite, values)):
            continue
        mean, more = fmean(values), beyond.get(group)
        if more is not None and more.mean > max(mean, 0.0 if group.zone else _BEYOND):
            measured[more] = estimate([more.mean], confidence, deterministic=True)
            continue
        back = fmean(time.back for time in times) if group.kind == "robots" else 0.0
        held = fmean(time.held for time in times) if group.kind == "robots" else 0.0
        load = Load(group, mean, in_peak(group, mean, factor), mean, back, held)
        measured[load] = estimate(values, confidence, deterministic=exact, within=(0.0, 1.0))
    return {load: measured[load] for load in ranked(measured)}


def _values(
    rows: Sequence[Row], times: Sequence[RobotTime], model: Model, quick: QuickEstimate | None
) -> dict[Group, list[float]]:
    """Collect the load of each group in each run."""
    values, parts = {}, {} if quick is None else _parts(model, quick)
    for group in groups(model):
        if group.kind == "robots":
            values[group] = [time.work for time in times]
        elif group.kind == "chargers":
            values[group] = [row.value("charger_utilisation") for row in rows]
        elif group.kind == "lifts":
            values[group] = [row.value("lift_utilisation") * _part_of_lift(quick, group) for row in rows]
        elif group.kind == "people":
            values[group] = [row.value("worker_utilisation") * parts.get(group, math.nan) for row in rows]
        elif group.kind == "pickers" and not group.zone:
            values[group] = [row.value("picker_utilisation") + row.value("picker_walking") for row in rows]
        elif group.kind == "pickers":
            values[group] = [(1 - row.value(_PICKERS_IDLE)) * parts.get(group, math.nan) for row in rows]
        else:
            values[group] = [row.value("server_utilisation") * parts.get(group, math.nan) for row in rows]
    if fmean(time.traffic for time in times) > fmean(time.work for time in times):
        values[LANES] = [time.traffic for time in times]
    return values


def _part_of_lift(quick: QuickEstimate | None, group: Group) -> float:
    """How many times the mean load of the lifts is that of one, by how long a task takes it."""
    taken = {} if quick is None else {item.name: item.share * item.time for item in quick.lifts}
    return taken.get(group.zone, 0.0) / fmean(taken.values()) if taken else math.nan


def _parts(model: Model, quick: QuickEstimate) -> dict[Group, float]:
    """The load of a whole kind as a multiple of one group's load at a station, by the time a task takes there.

    The time of a kind is the hours of all its groups, including groups without work.
    """
    loads_of_stations = {item.node: item for item in quick.stations}
    work, time = dict[Group, float](), dict[Group, float]()
    for group in groups(model):
        if not group.nodes:
            continue
        used = [loads_of_stations[node] for node in group.nodes if node in loads_of_stations]
        each = group.number * group.open / len(group.nodes)
        capacity = [item.work_capacity if group.kind == "people" else item.serve_capacity for item in used]
        work[group] = math.fsum(item.share * each / able for item, able in zip(used, capacity, strict=True))
        time[group] = group.number * group.open
    parts = {}
    for group in work:
        alike = [other for other in work if other.kind == group.kind]
        whole = math.fsum(work[other] for other in alike)
        if whole and time[group]:
            parts[group] = work[group] / whole * math.fsum(time[other] for other in alike) / time[group]
    return parts


@lru_cache(maxsize=64)
def _quick_estimate(model: Model) -> QuickEstimate | None:
    """The quick estimate; None where a robot by itself does no task, so that there is no estimate."""
    try:
        return quick_estimate(model)
    except SimulationError:
        return None
