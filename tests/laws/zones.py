"""Zones for random models: parts of the floor for one robot, and lines of two-way lanes for one direction."""

import random
from itertools import pairwise

import networkx as nx

import desim_warehouse as dw
from desim_warehouse.layout import build


def with_zones(mapping, seed):
    """Return the model with up to three zones, as far as there is room."""
    draw = random.Random(f"zones {seed}")
    model = dw.load(mapping)
    graph, contact = build(model.layout).graph, model.fleet.contact
    zones, taken = {}, set()
    for number in range(draw.randint(1, 3)):
        rule = draw.choice(["one-robot", "one-direction"])
        members = one_robot(graph, draw, taken) if rule == "one-robot" else line(graph, draw, taken, contact)
        if members:
            zones[f"z{number}"] = {"members": members, "rule": rule}
            taken |= {node for one in members for node in ([one] if isinstance(one, str) else one)}
    return {**mapping, "traffic": {**mapping.get("traffic", {}), "zones": zones}}


def one_robot(graph, draw, taken):
    """Return nodes and edges on a random walk, without some of them, and perhaps nodes elsewhere."""
    node = draw.choice(list(graph))
    members = []
    for _ in range(draw.randint(0, 5)):
        following = draw.choice(list(graph[node]) or [node])
        if following != node and draw.random() < 0.8:
            members.append([node, following])
        node = following
    members += [node for node in draw.sample(list(graph), 2) if draw.random() < 0.5]
    inside = {node for one in members for node in ([one] if isinstance(one, str) else one)}
    return [] if inside & taken or len(inside) > len(graph) // 2 else members


def line(graph, draw, taken, contact):
    """Return a walk without loops along two-way lanes of at least 2 D."""
    lanes = nx.Graph(
        (a, b)
        for a, b, data in graph.edges(data=True)
        if data["two_way"] and data["length"] >= 2 * contact and not {a, b} & taken
    )
    if not lanes:
        return []
    walk = [draw.choice(list(lanes))]
    for _ in range(draw.randint(1, 6)):
        further = [node for node in lanes[walk[-1]] if node not in walk]
        if not further:
            break
        walk.append(draw.choice(further))
    return [[a, b] if draw.random() < 0.5 else [b, a] for a, b in pairwise(walk)]
