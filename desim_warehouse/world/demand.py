"""Where tasks come from: a list, goods drawn at random, a list that never runs dry, or Poisson arrivals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simpy.events import Event, Timeout

from desim_warehouse.model.schema import Good, PoissonGoods, Popularity, RandomGoods, SaturatedGoods
from desim_warehouse.policies import Task

if TYPE_CHECKING:
    from collections.abc import Generator

    from desim_warehouse.world.world import World

BATCH = 1024
"""Goods drawn at a time."""


class Demand:
    """Releases tasks to the dispatcher; `total` is how many there will be, None if they never end."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.goods = world.model.tasks.goods
        self.total: int | None = None
        self._number = 0
        self._drawn: list[int] = []
        self._stream: Any = None

    def start(self) -> None:
        """Release what is known at the start; see to what comes later."""
        goods, env = self.goods, self.world.env
        if isinstance(goods, PoissonGoods):
            env.process(self._arrivals(goods))
        elif isinstance(goods, SaturatedGoods):
            for _ in range(goods.saturated):
                self._release(Good(good=self._draw()), goods.due_within)
        elif isinstance(goods, RandomGoods):
            self.total = goods.random
            for number in self._without_repetition(goods.random):
                self._release(Good(good=number))
        else:
            self.total = len(goods)
            for item in goods:
                self._announce(item if isinstance(item, Good) else Good(good=item))

    def taken(self) -> None:
        """A task was taken: where work never ends another one is released."""
        if isinstance(self.goods, SaturatedGoods):
            self._release(Good(good=self._draw()), self.goods.due_within)

    def _announce(self, good: Good) -> None:
        env = self.world.env
        if good.release <= env.now:
            self._release(good)
        else:
            Timeout(env, good.release - env.now).callbacks.append(lambda _: self._release(good))

    def _release(self, good: Good, due_within: float | None = None) -> None:
        place = self.world.layout.storage[good.good]
        now = self.world.env.now
        due = good.due if due_within is None else now + due_within
        task = Task(self._number, good.good, place.edge, place.offset, now, due, good.priority)
        self._number += 1
        self.world.dispatcher.release(task)

    def _arrivals(self, goods: PoissonGoods) -> Generator[Event, object, None]:
        mean = self.world.model.units.hour / goods.poisson
        gaps = self.world.streams.stream("arrivals")
        while True:
            yield Timeout(self.world.env, float(gaps.exponential(mean)))
            self._release(Good(good=self._draw()), goods.due_within)

    # Which goods

    def _generator(self) -> Any:
        if self._stream is None:
            self._stream = self.world.streams.stream("goods")
        return self._stream

    def _draw(self) -> int:
        if not self._drawn:
            size, weights = len(self.world.layout.storage), self._weights()
            self._drawn = self._generator().choice(size, BATCH, p=weights).tolist()
        return self._drawn.pop()

    def _without_repetition(self, count: int) -> list[int]:
        """Goods in random order, each at most once until all have been drawn; popular ones tend to come first."""
        size, weights = len(self.world.layout.storage), self._weights()
        goods: list[int] = []
        while len(goods) < count:
            some = min(count - len(goods), size if weights is None else int((weights > 0).sum()))
            goods += self._generator().choice(size, some, replace=False, p=weights).tolist()
        return goods

    def _weights(self) -> Any:
        """The share of every storage place in the demand; None: all alike."""
        import numpy as np

        popularity, storage = self.world.model.tasks.popularity, self.world.layout.storage
        if popularity == "uniform":
            return None
        if isinstance(popularity, Popularity) and popularity.classes:
            weights = np.empty(len(storage))
            begin, share = 0, 0.0
            for item in popularity.classes:
                share += item.share
                end = round(share * len(storage))
                weights[begin:end] = item.demand / max(end - begin, 1)
                begin = end
        elif isinstance(popularity, Popularity):
            weights = np.array(popularity.weights, dtype=float)
        else:
            weights = np.array([place.popularity for place in storage])
        return weights / weights.sum()
