"""The list of all indicators of a run.

To add an indicator, add it to `INDICATORS`: its name, unit, meaning, better direction, computation from the history of
a run, and the runs that have it. Runs, studies, targets, reports, figures, the command line and the reference in the
documentation all read this list.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal

from desim_warehouse.errors import NoIndicatorError, StudyError, nearest, spoken, synonym
from desim_warehouse.model import Model
from desim_warehouse.model.facts.day_parts import parts_of_the_day
from desim_warehouse.outcome import measures, money
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.parts import PartHistory, by_day_part, of_flow
from desim_warehouse.states import APART, AT_START, OPERATING, SERVER, STATES, TIMES, WAITING, State

Unit = Literal[
    "time",
    "length",
    "energy",
    "count",
    "tasks",
    "tasks per hour",
    "weighted",
    "money per year",
    "money per task",
    "capacity per hour",
    "share of tasks",
    "share of load units",
    "share of orders",
    "share of fleet time",
    "share of charger time",
    "share of capacity",
    "share of people's time",
    "share of workers' time",
    "share of pickers' time",
    "lines per hour",
    "encounters per hour",
    "ratio",
    "share of operating time",
]
Better = Literal["less", "more"]
Way = Literal["rises", "falls"]
AT = "@"
"""Separator between the name of an indicator and a part of the day."""

_MORE_OF = {AT_START, WAITING.name, *APART, *(name for name, state in STATES.items() if state.queue == SERVER)}
"""States in which a larger fleet usually spends more of its time: idle, in queues and in traffic."""
_JUDGED = {
    False: (
        *("T", "S", "C", "throughput_per_hour", "cycle_time_mean", "on_time", "cycle_time_p95", "share_waiting"),
        *("orders_on_time", "annual_cost"),
    ),
    True: (
        *("throughput_per_hour", "cycle_time_p95", "on_time", "backlog", "share_waiting", "cycle_time_mean"),
        *("worked_on_time", "orders_on_time", "charger_utilisation", "availability", "annual_cost"),
    ),
}
"""Indicators by which a run is judged, the most important first, by whether work never ends.

If it ends, the first indicators are those of the paper.
"""

_COUNTS: dict[Unit, tuple[str, str]] = {
    "share of tasks": ("tasks_due", "tasks"),
    "share of load units": ("loads_due", "worked"),
    "share of orders": ("orders_due", "orders"),
}
"""The indicator that counts the whole of a share, and the indicator that did so before 0.4.0."""
_OF_TASKS = ("cycle_time", "order_cycle_time", "tardiness", "departure_lead")
"""The indicators of the times of tasks and orders begin with these."""
_COUNTED: frozenset[Unit] = frozenset(["count", "tasks"])
_MEASURED: frozenset[Unit] = frozenset(
    [
        *("time", "length", "energy", "money per year", "money per task"),
        *("share of fleet time", "share of charger time", "share of operating time"),
        *("share of people's time", "share of workers' time", "share of pickers' time"),
    ]
)
"""Units of measurements; counts, and shares of them, may agree by chance."""


@dataclass(frozen=True)
class Indicator:
    """A performance indicator of a run.

    Attributes:
        title: name on axes and in reports.
        unit: kind of unit; the model gives the units of time and length.
        meaning: definition, for the reference.
        better: whether less or more is better; None for neither by itself.
        compute: returns the value in the evaluation period.
        applies: returns whether a run has the indicator.
        by_flow: returns the value for the tasks of a flow, named `NAME:FLOW`; None if flows do not have the indicator.
        by_time: returns the value for a part of the day, named `NAME@11:30-13:00`, if demand has rates by the clock:
            for the tasks that arrive in the part if it is the function `by_flow`, or else for the events in the part.
        signed: whether the value can be negative.
        with_robots: how the value usually changes with more robots for the work of a day, as a first guess of
            searches, which they check; None if unknown.
    """

    name: str
    title: str
    unit: Unit
    meaning: str
    better: Better | None
    compute: Callable[[History], float]
    applies: Callable[[Any], bool] = lambda _: True
    by_flow: Callable[[PartHistory], float] | None = None
    by_time: Callable[[PartHistory], float] | None = None
    signed: bool = False
    with_robots: Way | None = None

    def of(self, mark: str, part: str) -> Indicator:
        """Return the indicator for one flow (`mark` is `:`), or for one part of the day (`@`)."""
        title = f"{self.title}, {part_in_words(part) if mark == AT else part}"
        return replace(self, name=f"{self.name}{mark}{part}", title=title, by_flow=None, by_time=None)

    @property
    def is_share(self) -> bool:
        """Whether the indicator is a share, which is at most 1 and shown in per cent."""
        return self.unit.startswith("share")

    @property
    def is_count(self) -> bool:
        """Whether the indicator counts events or tasks."""
        return self.unit in _COUNTED

    @property
    def within(self) -> tuple[float, float]:
        """The range of the indicator: at least 0 unless it is signed, at most 1 if it is a share, else unbounded."""
        return -math.inf if self.signed else 0.0, 1.0 if self.is_share else math.inf


def _share_of(state: State) -> Indicator:
    """Return the indicator for the share of the fleet's time in a state; with waiting in traffic, all sum to 1."""
    return Indicator(
        f"share_{state.name}",
        f"Fleet {state.doing}",
        "share of fleet time",
        state.time,
        state.better,
        measures.share(state.name),
        lambda history: state.applies(history.model),
        with_robots="falls" if state.name in OPERATING else "rises" if state.name in _MORE_OF else None,
    )


