"""Floors: blocks on several of them, lifts beside nodes in front of their doors, and names, worked out by hand."""

import math
from xml.etree import ElementTree as ET

import pytest

import desim_warehouse as dw
from desim_warehouse.layout.naming import block_nodes
from desim_warehouse.plot import floor as plan
from tests.world.test_lifts import TWO

LIFT = {"at": ["D", "D1"], "lane": 3, "ride": 8, "doors": 2}


def blocks(**layout):
    """One block of two places on each of two floors: nodes A B above C D, aisles of 2, so B is 4 east of A."""
    return {
        "name": "two floors",
        "layout": {
            "blocks": {"columns": 1, "rows": 1, "floors": 2, "block_depth": 2, "goods_size": 1, "aisle_width": 2},
            "lifts": {"main": LIFT},
            "stations": {"out": {"at": ["C"]}},
            "bays": {"home": {"at": ["B"]}},
            **layout,
        },
        "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}},
        "tasks": {"goods": [0], "unload_at": ["out"], "load_time": 0, "unload_time": 0},
        "log": "all",
    }


def wrong(**layout):
    with pytest.raises(dw.WarehouseError) as error:
        dw.simulate(dw.load(blocks(**layout)))
    return str(error.value)


def test_blocks_stand_on_each_floor_alike_and_side_by_side():
    layout = dw.load(blocks()).floor
    at = {name: (data["x"], data["y"]) for name, data in layout.graph.nodes(data=True)}
    assert (at["A"], at["B"], at["C"], at["D"]) == ((1, 1), (5, 1), (1, 5), (5, 5))
    # a block and an aisle are 4 wide, and there is room for two between the floors
    assert (at["A1"], at["D1"]) == ((17, 1), (21, 5))
    assert set(layout.graph.successors("A1")) == {f"{node}1" for node in layout.graph.successors("A")}
    below, above = layout.storage[:4], layout.storage[4:]
    assert [place.edge for place in above] == [tuple(f"{node}1" for node in place.edge) for place in below]
    assert [place.x - 16 for place in above] == [place.x for place in below]
    assert {layout.floors[node] for node in ("A", "D", "main at D")} == {0}
    assert {layout.floors[node] for node in ("A1", "D1", "main at D1")} == {1}


def test_nodes_of_large_floors_have_the_number_of_the_floor_behind():
    assert block_nodes(1, 1, 2) == (("A2", "B2"), ("C2", "D2"))
    assert block_nodes(30, 1, 1)[1][4] == "r1c4f1"


def test_a_lift_beside_a_node_has_a_lane_in_and_one_out_where_most_room_is():
    layout = dw.load(blocks()).floor
    (lift,) = layout.lifts
    assert lift.nodes == ("main at D", "main at D1")
    # lanes of D lead west and north: the cabin is to the south-east, 3 away
    data = layout.graph.nodes["main at D"]
    assert (data["x"], data["y"]) == pytest.approx((5 + 3 / math.sqrt(2), 5 + 3 / math.sqrt(2)))
    assert layout.length(("D", "main at D")) == layout.length(("main at D", "D")) == 3
    assert not layout.two_way


def test_a_good_is_fetched_upstairs():
    """It lies 2.5 down the lane A1>C1 or C1>A1, beside the ring A>B>D>C>A; the robot starts and parks at B."""
    run = dw.simulate(dw.load(blocks(), {"tasks.goods": [4]}))
    ((arrives, node),) = [(row[0], row[4]) for row in run.record.rows if row[1] == "delivered"]
    assert node == "C"
    # the cabin is downstairs: B to the stop line, doors, in, a ride, out, D1>C1>A1 to the good, on by B1 to D1
    stop = 4 + 3 - 1
    up = stop + 2 + 1 + (2 + 8 + 2) + 3
    upstairs = 4 + 4 + 4 + 4
    down = (3 - 1) + 2 + 1 + (2 + 8 + 2) + 3
    assert arrives == pytest.approx(up + upstairs + down + 4)


def test_the_cabin_rests_at_the_node_in_front_of_which_it_is_said():
    lift = dw.load(blocks(lifts={"main": {**LIFT, "rests": "D1", "cabins": 2}})).floor.lifts
    assert [one.rests for one in lift] == ["main at D1", "main at D1 2"]


