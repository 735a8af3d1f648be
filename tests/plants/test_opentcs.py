"""Plant models of openTCS: one drawn for these tests, worked out by hand, and those of others where they are."""

from pathlib import Path

import networkx as nx
import pytest

import desim_warehouse as dw
from desim_warehouse.layout import build
from desim_warehouse.plants import import_layout, read_plant
from desim_warehouse.questions.check import check
from tests.auditor import audit
from tests.plants.damage import one_message
from tests.plants.foreign import needs_plants, plant_file, remarks

YARD = Path(__file__).parent / "yard.xml"


def yard(tmp_path, *changes):
    """The fixture with some of its text changed."""
    text = YARD.read_text()
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    path = tmp_path / "yard.xml"
    path.write_text(text)
    return path


def test_a_plant_in_metres_with_y_downwards():
    plant = read_plant(YARD)
    assert (len(plant.points), len(plant.links), len(plant.vehicles)) == (8, 10, 3)
    assert (plant.points["C"].x, plant.points["C"].y, plant.points["C"].parking) == (10, -8, False)
    assert plant.points["plug"].parking
    tug = plant.vehicles[-1]
    assert (tug.length, tug.speed, tug.critical) == (1.0, 1.0, 0.25)


def test_paths_there_and_back_are_one_two_way_lane():
    model = dw.read_layout(YARD)
    edges = {(edge.source, edge.target): edge for edge in model.layout.edges}
    # twin paths, each with its own speed, and a path with a reverse velocity
    assert edges["C", "pack"].two_way
    assert (edges["C", "pack"].speed, edges["C", "pack"].speed_back) == (1.0, 0.8)
    assert edges["plug", "D"].two_way
    assert ("pack", "C") not in edges
    # the loop is one-way; of two paths from A to B the shorter one
    assert [edges[pair].two_way for pair in (("A", "B"), ("B", "C"), ("C", "D"), ("D", "A"))] == [False] * 4
    assert edges["A", "B"].length is None  # the straight distance
    assert edges["B", "C"].length == 9.5
    graph = build(model.layout).graph
    assert graph.edges["A", "B"]["length"] == 10
    assert graph.edges["D", "A"]["length"] == 7
    assert graph.edges["C", "D"]["speed"] == 0.5


def test_places_are_known_by_their_operations():
    model = dw.read_layout(YARD)
    assert dict(model.layout.stations) == {"table 1": model.layout.stations["table 1"]}
    assert model.layout.stations["table 1"].at == ("pack",)
    assert model.layout.bays["chargers"].at == ("plug",)
    assert model.layout.bays["parking"].at == ("100",)
    assert [place.node for place in model.layout.storage] == ["B", "D"]
    assert model.tasks.unload_at == ("pack",)


def test_places_of_the_name_of_another_point_get_a_number(tmp_path):
    """A table called D, which vehicles serve from point `pack`, is another place than point D."""
    path = yard(tmp_path, ("table 1", "D"), ('"C"', '"chargers"'))
    model = dw.read_layout(path)
    assert model.layout.stations["D (2)"].at == ("pack",)
    assert model.tasks.unload_at == ("pack",)
    assert model.layout.bays["chargers (2)"].at == ("plug",)


def test_the_fleet_is_as_drawn():
    fleet = dw.read_layout(YARD).fleet
    assert (fleet.size, fleet.robot.radius, fleet.robot.speed) == (3, 0.6, 1.5)
    assert {name: (kind.count, kind.radius, kind.speed) for name, kind in fleet.kinds.items()} == {"tug": (1, 0.5, 1.0)}
    assert dw.read_layout(YARD, robots=5).fleet.size == 5


def test_what_could_not_be_carried_over_is_said_by_name():
    made = import_layout(YARD)
    assert remarks(made, "left out") == {
        ("path", ("A --- C",)),
        ("link", ("A --- B long",)),
        ("location", ("table 2",)),
        ("location", ("table 3",)),
        ("location", ("gate",)),
        ("location", ("scales",)),
        ("peripheral operation", ("C --- D",)),
        ("vehicle angle", ("C",)),
        ("height", ("roof",)),
        ("vehicle", ("Vehicle-1",)),
    }
    assert remarks(made, "changed") == {("link", ("D --- A",)), ("block", ("crossing",))}
    assert remarks(made, "unreachable") == {("point", ("roof",)), ("location", ("rack on the roof",))}
    for word in ("yard.xml", "1 vehicle", "tasks.goods"):
        assert word in made.model.description


