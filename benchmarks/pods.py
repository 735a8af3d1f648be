"""What goods to person costs beside single loads: `python -m benchmarks.pods`, in processor time.

A line beside an ordinary task and a visit beside a tour over a station, on one floor with the same robots; and a shift
of 100 robots, 2,000 pods and 20,000 lines.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import desim_warehouse as dw
from benchmarks.memory import peak

if TYPE_CHECKING:
    from desim_warehouse.questions.run import Run

RUNS = 5
SATURATED = {"saturated": 200}
TOUR = {"from": "storage", "via": ["picking"], "to": "storage", "arrivals": SATURATED, "stop_time": 28}


def hall(columns: int, rows: int, robots: int, nodes: list[str], pods: dict[str, Any], length: str) -> dict[str, Any]:
    """A hall of blocks of 2 x 4 places, with robots parked in the north and stations in the south."""
    blocks = {"columns": columns, "rows": rows, "block_width": 2, "block_depth": 4, "goods_size": 1, "aisle_width": 1}
    return {
        "layout": {
            "blocks": {**blocks, "directions": "ring"},
            "bays": {"parking": {"along": "north", "chargers": 0, "places": -(-robots // (columns + 1)) + 1}},
            "stations": {"picking": {"at": nodes, "places": 9, "servers": 1}},
        },
        "fleet": {"size": robots, "robot": {"radius": 0.35, "margin": 0.2, "speed": 1.5}},
        "tasks": {
            "load_time": 2.2,
            "unload_time": 2.2,
            "flows": {"picks": {"from": "storage", "to": "picking", "arrivals": SATURATED, "stop_time": 10}},
        },
        "pods": pods,
        "policies": {"allocation": "nearest", "routing": "fastest", "parking": "nearest", "pod": "most-lines"},
        "run": {"length": length},
        "log": "tasks",
    }


def timed(model: dw.Model, runs: int = RUNS) -> tuple[float, Run]:
    """The least processor time of some runs, and one of them; routes and layout are known from a run before."""
    dw.simulate(model, 1)
    least = float("inf")
    for _ in range(runs):
        begin = time.process_time()
        run = dw.simulate(model)
        least = min(least, time.process_time() - begin)
    return least, run


def rates(pod: str) -> tuple[float, float, float, float]:
    """Lines and visits a second, with pods and 10 robots; ordinary tasks, and tours over a station, without."""
    pods = {"count": 170, "items": 100, "per_pod": 15}
    model = dw.load(hall(5, 5, 10, ["r5c1", "r5c3"], pods, "2.5 h"), {"policies.pod": pod})
    carried, run = timed(model)
    single, tasks = timed(model.replace({"pods": None, "tasks.flows.picks.stop_time": 0}))
    toured, tours = timed(model.replace({"pods": None, "tasks.flows": {"visits": TOUR}}))
    lines, visits = run.kpis["tasks"], run.kpis["pod_visits"]
    return lines / carried, visits / carried, tasks.kpis["tasks"] / single, tours.kpis["tasks"] / toured


def main() -> None:
    """Print both."""
    for pod in ("nearest", "most-lines"):
        line, visit, task, tour = rates(pod)
        print(f"{pod}: a line {task / line:.2f} tasks, a visit {tour / visit:.2f} tours over a station")
    stations = [f"r10c{n}" for n in range(1, 20, 2)]
    pods = {"count": 2000, "items": 1000, "per_pod": 15, "popularity": {"classes": CLASSES}}
    shift = hall(25, 10, 100, stations, pods, "8 h")
    shift["tasks"]["flows"]["picks"] |= {"arrivals": {"poisson": 2500}}
    begin = time.process_time()
    run = dw.simulate(dw.load(shift))
    took = time.process_time() - begin
    print(f"{run.kpis['tasks']:,} lines, {run.kpis['pod_visits']:,} visits: {took:.0f} s, {peak():.0f} MB")


CLASSES = [{"share": 0.2, "demand": 0.8}, {"share": 0.8, "demand": 0.2}]

if __name__ == "__main__":
    main()
