"""Drawn places of bays and stations: slots beside their node, away from edges, or on the node for a bay in the lane.

For drawings of the floor, the replay and the page of a run.

On a grid of cells, slots are inside the cell of their node, as other cells are beside it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from desim_warehouse.layout import Layout
from desim_warehouse.layout.layout import BayPlaces
from desim_warehouse.model import Model

Point = tuple[float, float]

SIDES: tuple[Point, ...] = ((0.0, -1.0), (0.0, 1.0), (-1.0, 0.0), (1.0, 0.0))
"""North, south, west, east."""
NEAR = 3.2
"""Distance from a node to the middle of the first slot, in radii: 40 px for the paper's robots."""
PITCH = 2.6
"""Distance between slots, in radii."""
NARROW = 2
"""Slots side by side if edges or another zone are near."""
_CELLS = 64
"""Fewest nodes of a floor that may be a grid of cells."""
_ROOMY = 8
"""Longest step from cell to cell, in radii."""
_INSIDE = 0.9
"""Share of the side of a cell that its slots take up."""
_ALIKE = 0.9
"""Least share of the edges of a grid that are steps."""
DEEP = 8
"""Largest number of slots in a row away from the node."""
MANY = 0.15
"""Largest length of a full row away from the node, as a share of the longer side of the floor, for more than `DEEP`."""
SPREAD = 0.85
"""Share of the shortest edge at a node that its slots may take up side by side."""


@dataclass(frozen=True)
class Zone:
    """A bay or station at a node, with the middle of every slot, the nearest to the node first."""

    kind: str
    name: str
    node: str
    places: tuple[Point, ...]
    room: float
    """The radius for which each slot has room; larger robots are drawn smaller there."""


def robot_radii(model: Model) -> list[float]:
    """Return the radius of every robot, by number."""
    return [robot.radius for robot in model.fleet.robots()]


def zones(model: Model, layout: Layout) -> list[Zone]:
    """Lay out all bays, then all stations: where each slot of them is drawn, and the radius it has room for."""
    start = model.fleet.homes(layout.bays)
    largest = max(robot_radii(model))
    cell = cell_size(model, layout)
    if cell:
        return _in_cells(model, layout, cell)
    result = []
    for node, bay in layout.bays.items():
        here = layout.graph.nodes[node]
        count = _slots(start, node, bay)
        beside = not here.get("in_lane")
        room = _room(layout, count, largest)
        slots = _places(layout, node, count, (largest, room), 0) if beside else ((here["x"], here["y"]),)
        result.append(Zone("bay", bay.zone, node, slots, room))
    for node, station in layout.stations.items():
        nth = 1 if node in layout.bays else 0
        room = _room(layout, station.places, largest)
        slots = _places(layout, node, station.places, (largest, room), nth)
        result.append(Zone("station", station.zone, node, slots, room))
    return result


