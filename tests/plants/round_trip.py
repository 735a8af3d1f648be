"""Models drawn at random, and what of a model a format of layouts can carry."""

import math

from hypothesis import strategies as st

import desim_warehouse as dw
from desim_warehouse.layout import build

FORMATS = {
    "csv": "out",
    "graphml": "out.graphml",
    "opentcs": "out.xml",
    "lif": "out.lif.json",
    "rmf": "out.building.yaml",
}
"""What is written and read again, by the name of the file."""
STRAIGHT = {"lif", "rmf"}
"""Formats without lengths, and with levels."""
NAMES = st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), min_size=1, max_size=4)
MM = st.integers(-40_000, 40_000).map(lambda number: number / 1000)
LENGTH = st.none() | st.integers(500, 90_000).map(lambda number: number / 1000)
SPEED = st.none() | st.integers(100, 3000).map(lambda number: number / 1000)


@st.composite
def models(draw, *, in_lanes=False):
    """A one-way ring with lanes across of all kinds, storage, stations, chargers, parking, zones, kinds of robots."""
    names = draw(st.lists(NAMES, min_size=3, max_size=8, unique=True))
    nodes = [f"n{name}" for name in names]
    places = draw(st.lists(st.tuples(MM, MM), min_size=len(nodes), max_size=len(nodes), unique=True))
    edges = [{"from": a, "to": b, **limits(draw)} for a, b in zip(nodes, [*nodes[1:], nodes[0]], strict=True)]
    across = [(a, b) for i, a in enumerate(nodes) for b in nodes[i + 2 :] if (a, b) != (nodes[0], nodes[-1])]
    for a, b in draw(st.lists(st.sampled_from(across), unique=True, max_size=5)) if across else []:
        kind = draw(st.sampled_from(["one-way", "two-way", "side by side"]))
        there = {"from": a, "to": b, **limits(draw)}
        if kind == "side by side":
            edges += [{**there, "side_by_side": True}, {"from": b, "to": a, **limits(draw)}]
        else:
            edges.append({**there, "two_way": kind == "two-way"})
            if kind == "two-way":
                edges[-1]["speed_back"] = draw(SPEED)
    some = st.lists(st.sampled_from(nodes), unique=True, min_size=1, max_size=3)
    storage = [{"node": node} for node in draw(some)]
    if in_lanes:
        long = [one for one in edges if one["length"] is not None]
        picked = draw(st.lists(st.sampled_from(long), max_size=4)) if long else []
        storage += [{"edge": [one["from"], one["to"]], "offset": 0.25} for one in picked]
    bays = draw(some)
    at, rest = draw(some), draw(st.lists(st.sampled_from(nodes), unique=True, max_size=2))
    two = {"s1": {"at": at}, 's2, "x" & <y>': {"at": [node for node in rest if node not in at]}}
    chargers = draw(st.integers(0, len(bays)))
    size = draw(st.integers(1, 4))
    return dw.load(
        {
            "name": draw(NAMES),
            "layout": {
                "nodes": dict(zip(nodes, map(list, places), strict=True)),
                "edges": [{key: value for key, value in edge.items() if value is not None} for edge in edges],
                "storage": storage,
                "stations": {name: station for name, station in two.items() if station["at"]},
                "bays": {
                    name: {"at": there, "places": 4, "chargers": count}
                    for name, there, count in (("plug", bays[:chargers], 1), ("park", bays[chargers:], 0))
                    if there
                },
            },
            "fleet": {
                "size": size,
                "robot": {"radius": draw(st.integers(100, 900)) / 1000, "speed": draw(st.integers(100, 3000)) / 1000},
                "kinds": {"tug": {"count": draw(st.integers(1, size)), "radius": 0.75, "speed": 2.5}},
            },
            "tasks": {
                "goods": {"random": 2},
                "unload_at": ["s1"],
                "station_choice": "random",
                "load_time": 1,
                "unload_time": 1,
            },
            "battery": {"capacity": 50, "threshold": 10, "consumption": 0.01, "charge_rate": 0.1},
            "traffic": {"zones": {"zone": {"members": [nodes[0], [nodes[1], nodes[2]]], "rule": "one-robot"}}},
        }
    )


def limits(draw):
    return {"length": draw(LENGTH), "speed": draw(SPEED)}


def carried(model, form):
    """What a format can carry of a model whose storage places are at nodes: plain values to compare."""
    layout = build(model.layout)
    graph, fastest = layout.graph, max(robot.speed for robot in model.fleet.robots())
    joined = set() if form in {"csv", "graphml"} else side_by_side(graph, form)
    content = {
        "name": None if form == "csv" else model.name,
        "nodes": {
            name: (round(at["x"], 3), round(at["y"], 3))
            for name, at in graph.nodes(data=True)
            if graph.degree(name) or form != "rmf"
        },
        "lanes": {
            edge: (
                round(straight(graph, edge) if form in STRAIGHT or edge in layout.rides else data["length"], 2),
                fastest if form == "opentcs" and math.isinf(data["speed"]) else data["speed"],
                data["two_way"] or edge in layout.rides,
            )
            for edge, data in graph.edges.items()
            if edge not in joined and (edge not in layout.rides or form not in STRAIGHT)
        },
        "lifts": {lift.name: lift.nodes for lift in layout.lifts} if form in STRAIGHT else {},
        "joined": joined,
        "loads": {place.edge[0] for place in layout.storage},
        "stations": {
            f"{name} (2)" if form == "opentcs" and name in graph else name: set(item.at)  # where all names differ
            for name, item in model.layout.stations.items()
        },
        "chargers": {bay.node for bay in layout.bays.values() if bay.chargers},
        "parking": {bay.node for bay in layout.bays.values() if not bay.chargers},
    }
    if form == "opentcs":
        content["fleet"] = sorted((round(robot.radius, 4), robot.speed) for robot in model.fleet.robots())
        battery = model.battery if content["chargers"] else None  # without chargers robots never need charging
        content["threshold"] = battery and battery.threshold / battery.capacity
        content["zones"] = {
            (frozenset(one if isinstance(one, str) else frozenset(one) for one in zone.members), zone.rule)
            for zone in model.traffic.zones.values()
        }
    return content


def side_by_side(graph, form):
    """Lanes beside one back that are taken for one two-way lane by readers: where their lengths are alike, or lost."""
    lanes = set()
    for a, b in graph.edges:
        if (b, a) in graph.edges and not graph.edges[a, b]["two_way"] and "takes" not in graph.edges[a, b]:
            lengths = [graph.edges[edge]["length"] for edge in ((a, b), (b, a))]
            if form in STRAIGHT or max(lengths) - min(lengths) <= 0.05 * max(lengths) + 0.002:
                lanes |= {(a, b), (b, a)}
    return lanes


def straight(graph, edge):
    a, b = (graph.nodes[end] for end in edge)
    return math.dist((a["x"], a["y"]), (b["x"], b["y"]))
