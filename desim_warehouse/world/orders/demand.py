"""Sources of tasks: a list, goods drawn at random, a list that never runs dry, or Poisson arrivals."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from simpy.events import Event, Timeout

from desim_warehouse.layout import Layout
from desim_warehouse.model import Model
from desim_warehouse.model.facts.places import only_place, own_destinations, place_shares
from desim_warehouse.model.sections.goods import Good, PoissonGoods, RandomGoods, SaturatedGoods
from desim_warehouse.policies import Task
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.traffic.events import Clock, Steps

BATCH = 1024
"""Goods drawn at a time."""


class Orders(Protocol):
    """A source of tasks: `total` of them, or None: without end."""

    total: int | None

    def start(self, release: Callable[[Task], None]) -> None:
        """Release the tasks that are known at the start of the run, and schedule the arrival of later ones."""

    def taken(self, task: Task) -> None:
        """Note that a robot has taken a task or tour."""

    def returned(self, task: Task) -> None:
        """Note that a robot has given back a task or tour, which is open again."""

    def to_come(self, task: Task, by_flow: bool, /) -> bool:
        """Whether further tasks will become known that may share a tour with a given one, perhaps only `by_flow`."""


class Demand:
    """A source of tasks: `total` of them or, where it is None, without end."""

    def __init__(self, env: Clock, model: Model, layout: Layout, streams: Streams) -> None:
        self.env = env
        self.robots = model.fleet.size
        self.layout = layout
        self.storage = layout.storage
        self.own = own_destinations(model, layout)
        self.streams = streams
        assert model.tasks.goods is not None
        self.goods = model.tasks.goods
        self.model = model
        self.hour = model.units.hour / model.tasks.demand
        self.hours = model.hours(getattr(self.goods, "hours", None))
        self.total: int | None = None
        self._number = self._open = 0
        self._drawn: list[int] = []
        self._stream: Any = None
        self._only = None if isinstance(self.goods, tuple) else only_place(model, layout)

    def start(self, release: Callable[[Task], None]) -> None:
        """Pass the tasks known at the start of the run to `release`, and schedule the later arrivals."""
        self.release = release
        goods = self.goods
        if isinstance(goods, PoissonGoods):
            self.env.process(self._arrivals(goods))
        elif isinstance(goods, SaturatedGoods):
            for _ in range(goods.open(self.robots)):
                self._release(self._draw(), goods.due_within)
        elif isinstance(goods, RandomGoods):
            self.total = goods.random
            for number in self._without_repetition(goods.random):
                self._release(number)
        else:
            self.total = len(goods)
            for item, targets in zip(goods, self.own, strict=True):
                if isinstance(item, Good):
                    self._announce(item, targets)
                else:
                    self._release(item, targets=targets)

    def taken(self, task: Task) -> None:
        """Note that a robot has taken a task or tour: where work never ends, another task is released for each.

        No task is released in place of those that robots have given back, so that the number of open tasks is kept.
        """
        self._open -= len(task.tasks)
        for _ in task.tasks:
            if isinstance(self.goods, SaturatedGoods) and self._open < self.goods.open(self.robots):
                self._release(self._draw(), self.goods.due_within)

    def returned(self, task: Task) -> None:
        """Note that a robot has given back a task or tour, which is open again."""
        self._open += len(task.tasks)

    def to_come(self, _: Task, __: bool) -> bool:
        """Whether further tasks will become known, whatever robots do."""
        return isinstance(self.goods, PoissonGoods) or (self.total is not None and self._number < self.total)

    def _announce(self, good: Good, targets: tuple[str, ...]) -> None:
        def release(_: Event | None = None) -> None:
            self._put(good.good, good.due, good.priority, targets)

        if good.release <= self.env.now:
            release()
        else:
            Timeout(self.env, good.release - self.env.now).callbacks.append(release)

    def _release(self, good: int, due_within: float | None = None, *, targets: tuple[str, ...] = ()) -> None:
        self._put(good, None if due_within is None else self.env.now + due_within, 0, targets)

    def _put(self, good: int, due: float | None, priority: int, targets: tuple[str, ...]) -> None:
        place = self.storage[good]
        task = Task(self._number, good, place.edge, place.offset, self.env.now, due, priority, targets)
        self._number += 1
        self._open += 1
        self.release(task)

    def _arrivals(self, goods: PoissonGoods) -> Steps:
        mean = self.hour / goods.poisson
        gaps = self.streams.stream("arrivals")
        while True:
            yield Timeout(self.env, float(gaps.exponential(mean)))
            if goods.hours is None or self.hours.is_open(self.env.now):
                self._release(self._draw(), goods.due_within)

    # Choice of goods

    def _generator(self) -> Any:
        if self._stream is None:
            self._stream = self.streams.stream("goods")
        return self._stream

    def _draw(self) -> int:
        if self._only is not None:
            return self._only
        if not self._drawn:
            size, weights = len(self.storage), self._weights()
            self._drawn = self._generator().choice(size, BATCH, p=weights).tolist()
        return self._drawn.pop()

    def _without_repetition(self, count: int) -> list[int]:
        """Draw goods in random order, each at most once until all are drawn. Popular goods tend to come first."""
        if self._only is not None:
            return [self._only] * count
        size, weights = len(self.storage), self._weights()
        goods: list[int] = []
        while len(goods) < count:
            some = min(count - len(goods), size if weights is None else int((weights > 0).sum()))
            goods += self._generator().choice(size, some, replace=False, p=weights).tolist()
        return goods

    def _weights(self) -> Any:
        """Return the share of every storage place in the demand, or None for equal shares."""
        return place_shares(self.model, self.layout)


class NoOrders:
    """A source without tasks, for the run of a night."""

    def __init__(self, *_: object) -> None:
        """There is nothing to know."""

    total: int | None = None

    def start(self, release: Callable[[Task], None]) -> None:
        """Do nothing: there is nothing to release."""

    def taken(self, task: Task) -> None:
        """Do nothing: there is no task."""

    def returned(self, task: Task) -> None:
        """Do nothing: there is no task."""

    def to_come(self, _: Task, __: bool) -> bool:
        """Whether more tasks will become known: never."""
        return False
