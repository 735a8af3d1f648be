"""The data of a replay page: a header of plain JSON values, and columns of integers.

Lengths are in units of `grain`, and times in units of `tick` from the start of the window. Both are so small that a
robot is drawn within a small fraction of its radius from its logged position.

The data include the roots of waits with their total and longest waits. For each pod they include its place or carrier,
its content, and the lines for which it travels.
"""

from __future__ import annotations

import datetime as dt
import heapq
import itertools
from collections import defaultdict
from typing import Any

import numpy as np

from desim_warehouse.answer import numbers
from desim_warehouse.answer.numbers import plural
from desim_warehouse.answer.root_words import root as in_words
from desim_warehouse.layout import Layout
from desim_warehouse.model import Model
from desim_warehouse.model.facts.places import destinations
from desim_warehouse.outcome import chains
from desim_warehouse.outcome.chains import Lost, Root
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.positions import Legs, Positions
from desim_warehouse.outcome.resources import Resource, one_of, resources
from desim_warehouse.outcome.zones import cell_size, robot_radii
from desim_warehouse.replay.columns import LARGEST
from desim_warehouse.replay.people import picker_columns
from desim_warehouse.replay.scale import MapScale, scale_of
from desim_warehouse.replay.stops import stops
from desim_warehouse.replay.tiles import Tile, figures, tile_columns, tiles
from desim_warehouse.states import APART, SHOWN, WAITING, Phase, State
from desim_warehouse.values.arrays import Floats, Ints
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.orders.pods import Shelves

_ROOTS = 60
"""Largest number of roots in the list."""
_LEAST = 0.001
"""Least share of the fleet's time for a root to be listed."""
_LONGEST = 12
"""Largest number of waits that are listed for each root, the longest first."""
ENDLESS = -1
"""Number of units of an item that never runs out."""
ENERGY = 1000
"""Number of steps in a full battery."""
_DRIVING = (Phase.TO_GOOD, Phase.TO_STATION, Phase.TO_BAY)
SAME, OTHER, ONWARD = 0, 1, 2
"""Edge codes of a leg: the previous leg's edge, an edge in another column, or (2 + n) the n-th edge from its end."""
Columns = dict[str, Any]


def lost_to(history: History, scale: MapScale) -> list[dict[str, Any]]:
    """List the main roots of waits, the most time first.

    Each has its words, the number of its node (-1 for none), the time with its share, the number of robots, and the
    longest waits, each as robot, middle and length in the time of the run.
    """
    by_root: defaultdict[Root, list[Lost]] = defaultdict(list)
    for wait in chains.lost(history):
        by_root[wait.root].append(wait)
    number = {node: i for i, node in enumerate(history.layout.graph.nodes)}
    until = min(scale.end, history.end)
    unit, whole = history.model.units.time, (until - history.begin) * history.model.fleet.size
    return [
        {
            "words": in_words(root, history.model),
            "node": number.get(root.at, -1),
            "time": f"{numbers.duration(time, unit)}, {numbers.PERCENT.value(time / whole)}",
            "robots": robots,
            "longest": [
                [wait.robot, (wait.start + wait.end) / 2, wait.end - wait.start]
                for wait in heapq.nlargest(_LONGEST, by_root[root], key=lambda wait: wait.end - wait.start)
                if scale.start <= (wait.start + wait.end) / 2 <= scale.end
            ],
        }
        for root, (time, robots) in list(chains.lost_to(history, until).items())[:_ROOTS]
        if time >= _LEAST * whole
    ]


