"""What a replay page is given: a header of plain JSON values and columns of whole numbers.

Lengths are counted in steps of `grain` and times in steps of `tick` from the start of the window, both fine
enough to draw a robot within a small fraction of its radius of where the log has it.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.model.destinations import destinations
from desim_warehouse.report.positions import Legs, Positions
from desim_warehouse.report.replay.columns import LARGEST
from desim_warehouse.report.zones import robot_radii
from desim_warehouse.states import FOR_CHARGER, STATES, seen

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from desim_warehouse.history import History, StateSpan
    from desim_warehouse.run import Run

FINENESS = 100
"""Grains in the radius of the smallest robot."""
ENERGY = 1000
"""Steps in a full battery."""
SAME, OTHER, ONWARD = 0, 1, 2
"""Edge codes of a leg: the same edge; any edge, named in a column of its own; or the n-th out of the last one's end."""
SHOWN = [*(seen(name, task=0) for name in STATES), FOR_CHARGER]
"""States as the page shows them: a robot that waits for a charger is apart, as it is not working."""
_NUMBERS = {state.doing: number for number, state in enumerate(SHOWN)}

Columns = dict[str, Any]


@dataclass(frozen=True)
class Scale:
    """Steps of length and time, and the window of the run in its own time."""

    grain: float
    tick: float
    start: float
    end: float

    def times(self, values: Any) -> NDArray[np.int64]:
        """Times in ticks since the start of the window."""
        return np.rint((np.asarray(values, dtype=float) - self.start) / self.tick).astype(np.int64)

    def lengths(self, values: Any) -> NDArray[np.int64]:
        """Lengths in grains."""
        return np.rint(np.asarray(values, dtype=float) / self.grain).astype(np.int64)


def scale_of(run: Run, start: float, end: float) -> Scale:
    """Steps fit for a run: a hundredth of the smallest robot, and the time in which the fastest drives that far."""
    fleet = run.model.fleet
    grain = min(robot_radii(run.model)) / FINENESS
    fastest = max([fleet.robot.speed, *(kind.speed or 0.0 for kind in fleet.kinds.values())])
    longest = max(end - start, run.record.end)
    return Scale(grain, max(grain / fastest, 4 * longest / LARGEST), start, end)


def payload(run: Run, start: float, end: float) -> tuple[dict[str, Any], Columns]:
    """Header and columns of the page for a window of a run."""
    positions = Positions(run)
    scale = scale_of(run, start, end)
    history = run.history
    columns = {
        **_leg_columns(positions, scale),
        **_state_columns(history, scale),
        **_task_columns(history, scale),
        **_wait_columns(run, scale),
        **_count_columns(run, scale),
        **_storage_columns(run, scale),
    }
    return _header(run, positions, scale), columns


def _header(run: Run, positions: Positions, scale: Scale) -> dict[str, Any]:
    model, layout, edges, history = run.model, run.layout, positions.edges, run.history
    nodes = list(layout.graph.nodes)
    number = {node: i for i, node in enumerate(nodes)}
    blocks = model.layout.blocks
    return {
        "name": model.name,
        "description": model.description,
        "seed": run.seed,
        "units": {"length": model.units.length, "time": model.units.time, "seconds": model.units.seconds},
        "grain": scale.grain,
        "tick": scale.tick,
        "start": scale.start,
        "end": scale.end,
        "begin": history.begin,
        "finish": history.end,
        "capacity": None if model.battery is None else model.battery.capacity,
        "radii": robot_radii(model),
        "aisle": 0.0 if blocks is None else blocks.aisle_width,
        "goods_size": layout.goods_size,
        "nodes": [[node, data["x"], data["y"]] for node, data in layout.graph.nodes(data=True)],
        "source": [number[node] for node in edges.source],
        "target": [number[node] for node in edges.target],
        "length": edges.length.tolist(),
        "real": edges.real,
        "two_way": [[edge, back] for edge, back in enumerate(edges.twin.tolist()) if edge < back],
        "places": edges.start[edges.real :].tolist(),
        "zones": [[zone.kind, zone.name, number[zone.node], len(zone.places)] for zone in positions.zones],
        "unload_at": sorted(number[node] for node in destinations(model, layout)),
        "states": [{"name": state.name, "doing": state.doing, "role": state.role} for state in SHOWN],
        "rings": [
            [ring.time, list(ring.robots)] for ring in history.rotations if scale.start <= ring.time <= scale.end
        ],
        "before": {
            "S": sum(history.begin <= wait.end < scale.start for wait in history.waits),
            "C": sum(history.begin <= time < scale.start for time in history.recharges),
        },
    }


def _window(times: NDArray[np.float64], first: NDArray[np.int64], scale: Scale) -> list[tuple[int, int]]:
    """Per robot, the rows from the last before the window to the first after it."""
    rows = []
    for low, high in itertools.pairwise(first):
        begin = low + max(int(np.searchsorted(times[low:high], scale.start, side="right")) - 1, 0)
        end = low + min(int(np.searchsorted(times[low:high], scale.end, side="right")) + 1, high - low)
        rows.append((int(begin), int(end)))
    return rows


