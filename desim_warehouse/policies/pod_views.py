"""What policies of goods to person see, and the one method of each kind: pods, places, stations, without a clock.

`draw` is a number from 0 to 1, drawn for a policy with the class attribute `random = True`, and else 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from desim_warehouse.policies.protocols import Task, Travel


class PodView(NamedTuple):
    """A pod that stands, or last stood, on the storage place `offset` beyond the start of `edge`.

    `home`: the number of the place where it stood at the start. `units`: all that it holds, inf where stock never runs
    out. `rank`: the share of pods that hold more popular items, 0 for the most popular pod. `lines`: the open lines of
    the station in question that it has.
    """

    number: int
    home: int
    edge: tuple[str, str]
    offset: float
    units: float
    rank: float
    lines: Sequence[Task] = ()


class PlaceView(NamedTuple):
    """A storage place that no pod stands on or is bound for."""

    number: int
    edge: tuple[str, str]
    offset: float


class StationView(NamedTuple):
    """A station with room for an order: its node, how many `orders` it has, and of its lines to pick the `items`."""

    node: str
    orders: int
    items: Mapping[int, int]


class PodCall(NamedTuple):
    """A station has lines to pick and room for a robot: which of `pods`, each with some of them, is brought?

    `robots`: the nodes of the robots that are free, at least one.
    """

    time: float
    station: str
    pods: Sequence[PodView]
    robots: Sequence[str]
    travel: Travel
    draw: float


class StorageCall(NamedTuple):
    """A pod is about to leave a station: on which of some free `places` is it put down?"""

    time: float
    station: str
    pod: PodView
    places: Sequence[PlaceView]
    travel: Travel
    draw: float


class OrderCall(NamedTuple):
    """The oldest order may go to one of some stations with room for it: its lines, and these."""

    time: float
    lines: Sequence[Task]
    stations: Sequence[StationView]
    draw: float


class PutCall(NamedTuple):
    """Some units of an item have come to a station: onto which of the `pods` are they put?

    Pods that stand, or are bound for that station already.
    """

    time: float
    station: str
    item: int
    pods: Sequence[PodView]
    draw: float


class PodChoice(Protocol):
    """Which pod is brought to a station."""

    def choose(self, call: PodCall) -> int:
        """The number of one of the given pods. Asked when a robot is free, for one station at a time."""


class PodStorage(Protocol):
    """Where a pod is put down.

    With the attribute `keeps = True` every pod keeps the place where it stood at the start, which is then the only one.
    """

    def choose(self, call: StorageCall) -> int:
        """The number of one of the given places."""


class OrderAssignment(Protocol):
    """Which station an order goes to."""

    def choose(self, call: OrderCall) -> str:
        """The node of one of the given stations."""


class PutChoice(Protocol):
    """Onto which pod goods are put that come in."""

    def choose(self, call: PutCall) -> int:
        """The number of one of the given pods."""
