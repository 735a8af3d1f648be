"""The interfaces of policies: the views that they get, and the one method of each kind, without a clock or SimPy."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from desim_warehouse.errors import shown

if TYPE_CHECKING:
    import networkx as nx
    import numpy as np
    from numpy.typing import NDArray

CHARGERS = ("own", "nearest", "least-loaded")
"""Rules for choosing a charger; ties go to the nearest, then to the first in the model file."""
_FIFTH = 0.2
"""A share of capacity below any that a policy means by "full", so lower levels are taken for shares."""


class StopPlace(NamedTuple):
    """A stop of a task on its way: at one of some `nodes`, or at a storage place, an edge and an offset on it.

    In the latter case `nodes` is the end of that edge.
    """

    nodes: tuple[str, ...]
    storage: tuple[tuple[str, str], float] | None = None


class Task(NamedTuple):
    """A load to be taken from one storage place or station to another, or several loads that a robot takes on one tour.

    The load is picked `offset` beyond the start of `edge`. At a node, or in the station beside it, both ends of `edge`
    are that node, and the offset is 0. `good` is the number of its storage place, -1 if it comes from none. `to`: the
    nodes of which one is its destination; empty: the common one (tasks.unload_at). `drop`: the edge and the offset of
    the storage place to which it is brought (`to` is then the end of the edge); None: it goes to a node or station.
    `flow` names its flow, of which it is the `nth` task from 0, and `order` its order. `kinds`: the kinds of robots
    that may do it; empty: all. `load_type`: only for robots that carry it; empty: for all. `via`: its stops in between,
    in order.

    `members`: the tasks of a tour, in the order in which they are picked, for a robot that carries as many; empty: a
    single task. A tour has the number of its first member and is picked where that is; it is due when the first of its
    members is.

    With pods, `item` is that of a line whose pod is not chosen yet (-1: it is none). A visit of a `pod` (-1: it is
    none) is a tour via its station and back to a storage place, with the number of `lines` at the time of the call. It
    has the number of the first of them.
    """

    number: int
    good: int
    edge: tuple[str, str]
    offset: float
    release: float = 0.0
    due: float | None = None
    priority: int = 0
    to: tuple[str, ...] = ()
    drop: tuple[tuple[str, str], float] | None = None
    flow: str = ""
    nth: int = 0
    kinds: tuple[str, ...] = ()
    order: str = ""
    load_type: str = ""
    via: tuple[StopPlace, ...] = ()
    members: tuple[Task, ...] = ()
    item: int = -1
    pod: int = -1
    lines: int = 1

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The tasks that one robot does on this tour: its members, or the task itself."""
        return self.members or (self,)

    @property
    def is_tour(self) -> bool:
        """Whether the task is more than one load from one place to another."""
        return bool(self.members or self.via)


class RobotView(NamedTuple):
    """A robot as policies see it, read-only; energies are in the model's unit.

    `node` is where it is or comes to next; for a busy robot where it will be free, in about `free_in` time units. `bay`
    is the node of the bay it stood in last. `queue` are the tasks that it will do after the current one. `kind` is its
    kind in fleet.kinds; empty for ordinary robots. It carries `loads` at once, of the types `carries`; empty: of all
    types.
    """

    number: int
    node: str
    home: str
    energy: float
    capacity: float
    threshold: float
    bay: str = ""
    speed: float = 1.0
    free: bool = True
    free_in: float = 0.0
    queue: tuple[Task, ...] = ()
    kind: str = ""
    loads: int = 1
    carries: tuple[str, ...] = ()


class BayView(NamedTuple):
    """A bay as policies see it: `free` slots (neither occupied nor reserved), chargers, and `present` robots."""

    node: str
    free: int
    chargers: int
    present: int = 0


@dataclass(frozen=True, slots=True)
class Levels:
    """Battery levels that a charging policy decides for a robot, in the model's unit of energy.

    Attributes:
        critical: level at or below which a robot charges: it gets no task, and returns one whose good is not reached.
        good: level at or below which a robot that leaves its work goes to a charger, above it to a parking slot.
        sufficient: level from which charging may be interrupted for work.
        full: level at which charging ends, at most the capacity.
        margin: energy to be left on reaching a charger after the task. A robot gets no task, and keeps none that it
            is on its way to, if less would be left. None: no look-ahead.
        top_up: whether a robot that parks beside a charger also charges when it is above `good`.
        charger: charger that the robot goes to: `own` (of its home bay), `nearest` or `least-loaded`.
        swap_time: time to swap the battery for a full one; None: the battery is charged.
    """

    critical: float
    good: float
    sufficient: float
    full: float
    margin: float | None = None
    top_up: bool = True
    charger: str = "own"
    swap_time: float | None = None

    def fault(self, robot: RobotView) -> str | None:
        """Describe the first value that is out of range or order for a robot; None: all are valid."""
        return next(self._faults(robot), None)

    def _faults(self, robot: RobotView) -> Iterator[str]:
        """Yield what is wrong with the values for a robot. Each check relies on those before it."""
        numbers = {
            "critical": self.critical,
            "good": self.good,
            "sufficient": self.sufficient,
            "full": self.full,
            "margin": 0.0 if self.margin is None else self.margin,
            "swap_time": 0.0 if self.swap_time is None else self.swap_time,
        }
        for name, value in numbers.items():
            if not (isinstance(value, Real) and math.isfinite(value)):
                yield f"{name} is {shown(value)}, expected a finite number"
        if self.sufficient > self.full:
            yield f"sufficient, {self.sufficient:g}, is above full, {self.full:g}"
        if self.critical > self.full:
            yield f"critical, {self.critical:g}, is above full, {self.full:g}"
        if self.full > robot.capacity and not math.isclose(self.full, robot.capacity):
            yield f"full, {self.full:g}, is above the capacity, {robot.capacity:g}"
        if self.full <= 1 and self.full < _FIFTH * robot.capacity:
            yield (
                f"full is {self.full:g} of {robot.capacity:g}, so these are shares, as it seems; expected energy, as "
                "in 0.8 * robot.capacity"
            )
        if self.charger not in CHARGERS:
            yield f"charger is {shown(self.charger)}, none of {', '.join(CHARGERS)}"
        if self.swap_time is not None and self.swap_time < 0:
            yield f"swap_time is {self.swap_time:g}, below 0"


