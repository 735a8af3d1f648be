"""Features of real plants beyond the paper's floor, for random models.

Goods at nodes, destinations of tasks, robots that start on the lanes, take time to turn, and park on a node.
"""

import math
import random

import networkx as nx

import desim_warehouse as dw
from desim_warehouse.feasibility import errors


def wider(mapping, seed):
    """Return the model with goods at nodes, tasks with destinations, and robots that start on the lanes."""
    draw = random.Random(f"wider {seed}")
    layout, tasks = dict(mapping["layout"]), dict(mapping["tasks"])
    nodes = list(layout.get("nodes", ()))
    if nodes:
        layout["storage"] = [at_node(draw, nodes) if draw.random() < 0.5 else item for item in layout["storage"]]
        goals = [*nodes, *layout["stations"]]
        if isinstance(tasks["goods"], list):
            tasks["goods"] = [with_goal(draw, item, goals) if draw.random() < 0.4 else item for item in tasks["goods"]]
    turn_time = 0.0 if mapping["battery"] else draw.choice((0.0, 0.3, 2.0))  # batteries are not made for turns
    made = {**mapping, "layout": layout, "tasks": tasks, "traffic": {**mapping["traffic"], "turn_time": turn_time}}
    return with_starts(draw, with_bay_in_lane(draw, made)) if nodes else made


def with_bay_in_lane(draw, mapping):
    """Return the model with another bay in the lane, if no robot has to pass its random node."""
    layout = mapping["layout"]
    taken = {node for zone in layout["bays"].values() for node in zone["at"]}
    node = draw.choice(sorted(layout["nodes"]))
    bays = {**layout["bays"], "lane": {"at": [node], "in_lane": True, "chargers": draw.randint(0, 1)}}
    fleet = {"start": list(layout["bays"]), **mapping["fleet"]}  # no robot starts in the new bay
    made = {**mapping, "layout": {**layout, "bays": bays}, "fleet": fleet}
    return mapping if node in taken or refused(made, "BAY_IN_LANE") else made


def refused(mapping, *codes):
    try:
        return any(item.code in codes for item in errors(dw.load(mapping)))
    except dw.ModelError:  # another error, which the simulation reports
        return False


def with_starts(draw, mapping):
    """Return the model with robots on the lanes, from few to as many as have room and can move."""
    fleet, layout = mapping["fleet"], mapping["layout"]
    contact = 2 * fleet["robot"]["radius"] + fleet["robot"].get("margin", 0)
    edges = [({"from": e[0], "to": e[1]} if isinstance(e, list) else e) for e in layout["edges"]]
    lengths = {(e["from"], e["to"]): e["length"] for e in edges}
    facing = {}
    closed = {node for zone in layout["bays"].values() if zone.get("in_lane") for node in zone["at"]}
    near = nx.Graph(pair for pair, length in lengths.items() if length < contact + 1e-5)
    near.add_nodes_from(layout["nodes"])
    stands = [{"node": draw.choice(sorted(part - closed))} for part in nx.connected_components(near) if part - closed]
    for (a, b), length in lengths.items():
        for place in range(math.floor(length / contact) - 1 if (b, a) not in facing else 0):
            facing[a, b] = True
            offset = contact * (place + 1) * (1 + 1e-9)
            if length - offset >= contact:
                stands.append({"edge": [a, b], "offset": offset})
    draw.shuffle(stands)
    stands = stands[: draw.choice((0, 1, 3, fleet["size"]))][: fleet["size"]]
    return with_room_to_start({**mapping, "fleet": {**fleet, "start_on_lanes": stands}})


def with_room_to_start(mapping):
    """Return the model with as many of its robots on the lanes as can make way for each other."""
    fleet = {**mapping["fleet"]}
    stands = [*fleet.pop("start_on_lanes", ())]
    while stands:
        made = {**mapping, "fleet": {**fleet, "start_on_lanes": stands}}
        if not refused(made, "START_STUCK", "START_ON_LANES"):
            return made
        stands.pop()
    return {**mapping, "fleet": fleet}


def at_node(draw, nodes):
    return {"node": draw.choice(nodes)}


def with_goal(draw, item, goals):
    return {**(item if isinstance(item, dict) else {"good": item}), "to": draw.choice(goals)}
