"""Functions that compute indicators from the history of a run, or of a part of its tasks.

For the list of indicators (`outcome.indicators`).

The last functions are for goods to person: visits of pods, lines picked at each, idle pickers, and the way for a line.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence

from desim_warehouse.model.facts.lifts import beside, time_taken
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.parts import PartHistory
from desim_warehouse.outcome.records import Deadline, TaskHistory, Trip
from desim_warehouse.states import AT_START, BROKEN, IN_LIFT, OPERATING, RESTING, SERVER, names
from desim_warehouse.values.calendars import Hours, Stretch

_QUEUEING = names(lambda state: state.queue == SERVER)
ROUNDING = 1e-9
"""Relative tolerance within which sums of energy, or of time, count as equal."""


def total(tally: str) -> Callable[[History], float]:
    return lambda history: history.totals[tally]


def count(tally: str) -> Callable[[History], int]:
    return lambda history: int(history.totals[tally])


def collisions(history: History) -> int:
    """Count episodes of waiting, not stops within an episode; a count of time steps would grow as steps shrink."""
    return int(history.totals["rear_ends"] + history.totals["crossings"])


def cost(history: History) -> float:
    """Return the paper's cost in the evaluation period, distance x w_d + time x w_t + S x w_c."""
    return history.model.cost.total(history.totals["distance"], history.counted, collisions(history))


def rotations(history: History) -> int:
    return sum(1 for ring in history.rotations if history.counts(ring.time))


def throughput(history: History) -> float:
    hours = history.counted / history.model.units.hour
    return history.totals["delivered"] / hours if hours else math.nan


def share(state: str) -> Callable[[History], float]:
    def compute(history: History) -> float:
        time = history.counted * len(history.log.robots)
        return history.totals[state] / time if time else math.nan

    return compute


def tasks_of_flow(flow: PartHistory) -> float:
    return len(flow.counted_deliveries)


def throughput_of_flow(flow: PartHistory) -> float:
    return len(flow.counted_deliveries) / flow.hours if flow.hours else math.nan


def worked(tasks: History | PartHistory) -> int:
    return len(counted_work(tasks))


def worked_on_time(tasks: History | PartHistory) -> float:
    return met(tasks.work_deadlines)


def counted_work(tasks: History | PartHistory) -> list[TaskHistory]:
    """Return the load units on which work was finished in the evaluation period."""
    whole = tasks.history
    return [task for task in tasks.put_down if whole.counts(task.worked) and task.worked <= whole.end]


def worker_wait(tasks: History | PartHistory) -> float:
    return math.fsum(tasks.history.within(task.delivered, task.begun) for task in tasks.put_down)


def worker_utilisation(tasks: History | PartHistory) -> float:
    """Return the utilisation of workers by the tasks of a flow, or by all tasks."""
    return _worked_by(tasks.history, tasks.put_down, tasks.stretches)


def worker_utilisation_then(part: PartHistory) -> float:
    """Return the utilisation of workers in a part of the day by all tasks, whenever they arrived."""
    return _worked_by(part.history, part.history.put_down, part.stretches)


def _worked_by(whole: History, put_down: Iterable[TaskHistory], stretches: Sequence[Stretch]) -> float:
    """Return the utilisation of workers by some tasks that were put down, in some stretches of time."""
    staff = {node: (spec.workers, whole.model.hours(spec.hours)) for node, spec in whole.workplaces.items()}
    return in_hours(staff, [(task.station, task.begun, task.worked) for task in put_down], stretches)


def server_utilisation(part: History | PartHistory) -> float:
    """Return the utilisation of servers; a server is in use while a robot loads or unloads in its station."""
    whole = part.history
    staff = {
        node: (item.servers, whole.model.hours(whole.model.layout.stations[item.zone].hours))
        for node, item in whole.layout.stations.items()
    }
    return in_hours(staff, whole.served, part.stretches)


def in_hours(
    staff: Mapping[str, tuple[int, Hours]],
    busy: Iterable[tuple[str, float, float]],
    stretches: Sequence[Stretch],
) -> float:
    """Return the utilisation of servers or workers in their hours; nan without such time.

    Work after the end of the hours (`at_close: finish`) is not counted.

    Args:
        staff: number of servers or workers, and their hours, by node.
        busy: node, begin and end of each interval of work.
        stretches: stretches of time to look at.
    """
    time = math.fsum(
        number * hours.share(begin, end) * (end - begin) for number, hours in staff.values() for begin, end in stretches
    )
    worked = math.fsum(
        until - since
        for node, start, stop in busy
        for begin, end in stretches
        for since, until in staff[node][1].between(max(start, begin), min(stop, end))
    )
    return worked / time if time else math.nan


def work_backlog(tasks: History | PartHistory) -> int:
    return sum(task.worked > tasks.history.end for task in tasks.put_down)


def backlog(tasks: History | PartHistory) -> float:
    return len(tasks.tasks) - len(tasks.done)


def cycle_time(tasks: History | PartHistory) -> float:
    return mean(tasks.cycle_times)


def cycle_time_median(tasks: History | PartHistory) -> float:
    return quantile(tasks.cycle_times, 0.5)


