"""Small halls by number, limited by their packer, by a worker behind the station or by their robots."""

import random
from copy import deepcopy

import desim_warehouse as dw

RING = {
    "name": "packing hall",
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 10], "D": [0, 10]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"node": "A"}, {"node": "B"}],
        "bays": {"parking": {"at": ["D"], "places": 10, "chargers": 0}},
        "stations": {"packing": {"at": ["C"], "places": 6}},
    },
    "fleet": {"size": 6, "robot": {"radius": 0.4, "speed": 1.5}},
    "tasks": {"goods": {"poisson": 33}, "unload_at": ["packing"], "load_time": 10, "unload_time": 120},
    "run": {"length": "8 h"},
}
"""One packer who takes 2 minutes for each load: at most 30 can be done in an hour."""


def loaded_hall(number, hours):
    """A hall whose scarce resource is asked for 70 to 130 % of what it can give, and a run of so many hours."""
    drawn, content = random.Random(number), deepcopy(RING) | {"log": "tasks"}
    load, limit = drawn.uniform(0.7, 1.3), drawn.choice(["packer", "worker", "robots"])
    time = drawn.uniform(40, 150)
    content["tasks"]["unload_time"] = 10
    if limit == "packer":
        content["tasks"]["unload_time"] = {"lognormal": {"mean": time, "cv": drawn.uniform(0.1, 1.0)}}
        most = 3600 / time
    elif limit == "worker":
        content["layout"]["stations"]["packing"]["work_time"], most = time, 3600 / time
    else:
        size = drawn.choice([1, 2, 3])
        content["fleet"]["size"], most = size, size * 3600 / 60
    content["tasks"]["goods"], content["run"] = {"poisson": load * most}, {"length": hours}
    return dw.load(content), load
