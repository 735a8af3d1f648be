"""Which part of their time robots, chargers and servers of stations are busy at a design."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from desim_warehouse.model import Model
from desim_warehouse.model.facts.places import destinations
from desim_warehouse.model.sections.flows import StorageEnd
from desim_warehouse.outcome.resources import busy_share, on_duty, standing
from desim_warehouse.states import WAITING
from desim_warehouse.study.design import Point
from desim_warehouse.study.statistics.intervals import Estimate, estimate
from desim_warehouse.study.study import StudyEngine
from desim_warehouse.study.table import Row

SCARCE = 0.7
"""Part of their time from which on robots, chargers or servers are scarce."""
TRIP = "cycle_time_mean"
"""What a task takes: little more than the trip of its robot where nothing is scarce."""


def indicators_of(model: Model) -> dict[str, tuple[str, ...]]:
    """The indicators from which the utilisation follows: robots are busy but for the shares in which they stand."""
    return {
        "robots": standing(model),
        "traffic": (f"share_{WAITING.name}",),
        "chargers": ("charger_utilisation",),
        "stations": ("share_unloading",),
    }


def utilisation(study: StudyEngine, point: Point) -> dict[str, Estimate]:
    """`busy_shares` in the runs of a design."""
    rows = study.results.by_point[point.number]
    return busy_shares(rows, study.plan.base.replace(point.overrides), study.plan.confidence)


def busy_shares(runs: Sequence[Row], model: Model, confidence: float) -> dict[str, Estimate]:
    """The part of their time that robots, chargers and the servers of stations are busy, what holds most up first.

    A robot that waits, for work, in a queue, in traffic or for a repair, is not busy: others hold it up. Where robots
    wait in traffic longer than they are busy, that is a part of its own, `traffic`, and as robots have no other time
    left, the two together say how scarce they are. Time outside their hours is not the time of robots and stations.
    Nothing is said of servers where robots unload elsewhere, too, or load in stations.
    """
    rows = [row for row in runs if row.outcome.error is None]
    counted = model.run.warm_up, model.run.end
    layout = model.floor
    used = [layout.stations[node] for node in destinations(model, layout) if node in layout.stations]
    hours = {name: model.hours(station.hours) for name, station in model.layout.stations.items()}
    servers = math.fsum(station.servers * hours[station.zone].share(*counted) for station in used)
    each = model.fleet.size / servers if servers else 0.0
    stand = indicators_of(model)["robots"]
    values = {
        "robots": [busy_share([row.value(name) for name in stand], _off_duty(row, model)) for row in rows],
        "traffic": [on_duty(row.value(f"share_{WAITING.name}"), _off_duty(row, model)) for row in rows],
        "chargers": [row.value("charger_utilisation") for row in rows],
        "stations": [row.value("share_unloading") * each for row in rows] if servers and _unloads_only(model) else [],
    }
    exact = bool(rows) and all(row.outcome.deterministic for row in rows)
    found = {
        name: estimate(given, confidence, deterministic=exact, within=(0.0, 1.0))
        for name, given in values.items()
        if given and all(map(math.isfinite, given))
    }
    rank = {name: one.mean for name, one in found.items()}
    if found.keys() >= {"robots", "traffic"}:
        if found["traffic"].mean > found["robots"].mean:
            rank["traffic"] += rank["robots"]
        else:
            del found["traffic"]
    return dict(sorted(found.items(), key=lambda item: -rank[item[0]]))


def nothing_scarce(busy: Mapping[str, Estimate]) -> bool:
    """Whether robots, chargers and servers all have time to spare, and robots do not stand in traffic instead."""
    return "traffic" not in busy and all(share.mean < SCARCE for share in busy.values())


def _unloads_only(model: Model) -> bool:
    """Whether all that stations do is to have loads from storage put down, and robots put down loads nowhere else."""
    flows = model.tasks.flows.values()
    routes = [route for flow in flows for route in flow.routes]
    stored = [(isinstance(route.source, StorageEnd), isinstance(route.target, StorageEnd)) for route in routes]
    return not any(flow.via for flow in flows) and all(ends == (True, False) for ends in stored)


def _off_duty(row: Row, model: Model) -> float:
    return row.value("share_on_break") if model.fleet.has_hours else 0.0
