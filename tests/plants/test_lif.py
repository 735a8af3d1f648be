"""Layouts in LIF: one drawn for these tests, worked out by hand, dialects of it, and those of others where they are."""

import copy
import json
import math
import random

import pytest

import desim_warehouse as dw
from desim_warehouse.layout import build
from desim_warehouse.plants import import_layout, lif_keys, read_plant
from desim_warehouse.plants.keyed import Reader
from tests.auditor import audit
from tests.plants.damage import one_message
from tests.plants.drawn_lif import DOCK, dock, edge, node, station, write
from tests.plants.foreign import needs_plants, plant_file, remarks


@pytest.fixture
def drawn(tmp_path):
    """Write the dock with a change, and give its path."""
    return lambda change=None: write(tmp_path / "dock.lif.json", dock(change))


def test_a_layout_with_y_downwards(drawn):
    plant = read_plant(drawn())
    assert (len(plant.points), len(plant.links), len(plant.locations), len(plant.vehicles)) == (7, 10, 3, 0)
    assert (plant.points["C"].x, plant.points["C"].y, plant.points["C"].position) == (12, -8, "layouts[0].nodes[2]")
    ring = next(link for link in plant.links if link.name == "A-B")
    assert (ring.speed, ring.speed_back, ring.length, ring.position) == (1.5, 0, None, "layouts[0].edges[0]")


def test_opposite_edges_are_a_two_way_lane_and_actions_say_what_is_done(drawn):
    model = dw.read_layout(drawn(), robots=2)
    edges = {(one.source, one.target): one for one in model.layout.edges}
    assert {ends for ends, one in edges.items() if one.two_way} == {("B", "rack"), ("C", "belt"), ("D", "plug")}
    assert len(edges) == 7
    assert edges["B", "rack"].speed == 0.5
    assert [place.node for place in model.layout.storage] == ["rack"]
    assert dict(model.layout.stations)["belts"].at == ("belt",)
    assert model.layout.bays["chargers"].at == ("plug",)
    run = dw.simulate(model.replace({"run.length": 3600, "fleet.start_energy": 0.9}))
    assert run.kpis["tasks"] > 10
    assert audit(run) == []


def test_what_could_not_be_carried_over_is_said_by_name_and_place(drawn):
    made = import_layout(drawn())
    assert remarks(made, "left out") == {
        ("vehicle type", ("tall truck",)),
        ("direction of driving", ("rack-B", "belt-C")),
        ("load restriction", ("D-plug", "plug-D")),
    }
    assert not remarks(made, "changed")
    [where] = [remark.positions for remark in made.remarks if remark.kind == "load restriction"]
    assert where == ("layouts[0].edges[8]", "layouts[0].edges[9]")


def test_another_vehicle_type_has_other_nodes_and_edges(drawn):
    plant = read_plant(drawn(), vehicle_type="tall truck")
    assert set(plant.points) == {"A", "B", "C", "D", "rack"}
    assert len(plant.links) == 6
    left = {remark.kind: remark.names for remark in plant.remarks if remark.what == "left out"}
    assert left["node"] == ("belt", "plug")
    assert left["edge"] == ("C-belt", "belt-C", "D-plug", "plug-D")
    assert left["station"] == ("belts", "chargers")
    with pytest.raises(
        dw.ModelError, match="no vehicle type 'fork', expected one of forklift, tall truck; did you mean"
    ):
        read_plant(drawn(), vehicle_type="fork")


def test_a_type_that_no_edge_lists_can_drive_nowhere(drawn):
    def only_trucks(_, layout):
        for one in layout["edges"]:
            one["vehicleTypeEdgeProperties"] = one["vehicleTypeEdgeProperties"][:1]

    with pytest.raises(dw.ModelError, match=r"no lanes, .* not for vehicle type 'tall truck'"):
        dw.read_layout(drawn(only_trucks), vehicle_type="tall truck")


# Trajectories