def pod_columns(history: History, scale: MapScale) -> dict[str, Any]:
    """Return the columns of pods; empty without pods.

    The position of a pod is the number of its storage place, or -1 - n on robot n. `pod_at`: position of each pod at
    the start of the window. `move_...`: time, pod and new position of each lift or put-down, in order of time.
    `hold_...`: for each pod, the items on it at the start of the run, and their units. `line_...`: the lines done, in
    order of the times from which robots were on their way for them; `line_units` is the number of units that leave.
    """
    spec = history.model.pods
    if spec is None:
        return {}
    shelves = Shelves(spec, history.layout.storage, Streams(history.seed), keep=False)
    places = [pod.place for pod in shelves.pods]
    moves = []
    for row in history.rows("lifted", "stored"):
        pod, where = int(row.value or 0), row.other if row.kind == "stored" else -1 - row.robot
        if row.time < scale.start:
            places[pod] = where
        elif row.time <= scale.end:
            moves.append((row.time, pod, where))
    node = {name: number for number, name in enumerate(history.layout.graph)}
    assigned = {work.task: work.start for work in history.assignments if work.ended == "delivered"}
    lines = sorted((assigned[row.task], row) for row in history.rows("delivered"))
    item = {row.task: row.other for row in history.rows("released")}
    puts = {name for name, flow in history.model.tasks.flows.items() if not isinstance(flow.target, tuple)}
    units = [-spec.bundle if history.log.flows[row.task] in puts else 1 for _, row in lines]
    begin, done = scale.times([time for time, _ in lines]), scale.times([row.time for _, row in lines])
    held = [(item, units) for pod in shelves.pods for item, units in sorted(pod.stock.items())]
    return {
        "pod_at": places,
        "move_time": np.diff(scale.times([time for time, _, _ in moves]), prepend=0),
        "move_pod": [pod for _, pod, _ in moves],
        "move_to": [where for _, _, where in moves],
        "hold_count": [len(pod.stock) for pod in shelves.pods],
        "hold_item": [item for item, _ in held],
        "hold_units": [ENDLESS if spec.stock is None else int(units) for _, units in held],
        "line_time": np.diff(begin, prepend=0),
        "line_length": done - begin,
        "line_pod": [row.other for _, row in lines],
        "line_task": [row.task for _, row in lines],
        "line_item": [item[row.task] for _, row in lines],
        "line_node": [node[row.node] for _, row in lines],
        "line_units": units,
    }


def payload(history: History, start: float, end: float) -> tuple[dict[str, Any], Columns]:
    """Return the header and the columns of the page for a window of a run."""
    positions = Positions(history)
    scale = scale_of(history, start, end)
    shown, places = tiles(history), resources(history)
    columns = {
        **_leg_columns(positions, scale),
        **_state_columns(history, scale),
        **_energy_columns(history, scale),
        **_task_columns(history, scale),
        **_wait_columns(history, scale),
        **_blocked_columns(history, scale),
        **_delivery_columns(history, scale),
        **tile_columns(shown, scale),
        **_resource_columns(places, scale),
        **_storage_columns(history, scale),
        **pod_columns(history, scale),
        **picker_columns(history, scale),
    }
    return _header(history, positions, shown, places, scale), columns


# A long list of the data of the page.
def _header(
    history: History, positions: Positions, shown: list[Tile], places: list[Resource], scale: MapScale
) -> dict[str, Any]:
    model, layout, edges = history.model, history.layout, positions.edges
    nodes = list(layout.graph.nodes)
    number = {node: i for i, node in enumerate(nodes)}
    blocks, at_end = model.layout.blocks, figures(history, shown, scale)
    return {
        "name": model.name,
        "seed": history.seed,
        "day": _seconds_of_day(model.run.start),
        "units": {
            "length": model.units.length,
            "time": model.units.time,
            "times": plural(model.units.time, 0),
            "seconds": model.units.seconds,
        },
        "grain": scale.grain,
        "tick": scale.tick,
        "start": scale.start,
        "end": scale.end,
        "begin": history.begin,
        "capacity": None if model.battery is None else model.battery.capacity,
        "radii": robot_radii(model),
        "aisle": 0.0 if blocks is None else blocks.aisle_width,
        "goods_size": layout.goods_size,
        "cell": cell_size(model, layout),
        "nodes": [[node, data["x"], data["y"]] for node, data in layout.graph.nodes(data=True)],
        "source": [number[node] for node in edges.source],
        "target": [number[node] for node in edges.target],
        "length": edges.length.tolist(),
        "real": edges.real,
        "two_way": [[edge, back] for edge, back in enumerate(edges.twin.tolist()) if edge < back],
        "places": edges.start[edges.real :].tolist(),
        "zones": [[zone.kind, zone.name, number[zone.node], len(zone.places), zone.room] for zone in positions.zones],
        "resources": [
            [place.kind, place.zone, number[place.node], place.number, one_of(model, place)] for place in places
        ],
        "stops": stops(history, places, scale, at_end),
        "at_end": at_end,
        "lost": lost_to(history, scale),
        "fastest": model.fleet.fastest,
        "tiles": [[tile.key, tile.title, tile.form, tile.is_drawn] for tile in shown],
        **({"called": {str(number): name for number, name in layout.called.items()}} if layout.called else {}),
        **({"items": list(model.pods.names)} if model.pods is not None and model.pods.names else {}),
        **_lifts(layout, number),
        "unload_at": sorted(number[node] for node in destinations(model, layout)),
        "states": [
            {"name": state.name, "doing": state.doing, "role": state.role, "drives": state.phase in _DRIVING}
            for state in _shown(model)
        ],
        "apart": [state.doing for state in APART.values()],
        "rings": [
            [ring.time, list(ring.robots)] for ring in history.rotations if scale.start <= ring.time <= scale.end
        ],
    }


