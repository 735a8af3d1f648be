"""Files that a model file names: layouts in JSON, and storage places, weights, times and from-to matrices in CSV."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from desim_warehouse.errors import ModelError, did_you_mean, got, other_marks, reason
from desim_warehouse.folders import sha256
from desim_warehouse.layout.spec import NamesFile, StorageFile
from desim_warehouse.model import layout_file
from desim_warehouse.model.messages import FilePositions, Keys, Outline, Position, Problem, from_pydantic
from desim_warehouse.model.parse import Document
from desim_warehouse.model.sections.flows import MatrixFile
from desim_warehouse.model.sections.goods import WeightsFile
from desim_warehouse.model.sections.orders import command, not_plain, without_earlier
from desim_warehouse.model.sections.pods import HoldsFile
from desim_warehouse.model.sections.policy import KINDS
from desim_warehouse.policies import catalogue
from desim_warehouse.values.csv_rows import csv_rows
from desim_warehouse.values.distributions import ObservedFile
from desim_warehouse.values.fields import LIMITS

STORAGE: Keys = ("layout", "storage")
LAYOUT: Keys = ("layout", "file")

Reader = Callable[[dict[str, Any], Keys, "Path", FilePositions], Any]


def resolve(document: Document, outline: Outline) -> None:
    """Read the tables that a model names and put their values in, so that the model is complete by itself.

    The paths of the user's own policies are written in full: the model is then the same wherever it is used.

    Args:
        document: changed in place: its values, the lines of tables where they stand, what is wrong with them.
        outline: the keys that it can have.
    """
    data, folder, positions = document.data, document.folder, document.positions
    problems = _layout(data.get("layout"), document)
    for section, keys, read in _named(data):
        try:
            _refuse(section[str(keys[-1])]["file"], (*keys, "file"), document)
            section[str(keys[-1])] = read(section[str(keys[-1])], keys, folder, positions)
        except ValidationError as error:
            problems += from_pydantic(error, outline, keys)
            del section[str(keys[-1])]
        except _RefusedError as refused:
            problems += refused.problems
            del section[str(keys[-1])]
    document.problems += [*problems, *_policies(data.get("policies"), document)]
    document.unread |= {problem.keys[:2] for problem in problems}
    if LAYOUT in document.unread:
        document.unread.add(("layout",))


def _policies(section: Any, document: Document) -> list[Problem]:
    problems: list[Problem] = []
    for kind in KINDS if isinstance(section, dict) else ():
        holder, key = (section[kind], "name") if isinstance(section.get(kind), dict) else (section, kind)
        name = holder.get(key)
        if not isinstance(name, str):
            continue
        place, own, _ = name.rpartition(":")
        try:
            if own:  # a module may lie anywhere
                _refuse(place if place.endswith(".py") else None, ("policies", kind), document)
            holder[key] = catalogue.resolved(name, document.folder)
        except _RefusedError as refused:
            problems += refused.problems
            del section[kind]
    return problems


def _refuse(name: Any, keys: Keys, document: Document) -> None:
    """Refuse a file that the document may not name, without a word of the file, not even whether there is one."""
    if document.files == "none":
        raise _RefusedError(Problem(keys, "names a file, expected none here (files: none)"))
    if document.files == "beside" and not _is_below(document.folder, name):
        raise _RefusedError(
            Problem(keys, f"not a file below the folder of the model (got {got(name)}), expected one (files: beside)")
        )


def _is_below(folder: Path, name: Any) -> bool:
    """Whether a file lies below a folder, when all links are followed."""
    try:
        return Path(folder, name).resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, TypeError, RuntimeError):  # no name of a file; a ring of links
        return False


def _layout(section: Any, document: Document) -> list[Problem]:
    """Put the keys of a layout file into the section that names it."""
    if not isinstance(section, dict) or not isinstance(section.get("file"), str):
        return []
    positions, name = document.positions, section.pop("file")
    path = document.folder / name
    try:
        _refuse(name, LAYOUT, document)
        content = layout_file.read(path)
    except _RefusedError as refused:
        return list(refused.problems)
    except ModelError as error:
        return [Problem(LAYOUT, problem) for problem in error.problems]
    here = Position(next(positions.ranks), 0, 0, str(path))
    for key, value in content.items():
        if key == "file":
            return [Problem(LAYOUT, f"'{path}' names a file itself, expected {layout_file.EXPECTED}")]
        if key in section:
            return [Problem(LAYOUT, f"'{path}' has {key}, which stands beside it, too, expected it in one of the two")]
        section[key] = value
        positions.keys["layout", key] = positions.values["layout", key] = here
    return []


def _named(data: dict[str, Any]) -> list[tuple[dict[str, Any], Keys, Reader]]:
    """Find where tables are named: the section, the keys, and how to read each."""
    layout = data.get("layout")
    tables: list[tuple[dict[str, Any], Keys, Reader]] = []
    if isinstance(layout, dict) and _names_file(layout.get("storage")):
        tables.append((layout, STORAGE, _storage))
    if isinstance(layout, dict) and _names_file(layout.get("storage_names")):
        tables.append((layout, ("layout", "storage_names"), _place_names))
    pods = data.get("pods")
    if isinstance(pods, dict) and _names_file(pods.get("holds")):
        tables.append((pods, ("pods", "holds"), _holds))
    return [*tables, *_below(data.get("tasks"), ("tasks",))]


def _below(section: Any, keys: Keys) -> Iterator[tuple[dict[str, Any], Keys, Reader]]:
    if not isinstance(section, dict):
        return
    for key, value in section.items():
        if key in _READERS and _names_file(value):
            yield section, (*keys, key), _READERS[key]
        else:
            yield from _below(value, (*keys, key))


def _names_file(value: Any) -> bool:
    return isinstance(value, dict) and "file" in value


class _RefusedError(Exception):
    """A table that cannot be read."""

    def __init__(self, *problems: Problem) -> None:
        self.problems = problems


def _weights(named: dict[str, Any], keys: Keys, folder: Path, positions: FilePositions) -> dict[str, Any]:
    form = WeightsFile.model_validate(named)
    table = _Table.read(folder / form.file, (*keys, "file"), positions)
    table.require(form.column, (*keys, "column" if "column" in named else "file"))
    rows = _by_place(table, (*keys, "file"))
    for rank, row in enumerate(rows):
        positions.values[*keys, "weights", rank] = row.at[form.column]
    return {"weights": [row.number(form.column) for row in rows]}


def _by_place(table: _Table, keys: Keys) -> list[_Row]:
    """Return the rows of a table in the order of their column `place`, numbers from 0 on; without one as they stand."""
    if "place" not in table.header:
        return list(table.rows)
    rows: dict[float | str, _Row] = {}
    for row in table.rows:
        place = row.number("place")
        if place in rows or place not in range(len(table.rows)):
            text = f"no number of a storage place, or a second time (got {row.at['place'].text})"
            expected = f"all numbers from 0 to {len(table.rows) - 1} in column 'place', or no such column"
            raise _RefusedError(Problem(keys, f"{text}, expected {expected}"))
        rows[place] = row
    return [rows[place] for place in range(len(rows))]


def _times(named: dict[str, Any], keys: Keys, folder: Path, positions: FilePositions) -> dict[str, Any]:
    form = ObservedFile.model_validate(named)
    table = _Table.read(folder / form.file, (*keys, "file"), positions)
    table.require(form.column, (*keys, "column"))
    rows = [row for row in table.rows if row.cells[form.column]]  # a table may have longer columns beside it
    for rank, row in enumerate(rows):
        positions.values[*keys, "values", rank] = row.at[form.column]
    times = [row.number(form.column) for row in rows]
    return {"values": [f"{time!r} {form.unit}" if form.unit and isinstance(time, float) else time for time in times]}


def _pairs(named: dict[str, Any], keys: Keys, folder: Path, positions: FilePositions) -> list[dict[str, Any]]:
    """Read a from-to matrix: origins in the first column, destinations in the first line."""
    form = MatrixFile.model_validate(named)
    table = _Table.read(folder / form.file, (*keys, "file"), positions)
    if len(table.header) < 2:  # noqa: PLR2004 - origins, and a destination
        text = f"no matrix (got '{table.name}'), expected origins in the first column, destinations in line 1"
        raise _RefusedError(Problem((*keys, "file"), text))
    first, *targets = table.header
    made: list[dict[str, Any]] = []
    for row in table.rows:
        for target in targets:
            if row.cells[target] not in {"", "0"}:
                place: Keys = (*keys, len(made))
                positions.keys[place] = positions.values[place] = positions.values[*place, "from", 0] = row.at[first]
                positions.values[*place, "to", 0] = positions.values[*place, "per_hour"] = row.at[target]
                made.append({"from": row.cells[first], "to": target, "per_hour": row.number(target)})
    return made


def _storage(named: dict[str, Any], _: Keys, folder: Path, positions: FilePositions) -> list[dict[str, Any]]:
    form = StorageFile.model_validate(named)
    table = _Table.read(folder / form.file, (*STORAGE, "file"), positions)
    if "node" not in table.header or {"from", "to", "offset"} & set(table.header):
        for column in ("from", "to", "offset"):
            table.require(column, (*STORAGE, "file"))
    made = []
    for rank, row in enumerate(table.rows):
        keys: Keys = (*STORAGE, rank)
        at_node = bool(row.cells.get("node")) or "from" not in row.cells
        first = "node" if at_node else "from"
        positions.keys[keys] = positions.values[keys] = positions.values[*keys, "edge"] = row.at[first]
        item: dict[str, Any] = (
            {"node": row.cells["node"]} if at_node else {"edge": [row.cells["from"], row.cells["to"]]}
        )
        for column in ("popularity",) if at_node and not row.cells.get("offset") else ("offset", "popularity"):
            if column in row.cells:
                item[column] = row.number(column)
                positions.values[*keys, column] = row.at[column]
        made.append(item)
    return made


def _place_names(named: dict[str, Any], keys: Keys, folder: Path, positions: FilePositions) -> dict[str, Any]:
    form = NamesFile.model_validate(named)
    table = _Table.read(folder / form.file, (*keys, "file"), positions)
    for column in ("name", "place"):
        table.require(column, (*keys, "file"))
    places: dict[str, Any] = {}
    for row in table.rows:
        number = _whole(row.number("place"))
        if (name := row.cells["name"]) in places:
            text = f"name '{name}' given twice in '{table.name}', expected it once"
            raise _RefusedError(Problem((*keys, "file"), text))
        places[name] = number
        positions.values[*keys, "places", name] = row.at["place"]
    return {"places": places}


def _holds(named: dict[str, Any], keys: Keys, folder: Path, positions: FilePositions) -> dict[str, Any]:
    """Read the contents of pods: a row for each item on a pod. Pods and items are numbered as the file names them."""
    form = HoldsFile.model_validate(named)
    table = _Table.read(folder / form.file, (*keys, "file"), positions)
    for column in ("pod", "item"):
        table.require(column, (*keys, "file"))
    optional = [column for column in ("place", "units") if column in table.header]
    pods, names, places = dict[str, int](), dict[str, int](), dict[str, Any]()
    columns: dict[str, list[Any]] = {"pod": [], "item": [], **({"units": []} if "units" in optional else {})}
    for rank, row in enumerate(table.rows):
        pod = row.cells["pod"]
        if places.setdefault(pod, row.cells.get("place")) != row.cells.get("place"):
            text = f"pod '{pod}' is on two places in '{table.name}', expected one"
            raise _RefusedError(Problem((*keys, "file"), text))
        if "place" in optional:
            positions.values[*keys, "places", pods.get(pod, len(pods))] = row.at["place"]
        columns["pod"].append(pods.setdefault(pod, len(pods)))
        columns["item"].append(names.setdefault(row.cells["item"], len(names)))
        if "units" in optional:
            positions.values[*keys, "units", rank] = row.at["units"]
            columns["units"].append(_whole(row.number("units")))
    stand = {"places": [_whole(_number(place)) for place in places.values()]} if "place" in optional else {}
    return {"names": list(names), **stand, **columns}


def _orders(named: dict[str, Any], keys: Keys, folder: Path, positions: FilePositions) -> dict[str, Any]:
    """Orders stay in their file, which is read while the run goes on. The model keeps its full path and its digest."""
    if not isinstance(named["file"], str):
        return named
    path = (folder / named["file"]).absolute()
    section, earlier = without_earlier(named)
    try:
        section |= {"file": str(path), "sha256": sha256(path)}
    except OSError as error:
        if named.get("sha256"):  # the model of a run that is looked at elsewhere
            return section
        text = f"cannot be read (got '{path}': {reason(error)}), expected a CSV or Parquet file"
        raise _RefusedError(Problem((*keys, "file"), text)) from None
    if ways := [*earlier, *not_plain(path)]:
        cure = f"expected the one that this makes: {command(path, named, positions.source)}"
        raise _RefusedError(Problem((*keys, "file"), f"no plain table of orders (got {'; '.join(ways)}), {cure}"))
    return section


_READERS: dict[str, Reader] = {"popularity": _weights, "empirical": _times, "from_to": _pairs, "orders": _orders}
"""How tables are read that are named below tasks, by their key."""


def _number(cell: str) -> float | str:
    try:
        return float(cell)
    except ValueError:
        return cell


def _whole(number: float | str) -> int | float | str:
    return int(number) if isinstance(number, float) and number.is_integer() else number


@dataclass(frozen=True)
class _Row:
    width: int
    cells: Mapping[str, str]
    at: Mapping[str, Position]

    def number(self, column: str) -> float | str:
        """Return the cell as a number. Any other stays text, and is refused at its position."""
        return _number(self.cells[column])


@dataclass(frozen=True)
class _Table:
    name: str
    header: tuple[str, ...]
    rows: tuple[_Row, ...]

    @classmethod
    def read(cls, path: Path, keys: Keys, positions: FilePositions) -> _Table:
        """Read a CSV file with a header, which is named at `keys`."""
        import csv

        try:
            _check_size(path)
            with path.open(encoding="utf-8-sig", newline="") as lines:
                reader = csv_rows(lines)
                header = tuple(name.strip() for name in next(reader, (1, ()))[1])
                rows = tuple(_rows(reader, header, str(path), next(positions.ranks)))
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
                text = f"{wrong} (got {where}), expected {_columns(header)} in every row{other_marks(header)}"
                raise _RefusedError(Problem(keys, text))
        return cls(str(path), header, rows)

    def require(self, column: str, keys: Keys) -> None:
        """Refuse a table without this column, which is named at `keys`."""
        if column in self.header:
            return
        hint = other_marks(self.header) or did_you_mean(column, self.header)
        text = f"no column '{column}' in '{self.name}' (got {_columns(self.header)}), expected it in line 1{hint}"
        raise _RefusedError(Problem(keys, text))


def _columns(header: Sequence[str]) -> str:
    """Count columns in words, without their names: the reader of the message may not be allowed to see the file."""
    return f"{len(header) or 'no'} column{'s' * (len(header) != 1)}"


def _check_size(path: Path) -> None:
    """Refuse files that may never end, such as a device or a pipe, and files larger than any table."""
    if path.exists() and not path.is_file():
        raise OSError(0, "not a file")
    if path.exists() and path.stat().st_size > LIMITS["bytes"][0]:
        raise OSError(0, f"more than {LIMITS['bytes'][0]:,} bytes")


def _rows(reader: Iterator[tuple[int, list[str]]], header: tuple[str, ...], file: str, rank: int) -> Iterator[_Row]:
    for number, cells in reader:
        if not any(cells):
            continue
        column, positions = 1, {}
        for name, cell in zip(header, cells, strict=False):
            positions[name] = Position.in_file(rank, file, number, column)
            column += len(cell) + 1
        width = len(cells) if any(cells[len(header) :]) else min(len(cells), len(header))
        yield _Row(width, {name: cell.strip() for name, cell in zip(header, cells, strict=False)}, positions)
