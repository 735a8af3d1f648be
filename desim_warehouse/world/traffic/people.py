"""People in the aisles: when they come, where to, and how long they stay.

They do not react to robots, so all visits could be drawn before a run. They are drawn as needed: the times of visits
from one random stream, and the aisle and stay of each visit from a stream of its own.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Sequence
from functools import cache, partial
from typing import NamedTuple, Protocol

from desim_warehouse.layout import Layout
from desim_warehouse.layout.layout import Edge
from desim_warehouse.layout.zones import edges_along
from desim_warehouse.model import Model
from desim_warehouse.model.facts.demand import demand
from desim_warehouse.model.sections.traffic import PeopleSpec
from desim_warehouse.values.calendars import Hours
from desim_warehouse.values.distributions import drawn, mean_left
from desim_warehouse.values.streams import Streams


class Claiming(Protocol):
    """A waiting claim of a robot, as people see it."""

    @property
    def begun(self) -> float:
        """Return the time since which the claim waits."""


class Passer(Protocol):
    """A robot on its way, as people see it."""

    @property
    def claim(self) -> Claiming | None:
        """The claim with which the robot waits."""


class Visit(NamedTuple):
    """A person in an aisle, on all its edges."""

    begin: float
    end: float
    edges: tuple[Edge, ...]


class Aisle:
    """An aisle visited by people of one source, and closed to robots while a person is in it."""

    wait = "waiting_person"
    is_person = True

    def __init__(self, source: PeopleSource, edges: tuple[Edge, ...]) -> None:
        self.source = source
        self.edges = edges
        self.busy_since = self.busy_until = -math.inf

    def closed_until(self, now: float) -> float:
        """Return when all people who are in the aisle now will have left."""
        self.source.come(now)
        return self.busy_until

    def opens_for(self, robot: Passer, now: float) -> float:
        """Return when all people in the aisle have left, or step aside for a robot that waits."""
        until, give_way = self.closed_until(now), self.source.spec.give_way
        if give_way is None or robot.claim is None:
            return until
        return min(until, max(robot.claim.begun, self.busy_since) + give_way.after)

    def expected_until(self, time: float, now: float) -> float:
        """Return when an aisle is expected to open for a robot that sees a person, with unknown time of arrival.

        That is after the mean remaining time of a stay, or sooner if people step aside for the robot.
        """
        if self.closed_until(now) <= now:
            return time
        left, give_way = now + self.source.mean_left, self.source.spec.give_way
        return left if give_way is None else min(left, time + give_way.after)


class PeopleSource:
    """People of one kind, with their `visits` so far."""

    def __init__(
        self, name: str, spec: PeopleSpec, aisles: Sequence[tuple[Edge, ...]], weights: Sequence[float] | None
    ) -> None:
        self.name = name
        self.spec = spec
        self.aisles = [Aisle(self, edges) for edges in aisles]
        self.weights = weights
        self.visits: list[Visit] = []
        self.mean_left = mean_left(spec.stay)
        self._arrivals: Iterator[float]
        self._next = math.inf

    def start(self, streams: Streams, hours: Hours, hour: float) -> None:
        """Set the random streams of a run, the `hours` in which people come, and an `hour` in its time units."""
        self._streams = streams
        self._arrivals = self._times(hours, hour)
        # Without an aisle to come to, which `desim check` refuses, nobody does.
        self._next = next(self._arrivals, math.inf) if self.aisles else math.inf

    def _times(self, hours: Hours, hour: float) -> Iterator[float]:
        """Iterate over the times at which people come: a Poisson process within opening hours."""
        if self.spec.per_hour is None:
            yield from sorted(self.spec.times)
            return
        gaps = self._streams.stream(f"people:{self.name}:arrivals")
        open_time = 0.0
        while math.isfinite(open_time):
            open_time += float(gaps.exponential(hour / self.spec.per_hour))
            time = hours.when_open(open_time)
            if math.isinf(time):
                return
            yield time

    def come(self, now: float) -> None:
        """Add all visits that have begun by now."""
        while self._next <= now:
            stream = cache(partial(self._streams.stream, f"people:{self.name}", len(self.visits)))
            which = 0 if len(self.aisles) == 1 else int(stream().choice(len(self.aisles), p=self.weights))
            aisle, end = self.aisles[which], self._next + drawn(self.spec.stay, stream)
            self.visits.append(Visit(self._next, end, aisle.edges))
            if aisle.busy_until < self._next:
                aisle.busy_since = self._next
            aisle.busy_until = max(aisle.busy_until, end)
            self._next = next(self._arrivals, math.inf)


def sources(model: Model, layout: Layout, inside: Container[Edge]) -> list[PeopleSource]:
    """Make the sources of people of a model.

    `inside` are edges within an intersection, which are no aisles.
    """
    made = []
    for name, spec in model.people.items():
        if spec.aisles:
            made.append(PeopleSource(name, spec, [edges_along(layout, line) for line in spec.aisles], None))
        else:
            aisles, weights = storage_aisles(model, layout, inside)
            made.append(PeopleSource(name, spec, aisles, weights))
    return made


def storage_aisles(model: Model, layout: Layout, inside: Container[Edge]) -> tuple[list[tuple[Edge, ...]], list[float]]:
    """Return the edges with storage places, each an aisle by itself, and their shares of demand, without `inside`."""
    demand_of: dict[tuple[Edge, ...], float] = {}
    for place, share in zip(layout.storage, demand(model, layout), strict=True):
        if place.edge[0] != place.edge[1] and place.edge not in inside:
            aisle = edges_along(layout, sorted(place.edge))
            demand_of[aisle] = demand_of.get(aisle, 0.0) + float(share)
    total = math.fsum(demand_of.values())
    return list(demand_of), [wanted / total if total else 1 / len(demand_of) for wanted in demand_of.values()]
