"""Log rows of closures and people, and counts of encounters between robots and people.

Neither depends on robots, so their rows are written at the end of a run, when the robots that were in an aisle at the
arrival of a person are counted, too.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from itertools import accumulate
from typing import NamedTuple

from desim_warehouse.layout import Layout
from desim_warehouse.layout.layout import Edge
from desim_warehouse.layout.zones import edges_of
from desim_warehouse.model import Model
from desim_warehouse.model.sections.fleet import Start
from desim_warehouse.outcome.log import PLACES, Log
from desim_warehouse.values.calendars import merged
from desim_warehouse.world.traffic.people import PeopleSource, Visit


def closed_stretches(model: Model, layout: Layout, end: float) -> dict[Edge, list[tuple[float, float]]]:
    """Return for each edge that closes by calendar its closed periods, from the start of a run to `end`."""
    closed: defaultdict[Edge, list[tuple[float, float]]] = defaultdict(list)
    for closure in model.traffic.closures.values():
        hours = model.hours(closure.hours)
        stretches = []
        begin, until = hours.following(0.0)
        while begin <= end:
            stretches.append((max(begin, 0.0), until))
            begin, until = hours.following(until) if math.isfinite(until) else (math.inf, math.inf)
        for edge in edges_of(layout, closure.members):
            closed[edge] = merged([*closed[edge], *stretches])
    return closed


def record_closures(log: Log, model: Model, layout: Layout, end: float) -> None:
    """Write a row when an edge closes, and when it opens."""
    for edge, stretches in closed_stretches(model, layout, end).items():
        for begin, until in stretches:
            log.closed(edge, begin, until)


def record_visits(log: Log, people: Iterable[PeopleSource], end: float) -> None:
    """Write rows when a person comes into an aisle, one for each edge, and when they leave, in order of time."""
    for source in people:
        source.come(end)
    for number, visit in enumerate(_in_order(people)):
        log.visit(number, visit.edges, visit.begin, visit.end)


def count_encounters(log: Log, people: Iterable[PeopleSource], starts: Sequence[Start]) -> None:
    """Add the people who came into an aisle with a robot to the robots' counts, and tally the visits of people.

    `visits` begin in the evaluation period; `time` is their time within it for all people, and `shared` the part with a
    robot in the aisle.
    """
    stays = _stays(log, starts)
    visits, time, shared = 0, [0.0], [0.0]
    for visit in _in_order(people):
        begin, end = max(visit.begin, log.begin), min(visit.end, log.end)
        if end < begin:
            continue
        counts = visit.begin >= log.begin
        visits += counts
        time.append(end - begin)
        present = []
        for edge in visit.edges:
            for robot, since, until in stays[edge].overlapping(visit.begin, end) if edge in stays else ():
                if counts and since <= visit.begin < until:
                    log.robots[robot]["encounters"] += 1
                if until > begin:
                    present.append((max(since, begin), min(until, end)))
        shared += [until - since for since, until in merged(present)]
    log.people = {"visits": visits, "time": math.fsum(time), "shared": math.fsum(shared)}


def _in_order(people: Iterable[PeopleSource]) -> list[Visit]:
    return sorted((visit for source in people for visit in source.visits), key=lambda visit: visit.begin)


Stay = tuple[int, float, float]
"""A robot's stay on an edge: its begin and end."""


class Stays(NamedTuple):
    """The stays of robots on an edge, in order of arrival, with the latest departure up to each.

    A robot that is cleared off the edge may leave it before the robots ahead of it.
    """

    each: list[Stay]
    latest: list[float]

    def overlapping(self, begin: float, end: float) -> Iterator[Stay]:
        """Iterate over robots that are there at some time from `begin` to `end`."""
        for rank in range(bisect_right(self.latest, begin), len(self.each)):
            robot, since, until = self.each[rank]
            if since >= end and since > begin:
                return
            if until > begin:
                yield robot, since, until


def _stays(log: Log, starts: Sequence[Start]) -> dict[Edge, Stays]:
    """Return the robots on each edge. The last may still be there at the end."""
    where: dict[int, tuple[Edge, float]] = {
        robot: (start.edge, 0.0) for robot, start in enumerate(starts) if start.edge is not None
    }
    stays: defaultdict[Edge, list[Stay]] = defaultdict(list)
    for row in log.of(*PLACES):
        if row.robot in where:
            left, since = where.pop(row.robot)
            stays[left].append((row.robot, since, row.time))
        if row.edge is not None:
            where[row.robot] = row.edge, row.time
    for robot, (edge, since) in where.items():
        stays[edge].append((robot, since, log.end))
    for each in stays.values():
        each.sort(key=lambda stay: stay[1:])
    return {edge: Stays(each, list(accumulate((stay[2] for stay in each), max))) for edge, each in stays.items()}
