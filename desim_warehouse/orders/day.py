"""A day of orders from an ERP, made ready for a model: contents, problems, assumptions.

For `desim orders`, and `order_day` in Python.
"""

from __future__ import annotations

import datetime as dt
import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from desim_warehouse.errors import ModelError, reason, shown
from desim_warehouse.model.parse import from_file
from desim_warehouse.model.schema import OUTLINE, Model, model_of, reading
from desim_warehouse.model.sections.flows import ORDER_COLUMNS
from desim_warehouse.model.sections.order_lines import OrderLine, Problems, Reading
from desim_warehouse.orders.cells import ExportRows
from desim_warehouse.orders.export import read_export
from desim_warehouse.values.arguments import is_whole
from desim_warehouse.values.headings import heading

if TYPE_CHECKING:
    import pandas as pd


_TOTAL = r"(?i)^\W*(grand |sub)?(total|sum|summe|gesamt\w*|zwischensumme)\b|^\*{1,4}$"  # SAP has stars
_CANCELLED = (
    r"cancel|cancell?ed|cancel?lation|storno|storniert|stornierung|annulliert|abgesagt|"
    r"returned|retoure|retourniert|refunded|voided|deleted|gelöscht"
)
"""States of orders that are not driven."""
_FLAG = rf"(?:is|ist)?(?:{_CANCELLED})(?:flag|kz|kennzeichen|at|on|am|by|von|date|datum|time|zeit|reason|grund)?"
"""Headings of columns that state whether, when, why or by whom an order came into such a state."""
_STATUS = r"\w*(?:status|state|zustand)\w*"
"""Headings of columns that state in which state an order is."""
_NO = {"", "n", "no", "nein", "f", "false", "falsch", "null", "none", "na", "nan", "nat"}
"""What such a column has for other orders, without zeros and marks: 0000-00-00 is no date."""
_HOUR, _DAY = 3600.0, 86_400.0


