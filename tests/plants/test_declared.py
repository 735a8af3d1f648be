"""What files say themselves comes first: ends of lines, projections, weights, lines in blocks; lengths by hand."""

import json
import math

import pytest

import desim_warehouse as dw
from desim_warehouse.layout import build
from desim_warehouse.plants import import_layout, read_plant
from desim_warehouse.values.fields import LIMITS
from tests.plants.drawings import node_link

SQUARE = {0: [0, 0], 1: [20, 0], 2: [20, 12], 3: [0, 12]}
"""Corners of a floor of 20 x 12 m, y upwards."""
LOOP = [(0, 1), (1, 2), (2, 3), (3, 0)]
MERCATOR = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3857"}}


def point(number, at, **properties):
    return {
        "type": "Feature",
        "properties": {"id": number, **properties},
        "geometry": {"type": "Point", "coordinates": at},
    }


def line(ends, spots=None, words=("startid", "endid"), **properties):
    geometry = None if spots is None else {"type": "MultiLineString", "coordinates": [spots]}
    return {
        "type": "Feature",
        "properties": {**dict(zip(words, ends, strict=True)), **properties},
        "geometry": geometry,
    }


def written(folder, features, **more):
    path = folder / "plan.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features, **more}))
    return path


def route_graph(folder, edges=LOOP, corners=SQUARE, words=("startid", "endid"), **more):
    lines = [line(pair, [corners[end] for end in pair], words) for pair in edges]
    return written(folder, [*(point(number, at) for number, at in corners.items()), *lines], **more)


def edges_of(made):
    """Each directed edge with its length."""
    graph = build(made.model.layout).graph
    return {(a, b): round(data["length"], 3) for a, b, data in graph.edges(data=True)}


def left_out(made):
    return {name for remark in made.remarks if remark.what == "left out" for name in remark.names}


def test_a_route_graph_of_nav2_has_one_way_lanes(tmp_path):
    made = import_layout(route_graph(tmp_path, crs=MERCATOR), robots=4)
    assert edges_of(made) == {("0", "1"): 20, ("1", "2"): 12, ("2", "3"): 20, ("3", "0"): 12}
    assert not made.model.layout.bays["parking"].in_lane
    assert not left_out(made)
    assert made.in_short().startswith("4 nodes, 4 edges, 20 x 12 m, ")


def test_its_edges_meet_at_nodes_only(tmp_path):
    made = import_layout(route_graph(tmp_path, [*LOOP, (0, 2), (1, 3)]), robots=1)
    assert set(edges_of(made)) == {(str(a), str(b)) for a, b in [*LOOP, (0, 2), (1, 3)]}
    assert edges_of(made)["0", "2"] == pytest.approx(math.hypot(20, 12), abs=1e-3)


def test_the_point_that_bears_the_id_is_the_end_and_not_the_nearest(tmp_path):
    lines = [line((0, 1), [[0, 0], [18, 0]]), *(line(pair) for pair in LOOP[1:])]  # it ends 2 m off, others nowhere
    made = import_layout(written(tmp_path, [*(point(*one) for one in SQUARE.items()), *lines]), robots=1)
    assert edges_of(made) == {("0", "1"): 20, ("1", "2"): 12, ("2", "3"): 20, ("3", "0"): 12}


def test_lengths_corners_speeds_and_both_directions_of_edges_are_read(tmp_path):
    lines = [
        line((0, 1), [[0, 0], [10, 6], [20, 0]], speed=0.5),
        line((1, 2), length=15),
        line((2, 3), two_way=True),
        line((3, 0), oneway="no", cost=3),
    ]
    nodes = [point(0, SQUARE[0], role="load", frame="map"), *(point(number, SQUARE[number]) for number in (1, 2, 3))]
    made = import_layout(written(tmp_path, [*nodes, *lines]), robots=1)
    bent = round(2 * math.hypot(10, 6), 3)
    assert edges_of(made) == {
        ("0", "1"): bent,
        ("1", "2"): 15,
        ("2", "3"): 20,
        ("3", "2"): 20,
        ("3", "0"): 12,
        ("0", "3"): 12,
    }
    assert made.model.layout.edges[0].speed == 0.5
    assert {"cost", "frame"} <= left_out(made)


