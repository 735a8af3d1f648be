"""The sorting floor of benchmarks/sorting.py: what shared routes and a cap on robots under way do for it."""

import networkx as nx
import pytest

from benchmarks import sorting

pytestmark = pytest.mark.slow


def test_the_floor_is_one_way_connected_and_has_the_chutes():
    floor = sorting.floor()
    edges = [tuple(edge) for edge in floor["edges"]]
    graph = nx.DiGraph(edges)
    assert (len(graph), len(floor["stations"]["chutes"]["at"])) == (2556, 204)
    assert nx.is_strongly_connected(graph)
    assert not {edge[::-1] for edge in edges} & set(edges)


@pytest.mark.parametrize(
    ("robots", "steps", "times"),
    [(300, 40, 1.1), *(pytest.param(500, *each, marks=pytest.mark.long) for each in ((60, 1.25), (100, 1.4)))],
)
def test_robots_that_share_equally_short_routes_reach_more_goals(robots, steps, times):
    alone, shared = (
        sorting.goals(robots, sorting.POLICIES[name], steps=steps, warm_up=2 * steps)[0]
        for name in ("shortest", "spread")
    )
    assert shared > times * alone


@pytest.mark.long
def test_with_a_cap_800_robots_do_what_500_do():
    spread, capped = sorting.POLICIES["spread"], sorting.POLICIES["spread, at most 500 out"]
    five_hundred, eight_hundred = (sorting.goals(*one)[0] for one in ((500, spread), (800, capped)))
    assert eight_hundred >= 0.97 * five_hundred
    assert sorting.goals(800, spread)[0] < 0.6 * eight_hundred
