"""Road networks of RHCR (`.grid`) for `desim import`, such as its sorting centre: a weight for each direction.

A file has `Grid size (x, y)`, `W,H`, the names of the columns, then a line for every cell, column by column: id, type,
station, x, y (upwards), and the weights of driving north, west, south and east, and of waiting; `inf` forbids it.
Robots take parcels at cells of the type Induct and drop them at cells of the type Eject.
Source: J. Li et al., Lifelong multi-agent path finding in large-scale warehouses, 2021, and its maps.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

from desim_warehouse.errors import got, spoken
from desim_warehouse.plants.grid import Lines, fit, not_too_many
from desim_warehouse.plants.plant import Link, Location, Plant, Waypoint

_OPERATIONS = {"Induct": ("load",), "Eject": ("unload",), "Travel": (), "Home": (), "Obstacle": ()}
_TURNS = ((0, 1), (-1, 0), (0, -1), (1, 0))
_COLUMNS = 10
_CELL = "id, type, station, x, y and five weights, such as 12,Travel,None,3,4,1,inf,1,inf,1"

_SIZE = "the numbers of columns and rows, such as 77,37"


class _Square(NamedTuple):
    x: int
    y: int
    kind: str
    station: str
    weights: tuple[float, ...]


def looks(path: Path, start: bytes) -> bool:
    """Return whether a file may be such a network, by its first words or its ending."""
    return start[:9].lower() == b"grid size" or path.suffix.lower() == ".grid"


def read(path: Path, content: bytes, cell: float = 1.0) -> Plant:
    """Read a network whose cells have a side of `cell` metres.

    Raises:
        ModelError: a file that cannot be read, with the line.
    """
    lines = Lines.of(path, content)
    lines.take("the line 'Grid size (x, y)'")
    width, height, *_ = lines.numbers(lines.take(_SIZE), 2, _SIZE)
    lines.take("the names of the columns")
    squares: dict[tuple[int, int], _Square] = {}
    for rank, line in enumerate(lines.counted(width * height, f"{width} x {height} cells")):
        square = _square(line, lines)
        if (square.x, square.y) != divmod(rank, height):
            place = "x {}, y {}".format(*divmod(rank, height))
            lines.refuse(f"cell {rank} is x {square.x}, y {square.y}, expected {place}: column by column")
        squares[square.x, square.y] = square
    plant = Plant(path.stem, f"{path.name} (road network of RHCR)")
    _fill(plant, squares, height, cell)
    not_too_many(path, len(plant.points))
    return plant


def _square(line: str, lines: Lines) -> _Square:
    words = [word.strip() for word in line.split(",")]
    if len(words) != _COLUMNS:
        lines.refuse(f"{len(words)} values (got {got(line)}), expected {_CELL}")
    if words[1] not in _OPERATIONS:
        lines.refuse(f"unknown type of a cell (got {got(words[1])}), expected {spoken(_OPERATIONS, 'or')}")
    _, x, y = lines.numbers(",".join((words[0], *words[3:5])), 3, _CELL)
    weights = []
    for word in words[5:9]:
        try:
            weight = float(word)
        except ValueError:
            weight = math.nan
        if not weight > 0:
            lines.refuse(
                f"not a weight (got {got(word)}), expected a number above 0, or inf where robots may not drive"
            )
        weights.append(weight)
    return _Square(x, y, words[1], words[2], tuple(weights))


def _fill(plant: Plant, squares: dict[tuple[int, int], _Square], height: int, side: float) -> None:
    """Add points, one-way links and locations; a cell without links to or from it is an obstacle."""
    weighted = []
    ends: set[str] = set()
    for square in squares.values():
        for (dx, dy), weight in zip(_TURNS, square.weights, strict=True):
            other = squares.get((square.x + dx, square.y + dy))
            if math.isinf(weight) or other is None or "Obstacle" in (square.kind, other.kind):
                continue
            names = _name(square), _name(other)
            ends.update(names)
            plant.links.append(Link("-".join(names), *names))
            if weight != 1:
                weighted.append("-".join(names))
    places: dict[str, Location] = {}
    for square in squares.values():
        if (name := _name(square)) not in ends:
            continue
        plant.points[name] = Waypoint(name, square.x * side, (height - 1 - square.y) * side, square.kind == "Home")
        if operations := _OPERATIONS[square.kind]:
            station = f"{square.kind} {square.station}"
            places.setdefault(station, Location(station, {})).operations[name] = operations
    plant.locations = list(places.values())
    plant.note("left out", "weight", weighted, "other than 1: robots drive at one speed")
    fit(plant, side)


def _name(square: _Square) -> str:
    return f"x{square.x}y{square.y}"
