"""Layouts given node by node and edge by edge, and the zones at their nodes."""

import math

import pytest

import desim_warehouse as dw
from desim_warehouse import LayoutError
from desim_warehouse.layout import BayPlaces, StationPlaces, build
from desim_warehouse.layout.spec import LayoutSpec

SQUARE = {
    "nodes": {"A": [0, 0], "B": [30, 40], "C": [30, 0]},
    "edges": [["A", "B"], {"from": "B", "to": "C", "speed": 0.5}, {"from": "C", "to": "A", "length": 45}],
}


def layout(**more):
    return build(LayoutSpec.model_validate(SQUARE | more))


def test_edges_are_as_long_as_they_are_straight_unless_told():
    graph = layout().graph
    # 3-4-5: hypot(30, 40) = 50
    assert {(a, b): (data["length"], data["speed"]) for a, b, data in graph.edges(data=True)} == {
        ("A", "B"): (50, math.inf),
        ("B", "C"): (40, 0.5),
        ("C", "A"): (45, math.inf),
    }


def test_successors_are_tried_in_the_order_of_the_file():
    graph = layout(edges=[["A", "C"], ["A", "B"], ["B", "A"], ["C", "A"]]).graph
    assert list(graph.successors("A")) == ["C", "B"]


def test_storage_places_are_numbered_as_listed_and_stand_at_their_offset():
    storage = [{"edge": ["C", "A"], "offset": 15}, {"edge": ["A", "B"], "offset": 25, "popularity": 4}]
    first, second = layout(storage=storage).storage
    # a third of the way from C to A, although the edge is longer than it looks; the middle of A>B
    assert (first.number, first.edge, first.offset, first.x, first.y) == (0, ("C", "A"), 15, 20, 0)
    assert (second.number, second.x, second.y, second.popularity) == (1, 15, 20, 4)


def test_two_edges_of_one_label_are_refused():
    square = {"nodes": {"a": [0, 0], "b>c": [20, 0], "a>b": [20, 20], "c": [0, 20]}}
    ring = [["a", "b>c"], ["b>c", "a>b"], ["a>b", "c"], ["c", "a"]]
    text = r"layout: edges \[a, b>c\] and \[a>b, c\] have one name in tables, a>b>c; rename one of their nodes"
    with pytest.raises(LayoutError, match=text):
        layout(**square, edges=ring)
    assert layout(**square, edges=ring[:2]).graph.has_edge("a", "b>c")  # a name with > alone is none of that


def test_goods_at_a_node_of_the_label_of_an_edge_are_refused():
    """Logs write a>b>a>b where goods of node a>b are picked, too."""
    places = {"nodes": {"a": [0, 0], "b>a>b": [20, 0], "a>b": [20, 20]}, "edges": [["a", "b>a>b"]]}
    with pytest.raises(LayoutError, match=r"edges \[a, b>a>b\] and \[a>b, a>b\] have one name in tables, a>b>a>b"):
        layout(**places, storage=[{"node": "a>b"}])


def test_headings_are_angles_from_the_x_axis_towards_y():
    floor = layout()
    assert floor.headings["A", "B"] == math.atan2(40, 30)
    assert floor.headings["B", "C"] == pytest.approx(-math.pi / 2)
    assert floor.headings["C", "A"] == pytest.approx(math.pi)


def zones(**more):
    blocks = {"columns": 4, "rows": 2, "block_depth": 2, "goods_size": 1, "aisle_width": 1}
    return build(LayoutSpec.model_validate({"blocks": blocks} | more))


@pytest.mark.parametrize(
    ("places", "nodes"),
    [
        # nodes A..E, F..J, K..O
        ({"along": "north"}, "ABCDE"),
        ({"along": "south"}, "KLMNO"),
        ({"along": "west"}, "AFK"),
        ({"along": "east"}, "EJO"),
        ({"along": "south", "every": 2}, "KMO"),
        ({"along": "south", "every": 3}, "KN"),
        ({"at": ["H", "B"]}, "HB"),
        ({"at": ["H"], "along": "west"}, "HAFK"),
    ],
)
def test_a_zone_stands_at_nodes_by_name_or_along_a_side(places, nodes):
    floor = zones(bays={"home": {**places, "places": 3, "chargers": 1}})
    assert list(floor.bays.values()) == [BayPlaces("home", node, 3, 1) for node in nodes]


def test_stations_have_places_and_servers_at_each_of_their_nodes():
    floor = zones(stations={"pack": {"at": ["K", "L"], "places": 2}, "ship": {"at": ["O"], "servers": 3}})
    assert list(floor.stations.values()) == [
        StationPlaces("pack", "K", 2, 1),
        StationPlaces("pack", "L", 2, 1),
        StationPlaces("ship", "O", 4, 3),
    ]


@pytest.mark.parametrize(
    ("zones_of", "text"),
    [
        (
            {"bays": {"one": {"along": "north"}, "two": {"at": ["B"]}}},
            "layout: node B has more than one bay; give it one",
        ),
        (
            {"stations": {"one": {"at": ["O", "K"]}, "two": {"along": "south"}}},
            (
                "layout: node K has more than one station; give it one\n"
                "layout: node O has more than one station; give it one"
            ),
        ),
    ],
)
def test_two_zones_of_a_kind_cannot_share_a_node(zones_of, text):
    with pytest.raises(LayoutError) as refused:
        zones(**zones_of)
    assert str(refused.value) == text
    assert refused.value.problems == text.split("\n")


def test_a_bay_and_a_station_can_share_a_node():
    floor = zones(bays={"home": {"at": ["K"]}}, stations={"pack": {"at": ["K"]}})
    assert list(floor.bays) == list(floor.stations) == ["K"]


def test_a_bay_has_as_many_places_as_robots_start_there_and_a_charger_each():
    model = dw.load("models/multibots.yaml", {"fleet.size": 8})
    run = dw.simulate(model)
    # robots 6 and 7 start at A and B again, in bays of their own
    starts = [row[4] for row in sorted(run.record.rows) if row[1] == "parked"]
    assert sorted(starts).count("A") >= 2
    assert run.kpis["tasks"] == 10
