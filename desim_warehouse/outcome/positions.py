"""Positions of all robots at any time, reconstructed from the log of a run alone.

For the replay, and for `Run.positions`.

A robot's path is a chain of *legs*, each from one position on an edge to another at constant speed; after a leg the
robot stands. In this module, the slots of a bay or station are joined to their node by short edges. A robot in a slot
stands at the start of its edge, and drives to the end in the exit time of the model. Places beside lanes in wide aisles
have such edges too: a robot that loads there stands at the start.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from desim_warehouse.model.sections.fleet import Start
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.log import LogRow
from desim_warehouse.outcome.zones import Zone, zones
from desim_warehouse.states import BROKEN, STATES
from desim_warehouse.values.arrays import Floats, Ints

EPS = 1e-6
"""Length units from the end of an edge within which a robot is at its end."""


@dataclass(frozen=True)
class Edges:
    """All edges as straight lines: edges of the layout, then edges of the slots of zones and of places beside lanes."""

    source: list[str]
    """The node at which each edge begins, or to whose bay or station its slot belongs."""
    target: list[str]
    start: Floats
    """x and y of the start of each edge, a row each, in the units of the layout."""
    end: Floats
    length: Floats
    real: int
    """The number of edges of the layout, which come first."""
    twin: Ints
    """For each edge of the layout, the number of the opposite edge of its two-way lane, or -1 if it is one-way."""
    beside: dict[tuple[str, float], int]
    """The numbers of the edges of places beside lanes, by lane (`A>B`) and position along it."""

    def points(self, edge: Ints, position: Floats) -> Floats:
        """Return the points at positions along edges, in length units: a row of x and y each."""
        part = np.divide(position, self.length[edge], out=np.zeros(len(edge)), where=self.length[edge] > 0)
        points: Floats = self.start[edge] + part[:, None] * (self.end[edge] - self.start[edge])
        return points

    def headings(self, edge: Ints) -> Floats:
        """Return the directions of edges, in radians from x towards y."""
        way = self.end[edge] - self.start[edge]
        return np.arctan2(way[:, 1], way[:, 0])


@dataclass(frozen=True)
class Legs:
    """All legs of all robots, robot by robot, in order of time.

    Legs of robot i are `first[i]` to `first[i + 1]` - 1. `begin`, `end`: times. `edge`: number in `Edges`. `origin`,
    `target`: positions along the edge, in length units.
    """

    first: Ints
    begin: Floats
    end: Floats
    edge: Ints
    origin: Floats
    target: Floats


class Positions:
    """The positions of all robots during a run; raises ReportError without `log: all`."""

    def __init__(self, history: History) -> None:
        history.need_all("where robots are")
        self.zones = zones(history.model, history.layout)
        self.edges = _edges(history, self.zones)
        self.legs = _Follower(history, self.zones, self.edges).legs()

    def at(self, time: float) -> tuple[Ints, Floats]:
        """Return the number of each robot's edge at a time, and its position along the edge in length units."""
        legs = self.legs
        index = np.empty(len(legs.first) - 1, dtype=np.int64)
        for robot, (low, high) in enumerate(zip(legs.first, legs.first[1:], strict=False)):
            later = int(np.searchsorted(legs.begin[low:high], time, side="right"))
            index[robot] = low + max(later - 1, 0)
        return self._along(index, np.full(len(index), time))

    def of(self, robot: int, times: Floats) -> tuple[Ints, Floats]:
        """Return the numbers of a robot's edges at some times, and its positions along them in length units."""
        low, high = self.legs.first[robot : robot + 2]
        later = np.searchsorted(self.legs.begin[low:high], times, side="right")
        return self._along(low + np.maximum(later - 1, 0), times)

    def _along(self, leg: Ints, times: Floats) -> tuple[Ints, Floats]:
        """Return the edge of each leg, and the position along it at the time of the same index."""
        legs = self.legs
        begin, end = legs.begin[leg], legs.end[leg]
        lasts = end > begin
        part = np.clip(np.divide(times - begin, end - begin, out=np.ones(len(leg)), where=lasts), 0, 1)
        origin, target = legs.origin[leg], legs.target[leg]
        return legs.edge[leg], origin + part * (target - origin)

    def last_nodes(self, edge: Ints, position: Floats) -> list[str]:
        """Return the last node that each robot reached, from positions along edges."""
        is_at_end = position >= self.edges.length[edge] - EPS
        ends = zip(edge.tolist(), is_at_end.tolist(), strict=True)
        return [self.edges.target[n] if at_end else self.edges.source[n] for n, at_end in ends]

    def points(self, time: float) -> Floats:
        """Return the point of every robot at a time, a row of x and y each, in the units of the layout."""
        return self.edges.points(*self.at(time))

    def headings(self, time: float) -> Floats:
        """Return the direction that every robot faces at a time, in radians from x towards y."""
        return self.edges.headings(self.at(time)[0])


