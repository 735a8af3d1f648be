"""Wide aisles of a layout: which lanes have room beside them, and what is said where they have none."""

import copy
from math import inf

import pytest

import desim_warehouse as dw
from desim_warehouse.layout.aisles import wide_edges
from tests.world.ring import RING

pytestmark = pytest.mark.usefixtures("brief_probes")

D = 1.0


def ring(aisles, length=10):
    """The ring with a place beside B > C, of this length, and one beside C > D; robots keep 1 apart."""
    mapping = copy.deepcopy(RING)
    mapping["layout"]["edges"][1] = {"from": "B", "to": "C", "length": length}
    mapping["layout"]["storage"] = [{"edge": ["B", "C"], "offset": 1}, {"edge": ["C", "D"], "offset": 5}]
    mapping["layout"]["aisles"] = aisles
    return dw.load(mapping)


@pytest.mark.parametrize(
    ("aisles", "wide"),
    [
        ("narrow", set()),
        ("wide", {("B", "C"), ("C", "D")}),  # no place lies beside the others
        (2, {("B", "C"), ("C", "D")}),
        (1.99, set()),
        ({"main": {"along": [["A", "B", "C"]]}}, {("B", "C")}),
        ({"main": {"along": [["A", "B", "C"]], "width": 1.5}}, set()),
        ({"one": {"along": [["B", "C"]], "width": "narrow"}, "two": {"along": [["C", "D"]], "width": 3}}, {("C", "D")}),
    ],
)
def test_aisles_are_wide_that_leave_room_for_two_robots(aisles, wide):
    assert wide_edges(ring(aisles).floor, D) == wide


def test_widths_are_lengths_with_units():
    mapping = {**copy.deepcopy(RING), "units": {"length": "m"}}
    mapping["layout"]["aisles"] = "320 cm"
    assert dw.load(mapping).floor.widths["A", "B"] == pytest.approx(3.2)
    mapping["layout"]["aisles"] = "wide"
    assert dw.load(mapping).floor.widths["A", "B"] == inf


def test_both_directions_of_a_two_way_lane_are_wide():
    mapping = copy.deepcopy(RING)
    mapping["layout"]["edges"][2] = {"from": "C", "to": "D", "two_way": True}
    mapping["layout"]["aisles"] = {"main": {"along": [["D", "C"]]}}
    assert wide_edges(dw.load(mapping).floor, D) == {("C", "D"), ("D", "C")}


def findings(model):
    return {item.code: item.text for item in dw.check(model).findings if item.code.startswith("AISLES")}


def test_check_says_where_robots_load_in_the_lane_all_the_same():
    assert findings(ring("wide")) == findings(ring("narrow")) == {}
    assert findings(ring(1.5)) == {
        "AISLES_TIGHT": "1.5 is too narrow for two robots side by side, which need 2 (2 D), so those that load stand "
        "in their lanes: B>C, C>D"
    }
    assert findings(ring("wide", length=1.9)) == {
        "AISLES_SHORT": "edges in wide aisles are shorter than 2 (2 D), so robots load in the lane: B>C"
    }


@pytest.mark.parametrize("aisles", [0.7, {"main": {"along": [["A", "B"]], "width": 0.7}}])
def test_no_robot_fits_into_an_aisle_narrower_than_itself(aisles):
    """A robot is a metre wide."""
    (error,) = dw.check(ring(aisles)).errors
    assert (error.code, error.text) == ("ROBOT_WIDER_THAN_AISLE", "an aisle is 0.7 m wide, a robot 1 (2 x its radius)")
    assert error.place == ("layout.aisles.main.width" if isinstance(aisles, dict) else "layout.aisles")


@pytest.mark.parametrize(
    ("along", "says"),
    [
        ([["A", "C"]], "layout.aisles.a.along.0: no edge from one to the next"),
        ([["A", "B"], ["B"]], "layout.aisles.a.along.1: one node"),
        ([], "layout.aisles.a.along"),
    ],
)
def test_aisles_lie_along_edges(along, says):
    with pytest.raises(dw.ModelError, match=says):
        ring({"a": {"along": along}})


def test_an_edge_has_one_width():
    model = ring({"a": {"along": [["A", "B"]]}, "b": {"along": [["B", "A"]], "width": 3}})
    with pytest.raises(dw.LayoutError, match=r"layout\.aisles\.b: A>B has another width"):
        _ = model.floor


def test_aisles_of_blocks_lie_along_edges():
    blocks = {"columns": 2, "rows": 1, "block_depth": 4, "goods_size": 1, "aisle_width": 2}
    mapping = {**copy.deepcopy(RING), "layout": {"blocks": blocks, "bays": {"home": {"at": ["A"]}}}}
    mapping["tasks"] = {"goods": [0], "unload_at": ["D"], "load_time": 5, "unload_time": 3}
    mapping["layout"]["aisles"] = {"a": {"along": [["A", "F"]]}}
    with pytest.raises(dw.LayoutError, match=r"layout\.aisles\.a: no edge between A and F"):
        _ = dw.load(mapping).floor


def test_pods_stand_where_robots_would():
    mapping = dw.load("models/gallery/goods-to-person.yaml").content()
    mapping["layout"]["aisles"] = "wide"
    with pytest.raises(dw.ModelError, match=r"layout\.aisles: pods stand beside the lanes"):
        dw.load(mapping)