def _lifts(layout: Layout, number: dict[str, int]) -> dict[str, Any]:
    """Return lifts with their nodes, the floor of each node, and the titles of floors; empty without lifts."""
    if not layout.lifts:
        return {}
    floors = [layout.floors[node] for node in number]
    return {
        "lifts": [[lift.name, [number[node] for node in lift.nodes]] for lift in layout.lifts],
        "floors": floors,
        "floor_titles": list(layout.floor_titles.values()),
    }


def _resource_columns(resources: list[Resource], scale: MapScale) -> dict[str, Any]:
    """Return the number of busy servers or chargers, and of robots that queue, over time for each resource."""
    columns: dict[str, Any] = {}
    busy, queues = [resource.busy for resource in resources], [resource.queue for resource in resources]
    for what, curves in (("busy", busy), ("queue", queues)):
        kept = [[(time, count) for time, count in zip(*curve, strict=True) if time <= scale.end] for curve in curves]
        flat = [item for curve in kept for item in curve]
        columns[f"{what}_count"] = [len(curve) for curve in kept]
        columns[f"{what}_time"] = np.diff(scale.times([time for time, _ in flat]), prepend=0)
        columns[f"{what}_now"] = np.diff(np.array([count for _, count in flat], dtype=np.int64), prepend=0)
    return columns


def _window(times: Floats, first: Ints, scale: MapScale) -> list[tuple[int, int]]:
    """Return the range of rows of each robot, from the last row before the window to the first row after it."""
    rows = []
    for low, high in itertools.pairwise(first):
        begin = low + max(int(np.searchsorted(times[low:high], scale.start, side="right")) - 1, 0)
        end = low + min(int(np.searchsorted(times[low:high], scale.end, side="right")) + 1, high - low)
        rows.append((int(begin), int(end)))
    return rows


