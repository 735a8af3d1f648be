"""A day of orders from an ERP, made ready for a model: what is in it, what is wrong with it, what was assumed."""

from __future__ import annotations

import datetime as dt
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from desim_warehouse.errors import ModelError, reason, spoken
from desim_warehouse.model.parse import from_file
from desim_warehouse.model.schema import OUTLINE, Model, model_of, reading
from desim_warehouse.model.sections.flows import STORAGE, OrdersFile, StorageEnd
from desim_warehouse.model.sections.order_file import (
    BETWEEN,
    BEYOND,
    REST,
    Problems,
    Table,
    check_there,
    chunks,
    table_of,
)
from desim_warehouse.model.sections.order_rows import Chunk, OrderLine, Reading, clock, first_day
from desim_warehouse.values.fields import LIMITS

if TYPE_CHECKING:
    import pandas as pd


_TOTAL = re.compile(r"(?i)^\W*(grand |sub)?(total|sum|summe|gesamt\w*|zwischensumme)\b|^\*{1,4}$")  # SAP has stars
_CANCELLED = r"(?i)cancell?ed|storno|storniert|abgesagt|returned|retoure|refunded|voided|deleted|gelöscht"
"""States in which an order is not driven."""
_HOUR, _DAY = 3600.0, 86_400.0


