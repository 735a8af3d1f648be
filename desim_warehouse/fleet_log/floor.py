"""A log laid over the floor of a model: in its units and axes, every message on the edge that its robot drove.

Axes are found by robots in the middle of their lanes. Arrivals alone are seen late, which turns and shifts the axes a
little, and robots that stand may do so in a slot beside the lane.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from desim_warehouse.errors import ReportError, got, nearest, spoken
from desim_warehouse.fleet_log.table import GAP, FleetLog
from desim_warehouse.layout.layout import Edge
from desim_warehouse.model import Model
from desim_warehouse.values.arrays import Flags, Floats, Ints

_FEWEST = 10
"""Arrivals at nodes from which the axes of a log are found."""
_NAMES = 12
_CLOSE = 0.05
"""Axes that fit the floor this well, as a share of its extent, are those of the log."""


@dataclass(frozen=True)
class Tracks:
    """Messages of all logs of a fleet, by robot and then by time, in the model's units: one entry for each message.

    Attributes:
        robot: number of the robot; a robot has another number on every day.
        node: number of the node that the robot reached last, -1 where it has reached none.
        onto: number of the node that it drives to, -1 where there is none.
        edge: number of the edge from `node` to `onto`; -1 where the model has none, or the robot stands beside it.
        along: distance driven on that edge, from its start.
        joined: whether no gap lies between this message and the previous one of its robot.
        step: usual time between two messages of a robot.
    """

    model: Model
    time: Floats
    robot: Ints
    node: Ints
    onto: Ints
    edge: Ints
    along: Floats
    x: Floats
    y: Floats
    driving: Flags
    load: Flags
    action: Ints
    charge: Floats
    fault: Flags
    joined: Flags
    step: float
    length: float
    days: int
    notes: tuple[str, ...]

    @cached_property
    def edges(self) -> list[Edge]:
        """The edges of the layout by number."""
        return list(self.model.floor.graph.edges)

    @cached_property
    def lengths(self) -> Floats:
        """Lengths of the edges, in the model's unit."""
        return np.array([self.model.floor.length(edge) for edge in self.edges])

    @cached_property
    def before(self) -> Floats:
        """Time since the robot's previous message; 0 for its first message and after a gap."""
        return np.where(self.joined, np.diff(self.time, prepend=0.0), 0.0)


def lay_over(model: Model, logs: Sequence[FleetLog]) -> Tracks:
    """Return the messages of some logs on the floor of a model.

    Raises:
        ReportError: kinds of robots that differ, nodes of the log that are none of the model's, axes that do not fit.
    """
    if model.fleet.kinds:
        raise ReportError(
            f"{model.name}: fleet.kinds: a log does not say of which kind a robot is; calibrate each alone"
        )
    parts: dict[str, list[Any]] = {}
    notes: list[str] = []
    robots = 0
    for log in logs:
        if not log.step:
            continue
        columns, remarks = _day(model, log)
        columns["robot"] = columns["robot"] + robots
        robots += len(log.robots)
        notes += remarks
        for name, column in columns.items():
            parts.setdefault(name, []).append(column)
    if not parts:
        raise ReportError("logs of trips alone do not say where robots are, expected one with states")
    steps = [log.step for log in logs if log.step]
    seconds = model.units.seconds
    return Tracks(
        model=model,
        step=float(np.median(steps)) / seconds,
        length=sum(log.length for log in logs if log.step) / seconds,
        days=len(steps),
        notes=tuple(notes),
        **{name: np.concatenate(columns) for name, columns in parts.items()},
    )


def _day(model: Model, log: FleetLog) -> tuple[dict[str, Any], list[str]]:
    """Return the columns of `Tracks` for one log, and remarks on the log."""
    layout, table = model.floor, log.table
    number = {node: rank for rank, node in enumerate(layout.graph)}
    ranks = np.array([number.get(node, -1) for node in log.nodes])
    strange = [node for node in log.nodes if node not in number and node]
    node = ranks[table["node"].to_numpy()]
    if (node < 0).mean() > 0.5:  # noqa: PLR2004 - most of the log
        hint = nearest(strange[0], number) if strange else None
        raise ReportError(
            f"{log.name}: nodes that the model does not have (got {', '.join(map(got, strange[:3]))}), expected "
            f"{spoken(list(number)[:3], 'or')} and the like" + (f"; did you mean '{hint}'?" if hint else "")
        )
    notes = [f"{log.name}: nodes that the model does not have: {', '.join(strange[:_NAMES])}"] if strange else []
    robot = table["robot"].to_numpy().astype(np.int64)
    time = table["time"].to_numpy()
    first = np.diff(robot, prepend=-1) != 0
    joined = ~first & (np.diff(time, prepend=-math.inf) <= GAP * log.step)
    positions, remarks = _aligned(model, log, node, first)
    notes += remarks
    columns = {
        "time": time / model.units.seconds,
        "robot": robot,
        "node": node,
        "driving": table["driving"].to_numpy(),
        "load": table["load"].to_numpy(),
        "action": table["action"].to_numpy().astype(np.int64),
        "charge": table["charge"].to_numpy().astype(float),
        "fault": table["fault"].to_numpy(),
        "joined": joined,
    }
    return {**columns, **_on_edges(model, positions, node, robot, columns["driving"])}, notes