def cycle_time_p95(tasks: History | PartHistory) -> float:
    return quantile(tasks.cycle_times, 0.95)


def task_time(history: History) -> float:
    done = history.model.tasks.never_end or history.ended_with_its_work
    return history.end if done else math.nan


def cycle_time_cv(history: History) -> float:
    times = history.cycle_times
    return statistics.stdev(times) / statistics.fmean(times) if len(times) > 1 else math.nan


def tardiness(tasks: History | PartHistory) -> float:
    return mean([deadline.overrun(tasks.history.end) for deadline in tasks.deadlines])


def for_departures(tasks: History | PartHistory) -> list[TaskHistory]:
    """Return the tasks of flows with departures (`due_at`) that come due in the evaluation period."""
    whole = tasks.history
    flows = {name for name, flow in whole.model.tasks.flows.items() if flow.due_at}
    until = whole.model.run.end if whole.ended_with_its_work else whole.end
    return [
        task
        for task in tasks.tasks.values()
        if task.flow in flows and task.due is not None and whole.begin <= task.due <= until
    ]


def departure_lead(tasks: History | PartHistory) -> float:
    """Return the longest time between the arrival of a task and the departure that it missed; 0 if none missed one."""
    missed = (
        task.due - task.released for task in for_departures(tasks) if task.due is not None and task.done > task.due
    )
    return max(missed, default=0.0)


def has_departures(tasks: History | PartHistory) -> bool:
    return bool(for_departures(tasks))


def on_time(tasks: History | PartHistory) -> float:
    return met(tasks.deadlines)


def tasks_due(tasks: History | PartHistory) -> int:
    return len(tasks.deadlines)


def loads_due(tasks: History | PartHistory) -> int:
    return len(tasks.work_deadlines)


def met(deadlines: Sequence[Deadline]) -> float:
    """Return the share of deadlines that were met; nan without any."""
    return mean([not deadline.missed for deadline in deadlines])


def mean(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values) if values else math.nan


