"""The distance oracle against networkx on random one-way graphs."""

import math
import random
from itertools import pairwise

import networkx as nx
import pytest

from desim_warehouse.layout import oracle as oracles
from desim_warehouse.layout.oracle import RouteOracle
from desim_warehouse.layout.travel import FreeTravel

SPEED, NODE_TIME = 2.0, 1.5


def graph(seed, size=12):
    """A ring with random chords of random length and speed limit, so everything can be reached."""
    rng = random.Random(seed)
    made = nx.DiGraph()
    names = [f"n{i}" for i in range(size)]
    rng.shuffle(names)
    made.add_nodes_from(names)
    edges = [*zip(names, names[1:] + names[:1], strict=True)]
    edges += [tuple(rng.sample(names, 2)) for _ in range(2 * size)]
    for one, other in edges:
        made.add_edge(one, other, length=rng.uniform(1, 9), speed=rng.choice([math.inf, 0.5, 1.0]))
    for _, _, data in made.edges(data=True):
        data["time"] = data["length"] / min(SPEED, data["speed"]) + NODE_TIME
    return made


def total(made, way, what):
    return sum(made.edges[edge][what] for edge in pairwise(way))


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("cost", ["length", "time"])
def test_ways_are_the_cheapest_and_lengths_and_times_are_those_of_the_way(seed, cost):
    made = graph(seed)
    oracle = RouteOracle(made, cost, SPEED, NODE_TIME)
    for origin in made:
        for goal in made:
            way = oracle.way(origin, goal)
            assert total(made, way, cost) == pytest.approx(nx.shortest_path_length(made, origin, goal, weight=cost))
            assert oracle.length(origin, goal) == pytest.approx(total(made, way, "length"))
            assert oracle.time(origin, goal) == pytest.approx(total(made, way, "time"))


@pytest.mark.parametrize("seed", range(8))
def test_fewest_nodes_are_found_as_algorithm_1_finds_them(seed):
    made = graph(seed)
    oracle = RouteOracle(made, "hops", SPEED, NODE_TIME)
    for origin in made:
        before = {to: at for at, to in nx.bfs_edges(made, origin)}
        for goal in made:
            way = [goal]
            while way[-1] != origin:
                way.append(before[way[-1]])
            way.reverse()
            assert oracle.way(origin, goal) == way
            assert oracle.length(origin, goal) == pytest.approx(total(made, way, "length"))
            assert oracle.time(origin, goal) == pytest.approx(total(made, way, "time"))


@pytest.mark.parametrize("cost", ["hops", "length", "time"])
def test_a_table_holds_what_single_questions_answer(cost):
    made = graph(3)
    asked = FreeTravel(made, SPEED, NODE_TIME, cost)
    origins, goals = [*made][:5] * 2, [*made][4:]
    times, lengths = asked.times(origins, goals), asked.lengths(origins, goals)
    assert times.shape == (10, 8)
    for i, origin in enumerate(origins):
        for j, goal in enumerate(goals):
            assert times[i, j] == asked.ways.time(origin, goal)
            assert lengths[i, j] == asked.ways.length(origin, goal)


@pytest.mark.parametrize("cost", ["hops", "length", "time"])
def test_what_cannot_be_reached_is_infinitely_far(cost):
    made = nx.DiGraph()
    made.add_edge("a", "b", length=1.0, speed=math.inf)
    oracle = RouteOracle(made, cost, SPEED, NODE_TIME)
    assert oracle.time("b", "a") == oracle.length("b", "a") == math.inf
    assert oracle.way("b", "a") == []
    assert oracle.way("a", "a") == ["a"]
    assert oracle.time("a", "a") == 0


@pytest.mark.parametrize("cost", ["hops", "length"])
def test_few_rows_are_kept_and_the_answers_stay(monkeypatch, cost):
    made = graph(5)
    monkeypatch.setattr(oracles, "KEPT", 3 * len(made))
    small = RouteOracle(made, cost, SPEED, NODE_TIME)
    monkeypatch.undo()
    large = RouteOracle(made, cost, SPEED, NODE_TIME)
    for origin in made:
        for goal in made:
            assert small.length(origin, goal) == large.length(origin, goal)
            assert len(small._rows) <= 3
    assert len(large._rows) == len(made)


def test_ten_thousand_nodes_need_no_table_of_all_pairs():
    side = 100
    made = nx.DiGraph()
    for row in range(side):
        for column in range(side):
            for target in ((row, (column + 1) % side), ((row + 1) % side, column)):
                made.add_edge(f"{row}.{column}", f"{target[0]}.{target[1]}", length=1.0, speed=math.inf)
    oracle = RouteOracle(made, "length", 1.0, 0.0)
    assert oracle._keep * side**2 <= oracles.KEPT
    assert [oracle.length("0.0", f"{i}.{i}") for i in (1, 50, 99)] == [2, 100, 198]
    assert len(oracle._rows) == 3
