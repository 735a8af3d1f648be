"""Flows: goods brought from place to place, when, and how. Several run at once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import PurePath
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)

from desim_warehouse.errors import did_you_mean, got, spoken
from desim_warehouse.layout.spec import NodeOrStation, NodesOfStations
from desim_warehouse.model.sections.departures import DUE_AT, DueAt
from desim_warehouse.model.sections.goods import DUE, PopularityRule, is_drawn
from desim_warehouse.model.sections.lines import Lines, lines_in_words, mean_lines, shares_of
from desim_warehouse.values.calendars import ALWAYS, CalendarName, Hours, clock_of
from desim_warehouse.values.distributions import Varying
from desim_warehouse.values.fields import (
    SECTION,
    Count,
    Duration,
    Forms,
    Integer,
    Name,
    NotNegative,
    Part,
    Quantity,
    Rate,
    Share,
    Time,
    Unit,
    Usual,
    at_most,
    by_type,
    form,
    known,
    limited,
    see_kinds,
    see_sum,
    wrong,
)

STORAGE = "storage"
HourlyRate = Annotated[NotNegative, limited("hourly"), Quantity("rate")]
ORDER_COLUMNS = ("release", "from", "via", "to", "due", "priority", "quantity", "order", "item")
_ENDS = {
    "from": "where loads are picked: 'storage', or names of stations or nodes",
    "to": "where they are brought: 'storage', or names of stations or nodes",
}


# When


class PoissonArrivals(Part):
    """`poisson: n`: at random, n per hour on average."""

    poisson: Annotated[Rate, limited("hourly")] = Field(title="tasks", description="tasks per hour")

    def is_random(self, _model: Any) -> bool:
        """Return True: tasks arrive at random."""
        return True


class SaturatedArrivals(Part):
    """`saturated: n`: n tasks are always open, a new one is released as one is taken."""

    saturated: Annotated[Count, limited("open")] = Field(title="open tasks", description="number of open tasks")


class Profile(Part):
    """Rates that follow one another, and then repeat.

    If they cover 24 hours, they are those of a day from midnight, and the run begins with the rate at `run.start`, as
    calendars do. Others begin with the run.
    """

    per_hour: tuple[HourlyRate, ...] = Field(
        min_length=1,
        title="tasks",
        description="tasks per hour, one rate after the other; rates that cover 24 hours begin at midnight, by the "
        "clock of run.start, others at the start of the run",
    )
    every: Annotated[Duration | None, Usual("5 min", "7 d")] = Field(
        None, title="time for each rate", description="how long each rate lasts; default: an hour"
    )

    @field_validator("per_hour")
    @classmethod
    def _some(cls, rates: tuple[float, ...]) -> tuple[float, ...]:
        if not any(rates):
            raise wrong("all rates are 0, expected one above 0")
        return rates


class ProfileArrivals(Part):
    """`profile: {per_hour: [20, 60, 40]}`: at random, at a rate that changes with the time of day."""

    profile: Profile = Field(description="the rates")

    def is_random(self, _model: Any) -> bool:
        """Return True: tasks arrive at random."""
        return True


class Batch(Part):
    """Tasks released at one time, as a lorry brings or fetches them."""

    at: Annotated[Time, Usual("1 min", instant=True)] = Field(
        title="release time", description="when they are released, from the start of the run"
    )
    tasks: Annotated[Count, limited("tasks")] = Field(1, description="how many")


class ScheduleArrivals(Part):
    """`schedule: [{at: 1 h, tasks: 30}]`: these numbers at these times only."""

    schedule: tuple[Batch, ...] = Field(min_length=1, description="times, and how many tasks at each")

    def times(self, demand: float) -> list[tuple[float, int]]:
        """Return the times in order, and how many tasks at each, `demand` times as many, their sum rounded."""
        waves, asked, released = [], 0, 0
        for batch in sorted(self.schedule, key=lambda batch: batch.at):
            asked += batch.tasks
            waves.append((batch.at, round(asked * demand) - released))
            released = round(asked * demand)
        return waves


class OrdersFile(Part):
    """Orders, one per row, in the table that `desim orders` writes.

    Its columns: release, from, via, to, due, priority, quantity, order. Only release is required, and no others are
    allowed. Times are numbers from the start of the run, times of day or ISO dates with times (see run.start); from and
    to name nodes, stations or storage places (by number or name), via several, as `B > C`; quantity is the number of
    tasks. With pods, item is what a line asks for, and from and to name stations. Exports of other programs are
    refused, with the command that converts them.
    """

    file: Name = Field(description="CSV (UTF-8, commas) or Parquet file, relative to the model file")
    resample: Annotated[Duration | None, Usual("5 min", "7 d")] = Field(
        None,
        title="stretch of orders drawn anew",
        description="redraw the orders of each period of this length from those in it: replications differ, and the "
        "pattern of the day stays",
    )
    sha256: Name | None = Field(None, description="digest of the file, filled in when it is read")


class OrdersArrivals(Part):
    """`orders: {file: orders.csv}`: as in a file that `desim orders` wrote."""

    orders: OrdersFile = Field(description="the file")

    def is_random(self, _model: Any) -> bool:
        """Return True: rows may leave to chance where a load comes from; whether they do, a run knows."""
        return True


def _arrivals_form(value: Any) -> str | None:
    keys = next(iter(type(value).model_fields)) if isinstance(value, Part) else value
    return next((f"\0{key}" for key in _ARRIVALS if isinstance(keys, str | Mapping) and key in keys), None)


# From where, to where


class StorageEnd(Part):
    """A storage place, drawn for each task."""

    popularity: PopularityRule | None = Field(None, description="default: tasks.popularity")

    def is_random(self, model: Any) -> bool:
        """Whether there is more than one place to draw."""
        return is_drawn(self.popularity or model.tasks.popularity, model)


def _short_end(value: Any) -> Any:
    """`storage` is any storage place. One name is a list of one."""
    if value == STORAGE:
        return StorageEnd()
    return (value,) if isinstance(value, str) else value


_ARRIVALS: dict[str, type[Part]] = {
    next(iter(kind.model_fields)): kind
    for kind in (PoissonArrivals, SaturatedArrivals, ProfileArrivals, ScheduleArrivals, OrdersArrivals)
}

Arrivals = Annotated[
    Annotated[PoissonArrivals, form("poisson")]
    | Annotated[SaturatedArrivals, form("saturated")]
    | Annotated[ProfileArrivals, form("profile")]
    | Annotated[ScheduleArrivals, form("schedule")]
    | Annotated[OrdersArrivals, form("orders")],
    Forms(
        "{poisson: n per hour}, {saturated: n}, {profile: {per_hour: [...]}}, {schedule: [{at, tasks}]} or "
        "{orders: {file: ...}}",
        pick=_arrivals_form,
    ),
]

End = Annotated[
    Annotated[NodesOfStations, Field(min_length=1), form("nodes")] | Annotated[StorageEnd, form("storage")],
    Forms(
        "'storage', names of stations or nodes, or {popularity: ...} for storage places by popularity",
        {"type": "string"},
        pick=by_type(nodes=(list, tuple), storage=SECTION),
    ),
    BeforeValidator(_short_end),
]
"""Where tasks of a flow begin or end: at one of some nodes, or at a storage place."""


class Pair(Part):
    """A cell of a from-to matrix: how many tasks an hour go from one place to another."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True, defer_build=True)

    source: End = Field(alias="from", description="where they begin")
    target: End = Field(alias="to", description="where they end")
    per_hour: Annotated[NotNegative, Unit("rate")] = Field(title="tasks", description="tasks per hour")


