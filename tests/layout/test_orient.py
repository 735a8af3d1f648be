"""Two-way lanes made one-way: the floor stays connected, bridges stay, trips are not longer than they must be."""

import itertools

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.layout.orient import orient_lanes

pytestmark = pytest.mark.slow


def floor(undirected):
    """All lanes two-way; nodes (x, y) are named "x.y"."""
    graph = nx.DiGraph()
    for x, y in undirected:
        graph.add_node(f"{x}.{y}", x=x, y=y)
    for (a, b), (c, d) in undirected.edges:
        graph.add_edge(f"{a}.{b}", f"{c}.{d}")
        graph.add_edge(f"{c}.{d}", f"{a}.{b}")
    return graph


def oriented(graph, lanes, trials=100):
    """With goods everywhere, and the first node as the station."""
    return orient_lanes(graph, lanes, dict.fromkeys(graph, 1.0), [next(iter(graph))], lambda _: 1.0, trials)


def without(graph, directions):
    """What is left of the floor."""
    left = graph.copy()
    left.remove_edges_from((head, tail) for tail, head in directions.kept)
    return left


def test_a_ring_of_four_lanes_is_driven_round():
    graph = floor(nx.grid_2d_graph(2, 2))
    directions = oriented(graph, [("0.0", "1.0"), ("0.0", "0.1"), ("1.0", "1.1"), ("0.1", "1.1")])
    left = without(graph, directions)
    assert directions.bridges == ()
    assert sorted(map(len, nx.simple_cycles(left))) == [4]
    # Out and back is 4 for each of the three others, and 0 for the station itself: 12 against 2 + 2 + 4 two-way.
    assert directions.stretch == pytest.approx(12 / 8)


def test_a_spur_stays_two_way():
    graph = floor(nx.grid_2d_graph(2, 2))
    graph.add_node("tip", x=5, y=0)
    graph.add_edge("1.0", "tip")
    graph.add_edge("tip", "1.0")
    lanes = [("tip", "1.0"), ("0.0", "1.0"), ("0.0", "0.1"), ("1.0", "1.1"), ("0.1", "1.1")]
    directions = oriented(graph, lanes)
    assert directions.bridges == (("tip", "1.0"),)
    assert nx.is_strongly_connected(without(graph, directions))


def test_one_way_edges_that_are_there_stay_as_they_are():
    """A ring of which three edges are one-way leaves one direction for the fourth, against the preferred one or not."""
    for turn in (1, -1):
        graph = floor(nx.grid_2d_graph(2, 2))
        ring = ["0.0", "1.0", "1.1", "0.1"][::turn]
        for tail, head in itertools.pairwise(ring):
            graph.remove_edge(head, tail)
        assert oriented(graph, [("0.0", "0.1") if turn == 1 else ("0.1", "0.0")]).kept == ((ring[3], ring[0]),)


@given(st.integers(2, 6), st.integers(2, 6), st.sets(st.integers(0, 35), max_size=12), st.integers(0, 2**31))
def test_any_floor_stays_strongly_connected_and_only_bridges_stay_two_way(width, depth, holes, order):
    whole = nx.grid_2d_graph(width, depth)
    whole.remove_nodes_from([list(whole)[hole] for hole in holes if hole < width * depth])
    parts = sorted(nx.connected_components(whole), key=len)
    if not parts or len(parts[-1]) < 2:
        return
    grid = whole.subgraph(parts[-1])
    graph = floor(grid)
    lanes = [(f"{a}.{b}", f"{c}.{d}") for (a, b), (c, d) in grid.edges]
    lanes = [lane if order >> rank & 1 else lane[::-1] for rank, lane in enumerate(lanes)]
    directions = oriented(graph, lanes, trials=40)
    bridges = {frozenset((f"{a}.{b}", f"{c}.{d}")) for (a, b), (c, d) in nx.bridges(nx.Graph(grid))}
    assert {frozenset(lane) for lane in directions.bridges} == bridges
    assert len(directions.kept) + len(directions.bridges) == len(lanes)
    assert nx.is_strongly_connected(without(graph, directions))
    assert directions.stretch >= 1 - 1e-9
    assert directions.stretch <= oriented(graph, lanes, trials=0).stretch + 1e-9


