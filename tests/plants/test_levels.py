"""Buildings of several levels: from maps of Open-RMF and layouts in LIF, as models with lifts, and back."""

import copy
import math
from collections import Counter

import pytest

import desim_warehouse as dw
from desim_warehouse.plants import import_layout, read_plant
from tests.auditor import audit
from tests.plants.drawn_lif import dock, edge, node, station
from tests.plants.drawn_lif import write as write_lif
from tests.plants.drawn_rmf import clinic, hotel, write
from tests.plants.foreign import remarks
from tests.world.test_lifts import TWO, building

pytestmark = pytest.mark.usefixtures("brief_probes")


def driven(model, robots, hours=1):
    changes = {"fleet.size": robots, "fleet.start_energy": 0.9, "run.length": hours * 3600, "log": "all"}
    run = dw.simulate(model.replace(changes))
    assert audit(run) == []
    return run


def served(run):
    """How many loads come to each station."""
    return Counter(row[4] for row in run.record.rows if row[1] == "delivered")


# Maps of Open-RMF


def test_all_levels_to_which_lifts_lead_are_read_and_drawn_side_by_side(tmp_path):
    made = import_layout(write(tmp_path, hotel()))
    assert "levels L1, L2, L3" in made.plant.source
    lifts = made.model.layout.lifts
    # the cabins have the names of their vertices on each level, from the lowest
    assert {name: lift.nodes for name, lift in lifts.items()} == {
        "Lift1": ("vertex 3", "vertex 3 (2)", "vertex 3 (3)"),
        "Lift2": ("vertex 4", "vertex 4 (2)", "vertex 4 (3)"),
    }
    nodes = made.model.layout.nodes
    # 20 m wide as far as lanes lead, from 4 to 24, and 10 m between levels
    assert [nodes[name] for name in lifts["Lift1"].nodes] == [(14, 4), (44, 4), (74, 4)]
    assert ("level", ("L2", "L3")) in remarks(made, "changed")
    assert not [kind for kind, _ in remarks(made, "left out") if kind in {"level", "lift"}]
    assert ("lane", ("8 - 0 of graph 1",)) in remarks(made, "left out")
    (assumed,) = [one for one in made.remarks if one.kind == "layout.lifts"]
    assert (assumed.names, assumed.why) == (
        ("Lift1", "Lift2"),
        "12 s from level to level, and 4 s for the doors to open or close",
    )
    assert "lifts:  # assumed: 12 s from level to level" in made.text()
    assert made.model.floor.floor_titles == {0: "L1", 1: "L2", 2: "L3"}


def test_the_hotel_serves_rooms_on_all_levels(tmp_path):
    model = dw.read_layout(write(tmp_path, hotel()))
    assert [place.node for place in model.layout.storage] == ["restaurant"]
    assert set(model.layout.stations) == {"room 201", "room 215", "suite 2", "room 301", "room 315", "suite 3"}
    run = driven(model, 2, hours=2)
    assert min(served(run).values()) > 3
    assert run.kpis["share_in_lift"] > 0.2


def test_one_level_may_be_asked_for(tmp_path):
    plant = read_plant(write(tmp_path, hotel()), layout="L2")
    assert (len(plant.points), plant.lifts, plant.level_of) == (8, {}, {})
    left = {remark.kind: (remark.names, remark.why) for remark in plant.remarks if remark.what == "left out"}
    assert left["level"] == (("L1", "L3"), "level L2 is read; --layout reads another")
    assert left["lift"] == (("Lift1", "Lift2"), "no lanes lead to the cabin on two of the levels that are read")


def test_a_level_to_which_no_lift_leads_is_left_out(tmp_path):
    made = hotel()
    for vertex in made["levels"]["L3"]["vertices"]:
        if len(vertex) > 4:
            vertex[4].pop("lift_cabin", None)
    plant = read_plant(write(tmp_path, made))
    assert set(plant.level_of.values()) == {"L1", "L2"}
    left = {remark.kind: (remark.names, remark.why) for remark in plant.remarks if remark.what == "left out"}
    assert left["level"] == (("L3",), "no lift leads there from level L1, which is read; --layout reads another")


def test_a_cabin_that_is_driven_through_or_too_near_stands_beside_its_point(tmp_path):
    made = import_layout(write(tmp_path, clinic()))
    model = made.model
    # L1 is lower, though listed last; D is 1 m, so the lane to a cabin is at least 2 m, and 1.5 m are too short
    lifts = {name: lift.nodes for name, lift in model.layout.lifts.items()}
    assert lifts == {
        "lift_25": ("vertex 5 (2) cabin", "vertex 5 cabin"),
        "lift_1": ("vertex 6 (2) cabin", "vertex 6 cabin"),
    }
    (moved,) = [one for one in made.remarks if one.kind == "point" and one.what == "changed"]
    assert set(moved.names) == {"vertex 5 (2)", "vertex 5", "vertex 6 (2)", "vertex 6"}
    assert ("lift", ("visitors",)) in remarks(made, "left out")
    lanes = {(lane.source, lane.target): lane for lane in model.layout.edges}
    assert ("vertex 5", "vertex 5 cabin") in lanes
    at = model.layout.nodes
    assert math.dist(at["vertex 5"], at["vertex 5 cabin"]) == pytest.approx(2.02, abs=1e-3)
    report = dw.check(model)
    assert not [one for one in report.findings if one.level == "error"]
    run = driven(model, 3)
    assert run.kpis["tasks"] > 30
    assert min(served(run).values()) > 5


