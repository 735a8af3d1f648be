"""Grid maps (`.map`) of the MovingAI benchmarks and the League of Robot Runners, for `desim import`.

A file has `type octile`, `height H`, `width W`, `map`, then H rows. Robots can enter `.`, `G` and `S`, but not `@`,
`O`, `T` and `W`. If there are `E` cells, goods are delivered there and picked in the `S` cells (League of Robot
Runners).
Source: N. Sturtevant, Benchmarks for grid-based pathfinding, 2012; the start kit of the League of Robot Runners.
"""

from __future__ import annotations

from pathlib import Path

from desim_warehouse.errors import got
from desim_warehouse.plants.grid import AISLE, BLOCKED, CellKind, Grid, Lines, plant_of, point
from desim_warehouse.plants.plant import Plant

_KINDS = {
    **dict.fromkeys("@OTW", BLOCKED),
    **dict.fromkeys(".GS", AISLE),
    "E": CellKind("delivery", ("unload",)),
}
_PICK = CellKind("pick", ("load",))
_HEAD = "the lines 'type octile', 'height H', 'width W' and 'map' before the rows"


def looks(path: Path, start: bytes) -> bool:
    """Return whether a file may be such a map, by its first word or its ending."""
    return start[:5].lower().strip() == b"type" or path.suffix.lower() == ".map"


def read(path: Path, content: bytes, cell: float = 1.0) -> Plant:
    """Read a map whose cells have a side of `cell` metres.

    Raises:
        ModelError: a file that cannot be read, with the line.
    """
    grid = read_grid(path, content)
    plant = plant_of(path.stem, f"{path.name} (MovingAI map)", grid, cell, {})
    plant.numbered = {grid.number(cell): point(cell) for cell in grid.free()}
    return plant


def read_grid(path: Path, content: bytes) -> Grid:
    """Return the cells of a map."""
    lines, head = Lines.of(path, content), dict[str, str]()
    while (line := lines.take(_HEAD)).strip().lower() != "map":
        key, _, value = line.strip().partition(" ")
        if key.lower() not in {"type", "height", "width"} or key.lower() in head:
            lines.refuse(f"not what it should be (got {got(line)}), expected {_HEAD}")
        head[key.lower()] = value
    for key in ("height", "width"):
        if key not in head:
            lines.refuse(f"no {key}, expected {_HEAD}")
    height, width, *_ = lines.numbers(f"{head['height']} {head['width']}", 2, f"height and width as numbers in {_HEAD}")
    rows = lines.rows(height, width, _KINDS)
    is_league = any("E" in row for row in rows)
    return Grid(rows, {**_KINDS, "S": _PICK} if is_league else _KINDS)
