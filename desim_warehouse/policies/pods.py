"""Goods to person: which pod is brought, where it goes back, which station gets an order, and what is put where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from desim_warehouse.policies.pod_views import OrderCall, PodCall, PodView, PutCall, StationView, StorageCall


@dataclass(frozen=True)
class NearestPod:
    """The pod that is there soonest: from the nearest free robot to it, and on to the station.

    Source: Merschformann, Xie and Li, Annals of Operations Research (2018), RAWSim-O: nearest pod.
    """

    def choose(self, call: PodCall) -> int:
        """The number of the pod."""
        return _soonest(call, call.pods)


@dataclass(frozen=True)
class MostLines:
    """The pod from which most open lines of the station can be picked; of these the one that is there soonest.

    Source: pile-on; Xie, Thieme, Krenzler and Li, European J. Operational Research 288 (2021) 80-97.
    """

    def choose(self, call: PodCall) -> int:
        """The number of the pod."""
        most = max(len(pod.lines) for pod in call.pods)
        return _soonest(call, [pod for pod in call.pods if len(pod.lines) == most])


@dataclass(frozen=True)
class RandomPod:
    """Any pod that has a line, each as likely: the yardstick of the others, whose lines a visit are known exactly.

    Source: random pod selection; Merschformann et al., Operations Research Perspectives 6 (2019) 100128.
    """

    random: ClassVar[bool] = True

    def choose(self, call: PodCall) -> int:
        """The number of the pod."""
        return call.pods[int(call.draw * len(call.pods))].number


def _soonest(call: PodCall, pods: Sequence[PodView]) -> int:
    """The number of the pod that is there soonest; pods on one edge are there as soon as each other."""
    time, nodes, edges = call.travel.time, set(call.robots), {pod.edge for pod in pods}
    first = {begin: min(time(node, begin) for node in nodes) for begin in {begin for begin, _ in edges}}
    soon = {edge: first[edge[0]] + time(edge[1], call.station) for edge in edges}
    return min((soon[pod.edge], pod.number) for pod in pods)[1]


@dataclass(frozen=True)
class NearestPlace:
    """The free place nearest to the station that it leaves, by driving time.

    Source: closest open location; Lamballais, Roy and De Koster, European J. Operational Research 256 (2017) 976-990.
    """

    keeps: ClassVar[bool] = False

    def choose(self, call: StorageCall) -> int:
        """The number of the storage place."""
        return _by_time(call)[0]


@dataclass(frozen=True)
class OwnPlace:
    """Back to the place where it stood at the start, which is kept for it.

    Source: fixed storage; Merschformann et al. (2019).
    """

    keeps: ClassVar[bool] = True

    def choose(self, call: StorageCall) -> int:
        """Its home."""
        return call.pod.home


@dataclass(frozen=True)
class RandomPlace:
    """Any free place, each as likely.

    Source: random storage; Merschformann et al. (2019).
    """

    keeps: ClassVar[bool] = False
    random: ClassVar[bool] = True

    def choose(self, call: StorageCall) -> int:
        """The number of the storage place."""
        return call.places[int(call.draw * len(call.places))].number


@dataclass(frozen=True)
class ByTurnover:
    """Popular pods near the station: of the free places, by driving time, the one as far along as the pod's rank.

    Source: turnover-based storage; Hausman, Schwarz and Graves, Management Science 22 (1976) 629-638.
    """

    keeps: ClassVar[bool] = False

    def choose(self, call: StorageCall) -> int:
        """The number of the storage place."""
        places = _by_time(call)
        return places[min(int(call.pod.rank * len(places)), len(places) - 1)]


def _by_time(call: StorageCall) -> list[int]:
    """The free places, nearest to the station first."""
    time = {node: call.travel.time(call.station, node) for node in {place.edge[0] for place in call.places}}
    ways = sorted((time[place.edge[0]], place.offset, place.number) for place in call.places)
    return [number for _, _, number in ways]


@dataclass(frozen=True)
class FewestOrders:
    """The station with the fewest orders; ties by their order.

    Source: even workload; Merschformann et al. (2019).
    """

    def choose(self, call: OrderCall) -> str:
        """The node of the station."""
        return min(call.stations, key=lambda station: station.orders).node


@dataclass(frozen=True)
class MostLinesInCommon:
    """The station whose open lines are of most of the order's items, so that one pod serves both; else the emptiest.

    Source: the rule that matters most in Merschformann et al. (2019): pods in common of orders at one station.
    """

    def choose(self, call: OrderCall) -> str:
        """The node of the station."""

        def rank(station: StationView) -> tuple[int, int]:
            return -sum(line.item in station.items for line in call.lines), station.orders

        return min(call.stations, key=rank).node


@dataclass(frozen=True)
class Emptiest:
    """The pod that holds the fewest units, with those that are on their way to it; ties by number.

    Source: emptiest pod; Merschformann et al. (2019).
    """

    def choose(self, call: PutCall) -> int:
        """The number of the pod."""
        return min(call.pods, key=lambda pod: (pod.units, pod.number)).number


@dataclass(frozen=True)
class AnyPod:
    """Any pod, each as likely.

    Source: random pod; Merschformann et al. (2019).
    """

    random: ClassVar[bool] = True

    def choose(self, call: PutCall) -> int:
        """The number of the pod."""
        return call.pods[int(call.draw * len(call.pods))].number
