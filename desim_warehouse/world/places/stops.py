"""The stops of a task or tour: the places of loading, handover and unloading, their order and their times.

All loads of a tour are picked in the order of its members. Afterwards the robot goes each time to the stop that it
reaches soonest, among the next stops of its loads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeVar, cast

from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.policies import Handling, Task
from desim_warehouse.policies.protocols import StopPlace
from desim_warehouse.policies.situation import Act
from desim_warehouse.world.places.station import Station

T = TypeVar("T")


@dataclass(slots=True, eq=False)
class Stop:
    """A stop for a task: it is loaded, handed over on its way (`visit`), or unloaded.

    The stop is at `node`, in the `station` beside it (None: in the lane), or `offset` beyond the start of `edge`, whose
    end is then `node`; a stop at a node has it for both ends of `edge`. `rank` numbers the visits of its task from 0.
    `joins`: a robot may come to it from a previous stop on the same edge, without leaving that. `along`: it is handed
    over with another load of its order, in no time of its own.
    """

    task: Task
    act: Act
    node: str
    edge: tuple[str, str]
    offset: float
    station: Station | None
    rank: int = 0
    joins: bool = False
    along: bool = False

    def of(self, handling: Handling[T]) -> T:
        """Return the time of such a stop, by some handling times."""
        if self.along:
            return cast("T", 0.0)
        return handling.at_stop(self.act, self.task.flow, None if self.station is None else self.station.node)


def stops_of_tour(
    tour: Task,
    travel: FreeTravel,
    make_stop: Callable[[Task, Act, StopPlace, str], Stop],
    whole: Collection[str] = (),
) -> list[Stop]:
    """Return the stops of a tour in the order in which they are made.

    `make_stop` makes one at a node or storage place, for a robot that comes from a node. `whole`: flows whose orders
    are handed over whole, so that the loads of an order come one after the other.
    """
    stops = []
    for task in tour.tasks:
        node = task.edge[1]
        place = StopPlace((node,), None if task.edge[0] == node else (task.edge, task.offset))
        stops.append(make_stop(task, "load", place, node))
    order_of = {task.number: (task.flow, task.order) for task in tour.tasks if task.order and task.flow in whole}
    ranks = {order: rank for rank, order in enumerate(dict.fromkeys(order_of.get(task.number) for task in tour.tasks))}
    by_order = sorted(tour.tasks, key=lambda task: ranks[order_of.get(task.number)])
    ahead = {task.number: [*task.via, StopPlace(task.to, task.drop)] for task in by_order}
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
    handed_over = set()
    for stop in stops:
        stop.joins = True
        if stop.act == "unload" and stop.task.number in order_of:
            tote = order_of[stop.task.number], stop.node
            stop.along = tote in handed_over
            handed_over.add(tote)
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
        math.fsum(between(travel, earlier, later) for earlier, later in pairwise(stops))
        + travel.along(last.edge, last.offset)[1]
    )


def handled(handling: Handling[float], stops: Sequence[Stop]) -> float:
    """Return the mean handling time at some stops."""
    return math.fsum(time_at(handling, stop) for stop in stops)


def time_at(handling: Handling[float], stop: Stop) -> float:
    """Return the mean handling time at a stop; a pod that stops on its way is handled for each of its lines."""
    time = stop.of(handling)
    return stop.task.lines * time if stop.act == "visit" else time
