"""Measures of a day of a fleet that a log of messages has, for real robots and simulated ones alike."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from desim_warehouse.fleet_log.floor import Tracks, lay_over
from desim_warehouse.fleet_log.handling import episodes
from desim_warehouse.fleet_log.table import CHARGE, DROP, NOTHING, PICK, FleetLog
from desim_warehouse.model import Model
from desim_warehouse.values.arrays import Floats

Event: TypeAlias = "tuple[Any, float, int]"

_PARTS = (1.0, 0.5, 0.25, 1 / 6, 1 / 12)
_FEW = 4
"""Parts that a day should have, in hours: the longest of which there are so many, else the shortest."""


class Measure(NamedTuple):
    """A measure of a day: its meaning in words, the part of a model to check where it differs, and its kind.

    `kind` is a kind of unit: time, length, share or count.
    """

    meaning: str
    look_at: str
    kind: str = "count"


MEASURES = {
    "drops_per_hour": Measure("drops per hour", "demand, and whether the fleet keeps up"),
    "trip_mean": Measure("mean time from pick to drop", "speed with a load, waits in aisles and at stations", "time"),
    "trip_p95": Measure(
        "95 % quantile of the time from pick to drop", "queues at stations, breakdowns, blocked aisles", "time"
    ),
    "approach_mean": Measure("mean time from drop to next pick", "dispatching: who is sent where", "time"),
    "distance_per_hour": Measure("distance per robot-hour", "who is sent where, and by which way", "length"),
    "share_empty": Measure("time driving empty", "dispatching, and where robots park", "share"),
    "share_loaded": Measure("time driving with a load", "speed with a load, routes, popularity of places", "share"),
    "share_waiting": Measure(
        "time standing on lanes", "a blocked aisle, people, closures, the distance robots keep", "share"
    ),
    "share_at_nodes_of_work": Measure("time standing at stations", "packers and unloading time", "share"),
    "share_parked": Measure("time standing at bays", "demand, chargers, how many robots were on", "share"),
    "share_loading": Measure("time loading", "the load time of the model", "share"),
    "share_unloading": Measure("time unloading", "the unload time of the model", "share"),
    "share_charging": Measure("time charging", "chargers, consumption, the charging policy", "share"),
    "share_broken": Measure("time broken down", "breakdowns", "share"),
    "charges_per_hour": Measure("charges per robot-hour", "the charging policy and its levels"),
}
"""By name. Shares are of the time of which the log has messages, so gaps do not count."""


class MeasuredDay(NamedTuple):
    """Measures of a day from a log, in the units of the model.

    `figures` are those of `MEASURES`, nan where the log does not say. `drops` are load units put down an hour, in each
    part of the day, nan in those without messages. Of each edge `passed` is how often robots came along it in an hour,
    and `stood` how long robots stood on it in an hour; both are empty for trips.
    """

    figures: dict[str, float]
    drops: Floats
    passed: Floats
    stood: Floats


def parts_of(model: Model, log: FleetLog) -> Floats:
    """Return the instants that divide the evaluation period of a day into hours, a short day into parts of an hour."""
    begin, hour = model.run.warm_up, model.units.hour
    end = max(log.length / model.units.seconds, begin + 1.0)
    part = next((part for part in _PARTS if (end - begin) / (part * hour) >= _FEW), _PARTS[-1]) * hour
    return np.append(np.arange(begin, max(end - part / 2, begin + 0.5), part), end)


def measured(model: Model, log: FleetLog, parts: Floats) -> MeasuredDay:
    """Measure a day of a log without the model's warm-up; `parts`: the instants between which drops are counted."""
    if not log.step:
        return _of_trips(model, log, parts)
    tracks = lay_over(model, [log])
    counted = tracks.time >= model.run.warm_up
    time = np.where(counted, tracks.before, 0.0)
    total = float(time.sum())
    hour = model.units.hour
    robots = max(len(np.unique(tracks.robot)), 1)

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
    events = _events(tracks)
    figures = _between(events, model.run.warm_up, total / hour / robots) | {
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
    seen = np.histogram(tracks.time, parts, weights=time)[0] / hour / robots
    hours = total / hour / robots or math.nan
    on_edge = waits & (tracks.edge >= 0)
    stood = np.bincount(tracks.edge[on_edge], time[on_edge], len(tracks.edges))
    return MeasuredDay(figures, _an_hour(events, parts, seen), _passed(tracks, counted) / hours, stood / hours)


def _passed(tracks: Tracks, counted: Any) -> Floats:
    """Count how often robots came along each edge."""
    came = (counted & tracks.joined & (np.diff(tracks.node, prepend=-1) != 0))[1:]
    pairs, often = np.unique(np.stack([tracks.node[:-1][came], tracks.node[1:][came]]), axis=1, return_counts=True)
    names, number = list(tracks.model.floor.graph), {edge: rank for rank, edge in enumerate(tracks.edges)}
    passed = np.zeros(len(tracks.edges))
    for (a, b), times in zip(pairs.T, often, strict=True):
        edge = number.get((names[a], names[b])) if min(a, b) >= 0 else None
        if edge is not None:
            passed[edge] = times
    return passed


def _an_hour(events: list[Event], parts: Floats, hours: Floats) -> Floats:
    """Return the drops an hour in each part of a day, by the hours that were observed; nan where there are none."""
    dropped, _ = np.histogram([time for _, time, action in events if action == DROP], parts)
    return np.asarray(np.where(hours > 0, dropped / np.where(hours > 0, hours, 1.0), math.nan))


def _events(tracks: Tracks) -> list[Event]:
    """Return picks and drops as (robot, time, action), sorted."""
    picks, drops = (episodes(tracks, tracks.action == action) for action in (PICK, DROP))
    return sorted(
        [
            *zip(tracks.robot[picks.first], picks.begun.mean(axis=1), [PICK] * len(picks.first), strict=True),
            *zip(tracks.robot[drops.first], drops.ended[:, 0], [DROP] * len(drops.first), strict=True),
        ]
    )


def _between(events: list[Event], begin: float, hours: float) -> dict[str, float]:
    """Return drops an hour, and times between successive picks and drops of one robot."""
    trips: list[float] = []
    ways: list[float] = []
    dropped = 0
    before: tuple[Any, ...] = (None, 0.0, NOTHING)
    for robot, time, action in events:
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


def _of_trips(model: Model, log: FleetLog, parts: Floats) -> MeasuredDay:
    table, seconds = log.table, model.units.seconds
    events = sorted(zip(table["robot"], table["time"] / seconds, table["action"], strict=True))
    begin, hour = model.run.warm_up, model.units.hour
    figures = _between(events, begin, (log.length / seconds - begin) / hour)
    drops = _an_hour(events, parts, np.diff(parts) / hour)
    return MeasuredDay(dict.fromkeys(MEASURES, math.nan) | figures, drops, np.empty(0), np.empty(0))