@dataclass(frozen=True)
class OrderDay:
    """One day of orders, ready for a model, with problems and assumptions: the result of `order_day`.

    Attributes:
        lines: the rows that could be read, in order of release; quantities are tasks, each a trip.
        pieces: sum of the quantities as the file has them.
        problems: problems of other rows, one line per kind of problem.
        skipped: the rows with problems, as in the file.
        assumed: assumptions about whatever the file does not specify, in words.
        midnight: the day of the first order; None where the file has no dates.
        how: facts about the model that reading the file depends on.
        unread: columns that were not read, with a note on those that contain places of the model.
    """

    lines: tuple[OrderLine, ...]
    pieces: int
    problems: tuple[str, ...]
    skipped: pd.DataFrame
    assumed: tuple[str, ...]
    midnight: dt.datetime | None
    how: Reading
    unread: tuple[str, ...]

    @property
    def orders(self) -> int:
        """Number of orders."""
        return len({line.order for line in self.lines})

    @property
    def a_day(self) -> float:
        """Mean number of orders on the days on which some come."""
        return self.orders / max(1, len({self.time_of(line.release) // _DAY for line in self.lines}))

    @property
    def trips(self) -> int:
        """Number of tasks."""
        return sum(line.quantity for line in self.lines)

    @property
    def busiest(self) -> tuple[float, int]:
        """Busiest hour: its begin in seconds from midnight, and its number of trips."""
        hours: Counter[int] = Counter()
        for line in self.lines:
            hours[int(self.time_of(line.release) // _HOUR)] += line.quantity
        hour, trips = max(hours.items(), key=lambda item: (item[1], -item[0]), default=(0, 0))
        return hour * _HOUR, trips

    def time_of(self, release: Any) -> Any:
        """Convert times since the start of the run, in the model's unit, to seconds from midnight; also arrays."""
        return self.how.clock + release * self.how.seconds

    def table(self) -> pd.DataFrame:
        """Make the table that models read; times are dates if the export has dates, else from the start of the run."""
        import pandas as pd

        items = list(self.how.item_numbers)
        columns: dict[str, list[Any]] = {
            "order": [line.order for line in self.lines],
            "release": [line.release for line in self.lines],
            "from": [_name(line.source) for line in self.lines],
            "via": [" > ".join(map(_name, line.via or ())) for line in self.lines],
            "to": [_name(line.target) for line in self.lines],
            "due": [line.due for line in self.lines],
            "priority": [line.priority for line in self.lines],
            "quantity": [line.quantity for line in self.lines],
            "item": [None if line.item is None else items[line.item] for line in self.lines],
        }
        frame = pd.DataFrame(
            {name: cells for name, cells in columns.items() if any(cell is not None for cell in cells)}
        )
        if self.midnight is not None:
            for name in {"release", "due"} & set(frame):
                frame[name] = pd.Timestamp(self.midnight) + pd.to_timedelta(
                    self.time_of(frame[name].astype(float)), unit="s"
                )
        return frame.loc[:, [name for name in frame if not (frame[name] == "").all()]]


def _name(place: str | int | None) -> str:
    return "" if place is None else str(place)


def order_day(
    file: str | Path,
    model: Model | str | Path,
    *,
    columns: Mapping[str, str] | None = None,
    sheet: str | None = None,
    dates: Literal["us", "uk"] | None = None,
    quantity: Literal["tasks", "pieces"] | None = None,
    pieces_per_load: int | None = None,
) -> OrderDay:
    """Read a file of orders for a model, and summarise its problems.

    Args:
        file: CSV with any separator, Parquet or Excel.
        model: the model with the places that the orders name; its own flows from files of orders are ignored.
        columns: our column -> its heading in the file, such as `{"release": "Anlagedatum"}`; default: common headings.
        sheet: the sheet of an Excel file to read; default: the first.
        dates: how to read 03/02/2026: "us", March 2, or "uk", 3 February.
        quantity: what the quantities in the file count; default: pieces.
        pieces_per_load: the largest number of pieces on one load; default: all of a row.

    Returns:
        The orders by good row, and what is wrong with the others.

    Raises:
        ModelError: where the file or the model cannot be read, or `pieces_per_load` is no number of pieces. Rows with
            problems are in the result.
    """
    if pieces_per_load is not None and not is_whole(pieces_per_load, 1):
        raise ModelError([f"pieces_per_load {shown(pieces_per_load):.60}: expected a whole number above 0"])
    loaded = model if isinstance(model, Model) else _without_orders(Path(model))
    how, path, problems = reading(loaded, loaded.floor), Path(file), Problems(str(file))
    export = read_export(path, columns or {}, sheet)
    titles, per_load = export.titles, pieces_per_load or math.inf
    totals = _totals(export.cells)
    if totals.any():
        words = export.cells[totals][_ours(export.cells)].agg(" ".join, axis=1).str.strip()
        problems.add("", "a total", "orders alone", words.index.tolist(), words.tolist())
    rows = ExportRows(
        replace(export, cells=export.cells[~totals]), how, problems, dates, None if quantity == "tasks" else per_load
    )
    with_places = _unread(rows, export.unread)
    rows.check()
    _doubles(rows)
    lines = rows.lines()
    assumed = [*export.assumed, *rows.assumed, *_priorities(rows, lines)]
    if quantity is None and "quantity" in titles:
        loads = f"{pieces_per_load} on a load" if pieces_per_load else "all of a row on one load"
        assumed.insert(len(export.assumed), f"'{titles['quantity']}' counts pieces, {loads}")
    skipped = export.cells.drop(rows.cells.index[~rows.bad])[_ours(export.cells)]
    return OrderDay(
        tuple(sorted(lines, key=attrgetter("release"))),
        sum(pieces for pieces, bad in zip(rows.pieces, rows.bad, strict=True) if not bad),
        tuple(problems.messages()),
        skipped.assign(row=skipped.index),
        tuple(assumed),
        rows.midnight,
        how,
        tuple(titles[rank] + " (it has places of the model)" * (rank in with_places) for rank in export.unread),
    )


def _ours(cells: pd.DataFrame) -> list[str]:
    """Select our columns of a table."""
    return [name for name in cells if name in ORDER_COLUMNS]


def _without_orders(path: Path) -> Model:
    """Load a model without the files of orders that its flows name, as they may not exist yet."""
    expected = "a model with layout, fleet and tasks"
    document = from_file(path, str(path), expected, OUTLINE)
    data: Any = document.data
    tasks = data.get("tasks") if isinstance(data, dict) else None
    flows = tasks.get("flows") if isinstance(tasks, dict) else None
    overrides = {
        f"tasks.flows.{name}.arrivals": {"schedule": [{"at": 0}]}
        for name, flow in (flows.items() if isinstance(flows, dict) else ())
        if isinstance(flow, dict) and isinstance(flow.get("arrivals"), dict) and "orders" in flow["arrivals"]
    }
    return model_of(document, overrides)


def _priorities(rows: ExportRows, lines: list[OrderLine]) -> list[str]:
    """Return words for the direction of priorities, if priorities differ."""
    priorities = {line.priority for line in lines if line.priority is not None}
    if len(priorities) < 2:  # noqa: PLR2004 - nothing comes before another
        return []
    title, first, last = rows.titles["priority"], max(priorities), min(priorities)
    return [f"'{title}' is higher where it is more urgent: {first} before {last}"]


def _totals(cells: pd.DataFrame) -> Any:
    """Return for each row whether it is a total: it has a word for a sum, and no place."""
    words = cells[_ours(cells)].apply(lambda column: column.str.match(_TOTAL)).any(axis=1).to_numpy()
    return words & (cells[[name for name in ("from", "to") if name in cells]] == "").all(axis=1).to_numpy()


def _unread(rows: ExportRows, unread: Sequence[int]) -> set[int]:
    """Flag rows of cancelled orders, by words in unread columns; return the unread columns that hold places.

    In a column of states such a word may have others behind it: `CANCELLED_BY_CUSTOMER`.
    """
    with_places = set()
    for rank in unread:
        texts = rows.cells[rank]
        words = set(texts) - {""}
        if words and sum(word in rows.how.names or word in rows.how.numbers for word in words) * 2 >= len(words):
            with_places.add(rank)
        title = heading(rows.titles[rank])[0]
        flag, behind = re.fullmatch(_FLAG, title), r"(?:[\W_].*)?" if re.fullmatch(_STATUS, title) else ""
        states = [
            word
            for word in words
            if re.fullmatch(f"(?:{_CANCELLED}){behind}", word.casefold(), re.DOTALL)
            or (flag and re.sub(r"[\W_0]", "", word.casefold()) not in _NO)
        ]
        expected = "orders that are driven; --skip-bad leaves such rows out"
        rows.flag(texts.isin(states).to_numpy() & ~rows.bad, rank, "an order that was called off", expected)
    return with_places


def _doubles(rows: ExportRows) -> None:
    """Flag duplicate rows, and empty cells in columns of places.

    Rows are alike only if all their cells are, also those that are not read.
    """
    for column in [name for name in ("from", "to") if name in rows.cells]:
        cure = "a place, or no such column (the flow then says where)"
        rows.flag((rows.cells[column] == "").to_numpy() & ~rows.bad, column, "nothing there", cure)
    if "order" in rows.cells:
        twice = rows.cells.duplicated().to_numpy() & ~rows.bad
        rows.flag(twice, "order", "the same row as one before", "every row once")


def files(day: OrderDay, out: Path) -> tuple[Path, ...]:
    """Return the files of a day: its orders, and the rows left out beside them, if there are some."""
    return (out, out.with_name(f"{out.stem}.skipped.csv")) if len(day.skipped) else (out,)


def write(day: OrderDay, out: Path) -> None:
    """Write the orders of a day as Parquet, or CSV by the name, and rows left out beside; raises ModelError."""
    try:
        if out.suffix.lower() == ".csv":
            day.table().to_csv(out, index=False)
        else:
            day.table().to_parquet(out, index=False)
        for beside in files(day, out)[1:]:
            day.skipped.to_csv(beside, index=False)
    except OSError as error:
        raise ModelError([f"{out}: cannot be written ({reason(error)})"]) from None
