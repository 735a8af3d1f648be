"""Lanes drawn as lines, in GeoJSON and DXF: a small plant, worked out by hand."""

import json
import math
import sys

import pytest

import desim_warehouse as dw
from desim_warehouse.layout import build
from desim_warehouse.plants import import_layout
from desim_warehouse.plants.lanes import lanes_of
from desim_warehouse.plants.lines import Line, Mark, join
from desim_warehouse.plants.plant import Plant
from tests.plants.damage import one_message
from tests.plants.drawings import degrees, dxf, features, geojson


def drawn(lines, marks=()):
    """A plant of lines, each a list of spots, and marks."""
    plant = Plant("drawing", "a drawing")
    lanes = [line if isinstance(line, Line) else Line(f"line {i}", tuple(line)) for i, line in enumerate(lines)]
    join(plant, lanes, [Mark(name, at, ("load",)) for name, at in marks])
    return plant


def spots(plant):
    return {(point.x, point.y) for point in plant.points.values()}


def pairs(plant):
    at = plant.points
    return {((at[one.source].x, at[one.source].y), (at[one.target].x, at[one.target].y)) for one in plant.links}


def said(plant, what="changed"):
    return {(remark.kind, remark.names) for remark in plant.remarks if remark.what == what}


def test_lines_that_cross_get_a_point():
    plant = drawn([[(0, 5), (10, 5)], [(5, 0), (5, 10)]])
    assert spots(plant) == {(0, 5), (10, 5), (5, 0), (5, 10), (5, 5)}
    assert len(plant.links) == 4
    assert said(plant) == {("line", ("line 0", "line 1"))}


def test_an_end_on_another_line_is_a_junction_even_if_it_misses_it_a_little():
    plant = drawn([[(0, 0), (10, 0)], [(4, 0.04), (4, 3)]])
    assert pairs(plant) == {((0, 0), (4, 0.04)), ((4, 0.04), (10, 0)), ((4, 0.04), (4, 3))}
    assert len(drawn([[(0, 0), (10, 0)], [(4, 0.06), (4, 3)]]).links) == 2


SQUARE = [(0, 0), (20, 0), (20, 12), (0, 12)]
GAPS = {
    "closed": ([[*SQUARE, (0, 0)]], ()),
    "a ring that is not closed": ([[*SQUARE, (0, 0.3)]], ("line 0",)),
    "two lines end to end": ([[(0, 0), (10, 0)], [(10.3, 0), (20, 0)]], ("line 0", "line 1")),
    "an end beside a line": ([[(0, 0), (10, 0)], [(4, 0.2), (4, 3)]], ("line 1",)),
    "far apart": ([[(0, 0), (10, 0)], [(4, 0.6), (4, 3)]], ()),
    "a short spur": ([[(0, 0), (10, 0)], [(4, 0), (4, 0.4)]], ()),
    "lanes side by side": ([[(0, 0), (10, 0), (10, 5)], [(10, 5), (10.4, 5), (10.4, 0), (20, 0)]], ()),
}


@pytest.mark.parametrize("name", GAPS)
def test_an_end_that_stops_short_of_a_line_is_doubtful(name):
    lines, short = GAPS[name]
    assert said(drawn(lines), "doubtful") == {("line", short)} - {("line", ())}


def test_an_end_with_a_mark_stops_where_it_should():
    assert not said(drawn([[(0, 0), (10, 0)], [(4, 0.4), (4, 3)]], [("charger", (4, 0.4))]), "doubtful")


def test_ends_that_nearly_meet_are_one_point():
    plant = drawn([[(0, 0), (10, 0)], [(10.03, 0.03), (10, 8)]])
    assert pairs(plant) == {((0, 0), (10, 0)), ((10, 0), (10, 8))}
    assert said(plant) == {("line", ("line 1",))}


def test_corners_are_points_and_curves_keep_their_length():
    corner = drawn([[(0, 0), (5, 0), (10, 0), (10, 8)]])
    assert pairs(corner) == {((0, 0), (10, 0)), ((10, 0), (10, 8))}
    arc = [(10 * math.cos(angle / 100), 10 * math.sin(angle / 100)) for angle in range(158)]
    curve = drawn([arc])
    assert 3 <= len(curve.links) <= 8
    assert sum(link.length for link in curve.links) == pytest.approx(15.7, abs=0.01)
    assert said(curve) == {("line", ("line 0",))}