def _edges(history: History, places: Sequence[Zone]) -> Edges:
    graph = history.layout.graph
    point_of = {node: (data["x"], data["y"]) for node, data in graph.nodes(data=True)}
    source, target = [a for a, _ in graph.edges], [b for _, b in graph.edges]
    start, end = [point_of[node] for node in source], [point_of[node] for node in target]
    length = [float(data["length"]) for _, _, data in graph.edges(data=True)]
    real = len(length)
    number = {edge: rank for rank, edge in enumerate(graph.edges)}
    twin = [number[b, a] if two_way else -1 for a, b, two_way in graph.edges(data="two_way")]
    for zone in places:
        for point in zone.places:
            source.append(zone.node)
            target.append(zone.node)
            start.append(point)
            end.append(point_of[zone.node])
            length.append(math.dist(point, point_of[zone.node]))
    beside = {}
    for row in history.rows("aside"):
        assert row.edge is not None
        assert row.value is not None
        if (place := _place(row)) not in beside:
            beside[place] = len(length)
            source.append(row.edge[0])
            target.append(row.edge[1])
            start.append(_point_beside(history, row.edge, row.value))
            end.append(point_of[row.edge[1]])
            length.append(math.dist(start[-1], end[-1]))
    points = np.array(start, float), np.array(end, float)
    return Edges(source, target, *points, np.array(length), real, np.array(twin, np.int64), beside)


def _place(row: LogRow) -> tuple[str, float]:
    """Return the lane beside which a robot stands, and its position along the lane."""
    assert row.edge is not None
    assert row.value is not None
    return ">".join(row.edge), round(row.value, 6)


def _point_beside(history: History, edge: tuple[str, str], offset: float) -> tuple[float, float]:
    """Return the point of a robot beside its lane, at distance D on the side of the storage place."""
    layout = history.layout
    (x, y), heading = layout.position(edge, offset), layout.headings[edge]
    aside = -math.sin(heading), math.cos(heading)  # to the right, as y grows downwards
    near = min(
        (place for place in layout.storage if set(place.edge) == set(edge)),
        key=lambda place: math.dist((place.x, place.y), (x, y)),
        default=None,
    )
    right = near is None or (near.x - x) * aside[0] + (near.y - y) * aside[1] >= -EPS
    shift = history.model.fleet.contact * (1 if right else -1)
    return x + shift * aside[0], y + shift * aside[1]


class _Berths:
    """The slots of one zone; a robot takes the nearest free slot."""

    def __init__(self, first_edge: int, count: int) -> None:
        self.free = list(range(first_edge, first_edge + count))
        self.last = first_edge + count - 1

    def take(self) -> int:
        """Take a free slot and return the edge that joins it to the node."""
        return heapq.heappop(self.free) if self.free else self.last

    def leave(self, edge: int) -> None:
        """Make a slot free again."""
        if edge not in self.free:
            heapq.heappush(self.free, edge)