def _waited_apart(state: State) -> Indicator:
    """Return the indicator for the time of a wait in traffic that is not a collision."""
    return Indicator(
        state.name,
        f"Time {state.doing}",
        "time",
        f"all robots together, no collisions: {state.time}",
        state.better,
        measures.total(state.name),
        lambda history: state.applies(history.model),
        with_robots="rises",
    )


INDICATORS = {
    indicator.name: indicator
    for indicator in (
        Indicator(
            "T",
            "Task time",
            "time",
            "time at which the last robot is back with all goods delivered, nan if the run ends before that; with "
            "lifelong demand, the length of the run",
            "less",
            measures.task_time,
            with_robots="falls",
        ),
        Indicator(
            "S",
            "Waits for another robot",
            "count",
            "episodes in which a robot waits for another, `rear_ends + crossings`; the collisions of the paper",
            "less",
            measures.collisions,
            with_robots="rises",
        ),
        Indicator(
            "C",
            "Charging stops",
            "count",
            "charging stops after which a robot went out again",
            "less",
            measures.count("recharged"),
            with_robots="rises",
        ),
        Indicator(
            "tasks",
            "Tasks delivered",
            "count",
            "tasks delivered",
            "more",
            measures.count("delivered"),
            by_flow=measures.tasks_of_flow,
            with_robots="rises",
        ),
        Indicator(
            "moves", "Edges driven", "count", "edges driven", "less", measures.count("moves"), with_robots="rises"
        ),
        Indicator(
            "distance",
            "Distance driven",
            "length",
            "distance driven by all robots",
            "less",
            measures.total("distance"),
            with_robots="rises",
        ),
        Indicator(
            "energy",
            "Energy drawn",
            "energy",
            "energy used by all robots",
            "less",
            measures.total("energy"),
            with_robots="rises",
        ),
        Indicator(
            "waiting",
            "Time waited in traffic",
            "time",
            "time waited in traffic, all robots together",
            "less",
            measures.total("waiting"),
            with_robots="rises",
        ),
        *(_waited_apart(state) for state in APART.values()),
        Indicator(
            "encounters_per_hour",
            "Encounters of robots and people",
            "encounters per hour",
            "times per hour that a person held a robot up in front of an aisle, or entered one with a robot in it; "
            "only with `people`",
            "less",
            measures.encounters,
            measures.has_tally("encounters"),
            with_robots="rises",
        ),
        Indicator(
            "shared_time",
            "Time shared with robots",
            "share of people's time",
            "share of the time of people in aisles during which a robot was in the same aisle; only with `people`",
            "less",
            measures.shared_time,
            measures.has_tally("encounters"),
            with_robots="rises",
        ),
        Indicator(
            "cost",
            "Cost",
            "weighted",
            "`w_d distance + w_t time + w_c S`, with the weights of the section `cost`; time is the counted part of T",
            "less",
            measures.cost,
        ),
        Indicator(
            "rear_ends",
            "Waits behind a robot on an edge",
            "count",
            "waiting episodes behind a robot on the same edge",
            "less",
            measures.count("rear_ends"),
            with_robots="rises",
        ),
        Indicator(
            "crossings",
            "Waits before an intersection",
            "count",
            "waiting episodes in front of an intersection",
            "less",
            measures.count("crossings"),
            with_robots="rises",
        ),
        Indicator(
            "rotations",
            "Gridlock rotations",
            "count",
            "full rings of waiting robots that turned by one position",
            "less",
            measures.rotations,
            with_robots="rises",
        ),
        Indicator(
            "throughput_per_hour",
            "Throughput",
            "tasks per hour",
            "`tasks / (counted time × units.seconds / 3600)`",
            "more",
            measures.throughput,
            by_flow=measures.throughput_of_flow,
            with_robots="rises",
        ),
        Indicator(
            "cycle_time_mean",
            "Cycle time, mean",
            "time",
            "mean time from a task's release until it is done (`tasks.done_when`)",
            "less",
            measures.cycle_time,
            by_flow=measures.cycle_time,
            with_robots="falls",
        ),
        Indicator(
            "cycle_time_median",
            "Cycle time, median",
            "time",
            "median time from a task's release until it is done",
            "less",
            measures.cycle_time_median,
            by_flow=measures.cycle_time_median,
            with_robots="falls",
        ),
        Indicator(
            "cycle_time_p95",
            "Cycle time, 95 % quantile",
            "time",
            "95 % quantile of the time from a task's release until it is done (linear between order statistics)",
            "less",
            measures.cycle_time_p95,
            by_flow=measures.cycle_time_p95,
            with_robots="falls",
        ),
        Indicator(
            "cycle_time_cv",
            "Cycle time, coefficient of variation",
            "ratio",
            "standard deviation / mean of the time from a task's release until it is done; only with `people`",
            "less",
            measures.cycle_time_cv,
            measures.has_tally("encounters"),
        ),
        Indicator(
            "backlog",
            "Open orders at the end",
            "tasks",
            "tasks released but not done at the end",
            "less",
            measures.backlog,
            by_flow=measures.backlog,
            with_robots="falls",
        ),
        Indicator(
            "backlog_growth_per_hour",
            "Backlog growth",
            "tasks per hour",
            "tasks released minus tasks done in the counted time, per hour; only where tasks arrive at random "
            "(`poisson` or `profile`)",
            "less",
            measures.backlog_growth,
            measures.has_arrivals,
            signed=True,
            with_robots="falls",
        ),
        Indicator(
            "tardiness_mean",
            "Tardiness, mean",
            "time",
            "mean of `max(time when it was done − due, 0)` over the tasks that `on_time` is a share of; a task that "
            "is not done counts up to the end of the run; only where tasks have due times "
            "(`due`, `due_within` or `due_at`)",
            "less",
            measures.tardiness,
            measures.has_due_times,
            by_flow=measures.tardiness,
            with_robots="falls",
        ),
        Indicator(
            "on_time",
            "Done on time",
            "share of tasks",
            "share of the tasks coming due in the counted time, its end included, that are done (`tasks.done_when`) "
            "by their due time; only where tasks have due times (`due`, `due_within` or `due_at`). Tasks that came due "
            "in the warm-up are left out, done or not, and so are those due after the end, unless the run ends because "
            "all its work is done. Over several runs it is the mean of their shares, with equal weights: if busy days "
            "are late more often, the share of all tasks of all runs is smaller",
            "more",
            measures.on_time,
            measures.has_due_times,
            by_flow=measures.on_time,
            by_time=measures.on_time,
            with_robots="rises",
        ),
        Indicator(
            "tasks_due",
            "Tasks come due",
            "count",
            "number of tasks that `on_time` is a share of; only where tasks have due times "
            "(`due`, `due_within` or `due_at`)",
            None,
            measures.tasks_due,
            measures.has_due_times,
            by_flow=measures.tasks_due,
            by_time=measures.tasks_due,
        ),
        Indicator(
            "departure_lead",
            "Lead before departures",
            "time",
            "longest time before its departure (`due_at`) at which a task came that missed it, 0 if none did: all "
            "that came earlier were in time; only where tasks of flows with `due_at` come due in the counted time",
            "less",
            measures.departure_lead,
            measures.has_departures,
            by_flow=measures.departure_lead,
        ),
        Indicator(
            "worked",
            "Loads worked on",
            "count",
            "load units put down in stations on which work was finished; only where a station has `work_time`",
            "more",
            measures.worked,
            measures.has_work,
            by_flow=measures.worked,
            with_robots="rises",
        ),
        Indicator(
            "worked_on_time",
            "Worked on in time",
            "share of load units",
            "share of the load units for stations with workers, coming due in the counted time, on which work is "
            "finished by their due time; one that comes due before it is put down is also late, if it can go nowhere "
            "else; only where loads have due times (`due`, `due_within` or `due_at`)",
            "more",
            measures.worked_on_time,
            measures.has_due_work,
            by_flow=measures.worked_on_time,
            with_robots="rises",
        ),
        Indicator(
            "loads_due",
            "Loads come due",
            "count",
            "number of load units that `worked_on_time` is a share of; only where loads have due times "
            "(`due`, `due_within` or `due_at`)",
            None,
            measures.loads_due,
            measures.has_due_work,
            by_flow=measures.loads_due,
        ),
        Indicator(
            "worker_utilisation",
            "Worker utilisation",
            "share of workers' time",
            "share of the time of all workers, in the hours of their stations, in which they work on a load unit; "
            "for a flow, on its load units; only where a station has `work_time`",
            None,
            measures.worker_utilisation,
            measures.has_work,
            by_flow=measures.worker_utilisation,
            by_time=measures.worker_utilisation_then,
        ),
        Indicator(
            "server_utilisation",
            "Server utilisation",
            "share of capacity",
            "share of the time of all servers of stations, in the hours of their stations, in which a robot loads or "
            "unloads there; only with `layout.stations`",
            None,
            measures.server_utilisation,
            measures.has_stations,
            by_time=measures.server_utilisation,
        ),
        Indicator(
            "lift_utilisation",
            "Lift utilisation",
            "share of capacity",
            "share of the time of all lifts in which a robot holds them, from the call of the cabin until the doors "
            "have closed behind it; only with `layout.lifts`",
            None,
            measures.lift_utilisation,
            lambda history: bool(history.layout.lifts),
            with_robots="rises",
        ),
        Indicator(
            "robots_busy",
            "Robots busy",
            "share of fleet time",
            "share of the time of all robots, in their hours, in which they are not idle: waits, queues, charging "
            "and repairs also count, as each keeps a robot from a task",
            None,
            measures.robots_busy,
            by_time=measures.robots_busy,
            with_robots="falls",
        ),
        Indicator(
            "worker_wait",
            "Time waited for a worker",
            "time",
            "total time from when load units were put down until work on them began; only where a station has "
            "`work_time`",
            "less",
            measures.worker_wait,
            measures.has_work,
            by_flow=measures.worker_wait,
        ),
        Indicator(
            "work_backlog",
            "Loads not worked on",
            "tasks",
            "load units put down but not yet worked on at the end; only where a station has `work_time`",
            "less",
            measures.work_backlog,
            measures.has_work,
            by_flow=measures.work_backlog,
        ),
        Indicator(
            "pod_visits",
            "Visits of pods",
            "count",
            "pods that were brought to a station and put down again; only with `pods`",
            None,
            measures.pod_visits,
            measures.has_pods,
            with_robots="rises",
        ),
        Indicator(
            "pile_on",
            "Lines a visit",
            "ratio",
            "lines done / pods put down again; only with `pods`",
            "more",
            measures.pile_on,
            measures.has_pods,
            with_robots="falls",
        ),
        Indicator(
            "station_idle",
            "Pickers idle",
            "share of capacity",
            "share of the time of servers of stations, in their hours, in which no line is picked; only with `pods`",
            "less",
            measures.station_idle,
            measures.has_pods,
            with_robots="falls",
        ),
        Indicator(
            "distance_per_task",
            "Distance a task",
            "length",
            "distance driven by all robots / tasks delivered; only with `pods`, where a task is a line",
            "less",
            measures.distance_per_task,
            measures.has_pods,
        ),
        Indicator(
            "trips",
            "Trips",
            "count",
            "tours that ended with the delivery of their last task; only with `policies.batching`",
            None,
            lambda history: len(measures.counted_trips(history)),
            measures.has_batches,
        ),
        Indicator(
            "loads_per_trip",
            "Loads per trip",
            "tasks",
            "mean number of tasks done on one tour; only with `policies.batching`",
            "more",
            lambda history: measures.mean([len(trip.tasks) for trip in measures.counted_trips(history)]),
            measures.has_batches,
        ),
        Indicator(
            "orders",
            "Orders delivered",
            "count",
            "orders whose last task was delivered; only with orders from a file or of `lines`",
            "more",
            lambda history: len(history.counted_orders),
            measures.has_orders,
            with_robots="rises",
        ),
        Indicator(
            "order_cycle_time_mean",
            "Order cycle time, mean",
            "time",
            "mean time from an order's release until its last task is done; only with orders from a file or of `lines`",
            "less",
            lambda history: measures.mean([order.cycle_time for order in history.counted_orders]),
            measures.has_orders,
            with_robots="falls",
        ),
        Indicator(
            "order_cycle_time_p95",
            "Order cycle time, 95 % quantile",
            "time",
            "95 % quantile of the time from an order's release until its last task is done; only with orders from a "
            "file or of `lines`",
            "less",
            lambda history: measures.quantile(sorted(order.cycle_time for order in history.counted_orders), 0.95),
            measures.has_orders,
            with_robots="falls",
        ),
        Indicator(
            "orders_on_time",
            "Orders on time",
            "share of orders",
            "share of orders of which every task was done by its due time; an order comes due with the first of its "
            "tasks that is late, otherwise with the last; only with orders that have due times "
            "(`due`, `due_within` or `due_at`)",
            "more",
            lambda history: measures.met(history.order_deadlines),
            measures.has_due_orders,
            with_robots="rises",
        ),
        Indicator(
            "orders_due",
            "Orders come due",
            "count",
            "number of orders that `orders_on_time` is a share of; only with orders that have due times "
            "(`due`, `due_within` or `due_at`)",
            None,
            lambda history: len(history.order_deadlines),
            measures.has_due_orders,
        ),
        Indicator(
            "energy_lowest",
            "Lowest battery level",
            "share of capacity",
            "lowest level of any robot's battery, as a share of its capacity; only with `battery`",
            "more",
            measures.energy_lowest,
            measures.has_batteries,
            signed=True,  # with `battery.reserve`
            with_robots="rises",
        ),
        Indicator(
            "energy_drift_per_hour",
            "Battery drift",
            "capacity per hour",
            "change of the fleet's mean battery level over the counted time, as a share of the capacity per hour; only "
            "with `battery`",
            "more",
            measures.energy_drift,
            measures.has_batteries,
            signed=True,
        ),
        Indicator(
            "charger_utilisation",
            "Charger utilisation",
            "share of charger time",
            "share of the time of all chargers in which a robot is charged; only with `battery` and `chargers` of bays",
            None,
            measures.charger_utilisation,
            measures.has_chargers,
            by_time=measures.charger_utilisation,
        ),
        Indicator(
            "charger_wait",
            "Time queued for a charger",
            "time",
            "time waiting in a bay for a charger, all robots together; only with `battery` and `chargers` of bays",
            "less",
            lambda history: history.charger_wait,
            measures.has_chargers,
            with_robots="rises",
        ),
        Indicator(
            "station_wait",
            "Time queued for a server",
            "time",
            "time waiting in a station for a server, all robots together; only with `layout.stations`",
            "less",
            measures.station_wait,
            measures.has_stations,
            with_robots="rises",
        ),
        Indicator(
            "picker_utilisation",
            "Pickers, picking",
            "share of pickers' time",
            "share of the time of all pickers, in their hours, in which they handle loads; only with `pickers`",
            None,
            measures.picker_utilisation,
            measures.has_pickers,
            by_time=measures.picker_utilisation,
            with_robots="rises",
        ),
        Indicator(
            "picker_walking",
            "Pickers, walking",
            "share of pickers' time",
            "share of the time of all pickers, in their hours, in which they walk to a robot; only with `pickers`",
            "less",
            measures.picker_walking,
            measures.has_pickers,
            by_time=measures.picker_walking,
        ),
        Indicator(
            "lines_per_picker",
            "Lines of a picker",
            "lines per hour",
            "loads handled per picker and hour at work; only with `pickers`",
            "more",
            measures.lines_per_picker,
            measures.has_pickers,
            by_time=measures.lines_per_picker,
            with_robots="rises",
        ),
        Indicator(
            "breakdowns",
            "Breakdowns",
            "count",
            "breakdowns of robots; only with `breakdowns`",
            "less",
            measures.count("breakdowns"),
            measures.breaks_down,
            with_robots="rises",
        ),
        Indicator(
            "availability",
            "Availability",
            "share of operating time",
            "time in operation (driving, loading and unloading, waits not counted) as a share of that and the time in "
            "which robots are broken down; only with `breakdowns`",
            "more",
            measures.availability,
            measures.breaks_down,
        ),
        Indicator(
            "annual_cost",
            "Annual cost",
            "money per year",
            "yearly cost of robots, chargers, energy, people of stations and late orders at the prices of the "
            "section `prices`, for a year of its `hours` like the counted time; only with `prices`",
            "less",
            money.annual_cost,
            measures.has_prices,
            with_robots="rises",
        ),
        Indicator(
            "cost_per_task",
            "Cost per task",
            "money per task",
            "`annual_cost` / the tasks that such a year delivers; only with `prices`",
            "less",
            money.cost_per_task,
            measures.has_prices,
            with_robots="rises",
        ),
        *(_share_of(state) for state in TIMES.values()),
    )
}
"""Indicators by name, in the order of tables."""


