"""A run on disk: what `Run.save` writes and `load_run` reads back.

run.json holds seed, version, the model's content and the tallies. log.parquet holds the rows. kpis.json and the tables
robots.csv, edges.csv and nodes.csv are there for people and other programs.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from desim_warehouse._version import __version__
from desim_warehouse.errors import ReportError, reason
from desim_warehouse.folders import make_folder, too_old, write_whole
from desim_warehouse.run.spreadsheet import as_csv

if TYPE_CHECKING:
    import pandas as pd

    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model
    from desim_warehouse.outcome.log import Log

FORMAT = 1
RUN, STUDY = "run.json", "study.json"
"""The files by which the folders of runs and studies are recognised."""
KPIS = "kpis.json"
NUMBER = "edge_number"
"""Column of the log with the edges' numbers, where two edges have one name."""
R = TypeVar("R")


class KeptRun(NamedTuple):
    """A run as its folder keeps it.

    `kpis`: its indicators by name, NaN where one has no value. Read back they are those that another version saved, and
    none where this version simulated the run, as they follow from the log.
    """

    model: Model
    seed: int
    log: Log
    layout: Layout
    deterministic: bool
    kpis: dict[str, float]


def prepare(folder: Path) -> None:
    """Make the folder of a run; raises ReportError where that is not possible, or the folder is a study's."""
    if (folder / STUDY).exists():
        raise ReportError(f"{folder}: holds a study; a run needs a folder of its own")
    try:
        make_folder(folder)
    except OSError as error:
        raise ReportError(f"{folder}: the run cannot be written there ({reason(error)})") from error


def save_run(run: KeptRun, tables: Mapping[str, pd.DataFrame], folder: Path) -> Path:
    """Write a run, and tables by name, to a folder; run.json comes last, so a folder that has it is complete.

    Raises ReportError where nothing can be written, or the folder is a study's.
    """
    prepare(folder)
    try:
        return _write(run, tables, folder)
    except OSError as error:
        raise ReportError(f"{folder}: the run cannot be written there ({reason(error)})") from error


def _write(run: KeptRun, tables: Mapping[str, pd.DataFrame], folder: Path) -> Path:
    log = run.log
    table = log.frame()
    edges = _edges(run.layout)
    if len({">".join(edge) for edge in edges}) < len(edges):  # node names with > in them: which edge is meant?
        number = {edge: i for i, edge in enumerate(edges)}
        table[NUMBER] = [-1 if edge is None else number[edge] for edge in log.edge_of_rows()]
    table.to_parquet(folder / "log.parquet", index=False)
    kpis = {key: None if math.isnan(value) else value for key, value in run.kpis.items()}
    write_whole(folder / KPIS, json.dumps(kpis, indent=2) + "\n")
    for name, table in tables.items():
        write_whole(folder / f"{name}.csv", as_csv(table, index=True))
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
    write_whole(folder / RUN, json.dumps(content) + "\n")
    return folder


def _edges(layout: Layout) -> list[tuple[str, str]]:
    """The edges that rows may name: those of the layout, and of storage places on nodes."""
    on_nodes = (place.edge for place in layout.storage if place.edge[0] == place.edge[1])
    return [*layout.graph.edges, *dict.fromkeys(on_nodes)]


def _content(path: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    if content["format"] != FORMAT:
        raise ValueError(f"format {content['format']!r}, expected {FORMAT}: made by another version")
    if (why := too_old(content["version"])) is not None:
        raise ValueError(why)
    return content


def _kpis(folder: Path) -> dict[str, float]:
    """The indicators that were saved with a run."""
    kept: dict[str, float | None] = json.loads((folder / KPIS).read_text(encoding="utf-8"))
    return {name: math.nan if value is None else value for name, value in kept.items()}


def _log(kept: dict[str, Any], rows: list[Any], version: str) -> Log:
    """The log of a saved run: its rows, and what stands beside them."""
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
        version=version,
    )


def read_run(folder: Path, make: Callable[[KeptRun], R]) -> R:
    """Read a folder that a run was saved to, and return what `make` makes of it.

    Raises ReportError where there is no run, or `make` fails on what is damaged.
    """
    import pandas as pd

    from desim_warehouse.model import load
    from desim_warehouse.outcome.log import LogRow

    try:
        content = _content(folder / RUN)
        table = pd.read_parquet(folder / "log.parquet")
        kept = content["log"]
        model = load(content["model"])
        layout = model.floor
        edges = _edges(layout)
        numbers = table.pop(NUMBER) if NUMBER in table else None
        table = table.reindex(columns=list(LogRow._fields))  # a column that the saved run did not know is empty
        table = table.astype(object).where(table.notna(), None)
        if numbers is None:
            table["edge"] = table["edge"].map({">".join(edge): edge for edge in edges}.get)
        else:
            table["edge"] = [None if number < 0 else edges[number] for number in numbers]
        log = _log(kept, [tuple(row) for row in table.to_numpy().tolist()], content["version"])
        kpis = {} if log.version == __version__ else _kpis(folder)
        return make(KeptRun(model, content["seed"], log, layout, content["deterministic"], kpis))
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise ReportError(
            f"{folder}: no run can be read there ({reason(error)}); desim run MODEL --out DIR writes one"
        ) from error
