"""Nodes and edges for `desim import` from two CSV files, as spreadsheets write them: `nodes.csv` and `edges.csv`.

- An Excel workbook has them as sheets `nodes` and `edges`.
- Other names work if one has `nodes` where the other has `edges`: `hall-nodes.csv` and `hall-edges.csv`. You may also
name a folder that has both.
- Numbers are in metres and metres per second, or have a unit in the cell (`600 mm`) or in the header (`x [mm]`, `speed
[km/h]`). Cells are separated by commas, semicolons or tabs; without commas, `9,5` is a number.
- `y` is downwards, as in model files. A column `north` in its place is upwards.
- `role` is what robots do there: load, unload, charge, park, or several (`charge + park`). Translate your own words
with `--operation "pick face=load"`. `station` is a name; nodes with equal names are one station.
- An edge is one-way unless `two_way` is yes, or `one_way` is no; `--two-way` makes all edges without an entry two-way.
`side_by_side` is for two lanes in opposite directions. Without a length, the straight distance counts; without a speed,
there is no limit.
- Other columns are left out and reported.
"""

from __future__ import annotations

import csv
import io
import math
import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from desim_warehouse.errors import ModelError, did_you_mean, got, reason, spoken
from desim_warehouse.model.workbook import NO_VALUE, RECALCULATE, rows_of, sheets_of
from desim_warehouse.plants.file import content_of
from desim_warehouse.plants.plant import Link, Location, Plant, Waypoint
from desim_warehouse.values.csv_rows import csv_rows
from desim_warehouse.values.fields import LIMITS, FrozenMap
from desim_warehouse.values.headings import heading
from desim_warehouse.values.units import TABLE, UnitNames, converted

NODE = {
    "name": ("name", "node", "id", "point", "node_id"),
    "x": ("x", "east", "pos_x", "position_x"),
    "y": ("y", "pos_y", "position_y"),
    "north": ("north", "y_up"),
    "role": ("role", "roles", "operation", "operations"),
    "station": ("station", "location"),
}
EDGE = {
    "name": ("name", "edge", "id", "edge_id"),
    "from": ("from", "source", "start", "from_node"),
    "to": ("to", "target", "end", "to_node"),
    "length": ("length", "distance"),
    "speed": ("speed", "max_speed", "speed_limit"),
    "speed_back": ("speed_back", "max_reverse_speed"),
    "two_way": ("two_way", "bidirectional", "both_ways"),
    "one_way": ("one_way", "oneway"),
    "side_by_side": ("side_by_side",),
}
"""Columns, each with the titles that tables have for it; the first one present counts."""
OSM = {"maxspeed": "km/h"}
"""Titles of columns in files of maps, with the unit of numbers without one there, as in OpenStreetMap."""
_KINDS = {"x": "length", "y": "length", "north": "length", "length": "length", "speed": "speed", "speed_back": "speed"}
_YES, _NO = {"yes", "true", "1", "x", "y", "ja", "wahr", "both"}, {"no", "false", "0", "", "-", "n", "nein", "falsch"}
_SEVERAL = re.compile(r"\s*[+;,|/]\s*")
_SHORTEST = 0.001
"""Smallest length in metres, and smallest speed in metres per second; smaller values are probably slips."""
_METRES = UnitNames()
_SHOWN = 30  # names in a message, at most

EXPECTED = "a table of nodes (CSV) with the columns name, x and y"
NODES_FILE, EDGES_FILE = "nodes.csv", "edges.csv"
"""Their names in a folder."""
_EDGES = "a table of edges (CSV) with the columns from and to"
_NODES, _EDGES_SHEET = re.compile("nodes|points", re.IGNORECASE), re.compile("edges|lanes|links", re.IGNORECASE)
_MOST = 1000  # columns
_DECIMAL = re.compile(r"[+-]?\d+,\d+")


def looks(path: Path, start: bytes) -> bool:  # noqa: ARG001 - as all formats
    """Return whether a file may be a table, by its ending."""
    return path.suffix.lower() in {".csv", ".tsv"}


def read(path: Path, content: bytes, *, two_way: bool = False) -> Plant:
    """Read a table of nodes and the table of edges beside it.

    Args:
        path: the table of nodes.
        content: its bytes.
        two_way: whether edges without an entry lead both ways.

    Raises:
        ModelError: a table that cannot be read, with the row and column.
    """
    beside = edges_beside(path)
    name = _NODES.sub("", path.stem).strip(" _-.") or path.absolute().parent.name
    plant = Plant(name, f"{path.name} and {beside.name} (CSV)")
    _read(plant, _Table.of_csv(path, content), _Table.of_csv(beside, content_of(beside, _EDGES)), two_way=two_way)
    return plant


