"""How the cost of a part of a run grows with its size: `make bench-long`, or `python -m benchmarks.growth [PART ...]`.

Each part is measured at sizes that double: processor time per move, decision, node, place or row of the log, whichever
the part is about. The exponent is the slope of a straight line through the logarithms: 0 says that a unit costs the
same at every size, 1 that it costs twice as much at twice the size. Log n grows like an exponent of 0.1 to 0.2 between
these sizes, and caches that no longer hold everything add as much, so no part may exceed `BOUND`
(`tests/world/test_growth.py`).
"""

from __future__ import annotations

import gc
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

import desim_warehouse as dw
from benchmarks import up_to
from desim_warehouse.feasibility import errors
from desim_warehouse.feasibility.needs import _least_needs
from desim_warehouse.layout import build
from desim_warehouse.layout.travel import travel_on
from desim_warehouse.plot.floor import save
from desim_warehouse.questions.check import check
from desim_warehouse.run.probe import _calm, _probe
from desim_warehouse.world import World

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

ROUNDS = 2
WARM_UP = 300.0


def warehouse(side: int, robots: int, changes: dict[str, Any] | None = None) -> dw.Model:
    """A square floor of blocks with bays along one side, stations along the other, batteries, and work without end."""
    return dw.load(
        {
            "name": f"{side} x {side}",
            "layout": {
                "blocks": {"columns": side, "rows": side, "block_depth": 4, "goods_size": 1.0, "aisle_width": 1.4},
                "bays": {"parking": {"along": "north", "places": max(4 * robots // side, 4)}},
                "stations": {"packing": {"along": "south", "every": 3, "places": max(robots, 20), "servers": 20}},
            },
            "fleet": {"size": robots, "robot": {"radius": 0.35, "speed": 1.5, "margin": 0.1}},
            "tasks": {
                "goods": {"saturated": robots},
                "unload_at": ["packing"],
                "station_choice": "least-loaded",
                "load_time": 6,
                "unload_time": 12,
            },
            "battery": {"capacity": 100, "threshold": 25, "consumption": 0.003, "charge_rate": 0.02},
            "traffic": {"node_time": 0.5},
            "policies": {"routing": "shortest", "allocation": "nearest", "parking": "nearest"},
            "run": {"length": 100_000, "warm_up": 0},
            "log": "tasks",
        },
        changes or {},
    )


def spent(action: Callable[[], Any]) -> float:
    """Processor time, without the collection of cycles."""
    gc.collect()
    gc.disable()
    try:
        begin = time.process_time()
        action()
        return time.process_time() - begin
    finally:
        gc.enable()


def running(model: dw.Model, length: float, units: Callable[[World], int]) -> float:
    """Seconds per unit while a run goes on, once the routes that it takes have been searched for."""
    costs = []
    for _ in range(ROUNDS):
        world = World(model)
        world.begin()
        up_to(world.env, WARM_UP)
        before = units(world)
        taken = spent(lambda: up_to(world.env, WARM_UP + length))  # noqa: B023 - called at once
        costs.append(taken / (units(world) - before))
    return min(costs)


def moves(world: World) -> int:
    return sum(robot.body.moves for robot in world.robots)


def decisions(world: World) -> int:
    """Tasks given to robots."""
    return world.dispatcher.released - len(world.dispatcher.open)


# Parts


def robots_at_work(size: int) -> float:
    """At equal density; tasks, stations and bays grow with the fleet."""
    return running(warehouse(round(math.sqrt(12 * size)), size), max(30_000 / size, 300), moves)


def robots_at_rest(size: int) -> float:
    """A fleet for which ten robots would be enough."""
    return running(warehouse(20, size, {"tasks.goods": {"poisson": 400}}), 1500, decisions)


def open_tasks(size: int) -> float:
    return running(warehouse(20, 20, {"tasks.goods": {"saturated": size}}), 1200, decisions)


def open_tasks_and_hours(size: int) -> float:
    """The same for stations that are open for half of every ten minutes."""
    half = {"every": 600, "lasts": 300}
    changes = {"tasks.goods": {"saturated": size}, "calendars": {"half": half}, "layout.stations.packing.hours": "half"}
    return running(warehouse(20, 20, changes), 1200, decisions)


def open_tours(size: int) -> float:
    """With a stop on the way."""
    flow = {"from": "storage", "to": "storage", "via": ["r20c10"], "arrivals": {"saturated": size}}
    return running(_flows(20, 20, flow), 1200, decisions)


def batches(size: int) -> float:
    """Tasks that robots do two at a time."""
    flow = {"from": "storage", "to": "packing", "arrivals": {"saturated": size}}
    changes = {"policies.batching": {"name": "fixed-size", "size": 2}, "fleet.robot.capacity": 2}
    return running(_flows(20, 20, flow, changes), 1200, decisions)


def _flows(side: int, robots: int, flow: dict[str, Any], changes: dict[str, Any] | None = None) -> dw.Model:
    return warehouse(
        side, robots, {"tasks": {"flows": {"work": flow}, "load_time": 6, "unload_time": 12}, **(changes or {})}
    )


def stations(size: int) -> float:
    """Stations all over a floor of 1,681 nodes; a task goes to the one that the fewest robots are heading for."""
    return running(_with("stations", size, {"policies.allocation": "in-order"}), 1200, decisions)


def bays(size: int) -> float:
    """Bays all over a floor of 1,681 nodes; a robot rests after nearly every task."""
    return running(_with("bays", size, {"tasks.goods": {"poisson": 400}}), 3000, decisions)


def _with(what: str, size: int, changes: dict[str, Any]) -> dw.Model:
    """Twenty robots on a floor with a number of stations or bays, as far apart as possible."""
    at = [f"r{rank // 41}c{rank % 41}" for rank in range(0, 1681, 1681 // size)][:size]
    name = {"stations": "packing", "bays": "parking"}[what]
    return warehouse(40, 20, {f"layout.{what}.{name}": {"at": at, "places": 2}, **changes})


def nodes(size: int) -> float:
    """Building and checking the floor; places as many as blocks have."""
    return _checked(warehouse(round(math.sqrt(size)), 20, {"layout.blocks.block_depth": 1})) / size


def nodes_by_hops(size: int) -> float:
    """The same with the default routing."""
    changes = {"layout.blocks.block_depth": 1, "policies.routing": "highways"}
    return _checked(warehouse(round(math.sqrt(size)), 20, changes)) / size


def drawn(size: int) -> float:
    """Drawing the floor as `desim draw` does."""
    model = warehouse(round(math.sqrt(size)), 20)
    with TemporaryDirectory() as folder:
        return spent(lambda: save(model, Path(folder) / "floor.svg")) / size


def places(size: int) -> float:
    """Building and checking a floor of 400 blocks."""
    return _checked(warehouse(20, 20, {"layout.blocks.block_depth": size // 800})) / size


def _checked(model: dw.Model) -> float:
    """Seconds that a check and building the World take, nothing kept from before."""
    times = []
    for _ in range(ROUNDS):
        for kept in (build, travel_on, _least_needs, errors, _probe, _calm):
            kept.cache_clear()
        times.append(spent(lambda: (check(model), World(model))))
    return min(times)


def log_rows(size: int) -> float:
    """A run to its end, with all rows, its history and its indicators."""
    model = warehouse(10, 20, {"log": "all", "run.length": size / 25})
    costs = []
    for seed in range(ROUNDS):
        runs: list[dw.Run] = []
        taken = spent(lambda: runs.append(dw.simulate(model, seed)))  # noqa: B023 - called at once
        costs.append(taken / len(runs[0].record.rows))
    return min(costs)


@dataclass(frozen=True)
class GrowingPart:
    """A part of a run: what is counted, the sizes, and the seconds that one takes at a size.

    `bound`: of the exponent of these.
    """

    unit: str
    sizes: tuple[int, ...]
    measure: Callable[[int], float]
    bound: float = 0.35


PARTS = {
    "robots at work": GrowingPart("move", (50, 100, 200, 400, 800), robots_at_work, bound=0.5),
    "robots at rest": GrowingPart("decision", (50, 100, 200, 400, 800), robots_at_rest, bound=0.7),
    "open tasks": GrowingPart("decision", (250, 500, 1000, 2000, 4000), open_tasks),
    "open tasks, hours": GrowingPart("decision", (250, 500, 1000, 2000), open_tasks_and_hours, bound=0.85),
    "open tours": GrowingPart("decision", (250, 500, 1000, 2000, 4000), open_tours),
    "batches": GrowingPart("decision", (250, 500, 1000, 2000, 4000), batches),
    "stations": GrowingPart("decision", (25, 50, 100, 200, 400), stations),
    "bays": GrowingPart("decision", (25, 50, 100, 200, 400), bays),
    "nodes": GrowingPart("node", (1250, 2500, 5000, 10_000), nodes),
    "nodes, routed by hops": GrowingPart("node", (1250, 2500, 5000, 10_000), nodes_by_hops, bound=0.5),
    "nodes, drawn": GrowingPart("node", (1250, 2500, 5000, 10_000), drawn),
    "storage places": GrowingPart("place", (4000, 8000, 16_000, 32_000), places),
    "log rows": GrowingPart("row", (10_000, 20_000, 40_000, 80_000), log_rows),
}


def exponent(sizes: Sequence[float], times: Sequence[float]) -> float:
    """The slope of the straight line through the logarithms, by least squares."""
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])


def measured(name: str) -> tuple[list[float], float]:
    """Seconds per unit of a part at its sizes, and the exponent by which they grow."""
    part = PARTS[name]
    times = [part.measure(size) for size in part.sizes]
    return times, exponent(part.sizes, times)


def _short(number: float) -> str:
    return f"{number:,.0f}" if number >= 100 else f"{number:.3g}"


def report(names: Sequence[str] = tuple(PARTS)) -> None:
    """Print the table of docs/dev/performance.md."""
    print("| part | sizes | microseconds | a | exponent |\n|---|---|---|---|---|")
    for name in names:
        part, (times, slope) = PARTS[name], measured(name)
        sizes, costs = f"{part.sizes[0]:,} to {part.sizes[-1]:,}", ", ".join(_short(1e6 * time) for time in times)
        print(f"| {name} | {sizes} | {costs} | {part.unit} | {slope:.2f} |", flush=True)


if __name__ == "__main__":
    report(sys.argv[1:] or tuple(PARTS))
