"""Runs for the replay's tests: small floors with everything that a replay has to show."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import desim_warehouse as dw

if TYPE_CHECKING:
    from desim_warehouse.run import Run


def busy(**changes: Any) -> dict[str, Any]:
    """A crowded floor in metres: stations in the south, bays in the north, batteries that run low soon."""
    model: dict[str, Any] = {
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
def busy_run() -> Run:
    return dw.simulate(dw.load(busy()), seed=3)


@cache
def paper_run() -> Run:
    return dw.simulate(dw.load("models/multibots.yaml"))


@cache
def tired_run() -> Run:
    """The paper's floor with a battery that sends robots home on the way."""
    return dw.simulate(dw.load("models/multibots.yaml", {"battery.capacity": 5, "battery.threshold": 2.5}))


@cache
def jammed_run() -> Run:
    """The paper's floor with thirty robots that unload in the middle of it: rings close and turn."""
    changes = {"fleet.size": 30, "tasks.goods": {"random": 60}, "tasks.unload_at": ["I"]}
    return dw.simulate(dw.load("models/multibots.yaml", {**changes, "battery": None}))


RUNS = {"paper": paper_run, "tired": tired_run, "busy": busy_run, "jammed": jammed_run}
