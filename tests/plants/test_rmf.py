"""Maps of Open-RMF: one drawn for these tests, worked out by hand, and those of others where they are."""

import copy
import json
from pathlib import Path

import pytest

import desim_warehouse as dw
from desim_warehouse.layout import build
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.plants import import_layout, read_plant
from tests.auditor import audit
from tests.plants.damage import one_message
from tests.plants.foreign import needs_plants, plant_file, remarks

CLINIC = Path(__file__).parent / "clinic.building.yaml"
TEXT = CLINIC.read_text()


def clinic(tmp_path, *changes):
    """The map with some of its text changed."""
    text = TEXT
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    path = tmp_path / "clinic.building.yaml"
    path.write_text(text)
    return path


def test_a_building_map_in_metres_is_read():
    plant = read_plant(CLINIC)
    assert (len(plant.points), len(plant.links), len(plant.vehicles)) == (9, 9, 2)
    a = plant.points["A"]
    assert (a.x, a.y, a.parking, a.position) == (5, 5, False, "line 30")
    assert plant.points["dock 1"].parking
    one_way, mutex, slow = plant.links[:3]
    assert (one_way.speed_back, mutex.speed_back, slow.speed) == (0, float("inf"), 0.5)


def test_a_map_that_has_the_editor_s_name_is_called_by_its_file(tmp_path):
    assert "\nname: " in TEXT
    named = next(line for line in TEXT.splitlines() if line.startswith("name: "))
    assert read_plant(clinic(tmp_path, (named, "name: building"))).name == "clinic"
    assert read_plant(clinic(tmp_path, (named, "name: my ward"))).name == "my ward"


def test_pick_ups_drop_offs_and_chargers_of_a_building_map_are_read():
    model = dw.read_layout(CLINIC)
    assert [place.node for place in model.layout.storage] == ["pantry"]
    assert dict(model.layout.stations)["bedside"].at == ("ward",)
    assert model.layout.bays["chargers"].at == ("dock 1", "dock 2")
    assert (model.fleet.size, model.fleet.start) == (2, ("dock 1", "dock 2"))
    edges = {(edge.source, edge.target): edge.two_way for edge in model.layout.edges}
    assert len(edges) == 9
    assert [ends for ends, two_way in edges.items() if not two_way] == [("A", "vertex 3")]
    assert build(model.layout).graph.edges["A", "vertex 3"]["length"] == 20
    zone = model.traffic.zones["crossing"]
    assert (zone.members, zone.rule) == ((("vertex 3", "vertex 4"), "vertex 4"), "one-robot")


def test_the_clinic_can_be_driven_in():
    for robots in (None, 20):
        run = dw.simulate(
            dw.read_layout(CLINIC, robots=robots).replace({"run.length": 3600, "fleet.start_energy": 0.9})
        )
        assert run.kpis["tasks"] > 10
        assert audit(run) == []


def test_what_could_not_be_carried_over_is_said_by_name_and_line():
    made = import_layout(CLINIC)
    assert remarks(made, "left out") == {
        ("lane", ("11 - 12 of graph 1", "12 - 2 of graph 1")),
        ("orientation", ("vertex 4 - vertex 5",)),
        ("lift", ("vertex 4 - ward",)),
        ("lift", ("lift 1",)),
        ("dock", ("ward",)),
        ("door", ("front door",)),
        ("location", ("A", "lounge")),
    }
    positions = {
        remark.kind: remark.positions for remark in made.remarks if remark.names[:1] == ("vertex 4 - vertex 5",)
    }
    assert positions["orientation"] == ("line 14",)


def test_a_named_place_is_what_it_is_mapped_to():
    model = dw.read_layout(CLINIC, operations={"lounge": "unload", "dropoff": "none"})
    assert set(model.layout.stations) == {"lounge"}