class MatrixFile(Part):
    """A from-to matrix as CSV: a row for each origin, a column for each destination, in the cells tasks per hour."""

    file: Name = Field(description="CSV file, relative to the model file; the first column names the origins")


# How


class PriorityShare(Part):
    """A part of a flow's tasks with one priority."""

    priority: Integer = Field(description="higher first")
    share: Share = Field(title="share of tasks", description="part of the tasks")


class Route(NamedTuple):
    """From where to where tasks of a flow go, and their part of the flow."""

    source: tuple[str, ...] | StorageEnd
    target: tuple[str, ...] | StorageEnd
    share: float


def _few_stops(stops: tuple[str, ...]) -> tuple[str, ...]:
    at_most("stops", len(stops))
    return stops


class FlowSpec(Part):
    """Tasks of one kind: from where to where, when they are asked for, and how they are done."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True, defer_build=True)

    source: End | None = Field(None, alias="from", description="where loads are picked")
    target: End | None = Field(None, alias="to", description="where they are brought")
    from_to: Annotated[
        tuple[Pair, ...],
        Forms("a list of pairs (from, to, per_hour), or {file: from_to.csv}", MatrixFile),
    ] = Field((), description="instead of from and to: a from-to matrix")
    arrivals: Arrivals | None = Field(
        None, description="when tasks are released; default for from_to: at random, at its rates"
    )
    load_time: Annotated[Varying | None, Usual("1 s", "1 h")] = Field(None, description="default: tasks.load_time")
    unload_time: Annotated[Varying | None, Usual("1 s", "1 h")] = Field(None, description="default: tasks.unload_time")
    unload_per: Literal["line", "order"] = Field(
        "line",
        title="unloading for each",
        description="what unload_time applies to: each line, or all lines of an order that a robot brings together, "
        "as in a tote that is handed over whole",
    )
    due_within: Annotated[Duration | None, DUE] = Field(
        None, title="time until due", description="time from release to due"
    )
    due_at: Annotated[DueAt, DUE_AT] = Field(
        (),
        title="times due",
        description="due at the next of these times, such as departures of lorries: by the clock, every day (`10:00`), "
        "or from the start of the run (`4 h`), in order",
    )
    priority: Annotated[
        Annotated[Integer, form("number")] | Annotated[tuple[PriorityShare, ...], Field(min_length=1), form("shares")],
        Forms(
            "a whole number, or a list of priorities and shares",
            pick=by_type(number=(int, float), shares=(list, tuple)),
        ),
    ] = Field(0, description="higher first, for policies that use it; or several, each for a share of the tasks")
    kinds: tuple[Name, ...] = Field((), description="kinds of robots (fleet.kinds) that do it; default: all robots")
    via: Annotated[tuple[NodeOrStation, ...], AfterValidator(_few_stops)] = Field(
        (), description="stops in between with the load, in order: nodes or names of stations"
    )
    stop_time: Annotated[Varying, Usual("1 s", "1 h")] = Field(0.0, description="handling at each stop of via")
    hours: CalendarName | None = Field(
        None,
        description="a calendar of when tasks are released; those that a schedule or a file has outside it are "
        "released when it opens; default: at all times",
    )
    load_type: Name | None = Field(
        None, description="type of its loads, for robots that carry it (carries); default: for all robots"
    )
    lines: Lines = Field(
        1,
        title="lines of an order",
        description="lines of an order, each a task: a number, [least, most] with all equally likely, or discrete "
        "values and weights; with more than one line, rates and schedules count orders",
    )

    @field_validator("priority")
    @classmethod
    def _sum(cls, priority: int | tuple[PriorityShare, ...]) -> int | tuple[PriorityShare, ...]:
        if isinstance(priority, tuple):
            see_sum(part.share for part in priority)
        return priority

    @field_validator("kinds")
    @classmethod
    def _of_the_fleet(cls, kinds: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
        see_kinds(enumerate(kinds), known(info).kinds)
        return kinds

    @field_validator("load_type")
    @classmethod
    def _is_carried(cls, load_type: str | None, info: ValidationInfo) -> str | None:
        by_kind, kinds = known(info).carries, info.data.get("kinds", ())
        if load_type is None or by_kind is None:
            return load_type
        carried = [types for kind, types in by_kind.items() if not kinds or kind in kinds]
        if carried and not any(load_type in types or not types for types in carried):
            carried_types = tuple(dict.fromkeys(name for types in carried for name in types))
            hint = did_you_mean(load_type, carried_types)
            whose = f"robots of {spoken(kinds, 'or')}" if kinds else "robots"
            raise wrong(f"no robot carries it (got {got(load_type)}), {whose} carry {spoken(carried_types)}{hint}")
        return load_type

    @model_validator(mode="after")
    def _whole(self) -> FlowSpec:
        ends = {"from": self.source, "to": self.target}
        for key, end in ends.items():
            if self.from_to and end is not None:
                raise wrong("given together with from_to, expected one of the two", key)
            if not self.from_to and end is None:
                raise wrong(f"missing, expected {_ENDS[key]}", key)
        if self.arrivals is None and not self.from_to:
            raise wrong("missing, expected when tasks are asked for, such as {poisson: 40}", "arrivals")
        if self.from_to and not any(pair.per_hour for pair in self.from_to):
            raise wrong("all rates are 0, expected one above 0", "from_to")
        if self.hours is not None and isinstance(self.arrivals, SaturatedArrivals):
            text = f"{self.arrivals.saturated} tasks are always open, expected hours of the fleet or of stations"
            raise wrong(text, "hours")
        if self.due_at and self.due_within is not None:
            raise wrong("given together with due_within, expected one of the two", "due_at")
        for pair in self.routes:
            to_itself = isinstance(pair.source, tuple) and pair.source == pair.target and len(pair.source) == 1
            if isinstance(pair.source, tuple) and to_itself and not self.via:
                raise wrong(f"from a node to itself (got {got(pair.source[0])}), expected two places", "to")
        return self

    @model_validator(mode="after")
    def _counts_orders(self) -> FlowSpec:
        for key, is_given in (("from_to", self.from_to), ("arrivals", isinstance(self.when, OrdersArrivals))):
            if is_given and self.lines != 1:
                counts = "tasks, not orders" if key == "from_to" else "rows, each a line already (column order)"
                raise wrong(f"lines of an order beside {key}, which counts {counts}; leave it out", "lines")
        return self

    @model_validator(mode="after")
    def _hands_over_whole(self) -> FlowSpec:
        if self.unload_per == "order" and any(isinstance(route.target, StorageEnd) for route in self.routes):
            raise wrong("each line is put away at a storage place of its own, expected line", "unload_per")
        return self

    @property
    def routes(self) -> tuple[Route, ...]:
        """From where to where, and the part of the tasks of each. Without a matrix there is a single one."""
        if not self.from_to:
            assert self.source is not None
            assert self.target is not None
            return (Route(self.source, self.target, 1.0),)
        total = math.fsum(pair.per_hour for pair in self.from_to)
        return tuple(Route(pair.source, pair.target, pair.per_hour / total) for pair in self.from_to if pair.per_hour)

    @property
    def when(self) -> PoissonArrivals | SaturatedArrivals | ProfileArrivals | ScheduleArrivals | OrdersArrivals:
        """When tasks arrive, by default as often as the matrix says."""
        if self.arrivals is None:
            return PoissonArrivals(poisson=math.fsum(pair.per_hour for pair in self.from_to))
        return self.arrivals

    def is_random(self, model: Any) -> bool:
        """Whether chance decides when its tasks come, from where they come, how urgent they are, or how long they take.

        Nodes of a target are no draw: which of them is decided when a robot gets the task.
        """
        routes = self.routes
        from_several = any(isinstance(route.source, tuple) and len(route.source) > 1 for route in routes)
        drawn = from_several or len(routes) > 1 or isinstance(self.priority, tuple)
        drawn = drawn or len(shares_of(self.lines)) > 1
        return drawn or self.when.is_random(model) or super().is_random(model)

    @property
    def may_end_at_several(self) -> bool:
        """Whether tasks of the flow end at one of several nodes."""
        return any(isinstance(route.target, tuple) and len(route.target) > 1 for route in self.routes)

    @property
    def scheduled(self) -> int:
        """The most tasks that a schedule asks for."""
        most = max(shares_of(self.lines))
        return most * sum(batch.tasks for batch in self.when.schedule) if isinstance(self.when, ScheduleArrivals) else 0

    @property
    def mean_lines(self) -> float:
        """The mean number of tasks of an order; 1 where tasks are asked for one by one."""
        return mean_lines(self.lines)

    @property
    def may_stop(self) -> bool:
        """Whether tasks of the flow may stop on their way: they do, or rows of its orders may say so."""
        return bool(self.via) or isinstance(self.arrivals, OrdersArrivals)

    @property
    def never_ends(self) -> bool:
        """Whether tasks of this flow are released without end."""
        when = self.when
        if isinstance(when, OrdersArrivals):
            return when.orders.resample is not None
        return not isinstance(when, ScheduleArrivals)


def ends_of_storage(flows: Iterable[FlowSpec]) -> tuple[tuple[str, ...], bool]:
    """Return the nodes that loads from storage go to, and True; if there are none, where they come from, and False."""
    ends = [(route.source, route.target) for flow in flows for route in flow.routes]
    targets = [target for source, target in ends if isinstance(source, StorageEnd) and isinstance(target, tuple)]
    sources = [source for source, target in ends if isinstance(target, StorageEnd) and isinstance(source, tuple)]
    return tuple(dict.fromkeys(node for nodes in targets or sources for node in nodes)), bool(targets)


def in_words(flow: FlowSpec, demand: float) -> str:
    """Describe a flow in a few words, such as `dock to storage, 40 tasks an hour`, with its rate times `demand`."""
    (first, *more) = flow.routes
    way = f"{_named(first.source)} to {_named(first.target)}" if not more else f"{len(flow.routes)} from-to pairs"
    way += f" by way of {spoken(flow.via)}" if flow.via else ""
    when, what = flow.when, "tasks" if flow.lines == 1 else "orders"
    if isinstance(when, PoissonArrivals):
        arrivals = f"{when.poisson * demand:g} {what} an hour"
    elif isinstance(when, SaturatedArrivals):
        arrivals = f"{when.saturated} tasks always open"
    elif isinstance(when, ProfileArrivals):
        rates = when.profile.per_hour
        arrivals = f"{min(rates) * demand:g} to {max(rates) * demand:g} {what} an hour by a profile"
    elif isinstance(when, OrdersArrivals):
        arrivals = f"orders from {PurePath(when.orders.file).name}"
        arrivals += f", {demand:g} times as many" if demand != 1 and not fixed_orders(flow) else ""
    else:
        arrivals = f"{sum(tasks for _, tasks in when.times(demand))} {what} by a schedule"
    return f"{way}, {arrivals}" if flow.lines == 1 else f"{way}, {arrivals}, {lines_in_words(flow.lines)}"


def _named(end: tuple[str, ...] | StorageEnd) -> str:
    return STORAGE if isinstance(end, StorageEnd) else spoken(end, "or")


def mean_rate(flow: FlowSpec, length: float, hour: float, start: str, hours: Hours = ALWAYS) -> float | None:
    """Return the tasks an hour over the first `length` of a run; None for as many as can be done or as a file says.

    `start`: the time of day at which the run starts. `hours`: the calendar of the flow.
    """
    when = flow.when
    if isinstance(when, PoissonArrivals):
        return when.poisson * flow.mean_lines * hours.share(0.0, length)
    if isinstance(when, ProfileArrivals):
        expected = Rates(when.profile, hour, start).expected
        orders = math.fsum(expected(b) - expected(a) for a, b in hours.between(0.0, length))
        return orders * flow.mean_lines / length * hour
    if isinstance(when, ScheduleArrivals):
        return sum(batch.tasks for batch in when.schedule if batch.at <= length) * flow.mean_lines / length * hour
    return None


def fixed_orders(flow: FlowSpec) -> bool:
    """Whether tasks of a flow are the rows of a file as they stand there, so that no demand multiplies them."""
    return isinstance(flow.when, OrdersArrivals) and flow.when.orders.resample is None


class Rates:
    """A profile of arrival rates, and how many tasks it makes by a time. It begins anew when it is over.

    `start` is the run's. `phase` is where in the profile the run begins: by the clock if it covers 24 hours.
    """

    def __init__(self, profile: Profile, hour: float, start: str, demand: float = 1.0) -> None:
        self.every = hour if profile.every is None else profile.every
        self.by_clock = math.isclose(self.every * len(profile.per_hour), 24 * hour)
        self.phase = clock_of(start) / 3600 * hour if self.by_clock else 0.0
        self.rates = [rate * demand / hour for rate in profile.per_hour]
        self.sums = [0.0]
        for rate in self.rates:
            self.sums.append(self.sums[-1] + rate * self.every)
        self.before = self._from_first(self.phase)

    def expected(self, time: float) -> float:
        """Return the mean number of tasks by a time."""
        return self._from_first(self.phase + time) - self.before

    def changes(self, end: float) -> list[float]:
        """Return the times of a run up to its `end` at which a rate begins."""
        first = -self.phase % self.every
        return [first + n * self.every for n in range(int((end - first) / self.every) + 1)]

    def _from_first(self, time: float) -> float:
        """Return the mean number of tasks from the start of the profile to a time after it, through all its rounds."""
        rounds, rest = divmod(time, self.every * len(self.rates))
        step = min(int(rest // self.every), len(self.rates) - 1)
        return rounds * self.sums[-1] + self.sums[step] + (rest - step * self.every) * self.rates[step]

    def when(self, tasks: float) -> float:
        """Return the time by which a number of tasks is expected: the inverse of `expected`.

        A Poisson process of rate 1, taken through it, is one with these rates (Cinlar, Introduction to Stochastic
        Processes, 1975): arrival by arrival the same chance, whatever the rates.
        """
        from bisect import bisect_left

        rounds, rest = divmod(self.before + tasks, self.sums[-1])
        step = max(bisect_left(self.sums, rest) - 1, 0)
        while not self.rates[step]:  # rest is 0: the first step in which there are tasks
            step += 1
        whole = rounds * self.every * len(self.rates) + step * self.every
        return whole + (rest - self.sums[step]) / self.rates[step] - self.phase