def looks_like_book(path: Path, start: bytes) -> bool:
    """Return whether a file may be a workbook of Excel, by its ending and its first bytes."""
    return path.suffix.lower() in {".xlsx", ".xlsm"} and start.startswith(b"PK")


def read_book(path: Path, content: bytes, *, two_way: bool = False) -> Plant:  # noqa: ARG001 - read row by row
    """Read the sheets of nodes and edges of a workbook.

    Raises:
        ModelError: a workbook that cannot be read, with the row.
    """
    try:
        names = sheets_of(path)
        sheets = []
        for pattern, what in ((_NODES, "nodes"), (_EDGES_SHEET, "edges")):
            called = [name for name in names if pattern.fullmatch(name.strip())]
            called = called or [name for name in names if pattern.search(name)]
            if len(called) != 1:
                have = f"{'several sheets' if called else 'no sheet'} of {what} (got {spoken(called or names)})"
                raise ModelError([f"{path}: {have}, expected sheets nodes and edges"])
            sheets.append(_Table.of_sheet(path, called[0]))
        plant = Plant(path.stem, f"{path.name} (Excel)")
        _read(plant, *sheets, two_way=two_way)
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise ModelError([f"{path}: cannot be read ({reason(error)}), expected a workbook of Excel"]) from None
    return plant


def _read(plant: Plant, nodes: _Table, edges: _Table, *, two_way: bool) -> None:
    """Fill a plant from its two tables, and note the columns that are not read."""
    node_columns, edge_columns = nodes.columns(NODE), edges.columns(EDGE)
    node_columns.require(f"{nodes.place}1", "name", "x", *(() if "north" in node_columns.named else ("y",)))
    edge_columns.require(f"{edges.place}1", "from", "to")
    fill(plant, nodes.records(node_columns), edges.records(edge_columns), two_way=two_way)
    for table, columns in ((nodes, node_columns), (edges, edge_columns)):
        plant.note("left out", "column", columns.unread, f"of {table.name}: nothing that a layout has")


def edges_beside(path: Path) -> Path:
    """Return the path of the table of edges of a table of nodes: `edges` in place of `nodes` in its name."""
    if not _NODES.search(path.stem):
        text = f"{path}: a table whose name does not say what is in it, expected nodes.csv with edges.csv beside it"
        raise ModelError([text])
    return path.with_name(_NODES.sub(lambda match: "EDGES" if match[0].isupper() else "edges", path.stem) + path.suffix)


@dataclass(frozen=True, slots=True)
class Columns:
    """The columns of a table that are read: their titles, and their units; `unread` are the other titles."""

    named: Mapping[str, str]
    units: Mapping[str, float]
    unread: tuple[str, ...]

    @classmethod
    def of(
        cls,
        header: Iterable[str],
        headings: Mapping[str, tuple[str, ...]],
        where: str,
        bare: Mapping[str, str] = FrozenMap(),
    ) -> Columns:
        """Return the columns in a header; `bare`: units of titles that name none.

        Raises:
            ModelError: an unknown unit, or a column that occurs twice.
        """
        named: dict[str, str] = {}
        units: dict[str, float] = {}
        unread = []
        aliases = {
            heading(alias)[0]: (name, rank) for name, all_ in headings.items() for rank, alias in enumerate(all_)
        }
        best: dict[str, int] = {}
        for title in header:
            words, unit = heading(title)
            name, rank = aliases.get(words, ("", 0))
            if not name or (name in best and best[name] < rank):
                unread.append(title)
                continue
            if name in best:
                if best[name] == rank:
                    raise ModelError([f"{where}: column {got(title)} a second time, expected it once"])
                unread.append(named[name])
            named[name], best[name] = title, rank
            if unit := unit or bare.get(title):
                units[name] = _size(unit, name, f"{where}: column {got(title)}")
        return cls(named, {name: units[name] for name in named if name in units}, tuple(unread))

    def require(self, where: str, *names: str) -> None:
        """Raise ModelError for a table that lacks one of these columns."""
        for name in names:
            if name not in self.named:
                have = [title[:_SHOWN] for title in (*self.named.values(), *self.unread)][:12]
                shown, hint = spoken(have) if have else "none", did_you_mean(name, self.unread)
                raise ModelError([f"{where}: no column {name} (got {shown}), expected it{hint}"])