def test_another_graph_has_lanes_of_its_own(tmp_path):
    plant = read_plant(CLINIC, graph=1)
    assert set(plant.points) == {"gate", "vertex 12", "A"}
    with pytest.raises(dw.ModelError, match="no lanes of graph 2, expected one of 0, 1"):
        read_plant(CLINIC, graph=2)
    for graph in (-1, 0.5, "one", [1], True):
        with pytest.raises(dw.ModelError, match=r"graph .*: expected a whole number from 0 on"):
            read_plant(CLINIC, graph=graph)


def test_distances_that_differ_are_doubted(tmp_path):
    # 10 m, 4.9 m and 5.1 m of 200, 100 and 100 pixels: 5 cm a pixel
    assert ("scale", "doubtful") not in {(remark.kind, remark.what) for remark in read_plant(CLINIC).remarks}
    plant = read_plant(clinic(tmp_path, ("[3, 4.9]", "[3, 7.9]")))
    assert [remark.names for remark in plant.remarks if remark.kind == "scale"] == [
        ("0.05 m a pixel", "0.079 m a pixel", "0.051 m a pixel")
    ]
    assert plant.points["A"].x == pytest.approx(100 * (0.05 + 0.079 + 0.051) / 3)


def test_a_map_in_metres_points_upwards(tmp_path):
    plant = read_plant(clinic(tmp_path, ("reference_image", "cartesian_meters")))
    assert (plant.points["A"].x, plant.points["A"].y) == (100, -100)


def nav_graph():
    """The graph that the building map is made into."""
    level = read_yaml(TEXT, "clinic").data["levels"]["L1"]
    vertices, lanes = [], []
    for x, y, _, name, *about in level["vertices"]:
        plain = {key: value for key, (_, value) in (about or [{}])[0].items()}
        vertices.append([x / 20, -y / 20, {"name": name, **plain}])
    for a, b, about in level["lanes"]:
        if about["graph_idx"][1] == 0:
            plain = {key: about[key][1] for key in ("speed_limit", "mutex") if key in about}
            lanes += [[a, b, plain]] + ([[b, a, plain]] if about["bidirectional"][1] else [])
    return {
        "building_name": "clinic",
        "doors": {"front door": {"map": "L1"}},
        "levels": {"L1": {"lanes": lanes, "vertices": vertices}},
        "lifts": {},
    }


def test_a_navigation_graph_says_the_same(tmp_path):
    path = tmp_path / "0.yaml"
    path.write_text(json.dumps(nav_graph()))
    plant = read_plant(path)
    assert (len(plant.points), len(plant.links)) == (9, 17)
    assert ("door", ("front door",)) in {(remark.kind, remark.names) for remark in plant.remarks}
    building, graph = dw.read_layout(CLINIC), dw.read_layout(path)
    assert graph.layout.nodes == building.layout.nodes
    assert {(one.source, one.target, one.two_way) for one in graph.layout.edges} == {
        (one.source, one.target, one.two_way) for one in building.layout.edges
    }
    assert (graph.fleet, graph.layout.bays) == (building.fleet, building.layout.bays)


def test_one_level_at_a_time(tmp_path):
    data = read_yaml(TEXT, "clinic").data
    data["levels"]["L2"] = copy.deepcopy(data["levels"]["L1"])
    del data["levels"]["L2"]["lanes"][8:], data["levels"]["L2"]["measurements"]
    path = tmp_path / "two.building.yaml"
    path.write_text(json.dumps(data))
    assert [remark.names for remark in read_plant(path).remarks if remark.kind == "level"] == [("L2",)]
    upper = read_plant(path, layout="L2")
    assert len(upper.links) == 8
    assert (upper.points["A"].x, "scale") in {(5, remark.kind) for remark in upper.remarks}  # as on the other level
    with pytest.raises(dw.ModelError, match="no level 'L3', expected one of L1, L2"):
        read_plant(path, layout="L3")


