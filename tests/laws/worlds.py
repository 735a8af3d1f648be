"""Random small warehouses for the laws: strongly connected, one-way, with any number of robots."""

from __future__ import annotations

import math

import networkx as nx
from hypothesis import strategies as st

RADIUS = 0.5


def reals(low, high):
    return st.floats(low, high, allow_nan=False).map(lambda x: round(x, 2))


@st.composite
def block_layouts(draw):
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
def drawn_layouts(draw, graphs):
    """Nodes and edges from `graphs` (with positions), storage at random places on them."""
    graph = draw(graphs)
    positions = {str(n): (float(x), float(y)) for n, (x, y) in graph.nodes(data="at")}
    edges = [(str(a), str(b)) for a, b in graph.edges]
    storage = []
    for _ in range(draw(st.integers(1, 8))):
        a, b = draw(st.sampled_from(edges))
        length = math.dist(positions[a], positions[b])
        storage.append({"edge": [a, b], "offset": round(length * draw(st.floats(0.05, 0.95)), 4)})
    layout = {"nodes": positions, "edges": [list(e) for e in edges], "storage": storage}
    return layout, len(storage)


@st.composite
def rings_with_chords(draw):
    """A one-way ring of nodes on a circle, with chords."""
    n = draw(st.integers(3, 9))
    radius = draw(reals(1, 12))
    graph = nx.DiGraph()
    for i in range(n):
        angle = 2 * math.pi * i / n
        graph.add_node(i, at=(round(radius * math.cos(angle), 3), round(radius * math.sin(angle), 3)))
    nx.add_cycle(graph, range(n))
    for _ in range(draw(st.integers(0, 4))):
        a, b = draw(st.integers(0, n - 1)), draw(st.integers(0, n - 1))
        if a != b and not graph.has_edge(b, a):
            graph.add_edge(a, b)
    return graph


@st.composite
def oriented_grids(draw):
    """A grid of streets of random widths, made one-way at random (Robbins: depth-first, tree down, others up)."""
    wide, high = draw(st.integers(2, 4)), draw(st.integers(2, 4))
    xs, ys = [0.0], [0.0]
    for _ in range(wide - 1):
        xs.append(round(xs[-1] + draw(reals(0.6, 8)), 2))
    for _ in range(high - 1):
        ys.append(round(ys[-1] + draw(reals(0.6, 8)), 2))
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


layouts = st.one_of(block_layouts(), drawn_layouts(rings_with_chords()), drawn_layouts(oriented_grids()))


def node_names(layout):
    if "blocks" in layout:
        from desim_warehouse.layout.naming import block_nodes

        return [name for row in block_nodes(layout["blocks"]["columns"], layout["blocks"]["rows"]) for name in row]
    return list(layout["nodes"])


@st.composite
def models(draw, layouts=layouts, most_robots=40, most_goods=25):
    """A whole model: random fleet, work, stations, bays and batteries on a random layout."""
    layout, places = draw(layouts)
    names = node_names(layout)
    bays = draw(st.lists(st.sampled_from(names), min_size=1, max_size=3, unique=True))
    unload = draw(st.lists(st.sampled_from(names), min_size=1, max_size=3, unique=True))
    size = draw(st.integers(1, most_robots))
    stations = {}
    for i, node in enumerate(unload):
        if draw(st.booleans()):
            stations[f"s{i}"] = {"at": [node], "places": draw(st.integers(1, 4)), "servers": 1}
    kinds = {}
    if size > 1 and draw(st.booleans()):
        kinds = {"other": {"count": 1, "radius": draw(reals(0.2, 0.5)), "speed": draw(reals(0.3, 3))}}
    model = {
        "layout": {**layout, "bays": {"home": {"at": bays}}, "stations": stations},
        "fleet": {
            "size": size,
            "start": bays,
            "robot": {"radius": RADIUS, "speed": 1.0, "margin": draw(st.sampled_from([0.0, 0.2]))},
            "kinds": kinds,
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
    }
    if draw(st.booleans()):
        model["battery"] = {
            "capacity": 2000,
            "threshold": draw(st.integers(50, 600)),  # far enough to get to every good, whatever the traffic
            "consumption": 1,
            "charge_rate": 20,
            "reserve": 1e9,
        }
    return model