class RunIndicators(dict[str, float]):
    """The indicators of a run by name.

    Raises:
        NoIndicatorError: an indicator that the run does not have, with the reason or the nearest name.
    """

    def __missing__(self, name: str) -> float:
        indicator = look_up(name)
        raise NoIndicatorError(
            f"indicator {name!r}: this run does not have it; {indicator.meaning if indicator else hint(name, self)}"
        )


def kpis(history: History) -> RunIndicators:
    """Compute all indicators that a run has, in the units of its model file."""
    has = ((name, indicator) for name, indicator in INDICATORS.items() if indicator.applies(history))
    values = RunIndicators({name: indicator.compute(history) for name, indicator in has})
    for flow in history.model.tasks.flows:
        tasks = of_flow(history, flow)
        for name, indicator in INDICATORS.items():
            if indicator.by_flow is not None and indicator.applies(tasks):
                values[f"{name}:{flow}"] = indicator.by_flow(tasks)
    for name_of_part, part in by_day_part(history).items():
        for name, indicator in INDICATORS.items():
            of_tasks = indicator.by_time is indicator.by_flow
            if indicator.by_time is not None and indicator.applies(part if of_tasks else history):
                values[f"{name}{AT}{name_of_part}"] = indicator.by_time(part)
    return values


_CONDITION = re.compile(r"; (only (?:with|where) .+?)(?:$|, where|[;:]|\. )")
"""The condition in the meaning of an indicator under which models have it."""