DAMAGED = [
    ((("levels:", "storeys:"),), "no levels, as a map of Open-RMF has, and of no other program"),
    ((("- [2, 3,", "- [2, 33,"),), "line 12: a lane to vertex 33, expected one from 0 to 14"),
    ((("- [2, 3,", "- [2, -1,"),), "not a lane (got [2, -1,"),
    ((("- [2, 3,", "- [2, 3.5,"),), "not a lane"),
    ((("- [2, 3,", "- [2, true,"),), "not a lane"),
    ((("speed_limit: [3, 0.5]", "speed_limit: [3, fast]"),), "speed_limit: not a number (got 'fast')"),
    ((("speed_limit: [3, 0.5]", "speed_limit: [3, .nan]"),), "speed_limit: not a number (got .nan)"),
    ((("graph_idx: [2, 1]", "graph_idx: [2, one]"),), "graph_idx: not a whole number (got 'one')"),
    ((("[100, 100, 0, A]", "[100, .inf, 0, A]"),), "not a number (got .inf)"),
    ((("[100, 100, 0, A]", "[100, 1e308, 0, A]"),), "not a number (got 1e+308)"),
    ((("[100, 100, 0, A]", "[100]"),), "not a vertex (got [100])"),
    ((("[100, 100, 0, A]", "A"),), "not a vertex (got 'A')"),
    ((("distance: [3, 10]", "distance: [3, 0]"),), "not a distance (got 0)"),
    ((("distance: [3, 10]", "length: [3, 10]"),), "not a number (got nothing)"),
    ((("- [0, 1, {distance", "- [0, 99, {distance"),), "not a measurement"),
    ((("    measurements:", "    measured:"),), "no measurements, so nobody knows how long a pixel is"),
    ((("reference_image", "mars"),), "coordinate_system: not known (got 'mars')"),
    ((("    lanes:", "    lines:"),), "no lanes, expected some on which robots drive"),
    ((("    lanes:", "    lanes: 5\n    lines:"),), "levels.L1.lanes: not a list (got 5)"),
    ((("    vertices:", "    vertices: 5\n    points:"),), "not a list (got 5)"),
    ((("\nname: clinic", "\nname: clinic\nname: again"),), "given twice"),
    ((("\nname: clinic", "\nname: !!python/name:os.system x"),), "unknown tag"),
    ((("  L1:", "  1:"),), "not a name (got 1)"),
    ((("  L1:", "  L1: 5\n  L2:"),), "levels.L1: not a level (got 5)"),
]


@pytest.mark.parametrize(("changes", "message"), DAMAGED, ids=[str(message) for _, message in DAMAGED])
def test_a_damaged_map_is_one_message(tmp_path, changes, message):
    assert message in one_message(clinic(tmp_path, *changes))


BOMB = "a: &a [x, x, x, x, x, x, x, x]\n" + "".join(
    f"{b}: &{b} [{', '.join([f'*{a}'] * 8)}]\n" for a, b in zip("abcdefgh", "bcdefghi", strict=True)
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no levels"),
        ("[]", "no levels"),
        ("levels: {}", "a map of Open-RMF without levels: nothing is drawn yet"),
        ("levels: [1, 2]", "no levels"),
        ("levels: {L1: {}}", "no measurements"),
        ("levels: {L1: 5}", "not a level"),
        ("levels: {L1: [", "not valid YAML"),
        (BOMB + "levels: *i", "too many values"),
        ("levels: &a {L1: *a}", "an alias that contains itself"),
        ("levels: " + "[" * 100_000, "too many lists or sections"),
        ("levels: \0", "not text"),
        ("levels: \xff", "not UTF-8"),
        ("levels: {}\n" + "#" * 1_000_000, "too large"),
        ("name: a model\nlayout: {}\nfleet: {}\ntasks: {}", "no levels"),
    ],
    ids="empty list none levels empty-level number open bomb ring deep nul bytes large model".split(),  # noqa: SIM905
)
def test_a_hostile_map_is_one_message(tmp_path, text, message):
    path = tmp_path / "map.yaml"
    path.write_bytes(text.encode("latin-1"))
    assert message in one_message(path)