def test_blocks_are_zones(tmp_path):
    zone = dw.read_layout(YARD).traffic.zones["crossing"]
    assert (zone.members, zone.rule) == (("D", ("D", "A")), "one-robot")
    # one direction at a time on a two-way lane; on a one-way street that says nothing, so it is left out, and said
    spur = '<block name="crossing" type="SAME_DIRECTION_ONLY">\n        <member name="plug --- D"/>\n    </block>'
    text = YARD.read_text()
    block = text[text.index("<block") : text.index("</block>") + len("</block>")]
    zone = dw.read_layout(yard(tmp_path, (block, spur))).traffic.zones["crossing"]
    assert (zone.members, zone.rule) == ((("plug", "D"),), "one-direction")
    made = import_layout(yard(tmp_path, (block, spur.replace("plug --- D", "A --- B"))))
    assert not made.model.traffic.zones
    assert "left out: 1 block: A>B is not two-way, so its direction is given: crossing (line 76)" in map(
        str, made.remarks
    )
    # members that the model does not have
    gone = import_layout(yard(tmp_path, ('<member name="D"/>', '<member name="A --- C"/><member name="gate"/>')))
    assert gone.model.traffic.zones["crossing"].members == (("D", "A"),)
    assert ("member", ("A --- C of crossing", "gate of crossing")) in remarks(gone, "left out")


def test_the_model_is_written_as_a_readable_file(tmp_path):
    made = import_layout(YARD)
    path = tmp_path / "yard.yaml"
    path.write_text(made.text())
    assert dw.load(path) == made.model
    lines = made.text().splitlines()
    assert lines[0] == "# Made from yard.xml (openTCS plant model, version 7.0.0)."
    assert "# unreachable: 1 location: robots cannot get to its points and back: rack on the roof (line 55)" in lines
    assert "    - {from: B, to: C, length: 9.5, speed: 1}" in lines
    assert '    "100": [0, -12]' in lines
    assert "    - {node: B}  # rack north" in lines
    for remark in made.remarks:  # all that is assumed is marked
        if remark.what == "assumed":
            assert sum(f"assumed: {remark.why}" in line for line in lines) >= 1


def test_the_plant_can_be_driven_on():
    run = dw.simulate(dw.read_layout(YARD).replace({"run.length": 3600, "fleet.start_energy": 0.9}))
    assert run.kpis["tasks"] > 20
    assert audit(run) == []


OLD = (
    ('version="7.0.0"', 'version="0.0.2"'),
    ("positionX=", "xPosition="),
    ("positionY=", "yPosition="),
    ("positionZ=", "zPosition="),
    (' type="SINGLE_VEHICLE_ONLY"', ""),
)


def test_old_versions_say_the_same_in_other_words(tmp_path):
    old = dw.read_layout(yard(tmp_path, *OLD)).content()
    assert {**old, "description": ""} == {**dw.read_layout(YARD).content(), "description": ""}


def test_operations_mean_what_they_are_mapped_to():
    # the scales are a place to unload, the racks are none to load
    made = import_layout(YARD, operations={"weigh": "unload", "Load cargo": "none"})
    assert set(made.model.layout.stations) == {"table 1", "scales"}
    # so there is none to load, and all but the charger are taken for one
    assert {place.node for place in made.model.layout.storage} == {"A", "B", "D", "pack"}
    assert "layout.storage" in {remark.kind for remark in made.remarks if remark.what == "assumed"}


@pytest.mark.parametrize(
    ("operations", "message"),
    [
        ({"Weig": "unload"}, "did you mean 'Weigh'?"),
        ({"Weigh": "heavy"}, "expected load, unload, charge, park or none"),
    ],
)
def test_a_mapping_that_does_not_fit_is_refused(operations, message):
    with pytest.raises(dw.ModelError, match="operation 'Weig") as refused:
        import_layout(YARD, operations=operations)
    assert message in str(refused.value)


def test_where_only_parking_is_drawn_robots_work_there(tmp_path):
    only = (('name="Load cargo"', 'name="CHARGE"'), ("Unload cargo", "CHARGE"), ("Weigh", "CHARGE"))
    made = import_layout(yard(tmp_path, *only))
    assert {place.node for place in made.model.layout.storage} == {"plug", "100"}
    assert {name: set(station.at) for name, station in made.model.layout.stations.items()} == {
        "anywhere": {"plug", "100"}
    }
    assert {"layout.storage", "tasks.unload_at"} <= {remark.kind for remark in made.remarks if remark.what == "assumed"}
    plain = yard(tmp_path, ("PARK_POSITION", "HALT_POSITION"))
    text = plain.read_text()
    plain.write_text(text[: text.index("<locationType")] + "</model>")
    model = dw.read_layout(plain)
    assert {place.node for place in model.layout.storage} == {"A", "B", "C", "D", "pack", "plug", "100"}