def judged_by(names: Collection[str], *, never_ends: bool) -> list[str]:
    """Return the names by which a run of this kind is judged, the most important first; `names` are all it has."""
    return [name for name in _JUDGED[never_ends] if name in names]


def chosen(wanted: Collection[str], has: Collection[str]) -> list[str]:
    """Return the requested indicators of runs; `all` stands for every indicator that they have.

    Raises:
        StudyError: an indicator that no run has, with the nearest name.
    """
    for name in wanted:
        if name != "all" and has and name not in has:
            raise StudyError(no_run_has(name, has))
    return list(has) if "all" in wanted else list(wanted)


def no_run_has(name: str, has: Collection[str]) -> str:
    """Return the message for an indicator that no run has: the condition for it, or the nearest name."""
    indicator = look_up(name)
    condition = None if indicator is None else _CONDITION.search(indicator.meaning)
    if condition is None:
        return f"indicator {name!r}: no run has it, {hint(name, has)}"
    return f"indicator {name!r}: no run has it; it is there {condition[1]}, in the model file or by --set"


def why_no_value(name: str) -> str:
    """Return the reason why an indicator of a run is nan."""
    if name == "T":
        return "the run ends (run.length) before its work is done"
    return "nothing of what it is about happened in the counted time"


def hint(name: str, has: Collection[str]) -> str:
    """Return a hint on which indicator was meant, by a similar name, a synonym, its title, or a flow beside it."""
    names = name.split(",")
    if len(names) > 1:
        return f"expected one name at a time; the option may be repeated, for {spoken(map(str.strip, names))}"
    titles = {indicator.title: key for key in has if (indicator := look_up(key))}
    near = synonym(name, [*titles, *has]) or _of_flow(name) or nearest(name, [*titles, *has])
    return f"did you mean {titles.get(near, near)!r}?" if near else f"expected one of {', '.join(has)}"