@pytest.mark.parametrize("words", [("from", "to"), ("source", "target"), ("start_id", "end_id"), ("From", "To")])
def test_other_words_for_the_ends_are_understood_where_they_name_points(tmp_path, words):
    assert len(edges_of(import_layout(route_graph(tmp_path, words=words), robots=1))) == 4


def test_lines_from_street_to_street_are_a_drawing(tmp_path):
    lines = [line(("Main Street", "Dock"), [SQUARE[a], SQUARE[b]], ("from", "to")) for a, b in [*LOOP, (0, 2), (1, 3)]]
    made = import_layout(written(tmp_path, lines), robots=1)
    assert len(edges_of(made)) == 16  # two-way, and joined where they cross
    assert {"from", "to"} <= left_out(made)


@pytest.mark.parametrize(
    ("features", "message"),
    [
        ([*map(point, SQUARE, SQUARE.values()), line((0, 9))], "endid: no such node (got '9'), expected the name of a"),
        ([point(None, [0, 0]), line((0, 1))], "features[0]: id: empty, expected a name"),
        ([point(0, [0, 0]), point(0, [1, 0]), line((0, 1))], "a node of this name stands before (got '0')"),
        ([point(0, [0, 0]), point(1, [1, "x"]), line((0, 1))], "features[1].geometry.coordinates: not a position"),
        ([point(0, [0, 0]), point(1, [9, 0]), line((0, 1), length=-3)], "length: not above 0 (got -3)"),
        ([point(0, [0, 0]), point(1, [9, 0]), line((0, None))], "endid: empty, expected a name"),
    ],
)
def test_what_is_wrong_with_a_route_graph_is_said_with_its_place(tmp_path, features, message):
    with pytest.raises(dw.ModelError) as refused:
        import_layout(written(tmp_path, features))
    assert message in str(refused.value)
    assert len(refused.value.problems) == 1


@pytest.mark.parametrize("latitude", [0.0, 30.0, 47.07, -60.0])
@pytest.mark.parametrize("name", ["EPSG:3857", "urn:ogc:def:crs:EPSG::900913"])
def test_web_mercator_is_as_long_as_it_is_on_the_ground(tmp_path, latitude, name):
    radius, east = 6_378_137.0, 1_700_000.0
    north = radius * math.asinh(math.tan(math.radians(latitude)))
    stretch = 1 / math.cos(math.radians(latitude))
    corners = {number: [east + x * stretch, north + y * stretch] for number, (x, y) in SQUARE.items()}
    spots = [corners[number] for number in (0, 1, 2, 3, 0)]
    drawing = {"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": spots}}
    made = import_layout(written(tmp_path, [drawing], crs={"type": "name", "properties": {"name": name}}), robots=1)
    lengths = sorted(edges_of(made).values())
    assert lengths == pytest.approx([12] * 4 + [20] * 4, rel=1e-4)
    assert ", 20 x 12 m, " in made.in_short()


def test_a_crs_of_degrees_beside_metres_is_doubtful(tmp_path):
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
    made = import_layout(route_graph(tmp_path, crs=crs), robots=1)
    assert [remark.kind for remark in made.remarks if remark.what == "doubtful"] == ["crs"]
    assert edges_of(made)["0", "1"] == 20


def graph(folder, links, directed=True, key="links", **more):
    nodes = [{"id": number, "pos": at} for number, at in SQUARE.items()]
    ends = [{"source": a, "target": b, **about} for a, b, about in links]
    path = folder / "graph.json"
    path.write_text(json.dumps({"directed": directed, "multigraph": False, "nodes": nodes, key: ends, **more}))
    return path


def test_a_graph_in_json_is_the_one_that_networkx_reads(tmp_path):
    networkx = pytest.importorskip("networkx")
    path = node_link(tmp_path)
    theirs = networkx.node_link_graph(json.loads(path.read_text()), edges="links")
    lengths = {(str(a), str(b)): round(data["weight"], 3) for a, b, data in theirs.edges(data=True)}
    assert edges_of(import_layout(path, robots=1)) == lengths


