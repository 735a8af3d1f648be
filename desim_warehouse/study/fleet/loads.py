"""Utilisation of each group at a design (the loads of `model.facts.workers`), as means over its runs.

Runs of a study keep only indicators. These give the whole load of robots and chargers, but the time of servers and
people only as a total over stations, and of robots as a total over subfleets, which are divided in the proportions of
the quick estimate. The estimate itself is used for a group with more work than it can do, since no run shows a load
above one, and for a station of which runs that begin empty show less.
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
from desim_warehouse.model.facts.workers import LANES, Group, Load, groups, in_peak, of_slots, ranked
from desim_warehouse.outcome.loads import RobotTime, of_robots
from desim_warehouse.run.quick import estimate as quick_estimate
from desim_warehouse.study.design import Point
from desim_warehouse.study.statistics.intervals import Estimate, estimate
from desim_warehouse.study.study import StudyEngine
from desim_warehouse.study.table import Row

TRIP = "cycle_time_mean"
"""The indicator of the time of a task, which is little more than its robot's trip where nothing is scarce."""
_PICKERS_IDLE = "station_idle"
_BEYOND = 1.05
"""The load above which robots and chargers have too much work by the estimate, which is accurate to five per cent."""


def loads_at(study: StudyEngine, point: Point) -> dict[Load, Estimate]:
    """Measure `loads` in the runs of a design."""
    rows = study.results.by_point[point.number]
    return loads(rows, study.plan.base.replace(point.overrides), study.plan.confidence)


def loads(runs: Sequence[Row], model: Model, confidence: float) -> dict[Load, Estimate]:
    """Measure the load of each group in the runs of a design, the largest first, with the interval of its mean.

    If robots wait in traffic longer than they work, the lanes have a load as well.
    """
    rows = [row for row in runs if row.outcome.error is None]
    exact = bool(rows) and all(row.outcome.deterministic for row in rows)
    if not rows:
        return {}
    quick = _quick_estimate(model)
    beyond = {} if quick is None or quick.rate is None else {load.group: load for load in foreseen(model, quick)}
    measured = dict[Load, Estimate]()
    times = [of_robots(row.indicators, model) for row in rows]
    for group, values in _values(rows, times, model, quick).items():
        if not values or not all(map(math.isfinite, values)):
            continue
        mean, more = fmean(values), beyond.get(group)
        if more is not None and more.mean > max(mean, 0.0 if group.zone else _BEYOND):
            measured[more] = estimate([more.mean], confidence, deterministic=True)
            continue
        all_robots = group.kind == "robots" and group.subfleet is None
        back = fmean(time.back for time in times) if all_robots else 0.0
        held = fmean(time.held for time in times) if all_robots else 0.0
        load = Load(group, mean, in_peak(model, group, mean, model.run.warm_up), mean, back, held)
        measured[load] = estimate(values, confidence, deterministic=exact, within=(0.0, 1.0))
    in_hand = [time.tasks * model.fleet.size for time in times]
    full = of_slots(model, fmean(in_hand), model.run.warm_up)
    if full is not None:
        more = next((load for load in beyond.values() if load.group == full.group and load.mean > full.mean), full)
        measured[more] = estimate([more.mean], confidence, deterministic=True)
    return {load: measured[load] for load in ranked(measured)}


def _values(
    rows: Sequence[Row], times: Sequence[RobotTime], model: Model, quick: QuickEstimate | None
) -> dict[Group, list[float]]:
    """Collect the load of each group in each run."""
    values, parts = {}, {} if quick is None else _parts(model, quick)
    for group in groups(model):
        if group.kind == "robots":
            part = 1.0 if group.subfleet is None else _part_of_subfleet(model, quick, group)
            values[group] = [time.work * part for time in times]
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


def _part_of_subfleet(model: Model, quick: QuickEstimate | None, group: Group) -> float:
    """Return the load of the robots of a subfleet as a multiple of the load of all robots, by the quick estimate."""
    busy = {} if quick is None else {load.group: load.mean for load in foreseen(model, quick) if load.group.subfleet}
    whole = math.fsum(mean * subfleet.number for subfleet, mean in busy.items()) / model.fleet.size
    return busy.get(group, 0.0) / whole if whole else math.nan


def _part_of_lift(quick: QuickEstimate | None, group: Group) -> float:
    """Return the load of one lift as a multiple of the mean over lifts, by the time that a task takes of each."""
    taken = {} if quick is None else {item.name: item.share * item.time for item in quick.lifts}
    return taken.get(group.zone, 0.0) / fmean(taken.values()) if taken else math.nan


def _parts(model: Model, quick: QuickEstimate) -> dict[Group, float]:
    """Return each group's load at its station as a multiple of the load of its kind, by the time of a task there.

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
    """Return the quick estimate; None if a robot by itself completes no task, so that there is no estimate."""
    try:
        return quick_estimate(model)
    except SimulationError:
        return None
