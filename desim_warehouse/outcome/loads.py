"""Utilisation of each group in a run: the loads of `model.facts.workers`, measured.

For the sentence on the busiest group in the answer of a run and of `desim why`, and for plans.

The demand for a group that is always busy may exceed its capacity. If more work is left in the end than chance
explains, loads refer to all work that arrived (`Load.piles_up`), and may exceed 1.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from desim_warehouse.model import Model
from desim_warehouse.model.facts.hours import longest_closed
from desim_warehouse.model.facts.subfleets import Subfleet
from desim_warehouse.model.facts.workers import LANES, Load, at_nodes, groups, in_peak, of_slots
from desim_warehouse.outcome import measures
from desim_warehouse.outcome.halts import lacked_stock
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.records import TaskHistory
from desim_warehouse.outcome.resources import use_of_stations
from desim_warehouse.states import AT_START, BROKEN, IN_LIFT, OFF_DUTY, TIMES, Phase

_WORK = (Phase.TO_GOOD, Phase.LOADING, Phase.TO_STATION, Phase.UNLOADING, Phase.CHARGING)
"""Phases that a task takes of a robot, without the drive back to parking, when the robot is free for another task.

Rides in lifts are work, too; those on the way back are not told apart.
"""


class RobotTime(NamedTuple):
    """Shares of work, drives back to parking, and waits in the time in which robots are on duty and not broken.

    `held`: all waits. `traffic`: the waits in traffic among them. `tasks`: work and waits without charging.
    """

    work: float
    back: float
    held: float
    traffic: float
    tasks: float


def of_robots(kpis: Mapping[str, float], model: Model) -> RobotTime:
    """Return the shares of the time of robots from the indicators of a run; nan without such time."""

    def share(names: Iterable[str]) -> float:
        return math.fsum(kpis.get(f"share_{name}", 0.0) for name in names)

    def phases(*wanted: Phase) -> list[str]:
        return [name for name, state in TIMES.items() if state.phase in wanted and state.applies(model)]

    whole = 1 - share(OFF_DUTY) - share(BROKEN)
    if whole <= measures.ROUNDING or not math.isfinite(kpis.get(f"share_{AT_START}", math.nan)):
        return RobotTime(*[math.nan] * 5)
    back, work = share(phases(Phase.TO_BAY)), share([*phases(*_WORK), IN_LIFT])
    traffic = kpis.get("share_waiting", 0.0)
    held = max(whole - share([AT_START]) - back - work, 0.0)
    tasks = work - share(phases(Phase.CHARGING)) + held
    return RobotTime(work / whole, back / whole, held / whole, traffic / whole, tasks / whole)


def loads(history: History, kpis: Mapping[str, float]) -> tuple[Load, ...]:
    """Measure the load of each group in the evaluation period of a run, from its history and its indicators.

    Lanes are included if robots wait in traffic longer than they work. Empty without an evaluation period.
    """
    model, measured = history.model, list[Load | None]()
    since, (carried, worked) = model.run.warm_up, _asked_for(history)
    left = {"people": carried * worked, "chargers": 1.0, "lanes": 1.0}
    taken = measures.lifts_taken(history)
    time, at_servers, at_work = of_robots(kpis, model), use_of_stations(history), _use_of_people(history)
    if time.traffic > time.work:
        measured.append(Load(LANES, time.traffic))
    measured.append(of_slots(model, time.tasks * model.fleet.size * carried, since))
    for group in groups(model):
        if group.kind == "robots":
            own, times = (time, carried) if group.subfleet is None else _of_subfleet(history, group.subfleet)
            left[group.name], mean = times, own.work * times
            measured.append(Load(group, mean, in_peak(model, group, mean, since), mean, own.back, own.held))
        elif group.kind == "pickers" and not group.zone:
            mean = (kpis.get("picker_utilisation", math.nan) + kpis.get("picker_walking", math.nan)) * carried
            measured.append(Load(group, mean, in_peak(model, group, mean, since), mean))
        elif group.kind == "lifts":
            mean = taken[group.zone] * carried
            measured.append(Load(group, mean, in_peak(model, group, mean, since), mean))
        elif group.kind == "chargers":
            used = kpis.get("charger_utilisation", math.nan)
            measured.append(Load(group, used, None, used))
        else:
            shares, times = (at_work, left["people"]) if group.kind == "people" else (at_servers, carried)
            asked = {node: shares[node] * times for node in group.nodes if node in shares}
            measured.append(at_nodes(model, group, asked, since))
    return tuple(
        replace(load, piles_up=left.get(load.group.name, left.get(load.group.kind, carried)) > 1)
        for load in measured
        if load is not None and math.isfinite(load.mean)
    )


def _of_subfleet(history: History, subfleet: Subfleet) -> tuple[RobotTime, float]:
    """Return the shares of the time of a subfleet, and the ratio of its tasks that arrived to those delivered."""
    rows, whole = [history.log.robots[robot] for robot in subfleet.robots], history.counted * len(subfleet.robots)
    shares = {f"share_{key}": math.fsum(row[key] for row in rows) / whole for key in rows[0]} if whole else {}
    return of_robots(shares, history.model), _asked_for(history, subfleet.flows)[0]


def left_waiting(history: History) -> tuple[int, float]:
    """Return by how many the open tasks without a robot grow in the evaluation period, and the growth due to chance.

    The latter is the square root of the number of arrivals, the standard deviation of a Poisson count.
    """
    came = _came(history)
    return came - len(history.counted_done) - _in_hand(history), math.sqrt(came)


def _came(history: History, flows: Sequence[str] | None = None) -> int:
    return sum(history.counts(task.released) for task in history.tasks.values() if _is_of(task, flows))


def _is_of(task: TaskHistory, flows: Sequence[str] | None) -> bool:
    """Whether a task is of one of some flows; None: of any."""
    return flows is None or task.flow in flows


def _in_hand(history: History, flows: Sequence[str] | None = None) -> int:
    """Return by how much the number of tasks assigned to robots grew in the evaluation period."""
    assignments = [item for item in history.assignments if _is_of(history.tasks[item.task], flows)]
    begin, end = (
        sum(1 for task in assignments if task.start <= time < task.end or (time == task.end and task.ended == "open"))
        for time in (history.begin, history.end)
    )
    return end - begin


def _asked_for(history: History, flows: Sequence[str] | None = None) -> tuple[float, float]:
    """Return the ratio of arrived to delivered tasks, and of load units put down to load units worked on.

    Each is 1 if the backlog is no larger than chance and arrivals outside the hours of stations or robots explain, and
    if the run stood still because pods were empty.
    `flows`: those whose tasks are counted as arrived and delivered; None: all.
    """
    model, hours = history.model, history.counted
    if not model.tasks.arrive or not hours:
        return 1.0, 1.0
    closed = min(longest_closed(model) / hours, 1.0)

    def times(came: int, left: int, at_once: int) -> float:
        by_chance = 2 * math.sqrt(came) + came * closed + at_once
        return came / (came - left) if by_chance < left < came else 1.0

    came = _came(history, flows)
    delivered = sum(_is_of(task, flows) for task in history.counted_deliveries)
    put = sum(1 for task in history.put_down if history.counts(task.delivered))
    people = sum(group.number for group in groups(model) if group.kind == "people")
    carried = times(came, came - delivered - _in_hand(history, flows), 0)
    if carried > 1 and lacked_stock(history):
        carried = 1.0  # what is left lacks goods, not robots or people
    return carried, times(put, put - measures.worked(history), people)


def _use_of_people(history: History) -> dict[str, float]:
    """Return the utilisation of the workers at each node where load units are worked on."""
    model, shares = history.model, {}
    for node, spec in history.workplaces.items():
        staff = {node: (spec.workers, model.hours(spec.hours))}
        spans = [(node, task.begun, task.worked) for task in history.put_down if task.station == node]
        shares[node] = measures.in_hours(staff, spans, history.stretches)
    return shares
