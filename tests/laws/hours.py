"""Hours of stations, robots and flows for random models, with handling times, work and buffers in stations."""

import random

import desim_warehouse as dw
from desim_warehouse.layout import build


def lap(mapping):
    """Return a bound on the time for any route without a circle, handling included."""
    model = dw.load(mapping)
    slowest = min(robot.speed for robot in model.fleet.robots())
    edges = build(model.layout).graph.edges(data=True)
    drive = sum(data["length"] / min(slowest, data["speed"]) for *_, data in edges)
    return drive + len(edges) * model.traffic.node_time + 10


def with_hours(mapping, seed):
    """Return the model with periodic hours, each open for at least 60 % of the time, so that any two overlap."""
    draw = random.Random(f"hours {seed}")
    scale, last = lap(mapping), mapping.get("run", {}).get("length") or float("inf")
    calendars = {}
    for number in range(draw.randint(1, 3)):
        every = scale * draw.uniform(0.2, 4)
        calendars[f"h{number}"] = {
            "every": every,
            "lasts": every * draw.choice((0.6, 0.75, 0.99, 1.0)),
            "first": draw.choice((0.0, draw.uniform(0, min(every, 0.5 * last)))),
        }

    def some():
        return draw.choice([None, *calendars])

    layout = mapping["layout"]
    stations = {name: station(dict(item), draw, some(), scale) for name, item in layout.get("stations", {}).items()}
    fleet = {**mapping["fleet"], "hours": some()}
    fleet["kinds"] = {name: {**kind, "hours": some()} for name, kind in fleet.get("kinds", {}).items()}
    tasks = dict(mapping["tasks"])
    if isinstance(tasks.get("goods"), dict) and "poisson" in tasks["goods"]:
        tasks["goods"] = {**tasks["goods"], "hours": some()}
    if "flows" in tasks:
        tasks["flows"] = {
            name: flow if "saturated" in flow["arrivals"] else {**flow, "hours": some()}
            for name, flow in tasks["flows"].items()
        }
    layout = {**layout, "stations": stations}
    battery = mapping.get("battery")
    if battery:  # robots draw energy while they wait, and a fleet deep in reserve would only charge
        battery = {**battery, "charge_rate": 20 * battery["charge_rate"]}
        mapping = {**mapping, "battery": battery}
    calendars = {**mapping.get("calendars", {}), **calendars}
    return {**mapping, "calendars": calendars, "layout": layout, "fleet": fleet, "tasks": tasks}


def station(made, draw, hours, scale):
    """Return a station with random hours, handling times, and work on load units."""
    if hours is not None:
        made |= {"hours": hours, "at_close": draw.choice(("finish", "pause"))}
    if draw.random() < 0.3:
        made["unload_time"] = draw.choice((0.0, 4.0, {"exponential": 3}))
    if draw.random() < 0.3:
        made["load_time"] = draw.choice((0.0, {"uniform": [1, 5]}))
    if draw.random() < 0.5:
        buffer = draw.choice((None, 1, 3))
        made |= {"work_time": draw.choice((0.0, 3.0, {"exponential": 0.1 * scale})), "buffer": buffer}
        made["workers"] = draw.randint(1, 2 if buffer != 1 else 1)
    return made