def test_other_sections_may_name_what_a_lift_adds():
    hours = {"calendars": {"night": {"open": ["22:00-06:00"]}}}
    for member in ("main at D", ["D", "main at D"]):
        closed = {"traffic": {"closures": {"night": {"members": [member], "hours": "night"}}}}
        assert dw.load({**blocks(), **hours, **closed}).traffic.closures
    slow = dw.load({**blocks(), "traffic": {"slow": {"doors": {"members": [["D", "main at D"]], "speed": 0.5}}}})
    assert slow.floor.graph.edges["D", "main at D"]["speed"] == 0.5


@pytest.mark.parametrize(
    ("lift", "text"),
    [
        ({"at": ["D", "D1"]}, "main.lane: not said, expected the length of the lanes into and out of the cabin"),
        ({"at": ["D"], "lane": 3}, "main.at: too few floors (got [D]), expected a node on each of two or more"),
        ({"at": ["D", "D"], "lane": 3}, "main.at: a node twice (got 'D')"),
        ({"at": ["D", "E1"], "lane": 3}, "no such node (got 'E1')"),
        ({"at": ["D", "D1"], "nodes": ["A", "A1"], "lane": 3}, "main.at: given together with nodes"),
        ({"nodes": ["A", "A1"], "lane": 3}, "main.lane: without at, which it belongs to"),
        ({}, "main.nodes: too few floors (got [])"),
        ({"at": ["D", "D1"], "lane": 3, "rests": "A"}, "main.rests: no stop of the lift (got 'A'), expected D or D1"),
        ({"at": ["D", "D1"], "lane": 1.5}, "D>main at D is shorter than 2 (2 D), so robots would wait in the cabin"),
    ],
)
def test_a_lift_beside_nodes_that_cannot_be(lift, text):
    assert text in wrong(lifts={"main": {"ride": 8, **lift}})


def test_floors_without_a_lift_are_parts_that_robots_cannot_reach():
    report = dw.check(dw.load(blocks(lifts={})))
    assert any(finding.level == "error" for finding in report.findings)


# Names


def test_floors_have_names_or_numbers():
    assert dw.load(blocks()).floor.floor_titles == {0: "floor 0", 1: "floor 1"}
    named = dw.load(blocks(floors={"mezzanine": ["B1"]})).floor
    assert (named.floor_names, named.floor_titles) == ({0: "0", 1: "mezzanine"}, {0: "floor 0", 1: "mezzanine"})
    basement = dw.load(blocks(floors={"-1": ["A"], "G": ["A1"]})).floor
    assert basement.floor_titles == {0: "floor -1", 1: "G"}


@pytest.mark.parametrize(
    ("floors", "text"),
    [
        ({"ground": ["Z"]}, "no such node (got 'Z')"),
        ({"ground": []}, "layout.floors.ground"),
        (
            {"ground": ["A"], "hall": ["D"]},
            "layout.floors.hall: node D is on floor 'ground', from where robots drive there; give the floor one name",
        ),
    ],
)
def test_impossible_names_of_floors_are_refused(floors, text):
    assert text in wrong(floors=floors)


def test_one_floor_alone_has_no_name():
    text = wrong(lifts={}, floors={"ground": ["A"]})
    assert "layout.floors: one floor alone (got [ground]), expected layout.lifts, which lead to others" in text


def test_parts_of_a_floor_that_only_lifts_join_share_its_name():
    nodes = {**TWO["layout"]["nodes"], "lift2": [30, 0], "lift3": [30, 30], "annexe": [40, 0]}
    more = [{"from": "annexe", "to": "lift2", "two_way": True}, {"from": "ward", "to": "lift3", "two_way": True}]
    lifts = {**TWO["layout"]["lifts"], "other": {"nodes": ["lift2", "lift3"], "ride": 12}}
    changes = {"layout.nodes": nodes, "layout.edges": [*TWO["layout"]["edges"], *more], "layout.lifts": lifts}
    layout = dw.load(TWO, {**changes, "layout.floors": {"ground": ["hall", "annexe"], "wards": ["ward"]}}).floor
    assert sorted(layout.floor_names.values()) == ["ground", "ground", "wards"]


def test_names_of_floors_are_drawn(tmp_path):
    path = plan.save(dw.load(TWO, {"layout.floors": {"ground floor": ["hall"]}}), tmp_path / "floor.svg")
    words = {text.text for text in ET.parse(path).iter("{http://www.w3.org/2000/svg}text")}  # noqa: S314 - our own
    assert {"ground floor", "floor 1", "lift main"} <= words