def test_weights_are_lengths_where_they_can_be(tmp_path):
    links = [(a, b, {"weight": weight}) for (a, b), weight in zip(LOOP, (25, 12, 20, 12), strict=True)]
    made = import_layout(graph(tmp_path, links), robots=1)
    assert list(edges_of(made).values()) == [25, 12, 20, 12]
    assert "assumed: layout.edges: their 'weight' is the length in metres" in map(str, made.remarks)
    both = import_layout(graph(tmp_path, [(a, b, {**about, "length": 30}) for a, b, about in links]), robots=1)
    assert set(edges_of(both).values()) == {30}
    assert "weight" in left_out(both)


@pytest.mark.parametrize("weight", [1, "far", None, [1], -25, math.inf])
def test_a_weight_that_is_no_length_is_left_out_with_the_reason(tmp_path, weight):
    links = [(a, b, {"weight": 25 if a else weight}) for a, b in LOOP]
    path = graph(tmp_path, links)
    path.write_text(path.read_text().replace("Infinity", "1e999"))
    made = import_layout(path, robots=1)
    assert list(edges_of(made).values()) == [20, 12, 20, 12]
    assert any("no lengths, as one at least is missing or shorter" in remark.why for remark in made.remarks)


def test_a_graph_without_direction_has_two_way_lanes_and_edges_may_be_called_so(tmp_path):
    plant = read_plant(graph(tmp_path, [(a, b, {}) for a, b in LOOP], directed=False, key="edges", made="by hand"))
    assert all(link.speed_back for link in plant.links)
    assert any("made" in remark.names for remark in plant.remarks)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"nodes": 3}, "nodes: not a list (got 3), expected a graph (JSON)"),
        ({"links": None}, "links: not a list (got nothing)"),
        ({"nodes": [1]}, "nodes[0]: not an object (got 1), expected a graph (JSON)"),
        ({"directed": "yes"}, "directed: neither true nor false (got 'yes')"),
        ({"links": [{"source": 0, "target": 7}]}, "links[0]: to_node: no such node (got '7')"),
        ({"links": [{"source": 0}]}, "links[0]: no 'target' (it has 'source'), expected it, as in networkx"),
        ({"nodes": [{"id": 0, "x": "left", "y": 1}]}, "nodes[0]: x: "),
        ({"nodes": [{"x": 1, "y": 1}]}, "nodes[0]: no 'id' (it has 'x', 'y'), expected it, as in networkx"),
    ],
)
def test_a_damaged_graph_in_json_is_one_message(tmp_path, change, message):
    path = graph(tmp_path, [(a, b, {}) for a, b in LOOP])
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(dw.ModelError) as refused:
        import_layout(path)
    assert message in str(refused.value)
    assert len(refused.value.problems) == 1


@pytest.mark.parametrize("first", ["directed", "graph", "nodes", "links"])
def test_keys_of_a_graph_in_json_stand_in_any_order(tmp_path, first):
    path = graph(tmp_path, [(a, b, {}) for a, b in LOOP])
    content = json.loads(path.read_text()) | {"graph": {}}
    path.write_text(json.dumps({first: content[first], **content}))
    assert len(read_plant(path).links) == 4


@pytest.mark.parametrize("form", [list, str, lambda at: [*at, 0.0], lambda at: f"{at[0]:.1f}, {at[1]:.1f}, 0.0"])
def test_positions_may_have_a_height_or_be_text(tmp_path, form):
    """GraphML has no lists, so that people write `str` of a position."""
    path = graph(tmp_path, [(a, b, {}) for a, b in LOOP])
    content = json.loads(path.read_text())
    content["nodes"] = [{"id": one["id"], "pos": form(tuple(one["pos"]))} for one in content["nodes"]]
    plain = read_plant(path).points
    path.write_text(json.dumps(content))
    assert [(one.x, one.y) for one in read_plant(path).points.values()] == [(one.x, one.y) for one in plain.values()]


