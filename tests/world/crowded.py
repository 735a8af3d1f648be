"""A small one-way grid of cells of one robot each, easily jammed: chutes beside its nodes, goods on its lanes."""

import random
from itertools import pairwise

SIDE = 10


def crowded(robots, **changes):
    """The model; its floor does most with about 30 robots."""
    edges = []
    for rank in range(SIDE):
        row, column = [(x, rank) for x in range(SIDE)], [(rank, y) for y in range(SIDE)]
        for cells in (row if rank % 2 == 0 else row[::-1], column[::-1] if rank % 2 == 0 else column):
            edges += [(f"{a}.{b}", f"{c}.{d}") for (a, b), (c, d) in pairwise(cells)]
    nodes = [(x, y) for x in range(SIDE) for y in range(SIDE)]
    chutes = [f"{x}.{y}" for x, y in nodes if x % 2 and y % 2 and max(x, y) < SIDE - 1]
    return {
        "layout": {
            "nodes": {f"{x}.{y}": [x, y] for x, y in nodes},
            "edges": [list(edge) for edge in edges],
            "storage": [{"edge": list(edge), "offset": 0.5} for edge in edges[::3]],
            "bays": {"home": {"at": [f"{x}.{y}" for x, y in nodes if (x + y) % 5 == 0], "places": robots}},
            "stations": {"chutes": {"at": chutes, "places": robots, "servers": robots}},
        },
        "fleet": {"size": robots, "robot": {"radius": 0.5, "speed": 1}},
        "tasks": {
            "goods": {"saturated": 20},
            "unload_at": ["chutes"],
            "station_choice": "random",
            "load_time": 0,
            "unload_time": 0,
        },
        "policies": {"routing": {"name": "shortest", "spread": 8}, "parking": "nearest"},
        "run": {"length": 900, "warm_up": 200},
        "log": "tasks",
        **changes,
    }


def waves(robots, seed, *, calm, length, burst):
    """Tasks that come evenly for a time, `calm` of them a second, then `burst` of them at once."""
    draw = random.Random(seed)
    made = crowded(robots, run={})
    places = len(made["layout"]["storage"])
    times = [*(i / calm for i in range(int(length * calm))), *[length] * burst]
    made["tasks"]["goods"] = [{"good": draw.randrange(places), "release": time} for time in times]
    return made
