"""The one list of indicators of a run.

An indicator is added by adding it to `INDICATORS`, here: its name, unit, meaning, which direction is better, how it is
computed from the history of a run, and where it applies. Runs, studies, targets, reports, figures, the command line
and the reference in the documentation all read this list.
"""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from desim_warehouse.errors import StudyError, nearest
from desim_warehouse.outcome import money
from desim_warehouse.states import APART, BROKEN, OPERATING, SERVER, TIMES, names

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from desim_warehouse.outcome.history import FlowHistory, History, Trip
    from desim_warehouse.states import State

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
    "share of orders",
    "share of fleet time",
    "share of charger time",
    "share of capacity",
    "share of people's time",
    "encounters per hour",
    "ratio",
    "share of operating time",
]
Better = Literal["less", "more"]
_QUEUEING = names(lambda state: state.queue == SERVER)
ROUNDING = 1e-9
"""Part by which sums of energy may differ and still be the same."""


@dataclass(frozen=True)
class Indicator:
    """A figure by which a run is judged.

    `title`: for people, on axes and in reports. `unit`: its kind of unit. The model says what time and length are
    counted in. `meaning`: for the reference. `better`: whether less or more of it is better, None: neither by itself.
    `compute`: its value, counted from the end of the warm-up to the end of the run. `applies`: whether a run has it.
    `by_flow`: where tasks flow, each flow has it too, under `NAME:FLOW`, from the flow's own tasks. `signed`: whether
    it can be less than 0.
    """

    name: str
    title: str
    unit: Unit
    meaning: str
    better: Better | None
    compute: Callable[[History], float]
    applies: Callable[[History], bool] = lambda _: True
    by_flow: Callable[[FlowHistory], float] | None = None
    signed: bool = False

    def of_flow(self, flow: str) -> Indicator:
        """The indicator of one flow."""
        return replace(self, name=f"{self.name}:{flow}", title=f"{self.title}, {flow}", by_flow=None)

    @property
    def is_share(self) -> bool:
        """Whether it is a share, at most 1 and shown in per cent."""
        return self.unit.startswith("share")


def _total(tally: str) -> Callable[[History], float]:
    return lambda history: history.totals[tally]


def _count(tally: str) -> Callable[[History], int]:
    return lambda history: int(history.totals[tally])


def _collisions(history: History) -> int:
    """Waiting episodes, however often a robot would stop and start in one. Counted in steps, S grows without limit."""
    return int(history.totals["rear_ends"] + history.totals["crossings"])


def _cost(history: History) -> float:
    """The paper's outlook: distance x w_d + time x w_t + S x w_c, with the counted time (without a warm-up T)."""
    weights, distance = history.model.cost, history.totals["distance"]
    return distance * weights.distance + history.counted * weights.time + _collisions(history) * weights.collisions


def _rotations(history: History) -> int:
    return sum(1 for ring in history.rotations if history.counts(ring.time))


def _throughput(history: History) -> float:
    hours = history.counted / history.model.units.hour
    return history.totals["delivered"] / hours if hours else math.nan


def _share(state: str) -> Callable[[History], float]:
    def compute(history: History) -> float:
        time = history.counted * len(history.log.robots)
        return history.totals[state] / time if time else math.nan

    return compute


def _tasks_of_flow(flow: FlowHistory) -> float:
    return len(flow.counted_deliveries)


def _throughput_of_flow(flow: FlowHistory) -> float:
    return len(flow.counted_deliveries) / flow.hours if flow.hours else math.nan


def _backlog(tasks: History | FlowHistory) -> float:
    return len(tasks.tasks) - len(tasks.delivered)


def _cycle_time(tasks: History | FlowHistory) -> float:
    return _mean(tasks.cycle_times)


def _cycle_time_median(tasks: History | FlowHistory) -> float:
    return quantile(tasks.cycle_times, 0.5)


def _cycle_time_p95(tasks: History | FlowHistory) -> float:
    return quantile(tasks.cycle_times, 0.95)


def _cycle_time_cv(history: History) -> float:
    times = history.cycle_times
    return statistics.stdev(times) / statistics.fmean(times) if len(times) > 1 else math.nan


def _tardiness(tasks: History | FlowHistory) -> float:
    return _mean(tasks.lateness)


def _on_time(tasks: History | FlowHistory) -> float:
    return _mean([not late for late in tasks.lateness])


def _mean(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values) if values else math.nan