# Of others: lanes and vertices as listed, points on lanes, robots, places of work, chargers, as counted by hand

FOREIGN = {
    "office": (30, 73, 29, 2, ["coke_ingestor", "coke_ingestor_2"], 2),
    "triple_H": (22, 51, 23, 4, None, 4),  # no place of work is drawn: robots work where they park
    "battle_royale": (20, 53, 21, 4, ["goal_A", "goal_B", "goal_C", "goal_D"], 4),
}


@needs_plants
@pytest.mark.parametrize("name", FOREIGN)
@pytest.mark.parametrize("length", [600, pytest.param(1800, marks=pytest.mark.long)])
def test_maps_of_others_can_be_driven_in(name, length):
    path, (lanes, vertices, points, robots, stations, chargers) = plant_file(f"rmf/{name}.building.yaml"), FOREIGN[name]
    level = read_yaml(path.read_text(), name).data["levels"]["L1"]
    assert (len(level["lanes"]), len(level["vertices"])) == (lanes, vertices)
    made = import_layout(path)
    model, layout = made.model, build(made.model.layout)
    assert (len(made.plant.links), len(made.plant.points)) == (lanes, points)
    assert len(layout.two_way) == lanes
    assert model.fleet.size == len(model.fleet.start) == robots
    assert len(model.layout.bays["chargers"].at) == chargers
    if stations is not None:
        assert sorted(model.layout.stations) == stations
    done = {}
    for fleet in (robots, 20, 50) if length > 1000 else (robots, 20):
        full = {"run.length": length, "fleet.start_energy": 1}  # in the long run its four chargers feed 16 robots
        others = model if fleet == robots else dw.read_layout(path, robots=fleet)
        run = dw.simulate(others.replace(full))
        assert audit(run) == []
        done[fleet] = run.kpis["tasks"]
    assert done[robots] > length / 60
    assert done[20] > done[robots]  # and 50 robots hardly do more: the lanes are full


@needs_plants
def test_a_fleet_of_150_on_a_map_of_others():
    model = dw.read_layout(plant_file("rmf/office.building.yaml"), robots=150)
    run = dw.simulate(model.replace({"run.length": 600, "battery": None}))
    assert run.kpis["tasks"] > 10
    assert audit(run) == []


def test_degrees_are_metres_around_the_middle_of_the_lanes(tmp_path):
    lanes = "lanes: [[0, 1, {bidirectional: [4, true]}], [1, 2, {bidirectional: [4, true]}]]"
    spots = "[[103.85, 1.29, 0, gate], [103.851, 1.29, 0, hall], [103.851, 1.291, 0, yard]]"
    path = tmp_path / "campus.building.yaml"
    path.write_text(f"coordinate_system: wgs84\nlevels:\n  L1:\n    {lanes}\n    vertices: {spots}\n")
    plant = read_plant(path)
    [gate, hall, yard] = plant.points.values()
    assert hall.x - gate.x == pytest.approx(111.17, abs=0.01)  # a thousandth of a degree, at 1.29 degrees north
    assert hall.y - yard.y == pytest.approx(111.19, abs=0.01)  # y is downwards
    assert gate.x + hall.x == pytest.approx(0, abs=0.01)
    assert [remark.kind for remark in plant.remarks] == ["units.length"]
    path.write_text(path.read_text().replace("103.85,", "1103.85,"))
    with pytest.raises(dw.ModelError, match="wgs84, but some vertices are no degrees"):
        read_plant(path)


