"""Simulated runs as logs of a fleet: reports of its robots every second."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.fleet_log.table import CHARGE, DROP, NOTHING, PICK, FleetLog, Notes
from desim_warehouse.states import BROKEN, SHOWN, Phase

if TYPE_CHECKING:
    import pandas as pd

    from desim_warehouse.run import RunData

_ACTIONS = {Phase.LOADING: PICK, Phase.UNLOADING: DROP, Phase.CHARGING: CHARGE}
_DRIVING = {Phase.TO_GOOD, Phase.TO_STATION, Phase.TO_BAY}
_FULL = 100.0

_WITH_LOAD = {
    name
    for name, state in SHOWN.items()
    if state.phase in {Phase.TO_STATION, Phase.UNLOADING} or (state.queue is not None and state.queue.at == "station")
}


def sampled(run: RunData, every: float = 1.0) -> pd.DataFrame:
    """Sample reports of all robots every so many seconds: columns of `FleetLog.table`, the heading, nodes by name.

    Sorted by time. Raises ReportError for a run without `log: all`.
    """
    seconds = run.model.units.seconds
    times = np.arange(0.0, run.history.end, every / seconds)
    table = run.positions(times)
    fleet = run.model.fleet.size
    columns: dict[str, Any] = {
        name: np.empty((len(times), fleet), kind)
        for name, kind in {"driving": bool, "load": bool, "action": np.int8, "charge": float, "fault": bool}.items()
    }
    waits = [np.zeros(len(times), bool) for _ in range(fleet)]
    for wait in run.history.waits:
        waits[wait.robot][slice(*np.searchsorted(times, (wait.start, wait.end)))] = True
    for robot, spans in enumerate(run.history.states):
        states = [span.seen for span in spans]
        ranks = np.searchsorted([span.start for span in spans], times, side="right") - 1
        columns["driving"][:, robot] = np.array([state.phase in _DRIVING for state in states])[ranks] & ~waits[robot]
        columns["action"][:, robot] = np.array([_ACTIONS.get(state.phase, NOTHING) for state in states])[ranks]  # type: ignore[arg-type]
        columns["fault"][:, robot] = np.array([state.name in BROKEN for state in states])[ranks]
        columns["load"][:, robot] = np.array(_loaded([state.name for state in states]))[ranks]
        columns["charge"][:, robot] = _charge(run, robot, times)
    table["time"] *= seconds
    return table.assign(**{name: column.ravel() for name, column in columns.items()})


def _loaded(names: list[str]) -> list[bool]:
    """Whether a robot has a load in each of its states; broken down it keeps the load that it had before."""
    loaded: list[bool] = []
    for name in names:
        loaded.append(bool(loaded) and loaded[-1] if name in BROKEN else name in _WITH_LOAD)
    return loaded


def _charge(run: RunData, robot: int, times: Any) -> Any:
    """Return the battery's level in per cent, nan without batteries."""
    batteries = run.history.batteries
    if not batteries:
        return np.full(len(times), _FULL)
    return np.interp(times, *run.history.energy_curves[robot]) / batteries[robot].capacity * _FULL


def from_run(run: RunData, every: float = 1.0) -> FleetLog:
    """Return the log that the robots of a run would have written, one row for each every so many seconds."""
    import pandas as pd

    table = sampled(run, every).drop(columns="heading")
    node = pd.Categorical(table["node"], list(run.layout.graph))
    table["node"] = node.codes.astype(np.int32)
    table = table.sort_values(["robot", "time"], kind="stable", ignore_index=True)
    robots = tuple(f"robot {number}" for number in range(run.model.fleet.size))
    notes = Notes(rows=len(table))
    return FleetLog(f"{run.model.name}, seed {run.seed}", table, robots, tuple(node.categories), 0.0, every, notes)
