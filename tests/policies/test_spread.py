"""Equally short ways shared among robots, and edges that count more against their preferred direction."""

import math
import random
from itertools import pairwise

import networkx as nx
import pytest

import desim_warehouse as dw
from desim_warehouse.layout.oracle import RouteOracle
from desim_warehouse.questions.check import check
from desim_warehouse.questions.orient import orient
from desim_warehouse.world import World
from tests.policies.test_travel import NODE_TIME, SPEED, total

pytestmark = pytest.mark.usefixtures("brief_probes")

TIES = range(1, 9)


def square(side, draw=None):
    """A two-way grid of unit cells, or of edges of 1, 2 or 3 with speed limits."""
    made = nx.DiGraph()
    for x in range(side):
        for y in range(side):
            for there in ((x + 1, y), (x, y + 1)):
                if max(there) < side:
                    length, speed = (1.0, math.inf) if draw is None else (draw.choice([1.0, 2.0]), draw.choice([1, 9]))
                    for edge in (((x, y), there), (there, (x, y))):
                        made.add_edge(*(f"{a}{b}" for a, b in edge), length=length, speed=speed)
    for _, _, data in made.edges(data=True):
        data["time"] = data["length"] / min(SPEED, data["speed"]) + NODE_TIME
    return made


def test_robots_in_a_grid_take_several_of_the_equally_short_ways():
    oracle = RouteOracle(square(4), "length", SPEED, NODE_TIME)
    ways = {tuple(oracle.way("00", "33", tie)) for tie in TIES}
    assert len(ways) >= 4
    assert {len(way) for way in ways} == {7}


@pytest.mark.parametrize("cost", ["length", "time"])
@pytest.mark.parametrize("hubs", [(), ("00", "23")])
def test_every_way_is_as_long_and_takes_as_long_as_the_oracle_says(cost, hubs):
    """So estimates of allocation and batteries hold, whichever is taken."""
    made = square(5, random.Random(3))
    oracle = RouteOracle(made, cost, SPEED, NODE_TIME, hubs)
    ways = set()
    for origin in made:
        for goal in made:
            for tie in TIES:
                way = oracle.way(origin, goal, tie)
                ways.add(tuple(way))
                assert (way[0], way[-1]) == (origin, goal)
                assert total(made, way, "length") == pytest.approx(oracle.length(origin, goal))
                assert total(made, way, "time") == pytest.approx(oracle.time(origin, goal))
    assert len(ways) > len(made) ** 2


def test_a_way_as_short_that_takes_longer_is_not_taken():
    made = nx.DiGraph()
    for way in ("aXb", "aYb", "apqb"):
        for edge in pairwise(way):
            made.add_edge(*edge, length=6 / (len(way) - 1), speed=math.inf)
    oracle = RouteOracle(made, "length", SPEED, NODE_TIME)
    assert {"".join(oracle.way("a", "b", tie)) for tie in range(20)} == {"aXb", "aYb"}