def site():
    """The clinic's second floor as the site editor writes it: a one-way ring, a spur, and lanes of another graph."""
    spots = {4: (0, 0), 5: (20, 0), 6: (20, 10), 7: (0, 10), 8: (25, 0), 9: (-4, 0), 50: (30, 10)}
    ends = {70: (4, 5), 71: (5, 6), 72: (6, 7), 73: (7, 4), 74: (5, 8), 75: (4, 9), 76: (6, 50)}
    lanes = {number: {"anchors": list(pair), "graphs": "All", "reverse": "Disable"} for number, pair in ends.items()}
    for number in (74, 75):
        del lanes[number]["reverse"]
    lanes[71]["forward"] = {"speed_limit": 0.5}
    lanes[76]["graphs"], lanes[75]["graphs"] = {"Only": [61]}, {"AllExcept": [61]}
    places = {
        90: {"anchor": 8, "tags": [], "name": "pick", "graphs": "All"},
        91: {"anchor": 6, "tags": [], "name": "drop", "graphs": "All"},
        92: {"anchor": 9, "tags": ["Charger", "ParkingSpot", {"SpawnRobot": {}}], "name": "dock", "graphs": "All"},
    }
    anchors = {number: {"Translate2D": list(at)} for number, at in spots.items()}
    shared = {50: anchors.pop(50)}
    return {
        "format_version": "0.1",
        "anchors": shared,
        "properties": {"name": "clinic"},
        "levels": {"1": {"properties": {"name": "L2"}, "anchors": anchors, "walls": {}}},
        "navigation": {
            "guided": {
                "graphs": {"60": {"name": "carts"}, "61": {"name": "cleaners"}},
                "ranking": [60, 61],
                "lanes": lanes,
                "locations": places,
            }
        },
    }


def written(tmp_path, data):
    path = tmp_path / "clinic.site.json"
    path.write_text(json.dumps(data))
    return path


def test_a_site_says_what_its_navigation_graph_would(tmp_path):
    made = import_layout(written(tmp_path, site()))
    model, plant = made.model, made.plant
    assert (plant.name, plant.source) == ("clinic", "clinic.site.json (Open-RMF navigation graph, level L2)")
    edges = {(edge.source, edge.target): (edge.two_way, edge.speed) for edge in model.layout.edges}
    assert edges["vertex 0", "vertex 1"] == (False, None)
    assert edges["vertex 1", "drop"] == (False, 0.5)
    assert edges["vertex 1", "pick"] == edges["vertex 0", "dock"] == (True, None)
    assert len(edges) == 6
    assert (plant.points["drop"].x, plant.points["drop"].y) == (20, -10)
    assert ("lane", ("2 - 6 of graph 1",)) in remarks(made, "left out")
    assert model.layout.bays["chargers"].at == ("dock",)
    assert len(read_plant(written(tmp_path, site()), graph=1).links) == 6
    assert dw.simulate(model.replace({"run.length": 3600, "fleet.start_energy": 0.9})).kpis["tasks"] > 10


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("levels", "1", "anchors", "4"), {"Translate2D": "here"}, "anchor 4: not a place"),
        (("levels", "1", "anchors", "4"), {"Translate2D": ["x", 0]}, "anchor 4: levels.L2.vertices.0: not a number"),
        (("navigation", "guided", "lanes", "70"), {"anchors": [4]}, "lane 70: not between two anchors"),
        (("navigation", "guided", "lanes"), [], "no lanes"),
        (("navigation", "guided", "lanes"), [1], "lanes: not an object"),
        (("levels",), {}, "a map of Open-RMF without levels: nothing is drawn yet"),
    ],
    ids=str,
)
def test_a_damaged_site_is_one_message(tmp_path, path, value, message):
    data = json.loads(json.dumps(site()))
    *keys, last = path
    at = data
    for key in keys:
        at = at[key]
    at[last] = value
    assert message in one_message(written(tmp_path, data))


def test_keys_that_nobody_knows_are_told_by_kind(tmp_path):
    plant = read_plant(clinic(tmp_path, ("is_holding_point: [4, true]", "shelf_height: [3, 2]")))
    assert [(one.names, one.positions) for one in plant.remarks if one.kind == "key"] == [
        (("vertex.shelf_height",), ("line 33",))
    ]
