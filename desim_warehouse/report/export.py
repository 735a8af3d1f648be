"""Export a run for other programs: as tables in CSV or Parquet, a trace for Perfetto, or messages of VDA 5050."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from desim_warehouse.answer import words
from desim_warehouse.errors import ReportError, reason
from desim_warehouse.fleet_log.vda5050 import messages
from desim_warehouse.folders import filled_folder, refuse_other, refuse_theirs, whole_file, write_whole
from desim_warehouse.outcome.log import NONE
from desim_warehouse.run import RunData
from desim_warehouse.run.spreadsheet import as_csv
from desim_warehouse.values.frames import typed

if TYPE_CHECKING:
    import pandas as pd


Format = Literal["csv", "parquet", "trace", "vda5050"]
FORMATS: tuple[str, ...] = get_args(Format)
_STATES, _TASKS, _WAITS = 1, 2, 3
"""The tracks of a robot, in display order."""
_TRACKS = {_STATES: "states", _TASKS: "tasks", _WAITS: "waits"}
_RINGS = 1
"""The process of fleet-wide events; robot n is process n + 2."""


def export(
    run: RunData, form: str, path: str | Path, *, noise: float = 0.0, gaps: float = 0.0, force: bool = False
) -> Path:
    """Write a run in an open format, and return the path written.

    Args:
        run: the run.
        form: "csv" or "parquet" for a folder with the tables kpis, log, states, waits, robots, edges and nodes;
            "trace" for a JSON file in the Trace Event Format, for https://ui.perfetto.dev or chrome://tracing;
            "vda5050" for the state messages that its robots would have sent, one per line.
        path: the folder or file to write.
        noise: for vda5050, standard deviation of positions, in the length unit of the layout.
        gaps: for vda5050, number of gaps of 20 to 90 s without messages, per robot and hour.
        force: whether to overwrite files that this function did not write.

    Raises:
        ReportError: an unknown format, or a path that cannot be written or holds other files.
    """
    if form not in FORMATS:
        raise ReportError(f"format {form!r}: expected one of {', '.join(FORMATS)}")
    path = Path(path)
    try:
        with filled_folder(path.parent if form in {"trace", "vda5050"} else path):
            if form == "trace":
                if not force:
                    refuse_other(path, "trace")
                write_whole(path, json.dumps(trace(run), separators=(",", ":"), allow_nan=False))
            elif form == "vda5050":
                if not force:
                    refuse_other(path, "messages")
                with whole_file(path) as partial, partial.open("w", encoding="utf-8") as file:
                    file.writelines(f"{line}\n" for line in messages(run, noise=noise, gaps=gaps))
            else:
                _write_tables(run, form, path, force=force)
    except OSError as error:
        raise ReportError(f"{path}: cannot be written ({reason(error)})") from error
    return path


def _write_tables(run: RunData, form: str, folder: Path, *, force: bool) -> None:
    frames = tables(run)
    if not force:
        refuse_theirs(folder, [f"{name}.{form}" for name in frames])
    for name, table in frames.items():
        with whole_file(folder / f"{name}.{form}") as partial:
            if form == "csv":
                partial.write_text(as_csv(table), encoding="utf-8")
            else:
                table.to_parquet(partial, index=False)


def tables(run: RunData) -> dict[str, pd.DataFrame]:
    """Return all tables of a run by name, with times in the model's time unit; kpis has a row for each indicator.

    There are no `waits` unless the run has `log: all`.
    """
    import pandas as pd

    units = run.model.units
    kpis = pd.DataFrame(
        {
            "indicator": list(run.kpis),
            "value": [float(value) for value in run.kpis.values()],
            "unit": [words.unit(words.indicator_kind(key), units) for key in run.kpis],
        }
    )
    return {
        "kpis": kpis,
        "log": run.log,
        "tasks": run.tasks.reset_index(),
        "states": state_table(run),
        **({"waits": run.waits} if run.record.level == "all" else {}),
        "robots": run.robots.reset_index(),
        "edges": run.edges.reset_index(),
        "nodes": run.nodes.reset_index(),
    }


def state_table(run: RunData) -> pd.DataFrame:
    """Return the states of all robots as a table: robot, state, start, end, task, energy (at the start)."""
    import pandas as pd

    columns = {"robot": int, "state": str, "start": float, "end": float, "task": int, "energy": float}
    rows = [[getattr(span, name) for name in columns] for robot in run.history.states for span in robot]
    return typed(pd.DataFrame.from_records(rows, columns=list(columns)), columns)


def trace(run: RunData) -> dict[str, Any]:
    """Return a run in the Trace Event Format: a process for each robot, with tracks for states, tasks and waits.

    A wait is a slice of the robot that waits, with a flow from the state of the robot it waits for. Battery levels are
    counters. Timestamps are microseconds of simulated time. Gridlock rotations are marks of a separate process.

    Source: Google, Trace Event Format (JSON Object Format; events X, M, C, I, s and f).
    """
    microseconds = run.model.units.seconds * 1e6

    def in_microseconds(time: float) -> float:
        """Return a time of the run in microseconds, to the nanosecond."""
        return round(time * microseconds, 3)

    events = [
        *_names(run),
        *_states(run, in_microseconds),
        *_tasks(run, in_microseconds),
        *_waits(run, in_microseconds),
        *_batteries(run, in_microseconds),
        *_rotations(run, in_microseconds),
    ]
    return {
        "traceEvents": events,
        "displayTimeUnit": "ms",
        "otherData": {"model": run.model.name, "seed": run.seed, "version": run.version, "digest": run.model.digest()},
    }


def _process(robot: int) -> int:
    return robot + 2


def _names(run: RunData) -> list[dict[str, Any]]:
    """Return events with the names and the order of processes and tracks."""
    fleet = range(run.model.fleet.size)
    named = [(_RINGS, f"{run.model.name}: fleet"), *((_process(n), f"robot {n}") for n in fleet)]
    events: list[dict[str, Any]] = []
    for order, (process, name) in enumerate(named):
        events.append({"ph": "M", "pid": process, "tid": 0, "name": "process_name", "args": {"name": name}})
        events.append(
            {"ph": "M", "pid": process, "tid": 0, "name": "process_sort_index", "args": {"sort_index": order}}
        )
    for number in fleet:
        for track, name in _TRACKS.items():
            events.append(
                {"ph": "M", "pid": _process(number), "tid": track, "name": "thread_name", "args": {"name": name}}
            )
    return events


def _slice(pid: int, track: int, name: str, span: tuple[float, float], args: dict[str, Any]) -> dict[str, Any]:
    start, end = span
    return {
        "ph": "X",
        "pid": pid,
        "tid": track,
        "cat": _TRACKS[track],
        "name": name,
        "ts": start,
        "dur": round(end - start, 3),
        "args": args,
    }


def _states(run: RunData, in_microseconds: Callable[[float], float]) -> list[dict[str, Any]]:
    return [
        _slice(
            _process(span.robot),
            _STATES,
            words.STATE_WORDS[span.state],
            (in_microseconds(span.start), in_microseconds(span.end)),
            {} if span.task == NONE else {"task": span.task},
        )
        for robot in run.history.states
        for span in robot
    ]


def _tasks(run: RunData, in_microseconds: Callable[[float], float]) -> list[dict[str, Any]]:
    return [
        _slice(
            _process(work.robot),
            _TASKS,
            f"task {work.task}",
            (in_microseconds(work.start), in_microseconds(work.end)),
            {"ended": work.ended},
        )
        for work in run.history.assignments
    ]


def _waits(run: RunData, in_microseconds: Callable[[float], float]) -> list[dict[str, Any]]:
    """Return a slice for each wait, and a flow from the robot waited for."""
    events: list[dict[str, Any]] = []
    for number, wait in enumerate(run.history.waits):
        place = f"before {wait.node}" if wait.edge is None else f"on {'>'.join(wait.edge)}"
        whom = "waits" if wait.other == NONE else f"waits for robot {wait.other}"
        span = (in_microseconds(wait.start), in_microseconds(wait.end))
        events.append(_slice(_process(wait.robot), _WAITS, whom, span, {"where": place}))
        if wait.other != NONE:
            flow = {"cat": "waits", "name": "in the way", "id": number, "ts": span[0]}
            events.append({"ph": "s", "pid": _process(wait.other), "tid": _STATES, **flow})
            events.append({"ph": "f", "bp": "e", "pid": _process(wait.robot), "tid": _WAITS, **flow})
    return events


def _batteries(run: RunData, in_microseconds: Callable[[float], float]) -> list[dict[str, Any]]:
    return [
        {
            "ph": "C",
            "pid": _process(number),
            "tid": 0,
            "name": "battery",
            "ts": in_microseconds(time),
            "args": {"energy": round(level, 6)},
        }
        for number, (times, levels) in enumerate(run.history.energy_curves)
        for time, level in zip(times, levels, strict=True)
        if math.isfinite(level)
    ]


def _rotations(run: RunData, in_microseconds: Callable[[float], float]) -> list[dict[str, Any]]:
    return [
        {
            "ph": "I",
            "s": "g",
            "pid": _RINGS,
            "tid": 0,
            "cat": "rotations",
            "name": "gridlock rotation",
            "ts": in_microseconds(time),
            "args": {"robots": list(robots), "edges": list(edges)},
        }
        for time, robots, edges in run.history.rotations
    ]
