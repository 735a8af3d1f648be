"""The pods themselves: where each stands, what is on it and promised, and which storage places are free."""

from __future__ import annotations

import math
from collections import Counter, deque
from typing import TYPE_CHECKING, Any

from desim_warehouse.policies.pod_views import PlaceView, PodView

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.layout.layout import StoragePlace
    from desim_warehouse.model.sections.pods import PodsSpec
    from desim_warehouse.policies import Task
    from desim_warehouse.values.streams import Streams
    from desim_warehouse.world.robots.robot import Robot


class Pod:
    """A pod on a storage `place`, or last there, with `stock` units of each of its items; it `stands` or is carried.

    `bound`: the station that it was called to, until it is done there (then None, while it is still under way).
    `lines`: those that it is for, and `promised` how many of each item they take. `robot` brings it. `coming`: units
    that are to be put onto it.
    """

    def __init__(self, number: int, place: int, stock: dict[int, float]) -> None:
        self.number = number
        self.home = self.place = place
        self.stock = stock
        self.promised: Counter[int] = Counter()
        self.stands = True
        self.bound: str | None = None
        self.robot: Robot | None = None
        self.lines: deque[Task] = deque()
        self.coming = 0
        self.rank = 0.0

    def left(self, item: int) -> float:
        """Units of an item that are promised to no line yet."""
        return self.stock.get(item, 0) - self.promised.get(item, 0)


class Shelves:
    """All pods, by number and by what they hold, and the places that no pod stands on or is bound for.

    Where pods `keep` their places these are never free.
    """

    def __init__(self, spec: PodsSpec, storage: Sequence[StoragePlace], streams: Streams, *, keep: bool) -> None:
        self.storage = storage
        self.keep = keep
        draws = streams.stream("pods")
        holds, units = spec.holds, math.inf if spec.stock is None else spec.stock
        stands = draws.permutation(len(storage))[: spec.count].tolist()
        if holds is not None and holds.places:
            stands = list(holds.places)
        self.endless = spec.units is None
        self.pods = [Pod(number, place, {}) for number, place in enumerate(stands)]
        if holds is None:
            # Items are dealt out round after round: each is on as many pods as another, give or take one.
            rounds = -(-spec.count * spec.per_pod // spec.items)
            dealt = [item for _ in range(rounds) for item in draws.permutation(spec.items).tolist()]
            for pod in self.pods:
                pod.stock = dict.fromkeys(dealt[pod.number * spec.per_pod : (pod.number + 1) * spec.per_pod], units)
        else:
            for row, (number, item) in enumerate(zip(holds.pod, holds.item, strict=True)):
                there = self.pods[number].stock
                there[item] = there.get(item, 0) + (holds.units[row] if holds.units else units)
        self._holding: dict[int, list[Pod]] = {}
        for pod in self.pods:
            for item in pod.stock:
                self._holding.setdefault(item, []).append(pod)
        self._rank(spec.item_shares)
        self.free = dict.fromkeys(sorted(set(range(len(storage))) - set(stands)))

    def _rank(self, popularity: Any) -> None:
        weights = [sum(float(popularity[item]) for item in pod.stock) for pod in self.pods]
        for rank, number in enumerate(sorted(range(len(weights)), key=lambda number: (-weights[number], number))):
            self.pods[number].rank = rank / len(weights)

    def holding(self, item: int) -> Sequence[Pod]:
        """The pods that have, or had, an item."""
        return self._holding.get(item, ())

    def put(self, pod: Pod, item: int, units: int) -> None:
        """Some units of an item are put onto a pod."""
        if item not in pod.stock:
            self._holding.setdefault(item, []).append(pod)
        pod.stock[item] = pod.stock.get(item, 0) + units
        pod.coming -= units

    def lift(self, pod: Pod) -> None:
        """A pod is taken away from its place, which is free unless it is kept."""
        pod.stands = False
        if not self.keep:
            self.free[pod.place] = None

    def reserve(self, pod: Pod, place: int) -> None:
        """A pod is bound for a place."""
        self.free.pop(place, None)
        pod.place = place

    def places_for(self, pod: Pod) -> list[PlaceView]:
        """Where a pod may be put down: its own place where they are kept, else the free ones."""
        numbers = [pod.home] if self.keep else self.free
        return [PlaceView(number, self.storage[number].edge, self.storage[number].offset) for number in numbers]

    def view(self, pod: Pod, lines: Sequence[Task] = ()) -> PodView:
        """A pod as policies see it."""
        place = self.storage[pod.place]
        units = math.inf if self.endless else sum(pod.stock.values()) + pod.coming
        return PodView(pod.number, pod.home, place.edge, place.offset, units, pod.rank, lines)