def _leg_columns(positions: Positions, scale: Scale) -> Columns:
    """Per leg: the pause before it, its duration, its edge, and what is left of the edge behind its target.

    A leg begins where the one before ended if it is on the same edge (code SAME), else at the edge's start;
    the first leg of a robot says where it begins.
    """
    legs = positions.legs
    windows = _window(legs.begin, legs.first, scale)
    keep = np.concatenate([np.arange(low, high) for low, high in windows])
    count = np.array([high - low for low, high in windows])
    heads = np.cumsum(count) - count
    begin, end = scale.times(legs.begin[keep]), scale.times(legs.end[keep])
    pause = begin.copy()
    pause[1:] -= end[:-1]
    pause[heads] = begin[heads]
    code, other = _edge_codes(positions, legs, keep, heads)
    lengths = scale.lengths(positions.edges.length)
    edge = legs.edge[keep]
    return {
        "leg_count": count,
        "leg_pause": pause,
        "leg_time": end - begin,
        "leg_code": code,
        "leg_other": other,
        "leg_left": lengths[edge] - scale.lengths(legs.target[keep]),
        "leg_origin": scale.lengths(legs.origin[keep][heads]),
    }


def _edge_codes(
    positions: Positions, legs: Legs, keep: NDArray[np.int64], heads: NDArray[np.int64]
) -> tuple[list[int], list[int]]:
    edges = positions.edges
    out: dict[str, list[int]] = {}
    for number in range(edges.real):
        out.setdefault(edges.source[number], []).append(number)
    rank = [out[edges.source[number]].index(number) for number in range(edges.real)]
    first = set(heads.tolist())
    codes, others, last = [], [], -1
    for i, leg in enumerate(keep.tolist()):
        edge, origin = int(legs.edge[leg]), legs.origin[leg]
        if i in first:
            code = OTHER
        elif edge == last and (origin > 0 or legs.target[leg - 1] == 0):
            code = SAME
        elif edge < edges.real and edges.source[edge] == edges.target[last]:
            code = ONWARD + rank[edge]
        else:
            code = OTHER
        if code == OTHER:
            others.append(edge)
        codes.append(code)
        last = edge
    return codes, others


def _state_columns(history: History, scale: Scale) -> Columns:
    """Per robot, what it begins to do, with its task and energy there; and once more at the end of the run."""
    battery = history.model.battery
    capacity = 1.0 if battery is None else battery.capacity
    ends = history.energy_at_end or [0.0] * len(history.changes)
    rows = []
    for changes, left in zip(history.changes, ends, strict=True):
        rows += [(span.start, _number(span), span.task, span.energy or 0.0) for span in changes]
        last = changes[-1]
        rows.append((last.end, _number(last), last.task, left))
    flat = np.array(rows, dtype=float)
    sizes = [len(changes) + 1 for changes in history.changes]
    first = np.concatenate([[0], np.cumsum(sizes)])
    windows = _window(flat[:, 0], first, scale)
    keep = np.concatenate([np.arange(low, high) for low, high in windows])
    time, state, task, energy = flat[keep].T
    return {
        "state_count": [high - low for low, high in windows],
        "state_time": _steps(scale.times(time)),
        "state": state.astype(np.int64),
        "state_task": _steps(task.astype(np.int64)),
        "state_energy": _steps(np.rint(energy / capacity * ENERGY).astype(np.int64)),
    }


def _number(span: StateSpan) -> int:
    return _NUMBERS[seen(span.state, span.task).doing]


def _task_columns(history: History, scale: Scale) -> Columns:
    """Tasks whose good is there at some time of the window; those never loaded are, until the end and longer."""
    shown = [
        (number, task)
        for number, task in sorted(history.tasks.items())
        if task.released <= scale.end and task.delivered > scale.start and task.good >= 0
    ]
    after = scale.end + (scale.end - scale.start) + 1.0
    loaded = [min(task.loaded, after) for _, task in shown]
    return {
        "task": _steps(np.array([number for number, _ in shown], dtype=np.int64)),
        "task_good": [task.good for _, task in shown],
        "task_released": _steps(scale.times([task.released for _, task in shown])),
        "task_loaded": _steps(scale.times(loaded)),
    }


def _wait_columns(run: Run, scale: Scale) -> Columns:
    """Waits that are counted or under way in the window, in the order in which they end and are counted."""
    number = {edge: i for i, edge in enumerate(run.layout.graph.edges)}
    shown = [wait for wait in run.history.waits if wait.end >= scale.start and wait.start <= scale.end]
    end, begin = scale.times([wait.end for wait in shown]), scale.times([wait.start for wait in shown])
    return {
        "wait_time": _steps(end),
        "wait_begin": end - begin,
        "wait_length": end - begin,
        "wait_robot": [wait.robot for wait in shown],
        "wait_other": [wait.other for wait in shown],
        "wait_edge": [-1 if wait.on is None else number[wait.on] for wait in shown],
    }


def _count_columns(run: Run, scale: Scale) -> Columns:
    """Deliveries, also those before the window, and the times at which recharged robots went out in it."""
    number = {node: i for i, node in enumerate(run.layout.graph.nodes)}
    done = [task for task in run.history.delivered if task.delivered <= scale.end]
    out = [time for time in run.history.recharges if scale.start <= time <= scale.end]
    return {
        "done_time": _steps(scale.times([task.delivered for task in done])),
        "done_node": [number[task.station] for task in done],
        "recharged": _steps(scale.times(out)),
    }


def _storage_columns(run: Run, scale: Scale) -> Columns:
    """The storage places: their middle, and the edge from which they are served; -1 - i is the node of number i."""
    number = {edge: i for i, edge in enumerate(run.layout.graph.edges)}
    number.update({(node, node): -1 - i for i, node in enumerate(run.layout.graph)})
    storage = run.layout.storage
    return {
        "storage_x": _steps(scale.lengths([place.x for place in storage])),
        "storage_y": _steps(scale.lengths([place.y for place in storage])),
        "storage_edge": _steps(np.array([number[place.edge] for place in storage], dtype=np.int64)),
    }


def _steps(values: NDArray[np.int64]) -> NDArray[np.int64]:
    """The differences between neighbours, the first from 0."""
    return np.diff(values, prepend=0)
