"""Nodes and edges from two CSV files, as spreadsheets write them: `nodes.csv`, and `edges.csv` beside it.

- Other names do, too, if one has `nodes` where the other has `edges`: `hall-nodes.csv` and `hall-edges.csv`. A folder
  with both may be named instead.
- Numbers are metres and metres a second, or have a unit, in the cell (`600 mm`) or in the header (`x [mm]`,
  `speed [km/h]`). A comma, semicolon or tab may stand between cells; where it is no comma, `9,5` is a number.
- `y` is downwards, as in model files. A column `north` in its place is upwards.
- `role` is what robots do there: load, unload, charge, park, or several (`charge + park`). Words of your own are said
  with `--operation "pick face=load"`. `station` gives a name; nodes with the same one are one station.
- An edge is one-way unless `two_way` says yes; `--two-way` makes all that do not say so two-way. `side_by_side` is for
  two lanes, one there and one back. Without a length it is the straight distance, without a speed there is no limit.
- Other columns are left out, and named.
"""

from __future__ import annotations

import csv
import io
import re
from typing import TYPE_CHECKING

from desim_warehouse.errors import ModelError
from desim_warehouse.plants.file import content_of
from desim_warehouse.plants.plant import Plant
from desim_warehouse.plants.records import EDGE, NODE, Columns, TableRecord, fill
from desim_warehouse.values.fields import LIMITS

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

EXPECTED = "a table of nodes (CSV) with the columns name, x and y"
NODES_FILE, EDGES_FILE = "nodes.csv", "edges.csv"
"""Their names in a folder."""
_EDGES = "a table of edges (CSV) with the columns from and to"
_NODES = re.compile("nodes|points", re.IGNORECASE)
_MOST = 1000  # columns
_DECIMAL = re.compile(r"[+-]?\d+,\d+")


def looks(path: Path, start: bytes) -> bool:  # noqa: ARG001 - as all formats
    """Whether a file may be a table: by its ending."""
    return path.suffix.lower() in {".csv", ".tsv"}


def read(path: Path, content: bytes, *, two_way: bool = False) -> Plant:
    """Read a table of nodes and the table of edges beside it.

    Args:
        path: the table of nodes.
        content: what stands in it.
        two_way: whether edges that do not say lead both ways.

    Raises:
        ModelError: with the row and column, where something is wrong.
    """
    beside = edges_beside(path)
    plant = Plant(
        _NODES.sub("", path.stem).strip(" _-.") or path.absolute().parent.name, f"{path.name} and {beside.name} (CSV)"
    )
    nodes, edges = _Table(path, content), _Table(beside, content_of(beside, _EDGES))
    node_columns, edge_columns = nodes.columns(NODE), edges.columns(EDGE)
    node_columns.require(f"{path}:1", "name", "x", *(() if "north" in node_columns.named else ("y",)))
    edge_columns.require(f"{beside}:1", "from", "to")
    fill(plant, nodes.records(node_columns), edges.records(edge_columns), two_way=two_way)
    for table, columns in ((path, node_columns), (beside, edge_columns)):
        plant.note("left out", "column", columns.unread, f"of {table.name}: nothing that a layout has")
    return plant


def edges_beside(path: Path) -> Path:
    """The table of edges that belongs to a table of nodes: `edges` in place of `nodes` in its name."""
    if not _NODES.search(path.stem):
        text = f"{path}: a table whose name does not say what is in it, expected nodes.csv with edges.csv beside it"
        raise ModelError([text])
    return path.with_name(_NODES.sub(lambda found: "EDGES" if found[0].isupper() else "edges", path.stem) + path.suffix)


class _Table:
    """The rows of a CSV file, each with its line."""

    def __init__(self, path: Path, content: bytes) -> None:
        self.path = path
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = content[: error.start].count(b"\n") + 1
            said = f"not UTF-8 text (got byte 0x{content[error.start]:02x}), expected the file to be saved as CSV UTF-8"
            raise ModelError([f"{path}:{line}: {said}"]) from None
        first = text[: text.find("\n")] if "\n" in text else text
        self.delimiter = max(",;\t", key=first.count)
        self.reader = csv.reader(io.StringIO(text, newline=""), delimiter=self.delimiter, strict=True)
        self.header = [cell.strip() for cell in self.row() or []]
        if len(self.header) > _MOST:
            raise ModelError([f"{path}:1: too many columns (got {len(self.header):,}), expected at most {_MOST:,}"])

    def row(self) -> list[str] | None:
        """The next row; None after the last."""
        try:
            return next(self.reader, None)
        except csv.Error as error:
            raise ModelError([f"{self.path}:{self.reader.line_num}: not a table ({error}), expected CSV"]) from None

    def columns(self, known: Mapping[str, tuple[str, ...]]) -> Columns:
        """The columns that are read."""
        return Columns.of(filter(None, self.header), known, f"{self.path}:1")

    def records(self, columns: Columns) -> Iterator[TableRecord]:
        """The rows that are not empty."""
        count = 0
        while (cells := self.row()) is not None:
            where = f"{self.path}:{self.reader.line_num}"
            if not any(cells):
                continue
            if any(cells[len(self.header) :]):
                raise ModelError([f"{where}: {len(cells)} cells, expected at most {len(self.header)}, as line 1 has"])
            count += 1
            if count > LIMITS["nodes"][0] * 4:
                raise ModelError([f"{where}: too many rows, expected at most {4 * LIMITS['nodes'][0]:,}"])
            yield TableRecord(
                columns,
                dict(zip(self.header, map(self.cell, cells), strict=False)),
                where,
                f"{self.path.name} row {self.reader.line_num}",
            )

    def cell(self, text: str) -> str:
        """A cell, with a decimal point."""
        text = text.strip()
        return text.replace(",", ".") if self.delimiter != "," and _DECIMAL.fullmatch(text) else text