def _leg_columns(positions: Positions, scale: MapScale) -> Columns:
    """Return the columns of legs: the pause before each leg, its duration, its edge, and the rest of the edge beyond.

    A leg with the code SAME begins where the previous leg ended, any other leg at the start of its edge. `leg_origin`
    is the position at which the first leg of each robot begins.
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


def _edge_codes(positions: Positions, legs: Legs, keep: Ints, heads: Ints) -> tuple[list[int], list[int]]:
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


def _state_columns(history: History, scale: MapScale) -> Columns:
    """Return the changes of state of each robot, with the task; the last state is repeated at the end of the run."""
    number = {state.doing: number for number, state in enumerate(_shown(history.model))}
    rows = []
    for changes in history.changes:
        rows += [(span.start, number[span.seen.doing], span.task) for span in changes]
        last = changes[-1]
        rows.append((last.end, rows[-1][1], last.task))
    counts, (time, state, task) = _in_window(rows, [len(changes) + 1 for changes in history.changes], scale)
    return {
        "state_count": counts,
        "state_time": _steps(scale.times(time)),
        "state": state.astype(np.int64),
        "state_task": _steps(task.astype(np.int64)),
    }


def _energy_columns(history: History, scale: MapScale) -> Columns:
    """Return the corners of the piecewise linear battery level of each robot; empty without batteries."""
    batteries, curves = history.batteries, history.energy_curves
    if not batteries:
        return {}
    rows = [
        (time, level / battery.capacity)
        for battery, curve in zip(batteries, curves, strict=True)
        for time, level in zip(*curve, strict=True)
    ]
    counts, (time, level) = _in_window(rows, [len(times) for times, _ in curves], scale)
    return {
        "energy_count": counts,
        "energy_time": _steps(scale.times(time)),
        "energy": _steps(np.rint(level * ENERGY).astype(np.int64)),
    }


def _in_window(rows: list[Any], sizes: list[int], scale: MapScale) -> tuple[list[int], Floats]:
    """Cut rows (time, ...), grouped by robot, to the window; return the number of rows by robot, and the columns.

    `sizes`: number of rows by robot. The columns have shape (columns, rows).
    """
    flat = np.array(rows, dtype=float)
    windows = _window(flat[:, 0], np.concatenate([[0], np.cumsum(sizes)]), scale)
    keep = np.concatenate([np.arange(low, high) for low, high in windows])
    return [high - low for low, high in windows], flat[keep].T


def _shown(model: Model) -> list[State]:
    """Return the states as the page shows them, with a state of its own for waiting for a charger."""
    return [state for state in SHOWN.values() if state.applies(model)]


def _task_columns(history: History, scale: MapScale) -> Columns:
    """Return the columns of tasks that are open at some time of the window.

    `task_good`: number of the good; -1 if it is not in storage. `task_loaded`: after the window if never loaded.
    `task_due`: 1 plus the ticks from release to due time; 0 without a due time. `task_to`: number of the node of
    delivery; -1 if not delivered in this run.
    """
    shown = [
        (number, task)
        for number, task in sorted(history.tasks.items())
        if task.released <= scale.end and task.delivered > scale.start
    ]
    node = {name: i for i, name in enumerate(history.layout.graph.nodes)}
    after = scale.end + (scale.end - scale.start) + 1.0
    loaded = [min(task.loaded, after) for _, task in shown]
    longest = scale.tick * (LARGEST // 2)  # later due times are clipped to fit, and are still after the end of any run
    due = [-scale.tick if task.due is None else min(task.due - task.released, longest) for _, task in shown]
    return {
        "task": _steps(np.array([number for number, _ in shown], dtype=np.int64)),
        "task_good": [task.good for _, task in shown],
        "task_released": _steps(scale.times([task.released for _, task in shown])),
        "task_loaded": _steps(scale.times(loaded)),
        "task_due": np.rint(np.array(due) / scale.tick).astype(np.int64) + 1,
        "task_to": [node.get(task.station, -1) for _, task in shown],
    }


def _wait_columns(history: History, scale: MapScale) -> Columns:
    """Return the waits that overlap the window, in order of their ends.

    `wait_node`: number of the node before which a robot waits; -1 if it waits behind another robot on its edge.
    """
    number = {edge: i for i, edge in enumerate(history.layout.graph.edges)}
    node = {name: i for i, name in enumerate(history.layout.graph.nodes)}
    shown = [wait for wait in history.waits if wait.end >= scale.start and wait.start <= scale.end]
    end, begin = scale.times([wait.end for wait in shown]), scale.times([wait.start for wait in shown])
    return {
        "wait_time": _steps(end),
        "wait_length": end - begin,
        "wait_robot": [wait.robot for wait in shown],
        "wait_other": [wait.other for wait in shown],
        "wait_edge": [-1 if wait.on is None else number[wait.on] for wait in shown],
        "wait_node": [-1 if wait.node is None else node[wait.node] for wait in shown],
    }


def _blocked_columns(history: History, scale: MapScale) -> Columns:
    """Return the edges that are closed or have people in them in the window; empty for models without such waits.

    `shut_visit`: number of the visit; -1 if closed by calendar. `wait_cause`: the cause of each wait: 0 for other
    robots, or else its index in `apart` of the header, from 1.
    """
    if not history.model.waits_apart:
        return {}
    number = {edge: i for i, edge in enumerate(history.layout.graph.edges)}
    shown = [closure for closure in history.blocked if closure.end >= scale.start and closure.start <= scale.end]
    begin = scale.times([closure.start for closure in shown])
    causes = [WAITING.name, *APART]
    waits = [wait for wait in history.waits if wait.end >= scale.start and wait.start <= scale.end]
    return {
        "shut_edge": [number[closure.edge] for closure in shown],
        "shut_time": _steps(begin),
        "shut_length": scale.times([closure.end for closure in shown]) - begin,
        "shut_visit": [closure.visit for closure in shown],
        "wait_cause": [causes.index(wait.cause) for wait in waits],
    }


def _delivery_columns(history: History, scale: MapScale) -> Columns:
    """Return the deliveries of the evaluation period up to the end of the window, with their nodes."""
    number = {node: i for i, node in enumerate(history.layout.graph.nodes)}
    done = [task for task in history.counted_deliveries if task.delivered <= scale.end]
    return {
        "done_time": _steps(scale.times([task.delivered for task in done])),
        "done_node": [number[task.station] for task in done],
    }


def _storage_columns(history: History, scale: MapScale) -> Columns:
    """Return the storage places: their middles, and the edges from which they are served (-1 - i for node i)."""
    number = {edge: i for i, edge in enumerate(history.layout.graph.edges)}
    number.update({(node, node): -1 - i for i, node in enumerate(history.layout.graph)})
    storage = history.layout.storage
    return {
        "storage_x": _steps(scale.lengths([place.x for place in storage])),
        "storage_y": _steps(scale.lengths([place.y for place in storage])),
        "storage_edge": _steps(np.array([number[place.edge] for place in storage], dtype=np.int64)),
    }


def _steps(values: Ints) -> Ints:
    """Return the differences between consecutive values, beginning with the first value itself."""
    return np.diff(values, prepend=0)


def _seconds_of_day(start: str) -> int:
    """Return the time of day at which a run starts, in seconds."""
    clock = dt.time.fromisoformat(start.rpartition("T")[2])
    return clock.hour * 3600 + clock.minute * 60 + clock.second
