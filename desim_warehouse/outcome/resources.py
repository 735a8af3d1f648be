"""Numbers of servers and chargers in use, and of robots that queue for them, over time.

For the stations on a run's page and in its replay.

Both come from the pieces of the account of time, so that utilisations and queues agree with the account. A server is in
use while a robot loads or unloads in the station. Needs `log: all`.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import defaultdict
from dataclasses import dataclass
from typing import TypeAlias

from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.model.facts.workers import staff
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.pieces import pieces
from desim_warehouse.states import SHOWN, Place
from desim_warehouse.values.calendars import ALWAYS, Hours

Steps: TypeAlias = tuple[list[float], list[int]]


@dataclass(frozen=True)
class Resource:
    """The servers of a station, or the chargers of a bay, during a run.

    `number`: number of servers or chargers. `busy`, `queue`: step functions of the number in use, and of robots that
    queue or wait for the station to open, as times from 0 on and the values from these times on. `hours`: opening hours
    of the station.
    """

    kind: Place
    zone: str
    node: str
    number: int
    busy: Steps
    queue: Steps
    hours: Hours = ALWAYS

    def utilisation(self, begin: float, end: float) -> float:
        """Return the utilisation of the servers or chargers between two times; nan if the times are equal.

        It is a share of the opening hours, and may exceed 1 if the station finishes loads after it closes.
        """
        return in_use(area(self.busy, begin, end), self.number, self.hours, begin, end)

    def mean_queue(self, begin: float, end: float) -> float:
        """Return the mean number of robots that queue between two times; nan if the times are equal."""
        return area(self.queue, begin, end) / (end - begin) if end > begin else float("nan")


def in_use(busy: float, number: int, hours: Hours, begin: float, end: float) -> float:
    """Return the share of busy time in the opening time of all servers; nan if they are never open."""
    time = number * (end - begin) * hours.share(begin, end)
    return busy / time if time > 0 else math.nan


def use_of_stations(history: History) -> dict[str, float]:
    """Return the utilisation of the servers of each station by node, for any level of the log.

    Logs before 0.4.0 have no such tallies; they need `log: all`, and give an empty dict without it.
    """
    begin, end, model = history.begin, history.end, history.model
    if history.log.stations is None:
        whole = resources(history) if history.log.level == "all" else []
        return {station.node: station.utilisation(begin, end) for station in whole if station.kind == "station"}
    shares = {}
    for row in history.log.stations:
        item = history.layout.stations[row["station"]]
        hours = model.hours(model.layout.stations[item.zone].hours)
        shares[row["station"]] = in_use(row["busy"], item.servers, hours, begin, end)
    return shares


def one_of(model: Model, resource: Resource) -> str:
    """Return the word for one of the servers of a station, or of the chargers of a bay."""
    return "charger" if resource.kind == "chargers" else staff(model, resource.zone)


def resources(history: History) -> list[Resource]:
    """Return all stations and, if the robots have batteries, the chargers of all bays with chargers."""
    layout = history.layout
    places: dict[tuple[Place, str], tuple[str, int]] = {
        ("station", node): (item.zone, item.servers) for node, item in layout.stations.items()
    }
    if history.model.battery is not None:
        for node, number in chargers_at(history.model, layout).items():
            places["chargers", node] = layout.bays[node].zone, number
    changes: defaultdict[tuple[str, str, str], list[tuple[float, int]]] = defaultdict(list)
    for robot in pieces(history):
        for piece in robot:
            state = SHOWN.get(piece.part)  # None: it waits in traffic
            if state is None or piece.node is None:
                continue
            for place, what in ((state.occupies, "busy"), (state.queue and state.queue.at, "queue")):
                if place is not None:
                    changes[place, piece.node, what] += [(piece.start, 1), (piece.end, -1)]
    hours = {name: history.model.hours(station.hours) for name, station in history.model.layout.stations.items()}
    return [
        Resource(
            kind,
            zone,
            node,
            number,
            steps(changes[kind, node, "busy"]),
            steps(changes[kind, node, "queue"]),
            hours[zone] if kind == "station" else ALWAYS,
        )
        for (kind, node), (zone, number) in places.items()
    ]


def steps(changes: list[tuple[float, int]]) -> Steps:
    """Return the step function of a number that is 0 at first and changes at (time, difference) pairs."""
    change: defaultdict[float, int] = defaultdict(int)
    for time, by in changes:
        change[time] += by
    times, counts, count = [0.0], [0], 0
    for time in sorted(change):
        if change[time]:
            count += change[time]
            if time <= 0:
                counts[0] = count
            else:
                times.append(time)
                counts.append(count)
    return times, counts


def area(curve: Steps, begin: float, end: float) -> float:
    """Return the integral of a step function between two times, in robots times time units."""
    times, counts = curve
    total, index = 0.0, max(bisect_right(times, begin) - 1, 0)
    while index < len(times) and times[index] < end:
        until = times[index + 1] if index + 1 < len(times) else end
        total += counts[index] * (min(until, end) - max(times[index], begin))
        index += 1
    return total