GRID = {
    "layout": {
        "nodes": {f"{x}{y}": [3 * x, 3 * y] for x in range(4) for y in range(4)},
        "edges": [
            *({"from": f"{x}{y}", "to": f"{x + 1}{y}", "two_way": True} for x in range(3) for y in range(4)),
            *({"from": f"{x}{y}", "to": f"{x}{y + 1}", "two_way": True} for x in range(4) for y in range(3)),
        ],
        "storage": [{"edge": ["23", "33"], "offset": 1.5}],
        "bays": {"home": {"at": ["00"]}},
    },
    "fleet": {"size": 3, "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {"goods": {"random": 12}, "unload_at": ["30"], "load_time": 1, "unload_time": 1},
    "policies": {"routing": {"name": "shortest", "spread": 4}},
}


def test_a_run_takes_ways_in_a_turn_that_is_always_the_same():
    runs = [dw.simulate(dw.load(GRID), 5) for _ in range(2)]
    assert runs[0].record.rows == runs[1].record.rows
    alone = dw.simulate(dw.load(GRID, {"policies.routing": "shortest"}), 5)
    used = [{row[5] for row in run.record.rows if row[1] == "enter"} for run in (runs[0], alone)]
    assert len(used[0]) > len(used[1])


def test_one_way_at_a_time_is_what_it_is_without_spread():
    alone, one = (
        dw.simulate(dw.load(GRID, {"policies.routing": routing}), 5).record.rows
        for routing in ("shortest", {"name": "shortest", "spread": 1})
    )
    assert alone == one


@pytest.mark.parametrize("name", ["shortest", "fastest"])
@pytest.mark.parametrize(
    ("spread", "message"), [(0, "spread is 0, expected at least 1 route"), (1.5, "a whole number")]
)
def test_a_spread_that_is_no_number_of_routes_is_refused(name, spread, message):
    with pytest.raises(dw.ModelError, match=message):
        dw.load(GRID, {"policies.routing": {"name": name, "spread": spread}})


@pytest.mark.slow
def test_check_says_where_routes_are_not_shared():
    changes = {"traffic.turn_time": 1, "policies.routing": {"name": "fastest", "spread": 4}}
    assert "SPREAD_WITH_TURNS" in {finding.code for finding in check(dw.load(GRID, changes)).findings}
    assert "SPREAD_WITH_TURNS" not in {finding.code for finding in check(dw.load(GRID)).findings}


def loop(**back):
    """A two-way loop: from A to C by B it is 20, by D 26."""
    edges = [{"from": a, "to": b, "two_way": True} for a, b in ("BA", "CB", "AD", "DC")]
    edges[0].update(back)
    return {
        **GRID,
        "layout": {
            "nodes": {"A": [0, 0], "B": [0, 10], "C": [10, 10], "D": [13, 0]},
            "edges": edges,
            "storage": [{"edge": ["D", "C"], "offset": 5}],
            "bays": {"home": {"at": ["A", "C"], "places": 3}},
        },
        "tasks": {**GRID["tasks"], "unload_at": ["B"]},
    }


def world(routing, **back):
    return World(dw.load(loop(**back), {"policies.routing": routing}))


@pytest.mark.parametrize("routing", ["shortest", "fastest", "congestion-aware"])
def test_an_edge_counts_more_against_its_preferred_direction(routing):
    """A > B against its direction counts 16 with 1.6, 30 with 3: by D it is 13 + 10.44."""
    for against, way in ((1, "ABC"), (1.3, "ABC"), (3, "ADC")):
        made = world(routing, against=against)
        route = made.routes.route("A", "C")
        assert "A" + "".join(lane.edge[1] for lane in route) == way
        assert "".join(lane.edge[1] for lane in made.routes.route("C", "A")) == "BA"
        oracle = made.travel.ways
        assert oracle.length("A", "C") == pytest.approx(sum(lane.length for lane in route))
        assert oracle.time("A", "C") == pytest.approx(sum(lane.length for lane in route))


def test_ways_that_count_more_are_no_ties():
    """By X and by Y it is as far; against the arrow it counts more."""
    made = nx.DiGraph()
    for way in ("aXb", "aYb"):
        for edge in pairwise(way):
            made.add_edge(*edge, length=3.0, speed=math.inf)
    made.edges["a", "X"]["counts"] = 1.5
    oracle = RouteOracle(made, "length", SPEED, NODE_TIME)
    assert {"".join(oracle.way("a", "b", tie)) for tie in range(20)} == {"aYb"}
    assert (oracle.length("a", "X"), oracle.counted("a", "X")) == (3.0, 4.5)


def test_a_direction_that_nobody_drives_cannot_count():
    layout = loop(against=2)["layout"]
    layout["edges"][0]["two_way"] = False
    layout["edges"].append(["C", "A"])
    text = "edges.0..against: nobody drives from A to B, as B>A leads one way; leave it out, or say two_way"
    with pytest.raises(dw.LayoutError, match=text):
        dw.simulate(dw.load({**loop(), "layout": layout}))


def test_a_lane_made_one_way_has_no_preferred_direction_any_more():
    made = orient(dw.load(loop(against=2)))
    assert not made.layout.two_way
    assert {edge.against for edge in made.layout.edges} == {1}


def test_both_directions_cannot_be_preferred():
    layout = loop()["layout"]
    layout["edges"][0] = {"from": "A", "to": "B", "against": 2}
    layout["edges"].append({"from": "B", "to": "A", "against": 2})
    with pytest.raises(dw.LayoutError, match="both B>A and the edge back have it; leave out one"):
        dw.simulate(dw.load({**loop(), "layout": layout}))
