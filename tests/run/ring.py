"""A ring that robots drive round, of which every number can be worked out by hand."""

from desim_warehouse.questions.run import Run
from desim_warehouse.world import World

RATES = {"standing": 0.5, "empty": 1.0, "loaded": 2.0, "handling": 1.5}


def ring(battery, length, **changes):
    """A square ring of 30 a side at a speed of 1; the good is 10 beyond the bay, its station half round the ring.

    The robot is at its good at 10, leaves it at 13, is at its station at 63, free at 68 and in its bay at 128. A
    second good, released when the run is over, keeps the run from ending with the first.
    """
    return {
        "layout": {
            "nodes": {"A": [0, 0], "B": [30, 0], "C": [30, 30], "D": [0, 30]},
            "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
            "storage": [{"edge": ["A", "B"], "offset": 10}],
            "bays": {"home": {"at": ["A"]}},
        },
        "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}, "first_exit_time": 0, "exit_time": 0},
        "tasks": {
            "goods": [0, {"good": 0, "release": length}],
            "unload_at": ["C"],
            "load_time": 3,
            "unload_time": 5,
            "clear_time": 0,
        },
        "battery": battery,
        "run": {"length": length},
        **changes,
    }


def played(model, seed=0):
    """A run, and the levels that its batteries themselves say they have at its end."""
    world = World(model, seed).run()
    levels = [robot.battery.level(world.env.now) for robot in world.robots]
    return Run(model, seed, world.log, world.layout), levels