def test_twins_of_different_length_lie_side_by_side(tmp_path):
    longer = (
        'name="pack --- C" sourcePoint="pack" destinationPoint="C" length="4000"',
        'name="pack --- C" sourcePoint="pack" destinationPoint="C" length="6000"',
    )
    made = import_layout(yard(tmp_path, longer))
    edges = {(edge.source, edge.target): edge for edge in made.model.layout.edges}
    assert edges["C", "pack"].side_by_side
    assert edges["pack", "C"].side_by_side
    assert edges["pack", "C"].length == 6
    assert ("C", "pack") not in build(made.model.layout).two_way


def test_a_velocity_of_0_forbids_a_direction(tmp_path):
    backwards = (
        'destinationPoint="C" length="9500" maxVelocity="1000" maxReverseVelocity="0"',
        'destinationPoint="C" length="9500" maxVelocity="0" maxReverseVelocity="1000"',
    )
    plant = read_plant(yard(tmp_path, backwards))
    link = next(link for link in plant.links if link.name == "B --- C")
    assert (link.speed, link.speed_back) == (0, 1)


def test_points_on_one_spot_are_drawn_beside_each_other(tmp_path):
    made = import_layout(yard(tmp_path, ('positionX="-3000" positionY="8000"', 'positionX="0" positionY="8000"')))
    assert made.model.layout.nodes["plug"] == (0.01, -8)
    assert ("point", ("plug",)) in remarks(made, "changed")
    assert {edge.length for edge in made.model.layout.edges if edge.source == "plug"} == {3}


ONLY_RACKS = (('link point="pack"', 'link point="roof"'), ('link point="A"', 'link point="roof"'))
NOT_READ = [
    ((("<model", "<modell"), ("</model", "</modell")), "yard.xml:4: modell 'yard': not a plant model"),
    ((('version="7.0.0"', 'version="9.1"'),), "version '9.1' is not known"),
    ((('version="7.0.0"', ""),), "no version, expected one"),
    ((("</location>", ""),), "not XML (mismatched tag)"),
    ((('standalone="yes"', 'standalone="perhaps"'),), "not XML"),
    ((("UTF-8", "UTF-4711"),), "not XML (unknown encoding: UTF-4711)"),
    ((('positionX="10000"', 'positionX="ten"'),), "point 'B': positionX: not a number (got 'ten')"),
    ((('positionX="10000"', 'positionX="NaN"'),), "point 'B': positionX: not a number"),
    ((('positionX="10000"', 'positionX="1e99"'),), "point 'B': positionX: not a number"),
    ((('point name="B"', 'point name="A"'),), "point 'A': a point of this name stands before"),
    ((('destinationPoint="B"', 'destinationPoint="Z"'),), "leads to no point of the plant (got 'Z')"),
    ((('link point="B"', 'link point="Z"'),), "linked to no point of the plant (got 'Z')"),
    ((('type="rack"', 'type="shelf"'),), "of a type that the plant does not have (got 'shelf')"),
    ((('maxVelocity="500"', 'maxVelocity="-500"'),), "maxVelocity: below 0"),
    ((("SINGLE_VEHICLE_ONLY", "ANY"),), "type: not known (got 'ANY')"),
    ((('maxVelocity="1000"', 'maxVelocity="0"'), ('maxVelocity="500"', 'maxVelocity="0"')), "nowhere can robots drive"),
    (
        (('link point="B"', 'link point="roof"'), ('link point="D"', 'link point="roof"'), *ONLY_RACKS),
        "no location in reach",
    ),
]


@pytest.mark.parametrize(("changes", "message"), NOT_READ, ids=[message for _, message in NOT_READ])
def test_a_damaged_file_is_one_message(tmp_path, changes, message):
    assert message in one_message(yard(tmp_path, *changes))


BOMB = '<!DOCTYPE model [<!ENTITY a "aaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]>\n<model version="7.0.0" name="&b;"/>'
OUTSIDE = '<!DOCTYPE model [<!ENTITY f SYSTEM "file:///etc/passwd">]>\n<model version="7.0.0" name="&f;"/>'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not XML (no element found)"),
        ("name: a model", "not XML"),
        (BOMB, "a document type, which may define entities"),
        (OUTSIDE, "a document type"),
        ("<model version='7.0.0'>" + "<point>" * 50_000, "too many elements inside one another"),
        ("\0" * 100, "not XML"),
        ("<model version='7.0.0'/>", "no lanes, expected some on which robots drive"),
        ("<model version='7.0.0'>" + " " * 64_000_000 + "</model>", "too large"),
    ],
    ids=["empty", "yaml", "bomb", "outside", "deep", "nul", "nothing", "large"],
)
def test_a_hostile_file_is_one_message(tmp_path, text, message):
    path = tmp_path / "plant.xml"
    path.write_text(text)
    assert message in one_message(path)


