"""Warehouses of guidance graph optimisation (GGO, PIBT benchmarks) for `desim import`: JSON with rows of a grid.

`layout` holds the rows: `@` shelf, `T` blocked, `e` endpoint, `.` aisle, `w` workstation, `r` home of a robot. Goods
are picked at endpoints and delivered to workstations or, without any, to other endpoints. `weights` is used if `weight`
is true. It begins with the weights of waiting: one for all, or one per cell. The weights of driving east, north, west
and south follow, for every free cell, row by row, if these neighbours are free.
Source: Y. Zhang et al., Guidance graph optimization for lifelong multi-agent path finding, 2024, and its maps.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from desim_warehouse.errors import got
from desim_warehouse.model.json_text import read_json
from desim_warehouse.plants.grid import AISLE, BLOCKED, Cell, CellKind, Grid, Lines, not_too_many, plant_of, refuse
from desim_warehouse.plants.grid_kiva import ENDPOINT, HOME
from desim_warehouse.plants.plant import Plant

_KINDS = {"@": BLOCKED, "T": BLOCKED, ".": AISLE, "e": ENDPOINT, "r": HOME, "w": CellKind("workstation", ("unload",))}
_PICK = CellKind("endpoint", ("load",))
_EXPECTED = "a grid with the key layout, a list of rows (JSON)"
_TURNS = ((0, 1), (-1, 0), (0, -1), (1, 0))
_COUNTS = {"n_endpoint": "e", "n_agent_loc": "r", "n_shelf": "@", "n_workstation": "w"}
_USED = {"name", "layout", "weight", "weights", "n_row", "n_col", "optimize_wait", *_COUNTS}

_LEAST, _MOST = 1e-6, 1e6


def looks(_: Path, start: bytes) -> bool:
    """Return whether a file may be such a grid: JSON with a layout, or with the size of one."""
    return start.startswith(b"{") and any(key in start for key in (b'"layout"', b'"n_row"', b'"n_endpoint"'))


def read(path: Path, content: bytes, cell: float = 1.0) -> Plant:
    """Read a grid whose cells have a side of `cell` metres.

    Raises:
        ModelError: a file that cannot be read, with the position.
    """
    head = read_json(path, content, _EXPECTED)
    rows = head.get("layout") if isinstance(head, dict) else None
    if not isinstance(rows, list) or not rows or not all(isinstance(row, str) for row in rows):
        refuse(path, f"no rows of cells, expected {_EXPECTED}")
    lines = Lines(path, [row.rstrip() for row in rows])
    width = _number(head, "n_col", len(lines.lines[0]), path)
    if _number(head, "n_row", len(rows), path) != len(rows):
        refuse(path, f"layout: {len(rows)} rows, expected {head['n_row']} as n_row says")
    for rank, row in enumerate(lines.lines):
        lines.row(row, rank, width, _KINDS)
    kinds = {**_KINDS, "e": _PICK} if any("w" in row for row in lines.lines) else _KINDS
    grid = Grid(lines.lines, kinds)
    not_too_many(path, sum(1 for _ in grid.free()))
    name = head.get("name")
    weights = _weights(head, grid, path) if head.get("weight") else {}
    plant = plant_of(name if isinstance(name, str) and name else path.stem, f"{path.name} (grid)", grid, cell, weights)
    _counted(head, lines.lines, plant)
    plant.note(
        "left out", "key", [key for key in head if key not in _USED and head[key] is not None], "not of a layout"
    )
    if weights:
        why = (
            "of the weights of a lane's two directions only the ratio counts, as how far it counts to drive against it"
        )
        plant.note("changed", "weight", ["weights"], why)
        plant.note("left out", "weight", ["of waiting"], "robots wait only where they have to")
    return plant


def _number(head: dict[str, Any], key: str, default: int, path: Path) -> int:
    value = head.get(key, default)
    if type(value) is not int or value < 1:
        refuse(path, f"{key}: not a number of cells (got {got(value)}), expected a whole number")
    return value


def _counted(head: dict[str, Any], rows: list[str], plant: Plant) -> None:
    """Note counts in the file that differ from its map."""
    for key, letter in _COUNTS.items():
        drawn = sum(row.count(letter) for row in rows)
        if key in head and head[key] != drawn:
            text = f"the file says {got(head[key])}, {drawn} are drawn; the drawing counts"
            plant.note("changed", "number", [key], text)


def _weights(head: dict[str, Any], grid: Grid, path: Path) -> dict[tuple[Cell, Cell], float]:
    """Return the weight of each step from a cell to a neighbour."""
    listed = head.get("weights")
    cells = list(grid.free())
    steps = [(cell, other) for cell in cells for turn in _TURNS if grid.kind(other := _next(cell, turn)).free]
    if not isinstance(listed, list) or len(listed) - len(steps) not in {0, 1, len(cells)}:
        count = f"{len(listed)} weights" if isinstance(listed, list) else "no list"
        expected = f"{len(steps)}, one for each step between neighbours, after one or {len(cells)} for waiting"
        refuse(path, f"weights: {count}, expected {expected}")
    ours = listed[len(listed) - len(steps) :]
    for rank, weight in enumerate(ours, len(listed) - len(steps)):
        if isinstance(weight, bool) or not isinstance(weight, int | float) or not _LEAST <= weight <= _MOST:
            refuse(path, f"weights[{rank}]: not a weight (got {got(weight)}), expected a number above 0")
    return dict(zip(steps, map(float, ours), strict=True))


def _next(cell: Cell, turn: tuple[int, int]) -> Cell:
    return cell[0] + turn[0], cell[1] + turn[1]
