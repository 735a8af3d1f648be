"""CSV files that a model file names: weights of storage places, and the places themselves."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import ValidationError

from desim_warehouse.errors import nearest, reason, spoken
from desim_warehouse.fields import LIMITS, Part
from desim_warehouse.layout.spec import StorageFile
from desim_warehouse.model.messages import Keys, Place, Places, Problem, from_pydantic
from desim_warehouse.model.schema import OUTLINE, WeightsFile

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

_LISTED = 12
"""Columns named in a message."""
POPULARITY: Keys = ("tasks", "popularity")
STORAGE: Keys = ("layout", "storage")


def resolve(data: dict[str, Any], folder: Path, places: Places) -> list[Problem]:
    """Read the tables that a model names and put their values in, so that the model is complete by itself.

    Args:
        data: the plain values of a model; changed in place.
        folder: where relative names start: the model file's folder.
        places: where values stand; learns the lines of the tables.

    Returns:
        What is wrong with the tables.
    """
    problems: list[Problem] = []
    for keys, read in ((STORAGE, _storage), (POPULARITY, _weights)):
        section = data.get(str(keys[0]))
        named = section.get(keys[1]) if isinstance(section, dict) else None
        if isinstance(section, dict) and isinstance(named, dict) and "file" in named:
            try:
                section[str(keys[1])] = read(named, folder, places)
            except _RefusedError as refused:
                problems += refused.problems
                del section[str(keys[1])]
    return problems


class _RefusedError(Exception):
    """A table that cannot be read."""

    def __init__(self, *problems: Problem) -> None:
        self.problems = problems


def _weights(named: dict[str, Any], folder: Path, places: Places) -> dict[str, Any]:
    keys: Keys = (*POPULARITY, "weights")
    form = _form(WeightsFile, named, POPULARITY)
    table = _Table.read(folder / form.file, (*POPULARITY, "file"), places)
    table.require(form.column, (*POPULARITY, "column" if "column" in named else "file"))
    for rank, row in enumerate(table.rows):
        places.values[*keys, rank] = row.at[form.column]
    return {"weights": [row.number(form.column) for row in table.rows]}


def _storage(named: dict[str, Any], folder: Path, places: Places) -> list[dict[str, Any]]:
    form = _form(StorageFile, named, STORAGE)
    table = _Table.read(folder / form.file, (*STORAGE, "file"), places)
    if "node" not in table.header or {"from", "to", "offset"} & set(table.header):
        for column in ("from", "to", "offset"):
            table.require(column, (*STORAGE, "file"))
    made = []
    for rank, row in enumerate(table.rows):
        keys: Keys = (*STORAGE, rank)
        at_node = bool(row.cells.get("node")) or "from" not in row.cells
        first = "node" if at_node else "from"
        places.keys[keys] = places.values[keys] = places.values[*keys, "edge"] = row.at[first]
        item: dict[str, Any] = (
            {"node": row.cells["node"]} if at_node else {"edge": [row.cells["from"], row.cells["to"]]}
        )
        for column in ("popularity",) if at_node and not row.cells.get("offset") else ("offset", "popularity"):
            if column in row.cells:
                item[column] = row.number(column)
                places.values[*keys, column] = row.at[column]
        made.append(item)
    return made


_Form = TypeVar("_Form", bound=Part)


def _form(kind: type[_Form], named: dict[str, Any], keys: Keys) -> _Form:
    try:
        return kind.model_validate(named)
    except ValidationError as error:
        raise _RefusedError(*from_pydantic(error, OUTLINE, keys)) from None


@dataclass(frozen=True)
class _Row:
    width: int
    cells: Mapping[str, str]
    at: Mapping[str, Place]

    def number(self, column: str) -> float | str:
        """The cell as a number; any other stays text, and is refused at its place."""
        try:
            return float(self.cells[column])
        except ValueError:
            return self.cells[column]


@dataclass(frozen=True)
class _Table:
    name: str
    header: tuple[str, ...]
    rows: tuple[_Row, ...]

    @classmethod
    def read(cls, path: Path, keys: Keys, places: Places) -> _Table:
        """Read a CSV file with a header; `keys` is where it is named."""
        import csv

        try:
            _check_size(path)
            with path.open(encoding="utf-8-sig", newline="") as lines:
                reader = csv.reader(lines, strict=True)
                header = tuple(name.strip() for name in next(reader, ()))
                rows = tuple(_rows(reader, header, str(path), next(places.ranks)))
        except UnicodeDecodeError:
            text = f"not UTF-8 text (got '{path}'), expected the file to be saved as UTF-8"
            raise _RefusedError(Problem(keys, text)) from None
        except csv.Error as error:
            text = f"not a table (got '{path}': {error}), expected a CSV file"
            raise _RefusedError(Problem(keys, text)) from None
        except (OSError, ValueError) as error:
            text = f"cannot be read (got '{path}': {reason(error)}), expected a CSV file"
            raise _RefusedError(Problem(keys, text)) from None
        twice = [name for name, count in Counter(header).items() if name and count > 1]
        if twice:
            text = f"column '{twice[0]}' given twice in '{path}', expected it once"
            raise _RefusedError(Problem(keys, text))
        for row in rows:
            if row.width != len(header):
                where = next(iter(row.at.values())).text
                wrong = "a row without all columns" if row.width < len(header) else "a row with more cells than columns"
                text = f"{wrong} (got {where}), expected {_listed(header)} in every row"
                raise _RefusedError(Problem(keys, text))
        return cls(str(path), header, rows)

    def require(self, column: str, keys: Keys) -> None:
        """Refuse a table without this column; `keys` is where the column is named."""
        if column in self.header:
            return
        near = nearest(column, self.header)
        hint = f"; did you mean '{near}'?" if near else ""
        have = _listed([f"'{name}'" for name in self.header]) if self.header else "no columns"
        text = f"no column '{column}' in '{self.name}' (got {have}), expected it in line 1{hint}"
        raise _RefusedError(Problem(keys, text))


def _listed(names: Sequence[str]) -> str:
    """Columns in words; of many the first."""
    return spoken(names) if len(names) <= _LISTED else f"{', '.join(names[:_LISTED])} and {len(names) - _LISTED:,} more"


def _check_size(path: Path) -> None:
    """Refuse what may never end, such as a device or a pipe, and files larger than any table."""
    if path.exists() and not path.is_file():
        raise OSError(0, "not a file")
    if path.exists() and path.stat().st_size > LIMITS["bytes"][0]:
        raise OSError(0, f"more than {LIMITS['bytes'][0]:,} bytes")


def _rows(reader: Any, header: tuple[str, ...], file: str, rank: int) -> Iterator[_Row]:
    for cells in reader:
        if not any(cells):
            continue
        column, at = 1, {}
        for name, cell in zip(header, cells, strict=False):
            at[name] = Place.in_file(rank, file, reader.line_num, column)
            column += len(cell) + 1
        width = len(cells) if any(cells[len(header) :]) else min(len(cells), len(header))
        yield _Row(width, {name: cell.strip() for name, cell in zip(header, cells, strict=False)}, at)