def _of_flow(phrase: str) -> str | None:
    """Return the indicator of a flow for a phrase such as `express on time`, or None."""
    for name in sorted(
        (name for name, indicator in INDICATORS.items() if indicator.by_flow and "_" in name), key=len, reverse=True
    ):
        words = name.replace("_", "[ _]")
        if match := re.fullmatch(rf"(?P<before>.+) {words}|{words} (?P<after>.+)", phrase, re.IGNORECASE):
            return f"{name}:{match['before'] or match['after']}"
    return None


def refuse_unknown(name: str, models: Iterable[Model]) -> None:
    """Refuse an unknown indicator, or a flow or part of the day that no model has, before any simulation.

    Raises:
        StudyError: the name, and the nearest name that the models have.
    """
    base, mark, part = split(find(name).name)
    if not mark:
        return
    has = {
        part_or_flow: None
        for model in models
        for part_or_flow in (parts_of_the_day(model) if mark == AT else model.tasks.flows)
    }
    if part not in has:
        begun = (
            part_or_flow for part_or_flow in has if part_or_flow.startswith(part[: len("11:30")])
        )  # similar spelling does not mean similar times
        near = next(begun, None) if mark == AT else nearest(part, has)
        parts = f"expected {spoken(has, 'or')}" if has else "the model has none"
        meant = f"did you mean '{base}{mark}{near}'?" if near else parts
        raise StudyError(f"indicator {name!r}: no such {'part of the day' if mark == AT else 'flow'}, {meant}")