QUARTER = {  # of a circle of radius 8 about (12, 0), as a rational quadratic: exactly
    "degree": 2,
    "knotVector": [0, 0, 0, 1, 1, 1],
    "controlPoints": [
        {"x": 20, "y": 0, "weight": 1},
        {"x": 20, "y": 8, "weight": math.sqrt(0.5)},
        {"x": 12, "y": 8, "weight": 1},
    ],
}
LINE = {"degree": 1, "knotVector": [0, 0, 1, 1], "controlPoints": [{"x": 0, "y": 8}, {"x": 0, "y": 0}]}


def test_a_trajectory_is_as_long_as_its_curve(drawn):
    def turn(_, layout):
        layout["nodes"].append(node("bend", 20.0, 0.0))
        layout["edges"] += [edge("bend", "C", trajectory=QUARTER), edge("B", "bend")]
        layout["edges"][3] = edge("D", "A", trajectory=LINE)

    lengths = {link.name: link.length for link in read_plant(drawn(turn)).links}
    assert lengths["bend-C"] == pytest.approx(4 * math.pi, rel=1e-12)
    assert lengths["D-A"] == 8
    model = dw.read_layout(drawn(turn))
    assert build(model.layout).graph.edges["bend", "C"]["length"] == pytest.approx(4 * math.pi, abs=1e-4)


NOT_CURVES = [
    ({"degree": 3}, "2 control points and 4 knots for degree 3"),
    ({"degree": 1.5}, "of degree 1.5"),
    ({"degree": 40}, "of degree 40"),
    ({"knotVector": [0, 1, 0, 1]}, "knots that fall"),
    ({"knotVector": [0, 0, 0, 0]}, "all the same"),
    ({"controlPoints": [{"x": 0, "y": 8, "weight": 0}, {"x": 0, "y": 0}]}, "weights that are not above 0"),
    ({"controlPoints": [{"x": 0}, {"x": 0, "y": 0}]}, "a control point without x or y"),
    ({"controlPoints": [{"x": 0, "y": 3}, {"x": 0, "y": 0}]}, "does not lead from one node of its edge to the other"),
    ({"controlPoints": []}, "0 control points"),
]


@pytest.mark.parametrize(("change", "message"), NOT_CURVES, ids=[message for _, message in NOT_CURVES])
def test_a_trajectory_that_is_none_is_taken_to_be_straight(drawn, change, message):
    def bend(_, layout):
        layout["edges"][3] = edge("D", "A", trajectory={**LINE, **change})

    plant = read_plant(drawn(bend))
    assert next(link for link in plant.links if link.name == "D-A").length is None
    [remark] = [remark for remark in plant.remarks if remark.what == "doubtful"]
    assert message in remark.why
    assert (remark.names, remark.positions) == (("D-A",), ("layouts[0].edges[3]",))


# Dialects and repairs

REPAIRED = {
    "text for a number; read as meant": lambda _, layout: layout["stations"][0].update(stationHeight="0.55"),
    "a number for text; read as meant": lambda _, layout: layout["nodes"].append({**node("", 0, 4), "nodeId": 7}),
    "no stations; read without it": lambda _, layout: layout.pop("stations"),
    "no metaInformation; read without it": lambda made, _: made.pop("metaInformation"),
    "not a number (got 'None'); left out": lambda _, layout: layout["nodes"][0]["vehicleTypeNodeProperties"][0].update(
        theta="None"
    ),
    "text for true or false; read as meant": lambda _, layout: layout["edges"][0]["vehicleTypeEdgeProperties"][
        0
    ].update(rotationAllowed="False"),
    "not one of GLOBAL, TANGENTIAL (got 'global'); read as meant": lambda _, layout: layout["edges"][0][
        "vehicleTypeEdgeProperties"
    ][0].update(orientationType="global"),
    "no node 'nowhere'; left out": lambda _, layout: layout["edges"].append(edge("A", "nowhere")),
    "a node 'A' stands before; left out": lambda _, layout: layout["nodes"].append(node("A", 1.0, 1.0)),
    "no vehicleTypeNodeProperties; read without it": lambda _, layout: layout["nodes"][0].pop(
        "vehicleTypeNodeProperties"
    ),
    "not an object (got 5); left out": lambda _, layout: layout["nodes"].append(5),
}


