"""What every robot does from when to when, and its energy: from the log alone."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import TYPE_CHECKING, NamedTuple

from desim_warehouse.log import NONE, STATES

if TYPE_CHECKING:
    import pandas as pd

    from desim_warehouse.run import Run
    from desim_warehouse.world.battery import Battery

_TAPER_POINTS = 16
"""Points on a charge curve that is not straight."""


class Stay(NamedTuple):
    """A robot in one state from `start` to `end`, with the task at hand (-1: none) and the energy at its start."""

    robot: int
    state: str
    start: float
    end: float
    task: int
    energy: float | None


class Errand(NamedTuple):
    """A robot with a task from its assignment to its delivery or return (`ended`; `open` at the end of the run)."""

    robot: int
    task: int
    start: float
    end: float
    ended: str


def stays(run: Run) -> list[list[Stay]]:
    """For each robot its states in order of time; together they fill the run, none of no length.

    At the start robots are idle.
    """
    from desim_warehouse.world.battery import start_levels

    levels = [None if math.isinf(level) else level for level in start_levels(run.model, run.seed)]
    now = [Stay(number, "idle", 0.0, 0.0, NONE, level) for number, level in enumerate(levels)]
    found: list[list[Stay]] = [[] for _ in now]
    for row in run.record.rows:
        time, kind, robot, task, energy = row[0], row[1], row[2], row[3], row[6]
        if kind in STATES:
            if time > now[robot].start:
                found[robot].append(now[robot]._replace(end=time))
            now[robot] = Stay(robot, kind, time, time, task, energy)
    for last in now:
        if run.record.end > last.start:
            found[last.robot].append(last._replace(end=run.record.end))
    return found


def state_table(run: Run) -> pd.DataFrame:
    """The states of all robots as a table: robot, state, start, end, task, energy (at the start)."""
    import pandas as pd

    rows = [stay for robot in stays(run) for stay in robot]
    return pd.DataFrame.from_records(rows, columns=list(Stay._fields))


def errands(run: Run) -> list[Errand]:
    """Every task from the moment a robot has it to its delivery, its return to the list, or the end of the run."""
    at_hand: dict[int, tuple[int, float]] = {}
    found = []
    for row in run.record.rows:
        time, kind, robot, task = row[:4]
        if kind == "assigned":
            at_hand[task] = robot, time
        elif kind in ("delivered", "returned") and task in at_hand:
            holder, start = at_hand.pop(task)
            found.append(Errand(holder, task, start, time, kind))
    found += [Errand(robot, task, start, run.record.end, "open") for task, (robot, start) in at_hand.items()]
    return sorted(found, key=lambda errand: (errand.start, errand.robot))


def energy_curves(run: Run) -> list[tuple[list[float], list[float]]]:
    """For each robot times and energies between which its battery runs straight; empty without a battery.

    The log tells the energy at every change of state. In between it falls at the state's rate; where standing
    draws another rate, waits (recorded with `log: all`) are corners too; a tapered charge is sampled.
    """
    from desim_warehouse.world.battery import Battery

    spec = run.model.battery
    if spec is None:
        return []
    battery = Battery(spec)
    waits: dict[int, list[tuple[float, float]]] = defaultdict(list)
    if battery.varies and run.record.everything:
        for start, end, robot in run.waits[["start", "end", "robot"]].itertuples(index=False):
            waits[robot].append((start, end))
    curves = []
    for robot in stays(run):
        times: list[float] = []
        levels: list[float] = []
        for stay in robot:
            for time, level in _corners(stay, battery, waits[stay.robot]):
                times.append(time)
                levels.append(level)
        times.append(run.record.end)
        levels.append(_last(robot[-1], levels[-1], battery))
        curves.append((times, levels))
    return curves


def _corners(stay: Stay, battery: Battery, waits: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Start of a stay, and where the rate changes inside it."""
    level = battery.capacity if stay.energy is None else stay.energy
    points = [(stay.start, level)]
    if stay.state == "charging":
        if battery.spec is not None and battery.spec.taper is not None:
            step = (stay.end - stay.start) / _TAPER_POINTS
            points += [
                (stay.start + n * step, level + battery.charge_gain(level, n * step)) for n in range(1, _TAPER_POINTS)
            ]
        return points
    driving, standing = battery.rates[stay.state], battery.rates["waiting"]
    now = stay.start
    for start, end in waits:
        if start >= stay.start and end <= stay.end:
            at_start = level - driving * (start - now)
            level, now = at_start - standing * (end - start), end
            points += [(start, at_start), (end, level)]
    return points


def _last(stay: Stay, level: float, battery: Battery) -> float:
    """The energy at the end of the run, which the log does not tell."""
    if stay.state == "charging":
        start = battery.capacity if stay.energy is None else stay.energy
        return start + battery.charge_gain(start, stay.end - stay.start)
    return level
