"""Random small warehouses for the laws: strongly connected, one-way, with any number of robots.

Lengths are often one, two or three times D, or a little off, where one rule of traffic takes over from another.
"""

from __future__ import annotations

import math
from typing import get_args

import networkx as nx
from hypothesis import strategies as st

from desim_warehouse.findings import Acceptable

RADIUS = 0.5
SPEEDS = [0.2, 0.5, 0.7, 1.0, 1.3, 3.0]


def reals(low, high):
    return st.floats(low, high, allow_nan=False).map(lambda x: round(x, 2))


def lengths(contact, low, high):
    """Any length, or one about a multiple of D."""
    off = st.sampled_from([0.0, 1e-9, 1e-7, 1e-6, 3e-6, 1e-5, 0.05]).flatmap(
        lambda x: st.sampled_from([x, -x])
    ) | st.just(0.4)
    return reals(low, high) | st.builds(lambda times, more: times * contact + more, st.integers(1, 3), off)


@st.composite
def block_layouts(draw, contact):
    """Block grids of every proportion: aisles from shorter than D to many D long."""
    columns, rows = draw(st.integers(1, 4)), draw(st.integers(1, 3))
    blocks = {
        "columns": columns,
        "rows": rows,
        "block_width": draw(st.integers(1, 2)),
        "block_depth": draw(st.integers(1, 5)),
        "goods_size": draw(reals(0.4, 3)),
        "aisle_width": draw(reals(0.2, 3)),
        "directions": "ring",
    }
    return {"blocks": blocks}, columns * rows * blocks["block_width"] * blocks["block_depth"]


@st.composite
def drawn_layouts(draw, graphs, contact):
    """Nodes and edges from `graphs` (with positions), storage at random places on them, speed limits on some."""
    graph = draw(graphs)
    positions = {str(n): (float(x), float(y)) for n, (x, y) in graph.nodes(data="at")}
    edges = [(str(a), str(b)) for a, b in graph.edges]
    storage = []
    for _ in range(draw(st.integers(1, 8))):
        a, b = draw(st.sampled_from(edges))
        length = math.dist(positions[a], positions[b])
        offset = round(length * draw(st.floats(0.05, 0.95)), 4) or length / 2
        exact = [place for place in (contact, length - contact) if 1e-6 < place < length]
        storage.append({"edge": [a, b], "offset": draw(st.sampled_from([offset, *exact]))})
    limits = draw(st.dictionaries(st.sampled_from(edges), st.sampled_from([0.1, 0.4, 0.8, 2.0]), max_size=5))
    lanes = [{"from": a, "to": b, "speed": limits.get((a, b))} for a, b in edges]
    return {"nodes": positions, "edges": lanes, "storage": storage}, len(storage)


@st.composite
def rings_with_chords(draw, contact):
    """A one-way ring of nodes on a circle, with chords."""
    n = draw(st.integers(3, 9))
    radius = draw(lengths(contact, 0.5, 8)) / (2 * math.sin(math.pi / n))
    graph = nx.DiGraph()
    for i in range(n):
        angle = 2 * math.pi * i / n
        graph.add_node(i, at=(radius * math.cos(angle), radius * math.sin(angle)))
    nx.add_cycle(graph, range(n))
    for _ in range(draw(st.integers(0, 4))):
        a, b = draw(st.integers(0, n - 1)), draw(st.integers(0, n - 1))
        if a != b and not graph.has_edge(b, a):
            graph.add_edge(a, b)
    return graph


@st.composite
def oriented_grids(draw, contact):
    """A grid of streets of random widths, made one-way at random (Robbins: depth-first, tree down, others up)."""
    wide, high = draw(st.integers(2, 4)), draw(st.integers(2, 4))
    xs, ys = [0.0], [0.0]
    for _ in range(wide - 1):
        xs.append(xs[-1] + draw(lengths(contact, 0.6, 8)))
    for _ in range(high - 1):
        ys.append(ys[-1] + draw(lengths(contact, 0.6, 8)))
    streets = nx.grid_2d_graph(wide, high)
    order = {node: i for i, node in enumerate(draw(st.permutations(sorted(streets))))}
    depth, graph = {}, nx.DiGraph()

    def visit(node, parent):
        depth[node] = len(depth)
        for other in sorted(streets[node], key=order.get):
            if other not in depth:
                graph.add_edge(node, other)
                visit(other, node)
            elif other != parent and depth[other] < depth[node]:
                graph.add_edge(node, other)

    visit(min(order, key=order.get), None)
    for x, y in graph:
        graph.nodes[x, y]["at"] = (xs[x], ys[y])
    return nx.relabel_nodes(graph, {(x, y): f"{x}.{y}" for x, y in graph})