def look_up(name: str) -> Indicator | None:
    """Return an indicator by its name, also for a flow or a part of the day (`split`); None if it is unknown."""
    base, mark, part = split(name)
    indicator = INDICATORS.get(base)
    if not mark or indicator is None:
        return indicator
    has = indicator.by_time if mark == AT else indicator.by_flow
    return indicator.of(mark, part) if has and part else None


def part_in_words(part: str) -> str:
    """Return a part of the day in words: `11:30 to 13:00`."""
    return part.replace("-", " to ")


def split(name: str) -> tuple[str, str, str]:
    """Split an indicator's name into three parts: `on_time`, `:`, `outbound`, or `on_time`, `@`, `11:30-13:00`."""
    return name.partition(AT if AT in name.partition(":")[0] else ":")


def within(name: str) -> tuple[float, float]:
    """Return the range of an indicator by its name (`Indicator.within`); unbounded for an unknown name."""
    indicator = look_up(name)
    return (-math.inf, math.inf) if indicator is None else indicator.within


def is_count(name: str) -> bool:
    """Whether an indicator counts events or tasks; not for an unknown name."""
    indicator = look_up(name)
    return indicator is not None and indicator.is_count


def is_measured(name: str) -> bool:
    """Whether an indicator is a measurement, such as a time or a cost, which two designs do not share by chance."""
    indicator = look_up(name)
    return indicator is not None and indicator.unit in _MEASURED


