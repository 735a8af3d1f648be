"""Upper floors for random models, with bays, stations and destinations that robots reach by lifts."""

import random

from tests.laws.breakdowns import varying
from tests.laws.random_models import lasting

RIDES, DOORS = (1.0, 12.0, 60.0), (0.0, 4.0)
LASTS, MOST = 50, 1e12
"""Factor for the life of batteries, which are not made for long rides, and the largest reserve of a model."""
KEPT = frozenset({"start", "hours"})
"""Keys whose values are bays, which may be upstairs, or calendars."""


def with_lifts(mapping, key):
    """Return the model with one to four nodes for work or rest on upper floors; models of blocks stay as they are.

    A node keeps its name upstairs. In the lanes another node takes its place, with a lift beside it.
    """
    draw = random.Random(f"lifts {key}")
    layout = mapping["layout"]
    if "blocks" in layout:
        return mapping
    used = {node for zone in (*layout["bays"].values(), *layout.get("stations", {}).values()) for node in zone["at"]}
    used |= {node for node in mapping["tasks"].get("unload_at", ()) if node in layout["nodes"]}
    contact = 2 * mapping["fleet"]["robot"]["radius"] + mapping["fleet"]["robot"].get("margin", 0)
    two_way = any(isinstance(edge, dict) and edge.get("two_way") for edge in layout["edges"])
    moved = draw.sample(sorted(used), min(len(used), draw.randint(1, 4)))
    below = {node: f"{node}_" for node in moved}
    nodes, edges = {}, renamed(layout["edges"], below)
    for name, at in layout["nodes"].items():
        nodes[below.get(name, name)] = at
    height = 10 * max(abs(y) for _, y in layout["nodes"].values()) + 100

    def street(a, b):
        length = draw.choice((2, 2, 3, 6)) * contact * 1.0001
        both = two_way and draw.random() < 0.8
        for one, other in ((a, b), (b, a)):
            edges.append({"from": one, "to": other, "length": length, "side_by_side": not both})

    lifts, storeys = {}, 0  # each node upstairs has a storey of its own
    while moved:
        upstairs = [moved.pop() for _ in range(min(len(moved), draw.choice((1, 1, 2, 3))))]
        for shaft in range(draw.choice((1, 1, 2))):
            stops = []
            for floor, name in enumerate((below[upstairs[0]], *upstairs)):
                x, y = layout["nodes"][upstairs[max(floor - 1, 0)]]
                up = height * (storeys + floor) if floor else 0
                if floor:
                    nodes[name] = [x, y - up]
                stops.append(f"{name}^{shaft}.{floor}")
                nodes[stops[-1]] = [x + (3 + shaft) * contact, y - up - 0.5]
                street(name, stops[-1])
            lift = {"nodes": stops, "ride": draw.choice(RIDES), "doors": draw.choice(DOORS)}
            lift |= {"rests": draw.choice(stops)} if draw.random() < 0.5 else {}
            lifts[f"lift{len(lifts)}"] = lift | others(random.Random(f"users {key} {len(lifts)}"), lift)
        storeys += len(upstairs)
    storage = renamed(layout["storage"], below)
    made = {**layout, "nodes": nodes, "edges": edges, "storage": storage, "lifts": lifts}
    downstairs = {key: renamed(mapping[key], below) for key in ("fleet", "traffic", "people") if key in mapping}
    battery = lasting(mapping["battery"], LASTS)
    if battery:
        battery["reserve"] = min(battery["reserve"], MOST)
    return {**mapping, **downstairs, "layout": made, "battery": battery}


def others(draw, lift):
    """Return keys of a lift for people, who use it a tenth of the time or more, and for outages, in some buildings."""
    longest = lift["ride"] * len(lift["nodes"])
    users = {}
    if draw.random() < 0.4:
        transfer = draw.choice((0, 3, 20))
        each = 2 * longest + 4 * lift["doors"] + 2 * transfer
        users["people"] = {"per_hour": draw.choice((0.1, 0.3, 0.6)) * 3600 / each, "transfer": varying(draw, transfer)}
    if draw.random() < 0.3:
        every = varying(draw, draw.choice((5, 50)) * longest)
        users["outages"] = {"every": every, "repair": varying(draw, draw.choice((0.5, 5)) * longest)}
    return users | ({"cabins": draw.choice((2, 3))} if draw.random() < 0.2 else {})


def renamed(part, names):
    """Return a part of a model with the names of nodes replaced."""
    if isinstance(part, str):
        return names.get(part, part)
    if isinstance(part, dict):
        return {key: value if key in KEPT else renamed(value, names) for key, value in part.items()}
    return [renamed(value, names) for value in part] if isinstance(part, list | tuple) else part
