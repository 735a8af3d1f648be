"""The stops of a task or tour: where a robot loads, hands over and unloads, in what order, and how long that takes.

All loads of a tour are picked in the order of its members. Each time the robot goes to the one that is soonest reached,
of all to which its loads go next.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeVar

from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.policies import Handling, Task
from desim_warehouse.policies.protocols import StopPlace
from desim_warehouse.policies.situation import Act
from desim_warehouse.world.places.station import Station

T = TypeVar("T")


@dataclass(slots=True, eq=False)
class Stop:
    """A stop for a task: it is loaded, handed over on its way (`visit`), or unloaded.

    At `node`, in the `station` beside it (None: in the lane), or `offset` beyond the start of `edge`, whose end
    is `node` then; a stop at a node has it for both ends of `edge`. `rank`: which visit of its task it is, from 0.
    `joins`: a robot may come to it from one before it on the same edge, without leaving that.
    """

    task: Task
    act: Act
    node: str
    edge: tuple[str, str]
    offset: float
    station: Station | None
    rank: int = 0
    joins: bool = False

    def of(self, handling: Handling[T]) -> T:
        """Return the time of a stop like this, by some handling times."""
        return handling.at_stop(self.act, self.task.flow, None if self.station is None else self.station.node)


def stops_of_tour(
    tour: Task,
    travel: FreeTravel,
    make_stop: Callable[[Task, Act, StopPlace, str], Stop],
) -> list[Stop]:
    """Return the stops of a tour in the order in which they are made.

    `make_stop` makes one at a node or storage place, chosen for a robot that comes from a node.
    """
    stops = []
    for task in tour.tasks:
        node = task.edge[1]
        place = StopPlace((node,), None if task.edge[0] == node else (task.edge, task.offset))
        stops.append(make_stop(task, "load", place, node))
    ahead = {task.number: [*task.via, StopPlace(task.to, task.drop)] for task in tour.tasks}
    tasks = {task.number: task for task in tour.tasks}
    while ahead:
        last = stops[-1]
        next_ones = []
        for number, places in ahead.items():
            act: Act = "visit" if len(places) > 1 else "unload"
            stop = make_stop(tasks[number], act, places[0], last.edge[1])
            stop.rank = len(tasks[number].via) + 1 - len(places)
            next_ones.append(stop)
        stops.append(min(next_ones, key=lambda stop: between(travel, stops[-1], stop)))
        number = stops[-1].task.number
        del ahead[number][0]
        if not ahead[number]:
            del ahead[number]
    for stop in stops:
        stop.joins = True
    return stops


# Free driving and handling


def between(travel: FreeTravel, last: Stop, stop: Stop) -> float:
    """Return the free driving time from one stop of a tour to the next."""
    before, _ = travel.along(stop.edge, stop.offset)
    passed, rest = travel.along(last.edge, last.offset)
    if stop.edge == last.edge and stop.offset >= last.offset:
        return before - passed + travel.stop_time
    return rest + travel.from_edge(last.edge, stop.edge[0]) + travel.half_turn + before


def driven(travel: FreeTravel, stops: Sequence[Stop]) -> float:
    """Return the free driving time from the first of some stops to the end of the edge of the last."""
    last = stops[-1]
    return (
        sum(between(travel, earlier, later) for earlier, later in pairwise(stops))
        + travel.along(last.edge, last.offset)[1]
    )


def handled(handling: Handling[float], stops: Sequence[Stop]) -> float:
    """Return the mean handling time at some stops."""
    return sum(time_at(handling, stop) for stop in stops)


def time_at(handling: Handling[float], stop: Stop) -> float:
    """Return the mean handling time at a stop; where a pod stops on its way, for each line that it is called for."""
    time = stop.of(handling)
    return stop.task.lines * time if stop.act == "visit" else time