# Layouts in LIF


def upstairs(*more, level="1"):
    """The dock, and a floor above it whose node E an edge joins with D; further floors, each joined with another."""

    def change(made, layout):
        layout["edges"].append(edge("D", "E"))
        made["layouts"].append(
            {
                "layoutId": "first",
                "layoutVersion": "1",
                "layoutLevelId": level,
                "nodes": [node("E", 0.0, 8.0), node("F", 0.0, 0.0, "drop")],
                "edges": [edge("F", "E"), edge("E", "F"), edge("E", "D")],
                "stations": [station("attic", "F")],
            }
        )
        for name, below, its in more:
            made["layouts"].append(
                {
                    **copy.deepcopy(made["layouts"][1]),
                    "layoutId": f"level {its}",
                    "layoutLevelId": its,
                    "nodes": [node(name, 0.0, 8.0), node(f"{name}{name}", 9.0, 8.0, "drop")],
                    "edges": [edge(name, f"{name}{name}"), edge(f"{name}{name}", name), edge(name, below)],
                    "stations": [],
                }
            )

    return change


def test_edges_from_level_to_level_are_a_lift(tmp_path):
    made = import_layout(write_lif(tmp_path / "dock.lif.json", dock(upstairs())))
    # robots pass D, so the cabin stands beside it; E has one lane
    assert {name: lift.nodes for name, lift in made.model.layout.lifts.items()} == {"lift D - E": ("D cabin", "E")}
    assert ("transition", ("D-E", "E-D")) in remarks(made, "changed")
    assert ("point", ("D",)) in remarks(made, "changed")
    run = driven(made.model, 2, hours=2)
    assert run.kpis["in_lift"] > 0


@pytest.mark.parametrize(
    ("more", "lifts"),
    [
        ((("G", "E", "2"),), {"lift D - G": ("D cabin", "E", "G")}),  # in a line: one lift
        ((("G", "D", "-1"),), {"lift G - E": ("G", "D cabin", "E")}),  # by numbers of levels
        ((("G", "E", "0"),), {"lift D - E": ("D cabin", "E"), "lift G - E": ("G", "E cabin")}),
    ],
)
def test_which_edges_are_one_lift(tmp_path, more, lifts):
    plant = import_layout(write_lif(tmp_path / "dock.lif.json", dock(upstairs(*more)))).plant
    assert plant.lifts == lifts


def test_a_lift_has_the_name_of_its_edge(tmp_path):
    def named(made, layout):
        upstairs()(made, layout)
        layout["edges"][-1]["edgeName"] = "goods lift"

    plant = read_plant(write_lif(tmp_path / "dock.lif.json", dock(named)))
    assert plant.lifts == {"goods lift": ("D", "E")}


# And back


@pytest.mark.parametrize(("form", "name"), [("lif", "floors.lif.json"), ("rmf", "floors.building.yaml")])
def test_lifts_come_back(tmp_path, form, name):
    of_clinic = dw.read_layout(write(tmp_path, clinic()))
    named = dw.load(TWO, {"layout.floors": {"basement": ["hall"], "wards": ["far"]}})
    of_hotel = dw.read_layout(write(tmp_path, hotel()))
    for model in (dw.load(TWO), named, dw.load(building(2, "fastest")), of_hotel, of_clinic):
        out = dw.write_layout(model, tmp_path / name, form)
        (lost,) = [one for one in out if one.kind == "lift"]
        assert (lost.names, lost.what) == (tuple(model.layout.lifts), "left out")
        made = import_layout(tmp_path / name)
        again = made.model
        assert {key: lift.nodes for key, lift in again.layout.lifts.items()} == {
            key: lift.nodes for key, lift in model.layout.lifts.items()
        }
        assert dict(again.layout.nodes) == dict(model.layout.nodes)
        assert set(again.floor.floors.values()) == set(model.floor.floors.values())
        assert again.floor.floors == model.floor.floors
        assert again.floor.floor_names == model.floor.floor_names
        assert len(again.layout.storage) == len(model.layout.storage)


def test_in_formats_without_levels_a_lift_is_a_lane(tmp_path):
    remarks = dw.write_layout(TWO, tmp_path / "two.graphml", "graphml")
    why = {one.what: one.why for one in remarks if one.kind == "lift"}
    assert why["changed"] == "a lane from floor to floor, on which several robots drive"
    lanes = import_layout(tmp_path / "two.graphml").model.layout.edges
    assert {frozenset((one.source, one.target)) for one in lanes} >= {frozenset(("lift0", "lift1"))}
