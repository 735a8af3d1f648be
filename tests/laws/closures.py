"""Random closures, slow zones and people for random models."""

import random

import networkx as nx

import desim_warehouse as dw
from desim_warehouse.layout import build
from desim_warehouse.layout.zones import edges_inside, zones_on
from tests.laws.random_models import lasting
from tests.laws.wider import refused

SPANS = (3.0, 20.0, 60.0, 200.0)
"""Durations of closures and visits, from less than the time for an edge to more than the time for a task."""


def with_closures(mapping, seed):
    """Return the model with closures, slow zones and people."""
    draw = random.Random(f"closures {seed}")
    model = dw.load(mapping)
    layout = build(model.layout)
    inside = edges_inside(layout, model.fleet.contact, zones_on(layout, model.traffic.zones))
    free = [edge for edge in layout.graph.edges if edge not in inside and edge[::-1] not in inside]
    if not free:
        return mapping
    calendars, closures, slow, people = dict(mapping.get("calendars", {})), {}, {}, {}
    for number in range(draw.randint(0, 3)):
        calendars[f"c{number}"] = calendar(draw)
        closures[f"c{number}"] = {"members": members(layout.graph, draw, free, inside), "hours": f"c{number}"}
        closures[f"c{number}"]["tasks"] = draw.choice(("hold", "hold", "go"))
    for number in range(draw.randint(0, 2)):
        calendars[f"s{number}"] = calendar(draw)
        slow[f"s{number}"] = {
            "members": [list(edge) for edge in some(draw, free)],
            "speed": draw.choice((0.1, 0.4, 0.8)),
        }
        if draw.random() < 0.6:
            slow[f"s{number}"]["hours"] = f"s{number}"
    for number in range(draw.randint(0, 2)):
        stay = draw.choice(SPANS)
        people[f"p{number}"] = {
            "stay": draw.choice((stay, {"exponential": stay})),
            "aisles": [line(layout.graph, draw, free) for _ in range(draw.randint(1, 4))],
        }
        people[f"p{number}"] |= draw.choice(
            (
                {"per_hour": 3600 / draw.uniform(stay, 10 * stay)},
                {"times": sorted(draw.uniform(0, 500) for _ in range(5))},
            )
        )
        if number == 0 and random.Random(f"give way {seed}").random() < 0.4:
            people["p0"]["give_way"] = {"after": 0.3 * stay}
        if draw.random() < 0.3 and any(place.edge in free for place in layout.storage):
            del people[f"p{number}"]["aisles"]
    traffic = {**mapping.get("traffic", {}), "closures": closures, "slow": slow}
    made = {**mapping, "calendars": calendars, "traffic": traffic, "people": people}
    made["battery"] = lasting(mapping["battery"], 20)  # for waits that no estimate includes
    return {**made, "traffic": {**traffic, "closures": {}}} if refused(made, "CUT_OFF") else made


def calendar(draw):
    """Return a random calendar: a periodic closure, shorter than the opening, or three stretches."""
    lasts = draw.choice(SPANS)
    if draw.random() < 0.7:
        return {
            "every": lasts * draw.uniform(1.5, 6),
            "lasts": lasts,
            "first": draw.choice((0.0, draw.uniform(0, 300))),
        }
    begins = sorted(draw.uniform(0, 1000) for _ in range(3))
    return {"between": [[begin, begin + lasts] for begin in begins]}


def some(draw, edges):
    return draw.sample(edges, min(len(edges), draw.randint(1, 3)))


def members(graph, draw, free, inside):
    """Return some edges, or a node of which all incoming edges can close."""
    nodes = [node for node in graph if not any(edge in inside for edge in graph.in_edges(node))]
    if nodes and draw.random() < 0.3:
        return [draw.choice(nodes)]
    return [list(edge) for edge in some(draw, free)]


def line(graph, draw, free):
    """Return the nodes along one to three edges in a line."""
    of = nx.Graph(free)
    walk = list(draw.choice(free))
    while len(walk) < 4 and draw.random() < 0.5:
        further = [node for node in of[walk[-1]] if node not in walk]
        if not further:
            break
        walk.append(draw.choice(further))
    return walk