def _size(unit: str, name: str, where: str) -> float:
    kind = _KINDS.get(name)
    if kind is None or unit not in TABLE[kind]:
        expected = f"a unit of {kind} such as {'m' if kind == 'length' else 'm/s'}" if kind else "none here"
        raise ModelError([f"{where}: unit {got(unit)} is not known, expected {expected}"])
    return float(TABLE[kind][unit])


@dataclass(frozen=True, slots=True)
class TableRecord:
    """A row: its values by column, its place for messages, and its position in the file."""

    columns: Columns
    values: Mapping[str, Any]
    where: str
    position: str = ""

    def get(self, name: str) -> Any:
        """Return the value of a column; None for an empty cell or a missing column."""
        title = self.columns.named.get(name)
        value = None if title is None else self.values.get(title)
        if value == NO_VALUE:
            self.refuse(name, f"no value (got {got(value)}), expected one; {RECALCULATE}")
        return None if isinstance(value, str) and not value.strip() else value

    def refuse(self, name: str, text: str) -> NoReturn:
        """Raise ModelError for a value."""
        title = self.columns.named.get(name, name)
        raise ModelError([f"{self.where}: {title}: {text}"]) from None

    def text(self, name: str) -> str:
        """Return a required value as text."""
        value = self.get(name)
        if value is None:
            self.refuse(name, "empty, expected a name")
        return str(value).strip()

    def number(self, name: str) -> float | None:
        """Return a value in metres or metres per second; None for an empty cell, or for a speed without a limit."""
        value = self.get(name)
        if value is None:
            return None
        kind, number = _KINDS[name], math.nan
        try:
            number = float(value) * self.columns.units.get(name, 1.0)
        except (TypeError, ValueError, OverflowError):
            try:
                number = _or_nan(converted(str(value), kind, _METRES))
            except ValueError as error:
                self.refuse(name, str(error))
        if kind == "speed" and number == math.inf:
            return None
        if not abs(number) <= LIMITS["number"][0]:
            self.refuse(name, f"not a {kind} (got {got(value)}), expected a number")
        return number

    def above_0(self, name: str) -> float | None:
        """Return a length (m) or speed (m/s) above 0; None for an empty cell."""
        number = self.number(name)
        if number is not None and number < _SHORTEST:
            what = "too small" if number > 0 else "not above 0"
            self.refuse(name, f"{what} (got {got(self.get(name))}), expected at least {_SHORTEST:g}, or nothing")
        return number

    def flag(self, name: str) -> bool | None:
        """Return the truth value of yes or no; None for an empty cell."""
        value = self.get(name)
        word = str(value).strip().casefold()
        if value is None:
            return None
        if word not in _YES | _NO:
            self.refuse(name, f"neither yes nor no (got {got(value)}), expected one of the two")
        return word in _YES


def _or_nan(number: float | None) -> float:
    return math.nan if number is None else number


def of_maps(title: str) -> str:
    """Return the words for a column of maps whose numbers have the unit of OpenStreetMap."""
    return f"their '{title}' is in {OSM[title]}, as in OpenStreetMap; 'speed' is in m/s"


def fill(plant: Plant, nodes: Iterable[TableRecord], edges: Iterable[TableRecord], *, two_way: bool = False) -> None:
    """Add nodes and edges to a plant.

    Args:
        plant: the plant, to which points, links and locations are added.
        nodes: records with name, x, y (or north), and perhaps role and station.
        edges: records with from, to, and perhaps name, length, speed, two_way and side_by_side.
        two_way: whether edges without an entry are used in both directions.

    Raises:
        ModelError: a wrong value, with its position.
    """
    stations: dict[str, Location] = {}
    for record in nodes:
        _point(record, plant, stations)
    plant.locations += stations.values()
    for record in edges:
        _link(record, plant, two_way)
    if not plant.points:
        raise ModelError([f"{plant.source}: no nodes, expected some"])