@pytest.mark.parametrize("message", REPAIRED)
def test_what_is_clear_is_put_right_and_said(drawn, message):
    made = import_layout(drawn(REPAIRED[message]))
    whole = import_layout(drawn())
    assert message in {remark.why for remark in made.remarks if remark.what == "changed"}
    assert {**made.model.content(), "description": ""}["tasks"] == whole.model.content()["tasks"]
    with pytest.raises(dw.ModelError, match=r"to the letter of LIF 1\.0"):
        read_plant(drawn(REPAIRED[message]), strict=True)


def test_to_the_letter_the_dock_is_as_it_should_be(drawn):
    strict, lenient = read_plant(drawn(), strict=True), read_plant(drawn())
    assert strict == lenient


def test_nodes_and_edges_for_no_vehicle_type_are_open_to_all(drawn):
    def nobody(_, layout):
        layout["nodes"][4]["vehicleTypeNodeProperties"] = []
        layout["edges"][4]["vehicleTypeEdgeProperties"] = []

    made = import_layout(drawn(nobody))
    assert remarks(made, "changed") >= {("node", ("rack",)), ("edge", ("B-rack",))}
    assert len(made.plant.links) == 10


def test_degrees_and_millimetres_are_doubted(drawn):
    def in_degrees(_, layout):
        for one in layout["nodes"]:
            one["nodePosition"] = {axis: 1000 * value for axis, value in one["nodePosition"].items()}
            one["vehicleTypeNodeProperties"][0]["theta"] = 90.0
        layout["edges"][5] = edge("rack", "B", vehicleOrientation=180.0)

    made = import_layout(drawn(in_degrees))
    doubted = {remark.kind: remark for remark in made.remarks if remark.what == "doubtful"}
    assert len(doubted["vehicle angle"].names) in {1, 7}
    assert "degrees" in doubted["vehicle angle"].why
    assert "are coordinates in mm" in doubted["unit of length"].why
    assert ("direction of driving", ("rack-B", "belt-C")) in remarks(made, "left out")  # 180 degrees are backwards


def test_edges_that_are_meant_both_ways_are_read_so_if_asked(drawn):
    def one_way_each(_, layout):
        layout["edges"] = [one for one in layout["edges"] if one["edgeId"] not in {"rack-B", "belt-C", "plug-D"}]

    with pytest.raises(dw.ModelError, match="no location in reach"):
        dw.read_layout(drawn(one_way_each))
    model = dw.read_layout(drawn(one_way_each), two_way=True)
    assert all(one.two_way for one in model.layout.edges)
    assert len(model.layout.edges) == 7


def test_without_actions_a_station_is_known_by_its_name(drawn):
    def without(_, layout):
        for one in layout["nodes"]:
            for about in one["vehicleTypeNodeProperties"]:
                about.pop("actions", None)
        layout["stations"] = [
            station("1", "rack", stationName="Goods in"),
            station("2", "belt", stationName="Unloading"),
            station("3", "plug", stationName="Charger"),
        ]

    model = dw.read_layout(drawn(without), operations={"Goods in": "load"})
    assert [place.node for place in model.layout.storage] == ["rack"]
    assert set(model.layout.stations) == {"2"}
    assert model.layout.bays["chargers"].at == ("plug",)


def test_without_stations_nodes_with_actions_are_places(drawn):
    model = dw.read_layout(drawn(lambda _, layout: layout.pop("stations")))
    assert [place.node for place in model.layout.storage] == ["rack"]
    assert model.layout.bays["chargers"].at == ("plug",)


