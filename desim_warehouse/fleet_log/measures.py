"""What a day of a fleet was like, in figures that a log of messages has: of real robots and simulated ones alike."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from desim_warehouse.fleet_log.floor import lay_over
from desim_warehouse.fleet_log.handling import episodes
from desim_warehouse.fleet_log.table import CHARGE, DROP, NOTHING, PICK

if TYPE_CHECKING:
    from desim_warehouse.fleet_log.floor import Tracks
    from desim_warehouse.fleet_log.table import FleetLog
    from desim_warehouse.model import Model


class Measure(NamedTuple):
    """A figure of a day: what it is in words, and what to look at where a model has another."""

    meaning: str
    look_at: str


MEASURES = {
    "drops_per_hour": Measure("load units put down an hour", "demand, and whether the fleet keeps up"),
    "trip_mean": Measure("from a pick to the drop, mean", "speed with a load, waits in aisles and at stations"),
    "trip_p95": Measure("from a pick to the drop, 95 % quantile", "queues at stations, breakdowns, blocked aisles"),
    "approach_mean": Measure("from a drop to the next pick, mean", "who is sent where: policies.allocation"),
    "distance_per_hour": Measure("driven by a robot in an hour", "who is sent where, and by which way"),
    "share_empty": Measure("driving empty", "who is sent where: policies.allocation, policies.parking"),
    "share_loaded": Measure("driving with a load", "speed with a load, routes, popularity of places"),
    "share_waiting": Measure("standing on a lane", "a blocked aisle, people, closures, the distance robots keep"),
    "share_at_nodes_of_work": Measure("standing at stations", "servers and unloading time"),
    "share_parked": Measure("standing at bays", "demand, chargers, how many robots were on"),
    "share_loading": Measure("loading", "tasks.load_time"),
    "share_unloading": Measure("unloading", "tasks.unload_time"),
    "share_charging": Measure("charging", "chargers, consumption, the charging policy"),
    "share_broken": Measure("broken down", "fleet.robot.breakdowns"),
    "charges_per_hour": Measure("charges of a robot in an hour", "the charging policy and its levels"),
}
"""By name. Shares are of the time of which the log has messages, so gaps do not count."""


def measured(model: Model, log: FleetLog) -> tuple[dict[str, float], dict[str, float]]:
    """The measures of a day, in the units of the model, and how long robots stood on each edge in an hour.

    nan where the log does not say. The warm-up of the model is left out.
    """
    if not log.step:
        return _of_trips(model, log), {}
    tracks = lay_over(model, [log])
    counted = tracks.time >= model.run.warm_up
    time = np.where(counted, tracks.before, 0.0)
    total = float(time.sum())
    hour = model.units.hour

    def share(which: Any) -> float:
        return float(time[which].sum()) / total if total else math.nan

    names = list(model.floor.graph)
    on_lane = tracks.along > model.fleet.contact  # nearer to the node it may be in a slot beside it
    at_bay = np.isin(tracks.node, [names.index(node) for node in model.floor.bays]) & ~on_lane
    at_station = np.isin(tracks.node, [names.index(node) for node in model.floor.stations]) & ~on_lane
    free = (tracks.action == NOTHING) & ~tracks.fault
    stands = free & ~tracks.driving
    parked, at_work = stands & at_bay & ~tracks.load, stands & at_station & tracks.load
    waits = stands & ~parked & ~at_work
    steps = np.hypot(np.diff(tracks.x, prepend=tracks.x[0]), np.diff(tracks.y, prepend=tracks.y[0]))
    moved = steps[counted & tracks.joined & tracks.driving & np.isfinite(steps)].sum()
    charging = episodes(tracks, tracks.action == CHARGE).begun[:, 0]
    found = _times(tracks, total / hour / max(len(np.unique(tracks.robot)), 1)) | {
        "distance_per_hour": float(moved) / total * hour if total else math.nan,
        "share_empty": share(free & tracks.driving & ~tracks.load),
        "share_loaded": share(free & tracks.driving & tracks.load),
        "share_waiting": share(waits),
        "share_at_nodes_of_work": share(at_work),
        "share_parked": share(parked),
        "share_loading": share(tracks.action == PICK),
        "share_unloading": share(tracks.action == DROP),
        "share_charging": share(tracks.action == CHARGE),
        "share_broken": share(tracks.fault),
        "charges_per_hour": float((charging >= model.run.warm_up).sum()) / total * hour if total else math.nan,
    }
    stood = np.bincount(tracks.edge[waits & (tracks.edge >= 0)], time[waits & (tracks.edge >= 0)], len(tracks.edges))
    return found, {">".join(edge): float(spent) / total * hour for edge, spent in zip(tracks.edges, stood, strict=True)}


def _times(tracks: Tracks, hours: float) -> dict[str, float]:
    """Drops an hour, and the times between picks and drops of the same robot, without those that a gap cuts."""
    picks, drops = (episodes(tracks, tracks.action == action) for action in (PICK, DROP))
    end = drops.ended[:, 0]
    events = [
        *zip(tracks.robot[picks.first], picks.begun.mean(axis=1), [PICK] * len(picks.first), strict=True),
        *zip(tracks.robot[drops.first], end, [DROP] * len(end), strict=True),
    ]
    return _between(events, tracks.model.run.warm_up, hours)


def _between(events: list[tuple[Any, ...]], begin: float, hours: float) -> dict[str, float]:
    trips: list[float] = []
    ways: list[float] = []
    dropped = 0
    before: tuple[Any, ...] = (None, 0.0, NOTHING)
    for robot, time, action in sorted(events):
        dropped += action == DROP and time >= begin
        if robot == before[0] and before[1] >= begin and action != before[2]:
            (trips if action == DROP else ways).append(time - before[1])
        before = robot, time, action
    return {
        "drops_per_hour": dropped / hours if hours else math.nan,
        "trip_mean": float(np.mean(trips)) if trips else math.nan,
        "trip_p95": float(np.quantile(trips, 0.95)) if trips else math.nan,
        "approach_mean": float(np.mean(ways)) if ways else math.nan,
    }


def _of_trips(model: Model, log: FleetLog) -> dict[str, float]:
    table, seconds = log.table, model.units.seconds
    events = list(zip(table["robot"], table["time"] / seconds, table["action"], strict=True))
    begin = model.run.warm_up
    found = _between(events, begin, (log.length / seconds - begin) / model.units.hour)
    return dict.fromkeys(MEASURES, math.nan) | found