def quantile(ordered: Sequence[float], part: float) -> float:
    """Linear interpolation between order statistics, as numpy's default (kept here to start up without numpy)."""
    if not ordered:
        return math.nan
    place = part * (len(ordered) - 1)
    low = math.floor(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (place - low) * (ordered[high] - ordered[low])


def _backlog_growth(history: History) -> float:
    """Tasks released less tasks delivered in the counted time, an hour."""
    hours = history.counted / history.model.units.hour
    released = sum(1 for task in history.tasks.values() if history.counts(task.released))
    return (released - len(history.counted_deliveries)) / hours if hours else math.nan


def _energy_lowest(history: History) -> float:
    battery = history.model.battery
    return math.nan if battery is None else history.lowest_energy / battery.capacity


def _energy_drift(history: History) -> float:
    """Energy charged minus energy drawn, 0 where the two differ by rounding alone."""
    battery, hours = history.model.battery, history.counted / history.model.units.hour
    if battery is None or not hours:
        return math.nan
    charged, drawn = history.charged, history.totals["energy"]
    gained = 0.0 if math.isclose(charged, drawn, rel_tol=ROUNDING) else charged - drawn
    return gained / (battery.capacity * history.model.fleet.size) / hours


def _charger_utilisation(history: History) -> float:
    time = history.chargers * history.counted
    used = math.fsum(history.within(one.start, one.end) for one in history.chargings)
    return used / time if time else math.nan


def _time_in(history: History, states: Iterable[str]) -> float:
    """What all robots together have spent in some states; in those that the model does not have, nothing."""
    return math.fsum(history.totals.get(state, 0.0) for state in states)


def _availability(history: History) -> float:
    operating, broken = _time_in(history, OPERATING), _time_in(history, BROKEN)
    return operating / (operating + broken) if operating + broken > 0 else math.nan


def _breaks_down(history: History) -> bool:
    return history.model.fleet.breaks_down


def _station_wait(history: History) -> float:
    """Robots queue for a server or for a charger. Rounding may leave these sums just below 0."""
    return max(_time_in(history, _QUEUEING) - history.charger_wait, 0.0)


def _has_prices(history: History) -> bool:
    return history.model.prices is not None


def _has_batches(history: History) -> bool:
    return history.model.policies.batching.name != "single"


def _counted_trips(history: History) -> list[Trip]:
    return [trip for trip in history.trips if history.counts(trip.end)]


def _has_orders(history: History) -> bool:
    return bool(history.log.orders)


def _lateness_of_orders(history: History) -> list[float]:
    return [order.lateness for order in history.counted_orders if order.lateness is not None]


def _has_arrivals(history: History) -> bool:
    return history.model.tasks.arrive


def _has_batteries(history: History) -> bool:
    return history.model.battery is not None


def _has_chargers(history: History) -> bool:
    return _has_batteries(history) and history.chargers > 0


def _has_stations(history: History) -> bool:
    return bool(history.layout.stations)


def _has_tally(name: str) -> Callable[[History], bool]:
    """Whether robots counted something, as their model has it."""
    return lambda history: name in history.totals


def _encounters(history: History) -> float:
    hours = history.counted / history.model.units.hour
    return history.totals["encounters"] / hours if hours else math.nan


def _shared_time(history: History) -> float:
    people = history.log.people
    return people["shared"] / people["time"] if people["time"] else math.nan


def _has_due_times(tasks: History | FlowHistory) -> bool:
    return bool(tasks.lateness)


def _share_of(state: State) -> Indicator:
    """The share of the fleet's time in a state. Waiting in traffic is counted apart, and they add up to 1."""
    return Indicator(
        f"share_{state.name}",
        f"Fleet {state.doing}",
        "share of fleet time",
        state.time,
        state.better,
        _share(state.name),
        lambda history: state.applies(history.model),
    )


def _waited_apart(state: State) -> Indicator:
    """The time of a wait in traffic that is no collision."""
    return Indicator(
        state.name,
        f"Time {state.doing}",
        "time",
        f"all robots together, no collisions: {state.time}",
        state.better,
        _total(state.name),
        lambda history: state.applies(history.model),
    )


INDICATORS = {
    indicator.name: indicator
    for indicator in (
        Indicator(
            "T",
            "Task time T",
            "time",
            "task time: when the last robot is back with all goods delivered; lifelong demand: the run's length",
            "less",
            lambda history: history.end,
        ),
        Indicator(
            "S",
            "Collisions S",
            "count",
            "collisions: waiting episodes of all robots, `rear_ends + crossings`",
            "less",
            _collisions,
        ),
        Indicator(
            "C",
            "Charge cycles C",
            "count",
            "charge cycles after which a robot went out again",
            "less",
            _count("recharged"),
        ),
        Indicator(
            "tasks",
            "Tasks delivered",
            "count",
            "tasks delivered",
            "more",
            _count("delivered"),
            by_flow=_tasks_of_flow,
        ),
        Indicator("moves", "Edges driven", "count", "edges driven", "less", _count("moves")),
        Indicator(
            "distance",
            "Distance driven",
            "length",
            "driven by all robots",
            "less",
            _total("distance"),
        ),
        Indicator("energy", "Energy drawn", "energy", "used by all robots", "less", _total("energy")),
        Indicator(
            "waiting",
            "Time waited in traffic",
            "time",
            "waited in traffic, all robots together",
            "less",
            _total("waiting"),
        ),
        *(_waited_apart(state) for state in APART.values()),
        Indicator(
            "encounters_per_hour",
            "Encounters of robots and people",
            "encounters per hour",
            "how often a person held a robot up before an aisle, or came into one with a robot in it; only with "
            "`people`",
            "less",
            _encounters,
            _has_tally("encounters"),
        ),
        Indicator(
            "shared_time",
            "Time shared with robots",
            "share of people's time",
            "share of the time of people in aisles in which a robot was in the same aisle; only with `people`",
            "less",
            _shared_time,
            _has_tally("encounters"),
        ),
        Indicator(
            "cost",
            "Cost",
            "weighted",
            "`w_d distance + w_t time + w_c S`, with the weights of the section `cost`; time: what is counted of T",
            "less",
            _cost,
        ),
        Indicator(
            "rear_ends",
            "Waits behind a robot on an edge",
            "count",
            "collisions behind a robot on the same edge",
            "less",
            _count("rear_ends"),
        ),
        Indicator(
            "crossings",
            "Waits before an intersection",
            "count",
            "collisions before an intersection",
            "less",
            _count("crossings"),
        ),
        Indicator("rotations", "Gridlock rotations", "count", "full rings that turned", "less", _rotations),
        Indicator(
            "throughput_per_hour",
            "Throughput",
            "tasks per hour",
            "`tasks / (counted time × units.seconds / 3600)`",
            "more",
            _throughput,
            by_flow=_throughput_of_flow,
        ),
        Indicator(
            "cycle_time_mean",
            "Cycle time, mean",
            "time",
            "from a task's release to its delivery, mean",
            "less",
            _cycle_time,
            by_flow=_cycle_time,
        ),
        Indicator(
            "cycle_time_median",
            "Cycle time, median",
            "time",
            "the same, median",
            "less",
            _cycle_time_median,
            by_flow=_cycle_time_median,
        ),
        Indicator(
            "cycle_time_p95",
            "Cycle time, 95 % quantile",
            "time",
            "the same, 95 % quantile (linear between order statistics)",
            "less",
            _cycle_time_p95,
            by_flow=_cycle_time_p95,
        ),
        Indicator(
            "cycle_time_cv",
            "Cycle time, coefficient of variation",
            "ratio",
            "the same, standard deviation / mean: how far tasks differ in time; only with `people`",
            "less",
            _cycle_time_cv,
            _has_tally("encounters"),
        ),
        Indicator(
            "backlog",
            "Backlog at the end",
            "tasks",
            "tasks released and not delivered, at the end",
            "less",
            _backlog,
            by_flow=_backlog,
        ),
        Indicator(
            "backlog_growth_per_hour",
            "Backlog growth",
            "tasks per hour",
            "tasks released less tasks delivered in the counted time, per hour; only where tasks arrive at random",
            "less",
            _backlog_growth,
            _has_arrivals,
            signed=True,
        ),
        Indicator(
            "tardiness_mean",
            "Tardiness, mean",
            "time",
            "mean of `max(delivery − due, 0)`; only where tasks have due times",
            "less",
            _tardiness,
            _has_due_times,
            by_flow=_tardiness,
        ),
        Indicator(
            "on_time",
            "Delivered on time",
            "share of tasks",
            "share of the tasks delivered by their due time; only where tasks have due times",
            "more",
            _on_time,
            _has_due_times,
            by_flow=_on_time,
        ),
        Indicator(
            "trips",
            "Trips",
            "count",
            "tours that ended with the delivery of their last task; only with `policies.batching`",
            None,
            lambda history: len(_counted_trips(history)),
            _has_batches,
        ),
        Indicator(
            "loads_per_trip",
            "Loads per trip",
            "tasks",
            "tasks done on one tour, mean; only with `policies.batching`",
            "more",
            lambda history: _mean([len(trip.tasks) for trip in _counted_trips(history)]),
            _has_batches,
        ),
        Indicator(
            "orders",
            "Orders delivered",
            "count",
            "orders of which the last task was delivered; only with orders from a file",
            "more",
            lambda history: len(history.counted_orders),
            _has_orders,
        ),
        Indicator(
            "order_cycle_time_mean",
            "Order cycle time, mean",
            "time",
            "from an order's release to the delivery of its last task, mean; only with orders from a file",
            "less",
            lambda history: _mean([order.cycle_time for order in history.counted_orders]),
            _has_orders,
        ),
        Indicator(
            "order_cycle_time_p95",
            "Order cycle time, 95 % quantile",
            "time",
            "the same, 95 % quantile; only with orders from a file",
            "less",
            lambda history: quantile(sorted(order.cycle_time for order in history.counted_orders), 0.95),
            _has_orders,
        ),
        Indicator(
            "orders_on_time",
            "Orders on time",
            "share of orders",
            "share of the orders with due times of which every task was delivered by its due time",
            "more",
            lambda history: _mean([not late for late in _lateness_of_orders(history)]),
            lambda history: bool(_lateness_of_orders(history)),
        ),
        Indicator(
            "energy_lowest",
            "Lowest battery level",
            "share of capacity",
            "lowest level of any robot's battery, as a share of its capacity; only with batteries",
            "more",
            _energy_lowest,
            _has_batteries,
            signed=True,  # with `battery.reserve`
        ),
        Indicator(
            "energy_drift_per_hour",
            "Battery drift",
            "capacity per hour",
            "change of the fleet's mean battery level over the counted time, as a share of the capacity per hour; only "
            "with batteries",
            "more",
            _energy_drift,
            _has_batteries,
            signed=True,
        ),
        Indicator(
            "charger_utilisation",
            "Charger utilisation",
            "share of charger time",
            "share of the time of all chargers in which a robot is charged; only with batteries and chargers",
            None,
            _charger_utilisation,
            _has_chargers,
        ),
        Indicator(
            "charger_wait",
            "Time queued for a charger",
            "time",
            "time in a bay waiting for a charger, all robots together; only with batteries and chargers",
            "less",
            lambda history: history.charger_wait,
            _has_chargers,
        ),
        Indicator(
            "station_wait",
            "Time queued for a server",
            "time",
            "time in a station waiting for a server, all robots together; only with stations",
            "less",
            _station_wait,
            _has_stations,
        ),
        Indicator(
            "breakdowns",
            "Breakdowns",
            "count",
            "breakdowns of robots; only with breakdowns",
            "less",
            _count("breakdowns"),
            _breaks_down,
        ),
        Indicator(
            "availability",
            "Availability",
            "share of operating time",
            "time in operation (driving, loading and unloading, waits not counted) as a share of that and the time in "
            "which robots are broken down; only with breakdowns",
            "more",
            _availability,
            _breaks_down,
        ),
        Indicator(
            "annual_cost",
            "Annual cost",
            "money per year",
            "robots, chargers, energy, servers and late orders at the prices of the section `prices`, for a year of "
            "its `hours` like the counted time; only with prices",
            "less",
            money.annual_cost,
            _has_prices,
        ),
        Indicator(
            "cost_per_task",
            "Cost per task",
            "money per task",
            "`annual_cost` by the tasks that such a year delivers; only with prices",
            "less",
            money.cost_per_task,
            _has_prices,
        ),
        *(_share_of(state) for state in TIMES.values()),
    )
}
"""By name, in the order of tables."""
_DUE = {"tardiness_mean", "on_time"}


def kpis(history: History) -> dict[str, float]:
    """All indicators that a run has, in the units of its model file."""
    found = {name: indicator.compute(history) for name, indicator in INDICATORS.items() if indicator.applies(history)}
    for flow in history.model.tasks.flows:
        tasks = history.of_flow(flow)
        for name, indicator in INDICATORS.items():
            if indicator.by_flow is not None and (name not in _DUE or tasks.lateness):
                found[f"{name}:{flow}"] = indicator.by_flow(tasks)
    return found


def look_up(name: str) -> Indicator | None:
    """An indicator of ours by its name, also of a flow (`on_time:outbound`), or None."""
    base, colon, flow = name.partition(":")
    indicator = INDICATORS.get(base)
    if not colon or indicator is None:
        return indicator
    return indicator.of_flow(flow) if indicator.by_flow is not None and flow else None


def within(name: str) -> tuple[float, float]:
    """The range of an indicator of ours: at least 0 unless it is signed, a share at most 1, others unbounded."""
    indicator = look_up(name)
    if indicator is None:
        return -math.inf, math.inf
    return -math.inf if indicator.signed else 0.0, 1.0 if indicator.is_share else math.inf


def find(name: str) -> Indicator:
    """An indicator by its name. Raises StudyError where there is none, naming the nearest."""
    indicator = look_up(name)
    if indicator is None:
        near = nearest(name, INDICATORS)
        hint = f"did you mean {near!r}?" if near else f"expected one of {', '.join(INDICATORS)}"
        raise StudyError(f"indicator {name!r}: there is none, {hint}")
    return indicator