def test_stations_at_no_node_and_one_spot_and_parallel_edges_are_said(drawn):
    def odd(_, layout):
        layout["stations"] += [station("nowhere")]
        layout["nodes"][6]["nodePosition"] = {"x": 0.0, "y": 8.0}
        layout["edges"].append({**edge("A", "B", maxSpeed=0.3), "edgeId": "A-B slow"})

    made = import_layout(drawn(odd))
    positions = {(one.what, one.kind): one.positions for one in made.remarks}
    assert positions["left out", "location"] == ("layouts[0].stations[3]",)
    assert positions["changed", "point"] == ("layouts[0].nodes[6]",)
    assert positions["left out", "link"] == ("layouts[0].edges[10]",)
    assert made.model.layout.nodes["plug"] == (0.01, -8)


def test_closed_edges_are_left_out(drawn):
    def closed(_, layout):
        layout["edges"].append({**edge("A", "C", maxSpeed=0), "edgeId": "slow"})
        layout["edges"].append({**edge("A", "C", loadRestriction={"unloaded": False, "loaded": False})})

    assert ("edge", ("slow", "A-C")) in remarks(import_layout(drawn(closed)), "left out")


# Several layouts

UPSTAIRS = {
    "layoutId": "first",
    "layoutVersion": "1",
    "layoutLevelId": "1",
    "nodes": [node("E", 0.0, 8.0), node("A", 0.0, 0.0, "drop")],
    "edges": [edge("E", "A"), edge("A", "E"), edge("E", "D")],
    "stations": [station("attic", "A")],
}


def upstairs(made, layout):
    layout["edges"].append(edge("D", "E"))
    made["layouts"].append(copy.deepcopy(UPSTAIRS))


def test_levels_are_drawn_side_by_side_and_doubled_names_are_renamed(drawn):
    made = import_layout(drawn(upstairs))
    assert ("level", ("1",)) in remarks(made, "changed")
    nodes = made.model.layout.nodes
    assert nodes["first A"] == (27, 0)  # 10 m right of all others
    graph = build(made.model.layout).graph
    assert graph.edges["E", "first A"]["length"] == 8
    assert made.model.layout.stations["attic"].at == ("first A",)
    assert "a node 'A' stands before, in another layout; renamed" in {remark.why for remark in made.remarks}


def test_one_of_several_layouts_can_be_asked_for(drawn):
    for name in ("ground", "Ground floor"):
        plant = read_plant(drawn(upstairs), layout=name)
        assert len(plant.points) == 7
        left = {remark.kind: remark.names for remark in plant.remarks if remark.what == "left out"}
        assert left["layout"] == ("first",)
        assert left["transition"] == ("D-E",)
    with pytest.raises(dw.ModelError, match="layouts: no layout 'frist', expected one of ground, first; did you mean"):
        read_plant(drawn(upstairs), layout="frist")


def test_layouts_of_one_level_stay_where_they_are(drawn):
    def same_level(made, layout):
        upstairs(made, layout)
        made["layouts"][1]["layoutLevelId"] = "0"

    assert read_plant(drawn(same_level)).points["first A"].x == 0


# Version 2


def version_2(made, _):
    """The dock as LIF 2 has it."""
    made["metaInformation"] = {"lifId": "dock", "creator": "these tests", "lifVersion": "2.0.0"}
    layout = made.pop("layouts")[0]
    for part, kind in ((layout["nodes"], "Node"), (layout["edges"], "Edge")):
        for one in part:
            about = one.pop(f"vehicleType{kind}Properties")
            types = [{"manufacturer": "M", "seriesName": each["vehicleTypeId"]} for each in about]
            first = {key: value for key, value in about[0].items() if key not in {"vehicleTypeId", "rotationAllowed"}}
            first["feasibleActions"] = first.pop("actions", [])
            if "vehicleOrientation" in first:
                first["mobileRobotOrientations"] = [first.pop("vehicleOrientation")]
            one[f"mobileRobotType{kind}Properties"] = [{"mobileRobotTypes": types, **first}]
    made["origins"] = [{"originId": "gate", "layouts": [layout]}]


