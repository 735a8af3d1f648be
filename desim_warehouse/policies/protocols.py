"""What a policy of each kind must offer: one method, plain arguments, no clock and no SimPy."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import networkx as nx
    from numpy.random import Generator


@dataclass(frozen=True, slots=True)
class Task:
    """One good to be brought from its storage place to a station."""

    number: int
    good: int
    edge: tuple[str, str]
    offset: float
    release: float = 0.0
    due: float | None = None
    priority: int = 0


@dataclass(frozen=True, slots=True)
class RobotView:
    """A robot as a policy sees it: `node` is where it is or will be next; `energy` what its battery holds now."""

    number: int
    node: str
    home: str
    energy: float
    capacity: float
    threshold: float


@dataclass(frozen=True, slots=True)
class BayView:
    """A bay as a policy sees it: places nobody is in or on the way to, and its chargers."""

    node: str
    free: int
    chargers: int


class Travel(Protocol):
    """Directed distances and free driving times on the Highways."""

    def distance(self, origin: str, goal: str) -> float:
        """Length of the shortest way."""

    def time(self, origin: str, goal: str) -> float:
        """Time of the fastest way: node times and speed limits included, waiting not."""


@dataclass(frozen=True, slots=True)
class Situation:
    """What an allocation policy decides on: the free robots by number, the open tasks in order of the list."""

    time: float
    robots: Sequence[RobotView]
    tasks: Collection[Task]
    travel: Travel
    station: Callable[[RobotView, Task], str]
    """The node where a robot would unload a task."""
    feasible: Callable[[RobotView, Task], bool]
    """Whether the charging policy lets a robot take a task with the energy it has."""
    waits: Mapping[tuple[str, str], float]
    """Mean waiting time per passage of each edge so far, its end node included."""
    random: Callable[[], Generator]
    """The policy's own stream of random numbers, a numpy Generator."""


class Allocation(Protocol):
    """Which free robot does which open task."""

    def assign(self, situation: Situation) -> Iterable[tuple[int, int]]:
        """Pairs (robot number, task number); robots and tasks left out stay free and open."""


class Routing(Protocol):
    """Which way a robot drives."""

    def route(self, origin: str, goal: str, highways: nx.DiGraph) -> Sequence[str]:
        """The nodes from origin to goal, both included."""


class Charging(Protocol):
    """When a robot leaves its work to charge, and when it is ready again."""

    def recall_level(self, robot: RobotView) -> float | None:
        """Energy at which an empty robot gives its task back and turns to a charger; None: never."""

    def may_work(self, robot: RobotView, need: Callable[[], float]) -> bool:
        """Whether a robot may take a task that, with the way to a charger after it, draws `need()` energy."""

    def ready_level(self, robot: RobotView) -> float:
        """Energy at which a charging robot is ready for a task."""


class Parking(Protocol):
    """Where a robot goes that has nothing to fetch."""

    def choose(self, robot: RobotView, bays: Sequence[BayView], travel: Travel) -> str:
        """The node of a bay with a free place."""
