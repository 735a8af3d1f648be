"""Routes where robots take time to turn on nodes: times by hand, and the fastest of all routes of small networks."""

import math
import random
from itertools import pairwise

import networkx as nx
import numpy as np
import pytest

from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.layout.turning import turning

SPEED, NODE_TIME, TURN_TIME = 2.0, 1.0, 3.0


def network(number):
    """Up to 7 nodes anywhere, strongly connected."""
    draw = random.Random(number)
    names = [f"n{i}" for i in range(draw.randint(3, 7))]
    graph = nx.DiGraph()
    for name in names:
        graph.add_node(name, x=draw.uniform(0, 20), y=draw.uniform(0, 20))
    pairs = [*pairwise([*names, names[0]]), *((a, b) for a in names for b in names if a != b and draw.random() < 0.4)]
    for a, b in pairs:
        (x0, y0), (x1, y1) = ((graph.nodes[n]["x"], graph.nodes[n]["y"]) for n in (a, b))
        graph.add_edge(a, b, length=math.dist((x0, y0), (x1, y1)), speed=draw.choice([math.inf, 1.0]))
    return graph


def driven(graph, way):
    """Length and time of a route, turns between its edges included."""
    edges = list(pairwise(way))
    length = sum(graph.edges[edge]["length"] for edge in edges)
    time = sum(graph.edges[edge]["length"] / min(SPEED, graph.edges[edge]["speed"]) + NODE_TIME for edge in edges)
    return length, time + TURN_TIME * sum(turning(graph, one, other) for one, other in pairwise(edges))


@pytest.mark.parametrize("hubs", [(), ("n0", "n2")], ids=["towards the goal", "from hubs"])
@pytest.mark.parametrize("cost", ["hops", "length", "time"])
def test_times_are_those_of_the_route_and_the_fastest_is_the_fastest(cost, hubs):
    for number in range(15):
        graph = network(number)
        travel = FreeTravel(graph, SPEED, NODE_TIME, cost, hubs, TURN_TIME)
        for a in graph:
            for b in graph:
                way = travel.way(a, b)
                assert (travel.ways.length(a, b), travel.ways.time(a, b)) == pytest.approx(driven(graph, way))
                if cost == "time" and a != b:
                    # a route that passes a node twice may be faster still
                    best = min(driven(graph, other)[1] for other in nx.all_simple_paths(graph, a, b))
                    assert travel.ways.time(a, b) <= best + 1e-9
        every = list(graph)
        times = [[travel.ways.time(a, b) for b in every] for a in every]
        assert travel.times(every, every) == pytest.approx(np.array(times))


def test_the_turns_at_both_ends_of_a_route_are_those_to_and_from_the_edge():
    for number in range(15):
        graph = network(number)
        for cost in ("hops", "length", "time"):
            travel = FreeTravel(graph, SPEED, NODE_TIME, cost, ("n1",), TURN_TIME)
            edges = list(graph.edges)
            for node in graph:
                for a, b in edges:
                    to, back = travel.way(node, a), travel.way(b, node)
                    into = TURN_TIME * turning(graph, (to[-2], a), (a, b)) if len(to) > 1 else 0
                    out = TURN_TIME * turning(graph, (a, b), (b, back[1])) if len(back) > 1 else 0
                    assert travel.to_edge(node, (a, b)) == pytest.approx(travel.ways.time(node, a) + into)
                    assert travel.from_edge((a, b), node) == pytest.approx(travel.ways.time(b, node) + out)
            table = [[travel.to_edge(node, edge) for edge in edges] for node in graph]
            assert travel.to_edges(list(graph), edges) == pytest.approx(np.array(table))


def test_a_longer_route_with_fewer_turns_is_faster():
    """From A to D: along A B C D there are two right angles, along A E D one: 3 x 3 + 2 x 4 against 12 + 4."""
    graph = nx.DiGraph()
    for name, (x, y) in {"A": (0, 0), "B": (3, 0), "C": (3, 3), "D": (6, 3), "E": (6, 0)}.items():
        graph.add_node(name, x=x, y=y)
    for a, b, length in [("A", "B", 3), ("B", "C", 3), ("C", "D", 3), ("A", "E", 6), ("E", "D", 6), ("D", "A", 9)]:
        graph.add_edge(a, b, length=length, speed=math.inf)
    assert FreeTravel(graph, 1, 0, "time", (), 0.0).way("A", "D") == ["A", "B", "C", "D"]
    travel = FreeTravel(graph, 1, 0, "time", (), 4.0)
    assert travel.way("A", "D") == ["A", "E", "D"]
    assert travel.time("A", "D") == 16


@pytest.mark.parametrize("cost", ["hops", "length", "time"])
def test_turns_worked_out_for_all_pairs_at_once_are_those_of_each_pair(cost, monkeypatch):
    """Between nodes, edges, and goods at nodes, as origins and as goals."""
    for number in range(10):
        graph = network(number)
        travel = FreeTravel(graph, SPEED, NODE_TIME, cost, ("n1",), TURN_TIME, slowness=0.7)
        places = [*graph, *graph.edges, *((node, node) for node in graph)]
        each = travel.between(places, places)
        with monkeypatch.context() as patch:
            patch.setattr("desim_warehouse.layout.travel.MANY", 0)
            assert travel.between(places, places) == pytest.approx(each, rel=1e-12)