def test_a_ring_is_a_loop():
    plant = drawn([[(0, 0), (9, 0), (9, 9), (0, 9), (0, 0)]])
    assert len(plant.points) == len(plant.links) == 4


def test_a_line_drawn_twice_is_one_lane():
    plant = drawn([[(0, 0), (10, 0)], [(10, 0), (2, 0)], [(0, 0), (10, 0)]])
    assert spots(plant) == {(0, 0), (2, 0), (10, 0)}
    assert {(lane.source, lane.target, lane.two_way) for lane in lanes_of(plant)} == {
        ("p1", "p2", True),
        ("p2", "p3", True),
    }


def test_places_belong_to_the_nearest_lane():
    plant = drawn([[(0, 0), (10, 0)], [(0, 9), (10, 9)]], [("a", (3, 1)), ("b", (4, 4.5)), ("c", (10.01, 9))])
    assert {one.name: tuple(one.operations) for one in plant.locations} == {"a": ("a",), "c": ("c",)}
    assert (plant.points["a"].x, plant.points["a"].y) == (3, 0)
    assert said(plant) == {("place", ("a",))}
    assert said(plant, "left out") == {("place", ("b",))}


def test_nothing_to_drive_on_is_one_message():
    with pytest.raises(dw.ModelError, match="a drawing: no lines, expected lanes drawn as lines"):
        drawn([])
    plant = drawn([[(0, 0), (0.01, 0)], [(5, 5), (9, 5)]])
    assert said(plant, "left out") == {("line", ("line 0",))}


def test_hatching_is_refused_in_time():
    hatch = [[(i / 10, 0), (i / 10, 50)] for i in range(2000)]
    with pytest.raises(dw.ModelError, match="too many lines beside one another, expected lanes, not hatching"):
        drawn(hatch)


def the_yard(model, tolerance):
    """Whether a model has the lanes of the yard."""
    layout = build(model.layout)
    graph = layout.graph
    assert len(graph) == 6
    assert sorted(data["length"] for *_, data in graph.edges(data=True)) == pytest.approx(
        [3, 3, 4, 4, 8, 8, 10, 10], abs=tolerance
    )
    assert len(layout.two_way) == 2
    [load], [unload], [charge] = layout.storage, model.layout.stations.values(), model.layout.bays.values()
    xs = [graph.nodes[node]["x"] for node in (load.edge[0], unload.at[0], charge.at[0])]
    assert [x - xs[2] for x in xs] == pytest.approx([13, 17, 0], abs=tolerance)
    ys = [graph.nodes[node]["y"] for node in (load.edge[0], unload.at[0], charge.at[0])]
    assert [y - ys[0] for y in ys] == pytest.approx([0, 8, 8], abs=tolerance)  # downwards


def test_geojson_in_metres_is_read(tmp_path):
    made = import_layout(geojson(tmp_path))
    the_yard(made.model, 1e-6)
    assert set(made.model.layout.stations) == {"table 1"}
    speeds = {edge.speed for edge in made.model.layout.edges if not edge.two_way}
    assert speeds == {1}
    assert ("place", ("table 1",)) in said(made.plant)


def test_geojson_in_degrees_is_projected(tmp_path):
    made = import_layout(geojson(tmp_path, degrees))
    the_yard(made.model, 0.01)
    [remark] = [one for one in made.remarks if one.kind == "units.length"]
    assert "degrees are projected around 15.44" in remark.why