class _Follower:
    """Follow every robot through the rows of a log, and note its legs."""

    def __init__(self, history: History, places: Sequence[Zone], edges: Edges) -> None:
        self.history = history
        self.edges = edges
        self.number = {edge: number for number, edge in enumerate(history.layout.graph.edges)}
        self.berths: dict[tuple[str, str], _Berths] = {}
        edge = edges.real
        for zone in places:
            self.berths[zone.kind, zone.node] = _Berths(edge, len(zone.places))
            edge += len(zone.places)
        count = history.model.fleet.size
        self.on = [0] * count
        self.position = [0.0] * count
        self.fresh = [False] * count
        self.inside: list[tuple[_Berths, int, str] | None] = [None] * count
        self.resting = [0.0] * count
        self.exit = [history.model.fleet.first_exit_time] * count
        self.rows: list[tuple[int, float, float, int, float, float]] = []

    def legs(self) -> Legs:
        """Return all legs of the run."""
        for robot, start in enumerate(self.history.starts):
            if start.on_lanes:
                self._stand(robot, start)
            else:
                self._settle(0.0, robot, "bay", start.node)
        for row in self.history.rows("drive", "enter", "parked", "docked", "aside", "back", *STATES):
            if row.kind == "drive":
                self._drive(row)
            elif row.kind == "aside":
                self._note(row.robot, row.time, row.time, self.edges.beside[_place(row)], 0.0, 0.0)
            elif row.kind == "back":
                position = self.position[row.robot]
                self._note(row.robot, row.time, row.time, self._number(row), position, position)
            elif row.kind in BROKEN:
                self._come_out(row.robot, row.time)
            elif row.kind == "enter":
                self._enter(row)
            elif row.kind == "parked":
                self._settle(row.time, row.robot, "bay", row.node)
                self.exit[row.robot] = self.history.model.fleet.exit_time
            elif row.kind == "docked":
                self._settle(row.time, row.robot, "station", row.node)
                self.exit[row.robot] = self.history.model.tasks.clear_time
            else:
                self.resting[row.robot] = row.time
        return self._sorted()

    def _stand(self, robot: int, start: Start) -> None:
        """Note that a robot begins on the lanes: on an edge, or on a node, at the start of one of its edges."""
        edge = start.edge or next(iter(self.history.layout.graph.out_edges(start.node)))
        self.on[robot], self.position[robot] = self.number[edge], start.offset
        self._note(robot, 0.0, 0.0, self.number[edge], 0.0, start.offset)

    def _settle(self, time: float, robot: int, kind: str, node: str | None) -> None:
        """Note that a robot is in a bay or station from `time` on."""
        assert node is not None
        inside = self.inside[robot]
        berths = self.berths[kind, node]
        if inside is not None:
            if inside[0] is berths:
                return
            inside[0].leave(inside[1])
        edge = berths.take()
        self.inside[robot] = (berths, edge, kind)
        self.resting[robot] = time
        self._note(robot, time, time, edge, 0.0, 0.0)

    def _enter(self, row: LogRow) -> None:
        """Note that a robot's centre leaves a node for an edge, with the drive to the node if it was in a slot."""
        robot, time = row.robot, row.time
        inside = self.inside[robot]
        if inside is not None:
            self._leave_berth(robot, time, inside)
        self.on[robot] = self._number(row)
        self.position[robot] = 0.0
        self.fresh[robot] = True

    def _leave_berth(self, robot: int, time: float, inside: tuple[_Berths, int, str]) -> None:
        """Note that a robot is on the node beside its bay or station at `time`."""
        berths, place, _ = inside
        since = max(self.resting[robot], time - self.exit[robot])
        self._note(robot, since, time, place, 0.0, float(self.edges.length[place]))
        berths.leave(place)
        self.inside[robot] = None

    def _come_out(self, robot: int, time: float) -> None:
        """Note that a robot broke down; no robot breaks down in a bay, so it is drawn on the lane."""
        inside = self.inside[robot]
        if inside is not None and inside[2] == "bay":
            self._leave_berth(robot, time, inside)

    def _drive(self, row: LogRow) -> None:
        """Note that a robot sets off along its edge."""
        robot, time, edge = row.robot, row.time, self._number(row)
        assert row.value is not None
        assert row.until is not None
        target, until = row.value, row.until
        if edge != self.on[robot]:  # this row comes before the row of the change
            self.on[robot], self.position[robot], self.fresh[robot] = edge, 0.0, True
        origin = self.position[robot]
        if self.fresh[robot] or origin != target:
            self._note(robot, time, max(until, time), edge, origin, target)
        self.position[robot] = target
        self.fresh[robot] = False

    def _number(self, row: LogRow) -> int:
        assert row.edge is not None
        return self.number[row.edge]

    def _note(self, robot: int, begin: float, end: float, edge: int, origin: float, target: float) -> None:
        self.rows.append((robot, begin, end, edge, origin, target))

    def _sorted(self) -> Legs:
        table: Any = np.array(self.rows, dtype=float)
        robot = table[:, 0].astype(np.int64)
        order = np.argsort(robot, kind="stable")
        first = np.searchsorted(robot[order], np.arange(len(self.on) + 1))
        _, begin, end, edge, origin, target = table[order].T
        return Legs(first, begin, end, edge.astype(np.int64), origin, target)
