"""A run on disk, for `desim run --out` and commands that read its folder: written by `Run.save`, read by `load_run`.

run.json holds seed, version, the model's content and the tallies. log.parquet holds the rows. kpis.json and the tables
robots.csv, edges.csv and nodes.csv are written for people and other programs.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar, get_args

from desim_warehouse._version import __version__
from desim_warehouse.errors import LayoutError, ModelError, ReportError, reason, spoken
from desim_warehouse.folders import RUN, STUDY, drop_page, filled_folder, refuse_theirs, sha256, too_old, whole_file
from desim_warehouse.run.spreadsheet import as_csv

if TYPE_CHECKING:
    import pandas as pd

    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model
    from desim_warehouse.outcome.log import Log

FORMAT = 1
LOG, KPIS = "log.parquet", "kpis.json"
TABLES = ("robots", "edges", "nodes")
"""Tables that are written as CSV."""
_NEEDED = {
    **dict.fromkeys(("parked", "docked"), ("node",)),
    "enter": ("edge",),
    **dict.fromkeys(("aside", "back"), ("edge", "value")),
    "drive": ("edge", "value", "until"),
}
"""Columns that every row of a kind has."""
_DAMAGED = (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError, ModelError, LayoutError)
"""What reading a damaged folder raises."""
R = TypeVar("R")


class KeptRun(NamedTuple):
    """A run as its folder keeps it.

    `kpis`: its indicators by name, NaN for those without a value. On reading they are those saved by another version,
    and none if this version simulated the run, as they follow from the log.
    """

    model: Model
    seed: int
    log: Log
    layout: Layout
    deterministic: bool
    kpis: dict[str, float]


@contextmanager
def prepared(folder: Path) -> Iterator[None]:
    """Make the folder of a run, which goes again if no run is written within the context.

    Raises ReportError if it cannot be made or written to, or holds something else.
    """
    if (folder / STUDY).exists():
        raise ReportError(f"{folder}: holds a study; a run needs a folder of its own")
    with ExitStack() as made:
        try:
            made.enter_context(filled_folder(folder))
            refuse_theirs(folder, (RUN, LOG, KPIS, *(f"{name}.csv" for name in TABLES)))
        except OSError as error:
            raise ReportError(f"{folder}: the run cannot be written there ({reason(error)})") from error
        yield


def save_run(run: KeptRun, tables: Mapping[str, pd.DataFrame], folder: Path) -> Path:
    """Write a run, and tables by name, to a folder; run.json comes last, so a folder that has it is complete.

    Raises ReportError where nothing can be written, or the folder is a study's.
    """
    with prepared(folder):
        try:
            return _write(run, tables, folder)
        except OSError as error:
            raise ReportError(f"{folder}: the run cannot be written there ({reason(error)})") from error


def _write(run: KeptRun, tables: Mapping[str, pd.DataFrame], folder: Path) -> Path:
    log = run.log
    table = log.frame()
    kpis = {key: None if math.isnan(value) else value for key, value in run.kpis.items()}
    texts = {KPIS: json.dumps(kpis, indent=2) + "\n"}
    texts |= {f"{name}.csv": as_csv(tables[name], index=True) for name in TABLES}
    content = {
        "format": FORMAT,
        "version": log.version,
        "seed": run.seed,
        "deterministic": run.deterministic,
        "model": run.model.content(),
        "log": {
            "level": log.level,
            "begin": log.begin,
            "end": log.end,
            "finished": log.finished,
            "rings": log.rings,
            "due": list(log.due.items()),
            "flows": list(log.flows.items()),
            "orders": list(log.orders.items()),
            "for_workers": None if log.for_workers is None else sorted(log.for_workers),
            "energy": log.energy,
            "people": log.people,
            "robots": log.robots,
            "edges": log.edges,
            "nodes": log.nodes,
            "stations": log.stations,
        },
    }
    with ExitStack() as files:  # which take their places in reverse
        partial = {name: files.enter_context(whole_file(folder / name)) for name in (RUN, *texts, LOG)}
        table.to_parquet(partial[LOG], index=False)
        content["sha256"] = {LOG: sha256(partial[LOG])}
        texts[RUN] = json.dumps(content) + "\n"
        for name, text in texts.items():
            partial[name].write_text(text, encoding="utf-8")
        drop_page(folder, RUN, texts[RUN])
    return folder


def _content(path: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    if content["format"] != FORMAT:
        raise ValueError(f"format {content['format']!r}, expected {FORMAT}: made by another version")
    if (why := too_old(content["version"])) is not None:
        raise ValueError(why)
    return content


def _kpis(folder: Path) -> dict[str, float]:
    """Read the indicators that were saved with a run."""
    kept: dict[str, float | None] = json.loads((folder / KPIS).read_text(encoding="utf-8"))
    return {name: math.nan if value is None else float(value) for name, value in kept.items()}


def _log(kept: dict[str, Any], rows: list[Any], version: str) -> Log:
    """Rebuild the log of a saved run from its rows, and what stands beside them."""
    from desim_warehouse.outcome.log import Log

    return Log(
        level=kept["level"],
        rows=rows,
        rings=[(time, tuple(robots), tuple(edges)) for time, robots, edges in kept["rings"]],
        robots=kept["robots"],
        edges=kept["edges"],
        nodes=kept["nodes"],
        stations=kept.get("stations"),
        due=dict(kept["due"]),
        flows=dict(kept["flows"]),
        orders=dict(kept["orders"]),
        for_workers=None if kept.get("for_workers") is None else set(kept["for_workers"]),
        energy=kept["energy"],
        people=kept["people"],
        begin=kept["begin"],
        end=kept["end"],
        finished=kept.get("finished"),
        version=version,
    )


def _table(folder: Path, content: dict[str, Any]) -> pd.DataFrame:
    """Read the table of the log as written; raises ValueError for any other table. 0.3.0 did not mark its tables."""
    import pandas as pd

    written = content.get("sha256", {}).get(LOG)
    if written is not None and written != sha256(folder / LOG):
        raise ValueError(f"{LOG} is not as it was written")
    return pd.read_parquet(folder / LOG)


def _rows(table: pd.DataFrame, layout: Layout, *, ours: bool) -> list[Any]:
    """Return the rows of a log, with the edges of the layout; raises ValueError where they name another.

    `ours`: this version wrote it, and all columns that it knows.
    """
    import pandas as pd

    from desim_warehouse.outcome.log import LogRow

    missing = set(LogRow._fields) - set(table) if ours else set()
    if missing:
        raise ValueError(f"{LOG} has no column {spoken(sorted(missing))}")
    table = table.reindex(columns=list(LogRow._fields))  # a column that the saved run did not know is empty
    table = table.astype(object).where(table.notna(), None)
    edges: dict[str | None, tuple[str, str] | None] = {None: None, **dict(layout.labels)}
    table["edge"] = pd.Series([edges[label] for label in table["edge"]], index=table.index, dtype=object)
    return [tuple(row) for row in table.to_numpy().tolist()]


def _check(log: Log, model: Model, layout: Layout) -> None:
    """Raise ValueError for a log that cannot stem from a run of this model."""
    from desim_warehouse.outcome.log import KINDS, NONE, Detail

    size, before = model.fleet.size, 0.0
    if len(log.robots) != size:
        raise ValueError(f"{len(log.robots)} robots, expected the {size} of its model")
    if not (log.level in get_args(Detail) and 0 <= log.begin <= log.end < math.inf):
        raise ValueError(f"level {log.level}, from {log.begin} to {log.end}, expected those of a run")
    lanes, crossed = [tally["edge"] for tally in log.edges], [tally["node"] for tally in log.nodes]
    stations = [tally["station"] for tally in log.stations or ()]
    if len(log.energy) not in {0, size} or not (lanes and crossed) or not set(stations) <= set(layout.graph):
        raise ValueError("its tallies are not those of a run")
    nodes, robots = {None, *layout.graph}, frozenset(range(NONE, size))
    for number, row in enumerate(log.named_rows(), 1):
        if row.kind not in KINDS or row.node not in nodes or row.robot not in robots or row.task < NONE:
            raise ValueError(f"{LOG}, row {number}: no such kind of row, robot, task or node")
        if any(getattr(row, column) is None for column in _NEEDED.get(row.kind, ())):
            raise ValueError(f"{LOG}, row {number}: {row.kind} without {spoken(_NEEDED[row.kind])}")
        if not before <= row.time <= log.end:
            raise ValueError(f"{LOG}, row {number}: not in order of time")
        before = row.time


def read_run(folder: Path, make: Callable[[KeptRun], R]) -> R:
    """Read a folder that a run was saved to, and return what `make` makes of it.

    Raises ReportError where there is no run, or `make` fails on what is damaged.
    """
    from desim_warehouse.model import load

    try:
        content = _content(folder / RUN)
        model = load(content["model"])
        layout = model.floor
        version = content["version"]
        log = _log(content["log"], _rows(_table(folder, content), layout, ours=version == __version__), version)
        _check(log, model, layout)
        kpis = {} if log.version == __version__ else _kpis(folder)
        return make(KeptRun(model, content["seed"], log, layout, content["deterministic"], kpis))
    except _DAMAGED as error:
        raise ReportError(
            f"{folder}: no run can be read there ({reason(error)}); desim run MODEL --out DIR writes one"
        ) from error
