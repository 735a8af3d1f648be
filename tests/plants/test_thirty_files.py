"""Thirty files as other programs write them: nodes, edges, directions and lengths as networkx and ezdxf read them.

GraphML and node-link JSON are as networkx documents and writes them, route graphs as in the documentation of Nav2
(`startid`, `endid`, all edges directed), drawings as ezdxf writes them. Each floor is drawn at random.
"""

import json
import math
import random
from itertools import pairwise

import networkx as nx
import pytest

from desim_warehouse.layout import build
from desim_warehouse.plants import import_layout


def floor(seed, *, directed=True, lengths=None):
    """A strongly connected graph of 8 to 14 points, 6 m apart at least, some with lengths of a given name."""
    draw = random.Random(seed)
    spots = draw.sample([(6 * x, 6 * y) for x in range(5) for y in range(4)], draw.randint(8, 14))
    graph = nx.DiGraph() if directed else nx.Graph()
    for rank, (x, y) in enumerate(spots):
        graph.add_node(f"P{rank}", x=x + draw.randint(0, 2) / 2, y=y + draw.randint(0, 2) / 2)
    ring = list(graph)
    pairs = [*pairwise([*ring, ring[0]]), *(draw.sample(ring, 2) for _ in range(6))]
    for a, b in pairs:
        straight = math.dist(*((graph.nodes[end]["x"], graph.nodes[end]["y"]) for end in (a, b)))
        graph.add_edge(
            a, b, **({} if lengths is None else {lengths: round(straight * draw.choice([1, 1.25]) + 0.01, 2)})
        )
    return graph


def edges_of(graph):
    """Each directed edge with its length, which is the straight one where none is given."""
    lengths = {}
    for a, b, data in graph.edges(data=True):
        straight = math.dist(*((float(graph.nodes[end]["x"]), float(graph.nodes[end]["y"])) for end in (a, b)))
        length = float(data.get("length", data.get("weight", straight)))
        for ends in [(str(a), str(b))] + [(str(b), str(a))] * (not graph.is_directed()):
            lengths[ends] = pytest.approx(length, abs=2e-3)
    return lengths


def ours(path, **options):
    """The edges of the model that a file becomes, with lengths in metres, and its nodes."""
    made = import_layout(path, robots=1, **options)
    graph = build(made.model.layout).graph
    return {(a, b): data["length"] for a, b, data in graph.edges(data=True)}, set(graph)


FORMS = [(directed, lengths) for directed in (True, False) for lengths in (None, "length", "weight")]


@pytest.mark.parametrize(("directed", "lengths"), FORMS)
def test_a_graphml_of_networkx_is_read(tmp_path, directed, lengths):
    path = tmp_path / "plan.graphml"
    nx.write_graphml(floor(f"graphml {directed} {lengths}", directed=directed, lengths=lengths), path)
    theirs = nx.read_graphml(path)
    assert ours(path) == (edges_of(theirs), set(theirs))


@pytest.mark.parametrize("mixed", ["edges say their own direction", "keys have defaults", "nodes have labels"])
def test_a_graphml_written_by_hand_is_read(tmp_path, mixed):
    graph = floor(mixed)
    own = ' directed="true"' if mixed.startswith("edges") else ""
    default = "undirected" if own else "directed"
    speed = '<key id="s" for="edge" attr.name="speed" attr.type="double"><default>1.5</default></key>'
    label = '<key id="l" for="node" attr.name="label" attr.type="string"/>'
    keys = "".join(f'<key id="{axis}" for="node" attr.name="{axis}" attr.type="double"/>' for axis in "xy")
    keys += speed * ("default" in mixed) + label * ("label" in mixed)
    more = '<data key="l">dock</data>' * ("label" in mixed)
    nodes = "".join(
        f'<node id="{name}"><data key="x">{at["x"]}</data><data key="y">{at["y"]}</data>{more}</node>'
        for name, at in graph.nodes(data=True)
    )
    edges = "".join(f'<edge source="{a}" target="{b}"{own}/>' for a, b in graph.edges)
    path = tmp_path / "plan.graphml"
    head = '<?xml version="1.0" encoding="UTF-8"?><graphml xmlns="http://graphml.graphdrawing.org/xmlns">'
    path.write_text(f'{head}{keys}<graph id="G" edgedefault="{default}">{nodes}{edges}</graph></graphml>')
    assert ours(path) == (edges_of(graph), set(graph))


@pytest.mark.parametrize("key", ["links", "edges"])
@pytest.mark.parametrize(("directed", "lengths"), FORMS)
def test_a_graph_in_node_link_json(tmp_path, directed, lengths, key):
    data = nx.node_link_data(floor(f"{key} {directed} {lengths}", directed=directed, lengths=lengths), edges=key)
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(data))
    theirs = nx.node_link_graph(json.loads(path.read_text()), edges=key)
    assert ours(path) == (edges_of(theirs), set(theirs))


