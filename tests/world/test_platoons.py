"""A lane carries what the paper's rule lets it: robots under way drive on when the one ahead moves on.

A ring of 20 x 10 with D = 1, robots of speed 1 that only go round: as long as it is not full, k robots pass any point
k v / L times in a unit of time. What bounds it are the corners: at right angles a robot is let off for
D (cos theta + sin theta) = 1.366 behind the one before it, so 3600 / 1.366 = 2,635 an hour.
"""

import math

import pytest

from .floor import Floor

LENGTH = 60.0
CORNER = 3600 / (math.cos(math.radians(30)) + math.sin(math.radians(30)))


def flow(robots, edges=None, length=LENGTH, until=4000.0, warm_up=2000.0):
    """Passages of a point per 3,600 time units, in a ring once all robots are out."""
    nodes, ring = corners() if edges is None else cut(edges, length)
    floor = Floor(nodes, [f"{a}>{b}" for a, b in zip(ring, ring[1:] + ring[:1], strict=True)], D=1.0, mixed=False)
    for number in range(robots):
        at = number % len(ring)
        laps = " ".join((ring[at:] + ring[:at]) * 80)
        floor.robot(laps, start=number // len(ring) * 3.0)
    floor.env.run(until=until)
    passages = [row[0] for row in floor.log.rows if row[1] == "enter" and row[5][0] == ring[0]]
    return sum(warm_up <= time < until for time in passages) / (until - warm_up) * 3600, floor


def corners():
    return {"A": (0.0, 0.0), "B": (20.0, 0.0), "C": (20.0, 10.0), "D": (0.0, 10.0)}, ["A", "B", "C", "D"]


def cut(edges, length):
    """A ring of so many edges of one length, as a polygon: hardly any corner."""
    radius = length / edges / 2 / math.sin(math.pi / edges)
    ring = [f"n{i}" for i in range(edges)]
    at = [2 * math.pi * i / edges for i in range(edges)]
    return {name: (radius * math.cos(a), radius * math.sin(a)) for name, a in zip(ring, at, strict=True)}, ring


@pytest.mark.slow
@pytest.mark.parametrize("robots", [28, 36, 44, *(pytest.param(robots, marks=pytest.mark.long) for robots in (33, 40))])
def test_a_ring_carries_k_v_over_l_up_to_the_law_of_its_corners(robots):
    measured, _ = flow(robots)
    assert measured == pytest.approx(min(robots / LENGTH * 3600, CORNER), rel=0.01)


def test_nobody_waits_in_a_ring_that_is_not_full():
    _, floor = flow(36)
    waits = [row for row in floor.log.rows if row[1] == "collision" and row[0] > 2000]
    assert waits == []


@pytest.mark.slow
@pytest.mark.parametrize("until", [1500.0, pytest.param(4000.0, marks=pytest.mark.long)])
def test_an_edge_of_two_to_four_d_holds_one_robot_less_than_it_has_places_for(until):
    """The price of claiming the node and room to stand beyond it at the stop line: see docs/why.md."""
    fits, _ = flow(24, edges=24, until=until, warm_up=until / 2)  # edges of 2.5 D hold one robot each
    assert fits == pytest.approx(24 / LENGTH * 3600, rel=0.01)
    more, _ = flow(30, edges=24, until=until, warm_up=until / 2)
    assert more < 30 / LENGTH * 3600 * 0.97