def in_a_block(folder, layer="AGV lanes", deep=1, beside=(), scale=1.0):
    """The loop in a block that is inserted once, perhaps in others."""
    ezdxf = pytest.importorskip("ezdxf", reason="ezdxf, the extra dxf, is not installed")
    document = ezdxf.new(units=6)
    space = document.modelspace()
    block = document.blocks.new("FLOOR")
    for a, b in LOOP:
        block.add_line(SQUARE[a], SQUARE[b], dxfattribs={"layer": layer})
    for number in range(deep - 1):
        outer = document.blocks.new(f"FLOOR {number}")
        outer.add_blockref(block.name, (1, 1))
        block = outer
    space.add_blockref(block.name, (0, 0), dxfattribs={"xscale": scale, "yscale": scale, "layer": "inserted"})
    for a, b in beside:
        space.add_line(a, b, dxfattribs={"layer": "Walls"})
    for work, x, y in (("load", 20, 6), ("unload", 0, 6), ("park", 10, 0)):
        space.add_point((x * scale + deep - 1, y * scale + deep - 1), dxfattribs={"layer": work})
    document.saveas(folder / "plan.dxf")
    return folder / "plan.dxf"


@pytest.mark.parametrize(
    "drawn",
    [
        {},
        {"deep": 4},
        {"layer": "0"},
        {"layer": "Geometry"},
        {"beside": [((-5, -5), (30, -5))]},
        {"scale": 2.0},
    ],
)
def test_lines_inside_blocks_are_lanes(tmp_path, drawn):
    made = import_layout(in_a_block(tmp_path, **drawn))
    lengths = edges_of(made)
    assert len(lengths) == 14
    assert sum(lengths.values()) == pytest.approx(2 * 64 * drawn.get("scale", 1))
    assert made.in_short().startswith("7 nodes, 7 edges, ")


@pytest.mark.slow
def test_blocks_that_hold_thousands_of_others_each_are_refused(tmp_path, monkeypatch):
    monkeypatch.setitem(LIMITS, "nodes", (500, *LIMITS["nodes"][1:]))
    ezdxf = pytest.importorskip("ezdxf", reason="ezdxf, the extra dxf, is not installed")
    path = in_a_block(tmp_path)
    document = ezdxf.readfile(path)
    inner = "FLOOR"
    for number in range(4):
        outer = document.blocks.new(f"many {number}")
        for _ in range(20):
            outer.add_blockref(inner, (0, 0))
        inner = outer.name
    document.modelspace().add_blockref(inner, (0, 0))
    document.saveas(path)
    with pytest.raises(dw.ModelError, match="too many entities in blocks, expected 500 at most"):
        import_layout(path)


def test_the_floor_shows_a_unit_that_is_not_meant(tmp_path):
    large = {number: [1000 * x, 1000 * y] for number, (x, y) in SQUARE.items()}
    made = import_layout(route_graph(tmp_path, corners=large), robots=1)
    assert ", 20,000 x 12,000 m, " in made.in_short()
    assert {remark.kind for remark in made.remarks if remark.what == "doubtful"} == {"floor", "unit of length"}


def test_lengths_of_another_unit_than_coordinates_are_doubtful(tmp_path):
    links = [(a, b, {"length": 0.02}) for a, b in LOOP]
    made = import_layout(graph(tmp_path, links), robots=1)
    assert {remark.kind for remark in made.remarks if remark.what == "doubtful"} == {"link"}


def test_imports_take_the_fastest_way_also_where_lanes_have_no_speed(tmp_path):
    (tmp_path / "nodes.csv").write_text(
        "name,x,y,role,station\nA,0,0,load,\nS,10,2,,\nF,10,-6,,\nB,20,0,unload,packing\nX,10,20,park,\n"
    )
    (tmp_path / "edges.csv").write_text("from,to,speed\nA,S,0.2\nS,B,0.2\nA,F,\nF,B,\nB,X,\nX,A,\n")
    made = import_layout(tmp_path / "nodes.csv")
    assert made.content["policies"]["routing"] == "fastest"
    (tmp_path / "edges.csv").write_text("from,to,speed\nA,F,\nF,B,\nB,X,\nX,A,\n")
    assert import_layout(tmp_path / "nodes.csv").content["policies"]["routing"] == "fastest"