def route_graph(graph, *, both, bent, crs):
    """A route graph of Nav2: points with ids, and lines from `startid` to `endid`; `both`: each there and back."""
    numbers = {name: rank for rank, name in enumerate(graph)}
    at = {name: [data["x"], data["y"]] for name, data in graph.nodes(data=True)}
    features = [
        {
            "type": "Feature",
            "properties": {"id": number, "frame": "map"},
            "geometry": {"type": "Point", "coordinates": at[name]},
        }
        for name, number in numbers.items()
    ]
    pairs = [*graph.edges, *((b, a) for a, b in graph.edges if both and not graph.has_edge(b, a))]
    for rank, (a, b) in enumerate(pairs, len(numbers)):
        spots = [at[a], [at[a][0], at[b][1]], at[b]] if bent else [at[a], at[b]]
        geometry = {"type": "MultiLineString", "coordinates": [spots]}
        ends = {"id": rank, "startid": numbers[a], "endid": numbers[b]}
        features.append({"type": "Feature", "properties": ends, "geometry": geometry})
    about = {"crs": {"type": "name", "properties": {"name": crs}}} if crs else {}
    return {"type": "FeatureCollection", "name": "graph", **about, "features": features}


def read_route_graph(content):
    graph = nx.DiGraph()
    for one in content["features"]:
        properties, spots = one["properties"], one["geometry"]["coordinates"]
        if one["geometry"]["type"] == "Point":
            graph.add_node(str(properties["id"]), x=spots[0], y=spots[1])
        else:
            length = sum(math.dist(*pair) for pair in pairwise(spots[0]))
            graph.add_edge(str(properties["startid"]), str(properties["endid"]), length=length)
    return graph


@pytest.mark.parametrize(
    ("both", "bent", "crs"),
    [
        (False, False, None),
        (True, False, None),
        (False, True, None),
        (False, False, "urn:ogc:def:crs:EPSG::3857"),
        (True, True, "urn:ogc:def:crs:EPSG::3857"),
    ],
)
def test_a_route_graph_of_nav2(tmp_path, both, bent, crs):
    path = tmp_path / "plan.geojson"
    path.write_text(json.dumps(route_graph(floor(f"nav2 {both} {bent} {crs}"), both=both, bent=bent, crs=crs)))
    theirs = read_route_graph(json.loads(path.read_text()))
    assert ours(path) == (edges_of(theirs), set(theirs))


def lines_of(entities):
    """The straight pieces of a drawing, whatever block they are inside, as ezdxf takes blocks apart."""
    for entity in entities:
        if entity.dxftype() == "INSERT":
            yield from lines_of(entity.virtual_entities())
        elif entity.dxftype() == "LWPOLYLINE":
            yield from pairwise([(x, y) for x, y in entity.get_points("xy")])
        else:
            yield (entity.dxf.start.x, entity.dxf.start.y), (entity.dxf.end.x, entity.dxf.end.y)


def comb(shape):
    """A main aisle of 24 m with four spurs, drawn at some place."""
    shape.add_line((0, 0), (24, 0))
    for rank in range(4):
        shape.add_lwpolyline([(6 + 6 * rank, 0), (6 + 6 * rank, 4 + rank)])


def in_a_block(document, **how):
    comb(document.blocks.new("FLOOR"))
    document.modelspace().add_blockref("FLOOR", (5, 7), dxfattribs=how)


def in_blocks_of_blocks(document):
    comb(document.blocks.new("AISLE"))
    outer = document.blocks.new("FLOOR")
    outer.add_blockref("AISLE", (0, 0))
    outer.add_line((0, 0), (0, 20))
    outer.add_blockref("AISLE", (0, 20))
    document.modelspace().add_blockref("FLOOR", (3, 3), dxfattribs={"rotation": 30})


DRAWINGS = {
    "lines and polylines": lambda document: comb(document.modelspace()),
    "a block": in_a_block,
    "a block that is turned and twice as large": lambda document: in_a_block(document, rotation=90, xscale=2, yscale=2),
    "blocks inside a block": in_blocks_of_blocks,
}


@pytest.mark.parametrize("name", DRAWINGS)
def test_a_drawing_of_ezdxf_is_read(tmp_path, name):
    ezdxf = pytest.importorskip("ezdxf", reason="ezdxf, the extra dxf, is not installed")
    document = ezdxf.new(units=6)
    DRAWINGS[name](document)
    path = tmp_path / "plan.dxf"
    document.saveas(path)
    drawn = [*lines_of(ezdxf.readfile(path).modelspace())]
    total = sum(math.dist(*ends) for ends in drawn)
    edges, nodes = ours(path)
    graph = nx.Graph(list(edges))
    assert sum(edges.values()) == pytest.approx(2 * total, abs=0.01)  # both ways
    assert all(edges[a, b] == edges[b, a] for a, b in edges)
    spots = {(round(x, 3), round(y, 3)) for ends in drawn for x, y in ends}
    assert (len(nodes), nx.is_connected(graph), graph.number_of_edges()) == (len(spots), True, len(spots) - 1)
