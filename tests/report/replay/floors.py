"""Runs for the replay's tests: small floors with everything that a replay has to show."""

from functools import cache

import desim_warehouse as dw
from tests.world.test_pods import RING


def busy(**changes):
    """A crowded floor in metres: stations in the south, bays in the north, batteries that run low soon."""
    model = {
        "name": "busy",
        "layout": {
            "blocks": {
                "columns": 3,
                "rows": 2,
                "block_depth": 6,
                "goods_size": 1.2,
                "aisle_width": 1.6,
                "cross_aisle_width": 2.0,
            },
            "bays": {"north": {"along": "north", "places": 5, "chargers": 2}},
            "stations": {"packing": {"along": "south", "places": 3, "servers": 1}},
        },
        "fleet": {"size": 16, "robot": {"radius": 0.4, "speed": 1.5, "margin": 0.1}, "exit_time": 2.0},
        "tasks": {
            "goods": {"saturated": 12},
            "unload_at": [f"{'IJKL'[number % 4]}" for number in range(16)],
            "load_time": 4.0,
            "unload_time": 6.0,
            "clear_time": 1.0,
        },
        "battery": {"capacity": 10.0, "threshold": 4.0, "consumption": 0.02, "charge_rate": 0.2},
        "traffic": {"node_time": 0.5},
        "run": {"length": 900.0, "warm_up": 60.0},
    }
    return model | changes


@cache
def busy_run():
    return dw.simulate(dw.load(busy()), seed=3)


@cache
def due_run():
    """The crowded floor with orders that come when they will, and are due soon."""
    tasks = busy()["tasks"] | {"goods": {"poisson": 300, "due_within": 60.0}}
    return dw.simulate(dw.load(busy(name="due", tasks=tasks, battery=None)), seed=1)


@cache
def paper_run():
    return dw.simulate(dw.load("models/multibots.yaml"))


@cache
def tired_run():
    """The paper's floor with a battery that sends robots home on the way."""
    return dw.simulate(dw.load("models/multibots.yaml", {"battery.capacity": 5, "battery.threshold": 2.5}))


@cache
def jammed_run():
    """The paper's floor with thirty robots that unload in the middle of it: rings close and turn."""
    changes = {"fleet.size": 30, "tasks.goods": {"random": 60}, "tasks.unload_at": ["I"]}
    return dw.simulate(dw.load("models/multibots.yaml", {**changes, "battery": None}))


@cache
def drawn_run():
    """A floor drawn by hand: slanting edges, robots of two sizes, a bay inside, a bay and a station at one node."""
    nodes = {"in": [0.0, 0.0], "a": [20.0, 0.0], "b": [32.0, 9.0], "out": [20.0, 18.0], "c": [0.0, 18.0]}
    edges = ["in a", "a b", "b out", "out c", "c in", "a mid", "mid c", "in mid", "mid out"]
    places = [("a b", 5.0), ("a b", 8.0), ("b out", 6.0), ("mid c", 5.0), ("in a", 9.0)]
    layout = {
        "nodes": nodes | {"mid": [9.0, 9.0]},
        "edges": [edge.split() for edge in edges],
        "storage": [{"edge": edge.split(), "offset": offset} for edge, offset in places],
        "bays": {"garage": {"at": ["in", "mid"], "places": 4}},
        "stations": {"dock": {"at": ["out"], "places": 4, "servers": 2}, "desk": {"at": ["in"], "places": 2}},
    }
    robot = {"radius": 0.5, "speed": 1.2, "margin": 0.1}
    kinds = {"big": {"count": 2, "radius": 0.8, "speed": 0.9}}
    tasks = {"goods": {"random": 30}, "unload_at": ["out", "in", *["out"] * 5], "load_time": 5.0, "unload_time": 8.0}
    model = busy(
        name="drawn",
        layout=layout,
        fleet={"size": 7, "robot": robot, "kinds": kinds, "exit_time": 2.0},
        tasks=tasks,
        battery={"capacity": 100.0, "threshold": 40.0, "consumption": 0.3, "charge_rate": 1.0},
    )
    del model["run"]
    return dw.simulate(dw.load(model), seed=1)


