"""Kiva maps of the benchmarks of pickup and delivery (MAPD, RHCR) for `desim import`, and their files of tasks.

A map has four lines of numbers: its size in rows and columns, endpoints, agents, horizon. Then come the rows: `@`
shelf, `e` endpoint (goods are picked and delivered there), `r` home of a robot, `.` aisle. A file of tasks has their
number, optionally a line with the horizon, then lines `release pickup delivery ...`. An endpoint's number is its rank
among the `e` cells, row by row from 0.
Source: H. Ma et al., Lifelong multi-agent path finding for online pickup and delivery tasks, 2017.
"""

from __future__ import annotations

import re
from pathlib import Path

from desim_warehouse.plants.grid import AISLE, BLOCKED, CellKind, Grid, Lines, instant_handling, plant_of
from desim_warehouse.plants.plant import Plant, Transport, Vehicle

ENDPOINT = CellKind("endpoint", ("load", "unload"))
HOME = CellKind("home", parking=True)
_KINDS = {"@": BLOCKED, ".": AISLE, "e": ENDPOINT, "r": HOME}
_BEGIN = re.compile(rb"\d+[ \t]*[ \t,][ \t]*\d+[ \t]*\r?\n[ \t]*\d+[ \t]*\r?\n")
_BLANKS = r"\s+"
_TASK = "release, pickup and delivery, such as '12 3 41'"


def looks(_: Path, start: bytes) -> bool:
    """Return whether a file may be such a map: a line of two numbers, then a line of one."""
    return _BEGIN.match(start) is not None


def read(path: Path, content: bytes, cell: float = 1.0) -> Plant:
    """Read a map whose cells have a side of `cell` metres.

    Raises:
        ModelError: a file that cannot be read, with the line.
    """
    lines = Lines.of(path, content)
    size = "the numbers of rows and columns"
    height, width, *_ = lines.numbers(lines.take(size), 2, size)
    endpoints, agents, _ = (lines.number(f"the number of {what}") for what in ("endpoints", "agents", "steps"))
    grid = Grid(lines.rows(height, width, _KINDS), _KINDS)
    plant = plant_of(path.stem, f"{path.name} (kiva map)", grid, cell, {})
    homes = [spot.name for spot in plant.points.values() if spot.parking]
    ends = [name for location in plant.locations for name in location.operations]
    for what, count, drawn in (("endpoints", endpoints, len(ends)), ("agents", agents, len(homes))):
        if count != drawn:
            text = f"the head says {count}, {drawn} are drawn; the drawing counts"
            plant.note("changed", what[:-1], [f"{drawn} {what}"], text)
    plant.numbered = dict(enumerate(ends))
    plant.vehicles = [Vehicle(f"agent {rank}", cell, cell, home) for rank, home in enumerate(homes)]
    return plant


def looks_like_tasks(_: Path, start: bytes) -> bool:
    """Return whether a file may hold such tasks: one or two lines of one or two numbers, then three or more."""
    return re.match(rb"(\d+([ \t]+\d+)?[ \t]*\r?\n[ \t]*){1,2}\d+[ \t]+\d+[ \t]+\d+", start) is not None


def read_tasks(path: Path, content: bytes, plant: Plant) -> None:
    """Add the tasks of a file to a plant.

    Raises:
        ModelError: a file that cannot be read, with the line.
    """
    lines = Lines.of(path, content)
    number = lines.numbers(lines.take("the number of tasks"), 1, "the number of tasks", _BLANKS)[0]
    if len(lines.lines) > lines.next and lines.lines[lines.next].strip().isdecimal():
        lines.number("the horizon")
    for rank, line in enumerate(lines.counted(number, f"{number} tasks")):
        release, *ends = lines.numbers(line, 3, _TASK, _BLANKS)[:3]
        for end in ends:
            if end not in plant.numbered:
                most = f"a number from 0 to {len(plant.numbered) - 1}" if plant.numbered else "a map with endpoints"
                lines.refuse(f"no such endpoint (got {end}), expected {most}")
        names = [plant.numbered[end] for end in ends]
        stops = tuple(zip(names, ("load", "unload"), strict=True))
        plant.transports.append(Transport(f"task {rank}", stops, float(release), None, f"{path.name}:{lines.next}"))
    instant_handling(plant)
