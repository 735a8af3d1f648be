"""Problems of the League of Robot Runners for `desim import`: JSON that names a map, the robots and the tasks.

Robots start in the cells that the agents file lists. A task is a list of cells that one robot visits in this order: it
loads in the first and unloads in the last. Cells, including blocked ones, are numbered row by row from 0. Lines with
`#` are comments.
Source: the start kit of the League of Robot Runners, 2023 to 2026.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Any

from desim_warehouse.errors import ModelError, got
from desim_warehouse.model.json_text import read_json
from desim_warehouse.plants import grid_kiva, grid_movingai
from desim_warehouse.plants.file import content_of
from desim_warehouse.plants.grid import Lines, instant_handling, refuse
from desim_warehouse.plants.plant import Plant, Transport, Vehicle
from desim_warehouse.plants.stops import VISIT
from desim_warehouse.values.fields import LIMITS

_EXPECTED = "a problem of the League of Robot Runners (JSON) with mapFile, agentFile, taskFile and teamSize"
_TASKS = re.compile(rb"(#[^\n]*\n)*\d+[ \t]*\r?\n\d+([ \t]*,[ \t]*\d+)*[ \t]*\r?(\n|$)")
_COMMAS = r"\s*,\s*"
_LOST = {
    "numTasksReveal": "all tasks are known from the start",
    "delayConfig": "robots drive without random delays",
}
_USED = {"mapFile", "agentFile", "taskFile", "teamSize", "agentSize", "version"}


def looks(_: Path, start: bytes) -> bool:
    """Return whether a file may be such a problem: JSON that names a map."""
    return start.startswith(b"{") and b'"mapFile"' in start


def read(path: Path, content: bytes, cell: float = 1.0) -> Plant:
    """Read a problem whose cells have a side of `cell` metres.

    Raises:
        ModelError: a file that cannot be read, with the position.
    """
    head = read_json(path, content, _EXPECTED)
    if not isinstance(head, dict):
        refuse(path, f"not a problem (got {got(head)}), expected {_EXPECTED}")
    files = {key: _file(path, head, key) for key in ("mapFile", "agentFile", "taskFile") if key in head}
    if "mapFile" not in files:
        refuse(path, f"no mapFile, expected {_EXPECTED}")
    map_file = files["mapFile"]
    plant = grid_movingai.read(map_file, content_of(map_file, "a MovingAI map"), cell)
    plant.name, plant.source = path.stem, f"{path.name} (problem of the League of Robot Runners)"
    if "agentFile" in files:
        _agents(files["agentFile"], head, plant, cell, path)
    if "taskFile" in files:
        read_tasks(files["taskFile"], content_of(files["taskFile"], "tasks"), plant)
    for key, why in _LOST.items():
        plant.note("left out", "key", [key] if key in head else [], why)
    others = [key for key in head if key not in {*_USED, *_LOST}]
    plant.note("left out", "key", others, "not of a layout, its robots or tasks")
    return plant


def _file(path: Path, head: dict[str, Any], key: str) -> Path:
    """Return the path of a file that a problem file names under a key.

    The path is below the folder of the problem file as named, or else beside the problem file under its base name.
    """
    name = head[key]
    if not isinstance(name, str) or not name or "\0" in name or PurePosixPath(name).is_absolute() or ".." in name:
        refuse(path, f"{key}: not a file below the folder of the problem (got {got(name)}), expected its name")
    below, beside = path.parent / name, path.parent / PurePosixPath(name).name
    return below if below.exists() or not beside.exists() else beside


def _agents(path: Path, head: dict[str, Any], plant: Plant, cell: float, problem: Path) -> None:
    """Add the robots to a plant: as many as the team has, in the cells that the file lists."""
    starts = _listed(Lines.of(path, content_of(path, "agents"), "#"), plant, "agents", 1)
    team = head.get("teamSize", len(starts))
    if type(team) is not int or not 1 <= team <= len(starts):
        refuse(problem, f"teamSize: not so many (got {got(team)}), expected 1 to {len(starts)}, as agents are listed")
    size = head.get("agentSize", 1.0)
    if isinstance(size, bool) or not isinstance(size, int | float) or not 0 < size <= 1:
        refuse(problem, f"agentSize: not a part of a cell (got {got(size)}), expected a number above 0, at most 1")
    taken: dict[str, int] = {}
    for rank, (place, line) in enumerate(starts[:team]):
        here = plant.numbered[place[0]]
        if here in taken:
            raise ModelError([f"{path}:{line}: in the cell of agent {taken[here]}, expected one robot a cell"])
        taken[here] = rank
        plant.vehicles.append(Vehicle(f"agent {rank}", size * cell, cell, here, position=f"{path.name}:{line}"))
        plant.points[here] = replace(plant.points[here], parking=True)
    plant.assume("layout.bays", "robots park beside the cells in which they start, out of the way of others")


def looks_like_tasks(path: Path, start: bytes) -> bool:
    """Return whether a file may hold such tasks: comments, a number, and numbers with commas, or by its name.

    A number alone may be a task of one cell, or the horizon of MAPD.
    """
    named = path.suffix.lower() == ".tasks" or _TASKS.match(start) is not None
    return named and not grid_kiva.looks_like_tasks(path, start)


def read_tasks(path: Path, content: bytes, plant: Plant) -> None:
    """Add the tasks of a file to a plant.

    Raises:
        ModelError: a file that cannot be read, with the line.
    """
    tasks = _listed(Lines.of(path, content, "#"), plant, "tasks", None)
    for rank, (cells, line) in enumerate(tasks):
        names = [plant.numbered[cell] for cell in cells]
        operations = ["load", *[VISIT] * (len(names) - 2), "unload"]
        if len(names) == 1:
            names *= 2
        stops = tuple(zip(names, operations, strict=True))
        plant.transports.append(Transport(f"task {rank}", stops, position=f"{path.name}:{line}"))
    instant_handling(plant)


def _listed(lines: Lines, plant: Plant, what: str, each: int | None) -> list[tuple[list[int], int]]:
    """Return the lists of cells in a file, which begins with their number, each with its line number."""
    expected = "numbers of cells that robots can enter, such as 17" + ",203" * (each is None)
    number, lists = lines.number(f"the number of {what}"), []
    most = LIMITS["tasks"][0]
    if number > most:
        lines.refuse(f"too many {what} (got {number:,}), expected at most {most:,}")
    for line in lines.counted(number, f"{number} {what}"):
        cells = lines.numbers(line, 1, expected, _COMMAS)
        if each is not None and len(cells) != each:
            lines.refuse(f"not what it should be (got {got(line)}), expected {expected}")
        for cell in cells:
            if cell not in plant.numbered:
                lines.refuse(f"no cell that robots can enter (got {cell}), expected {expected}")
        lists.append((cells, lines.next))
    return lists
