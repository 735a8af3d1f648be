"""Tasks of flows: their origins and destinations, and when each becomes known.

Every flow has a random stream of its own for each quantity drawn, so its tasks do not depend on other flows, robots or
policies.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterator
from itertools import repeat
from typing import TYPE_CHECKING, Any

from simpy.events import Timeout

from desim_warehouse.layout import Layout
from desim_warehouse.layout.layout import StoragePlace
from desim_warehouse.model import Model
from desim_warehouse.model.facts.places import only_place, place_shares
from desim_warehouse.model.schema import reading
from desim_warehouse.model.sections.flows import (
    STORAGE,
    FlowSpec,
    OrdersArrivals,
    PoissonArrivals,
    ProfileArrivals,
    SaturatedArrivals,
    ScheduleArrivals,
    StorageEnd,
)
from desim_warehouse.model.sections.lines import draw_lines
from desim_warehouse.model.sections.order_lines import OrderLine
from desim_warehouse.model.sections.orders import read, resampled, summary
from desim_warehouse.policies import StopPlace, Task
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.traffic.events import Clock, Steps

if TYPE_CHECKING:
    End = StorageEnd | tuple[str, ...]


TRIES = 20
"""The most draws of a storage place different from the first."""
BATCH = 1024
"""The number of draws made at a time."""


class Flows:
    """A source of the tasks of all flows, `total` of them or, if None, without end."""

    def __init__(self, env: Clock, model: Model, layout: Layout, streams: Streams) -> None:
        self.env = env
        self.flows = {name: _Flow(name, flow, model, layout, streams) for name, flow in model.tasks.flows.items()}
        self.total: int | None = None
        if not model.tasks.never_end:
            self.total = sum(flow.scheduled for flow in self.flows.values())
        self._number = 0

    def start(self, release: Callable[[Task], None]) -> None:
        """Pass the tasks known at the start of the run to `release`, and schedule the arrival of later tasks."""
        self.release = release
        for flow in self.flows.values():
            while flow.open < flow.always_open:
                self._release(flow)
            self.env.process(self._arrivals(flow))

    def taken(self, task: Task) -> None:
        """Note a task or tour in hand: where the number of open tasks is constant, another task replaces each."""
        flows = [self.flows[member.flow] for member in task.tasks]
        for flow in flows:
            flow.open -= 1
        for flow in flows:
            if flow.open < flow.always_open:
                self._release(flow)

    def returned(self, task: Task) -> None:
        """Note that a robot has given back a task or tour, which is open again."""
        for member in task.tasks:
            self.flows[member.flow].open += 1

    def _arrivals(self, flow: _Flow) -> Steps:
        for time, line in flow.releases():
            if time > self.env.now:
                yield Timeout(self.env, time - self.env.now)
            for _ in range(1 if line is None else line.quantity):
                self._release(flow, line)
        flow.ended = True

    def _release(self, flow: _Flow, line: OrderLine | None = None) -> None:
        for task in flow.order(self._number, self.env.now, line):
            self._number += 1
            flow.open += 1
            self.release(task)

    def to_come(self, task: Task, by_flow: bool) -> bool:
        """Whether further tasks will become known that may share a tour with a given one, perhaps only `by_flow`."""
        return any(
            not flow.ended
            and (flow.load_type, flow.spec.kinds) == (task.load_type, task.kinds)
            and (not by_flow or flow.name == task.flow)
            for flow in self.flows.values()
        )


class _Flow:
    """The source of the tasks of one flow, which are made one after the other."""

    def __init__(self, name: str, spec: FlowSpec, model: Model, layout: Layout, streams: Streams) -> None:
        self.name = name
        self.spec = spec
        self.when = spec.when
        self.hours = None if spec.hours is None else model.hours(spec.hours)
        self.layout = layout
        self.model = model
        self.streams = streams
        self.routes = spec.routes
        self.released = self.open = self._orders = 0
        self.ended = False
        self.load_type = spec.load_type or ""
        self.timetable = model.timetable(spec)
        self.items = None if model.pods is None else self._drawn_items(model.pods.item_shares)
        self._via = tuple(StopPlace(layout.nodes_of(name)) for name in spec.via)
        self._how = reading(model, layout)
        self._draws: dict[tuple[str, int, End], Iterator[int]] = {}
        self._cumulated = [math.fsum(route.share for route in self.routes[: i + 1]) for i in range(len(self.routes))]

    # Release times

    @property
    def always_open(self) -> int:
        """The number of tasks that are always open; 0 if they arrive."""
        return self.when.saturated if isinstance(self.when, SaturatedArrivals) else 0

    @property
    def scheduled(self) -> int:
        """The number of tasks of a flow that ends."""
        when = self.when
        if isinstance(when, OrdersArrivals):
            return summary(when.orders, self._how).tasks
        assert isinstance(when, ScheduleArrivals)
        orders = sum(tasks for _, tasks in when.times(self.model.tasks.demand))
        return orders if self.spec.lines == 1 else sum(map(self._lines, range(orders)))

    def releases(self) -> Iterator[tuple[float, OrderLine | None]]:
        """Iterate over the times at which tasks become known, in order, and their rows of orders.

        No task becomes known outside the hours of the flow. Random tasks that fall there are left out, which does not
        affect those within hours. Tasks of a schedule or a file are instead released when the hours begin.
        """
        hours = self.hours
        if hours is None:
            yield from self.asked_for()
            return
        at_random = isinstance(self.when, PoissonArrivals | ProfileArrivals)
        for time, line in self.asked_for():
            begin, _ = hours.following(time)
            if math.isinf(begin):
                return
            if begin <= time or not at_random:
                yield max(begin, time), line

    def asked_for(self) -> Iterator[tuple[float, OrderLine | None]]:
        """Yield the times at which tasks are requested, in order, and the rows of orders, regardless of hours."""
        when = self.when
        if isinstance(when, OrdersArrivals):
            lines = read(when.orders, self._how)
            width, demand = when.orders.resample, self.model.tasks.demand
            if width is not None:
                lines = resampled(lines, width, demand, lambda k: self.streams.stream(f"orders:{self.name}", k))
            yield from ((line.release, line) for line in lines)
        else:
            yield from ((time, None) for time in self.arrivals())

    def arrivals(self) -> Iterator[float]:
        """Iterate over the times at which tasks become known, in order.

        Random times are a Poisson process of rate 1, transformed by the expected number of tasks up to a time.
        """
        when, hour, demand = self.when, self.model.units.hour, self.model.tasks.demand
        if isinstance(when, SaturatedArrivals):
            return
        if isinstance(when, PoissonArrivals | ProfileArrivals):
            gaps = self.streams.stream(f"arrivals:{self.name}")
            rates = self.model.rates(when.profile, demand) if isinstance(when, ProfileArrivals) else None
            expected = 0.0
            while True:
                expected += float(gaps.exponential())
                if rates is not None:
                    yield rates.when(expected)
                elif isinstance(when, PoissonArrivals):
                    yield expected * hour / (when.poisson * demand)
        elif isinstance(when, ScheduleArrivals):
            for time, tasks in when.times(demand):
                for _ in range(tasks):
                    yield time

    # Tasks

    def order(self, number: int, now: float, line: OrderLine | None = None) -> list[Task]:
        """Make the lines of the next order, numbered from `number` on: one, unless the flow has orders of several."""
        if self.spec.lines == 1:
            return [self.task(number, now, line)]
        nth = self._orders
        self._orders += 1
        tasks = [self.task(number + rank, now) for rank in range(self._lines(nth))]
        return [task._replace(order=str(nth), priority=tasks[0].priority) for task in tasks]

    def _lines(self, nth: int) -> int:
        """Return the number of lines of the n-th order."""
        lines = self.spec.lines
        return lines if isinstance(lines, int) else draw_lines(lines, self.streams.stream(f"lines:{self.name}", nth))

    def task(self, number: int, now: float, line: OrderLine | None = None) -> Task:
        """Make the next task, which becomes known now. The flow provides what the row of its order leaves out."""
        nth = self.released
        self.released += 1
        if self.items is not None:
            return self._line(number, nth, now, line)
        which = 0 if len(self.routes) == 1 else bisect_left(self._cumulated, self._share("route") * self._cumulated[-1])
        route = self.routes[which]
        begins = self._end(None if line is None else line.source, route.source)
        ends = self._end(None if line is None else line.target, route.target)
        source, target, tries = self._place("from", which, begins), self._place("to", which, ends), TRIES
        while tries and source is target:  # both in storage: a place is no destination of itself, if there are others
            target, tries = self._place("to", which, ends), tries - 1
        if isinstance(source, str):
            good, edge, offset = -1, (source, source), 0.0
        else:
            good, edge, offset = source.number, source.edge, source.offset
        if isinstance(target, str):
            assert isinstance(ends, tuple)
            targets, drop = tuple(node for node in ends if node != source) or ends, None
        else:
            targets, drop = (target.edge[1],), (target.edge, target.offset)
        return Task(
            number,
            good,
            edge,
            offset,
            now,
            *self._terms(now, line),
            targets,
            drop,
            self.name,
            nth,
            self.spec.kinds,
            "" if line is None else line.order,
            self.load_type,
            self._via if line is None or line.via is None else tuple(self._stop(place) for place in line.via),
        )

    def _terms(self, now: float, line: OrderLine | None) -> tuple[float | None, int]:
        """Return when a task released now is due, and its priority."""
        due = self._due(now) if line is None or line.due is None else line.due
        return due, self._priority() if line is None or line.priority is None else line.priority

    def _line(self, number: int, nth: int, now: float, line: OrderLine | None) -> Task:
        """Make a line for pods: an item to be picked from a pod, or put onto one, at one of some stations."""
        assert self.items is not None
        route, named = self.routes[0], None if line is None else line.target
        nodes = route.target
        if isinstance(nodes, StorageEnd):
            nodes, named = route.source, None if line is None else line.source
        if isinstance(named, str) and named != STORAGE:
            nodes = self.layout.nodes_of(named)
        assert isinstance(nodes, tuple)
        return Task(
            number,
            -1,
            ("", ""),
            0.0,
            now,
            *self._terms(now, line),
            nodes,
            flow=self.name,
            nth=nth,
            kinds=self.spec.kinds,
            order="" if line is None else line.order,
            load_type=self.load_type,
            item=next(self.items) if line is None or line.item is None else line.item,
        )

    def _drawn_items(self, weights: Any) -> Iterator[int]:
        stream: Any = self.streams.stream(f"items:{self.name}")
        while True:
            yield from stream.choice(len(weights), BATCH, p=weights).tolist()

    def _stop(self, named: str | int) -> StopPlace:
        if isinstance(named, str):
            return StopPlace(self.layout.nodes_of(named))
        place = self.layout.storage[named]
        return StopPlace((place.edge[1],), (place.edge, place.offset))

    def _due(self, now: float) -> float | None:
        if self.spec.due_within is not None:
            return now + self.spec.due_within
        return self.timetable.next(now)

    def _priority(self) -> int:
        priority = self.spec.priority
        if isinstance(priority, int):
            return priority
        drawn, share = self._share("priority"), 0.0
        for part in priority:
            share += part.share
            if drawn < share:
                return part.priority
        return priority[-1].priority

    def _end(self, named: str | int | None, end: End) -> End | StoragePlace:
        """Return the place or places that the row of an order names, or otherwise the places of the flow."""
        if named is None:
            return end
        if isinstance(named, int):
            return self.layout.storage[named]
        return StorageEnd() if named == STORAGE else self.layout.nodes_of(named)

    def _place(self, end: str, which: int, places: End | StoragePlace) -> str | StoragePlace:
        """Draw a storage place, or take one of some nodes (a destination is chosen when a robot gets the task)."""
        if isinstance(places, StoragePlace):
            return places
        if isinstance(places, StorageEnd):
            return self.layout.storage[self._drawn(end, which, places)]
        if len(places) == 1 or end == "to":
            return places[0]
        return places[self._drawn(end, which, places)]

    # Draws

    def _share(self, what: str) -> float:
        """Draw a number from 0 to 1 for the present task."""
        return float(self.streams.stream(f"{what}:{self.name}", self.released).random())

    def draw_from(self, end: str, which: int, places: End, numbers: Iterator[int]) -> None:
        """Choose the origins or destinations of a route by given numbers instead of random ones."""
        self._draws[end, which, places] = numbers

    def _drawn(self, end: str, which: int, places: End) -> int:
        key = end, which, places
        if key not in self._draws:
            self._draws[key] = self._numbers(end, which, places)
        return next(self._draws[key])

    def _numbers(self, end: str, which: int, places: End) -> Iterator[int]:
        if isinstance(places, StorageEnd):
            only = only_place(self.model, self.layout, places)
            if only is not None:
                yield from repeat(only)
            size, weights = len(self.layout.storage), place_shares(self.model, self.layout, places)
        else:
            size, weights = len(places), None
        stream: Any = self.streams.stream(f"{end}:{self.name}", which)
        while True:
            yield from stream.choice(size, BATCH, p=weights).tolist()