def is_of_due(name: str) -> bool:
    """Whether an indicator is a share of the tasks, load units or orders that come due."""
    indicator = look_up(name)
    return indicator is not None and indicator.unit in _COUNTS


def depends_on_length(name: str) -> bool:
    """Whether an indicator depends on the run length where work piles up: times of tasks, shares in time."""
    return is_of_due(name) or name.startswith(_OF_TASKS)


def counted_in(name: str, has: Collection[str]) -> list[str]:
    """Return the names of indicators that count the whole of a share of tasks or orders; empty for other indicators.

    `has`: the names that the run has. Versions before 0.4.0 counted all tasks of the flows with due times.
    """
    indicator = look_up(name)
    base, mark, flow = split(name)
    if indicator is None or indicator.unit not in _COUNTS:
        return []
    due, done = _COUNTS[indicator.unit]
    if f"{due}{mark}{flow}" in has:
        return [f"{due}{mark}{flow}"]
    flows = [flow] if flow else [other.partition(":")[2] for other in has if other.startswith(f"{base}:")]
    return [f"{done}:{flow_name}" for flow_name in flows] or [done]


def find(name: str) -> Indicator:
    """Return an indicator by its name; raise StudyError, with the nearest name, if it is unknown."""
    indicator = look_up(name)
    if indicator is None:
        raise StudyError(f"indicator {name!r}: there is none, {hint(name, INDICATORS)}")
    return indicator
