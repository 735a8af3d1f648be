"""Grids of cells for `desim import`, as in path finding: free cells are points, joined by two-way lanes.

A cell is (row, column), rows downwards, both from 0; its point is called `r3c7`. `plant_of` makes a plant of the `Grid`
that a reader fills in.

If a grid names no places of work, every cell is assumed to have goods and a station, which the user can change. Cells
that robots cannot reach are reported.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, NoReturn

from desim_warehouse.errors import ModelError, got, spoken
from desim_warehouse.plants.plant import Link, Location, Plant, Waypoint
from desim_warehouse.values.fields import LIMITS

_ANY = float("inf")
Cell = tuple[int, int]
_DIGITS = 9


class CellKind(NamedTuple):
    """The meaning of a letter of a grid: the operations of robots in such a cell, and whether robots can enter it."""

    name: str
    operations: tuple[str, ...] = ()
    parking: bool = False
    free: bool = True


BLOCKED = CellKind("blocked", free=False)
AISLE = CellKind("aisle")


@dataclass(frozen=True)
class Grid:
    """Rows of letters of equal length, and the meaning of the letters."""

    rows: Sequence[str]
    kinds: Mapping[str, CellKind]

    def kind(self, cell: Cell) -> CellKind:
        """Return the kind of a cell; cells outside the grid are blocked."""
        row, column = cell
        if not (0 <= row < len(self.rows) and 0 <= column < len(self.rows[row])):
            return BLOCKED
        return self.kinds[self.rows[row][column]]

    def free(self) -> Iterator[Cell]:
        """Yield the cells that robots can enter, row by row."""
        for row, letters in enumerate(self.rows):
            for column, letter in enumerate(letters):
                if self.kinds[letter].free:
                    yield row, column

    def number(self, cell: Cell) -> int:
        """Return the number of a cell as planners count: row by row, including blocked cells."""
        return cell[0] * len(self.rows[0]) + cell[1]


def point(cell: Cell) -> str:
    """Return the name of the point of a grid cell, `r3c7` for row 3 and column 7."""
    return f"r{cell[0]}c{cell[1]}"


def plant_of(name: str, source: str, grid: Grid, side: float, weights: Mapping[tuple[Cell, Cell], float]) -> Plant:
    """Return a plant with a point in the middle of every free cell, and a lane between neighbours.

    Args:
        name: the name of the plant.
        source: the file and its format.
        grid: the cells.
        side: the side of a cell, in metres.
        weights: cost of each step from a cell to a neighbour in the choice of routes; empty: all equal. Only the ratio
            of the costs of a lane's two directions is used.
    """
    plant = Plant(name, source)
    places: dict[str, Location] = {}
    for cell in grid.free():
        kind, here = grid.kind(cell), point(cell)
        plant.points[here] = Waypoint(here, cell[1] * side, cell[0] * side, kind.parking)
        if kind.operations:
            places.setdefault(kind.name, Location(kind.name, {})).operations[here] = kind.operations
        for other in ((cell[0], cell[1] + 1), (cell[0] + 1, cell[1])):
            if grid.kind(other).free:
                plant.links.append(_lane(cell, other, weights))
    plant.locations = list(places.values())
    fit(plant, side)
    return plant


def fit(plant: Plant, side: float) -> None:
    """Assume that robots, which are not drawn, fill a cell of `side` metres, and drive one cell a second."""
    plant.cell = side
    plant.assume("fleet.robot.radius", f"as large as fits a cell of {side:g} m")
    plant.assume("fleet.robot.speed", "a cell a second")


def instant_handling(plant: Plant) -> None:
    """Assume that loading and unloading take no time, as in benchmarks."""
    plant.handling = 0.0
    for key in ("tasks.load_time", "tasks.unload_time"):
        plant.assume(key, "as in the benchmark: a visit takes no time")


def _lane(cell: Cell, other: Cell, weights: Mapping[tuple[Cell, Cell], float]) -> Link:
    ahead, back = weights.get((cell, other), 1.0), weights.get((other, cell), 1.0)
    if ahead > back:
        cell, other, ahead, back = other, cell, back, ahead
    names = point(cell), point(other)
    return Link("-".join(names), *names, speed_back=_ANY, against=back / ahead)


@dataclass
class Lines:
    """The lines of a text file, with line numbers for messages."""

    path: Path
    lines: list[str]
    next: int = 0
    comment: str = ""

    @classmethod
    def of(cls, path: Path, content: bytes, comment: str = "") -> Lines:
        """Decode a file in UTF-8 into lines, without blanks at line ends and blank lines at the end of the file."""
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = content.count(b"\n", 0, error.start) + 1
            problem = f"not text (got byte 0x{content[error.start]:02x}), expected a grid or its tasks as text"
            raise ModelError([f"{path}:{line}: {problem}"]) from None
        return cls(path, [line.rstrip() for line in text.rstrip().split("\n")], 0, comment)

    def __iter__(self) -> Lines:
        return self

    def __next__(self) -> str:
        """Return the next line that is not a comment."""
        while self.next < len(self.lines):
            self.next += 1
            line = self.lines[self.next - 1]
            if not self.comment or not line.startswith(self.comment):
                return line
        raise StopIteration

    def take(self, expected: str) -> str:
        """Return the next line; raise ModelError at the end of the file."""
        line = next(self, None)
        if line is None:
            self.refuse(f"the file ends here, expected {expected}")
        return line

    def number(self, expected: str) -> int:
        """Return the whole number in the next line; raise ModelError for any other content."""
        line = self.take(expected)
        number, *more = self.numbers(line, 1, expected)
        if more:
            self.refuse(f"more than one number (got {got(line)}), expected {expected}")
        return number

    def numbers(self, line: str, count: int, expected: str, between: str = r"[\s,]+") -> list[int]:
        """Return at least `count` whole numbers from 0 up in a line, separated by blanks or commas."""
        words = list(filter(None, re.split(between, line.strip())))
        if len(words) < count or not all(word.isdecimal() and len(word) <= _DIGITS for word in words):
            self.refuse(f"not what it should be (got {got(line)}), expected {expected}")
        return [int(word) for word in words]

    def counted(self, number: int, what: str, noun: str = "line") -> Iterator[str]:
        """Yield the last lines of the file, as many as its head states; raise ModelError for fewer or more.

        Args:
            number: the number of lines.
            what: what the lines are, with their number, for messages.
            noun: word for one further line.
        """
        for rank in range(number):
            yield self.take(f"{what} as the head of the file says; {rank} are there")
        if (more := next(self, None)) is not None:
            self.refuse(f"one more {noun} (got {got(more)}), expected {what} as the head of the file says")

    def rows(self, height: int, width: int, kinds: Mapping[str, CellKind]) -> list[str]:
        """Return the rows of a grid of this size, which are the last lines of the file."""
        if height < 1 or width < 1:
            self.refuse(f"a grid without cells (got {height} rows of {width}), expected at least one of each")
        made = []
        for row, line in enumerate(self.counted(height, f"{height} rows", "row")):
            self.row(line, row, width, kinds)
            made.append(line)
        not_too_many(self.path, sum(kinds[letter].free for line in made for letter in line))
        return made

    def row(self, line: str, row: int, width: int, kinds: Mapping[str, CellKind]) -> None:
        """Refuse a row of another width, and letters without a meaning."""
        if len(line) != width:
            self.refuse(f"row {row} has {len(line)} cells, expected {width} as the head of the file says")
        if strange := [column for column, letter in enumerate(line) if letter not in kinds]:
            letters = spoken(map(repr, kinds), "or")
            self.refuse(
                f"row {row}, column {strange[0]}: unknown cell (got {got(line[strange[0]])}), expected {letters}"
            )

    def refuse(self, text: str) -> NoReturn:
        """Raise ModelError for the line that was read last."""
        raise ModelError([f"{self.path}:{max(self.next, 1)}: {text}"])


def not_too_many(path: Path, free: int) -> None:
    """Refuse a grid with more free cells than a layout may have nodes, or with none."""
    most = LIMITS["nodes"][0]
    if not free:
        refuse(path, "no cell that robots can enter, expected some")
    if free > most:
        refuse(path, f"too many cells that robots can enter (got {free:,}), expected at most {most:,}")


def refuse(path: Path, text: str) -> NoReturn:
    """Raise ModelError for a file."""
    raise ModelError([f"{path}: {text}"])
