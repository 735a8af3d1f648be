"""What desim check says of lifts: where robots would wait or work in a cabin, or drive through it. D = 1."""

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.check import check
from tests.world.test_lifts import TWO

pytestmark = pytest.mark.usefixtures("brief_probes")

LIFT = "layout.lifts.main"


def said(*codes, **changes):
    model = dw.load(TWO, {key.replace("__", "."): value for key, value in changes.items()})
    return [str(one) for one in check(model).findings if one.code in codes]


def test_a_building_as_it_should_be_has_no_errors():
    assert said("LIFT", "SHORT_EDGES", "EDGES_BELOW_2D", "CROSSING_EDGES", "LANES_OVERLAP") == []


def with_edge(a, b, **more):
    return {"layout__edges": [*TWO["layout"]["edges"], {"from": a, "to": b, "two_way": True, **more}]}


def test_a_lift_with_two_lanes_on_one_floor_could_be_driven_through():
    (text,) = said("LIFT", **with_edge("home", "lift0"))
    assert "lift0 has lanes to hall, home, so robots could drive through the cabin; join it to one node" in text


def test_a_short_lane_would_make_robots_wait_in_the_cabin():
    edges = [{**edge, "length": 1.9} if edge["to"] == "lift0" else edge for edge in TWO["layout"]["edges"]]
    (text,) = said("LIFT", layout__edges=edges)
    assert "hall>lift0 is shorter than 2 (2 D), so robots would wait in the cabin; make it longer" in text


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"layout__stations": {"wards": {"at": ["lift1"]}}}, "station wards"),
        ({"layout__bays": {"yard": {"at": ["lift0"], "places": 4}}}, "bay yard"),
        ({"layout__storage": [{"node": "lift0"}]}, "good 0"),
        ({"traffic__zones": {"doors": {"members": [["hall", "lift0"]], "rule": "one-robot"}}}, "zone doors"),
    ],
)
def test_nothing_else_is_in_a_lift(changes, what):
    texts = said("LIFT", **changes)
    assert len(texts) == 1
    assert what in texts[0]
    assert "robots would be in the cabin; move it to the node in front of the doors" in texts[0]


def test_no_robot_starts_in_a_lift():
    (text,) = said("START_ON_LANES", fleet__start_on_lanes=[{"node": "lift0"}])
    assert "robot 0 on node lift0 is in a lift; start it in front of the doors" in text


def test_a_lift_is_not_open_to_all():
    (text,) = said("LIFT", traffic__nodes={"lift0": {"free": True}})
    assert "a lift carries one robot at a time, and cannot be open to all" in text


def test_closures_name_the_lanes_to_the_doors():
    """Rides cannot be named: they are no edges of the file. A node of a lift stands for the lanes to its doors."""
    hours = {"calendars": {"night": {"open": ["22:00-06:00"]}}}
    shut = {"shut": {"members": ["lift0"], "hours": "night"}}
    assert said("CLOSURE", **hours, traffic__closures=shut) == []
    for key, part in (
        ("traffic.closures", {"shut": {**shut["shut"], "members": [["lift0", "lift1"]]}}),
        ("people", {"visitors": {"aisles": [["lift0", "lift1"]], "per_hour": 10, "stay": 20}}),
        ("traffic.slow", {"ride": {"members": [["lift0", "lift1"]], "speed": 0.1}}),
    ):
        with pytest.raises(dw.ModelError, match="edge"):
            dw.load(TWO, {**hours, key: part})


def test_the_lanes_to_the_doors_may_close():
    hours = {"calendars": {"night": {"open": ["00:00-00:02"]}}}
    doors = {"doors": {"members": [["hall", "lift0"], ["lift1", "ward"]], "hours": "night", "tasks": "go"}}
    run = dw.simulate(dw.load(TWO, {**hours, "traffic.closures": doors}))
    # loaded at 15; it enters the lane to the doors when that opens, at 120
    assert run.kpis["waiting_closed"] == 105
    assert run.kpis["T"] == 140 + 105