@cache
def spurs_run():
    """A two-way trunk with spurs, beside it a loop with one lane in each direction."""
    nodes = {"a": [0.0, 0.0], "b": [12.0, 0.0], "c": [24.0, 0.0], "d": [36.0, 0.0], "shelf": [12.0, 9.0]}
    two_way = ["a b", "b c", "b shelf", "c pack"]
    edges = [{"from": pair.split()[0], "to": pair.split()[1], "two_way": True} for pair in two_way]
    edges += [{"from": "c", "to": "d", "side_by_side": True}, {"from": "d", "to": "c"}]
    layout = {
        "nodes": nodes | {"pack": [24.0, 9.0]},
        "edges": edges,
        "storage": [{"node": "shelf"}, {"edge": ["a", "b"], "offset": 6.0}, {"edge": ["d", "c"], "offset": 6.0}],
        "bays": {"home": {"at": ["a", "d"], "places": 3}},
        "stations": {"pack": {"at": ["pack"], "places": 2}},
    }
    model = busy(
        name="spurs",
        layout=layout,
        fleet={"size": 5, "robot": {"radius": 0.5, "speed": 1.0}},
        tasks={"goods": {"random": 20}, "unload_at": ["pack"], "load_time": 5.0, "unload_time": 8.0},
        battery=None,
        policies={"routing": "shortest"},
    )
    del model["run"]
    return dw.simulate(dw.load(model), seed=1)


@cache
def tours_run():
    """Robots that pick up to three goods on a tour of the paper's floor, some on one lane, and unload in stations."""
    changes = {
        "fleet.robot.capacity": 3,
        "policies.batching": {"name": "time-window", "window": 200},
        "tasks.goods": {"random": 40},
        "layout.stations": {"out": {"at": ["M", "P"], "places": 2}},
        "tasks.unload_at": ["M", "P"],
        "tasks.station_choice": "nearest",
        "battery": None,
    }
    return dw.simulate(dw.load("models/multibots.yaml", changes))


@cache
def people_run():
    """The crowded floor with an aisle that is closed again and again, and people in others."""
    model = busy(
        name="people",
        calendars={"cleaning": {"every": 200, "lasts": 80, "first": 20}},
        traffic={"node_time": 0.5, "closures": {"aisle": {"members": [["B", "F"], ["F", "J"]], "hours": "cleaning"}}},
        people={"pickers": {"per_hour": 200, "stay": {"exponential": 40}}},
        battery=None,
    )
    return dw.simulate(dw.load(model), seed=2)


WALLS = [(column, row) for column in (*range(2, 6), *range(7, 11)) for row in (2, 5)]
"""Cells of the grid where no robot can be: shelves."""


@cache
def grid_run():
    """A grid of two-way cells round four shelves, with goods on the cells beside them."""
    cells = [(column, row) for row in range(8) for column in range(13) if (column, row) not in WALLS]
    pairs = [((x, y), there) for x, y in cells for there in ((x + 1, y), (x, y + 1)) if there in cells]
    beside = [(x, y) for x, y in cells if (x, y - 1) in WALLS or (x, y + 1) in WALLS]

    def name(cell):
        return f"{cell[0]}.{cell[1]}"

    layout = {
        "nodes": {name(cell): [float(cell[0]), float(cell[1])] for cell in cells},
        "edges": [{"from": name(a), "to": name(b), "two_way": True} for a, b in pairs],
        "storage": [{"node": name(cell)} for cell in beside],
        "bays": {"home": {"at": ["0.0", "0.7"], "places": 2}},
        "stations": {"pack": {"at": ["12.3"], "places": 2}},
    }
    model = busy(
        name="grid",
        layout=layout,
        fleet={"size": 3, "robot": {"radius": 0.3, "speed": 1.0, "margin": 0.05}},
        tasks={"goods": {"random": 8}, "unload_at": ["12.3"], "load_time": 3.0, "unload_time": 4.0},
        battery=None,
        policies={"routing": "shortest"},
    )
    del model["run"]
    return dw.simulate(dw.load(model), seed=1)


RUNS = {
    "tours": tours_run,
    "spurs": spurs_run,
    "paper": paper_run,
    "tired": tired_run,
    "busy": busy_run,
    "jammed": jammed_run,
    "drawn": drawn_run,
    "people": people_run,
    "grid": grid_run,
}


@cache
def pods_run():
    """The ring of the cases worked out by hand: a bundle of two is put onto a pod with one unit, three are picked."""
    flows = {
        "picks": {"from": "storage", "to": "pick", "arrivals": {"schedule": [{"at": 0, "tasks": 3}]}, "stop_time": 10},
        "bundles": {"from": "pick", "to": "storage", "arrivals": {"schedule": [{"at": 500}]}, "stop_time": 20},
    }
    return dw.simulate(
        dw.load(RING, {"tasks.flows": flows, "pods.stock": 1, "pods.bundle": 2, "pods.count": 1}), seed=1
    )