def quantile(ordered: Sequence[float], part: float) -> float:
    """Return a quantile of sorted values, interpolated linearly as by numpy, which would slow down the start."""
    if not ordered:
        return math.nan
    place = part * (len(ordered) - 1)
    low = math.floor(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (place - low) * (ordered[high] - ordered[low])


def backlog_growth(history: History) -> float:
    """Return tasks released minus tasks done in the evaluation period, per hour."""
    hours = history.counted / history.model.units.hour
    released = sum(1 for task in history.tasks.values() if history.counts(task.released))
    return (released - len(history.counted_done)) / hours if hours else math.nan


def energy_lowest(history: History) -> float:
    return min(history.lowest_levels, default=math.nan)


def energy_drift(history: History) -> float:
    """Return the energy charged minus the energy drawn, as a share of the capacity per hour.

    The result is exactly 0 if the two differ by rounding only.
    """
    batteries, hours = history.batteries, history.counted / history.model.units.hour
    if not batteries or not hours:
        return math.nan
    charged, drawn = history.charged, history.totals["energy"]
    gained = 0.0 if math.isclose(charged, drawn, rel_tol=ROUNDING) else charged - drawn
    return gained / math.fsum(battery.capacity for battery in batteries) / hours


def charger_utilisation(part: History | PartHistory) -> float:
    whole = part.history
    time = whole.chargers * length(part.stretches)
    used = math.fsum(overlap(charging.start, charging.end, part.stretches) for charging in whole.chargings)
    return used / time if time else math.nan


def robots_busy(part: History | PartHistory) -> float:
    """Return the share of time on duty in which robots are not idle; waits count, as they keep robots from a task."""
    time = dict.fromkeys(RESTING, 0.0)
    for robot in part.history.changes:
        for span in robot:
            if span.state in time:
                time[span.state] += overlap(span.start, span.end, part.stretches)
    idle = time.pop(AT_START)
    on_duty = len(part.history.log.robots) * length(part.stretches) - math.fsum(time.values())
    return max(1 - idle / on_duty, 0.0) if on_duty > ROUNDING else math.nan


def length(stretches: Sequence[Stretch]) -> float:
    """Return the total length of stretches of time."""
    return math.fsum(end - begin for begin, end in stretches)


def overlap(start: float, end: float, stretches: Sequence[Stretch]) -> float:
    """Return the length of the part of an interval that lies in stretches of time."""
    return math.fsum(max(min(end, last) - max(start, first), 0.0) for first, last in stretches)


def time_in(history: History, states: Iterable[str]) -> float:
    """Return the total time of all robots in some states; 0 for states that the model does not have."""
    return math.fsum(history.totals.get(state, 0.0) for state in states)


def availability(history: History) -> float:
    operating, broken = time_in(history, OPERATING), time_in(history, BROKEN)
    counts = operating + broken > ROUNDING * history.counted  # else robots only waited, and the rest is rounding
    return operating / (operating + broken) if counts else math.nan


def breaks_down(history: History) -> bool:
    return history.model.fleet.breaks_down


def station_wait(history: History) -> float:
    """Return the total time in which robots queue for a server; rounding may make the difference negative."""
    return max(time_in(history, _QUEUEING) - history.charger_wait, 0.0)


def has_prices(history: History) -> bool:
    return history.model.prices is not None


def has_batches(history: History) -> bool:
    return history.model.policies.batching.name != "single"


def counted_trips(history: History) -> list[Trip]:
    return [trip for trip in history.trips if history.counts(trip.end)]


def has_orders(history: History) -> bool:
    return bool(history.log.orders)


def has_due_orders(history: History) -> bool:
    return bool(history.order_deadlines)


def has_work(tasks: History | PartHistory) -> bool:
    return bool(tasks.put_down)


def has_due_work(tasks: History | PartHistory) -> bool:
    return bool(tasks.work_deadlines)


def has_arrivals(history: History) -> bool:
    return history.model.tasks.arrive


def has_batteries(history: History) -> bool:
    return history.model.battery is not None


def has_chargers(history: History) -> bool:
    return has_batteries(history) and history.chargers > 0


def has_stations(history: History) -> bool:
    return bool(history.layout.stations)


def has_tally(name: str) -> Callable[[History], bool]:
    """Return a condition for indicators: whether the robots of a run have a tally of this name."""
    return lambda history: name in history.totals


def encounters(history: History) -> float:
    hours = history.counted / history.model.units.hour
    return history.totals["encounters"] / hours if hours else math.nan


def shared_time(history: History) -> float:
    people = history.log.people
    return people["shared"] / people["time"] if people["time"] else math.nan


def has_due_times(tasks: History | PartHistory) -> bool:
    return bool(tasks.deadlines)


def has_pods(history: History) -> bool:
    return history.model.pods is not None


def pod_visits(history: History) -> int:
    return sum(1 for row in history.rows("stored") if history.counts(row.time))


def pile_on(history: History) -> float:
    visits = pod_visits(history)
    return history.totals["delivered"] / visits if visits else math.nan


def lifts_taken(history: History) -> dict[str, float]:
    """Return the utilisation of each lift by name: the share of the evaluation period in which robots hold it.

    The time in which robots wait for cabins and ride is logged for all lifts together. It is divided in proportion to
    the least times of their rides.
    """
    layout, model, whole = history.layout, history.model, history.counted
    passed = {row["edge"]: row["passages"] for row in history.log.edges} if layout.lifts else {}
    rides = {
        lift: {ride: passed[">".join(ride)] for ride, its_lift in layout.rides.items() if its_lift is lift}
        for lift in layout.lifts
    }
    driven = {lift: beside(model, lift, mine) for lift, mine in rides.items()}
    least = {lift: time_taken(model, lift, mine) - driven[lift] for lift, mine in rides.items()}
    weights = least if any(least.values()) else dict.fromkeys(rides, 1.0)  # cabins were called, but no ride is over
    times = history.totals[IN_LIFT] / math.fsum(weights.values()) if rides else 0.0
    return {lift.name: (times * weights[lift] + driven[lift]) / whole if whole else math.nan for lift in rides}


def lift_utilisation(history: History) -> float:
    """Return the mean utilisation of all lifts."""
    return statistics.fmean(lifts_taken(history).values())


def has_pickers(history: History) -> bool:
    return history.model.pickers is not None


def picker_utilisation(part: History | PartHistory) -> float:
    return _of_pickers(part, picks=True)


def picker_walking(part: History | PartHistory) -> float:
    return _of_pickers(part, picks=False)


def _of_pickers(part: History | PartHistory, *, picks: bool) -> float:
    """Return the share of the time of all pickers, in their hours, in which they pick (`picks`) or walk."""
    busy = [("", span.start, span.end) for span in part.history.pickers_work if span.picks is picks]
    return in_hours(_pickers(part.history), busy, part.stretches)


def _pickers(history: History) -> dict[str, tuple[int, Hours]]:
    """Return the number of pickers and their hours under the place "", as `in_hours` takes them; empty without any."""
    pickers = history.model.pickers
    return {} if pickers is None else {"": (pickers.count, history.model.hours(pickers.hours))}


def lines_per_picker(part: History | PartHistory) -> float:
    """Return the number of picks that end in the evaluation period, per hour of a picker at work."""
    ends = [span.end for span in part.history.pickers_work if span.picks]
    lines = sum(begin <= end <= until for end in ends for begin, until in part.stretches)
    at_work = math.fsum(
        number * hours.share(begin, until) * (until - begin)
        for number, hours in _pickers(part.history).values()
        for begin, until in part.stretches
    )
    return lines * part.history.model.units.hour / at_work if at_work else math.nan


def station_idle(history: History) -> float:
    """Return the share of the time of servers in which they pick no line; changes of pods count as idle."""
    stations, model = history.layout.stations, history.model
    busy = math.fsum(row["busy"] for row in history.log.stations or ())
    time = math.fsum(
        item.servers * model.hours(model.layout.stations[item.zone].hours).share(history.begin, history.end)
        for item in stations.values()
    )
    return 1 - busy / (time * history.counted) if time * history.counted else math.nan


def distance_per_task(history: History) -> float:
    done = history.totals["delivered"]
    return history.totals["distance"] / done if done else math.nan
