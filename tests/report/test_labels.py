"""Names on drawings stand beside what they name, and cover nothing."""

import itertools
import xml.etree.ElementTree as ET

import pytest

import desim_warehouse as dw
from desim_warehouse.folders import gallery
from desim_warehouse.look.labels import Sheet, box_around, boxes_along
from desim_warehouse.outcome.zones import zones
from desim_warehouse.plot import floor
from desim_warehouse.questions.run.drawings import names_of_zones

NODE = box_around(0, 0, 1)
SIZE = (4, 2)


def put(sheet, side, **how):
    spot = sheet.put([SIZE], NODE, 1, side, **how)
    return spot and spot[0]


def test_a_name_stands_on_the_side_that_is_asked_for_where_it_is_free():
    assert put(Sheet([NODE]), (0, -1)).box == (-2, -4, 2, -2)
    assert put(Sheet([NODE]), (1, 0)).box == (2, -1, 6, 1)


def test_a_text_beside_a_node_is_held_at_its_near_end():
    east, west = (put(Sheet([NODE]), side) for side in ((1, 0), (-1, 0)))
    assert ((east.x, east.y), (west.x, west.y)) == ((2, 0), (-2, 0))


def test_a_name_goes_round_a_mark_to_the_nearest_side():
    """Above is another node, and north-east a lane, so north-west is next."""
    above, lane = box_around(0, -3, 1), (2, -5, 9, -2)
    assert put(Sheet([NODE, above], [lane]), (0, -1)).box == (-6, -4, -2, -2)


def test_a_name_covers_a_lane_rather_than_nothing_and_a_mark_never():
    everywhere = (-50, -50, 50, 50)
    assert put(Sheet([NODE], [everywhere]), (0, -1)).box == (-2, -4, 2, -2)
    assert put(Sheet([everywhere]), (0, -1)) is None


def test_a_name_that_stands_elsewhere_is_worth_no_line():
    assert put(Sheet([NODE], [(-50, -50, 50, 50)]), (0, -1), again=True) is None


def test_a_small_name_on_its_side_is_preferred_to_a_large_one_elsewhere():
    """Beside the node above there is room for two letters."""
    sheet = Sheet([NODE, (1, -9, 9, 9), (-9, -9, -1, 9)])
    spot, size = sheet.put([SIZE, (2, 1)], NODE, 1, (0, -1))
    assert (spot.box, size) == ((-1, -3, 1, -2), 1)


def test_a_name_keeps_its_place_free_of_the_next():
    sheet = Sheet([NODE])
    assert put(sheet, (0, -1)).box != put(sheet, (0, -1)).box


def test_a_slanted_line_is_covered_in_pieces():
    assert list(boxes_along((0, 0), (3, 4), 2.5)) == [(0, 0, 1.5, 2), (1.5, 2, 3, 4)]
    assert list(boxes_along((3, 1), (0, 1), 0.1)) == [(0, 1, 3, 1)]


def apart(one, other):
    return one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]


@pytest.mark.parametrize("name", gallery())
def test_on_the_floors_of_the_gallery_zones_have_their_names_over_nothing_else(name):
    model = dw.load(gallery()[name])
    places = zones(model, model.floor)
    room = 0.03 * max(data["x"] for _, data in model.floor.graph.nodes(data=True))
    named = names_of_zones(model.floor, places, room)
    assert {name for _, name, _ in named} == {zone.name for zone in places}
    boxes = [spot.box for _, _, spot in named]
    assert all(apart(one, other) for one, other in itertools.combinations(boxes, 2))
    nodes = [box_around(data["x"], data["y"], 0.4 * room) for _, data in model.floor.graph.nodes(data=True)]
    slots = [box_around(x, y, zone.room) for zone in places for x, y in zone.places]
    assert all(apart(box, mark) for box in boxes for mark in nodes + slots)


def test_the_drawing_of_a_hospital_has_the_names_of_all_nodes_stations_and_its_lift(tmp_path):
    model = dw.load(gallery()["hospital"])
    drawn = ET.parse(floor.save(model, tmp_path / "floor.svg"))  # noqa: S314 - our own file
    words = {text.text for text in drawn.iter("{http://www.w3.org/2000/svg}text")}
    assert words >= {*model.floor.graph, "wards", "kitchen", "laundry", "home", "lift main"}