def test_a_maxspeed_is_in_kilometres_an_hour_as_in_openstreetmap(tmp_path):
    made = import_layout(geojson(tmp_path))
    text = (path := tmp_path / "yard.geojson").read_text()
    path.write_text(text.replace('"speed": 1', '"maxspeed": "5"'))
    assert text.count('"speed": 1') == 1
    of_maps = import_layout(path)
    assert {edge.speed for edge in made.model.layout.edges if edge.speed} == {1}
    assert {round(edge.speed, 2) for edge in of_maps.model.layout.edges if edge.speed} == {1.39}
    remark = "assumed: layout.edges: their 'maxspeed' is in km/h, as in OpenStreetMap; 'speed' is in m/s"
    assert remark in map(str, of_maps.remarks)
    assert remark not in map(str, made.remarks)
    path.write_text(text.replace('"speed": 1', '"maxspeed": "90 m/min"'))
    assert {edge.speed for edge in import_layout(path).model.layout.edges if edge.speed} == {1.5}


def test_geojson_lanes_of_a_layer(tmp_path):
    made = import_layout(geojson(tmp_path), lanes="lanes")
    left = {(one.kind, one.names, one.why) for one in made.remarks if one.what == "left out"}
    assert ("feature", ("features[2]",), "a line on another layer than those of lanes") in left
    assert len(made.plant.points) == 5


def changed(data, path, value):
    """The features with a value put at a path of keys."""
    at = data
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value
    return data


GEOMETRY = ("features", 0, "geometry")


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("type",), "Feature", "the top level: not a FeatureCollection"),
        (("features",), {}, "features: not a list"),
        (("features",), [], "features: no line, expected lanes drawn as lines"),
        (("features", 1), 5, "features[1]: not a feature (got 5)"),
        (GEOMETRY, "here", "features[0].geometry: not a geometry (got 'here')"),
        ((*GEOMETRY, "coordinates"), None, "features[0].geometry.coordinates: not a list (got nothing)"),
        ((*GEOMETRY, "coordinates", 2), [1], "features[0].geometry.coordinates[2]: not a position (got [1])"),
        ((*GEOMETRY, "coordinates", 2), [1, True], "not a position (got [1, true])"),
        ((*GEOMETRY, "coordinates", 2), [1, 1e308], "not a position"),
        (("features", 0, "properties", "speed"), 0, "features[0]: speed: not above 0 (got 0)"),
        (("features", 0, "properties", "oneway"), "perhaps", "features[0]: oneway: neither yes nor no"),
    ],
)
def test_what_is_wrong_with_geojson_is_said_with_its_place(tmp_path, path, value, message):
    (tmp_path / "yard.geojson").write_text(json.dumps(changed(features(), path, value)))
    assert message in one_message(tmp_path / "yard.geojson")


def test_a_drawing_in_millimetres_is_read(tmp_path):
    made = import_layout(dxf(tmp_path))
    the_yard(made.model, 1e-6)
    assert ("layer", ("Walls",)) in said(made.plant, "left out")


def test_a_drawing_in_inches_and_one_without_units(tmp_path):
    the_yard(dw.read_layout(dxf(tmp_path, unit=1, scale=1000 / 25.4)), 1e-3)
    made = import_layout(dxf(tmp_path, unit=0, scale=1))
    the_yard(made.model, 1e-6)
    assert [one.why for one in made.remarks if one.kind == "units.length"] == [
        "m; the drawing does not name its unit ($INSUNITS), taken for m"
    ]
    the_yard(dw.read_layout(dxf(tmp_path, unit=0, scale=1000)), 1e-6)


def test_the_layers_of_lanes_may_be_named(tmp_path):
    path = dxf(tmp_path)
    the_yard(dw.read_layout(path, lanes=("lanes", "LANES ONE-WAY")), 1e-6)
    with pytest.raises(dw.ModelError, match=r"no lines on a layer 'Wall', expected one of .*; did you mean 'Walls'\?"):
        dw.read_layout(path, lanes="Wall")


