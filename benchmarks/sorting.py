"""A sorting floor, how its robots do with one route, with several, and with a cap on robots under way.

A one-way grid of about 2,500 cells of one robot each: parcels are taken along its sides and dropped into chutes all
over the floor, as in sorting centres. Goals a step (a parcel taken or dropped; a robot drives one cell a step) are
counted after a warm-up. `python -m benchmarks.sorting` prints the figures behind docs/why.md (some two minutes).
"""

from __future__ import annotations

import sys
import time
from itertools import pairwise
from typing import Any

import desim_warehouse as dw

WIDTH, HEIGHT = 69, 40
FLEETS = (100, 300, 500, 800)
POLICIES: dict[str, dict[str, Any]] = {
    "shortest": {"policies.routing": "shortest"},
    "spread": {"policies.routing": {"name": "shortest", "spread": 8}},
    "spread, at most 500 out": {
        "policies.routing": {"name": "shortest", "spread": 8},
        "traffic.most_out": 500,
    },
}


def is_chute(x: int, y: int) -> bool:
    """Whether a cell is a chute, which no robot enters."""
    return x % 4 == 2 and y % 3 == 2 and 0 < y < HEIGHT - 2


def floor() -> dict[str, Any]:
    """The model's layout: cells with one-way edges to their neighbours, chutes, bays along the top and bottom."""
    cells = [(x, y) for y in range(HEIGHT) for x in range(WIDTH) if not is_chute(x, y)]
    free = set(cells)
    edges = []
    for y in range(HEIGHT):
        row = [(x, y) for x in range(WIDTH)]
        edges += pairwise(row if is_east(y) else row[::-1])
    for x in range(WIDTH):
        column = [(x, y) for y in range(HEIGHT)]
        edges += pairwise(column if is_south(x) else column[::-1])
    edges = [(one, other) for one, other in edges if one in free and other in free]
    picks = [
        *(((0, y), (0, y - 1)) for y in range(4, HEIGHT - 1, 3)),
        *(((WIDTH - 1, y), (WIDTH - 1, y + 1)) for y in range(3, HEIGHT - 1, 3)),
        *(((x, 0), (x + 1, 0)) for x in range(3, WIDTH - 1, 4)),
        *(((x, HEIGHT - 1), (x - 1, HEIGHT - 1)) for x in range(1, WIDTH, 4)),
    ]
    ends = [(x, y) for y in (0, HEIGHT - 1) for x in range(1, WIDTH - 1)]
    drops = [(x, y - 1) for x, y in ((x, y) for y in range(HEIGHT) for x in range(WIDTH)) if is_chute(x, y)]
    return {
        "nodes": {name(cell): [*map(float, cell)] for cell in cells},
        "edges": [[name(one), name(other)] for one, other in edges],
        "storage": [{"edge": [name(one), name(other)], "offset": 0.5} for one, other in picks],
        "bays": {"ends": {"at": [name(cell) for cell in ends], "places": 6}},
        "stations": {"chutes": {"at": [name(cell) for cell in drops], "places": 100, "servers": 100}},
    }


def name(cell: tuple[int, int]) -> str:
    """A cell's node."""
    return f"{cell[0]},{cell[1]}"


def is_east(y: int) -> bool:
    """Whether a row leads east."""
    return y % 3 != 1 and y < HEIGHT - 1


def is_south(x: int) -> bool:
    """Whether a column leads south: as many do as lead north."""
    return x % 4 == 1 or x % 8 == 4


def model(robots: int, steps: float, warm_up: float) -> dict[str, Any]:
    """The whole model: parcels without end, each for a chute drawn at random."""
    layout = floor()
    return {
        "name": "sorting floor",
        "layout": layout,
        "fleet": {"size": robots, "robot": {"radius": 0.5, "speed": 1.0}},
        "tasks": {
            "goods": {"saturated": 50},
            "unload_at": ["chutes"],
            "station_choice": "random",
            "load_time": 0.0,
            "unload_time": 0.0,
        },
        "policies": {"routing": "shortest", "parking": "nearest"},
        "run": {"length": warm_up + steps, "warm_up": warm_up},
        "log": "tasks",
    }


def goals(robots: int, changes: dict[str, Any], *, steps: float = 600, warm_up: float = 600) -> tuple[float, float]:
    """Goals a step, and seconds of processor time."""
    loaded = dw.load(model(robots, steps, warm_up), changes)
    begin = time.process_time()
    run = dw.simulate(loaded)
    spent = time.process_time() - begin
    done = sum(row[1] in {"loaded", "delivered"} and row[0] > warm_up for row in run.record.rows)
    return done / steps, spent


def report() -> None:
    """Print the table; in brackets the processor time of a run, which the machine decides on."""
    print(f"{'goals a step':<26}" + "".join(f"{robots:>16}" for robots in FLEETS))
    for title, changes in POLICIES.items():
        print(f"{title:<26}", end="")
        for robots in FLEETS:
            rate, spent = goals(robots, changes)
            print(f"{rate:>8.2f} ({spent:>3.0f} s)", end="", flush=True)
        print()


if __name__ == "__main__":
    sys.exit(report())