def _point(record: TableRecord, plant: Plant, stations: dict[str, Location]) -> None:
    name = record.text("name")
    if name in plant.points:
        record.refuse("name", f"a node of this name stands before (got {got(name)}), expected every name once")
    upwards = "north" in record.columns.named
    x, y = record.number("x"), record.number("north" if upwards else "y")
    for key, value in (("x", x), ("north" if upwards else "y", y)):
        if value is None:
            record.refuse(key, "empty, expected a number of metres")
    assert x is not None
    assert y is not None
    plant.points[name] = Waypoint(name, x, -y if upwards and y else y, position=record.position)
    role, station = record.get("role"), record.get("station")
    operations = tuple(filter(None, _SEVERAL.split(str(role).strip()))) if role is not None else ()
    if operations or station is not None:
        called = record.text("station") if station is not None else name
        stations.setdefault(called, Location(called, {}, record.position)).operations[name] = operations


def _link(record: TableRecord, plant: Plant, two_way: bool) -> None:
    ends = record.text("from"), record.text("to")
    for column, end in zip(("from", "to"), ends, strict=True):
        if end not in plant.points:
            hint = did_you_mean(end, plant.points)
            record.refuse(column, f"no such node (got {got(end)}), expected the name of a node{hint}")
    speed, both = record.above_0("speed") or math.inf, record.flag("two_way")
    if both is None and (one_way := record.flag("one_way")) is not None:
        both = not one_way
    back = speed if record.get("speed_back") is None else record.above_0("speed_back") or math.inf
    back = back if (two_way if both is None else both) else 0.0
    name = ">".join(ends) if record.get("name") is None else record.text("name")
    beside = bool(record.flag("side_by_side"))
    link = Link(name, *ends, record.above_0("length"), speed, back, record.position, side_by_side=beside)
    plant.links.append(link)


@dataclass
class _Table:
    """The rows of a table below its header, each with its number.

    `name`: the table in notes. `place`: the words before a row's number in messages. `comma`: whether 9,5 is a number.
    """

    name: str
    place: str
    header: list[str]
    rows: Iterator[tuple[int, list[str]]]
    comma: bool

    @classmethod
    def of_csv(cls, path: Path, content: bytes) -> _Table:
        """Return the table in a CSV file."""
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = content[: error.start].count(b"\n") + 1
            problem = (
                f"not UTF-8 text (got byte 0x{content[error.start]:02x}), expected the file to be saved as CSV UTF-8"
            )
            raise ModelError([f"{path}:{line}: {problem}"]) from None
        first = text[: text.find("\n")] if "\n" in text else text
        delimiter = max(",;\t", key=first.count)
        return cls._of(path.name, f"{path}:", _lines(path, text, delimiter), comma=delimiter != ",")

    @classmethod
    def of_sheet(cls, path: Path, sheet: str) -> _Table:
        """Return the table in a sheet of a workbook."""
        return cls._of(f"sheet {sheet}", f"{path}, {sheet}:", enumerate(rows_of(path, sheet), 1), comma=True)

    @classmethod
    def _of(cls, name: str, place: str, rows: Iterator[tuple[int, list[str]]], *, comma: bool) -> _Table:
        header = [cell.strip() for cell in next(rows, (1, []))[1]]
        if len(header) > _MOST:
            raise ModelError([f"{place}1: too many columns (got {len(header):,}), expected at most {_MOST:,}"])
        return cls(name, place, header, rows, comma)

    def columns(self, headings: Mapping[str, tuple[str, ...]]) -> Columns:
        """Return the columns that are read."""
        return Columns.of(filter(None, self.header), headings, f"{self.place}1")

    def records(self, columns: Columns) -> Iterator[TableRecord]:
        """Yield the rows that are not empty."""
        count = 0
        for number, cells in self.rows:
            where = f"{self.place}{number}"
            if not any(cells):
                continue
            if any(cells[len(self.header) :]):
                raise ModelError([f"{where}: {len(cells)} cells, expected at most {len(self.header)}, as line 1 has"])
            count += 1
            if count > LIMITS["nodes"][0] * 4:
                raise ModelError([f"{where}: too many rows, expected at most {4 * LIMITS['nodes'][0]:,}"])
            values = dict(zip(self.header, map(self.cell, cells), strict=False))
            yield TableRecord(columns, values, where, f"{self.name} row {number}")

    def cell(self, text: str) -> str:
        """Return the text of a cell, with a decimal point in place of a decimal comma."""
        text = text.strip()
        return text.replace(",", ".") if self.comma and _DECIMAL.fullmatch(text) else text


def _lines(path: Path, text: str, delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows of a CSV text, each with the number of its last line; raise ModelError for other text."""
    try:
        yield from csv_rows(io.StringIO(text, newline=""), delimiter)
    except csv.Error as error:
        raise ModelError([f"{path}: not a table ({error}), expected CSV"]) from None