@pytest.mark.parametrize(
    ("lift", "text"),
    [
        ({"nodes": ["lift0"], "ride": 12}, "too few floors (got [lift0]), expected a node on each of two or more"),
        ({"nodes": ["lift0", "lift0"], "ride": 12}, "a node twice (got 'lift0')"),
        ({"nodes": ["lift0", "cellar"], "ride": 12}, "no such node (got 'cellar')"),
        ({"nodes": ["lift0", "lift1"], "ride": 0}, "main.ride: "),
        ({"nodes": ["lift0", "lift1"], "ride": 12, "rests": "hall"}, "no stop of the lift (got 'hall')"),
    ],
)
def test_a_lift_that_cannot_be(lift, text):
    with pytest.raises(dw.ModelError) as error:
        dw.load(TWO, {"layout.lifts": {"main": lift}})
    assert text in str(error.value)


def test_an_edge_beside_a_ride_is_refused():
    with pytest.raises(dw.WarehouseError, match="the edge lift0>lift1 leads from floor to floor, as its rides do"):
        dw.simulate(dw.load(TWO, {"layout.edges": with_edge("lift0", "lift1")["layout__edges"]}))


# Several cabins side by side


def test_another_cabin_has_lanes_of_its_own_from_the_same_nodes():
    layout = dw.load(TWO, {"layout.lifts.main.cabins": 2, "layout.lifts.main.rests": "lift1"}).floor
    first, second = layout.lifts
    assert (first.name, first.nodes, first.model_name) == ("main", ("lift0", "lift1"), "main")
    assert (second.name, second.nodes, second.rests, second.model_name) == (
        "main 2",
        ("lift0 2", "lift1 2"),
        "lift1 2",
        "main",
    )
    assert layout.length(("hall", "lift0 2")) == layout.length(("lift0 2", "hall")) == 10
    assert layout.graph.edges["hall", "lift0 2"]["two_way"]
    # on the side of the hall where most room is: the other lanes of the hall lead east and west
    assert abs(layout.points["lift0 2"] - layout.points["hall"]) == pytest.approx(10)
    assert layout.points["lift0 2"].real == pytest.approx(10)
    assert layout.floors["lift0 2"] == layout.floors["hall"] == 0
    assert {layout.rides[ride].name for ride in layout.rides if "lift1 2" in ride} == {"main 2"}


def test_a_model_with_several_cabins_has_no_errors_of_its_own():
    codes = {one.code for one in dw.check(dw.load(TWO, {"layout.lifts.main.cabins": 3})).findings}
    assert codes <= {one.code for one in dw.check(dw.load(TWO)).findings} | {"LIFT_UNUSED"}


def test_what_is_said_of_the_node_of_a_lift_holds_for_all_its_cabins():
    hours = {"calendars": {"night": {"open": ["00:00-00:02"]}}}
    for members in ([["hall", "lift0"], ["lift1", "ward"]], ["lift0", "lift1"]):
        shut = {"night": {"members": members, "hours": "night", "tasks": "go"}}
        model = dw.load(TWO, {**hours, "traffic.closures": shut, "layout.lifts.main.cabins": 2})
        assert dw.simulate(model).kpis["waiting_closed"] == 105


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"traffic__nodes": {"lift0": {"time": 3}}}, "the time would be spent in one of several cabins"),
        ({"traffic__nodes": {"lift0": {"free": True}}}, "a lift carries one robot at a time"),
    ],
)
def test_what_cannot_hold_for_several_cabins_is_refused(changes, text):
    assert text in said("LIFT", layout__lifts__main__cabins=2, **changes)[0]


def test_a_node_that_has_the_name_of_another_cabin_is_refused():
    nodes = {"layout.nodes": {**TWO["layout"]["nodes"], "lift0 2": [9, 9]}, "layout.lifts.main.cabins": 2}
    with pytest.raises(dw.WarehouseError, match="node 'lift0 2' is there already"):
        dw.simulate(dw.load(TWO, nodes))


def test_cabins_share_the_rides_of_people():
    """A cabin more brings no riders of its own: 20 rides an hour are 10 with each of two cabins."""
    shared = {"layout.lifts.main.cabins": 2, "layout.lifts.main.people": {"per_hour": 20, "transfer": "3 s"}}
    model = dw.load(TWO, shared)
    rates = [lift.people.per_hour for lift in model.floor.lifts]
    assert sum(rates) == pytest.approx(model.layout.lifts["main"].people.per_hour)
    assert len(set(rates)) == 1