def test_no_file_is_one_message(tmp_path):
    for path in (tmp_path, tmp_path / "none.xml"):
        one_message(path)


# Of others: points, paths, vehicles, stations in reach, two-way lanes, points out of reach, as counted by hand

FOREIGN = {
    "opentcs/Demo-01_v7.xml": (59, 75, 4, 8, 0, 0),
    "opentcs-touchmii/labmodel.xml": (112, 144, 1, 1, 0, 22),
    "opentcs-touchmii/zhaoqin.xml": (51, 98, 1, 6, 49, 1),
    "opentcs-touchmii/tsh.xml": (18, 18, 2, 7, 18, 0),
    "opentcs-touchmii/xxx.xml": (103, 110, 1, 24, 55, 21),
}


@needs_plants
@pytest.mark.parametrize("name", FOREIGN)
def test_plants_of_others_can_be_driven_on(name):
    made = import_layout(plant_file(name))
    model, layout = made.model, build(made.model.layout)
    assert nx.number_of_nodes(layout.graph) == len(made.plant.points)
    outside = sum(
        len(remark.names) for remark in made.remarks if (remark.what, remark.kind) == ("unreachable", "point")
    )
    counts = (
        len(made.plant.points),
        len(made.plant.links),
        model.fleet.size,
        len(layout.stations),
        len(layout.two_way),
        outside,
    )
    assert counts == FOREIGN[name]
    for fleet in (model, dw.read_layout(plant_file(name), robots=12)):
        run = dw.simulate(fleet.replace({"run.length": 1800, "fleet.start_energy": 0.9}))
        assert run.kpis["tasks"] > 0
        assert audit(run) == []


@needs_plants
def test_stations_of_others_out_of_reach_are_named():
    made = import_layout(plant_file("opentcs-touchmii/xxx.xml"))
    lost = [remark for remark in made.remarks if (remark.what, remark.kind) == ("unreachable", "location")]
    assert lost[0].names == tuple(f"Location-{number:04}" for number in range(1, 17))


@needs_plants
@pytest.mark.parametrize("name", ["opentcs/PlantModelV005.sample.xml", "opentcs/PlantModelV7.sample.xml"])
def test_samples_of_the_format_without_a_network_are_refused(name):
    assert len(read_plant(plant_file(name)).points) == 15
    with pytest.raises(dw.ModelError, match="nowhere can robots drive"):
        dw.read_layout(plant_file(name))


def test_attributes_and_elements_that_nobody_knows_are_told(tmp_path):
    path = yard(tmp_path, ("<path name=", '<path maxAcceleration="9" name='), ("<vehicle ", "<lidar/><vehicle "))
    [remark] = [one for one in read_plant(path).remarks if one.kind == "key"]
    assert remark.names == ("path.maxAcceleration", "lidar")


@pytest.mark.usefixtures("brief_probes")
def test_loads_that_go_nowhere_are_told(tmp_path):
    model = dw.read_layout(yard(tmp_path))
    at = model.layout.storage[0].node
    stays = model.replace({"layout.storage": [{"node": at}], "tasks.unload_at": [at], "layout.stations": {}})
    assert "NOTHING_TO_DRIVE" in {finding.code for finding in check(stays).findings}
    assert "NOTHING_TO_DRIVE" not in {finding.code for finding in check(model).findings}


@pytest.mark.parametrize(("back", "named"), [(1, True), (90, True), (100, False), (1000, False)])
def test_a_path_that_is_crawled_back_is_named_as_one_way(tmp_path, back, named):
    """Both speeds are kept, and robots drive by time, so they go round."""
    whole = 'name="D --- 100" sourcePoint="D" destinationPoint="100" length="4000" maxVelocity="1000" '
    text = YARD.read_text(encoding="utf-8")
    text = text.replace(f'{whole}maxReverseVelocity="1000"', f'{whole}maxReverseVelocity="{back}"')
    (tmp_path / "yard.xml").write_text(text, encoding="utf-8")
    made = import_layout(tmp_path / "yard.xml")
    lane = next(edge for edge in made.model.layout.edges if edge.target == "100")
    assert (lane.speed, lane.speed_back) == (1.0, None if back == 1000 else back / 1000)
    assert made.model.policies.routing.name == "fastest"
    assert (("link", ("D --- 100",)) in remarks(made, "doubtful")) == named