def layouts(contact):
    return st.one_of(
        block_layouts(contact),
        drawn_layouts(rings_with_chords(contact), contact),
        drawn_layouts(oriented_grids(contact), contact),
    )


def node_names(layout):
    if "blocks" in layout:
        from desim_warehouse.layout.naming import block_nodes

        return [name for row in block_nodes(layout["blocks"]["columns"], layout["blocks"]["rows"]) for name in row]
    return list(layout["nodes"])


def nodes(names, most=3):
    return st.lists(st.sampled_from(names), min_size=1, max_size=most, unique=True)


@st.composite
def bays(draw, names, size):
    """Where robots start, and perhaps a spare bay; as many places as robots, or few more than needed."""
    start = draw(nodes(names))
    found = {"home": {"at": start}}
    if draw(st.booleans()):
        found["home"]["places"] = -(-size // len(start)) + draw(st.integers(0, 2))
        spare = [name for name in names if name not in start]
        if spare and draw(st.booleans()):
            found["spare"] = {"at": [draw(st.sampled_from(spare))], "places": 1, "chargers": draw(st.integers(0, 1))}
    return start, found


@st.composite
def kinds(draw, size):
    """Robots of up to four speeds."""
    found, left = {}, size - 1
    for rank in range(draw(st.integers(0, 3))):
        if left:
            count = draw(st.integers(1, left))
            speed, radius = draw(st.sampled_from(SPEEDS) | reals(0.3, 3)), draw(st.sampled_from([0.5, 0.3]))
            found[f"kind{rank}"] = {"count": count, "radius": radius, "speed": speed}
            left -= count
    return found


@st.composite
def batteries(draw):
    """With little to spare robots are called home on the way, by their level or because they wait too long."""
    if draw(st.booleans()):
        return None, "threshold"
    battery = {"capacity": 2000.0, "threshold": 0.0, "consumption": 1, "charge_rate": 20, "reserve": 1e9}
    if draw(st.booleans()):
        return battery, {"name": "reach-aware", "margin": draw(reals(0.1, 0.6))}
    battery["threshold"] = 2000.0 - draw(st.integers(50, 400))  # as a rule far enough to get to every good
    return battery, "threshold"


@st.composite
def routing(draw):
    """A fixed way, or other ways for robots that are held up."""
    detours = draw(st.integers(0, 4))
    if draw(st.booleans()) or not detours:
        return "highways"
    if draw(st.booleans()):
        return {"name": "congestion-aware", "detours": detours, "queues": 3.0}
    return {"name": "tests.laws.wanderer:Wanderer", "seed": draw(st.integers(0, 9)), "detours": detours}


@st.composite
def models(draw, layouts=layouts, most_robots=40, most_goods=25):
    """A whole model: random fleet, work, stations, bays, batteries and policies on a random layout."""
    margin = draw(st.sampled_from([0.0, 0.2, 1.0]))
    layout, places = draw(layouts(2 * RADIUS + margin))
    names = node_names(layout)
    size = draw(st.integers(1, most_robots))
    start, homes = draw(bays(names, size))
    unload = draw(nodes(names))
    stations = {
        f"s{i}": {"at": [node], "places": draw(st.integers(1, 4)), "servers": 1}
        for i, node in enumerate(unload)
        if draw(st.booleans())
    }
    battery, charging = draw(batteries())
    return {
        "layout": {**layout, "bays": homes, "stations": stations},
        "fleet": {
            "size": size,
            "start": start,
            "robot": {"radius": RADIUS, "speed": 1.0, "margin": margin},
            "kinds": draw(kinds(size)),
            "exit_time": draw(st.sampled_from([0.0, 1.5])),
        },
        "tasks": {
            "goods": [draw(st.integers(0, places - 1)) for _ in range(draw(st.integers(1, most_goods)))],
            "unload_at": [unload[i % len(unload)] for i in range(size)] if len(unload) > 1 else unload,
            "load_time": draw(st.sampled_from([0.0, 2.0])),
            "unload_time": draw(st.sampled_from([0.0, 3.0])),
            "clear_time": draw(st.sampled_from([0.0, 1.0])),
        },
        "traffic": {
            "collision_angle": draw(st.sampled_from([0, 30, 45, 60, 90])),
            "node_time": draw(st.sampled_from([0.0, 0.4])),
        },
        "battery": battery,
        "policies": {
            "routing": draw(routing()),
            "charging": charging,
            "parking": draw(st.sampled_from(["home", "stay", "nearest", "spread"])),
        },
        "accept": list(get_args(Acceptable)),  # narrow aisles and small batteries are drawn on purpose
    }