def _aligned(model: Model, log: FleetLog, node: Ints, first: Flags) -> tuple[Any, list[str]]:
    """Transform positions (x + iy) to the layout's axes and units, fitted to arrivals at nodes; with remarks."""
    points = np.array(list(model.floor.points.values()))
    seen = log.table["x"].to_numpy().astype(float) + 1j * log.table["y"].to_numpy()
    came = (np.diff(node, prepend=-1) != 0) & ~first & (node >= 0) & np.isfinite(seen)
    driving = log.table["driving"].to_numpy()
    if driving.any():  # in bays and stations robots stand beside the node
        came &= driving
    if came.sum() < _FEWEST:
        return seen, [f"{log.name}: {came.sum()} arrivals at nodes are too few to find its axes"]
    target, here = points[node[came]], seen[came]
    best: tuple[float, complex, complex, bool] | None = None
    for mirrored in (False, True):
        from_log = here.conj() if mirrored else here
        turn, shift = _similar(from_log, target)
        off = float(np.median(np.abs(turn * from_log + shift - target)))
        if best is None or off < best[0]:
            best = off, turn, shift, mirrored
    assert best is not None
    off, turn, shift, mirrored = best
    extent = max(np.ptp(points.real), np.ptp(points.imag))
    if off > _CLOSE * extent:
        raise ReportError(
            f"{log.name}: positions do not fit the nodes of the model ({off:.3g} {model.units.length} apart), "
            "expected a log of the same floor"
        )
    scale = abs(turn)
    remarks = []
    if abs(scale - 1) > _CLOSE / 2:
        remarks = [f"{log.name}: {scale:.4g} {model.units.length} of the model to a unit of the log"]
    else:  # true to scale: the rest of the fit's scale is chance
        turn /= scale
    from_log = seen.conj() if mirrored else seen
    return turn * from_log + shift, remarks


def _similar(here: Any, target: Any) -> tuple[complex, complex]:
    """Fit the turn (with scale) and shift from points (x + iy) to their targets: least squares on the better half."""
    use = np.ones(len(here), bool)
    turn, shift = 1 + 0j, 0j
    for _ in range(5):
        a, b = here[use].mean(), target[use].mean()
        spread = (np.abs(here[use] - a) ** 2).sum()
        turn = complex(((target[use] - b) * (here[use] - a).conj()).sum() / spread) if spread else 1 + 0j
        shift = complex(b - turn * a)
        off = np.abs(turn * here + shift - target)
        use = off <= np.median(off)
    return turn, shift


def _on_edges(model: Model, positions: Any, node: Ints, robot: Ints, driving: Flags) -> dict[str, Any]:
    """Return columns x, y, onto (next node), edge and along (way from its start) for every message."""
    layout = model.floor
    names, points = list(layout.graph), np.array(list(layout.points.values()))
    turns = np.flatnonzero((np.diff(node) != 0) | (np.diff(robot) != 0))
    ends = np.append(turns, len(node) - 1)
    after = np.append(node[turns + 1], -1)
    after[np.append(robot[turns] != robot[turns + 1], True)] = -1
    onto = after[np.searchsorted(ends, np.arange(len(node)))]
    code = {(names.index(a), names.index(b)): rank for rank, (a, b) in enumerate(layout.graph.edges)}
    pairs, inverse = np.unique(np.stack([node, onto]), axis=1, return_inverse=True)
    edge = np.array([code.get((int(a), int(b)), -1) for a, b in pairs.T])[inverse.ravel()]
    real = np.flatnonzero((edge >= 0) & np.isfinite(positions))
    way = points[onto[real]] - points[node[real]]
    drawn = np.abs(way)
    ahead, start = way / drawn, points[node[real]]
    moving = driving[real]  # standing robots may be in a slot beside the lane
    positions = _squared(positions, positions[real][moving], start[moving], ahead[moving], model.fleet.contact / 2)
    place = (positions[real] - start) * ahead.conj()
    along = np.full(len(node), math.nan)
    along[real] = place.real * np.array([layout.length(pair) for pair in layout.graph.edges])[edge[real]] / drawn
    beside = np.ones(len(node), bool)
    beside[real] = np.abs(place.imag) > model.fleet.contact / 2
    along[beside] = math.nan
    return {"x": positions.real, "y": positions.imag, "onto": onto, "edge": np.where(beside, -1, edge), "along": along}


def _squared(positions: Any, on: Any, start: Any, ahead: Any, far: float) -> Any:
    """Turn and shift all positions a little, so that robots are in the middle of their lanes on average.

    Arrivals at nodes are seen up to a second late, so axes that are found from these alone are slightly off.
    """
    beside = ((on - start) * ahead.conj()).imag
    near = np.abs(beside) < far
    if near.sum() < _FEWEST:
        return positions
    middle = on[near].mean()
    across = 1j * ahead[near]
    columns = [1j * (on[near] - middle), np.ones(int(near.sum())), np.full(int(near.sum()), 1j)]
    matrix = np.stack([(column * across.conj()).real for column in columns], axis=1)
    turn, x, y = np.linalg.lstsq(matrix, -beside[near], rcond=None)[0]
    return (positions - middle) * np.exp(1j * turn) + middle + complex(x, y)