def test_curves_hidden_layers_and_what_is_no_line(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    document = ezdxf.new(units=6)
    space = document.modelspace()
    space.add_circle((0, 0), 10, dxfattribs={"layer": "lane"})
    space.add_lwpolyline([(10, 0), (20, 0), (20, 9)], dxfattribs={"layer": "lane"})
    space.add_text("lane 1", dxfattribs={"layer": "lane"})
    document.layers.add("old lane").off()
    space.add_line((0, 0), (50, 50), dxfattribs={"layer": "old lane"})
    space.add_point((-10, 0), dxfattribs={"layer": "pick"})
    space.add_point((20, 9), dxfattribs={"layer": "drop"})
    document.saveas(tmp_path / "ring.dxf")
    made = import_layout(tmp_path / "ring.dxf")
    ring = [edge for edge in made.model.layout.edges if edge.length is not None]
    assert sum(edge.length for edge in ring) == pytest.approx(2 * math.pi * 10, rel=0.01)
    assert {("layer", ("old lane",)), ("kind of entity", ("1 TEXT on lane",))} <= said(made.plant, "left out")


def test_lines_on_layers_whose_names_say_nothing(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    document = ezdxf.new(units=6)
    for layer in ("0", "A-101"):
        document.modelspace().add_line((0, 0), (50, 50), dxfattribs={"layer": layer})
    document.saveas(tmp_path / "plan.dxf")
    message = r"which lines are lanes\? Choose layers with --lanes, of 0 \(1 lines\) and A-101 \(1 lines\)"
    with pytest.raises(dw.ModelError, match=message):
        dw.read_layout(tmp_path / "plan.dxf")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"AC1027 a drawing", "a binary drawing (DWG or binary DXF), expected it saved as DXF in text"),
        (b"AutoCAD Binary DXF\r\n\x1a\0", "a binary drawing"),
        (b"", "no lines in the model space"),
        (b"hello", "not a drawing"),
        (b"0\nSECTION\n2\nENTITIES\n0\nENDSEC\n0\nEOF\n", "no lines in the model space"),
    ],
)
def test_what_is_no_drawing_is_one_message(tmp_path, content, message):
    pytest.importorskip("ezdxf")
    (tmp_path / "plan.dxf").write_bytes(content)
    assert message in one_message(tmp_path / "plan.dxf")


def test_without_ezdxf_the_message_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    (tmp_path / "plan.dxf").write_bytes(b"0\nEOF\n")
    error = r"plan\.dxf: a DXF drawing, which needs the package ezdxf; install it: pip install 'desim-warehouse\[dxf\]'"
    with pytest.raises(dw.ModelError, match=error):
        dw.read_layout(tmp_path / "plan.dxf")


def test_entities_that_are_no_lanes_do_not_stop_a_drawing(tmp_path):
    """A damaged spline, a mesh on a layer of lanes, and a text there, in a drawing without a unit."""
    ezdxf = pytest.importorskip("ezdxf")
    path = dxf(tmp_path, unit=0, scale=1)
    document = ezdxf.readfile(path)
    space = document.modelspace()
    space.add_polymesh(dxfattribs={"layer": "Lanes"})
    space.add_text("aisle 1", dxfattribs={"layer": "Lanes"})
    spline = space.add_spline([(0, 0), (1, 1), (2, 0)], dxfattribs={"layer": "Walls"})
    document.saveas(path)
    text = path.read_text()
    begin = text.index("AcDbSpline\n")
    path.write_text(text[:begin].removesuffix("100\n") + text[begin + len("AcDbSpline\n") :])
    with pytest.raises(ezdxf.DXFStructureError):
        ezdxf.readfile(path)
    made = import_layout(path)
    the_yard(made.model, 1e-6)
    assert [one.names for one in made.remarks if one.kind == "entity"] == [
        (f"missing 'AcDbSpline' subclass in SPLINE(#{spline.dxf.handle})",)
    ]


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.xlayo", "<LayoutConfiguration/>", "a file of RAWSim-O, which cannot be read"),
        ("a.xml", "<LayoutConfiguration/>", "of no other program that is known"),
        ("a.json", '{"robots": []}', "of a program that is not known: not a layout that can be read"),
        ("a.yaml", "robots: []", "of no other program that is known"),
    ],
)
def test_other_programs_are_called_by_their_names_or_not_known(tmp_path, name, text, message):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(dw.ModelError, match=message):
        import_layout(path)


def test_trees_of_ggo_are_blocked(tmp_path):
    path = tmp_path / "trees.json"
    path.write_text(json.dumps({"layout": ["T@e..", ".....", "ww..r"]}))
    assert len(import_layout(path).plant.points) == 13
