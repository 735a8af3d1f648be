"""Random drafts by number, and how far their quick estimate is from long runs of them, in per cent.

`python -m tests.feasibility.estimate_truth 0 40` prints each draft, and the median, the 90 % quantile and the worst of
all: tasks an hour of one robot, and what it draws for a task; tasks an hour of the fleet where work always waits; and
at 60 % of that the time that a task takes a robot, and what the fleet draws.
"""

import random
import sys

import numpy as np

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.errors import SimulationError
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.run.quick import estimate

TASKS = 1500
"""Of a run, about."""
WORKING = ("empty", "loading", "loaded", "unloading", "awaiting", "queueing")
SATURATED = {"saturated": 200}
FEW = 10
"""Tasks an hour of a flow; a run has half as many again as the fleet can do."""


def model(number):
    """A draft with some of what a model may have, and work that always waits."""
    draw = random.Random(number)
    size = draw.randint(24, 70), draw.randint(20, 50)
    words = Draft(size, orders=draw.choice([60, 100, 160]), due=draw.choice([8, 15]), stations=draw.choice([1, 2]))
    drafted = dw.Model.model_validate(read_yaml(draft(words), "draft").data)
    speed = draw.choice([1.0, 1.5, 2.0, 3.0])
    changes = {
        "fleet.robot.speed": speed,
        "fleet.robot.acceleration": draw.choice([0.3, 0.5, 1.0, None]),
        "policies.allocation": "in-order",
        "tasks.goods": SATURATED,
        "log": "tasks",
    }
    sometimes = [
        {"traffic.turn_time": 4},
        {"traffic.node_time": 1},
        {"fleet.robot.speed_loaded": 0.7 * speed},
        {"policies.interval": 10},
        {"fleet.robot.delays": {"share": 0.05, "time": 10}},
        {"tasks.popularity": {"classes": [{"share": 0.2, "demand": 0.7}, {"share": 0.8, "demand": 0.3}]}},
        {"people": {"pickers": {"per_hour": 20, "stay": 40}}},
        {"battery.capacity": 0.5 * drafted.battery.capacity},
        {"layout.blocks.directions.columns": "two-way"},
        {"tasks.station_choice": "nearest"},
    ]
    for one in sometimes:
        changes |= one if draw.random() < 0.2 else {}
    kind = draw.choice(["goods", "goods", "flows", "via", "kinds", "tours"])
    flows = {
        "in": {"from": "packing", "to": "storage", "arrivals": {"poisson": FEW}},
        "out": {"from": "storage", "to": "packing", "arrivals": {"poisson": FEW}},
    }
    if kind in {"flows", "via"}:
        if kind == "via":
            flows["out"] |= {"via": ["packing"], "stop_time": 15}
        changes = {key: value for key, value in changes.items() if not key.startswith("tasks")}
        changes["tasks"] = {"load_time": 10, "unload_time": 20, "station_choice": "least-loaded", "flows": flows}
    elif kind == "kinds" and drafted.fleet.size > 2:
        changes["fleet.kinds"] = {"slow": {"count": drafted.fleet.size // 2, "speed": 0.6 * speed}}
    elif kind == "tours":
        changes |= {"fleet.robot.capacity": 3, "policies.batching": {"name": "fixed-size", "size": 3}}
    return kind, drafted.replace(changes)


def simulated(one, calculation):
    """The indicators of a run that is long enough for the tasks wanted."""
    hour = one.units.hour
    length = TASKS / calculation.capacity
    if one.tasks.flows:
        one = one.replace({"tasks.demand": 1.5 * calculation.capacity * hour / (len(one.tasks.flows) * FEW)})
    return dw.simulate(one.replace({"run": {"length": max(1.25 * length, 2 * hour), "warm_up": 0.2 * length}}), 3).kpis


def apart(number):
    """What the estimate of a draft says too much, in per cent, by name."""
    kind, whole = model(number)
    hour, ratios = whole.units.hour, {}
    lone = whole.replace({"fleet.size": 1, "fleet.kinds": {}})
    for name, one in (("one robot", lone), ("fleet", whole)):
        told = estimate(one)
        kpis = simulated(one, told)
        ratios[name] = told.capacity * hour / kpis["throughput_per_hour"]
        if one is lone:
            ratios["its energy"] = told.power.task * kpis["tasks"] / kpis["energy"]
    if not whole.tasks.flows and kind != "tours":
        calm = whole.replace({"tasks.goods": {"poisson": 0.6 * kpis["throughput_per_hour"]}})
        told, kpis = estimate(calm), simulated(calm, told)
        counted = kpis["tasks"] / kpis["throughput_per_hour"] * hour
        busy = calm.fleet.size * counted * sum(kpis.get(f"share_{name}", 0.0) for name in WORKING) / kpis["tasks"]
        ratios["busy at 60 %"] = told.cycle.time / busy
        ratios["draws at 60 %"] = told.power.draws * counted / kpis["energy"]
    return kind, {name: 100 * (ratio - 1) for name, ratio in ratios.items()}


def main(first, last):
    """Print how far the estimates are off."""
    every = {}
    for number in range(first, last):
        try:
            kind, errors = apart(number)
        except SimulationError as error:
            sys.stdout.write(f"{number}: {type(error).__name__}: {str(error)[:150]}\n")
            continue
        line = ", ".join(f"{name} {value:+.1f}" for name, value in errors.items())
        sys.stdout.write(f"{number} ({kind}): {line}\n")
        sys.stdout.flush()
        for name, value in errors.items():
            every.setdefault(name, []).append(value)
    for name, values in every.items():
        off = np.abs(values)
        sys.stdout.write(
            f"{name}: {len(values)} drafts, median {np.median(off):.1f}, 90 % within {np.quantile(off, 0.9):.1f}, "
            f"worst {off.max():.1f}, on average {np.mean(values):+.1f}\n"
        )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
