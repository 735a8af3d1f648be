"""Standstills: periods without deliveries although tasks were open, and their causes.

For the answer of a run, and for its course on the page and in the replay.

A gap between two deliveries counts if tasks are open in it for longer than the 95 % quantile of cycle times, and no
robot is at work for most of that time. A robot at work drives to or with a load, or handles a load, and does not wait
in traffic. So a single long task is not a standstill. Waits in traffic need `log: all`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Literal, NamedTuple

from desim_warehouse.model import Model
from desim_warehouse.model.facts.places import destinations, specs
from desim_warehouse.outcome.account import booked
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.measures import quantile
from desim_warehouse.states import (
    APART,
    AT_START,
    CHARGER,
    CLOSED_LANE,
    IN_LIFT,
    OPENING,
    PERSON_AHEAD,
    PICKER,
    SHOWN,
    Phase,
    Queue,
)

Cause = Literal[
    "batteries", "off duty", "closed", "lanes", "people", "lifts", "broken", "queues", "pickers", "no stock", "no task"
]
"""Cause of a standstill: robots charge or wait for it, rest off duty, wait for a station, ..., or pods are empty."""
LEAST_DONE = 20
"""Fewest tasks done from which the quantile of cycle times is computed."""
AT_WORK = (Phase.TO_GOOD, Phase.LOADING, Phase.TO_STATION, Phase.UNLOADING)
MOST_AT_WORK = 0.5
"""Mean number of robots at work from which a gap does not count as a standstill."""


class Halt(NamedTuple):
    """A standstill of deliveries from `start` to `end`, with the number of `open` tasks, and its main cause."""

    start: float
    end: float
    open: int
    cause: Cause


def halts(history: History) -> list[Halt]:
    """Return the standstills of deliveries in the evaluation period, in order."""
    if len(history.cycle_times) < LEAST_DONE:
        return []
    longest = quantile(history.cycle_times, 0.95)
    gaps = [gap for gap in _gaps(history) if gap[1] - gap[0] > longest]
    spans = parts_of_time(history) if gaps else []
    standstills = []
    for start, end, still in gaps:
        worked, spent = 0.0, defaultdict[Cause, float](float)
        for since, until, part in spans:
            time = max(min(until, end) - max(since, start), 0.0)
            what = _what(part) if time else None
            if what is not None:
                spent[what] += time
            elif part in SHOWN and SHOWN[part].phase in AT_WORK:
                worked += time
        if worked < MOST_AT_WORK * (end - start) and spent:
            standstills.append(Halt(start, end, still, _cause(history, spent, start, end)))
    return standstills


def lacked_stock(history: History) -> bool:
    """Whether the run stood still because pods were empty."""
    return _may_run_out(history.model) and any(halt.cause == "no stock" for halt in halts(history))


def _gaps(history: History) -> Iterator[tuple[float, float, int]]:
    """Yield the intervals without a delivery in which tasks are open all along, with the number open at the end."""
    begin, end = history.begin, history.end
    done = [task.delivered for task in history.counted_deliveries if task.delivered <= end]
    released = sorted(task.released for task in history.tasks.values())
    before = sum(1 for task in history.delivered if task.delivered < begin)
    came = 0
    for number, (since, until) in enumerate(pairwise([begin, *done, end])):
        while came < len(released) and released[came] <= since:
            came += 1
        still, start = came - before - number, since
        if still <= 0:
            if came == len(released) or released[came] >= until:
                continue
            start = released[came]
        later = came
        while later < len(released) and released[later] < until:
            later += 1
        yield start, until, later - before - number


def parts_of_time(history: History) -> list[tuple[float, float, str]]:
    """Return intervals with the state of every robot or, if logged, the reason of its wait in traffic."""
    return [part for robot in parts_of_robots(history) for part in robot]


def parts_of_robots(history: History) -> list[list[tuple[float, float, str]]]:
    """Return the intervals of `parts_of_time` robot by robot."""
    if history.log.level == "all":
        return [[(piece.start, piece.end, piece.part) for piece in robot] for robot in booked(history)]
    return [[(change.start, change.end, change.seen.name) for change in robot] for robot in history.states]


def _what(part: str) -> Cause | None:
    """Return the cause of a standstill that a state or a wait in traffic suggests; None for work and drives to park."""
    if part in APART:
        waits: dict[str, Cause] = {CLOSED_LANE: "lanes", PERSON_AHEAD: "people", IN_LIFT: "lifts"}
        return waits[part]
    if part not in SHOWN:
        return "queues"
    state = SHOWN[part]
    if state.queue is not None:
        by_queue: dict[Queue, Cause] = {OPENING: "closed", CHARGER: "batteries", PICKER: "pickers"}
        return by_queue.get(state.queue, "queues")
    if state.phase is Phase.REST:
        return "no task" if part == AT_START else "off duty"
    held: dict[Phase | None, Cause] = {
        Phase.CHARGING: "batteries",
        Phase.BREAKDOWN: "broken",
        Phase.DECISION: "no task",
    }
    return held.get(state.phase)


def _cause(history: History, spent: Mapping[Cause, float], start: float, end: float) -> Cause:
    """Return the cause of a standstill: the main activity of robots in it, or the root of queues, hours or repairs."""
    cause = max(spent, key=spent.__getitem__)
    if cause == "queues":
        roots: tuple[Cause, ...] = ("lanes", "people", "lifts", "pickers")
        cause = next((root for root in roots if spent.get(root, 0.0) > MOST_AT_WORK * (end - start)), cause)
    if cause != "no task":
        return cause
    return "broken" if _waits_for_repair(history, (start + end) / 2) else _shut(history.model, start, end)


def _waits_for_repair(history: History, time: float) -> bool:
    """Whether all open tasks at a time are assigned to robots that are broken down then."""
    open_tasks = {task.number for task in history.tasks.values() if task.released <= time < task.delivered}
    holders = {task.task: task.robot for task in history.assignments if task.start <= time < task.end}
    broken = {
        span.robot
        for robot in history.states
        for span in robot
        if span.start <= time < span.end and span.seen.phase is Phase.BREAKDOWN
    }
    return bool(open_tasks) and all(holders.get(number) in broken for number in open_tasks)


def _shut(model: Model, start: float, end: float) -> Cause:
    """Return why robots without a task get none between two times: hours, closures, empty pods, or no task."""
    middle, stations_by_node = (start + end) / 2, specs(model, model.floor)
    stations = [
        model.hours(stations_by_node[node].hours)
        for node in destinations(model, model.floor)
        if node in stations_by_node
    ]
    if stations and not any(hours.is_open(middle) for hours in stations):
        return "closed"
    held = [closure.hours for closure in model.traffic.closures.values() if closure.tasks == "hold"]
    if any(model.hours(name).is_open(middle) for name in held):
        return "lanes"
    return "no stock" if _may_run_out(model) else "no task"


def _may_run_out(model: Model) -> bool:
    """Whether pods hold units that may be used up."""
    return model.pods is not None and model.pods.units is not None
