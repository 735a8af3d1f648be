"""The tasks of a probe: in the model's own mix, a fixed number known at any time, spread evenly rather than at random.

For the quick estimate (`run.quick`).

Places and flows are a stratified sample in random order: each occurs in proportion to the demand, up to rounding, and
without any pattern of the floor.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from simpy.events import Timeout

from desim_warehouse.layout import Layout
from desim_warehouse.model import Model
from desim_warehouse.model.facts.demand import demand, listed
from desim_warehouse.model.facts.places import own_destinations, place_shares
from desim_warehouse.model.sections.flows import OrdersArrivals, StorageEnd
from desim_warehouse.policies import Task
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.orders.flows import Flows
from desim_warehouse.world.traffic.events import Clock

BY_OTHERS = {"least-loaded", "each"}
"""Station choices that depend on other robots; a single robot takes these stations in turn."""
BLOCK = 50
"""The number of goods spread over all places, as a probe may end after some of them."""


class Backlog:
    """A source of at most about `count` tasks of the goods or `flows`, with `waiting` of them known at any time.

    All lines of an order become known together, as in a run: otherwise a batch by order would have a part of it. With
    pods, where no tasks are batched, lines become known one by one, so that exactly `waiting` of them wait.

    Attributes:
        enough: function that is asked before each order, with the number of tasks released; no orders follow if True.
        in_turn: whether stations that other robots chose are gone to in turn.
        rates: rates of the flows, in any unit.
        pause: time from when a task is taken until the next is known.
    """

    def __init__(
        self,
        env: Clock,
        model: Model,
        layout: Layout,
        streams: Streams,
        *,
        flows: Sequence[str],
        count: int,
        waiting: int,
        in_turn: bool,
        rates: Mapping[str, float],
        pause: float,
        enough: Callable[[int], bool],
    ) -> None:
        self._env, self._model, self._layout = env, model, layout
        self._random, self._rates = streams.stream("probe"), rates
        self._in_turn = in_turn and model.tasks.station_choice in BY_OTHERS
        orders = list(self._of_flows(streams, flows, count) if model.tasks.flows else self._of_goods(count))
        if model.pods is not None:
            orders = [[task] for order in orders for task in order]
        most = sum(map(len, orders))
        self.total: int | None = most
        self._waiting, self._open, self._pause = waiting, 0, pause
        self._coming, self._given, self._most, self._enough = iter(orders), 0, most, enough

    def start(self, release: Callable[[Task], None]) -> None:
        """Release the first tasks, and later as many as are taken."""
        self._release = release
        self._fill()

    def taken(self, task: Task) -> None:
        """Release the tasks that follow a task that is taken."""
        self._open -= len(task.tasks)
        if self._pause:
            Timeout(self._env, self._pause).callbacks.append(lambda _: self._fill())
        else:
            self._fill()

    def returned(self, task: Task) -> None:
        """Count a task as open again."""
        self._open += len(task.tasks)

    def to_come(self, _: Task, __: bool) -> bool:
        """Whether more tasks will follow."""
        return self._given < self._most

    def _fill(self) -> None:
        while self._open < self._waiting and self._given < self._most:
            if self._enough(self._given):
                self.total = self._most = self._given
                return
            order = next(self._coming)
            self._open += len(order)
            self._given += len(order)
            for task in order:
                self._release(task._replace(release=self._env.now, due=None))

    def _of_goods(self, count: int) -> Iterator[list[Task]]:
        """Iterate over goods in the mix of the demand; goods of a list come in its order, again and again."""
        model, storage, nodes = self._model, self._layout.storage, self._model.tasks.unload_at
        goods, own = listed(model), own_destinations(model, self._layout)
        drawn = [] if goods else self._sample(demand(model, self._layout), count, BLOCK)
        turns = self._sample([1.0] * len(nodes), count, BLOCK) if self._in_turn and len(nodes) > 1 else []
        for number in range(count):
            place = storage[goods[number % len(goods)] if goods else drawn[number]]
            targets = own[number % len(own)] if own else ()
            if turns and not targets:
                targets = (nodes[turns[number]],)
            yield [Task(number, place.number, place.edge, place.offset, to=targets)]

    def _of_flows(self, streams: Streams, names: Sequence[str], count: int) -> Iterator[list[Task]]:
        """Iterate over the orders of some flows, by their rates, each with the tasks of all its lines."""
        model, rates = self._model, self._rates
        made = Flows(self._env, model, self._layout, streams).flows
        drawn = self._sample([rates[name] / model.tasks.flows[name].mean_lines for name in names], count)
        which = [names[number] for number in drawn]
        rows = {name: self._rows(made[name], which.count(name)) for name in names}
        for name in names:
            self._stratify(made[name], max(which.count(name), 1))
        number = 0
        for nth, name in enumerate(which):
            order = made[name].order(number, 0.0, next(rows[name]))
            number += len(order)
            if self._in_turn and model.tasks.station_choice == "least-loaded":
                order = [task._replace(to=(task.to[nth % len(task.to)],)) for task in order]
            yield order

    def _stratify(self, flow: Any, count: int) -> None:
        """Draw the storage places of a flow as a sample of its own."""
        for which, route in enumerate(flow.routes):
            for end, places in (("from", route.source), ("to", route.target)):
                if isinstance(places, StorageEnd):
                    shares = place_shares(self._model, self._layout, places)
                    weights = [1.0] * len(self._layout.storage) if shares is None else shares
                    flow.draw_from(end, which, places, self._samples(weights, count))

    def _samples(self, weights: Sequence[float], count: int) -> Iterator[int]:
        while True:
            yield from self._sample(weights, count)

    def _rows(self, flow: Any, count: int) -> Iterator[Any]:
        """Iterate over a sample of the rows of a file of orders, else over None for each task."""
        if not isinstance(flow.when, OrdersArrivals):
            return iter([None] * count)
        every = [line for _, line in flow.asked_for()]
        return iter([every[number] for number in self._sample([1.0] * len(every), count)])

    def _sample(self, weights: Sequence[float], count: int, block: int | None = None) -> list[int]:
        """Draw a stratified sample of numbers by weight, in random order: one from each of `count` equal parts.

        They come in blocks, each spread over the whole; without `block` all form one block.
        """
        import numpy as np

        block = block or max(count, 1)
        blocks = -(-count // block)
        places = self._random.permuted(np.arange(blocks * block).reshape(block, blocks), axis=1)
        parts = self._random.permuted(places, axis=0).T.ravel()
        cut = np.cumsum(np.asarray(weights, dtype=float))
        points = (parts + self._random.random(len(parts))) / len(parts) * cut[-1]
        return np.minimum(np.searchsorted(cut, points, side="right"), len(cut) - 1)[:count].tolist()  # type: ignore[no-any-return]
