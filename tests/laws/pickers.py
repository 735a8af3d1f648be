"""Pickers for random models: people who walk to robots at storage places, from few and slow to many and fast."""

import random

import desim_warehouse as dw
from desim_warehouse.errors import ModelError
from tests.laws.hours import lap
from tests.laws.random_models import lasting

LASTS = 60
"""Factor for the life of batteries, as robots wait for people, who may be slow or off work."""


def with_pickers(mapping, key):
    """Return the model with pickers for all loads at storage places, or for some flows of them."""
    draw = random.Random(f"pickers {key}")
    model = dw.load(mapping)
    if model.pods is not None or model.layout.lifts or not model.floor.storage:
        return mapping
    slowest = min(robot.speed for robot in model.fleet.robots())
    most = max(model.fleet.size, 3) if draw.random() < 0.9 else 1
    count = draw.randint(1, most)
    pickers = {
        "count": count,
        "speed": slowest * draw.choice((0.5, 1, 1, 3, 1000)),
        "choose": draw.choice(("nearest", "nearest", "longest-waiting")),
    }
    pickers |= draw.choice(({}, {"stay": "order"}, {"stay": "order"}, {"call": "ahead"}))
    if "stay" not in pickers:
        pickers["zones"] = draw.randint(1, min(count, len(model.floor.storage)))
    flows = [
        name for name, flow in mapping["tasks"].get("flows", {}).items() if "storage" in (flow["from"], flow["to"])
    ]
    if flows and draw.random() < 0.3:
        pickers["flows"] = draw.sample(flows, draw.randint(1, len(flows)))
    made = {**mapping, "battery": lasting(mapping["battery"], LASTS)}
    if draw.random() < 0.3:
        every = lap(mapping) * draw.uniform(0.2, 3)
        hours = {"every": every, "lasts": every * draw.choice((0.6, 0.75, 0.99))}
        made["calendars"] = {**mapping.get("calendars", {}), "pickers": hours}
        pickers["hours"] = "pickers"
        if made["battery"]:  # robots draw while they wait
            made["battery"] = {**made["battery"], "charge_rate": 20 * made["battery"]["charge_rate"]}
    tries = [{**made, "pickers": {name: value for name, value in pickers.items() if name != "stay"}}]
    if "stay" in pickers:
        tries.insert(0, {**with_stations(made, model), "pickers": pickers})
    for tried in tries:
        try:
            dw.load(tried)
        except ModelError:
            continue
        return tried
    return mapping


def with_stations(mapping, model):
    """Return the model with a station at every node where loads are put down."""
    layout, tasks = mapping["layout"], mapping["tasks"]
    ends = [*tasks.get("unload_at", ()), *(flow["to"] for flow in tasks.get("flows", {}).values())]
    nodes = [node for node in dict.fromkeys(ends) if node in model.floor.graph and node not in model.floor.stations]
    beside = {f"beside {node}": {"at": [node], "places": 3, "servers": 1} for node in nodes}
    return {**mapping, "layout": {**layout, "stations": {**layout.get("stations", {}), **beside}}}