@lru_cache(maxsize=32)
def _steps(layout: Layout) -> tuple[float, bool]:
    """Return the lower quartile of edge lengths, and whether nearly all edges are steps of this length along x or y."""
    point_of = {node: (data["x"], data["y"]) for node, data in layout.graph.nodes(data=True)}
    ways = [(point_of[b][0] - point_of[a][0], point_of[b][1] - point_of[a][1]) for a, b in layout.graph.edges]
    spans = sorted(math.hypot(*way) for way in ways)
    usual = spans[len(spans) // 4]
    fits = sum(abs(abs(dx + dy) - usual) < 1e-6 * usual and 0.0 in (dx, dy) for dx, dy in ways)
    return usual, fits > _ALIKE * len(ways)


def cell_size(model: Model, layout: Layout) -> float:
    """Return the side of the cells if the floor is a grid of cells with one robot each; else 0."""
    if layout.goods_size or len(layout.graph) < _CELLS:
        return 0.0
    usual, alike = _steps(layout)
    return usual if alike and usual <= _ROOMY * max(robot_radii(model)) else 0.0


def _slots(start: Sequence[str], node: str, bay: BayPlaces) -> int:
    """Return the number of slots of a bay; if the model gives none, the number of robots that start there."""
    return max(start.count(node) if bay.places is None else bay.places, 1)


def _in_cells(model: Model, layout: Layout, cell: float) -> list[Zone]:
    """Lay out slots in rows inside the cells of their nodes; a bay and a station at one node have half a cell each."""
    start, largest = model.fleet.homes(layout.bays), max(robot_radii(model))
    zones = [("bay", bay.zone, node, _slots(start, node, bay)) for node, bay in layout.bays.items()]
    zones += [("station", station.zone, node, station.places) for node, station in layout.stations.items()]
    made = []
    for kind, name, node, count in zones:
        here, shared = layout.graph.nodes[node], node in layout.bays and node in layout.stations
        high = _INSIDE * cell / (2 if shared else 1)
        middle = here["y"] + (0.0 if not shared else -high / 2 if kind == "bay" else high / 2)
        across = math.ceil(math.sqrt(count))
        wide, deep = _INSIDE * cell / across, high / math.ceil(count / across)
        places = []
        for number in range(count):
            row, column = divmod(number, across)
            x = here["x"] - _INSIDE * cell / 2 + (column + 0.5) * wide
            places.append((x, middle - high / 2 + (row + 0.5) * deep))
        made.append(Zone(kind, name, node, tuple(places), min(wide, deep, 2 * largest) / 2))
    return made


def _room(layout: Layout, count: int, radius: float) -> float:
    """Return the radius for which slots are drawn: a robot's, or less if so many slots would cover the floor.

    Imported plants have slots for the largest possible fleet.
    """
    if count <= DEEP:
        return radius
    longer = max(_reach(layout, side) + _reach(layout, other) for side, other in (SIDES[:2], SIDES[2:]))
    return min(radius, MANY * longer / (PITCH * DEEP))


def _places(layout: Layout, node: str, count: int, radii: tuple[float, float], nth: int) -> tuple[Point, ...]:
    """Return slots in rows that extend away from the node, no wider than the space before its neighbours.

    `radii`: the radius of robots, and the radius for which slots have room.
    """
    across, deep, free = _outward(layout, node, nth)
    here = layout.graph.nodes[node]
    x, y = here["x"], here["y"]
    lengths = [
        math.dist((x, y), (layout.graph.nodes[other]["x"], layout.graph.nodes[other]["y"]))
        for other in [*layout.graph.successors(node), *layout.graph.predecessors(node)]
    ]
    radius, room = radii
    pitch = PITCH * room
    narrow = not free or (node in layout.bays and node in layout.stations)
    fit = int(SPREAD * min(lengths, default=pitch) / pitch)
    most = NARROW if narrow else count if room == radius else DEEP
    wide = max(-(-count // DEEP), min(count, most, fit))
    places = []
    for number in range(count):
        row, column = divmod(number, wide)
        in_row = min(wide, count - row * wide)
        out = NEAR * radius + row * pitch
        side = (column - (in_row - 1) / 2) * pitch
        places.append((x + out * deep[0] + side * across[0], y + out * deep[1] + side * across[1]))
    return tuple(sorted(places, key=lambda place: round(math.dist(place, (x, y)), 9)))


@lru_cache(maxsize=32)
def _reach(layout: Layout, side: Point) -> float:
    """Return the coordinate of the outermost node on a side."""
    return float(max(side[0] * data["x"] + side[1] * data["y"] for _, data in layout.graph.nodes(data=True)))


def _outward(layout: Layout, node: str, nth: int) -> tuple[Point, Point, bool]:
    """Return unit vectors along and away from a zone, and whether the zone is outside the floor.

    A zone is placed towards the outside if possible, or else where there is no edge, or else between edges.
    """
    graph = layout.graph
    here = graph.nodes[node]
    angles = []
    for other in [*graph.successors(node), *graph.predecessors(node)]:
        neighbour = graph.nodes[other]
        angles.append(math.atan2(neighbour["y"] - here["y"], neighbour["x"] - here["x"]))

    def room(side: Point) -> float:
        """Return the angle to the nearest edge."""
        way = math.atan2(side[1], side[0])
        return min((abs(math.remainder(way - angle, math.tau)) for angle in angles), default=math.pi)

    def outside(side: Point) -> bool:
        """Whether no node lies farther out on this side."""
        return bool(side[0] * here["x"] + side[1] * here["y"] >= _reach(layout, side))

    half = math.sqrt(0.5)
    free = [side for side in SIDES if room(side) > math.pi / 4 - 1e-9]
    free.sort(key=lambda side: not outside(side))
    corners = [(sx * half, sy * half) for sy in (-1, 1) for sx in (1, -1)]
    corners.sort(key=room, reverse=True)
    chosen = (free + corners)[nth]
    return (-chosen[1], chosen[0]), chosen, outside(chosen)