def test_version_2_says_the_same_in_other_words(drawn):
    old, new = import_layout(drawn()), import_layout(drawn(version_2))
    same = {"description": "", "name": ""}
    assert {**new.model.content(), **same} == {**old.model.content(), **same}
    assert "version" not in {kind for kind, _ in remarks(new, "doubtful")}
    assert new.plant.points["A"].position == "origins[0].layouts[0].nodes[0]"
    assert remarks(new, "left out") == {("vehicle type", ("M tall truck",))} | {
        one for one in remarks(old, "left out") if one[0] != "vehicle type"
    }
    with pytest.raises(dw.ModelError, match="no layouts"):
        read_plant(drawn(version_2), strict=True)


def test_an_unknown_version_is_read_as_1_and_doubted(drawn):
    made = import_layout(drawn(lambda made, _: made["metaInformation"].update(lifVersion="7.1")))
    assert ("version", ("7.1",)) in remarks(made, "doubtful")


# Damaged and hostile files

TEXT = json.dumps(DOCK)
HOSTILE = {
    "empty": ("", "not JSON"),
    "list": ("[]", "not an object"),
    "no layouts": ('{"metaInformation": {}}', "no layouts"),
    "no nodes": ('{"layouts": [{}]}', "no nodes"),
    "twice": (TEXT.replace('"edges"', '"nodes"'), "key 'nodes' given twice"),
    "nan": (TEXT.replace("12.0", "NaN", 1), "layouts[0].nodes[1].nodePosition.x: not a number (got NaN)"),
    "infinity": (TEXT.replace("12.0", "-Infinity", 1), "not a number (got -Infinity)"),
    "1e308": (TEXT.replace("12.0", "1e308", 1), "not a number of a layout"),
    "1e999": (TEXT.replace("12.0", "1e999", 1), "not a number of a layout"),
    "digits": (TEXT.replace("12.0", "1" * 10_000, 1), "not JSON"),
    "text": (TEXT.replace("12.0", '"twelve"', 1), "not a number (got 'twelve')"),
    "no x": (TEXT.replace('"x": 12.0, ', "", 1), "no x"),
    "no name": (TEXT.replace('"nodeId": "B", ', "", 1), "no nodeId"),
    "no end": (TEXT.replace('"endNodeId": "B", ', "", 1), "no endNodeId"),
    "half a character": (TEXT.replace('"nodeId": "B"', '"nodeId": "\\ud800"', 1), "not text (half a character)"),
    "deep": ('{"layouts":' + "[" * 100_000, "too many lists or objects inside one another"),
    "deep and whole": ('{"layouts":' + "[" * 50_000 + "]" * 50_000 + "}", "too many lists or objects"),
    "wide": ('{"layouts":[' + "[]," * 2_000_000 + "[]]}", "too many values"),
    "nothing but repairs": ('{"layouts":[{"nodes":[' + "5," * 600_000 + "5]}]}", "as are too many values"),
    "large": ('{"layouts":[]' + " " * 64_000_000 + "}", "too large"),
    "nodes without edges": (TEXT[: TEXT.index(', "edges"')] + "}]}", "no lanes, expected some on which robots drive"),
    "bytes": ('{"layouts": [\xff]}', "not JSON"),
    "types": (
        json.dumps(dock(lambda _, layout: layout["nodes"].append(node("T", 0, 0, types=list(map(str, range(2000))))))),
        "too many types of vehicles",
    ),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_one_message(tmp_path, name):
    text, expected = HOSTILE[name]
    path = tmp_path / "hostile.lif"
    path.write_bytes(text.encode("latin-1"))
    assert expected in one_message(path)


STRANGE = [None, True, 5, -1.5, "", "x", [], {}, [[]], {"a": 1}, 1e308, "9" * 30, "\u2028", 0]


def paths(value, path=()):
    """All paths to values."""
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from paths(item, (*path, key))


def damaged(draw, content):
    """A copy with one value gone, strange, or there twice."""
    made = copy.deepcopy(content)
    *path, last = draw.choice([path for path in paths(made) if path])
    inner = made
    for key in path:
        inner = inner[key]
    change = draw.randrange(3)
    if change == 0:
        del inner[last]
    elif change == 1 or isinstance(inner, dict):
        inner[last] = draw.choice(STRANGE)
    else:
        inner.append(copy.deepcopy(inner[last]))
    return made


def test_a_large_file_is_read_in_a_moment(tmp_path):
    side = 25
    cells = [(x, y) for x in range(side) for y in range(side)]
    name = "{}/{}".format
    ways = [((x, y), (x + 1, y)) for x, y in cells if x + 1 < side] + [
        ((x, y), (x, y + 1)) for x, y in cells if y + 1 < side
    ]

    def large(_, layout):
        layout["nodes"] += [node(name(x, y), 2.0 * x, 40.0 + 2 * y) for x, y in cells]
        layout["edges"] += [edge(name(*a), name(*b)) for a, b in (*ways, *((b, a) for a, b in ways))]
        layout["edges"] += [edge(name(0, 0), "D"), edge("D", name(0, 0))]

    plant = read_plant(write(tmp_path / "large.lif", dock(large)))
    assert (len(plant.points), len(plant.links)) == (7 + side**2, 12 + 4 * side * (side - 1))


# Of others: nodes, edges, stations as listed; those of the vehicle type; why a model cannot be made of some

ONE_WAY = "nowhere can robots drive"  # an edge is one-way, from start to end
FOREIGN = {
    "10_1_Forward_Edge": ((2, 1, 0), ONE_WAY),
    "10_2_Bidirectional_Edge": ((2, 2, 0), None),
    "10_3_Counter_clockwise_Rotation_on_Node": ((2, 2, 0), None),
    "10_5_Multiple_Layouts_in_One_LIF": ((4, 2, 0), ONE_WAY),
    "10_6_Station_with_One_Node": ((2, 2, 1), None),
    "10_8_Station_with_Two_Nodes_Restricted_for_Different_Vehicle_Types": ((2, 2, 1), None),  # 4, 4 of all types
    "10_11_Multiple_Edges_with_Load_Restrictions": ((5, 8, 0), None),
    "10_12_Multiple_Edges_Between_Same_Two_Nodes_for_Different_vehicleTypeEdgeProperty_Constraints": ((3, 3, 0), None),
    "10_13_Battery_Charging_Station": ((2, 2, 1), None),
    "10_14_Two_Levels_of_a_Facility_in_One_LIF_File": ((4, 3, 0), None),  # and a lift
    "10_17_Edge_with_Trajectory_Definition": ((2, 2, 0), None),
    "10_18_Manufacturer_Specific_Action_on_an_Edge": ((2, 2, 0), None),
}


@needs_plants
@pytest.mark.parametrize("name", FOREIGN)
def test_layouts_of_other_publishers_are_read(name):
    path, (counts, why) = plant_file(f"lif-vdma/{name}.json"), FOREIGN[name]
    plant = read_plant(path)
    listed = sum(len(layout.get("stations", ())) for layout in json.loads(path.read_text())["layouts"])
    assert (len(plant.points), len(plant.links), listed) == counts
    with pytest.raises(dw.ModelError, match=r"to the letter of LIF 1\.0"):
        read_plant(path, strict=True)  # as the schema of the same publisher has it
    if why is None:
        run = dw.simulate(dw.read_layout(path).replace({"run.length": 1800, "fleet.start_energy": 0.9}))
        assert audit(run) == []
    else:
        with pytest.raises(dw.ModelError, match=why):
            dw.read_layout(path)


@needs_plants
def test_a_file_in_another_dialect_is_read_with_remarks():
    path = plant_file("lif-continua/example.lif.json")
    with pytest.raises(dw.ModelError, match=r"nowhere can robots drive .* not for vehicle type 'vehicle-002'"):
        dw.read_layout(path)  # its only edge into node-002 is for a type that may not use that node
    plant = read_plant(path, layout="layout-001")
    assert (len(plant.points), len(plant.links), len(plant.locations)) == (2, 1, 2)
    assert {"vehicle angle"} <= {remark.kind for remark in plant.remarks if remark.what == "doubtful"}
    text = " ".join(remark.why for remark in read_plant(path, vehicle_type="vehicle-001").remarks)
    assert "out of the range from 0 to 1" in text  # of knots
    assert "out of the range from 1" in text  # of weights
    model = dw.read_layout(path, two_way=True)
    assert len(model.layout.edges) == 1


@needs_plants
@pytest.mark.parametrize("count", [150, pytest.param(300, marks=pytest.mark.long)])
def test_to_the_letter_is_what_the_schema_says(count):
    jsonschema = pytest.importorskip("jsonschema")
    schema = json.loads(plant_file("lif-vdma/LIF.schema").read_text())
    check = jsonschema.Draft7Validator(schema)
    files = [json.loads(path.read_text()) for path in sorted(plant_file("lif-vdma").glob("*.json"))]
    draw, verdicts = random.Random(3), []
    for content in (*files, DOCK, *(damaged(draw, DOCK) for _ in range(count))):
        if "1e+308" in json.dumps(content):
            continue  # a number, to the schema
        reader = Reader("file", strict=True)
        try:
            reader.read(content, lif_keys.FILE, "")
            ours = not reader.faults
        except dw.ModelError:
            ours = False
        assert ours == check.is_valid(content), content
        verdicts.append(ours)
    assert count / 6 < sum(verdicts) < count * 5 / 6


def test_speeds_of_version_2_count(drawn):
    def limited(made, layout):
        version_2(made, layout)
        about = made["origins"][0]["layouts"][0]["edges"][0]["mobileRobotTypeEdgeProperties"][0]
        about.update(maximumSpeed=0.4, maximumRotationSpeed=0.2, maximumMobileRobotHeight=2.5, corridor={})
        del about["maxSpeed"]

    made = import_layout(drawn(limited))
    [edge] = [one for one in made.model.layout.edges if (one.source, one.target) == ("A", "B")]
    assert edge.speed == 0.4
    left = remarks(made, "left out")
    assert {("rotation speed", ("A-B",)), ("height", ("A-B",)), ("key", ("corridor",))} <= left


def test_lengths_of_line_guided_robots_count(drawn):
    def guided(made, layout):
        version_2(made, layout)
        about = made["origins"][0]["layouts"][0]["edges"][0]["mobileRobotTypeEdgeProperties"][0]
        about["physicalLineGuidedProperty"] = {"direction": "left", "length": 13.5}

    [edge] = [one for one in import_layout(drawn(guided)).model.layout.edges if (one.source, one.target) == ("A", "B")]
    assert edge.length == 13.5


def test_keys_that_nobody_knows_are_told(drawn):
    def more(made, layout):
        made["colour"] = "blue"
        for one in layout["edges"]:
            one["wear"] = 1

    [remark] = [one for one in import_layout(drawn(more)).remarks if one.kind == "key"]
    assert remark.names == ("colour", "wear")
    assert remark.positions == ("the top level", "layouts[0].edges[0] and 9 more")


def test_one_way_edges_that_are_meant_both_ways_name_the_option(drawn):
    def one_way(made, layout):
        layout["edges"] = [edge("A", "B"), edge("B", "rack"), edge("B", "C"), edge("C", "belt")]

    with pytest.raises(dw.ModelError, match=r"each is meant in both directions, choose two-way \(--two-way\)"):
        import_layout(drawn(one_way))
    assert import_layout(drawn(one_way), two_way=True).model.layout.two_way


@pytest.mark.parametrize(("kind", "bays"), [("CHARGING", {"chargers", "parking"}), ("zone 4", set())])
def test_a_station_type_that_sounds_like_charging_is_a_charger(drawn, kind, bays):
    def typed(made, layout):
        layout["stations"][2].update(stationType=kind, stationId="C-3")
        for one in layout["nodes"]:
            for about in one["vehicleTypeNodeProperties"]:
                about.pop("actions", None)

    layout = import_layout(drawn(typed)).model.layout
    assert ("plug" in {node for bay in layout.bays.values() if bay.chargers for node in bay.at}) == bool(bays)
