"""Random plants: a model with figures from data sheets, and the figures that its fleet really has."""

import string

import numpy as np

SHEET = """\
name: a plant
layout:
  blocks: {{columns: {columns}, rows: 1, block_width: 2, block_depth: {depth}, goods_size: 1.2, aisle_width: 3}}
  bays:
    charging: {{at: [B, C], places: 2, chargers: 1}}
    parking: {{at: [A, D], places: 6, chargers: 0}}
  stations:
    packing: {{at: [{south}, {packers}], places: 6, servers: 2}}
fleet:
  size: {size}   # robots
  start: [A, D]
  robot: {{radius: 0.4, speed: 1.5, margin: 0.2}}
  start_energy: {{uniform: [0.3, 0.9]}}
tasks:
  goods: {{poisson: 40}}
  unload_at: [{south}, {packers}]
  station_choice: least-loaded
  load_time: 10
  unload_time: 20
battery: {{capacity: 100, consumption: 0.005, charge_rate: 0.03}}
traffic: {{node_time: 1}}
policies: {{allocation: nearest, charging: four-thresholds, parking: nearest}}
run: {{length: {length}, warm_up: 0}}
"""


def sheet(rng, hours=2.0):
    """A model file with figures from data sheets."""
    columns, depth, size = int(rng.integers(4, 7)), int(rng.integers(6, 16)), int(rng.integers(3, 9))
    south = string.ascii_uppercase[columns + 1 :]
    return SHEET.format(
        columns=columns, depth=depth, size=size, length=round(hours * 3600), south=south[0], packers=south[2]
    )


def real(rng, size, edges):
    """What is true of the fleet, as overrides; the slow edges apart."""
    speed = rng.uniform(0.8, 1.9)
    loaded = speed * rng.uniform(0.6, 0.97)
    spread = {"mean": rng.uniform(6, 25), "cv": rng.uniform(0.15, 0.8)}
    other = {"mean": rng.uniform(8, 30), "cv": rng.uniform(0.15, 0.8)}
    kinds = rng.choice(["lognormal", "gamma"], 2)
    truth = {
        "fleet.robot.speed": speed,
        "fleet.robot.speed_loaded": loaded,
        "traffic.node_time": rng.uniform(0, 3),
        "traffic.turn_time": rng.choice([0.0, rng.uniform(0.5, 3)]),
        "tasks.load_time": {str(kinds[0]): spread},
        "tasks.unload_time": {str(kinds[1]): other},
        "battery.consumption": {
            "standing": rng.uniform(0.001, 0.003),
            "empty": rng.uniform(0.003, 0.006),
            "loaded": rng.uniform(0.005, 0.009),
            "handling": rng.uniform(0.002, 0.005),
        },
        "battery.charge_rate": rng.uniform(0.02, 0.06),
        "fleet.robot.breakdowns": {
            "every": {"exponential": rng.uniform(2000, 15000)},
            "repair": {"lognormal": {"mean": rng.uniform(60, 400), "cv": rng.uniform(0.3, 0.8)}},
        },
        "tasks.goods.poisson": rng.uniform(5, 9) * size,
        "log": "all",
    }
    chosen = [list(edges[n]) for n in rng.choice(len(edges), rng.integers(0, 3), replace=False)]
    if chosen:
        truth["traffic.slow"] = {"somewhere": {"members": chosen, "speed": loaded * rng.uniform(0.5, 0.8)}}
    return truth


def known(truth):
    """The true value of every figure that has an interval, by the key of the estimate."""
    figures = {key: truth[key] for key in truth if isinstance(truth[key], float | np.floating)}
    figures |= {key: next(iter(truth[key].values()))["mean"] for key in ("tasks.load_time", "tasks.unload_time")}
    figures |= {f"battery.consumption.{state}": rate for state, rate in truth["battery.consumption"].items()}
    faults = truth["fleet.robot.breakdowns"]
    figures["fleet.robot.breakdowns.every"] = faults["every"]["exponential"]
    figures["fleet.robot.breakdowns.repair"] = faults["repair"]["lognormal"]["mean"]
    for zone in truth.get("traffic.slow", {}).values():
        figures["slow"] = zone["speed"]
    return figures
