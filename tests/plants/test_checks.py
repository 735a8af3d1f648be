"""What looks wrong in a drawing is said, whatever its format: by name, and where it stands in the file."""

import pytest

import desim_warehouse as dw
from desim_warehouse.plants import import_layout, imported
from desim_warehouse.plants.plant import Link, Location, Plant, Waypoint
from tests.plants.foreign import needs_plants, plant_file
from tests.plants.test_opentcs import yard


def plant(*links, points=(("A", 0, 0), ("B", 10, 0), ("C", 10, 10)), locations=()):
    """Points on a floor, with links of these ends and lengths, each on a line of its own."""
    made = Plant("floor", "floor.txt")
    made.points = {name: Waypoint(name, x, y, position=f"line {rank}") for rank, (name, x, y) in enumerate(points, 1)}
    for rank, (source, target, length) in enumerate(links, 10):
        made.links.append(Link(f"{source}{target}", source, target, length, 1.0, 1.0, f"line {rank}"))
    made.locations = list(locations)
    return made


def said(made, *kinds):
    return {
        (one.what, one.kind): tuple(zip(one.names, one.positions, strict=True))
        for one in made.remarks
        if one.kind in kinds
    }


WAYS = (("A", "B", None), ("B", "C", None))


def test_lengths_shorter_than_the_straight_line():
    made = imported(plant(("A", "B", 9.8), ("B", "C", 9.95)))  # the second by rounding
    assert said(made, "link") == {("changed", "link"): (("AB", "line 10"),)}
    assert [edge.length for edge in made.model.layout.edges] == [9.8, 9.95]


def test_a_second_link_between_two_points_is_left_out():
    made = imported(plant(*WAYS, ("A", "B", 12)))
    assert said(made, "link") == {("left out", "link"): (("AB", "line 12"),)}


def test_points_on_one_spot_wherever_they_are_moved():
    points = [("A", 0, 0), ("B", 0, 0), ("C", 0.01, 0), ("D", 0, 0)]
    made = imported(plant(*WAYS, ("C", "D", 5), points=points))
    nodes = dict(made.model.layout.nodes)
    assert len({tuple(at) for at in nodes.values()}) == 4
    assert nodes["A"] == (0, 0)
    assert [name for name, _ in said(made, "point")["changed", "point"]] == ["B", "C", "D"]


def test_a_thousand_points_on_one_spot():
    points = [(f"P{rank}", 5, 5) for rank in range(1000)]
    made = imported(plant(*((f"P{rank}", f"P{rank + 1}", 3) for rank in range(999)), points=points))
    assert len({tuple(at) for at in made.model.layout.nodes.values()}) == 1000


def test_locations_without_links_and_points_apart():
    points = [("A", 0, 0), ("B", 10, 0), ("C", 10, 10), ("far", 99, 0)]
    lost = Location("lost", {}, "line 20")
    island = Location("island", {"far": ("load",)}, "line 21")
    shelf = Location("shelf", {"A": ("load",), "C": ("unload",)}, "line 22")
    made = imported(plant(*WAYS, points=points, locations=[lost, island, shelf]))
    assert said(made, "location", "point") == {
        ("left out", "location"): (("lost", "line 20"),),
        ("unreachable", "location"): (("island", "line 21"),),
        ("unreachable", "point"): (("far", "line 4"),),
    }


@pytest.mark.parametrize(("metres", "doubted"), [(1, False), (1000, True)])
def test_lengths_that_look_like_millimetres(metres, doubted):
    points = [("A", 0, 0), ("B", 10 * metres, 0), ("C", 10 * metres, 10 * metres)]
    made = imported(plant(*WAYS, points=points))
    assert any(remark.kind == "unit of length" for remark in made.remarks) == doubted


@pytest.mark.parametrize(("metres", "doubted"), [(0.5, False), (0.05, True), (1e-5, True)])
def test_a_floor_on_which_no_robot_fits(metres, doubted):
    """Ten metres in km, and degrees of latitude in a table, whose numbers are metres."""
    points = [("A", 0, 0), ("B", 10 * metres, 0), ("C", 10 * metres, 10 * metres)]
    remarks = [str(one) for one in imported(plant(*WAYS, points=points)).remarks if one.kind == "floor"]
    assert [remark.partition(";")[2] for remark in remarks] == [
        f" are coordinates in km or degrees?: {10 * metres:.2g} x {10 * metres:.2g} m"
    ] * doubted


def test_energy_levels_in_the_wrong_order(tmp_path):
    before = 'energyLevelFullyRecharged="95" energyLevelSufficientlyRecharged="45" maxVelocity="1000"'
    after = 'energyLevelFullyRecharged="30" energyLevelSufficientlyRecharged="90" maxVelocity="1000"'
    [remark] = [one for one in import_layout(yard(tmp_path, (before, after))).remarks if one.what == "doubtful"]
    assert (remark.kind, remark.names, remark.positions) == ("vehicle", ("tug",), ("line 33",))
    assert remark.why == "energyLevelSufficientlyRecharged is above energyLevelFullyRecharged"


@needs_plants
def test_what_is_wrong_with_plants_of_others():
    def found(name):
        names = {}
        for one in import_layout(plant_file(name)).remarks:
            names[one.what, one.kind] = (*names.get((one.what, one.kind), ()), *one.names)
        return names

    demo = found("opentcs/Demo-01_v7.xml")
    assert "Fire door 01" in demo["left out", "location"]
    assert len(demo["changed", "link"]) > 1  # shorter than the straight line, by up to 2 m
    users = found("opentcs-touchmii/zhaoqin.xml")
    assert users["left out", "location"] == ("Location-008",)
    assert users["doubtful", "vehicle"] == ("Vehicle-01",)
    assert len(found("opentcs-touchmii/xxx.xml")["unreachable", "location"]) == 16


@needs_plants
@pytest.mark.parametrize("name", ["PlantModelV005.sample.xml", "PlantModelV7.sample.xml"])
def test_samples_of_a_format_whose_paths_lead_nowhere(name):
    with pytest.raises(dw.ModelError, match="nowhere can robots drive"):
        dw.read_layout(plant_file(f"opentcs/{name}"))


@needs_plants
def test_the_demo_runs_a_shift_with_its_vehicles():
    model = dw.read_layout(plant_file("opentcs/Demo-01_v7.xml"))
    assert (model.fleet.size, model.run.length) == (4, 8 * 3600)
    two_hours = {"run.length": 7200, "fleet.start_energy": 0.9}
    assert dw.simulate(model.replace(two_hours)).kpis["tasks"] > 100
