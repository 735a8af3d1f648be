"""Goods to person: policies for calling and storing pods, assigning orders to stations, and replenishment.

First come the views that these policies get, and the one method of each kind, without a clock. `draw` is a random
number from 0 to 1 for policies with the class attribute `random = True`, and otherwise 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

from desim_warehouse.policies.protocols import Task, Travel


class PodView(NamedTuple):
    """A pod that stands, or last stood, on the storage place `offset` beyond the start of `edge`.

    `home`: the number of its place at the start. `units`: its total stock, inf if stock never runs out. `rank`: the
    share of pods that hold more popular items, 0 for the most popular pod. `lines`: the open lines of the station in
    question that the pod has.
    """

    number: int
    home: int
    edge: tuple[str, str]
    offset: float
    units: float
    rank: float
    lines: Sequence[Task] = ()


class PlaceView(NamedTuple):
    """A storage place where no pod stands or is bound to."""

    number: int
    edge: tuple[str, str]
    offset: float


class StationView(NamedTuple):
    """A station with room for an order: its node, its number of `orders`, and the `items` of its lines to pick."""

    node: str
    orders: int
    items: Mapping[int, int]


class PodCall(NamedTuple):
    """A station has lines to pick and room for a robot: the policy chooses which of `pods` to bring.

    Each pod has some of these lines.

    `robots`: the nodes of the free robots, at least one.
    """

    time: float
    station: str
    pods: Sequence[PodView]
    robots: Sequence[str]
    travel: Travel
    draw: float


class StorageCall(NamedTuple):
    """A pod is about to leave a station: the policy chooses one of the free `places` to put it down on."""

    time: float
    station: str
    pod: PodView
    places: Sequence[PlaceView]
    travel: Travel
    draw: float


class OrderCall(NamedTuple):
    """Several stations have room for the oldest order: the policy chooses one of them."""

    time: float
    lines: Sequence[Task]
    stations: Sequence[StationView]
    draw: float


class PutCall(NamedTuple):
    """Units of an item have arrived at a station: the policy chooses which of the `pods` to put them onto.

    The pods stand, or are bound for that station already.
    """

    time: float
    station: str
    item: int
    pods: Sequence[PodView]
    draw: float


class PodChoice(Protocol):
    """Decides which pod is brought to a station."""

    def choose(self, call: PodCall) -> int:
        """Return the number of one of the given pods. Called when a robot is free, for one station at a time."""


class PodStorage(Protocol):
    """Decides where a pod is put down.

    With the attribute `keeps = True` every pod keeps its place at the start, which is then the only choice.
    """

    def choose(self, call: StorageCall) -> int:
        """Return the number of one of the given places."""


class OrderAssignment(Protocol):
    """Decides which station an order goes to."""

    def choose(self, call: OrderCall) -> str:
        """Return the node of one of the given stations."""


class PutChoice(Protocol):
    """Decides onto which pod incoming goods are put."""

    def choose(self, call: PutCall) -> int:
        """Return the number of one of the given pods."""


@dataclass(frozen=True)
class NearestPod:
    """Calls the pod that arrives soonest: from the nearest free robot to it, and on to the station.

    Source: Merschformann, Xie and Li, Annals of Operations Research (2018), RAWSim-O: nearest pod.
    """

    def choose(self, call: PodCall) -> int:
        """Return the number of the pod."""
        return _soonest(call, call.pods)


@dataclass(frozen=True)
class MostLines:
    """Calls the pod with the most open lines of the station; of these the one that arrives soonest.

    Source: pile-on; Xie, Thieme, Krenzler and Li, European J. Operational Research 288 (2021) 80-97.
    """

    def choose(self, call: PodCall) -> int:
        """Return the number of the pod."""
        most = max(len(pod.lines) for pod in call.pods)
        return _soonest(call, [pod for pod in call.pods if len(pod.lines) == most])


@dataclass(frozen=True)
class RandomPod:
    """Calls any pod that has a line, all equally likely: a yardstick, as its lines per visit are known exactly.

    Source: random pod selection; Merschformann et al., Operations Research Perspectives 6 (2019) 100128.
    """

    random: ClassVar[bool] = True

    def choose(self, call: PodCall) -> int:
        """Return the number of the pod."""
        return call.pods[int(call.draw * len(call.pods))].number


def _soonest(call: PodCall, pods: Sequence[PodView]) -> int:
    """Return the number of the pod that arrives soonest; pods on the same edge tie."""
    time, nodes, edges = call.travel.time, set(call.robots), {pod.edge for pod in pods}
    first = {begin: min(time(node, begin) for node in nodes) for begin in {begin for begin, _ in edges}}
    soon = {edge: first[edge[0]] + time(edge[1], call.station) for edge in edges}
    return min((soon[pod.edge], pod.number) for pod in pods)[1]


@dataclass(frozen=True)
class NearestPlace:
    """Stores the pod at the free place nearest to the station that it leaves, by driving time.

    Source: closest open location; Lamballais, Roy and De Koster, European J. Operational Research 256 (2017) 976-990.
    """

    keeps: ClassVar[bool] = False

    def choose(self, call: StorageCall) -> int:
        """Return the number of the storage place."""
        return _by_time(call)[0]


@dataclass(frozen=True)
class OwnPlace:
    """Stores the pod at the place where it stood at the start, which is reserved for it.

    Source: fixed storage; Merschformann et al. (2019).
    """

    keeps: ClassVar[bool] = True

    def choose(self, call: StorageCall) -> int:
        """Return the place where the pod stood at the start."""
        return call.pod.home


@dataclass(frozen=True)
class RandomPlace:
    """Stores the pod at any free place, all equally likely.

    Source: random storage; Merschformann et al. (2019).
    """

    keeps: ClassVar[bool] = False
    random: ClassVar[bool] = True

    def choose(self, call: StorageCall) -> int:
        """Return the number of the storage place."""
        return call.places[int(call.draw * len(call.places))].number


@dataclass(frozen=True)
class ByTurnover:
    """Stores popular pods near the station: at the free place as far along, by driving time, as the pod's rank.

    Source: turnover-based storage; Hausman, Schwarz and Graves, Management Science 22 (1976) 629-638.
    """

    keeps: ClassVar[bool] = False

    def choose(self, call: StorageCall) -> int:
        """Return the number of the storage place."""
        places = _by_time(call)
        return places[min(int(call.pod.rank * len(places)), len(places) - 1)]


def _by_time(call: StorageCall) -> list[int]:
    """Return the free places, nearest to the station first."""
    time = {node: call.travel.time(call.station, node) for node in {place.edge[0] for place in call.places}}
    ways = sorted((time[place.edge[0]], place.offset, place.number) for place in call.places)
    return [number for _, _, number in ways]


@dataclass(frozen=True)
class FewestOrders:
    """Assigns the order to the station with the fewest orders; ties by their order.

    Source: even workload; Merschformann et al. (2019).
    """

    def choose(self, call: OrderCall) -> str:
        """Return the node of the station."""
        return min(call.stations, key=lambda station: station.orders).node


@dataclass(frozen=True)
class MostLinesInCommon:
    """Assigns the order to the station whose open lines share most items with it, for common pods; else the emptiest.

    Source: the rule that matters most in Merschformann et al. (2019): pods in common of orders at one station.
    """

    def choose(self, call: OrderCall) -> str:
        """Return the node of the station."""

        def rank(station: StationView) -> tuple[int, int]:
            return -sum(line.item in station.items for line in call.lines), station.orders

        return min(call.stations, key=rank).node


@dataclass(frozen=True)
class Emptiest:
    """Puts goods onto the pod with the fewest units, those on their way included; ties by number.

    Source: emptiest pod; Merschformann et al. (2019).
    """

    def choose(self, call: PutCall) -> int:
        """Return the number of the pod."""
        return min(call.pods, key=lambda pod: (pod.units, pod.number)).number


@dataclass(frozen=True)
class AnyPod:
    """Puts goods onto any pod, all equally likely.

    Source: random pod; Merschformann et al. (2019).
    """

    random: ClassVar[bool] = True

    def choose(self, call: PutCall) -> int:
        """Return the number of the pod."""
        return call.pods[int(call.draw * len(call.pods))].number