class Travel(Protocol):
    """Directed distances and free driving times between nodes, in the units of the model."""

    def distance(self, origin: str, goal: str) -> float:
        """Return the length of the shortest route."""

    def time(self, origin: str, goal: str) -> float:
        """Return the time of the fastest route: node times and speed limits included, waiting not."""

    def way(self, origin: str, goal: str) -> list[str]:
        """Return the nodes that a robot drives from origin to goal, both included."""

    def times(self, origins: Sequence[str], goals: Sequence[str]) -> NDArray[np.float64]:
        """Return free driving times of the routes that robots take: origins x goals, in the model's time unit."""

    def lengths(self, origins: Sequence[str], goals: Sequence[str]) -> NDArray[np.float64]:
        """Return lengths of the routes that robots take: origins x goals, in the model's length unit."""


class Oracle(Protocol):
    """Routes that are cheapest by one cost of an edge."""

    def way(self, origin: str, goal: str, tie: int = 0) -> list[str]:
        """Return the nodes of the route, both ends included; empty without one. `tie` chooses among equal routes."""

    def time(self, origin: str, goal: str) -> float:
        """Return the free driving time of the route."""

    def counted(self, origin: str, goal: str) -> float:
        """Return the cost that routes are compared by: higher where the route goes against a preferred direction."""


@dataclass(frozen=True, slots=True)
class Roads:
    """The road network as routing policies see it.

    `graph` has x, y at its nodes (in_lane: no route may lead through it) and length, speed at its edges. `oracle("hops"
    | "length" | "time")` gives the cheapest routes. `waits` is the mean waiting per passage of each edge so far, its
    end node included. `queued` is the number of robots that wait now to leave an edge by its end node, or are held up
    on it.
    """

    graph: nx.DiGraph
    oracle: Callable[[Any], Oracle]
    waits: Mapping[tuple[str, str], float]
    queued: Callable[[tuple[str, str]], int]
    speed: float
    node_time: float
    contact: float
    turning: Callable[[str, str, str], float] | None = None
    """Turning time of a robot on the second node, between the first and the third; None: no time."""
    node_times: Mapping[str, float] = field(default_factory=dict)
    """The times at nodes that differ from `node_time`."""
    closed_for: Callable[[tuple[str, str], float], float] | None = None
    """The wait of a robot that reaches an edge after a time, because it is closed; inf: it never opens again.

    Closures are known by their calendars. A person in the edge now is assumed to stay for the mean remaining time of a
    stay, and later visits are not known. None: no edge ever closes.
    """
    shut_for: Callable[[tuple[str, str], float], float] | None = None
    """The wait of a robot that reaches an edge, for `traffic.closures` alone, known for all times; None: none.

    It counts from the stop line before the edge, where a robot is let in or waits.
    """
    limit: Callable[[tuple[str, str]], float] | None = None
    """The speed limit on an edge now; None: always the `speed` of the graph."""

    def time_at(self, node: str) -> float:
        """Return the time spent at a node on reaching it: `node_time`, or the node's own."""
        return self.node_times.get(node, self.node_time)


class Routing(Protocol):
    """Decides which route a robot takes."""

    def route(self, origin: str, goal: str, roads: Roads) -> Sequence[str]:
        """Return the nodes from origin to goal, both included."""


class Charging(Protocol):
    """Decides when a robot leaves its work to charge, where it charges, and when it is ready again.

    A policy with the attribute `fixed = True` guarantees that the levels depend on a robot's capacity and threshold
    only: it is called once in a run.
    """

    def levels(self, robot: RobotView) -> Levels:
        """Return the battery levels that hold for a robot now."""


class TaskBatch(NamedTuple):
    """Tasks that one robot does on one tour: their numbers, in the order of picking.

    `at`: the earliest time of the batch; until then the batching policy is called again at each new task.
    """

    tasks: tuple[int, ...]
    at: float = 0.0


@dataclass(frozen=True, slots=True)
class WaitingTasks:
    """Tasks that a batching policy may combine, none of them in a batch yet, in order of release.

    They have one load type and are for the same kinds of robots, which carry up to `most` loads. `to_come`: whether
    more of them will become known in any case; with tasks that are always open none are.
    """

    time: float
    tasks: Sequence[Task]
    most: int
    to_come: bool
    travel: Travel


class Batching(Protocol):
    """Decides which tasks a robot does on one tour."""

    def batches(self, waiting: WaitingTasks) -> Iterable[TaskBatch]:
        """Return batches of waiting tasks, each task in at most one; tasks left out wait until a new task arrives.

        Called at the end of every instant at which a task has become known, and at the first `at` to come.
        """


class Parking(Protocol):
    """Decides where an idle robot goes.

    With the class attribute `dwells = True` robots rest where they unloaded until the place is needed, and call only
    then.
    """

    def choose(self, robot: RobotView, bays: Sequence[BayView], travel: Travel) -> str:
        """Return the node of one of the given bays; every bay has a free slot."""