@dataclass(frozen=True)
class OrderDay:
    """The orders of a file.

    Attributes:
        lines: the rows that could be read, in order of release; quantities are tasks, each a trip.
        pieces: quantities added up, as the file has them.
        problems: what is wrong with other rows, a line for each kind.
        skipped: these rows, as they stand in the file.
        assumed: what the file does not say.
        start: when the run starts: a time of day in seconds.
        midnight: the day of the first order; None where the file has no dates.
        seconds: in a time unit of the model.
        items: with pods, how the file writes each item, by number.
        unread: columns that are not read; one that has places of the model says so.
    """

    lines: tuple[OrderLine, ...]
    pieces: int
    problems: tuple[str, ...]
    skipped: pd.DataFrame
    assumed: tuple[str, ...]
    start: float
    midnight: dt.datetime | None
    seconds: float
    items: tuple[str, ...] = ()
    unread: tuple[str, ...] = ()

    @property
    def orders(self) -> int:
        """How many orders there are."""
        return len({line.order for line in self.lines})

    @property
    def trips(self) -> int:
        """How many tasks there are."""
        return sum(line.quantity for line in self.lines)

    @property
    def busiest(self) -> tuple[float, int]:
        """The hour with most trips: when it begins, in seconds from midnight, and how many."""
        hours: Counter[int] = Counter()
        for line in self.lines:
            hours[int(self.time_of(line.release) // _HOUR)] += line.quantity
        hour, trips = max(hours.items(), key=lambda item: (item[1], -item[0]), default=(0, 0))
        return hour * _HOUR, trips

    def time_of(self, release: float) -> float:
        """A time from the start of the run in seconds from midnight."""
        return self.start + release * self.seconds

    def table(self) -> pd.DataFrame:
        """The orders as a file for models: times as dates where there are some, else from the start of the run."""
        import pandas as pd

        columns: dict[str, list[Any]] = {
            "order": [line.order for line in self.lines],
            "release": [line.release for line in self.lines],
            "from": [_name(line.source) for line in self.lines],
            "via": [" > ".join(map(_name, line.via or ())) for line in self.lines],
            "to": [_name(line.target) for line in self.lines],
            "due": [line.due for line in self.lines],
            "priority": [line.priority for line in self.lines],
            "quantity": [line.quantity for line in self.lines],
            "item": [None if line.item is None else self.items[line.item] for line in self.lines],
        }
        frame = pd.DataFrame(
            {name: cells for name, cells in columns.items() if any(cell is not None for cell in cells)}
        )
        if self.midnight is not None:
            for name in {"release", "due"} & set(frame):
                times = frame[name].astype(float) * self.seconds + self.start
                frame[name] = pd.Timestamp(self.midnight) + pd.to_timedelta(times, unit="s")
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
    """Read a file of orders for a model, and sum up what is wrong with it.

    Args:
        file: CSV with any separator, Parquet or Excel.
        model: whose places the orders name; flows of its own that are files of orders are not looked at.
        columns: what the file calls our columns, such as `{"release": "Anlagedatum"}`; default: by common headings.
        sheet: of an Excel file; default: the first.
        dates: how 03/02/2026 is meant.
        quantity: what quantities count; default: pieces.
        pieces_per_load: how many pieces fit on one load; default: all of a row.

    Returns:
        The orders by good row, and what is wrong with the others.

    Raises:
        ModelError: where the file or the model cannot be read. Rows with problems are in the result.
    """
    import pandas as pd

    loaded = model if isinstance(model, Model) else _without_orders(Path(model))
    counted = quantity or "pieces"
    spec = OrdersFile.model_validate(
        {"file": str(file), "columns": columns or {}, "sheet": sheet, "dates": dates, "quantity": counted}
        | ({} if pieces_per_load is None else {"pieces_per_load": pieces_per_load})
    )
    table, how = table_of(spec), reading(loaded, loaded.floor)
    day = _Day(spec, table, how)
    lines, skipped = day.read()
    assumed = list(table.assumed)
    if quantity is None and "quantity" in table.titles:
        loads = f"{pieces_per_load} on a load" if pieces_per_load else "all of a row on one load"
        assumed.append(f"'{table.titles['quantity']}' counts pieces, {loads}")
    assumed += [*day.readings(), *_dates_alone(table, day, how, lines), *_priorities(table, lines)]
    assumed += _turned(loaded, lines)
    return OrderDay(
        tuple(sorted(lines, key=attrgetter("release"))),
        day.pieces,
        tuple(day.found.told()),
        pd.concat(skipped or [pd.DataFrame()]),
        tuple(assumed),
        clock(how.start),
        day.midnight,
        how.seconds,
        tuple(how.item_numbers),
        tuple(name + " (it has places of the model)" * (name in day.with_places) for name in table.unread.values()),
    )


def _without_orders(path: Path) -> Model:
    """The model of a file, without the orders that its flows name, which need not be there yet."""
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


def _dates_alone(table: Table, day: _Day, how: Reading, lines: list[OrderLine]) -> list[str]:
    """That dates have no time of day, where none of them has."""
    start = clock(how.start)
    if day.midnight is None or not lines or any((start + line.release * how.seconds) % _DAY for line in lines):
        return []
    return [f"dates in '{table.titles['release']}' have no time of day: all orders of a day come at 00:00"]


def _priorities(table: Table, lines: list[OrderLine]) -> list[str]:
    """How priorities are read, where they differ."""
    given = {line.priority for line in lines if line.priority is not None}
    title = table.titles.get("priority", "priority")
    return [f"'{title}' is higher where it is more urgent: {max(given)} before {min(given)}"] if len(given) > 1 else []


def _turned(model: Model, lines: list[OrderLine]) -> list[str]:
    """Tasks from a station to storage, where all flows of the model lead the other way."""
    zones = {station.zone for station in model.floor.stations.values()}
    flows = model.tasks.flows
    outward = [name for name, flow in flows.items() if isinstance(flow.source, StorageEnd) and flow.target is not None]
    turned = sum(
        (line.target == STORAGE or isinstance(line.target, int))
        and isinstance(line.source, str)
        and (line.source in zones or line.source in model.floor.stations)
        for line in lines
    )
    if not turned or not outward or len(outward) < len(flows):
        return []
    flow = f"flow {spoken(outward)} {'leads' if len(outward) == 1 else 'lead'}"
    return [f"{turned:,} of {len(lines):,} lines go from a station to storage, though {flow} the other way"]


class _Day:
    """A file while it is read; rows that the model would take as they are may be wrong here: doubles, empty places."""

    def __init__(self, spec: OrdersFile, table: Table, how: Reading) -> None:
        self.spec = spec
        self.table = table
        self.how = how
        self.found = Problems(spec.file)
        self.pieces = 0
        self.seen: set[int] = set()
        self.with_places: set[str] = set()
        self.midnight = first_day(spec, table, how)
        check_there(table.path)

    def read(self) -> tuple[list[OrderLine], list[pd.DataFrame]]:
        """The rows that could be read, and the others."""
        import numpy as np

        lines: list[OrderLine] = []
        skipped: list[pd.DataFrame] = []
        rows, most = 0, LIMITS["tasks"][0]
        for frame in chunks(self.spec, self.table, rest=True):
            rows += len(frame)
            if rows > most:  # whatever they are: those that are left out are kept, too
                raise ModelError(
                    [f"{self.spec.file}: too many rows, expected at most {most:,}; split the file by days"]
                )
            numbered = frame.assign(row=frame.index).drop(columns=[BEYOND, REST], errors="ignore")
            total = self.totals(frame)
            if total.any():
                said = frame[total].fillna("").astype(str).agg(" ".join, axis=1).str.strip()
                self.found.add("", "a total", "orders alone", frame.index[total].tolist(), said)
            total |= self.cancelled(frame) & ~total
            kept = frame[~total]
            chunk = Chunk(kept, self.spec, self.table, self.how, self.midnight, self.found)
            good = chunk.lines()
            self.more_problems(chunk)
            fine = ~chunk.bad
            at_first = np.flatnonzero(fine)
            wanted = set(at_first.tolist())
            ranks = [rank for rank in range(len(kept)) if rank not in chunk.unread]
            lines += [line for line, rank in zip(good, ranks, strict=True) if rank in wanted]
            self.pieces += sum(chunk.pieces[rank] for rank in wanted)
            bad = np.array(total, dtype=bool)
            bad[np.flatnonzero(~total)[~fine]] = True
            if bad.any():
                skipped.append(numbered[bad])
        return lines, skipped

    def readings(self) -> list[str]:
        """How times and numbers are read that may be meant otherwise."""
        called = self.table.titles
        return [
            *(
                f"'{called[name]}' is as on the clock of the hall: {zone} is left out"
                for name, zone in self.found.zones.items()
                if name not in self.found.ways
            ),
            *(f"'{called[name]}' {way}" for name, way in self.found.ways.items()),
            *(f"points in '{called[name]}' stand between thousands" for name in sorted(self.found.thousands)),
        ]

    def cancelled(self, frame: pd.DataFrame) -> Any:
        """Which rows say in a column that is not read that nobody drives them; looks for places there, too."""
        import numpy as np

        found = np.zeros(len(frame), dtype=bool)
        if REST not in frame:
            return found
        cells = frame[REST].str.split(BETWEEN, expand=True)
        for column, name in zip(cells, self.table.unread.values(), strict=False):
            texts = cells[column].fillna("")
            distinct = set(texts.unique()) - {""}
            if distinct and sum(one in self.how.names or one in self.how.numbers for one in distinct) * 2 >= len(
                distinct
            ):
                self.with_places.add(name)
            hit = texts.str.fullmatch(_CANCELLED).to_numpy(dtype=bool) & ~found
            if hit.any():
                expected = "orders that are driven; --skip-bad leaves such rows out"
                self.found.add(name, "an order that was called off", expected, frame.index[hit].tolist(), texts[hit])
            found |= hit
        return found

    def totals(self, frame: pd.DataFrame) -> Any:
        """Which rows are totals: no place and no order, but a word for a sum."""
        import pandas as pd

        frame = frame.drop(columns=REST, errors="ignore")
        text = frame.astype(str).apply(lambda column: column.str.strip())
        word = text.apply(lambda column: column.str.match(_TOTAL.pattern)).any(axis=1).to_numpy()
        places = [name for name in ("from", "to") if name in frame]
        empty = (text[places] == "") | frame[places].isna() if places else pd.DataFrame(index=frame.index)
        return word & empty.all(axis=1).to_numpy()

    def more_problems(self, chunk: Chunk) -> None:
        """Rows that are there twice, and places that are not said where others say theirs."""
        import numpy as np
        import pandas as pd

        frame = chunk.table
        for column in ("from", "to"):
            if column in frame:
                texts = np.array([not str(cell).strip() for cell in frame[column].fillna("")], dtype=bool)
                cure = "a place, or no such column (the flow then says where)"
                chunk.problem(texts & ~chunk.bad, column, "nothing there", cure)
        if "order" in frame and len(frame):
            hashes = pd.util.hash_pandas_object(frame.astype(str), index=False).tolist()
            twice = np.zeros(len(frame), dtype=bool)
            for rank, number in enumerate(hashes):
                twice[rank] = number in self.seen
                self.seen.add(number)
            chunk.problem(twice & ~chunk.bad, "order", "the same row as one before", "every row once")


def files(day: OrderDay, out: Path) -> tuple[Path, ...]:
    """The files of a day: its orders, and the rows left out beside them, if there are some."""
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