@given(st.data())
def test_any_floor_without_bridges_is_oriented_all_over_and_never_worse_than_at_first(data):
    """Floors grown from a ring by ears (Whitney 1932), some of the lanes given as one-way along them, anywhere."""
    places = st.tuples(st.integers(0, 30), st.integers(0, 30))
    graph = nx.DiGraph()

    def ear(path):
        for tail, head in itertools.pairwise(path):
            if not graph.has_edge(tail, head) and not graph.has_edge(head, tail):
                graph.add_edge(tail, head, given=data.draw(st.integers(0, 3)) == 0)

    def fresh(number):
        names = [f"n{len(graph) + rank}" for rank in range(number)]
        for name in names:
            x, y = data.draw(places)
            graph.add_node(name, x=x, y=y)
        return names

    ring = fresh(data.draw(st.integers(3, 6)))
    ear([*ring, ring[0]])
    for _ in range(data.draw(st.integers(0, 8))):
        ends = [data.draw(st.sampled_from(sorted(graph))) for _ in range(2)]
        if ends[0] != ends[1]:
            ear([ends[0], *fresh(data.draw(st.integers(0, 3))), ends[1]])
    # every ear is passed in one direction, so that what is given leaves the floor strongly connected
    loose = [(a, b) for a, b, given in graph.edges(data="given") if not given]
    lanes = [lane[:: data.draw(st.sampled_from([1, -1]))] for lane in loose]
    assert nx.is_strongly_connected(graph)
    if not lanes:
        return
    graph.add_edges_from([lane[::-1] for lane in loose])
    directions = oriented(graph, lanes, trials=60)
    assert directions.bridges == ()
    assert {frozenset(lane) for lane in directions.kept} == {frozenset(lane) for lane in lanes}
    assert nx.is_strongly_connected(without(graph, directions))
    assert 1 - 1e-9 <= directions.stretch <= oriented(graph, lanes, trials=0).stretch + 1e-9


@pytest.mark.long
def test_a_grid_of_fifty_thousand_nodes_is_oriented():
    graph = floor(nx.grid_2d_graph(230, 218))
    lanes = [edge for edge in graph.edges if edge[0] < edge[1]]
    directions = oriented(graph, lanes, trials=2)
    assert len(directions.kept) == len(lanes) == 99_832
    assert nx.is_strongly_connected(without(graph, directions))
    assert directions.stretch < 1.05


def test_of_a_small_floor_the_best_ways_that_there_are():
    """A 3 x 3 grid has 12 lanes: all 4,096 ways by brute force, with all trips from the station and back."""
    graph = floor(nx.grid_2d_graph(3, 3))
    lanes = [edge for edge in graph.edges if edge[0] < edge[1]]
    ends = {node: 1.0 + rank for rank, node in enumerate(graph)}
    directions = orient_lanes(graph, lanes, ends, ["1.1"], lambda _: 1.0)

    def mean(left):
        there, back = (nx.single_source_shortest_path_length(way, "1.1") for way in (left, left.reverse()))
        return sum((there[node] + back[node]) * weight for node, weight in ends.items())

    every = []
    for turns in itertools.product((False, True), repeat=len(lanes)):
        left = nx.DiGraph([lane[::-1] if turned else lane for lane, turned in zip(lanes, turns, strict=True)])
        if nx.is_strongly_connected(left):
            every.append(mean(left))
    assert mean(without(graph, directions)) == min(every)


def test_annealing_goes_on_where_turning_one_at_a_time_ends():
    graph = floor(nx.grid_2d_graph(6, 5))
    lanes = [edge for edge in graph.edges if edge[0] < edge[1]]
    hubs = ["0.0", "5.4"]
    few, many = (
        orient_lanes(graph, lanes, dict.fromkeys(graph, 1.0), hubs, lambda _: 1.0, trials) for trials in (0, 300)
    )
    assert many.stretch < few.stretch
