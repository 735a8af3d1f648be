"""Full rings: robots that wait for each other in a circle are found and let go all at once. D = 2, speed 1."""

import math
from itertools import pairwise

import pytest

import desim_warehouse as dw
from desim_warehouse import GridlockError
from tests.auditor import audit
from tests.world.floor import PARK, Floor

near = pytest.approx
CORNERS = {"A": (0, 0), "B": (10, 0), "C": (10, 10), "D": (0, 10)}
AROUND = "ABCDABCD"


def ring(length, **settings):
    """A square A > B > C > D > A whose edges are `length` long."""
    return Floor(CORNERS, [(f"{a}>{b}", length) for a, b in pairwise("ABCDA")], **settings)


def four_on_the_ring(floor, speeds=(1, 1, 1, 1)):
    """One robot an edge, each to drive its edge and the next; the last loads 3 beyond D for 4."""
    ways = [" ".join(AROUND[k : k + 3]) for k in range(4)]
    robots = [floor.robot(way, PARK, speed=speed) for way, speed in zip(ways[:3], speeds, strict=False)]
    return [*robots, floor.robot(("D A", 3), 4, "A B", PARK, speed=speeds[3])]


def rotations(floor):
    return [(time, set(robots)) for time, robots, _ in floor.log.rings]


def test_a_full_ring_turns_by_one_place():
    floor = ring(5)
    robots = four_on_the_ring(floor)
    floor.run()
    # one robot fits on an edge of 5 (at 3; room for another would be 2 D = 4). The first three are at their stop lines
    # at 3; the last has loaded at 3 + 4 = 7 and closes the ring, which turns at once
    assert rotations(floor) == [(near(7), {0, 1, 2, 3})]
    assert [[wait[1:3] for wait in floor.waits(robot)] for robot in robots] == [[(near(3), near(7))]] * 3 + [[]]
    assert floor.S == 3
    # all leave their nodes at 7 + 2 = 9, the next node is 5 farther
    assert [floor.there(robot)[-1] for robot in robots] == [near(14)] * 4


def test_on_edges_a_rounding_shorter_than_two_places_nobody_is_sent_back():
    """Places at 2 - 1e-7 = D - 1e-7: whoever turns before the one ahead has its place on the node, not before it."""
    floor = ring(4 - 1e-7)
    robots = [floor.robot(" ".join(AROUND[k : k + 3]), PARK) for k in range(4)]
    floor.run()
    assert rotations(floor) == [(near(2), {0, 1, 2, 3})]
    assert [floor.there(robot)[-1] for robot in robots] == [near(8)] * 4
    assert min(row[6] for row in floor.log.rows if row[1] == "drive") == 0


def test_a_rotation_says_who_turned_where_in_the_order_of_waiting():
    floor = ring(5)
    four_on_the_ring(floor)
    floor.run()
    [(_, robots, edges)] = floor.log.rings
    # each waits for the one ahead; robot 3 on D>A closed the ring
    assert robots == (3, 0, 1, 2)
    assert edges == ("D>A", "A>B", "B>C", "C>D")
    [row] = [row for row in floor.log.rows if row[1] == "rotation"]
    assert (row[0], row[6]) == (near(7), 4)


def test_a_ring_with_two_robots_an_edge_turns_place_by_place():
    floor = ring(7, theta=0)
    first = [floor.robot(("A B", 5), 6, "B C", PARK)]
    first += [floor.robot(" ".join(AROUND[k : k + 3]), PARK) for k in (1, 2, 3)]
    second = [floor.robot(" ".join(AROUND[k : k + 3]), PARK, start=2) for k in range(4)]
    floor.run()
    # places 5 and 3 on each edge, all taken at 5; robot 0 loads from 5 to 11 and then closes the ring.
    # First turn, at 11: those ahead pass the nodes at 13 and are at place 3 of the next edge at 16; those behind are at
    # place 5 at 13 and wait for them. Second turn, at 16: now they pass the nodes, at 18.
    assert rotations(floor) == [(near(11), set(range(8))), (near(16), set(range(8)))]
    # those ahead are then at place 5 at 18 and at their goal, the node, at 20; those behind need 7 from 18 on
    assert [floor.there(robot)[-1] for robot in first] == [near(20)] * 4
    assert [floor.there(robot)[-1] for robot in second] == [near(25)] * 4
    # waits: 5 to 11 (all but the one that loads), and 13 to 16 (those behind): 7 + 4
    assert floor.S == 11
    assert sum(robot.waited for robot in floor.robots) == near(7 * 6 + 4 * 3)


def test_a_ring_is_seen_as_soon_as_the_last_robot_is_blocked():
    """Robots of one ring that arrive one after the other wait for the last of them only."""
    floor = ring(5)
    floor.robot(("A B", 2.5), 1, "B C", PARK)
    floor.robot(("B C", 2.5), 2, "C D", PARK)
    floor.robot(("C D", 2.5), 3, "D A", PARK)
    floor.robot(("D A", 2.5), 4, "A B", PARK)
    floor.run()
    # robot i has loaded at 2.5 + 1 + i and is at the stop line 0.5 later: 4, 5, 6, 7
    assert rotations(floor) == [(near(7), {0, 1, 2, 3})]
    assert [robot.waited for robot in floor.robots] == [near(3), near(2), near(1), 0]


def test_robots_that_stand_on_nodes_turn_in_the_same_way():
    """Edges of 3 (D <= 3 < 2 D) between the nodes of the ring; each robot came in on a street of 10."""
    outside = {"a": (-10, 0), "b": (3, -10), "c": (13, 3), "d": (0, 13)}
    nodes = {"A": (0, 0), "B": (3, 0), "C": (3, 3), "D": (0, 3), **outside}
    floor = Floor(nodes, ["A>B", "B>C", "C>D", "D>A", "a>A", "b>B", "c>C", "d>D"])
    robots = [floor.robot("a A", 10, "A B", PARK), floor.robot("b B", 10, "B C", PARK)]
    robots += [floor.robot("c C", 10, "C D", PARK), floor.robot("d D", 15, "D A", PARK)]
    floor.run()
    # they stand on the nodes from 10; three want to go on at 20, the last at 25: then all do, and are 3 on at 28
    assert rotations(floor) == [(near(25), {0, 1, 2, 3})]
    assert [floor.there(robot)[-1] for robot in robots] == [near(28)] * 4
    assert [robot.waited for robot in robots] == [near(5)] * 3 + [0]


def eight(**settings):
    """Two triangles with a common node X: X > A > B > X > C > D > X, all edges 5 long."""
    nodes = {"X": (0, 0), "A": (-4, -3), "B": (-4, 3), "C": (4, 3), "D": (4, -3)}
    edges = [(f"{a}>{b}", 5) for a, b in pairwise("XABXCDX")]
    return Floor(nodes, edges, theta=0, **settings)


def test_a_ring_that_crosses_itself_is_opened_by_a_robot_that_stands_on_the_node():
    floor = eight()
    ways = ["X A B", "A B X", "B X C", "X C D", "C D X"]
    robots = [floor.robot(way, PARK) for way in ways]
    robots.append(floor.robot(("D X", 3), 7, "X A", PARK))
    floor.run()
    # All are at their stop lines by 5 (robot 3 came out of the bay at X behind robot 0, at 2). Robot 5 has loaded at
    # 3 + 7 = 10 and closes a ring of six that passes X twice. Robot 2 drives onto X and is there at 12; behind it
    # robots 1 and 0 go on at 10. Now robots 2, 3, 4 and 5 are a ring, which turns at 12.
    assert rotations(floor) == [(near(10), {0, 1, 2, 3, 4, 5}), (near(12), {2, 3, 4, 5})]
    # Robots 0 and 1 pass their nodes at 12, robot 2 leaves X at 12, robots 3, 4 and 5 pass theirs at 14; then 5 more
    assert [floor.there(robot)[-1] for robot in robots] == [near(17)] * 3 + [near(19)] * 3
    waits = [[wait[1:3] for wait in floor.waits(robot)] for robot in robots]
    assert waits == [
        [(near(3), near(10))],
        [(near(3), near(10))],
        [(near(3), near(10))],
        [(near(0), near(2)), (near(5), near(12))],
        [(near(3), near(12))],
        [(near(10), near(12))],
    ]


def test_a_ring_of_different_speeds_turns_at_the_pace_of_its_slowest():
    floor = ring(5)
    robots = four_on_the_ring(floor, speeds=(1, 0.5, 2, 1))
    floor.run()
    # the slow one is at its stop line at 3 / 0.5 = 6, the ring closes at 7: the nodes are passed at 7 + 2 / 0.5 = 11,
    # and the next edge takes 5 / 0.5 = 10 for all of them
    assert rotations(floor) == [(near(7), {0, 1, 2, 3})]
    assert [floor.there(robot)[-1] for robot in robots] == [near(21)] * 4


def test_a_robot_that_comes_into_a_bay_with_a_slower_ring_leaves_it_at_its_own_speed():
    floor = ring(5, theta=0)
    stands, parks = floor.robot("D A", 20, "A B", PARK), floor.robot("D A", PARK, 100, "A B", PARK, start=2)
    others = [floor.robot("A B C", PARK), floor.robot("B C D", PARK, speed=0.5), floor.robot("C D A", PARK, start=3)]
    floor.run()
    # the first stands on A from 5 to 25, the second before it, at 3 on D>A, from 5; the others are at their stop lines
    # at 3, 6 and 6. At 25 the first wants to go on, which closes the ring: it turns at 0.5
    assert rotations(floor) == [(near(25), {0, 1, 2, 3, 4})]
    assert floor.there(stands) == [near(5), near(25 + 5 / 0.5)]
    assert [floor.there(robot) for robot in others] == [[near(25 + (2 + 5) / 0.5)]] * 3
    # the second is on A, and in the bay, at 25 + 2 / 0.5; 100 later it drives the next 5 at 1
    assert floor.there(parks) == [near(29), near(129 + 5)]


def test_a_robot_that_a_slower_ring_brings_onto_a_node_leaves_that_at_its_own_speed():
    floor = ring(5, theta=0)
    stands, follows = floor.robot("D A", 20, "A B", PARK), floor.robot("D A B", PARK, start=2)
    for way, start, speed in (("A B C", 0, 1), ("B C D", 0, 0.5), ("C D A", 3, 1)):
        floor.robot(way, PARK, start=start, speed=speed)
    floor.run()
    # the ring turns at 25, at 0.5, and brings the second onto A at 29; there is no room beyond until the first, at its
    # stop line at 3 on A>B at 31, drives on to B, where it is at 35. The second can be D behind it at 35 if it leaves A
    # at 32, at 1, and is at B 2 later
    assert rotations(floor) == [(near(25), {0, 1, 2, 3, 4})]
    assert floor.there(stands) == [near(5), near(35)]
    assert (floor.enters(follows)["A>B"], floor.there(follows)) == (near(32), [near(37)])


def test_a_ring_may_not_turn_where_the_model_says_stop():
    floor = ring(5, rotate=False)
    four_on_the_ring(floor)
    with pytest.raises(GridlockError) as gridlock:
        floor.run()
    assert str(gridlock.value) == (
        "gridlock at time 7: 4 robots wait for each other in a ring (robot 3 on edge D>A at 3; "
        "robot 0 on edge A>B at 3; robot 1 on edge B>C at 3; robot 2 on edge C>D at 3); "
        "traffic.gridlock: rotate lets such rings turn"
    )


# In a whole model

SQUARE = {
    "layout": {
        "nodes": {name: list(place) for name, place in CORNERS.items()},
        "edges": [{"from": a, "to": b, "length": 5} for a, b in pairwise("ABCDA")],
        "storage": [{"edge": [a, b], "offset": 3} for a, b in pairwise("ABCDA")],
        "bays": {"home": {"at": list(CORNERS)}},
    },
    "fleet": {"size": 4, "robot": {"radius": 1, "speed": 1}},
    "tasks": {"goods": [0, 1, 2, 3], "unload_at": ["C", "D", "A", "B"], "load_time": 4, "unload_time": 0},
}


def test_four_robots_that_load_at_once_turn_in_their_ring():
    run = dw.simulate(dw.load(SQUARE))
    # loaded at 3 + 4 = 7, when the ring closes: nodes at 9, the next nodes at 14; unloaded at once, two edges home:
    # again four robots on four edges. From the nodes at 14 to the stop lines at 17, a turn, nodes at 19, home at 24.
    assert [ring[0] for ring in run.record.rings] == [near(7), near(17)]
    assert (run.T, run.S, run.kpis["rotations"], run.kpis["moves"]) == (near(24), 0, 2, 16)
    assert audit(run) == []


def test_the_error_of_a_run_names_robots_edges_and_time():
    with pytest.raises(GridlockError) as gridlock:
        dw.simulate(dw.load(SQUARE, {"traffic.gridlock": "stop"}))
    message = str(gridlock.value)
    assert message.startswith("gridlock at time 7: 4 robots wait for each other in a ring (")
    for robot, (a, b) in enumerate(pairwise("ABCDA")):
        assert f"robot {robot} on edge {a}>{b} at 3" in message


def test_the_error_of_a_large_ring_names_some_of_its_robots():
    corners = "ABCDEFGH"
    layout = {
        "nodes": {name: [10 * place, 10 * place**2] for place, name in enumerate(corners)},
        "edges": [{"from": a, "to": b, "length": 5} for a, b in pairwise(corners + "A")],
        "storage": [{"edge": [a, b], "offset": 3} for a, b in pairwise(corners + "A")],
        "bays": {"home": {"at": list(corners)}},
    }
    fleet = {"size": 8, "robot": {"radius": 1, "speed": 1}}
    tasks = {"goods": list(range(8)), "unload_at": [*corners[2:], "A", "B"], "load_time": 4, "unload_time": 0}
    model = {"layout": layout, "fleet": fleet, "tasks": tasks, "traffic": {"gridlock": "stop"}}
    with pytest.raises(GridlockError) as gridlock:
        dw.simulate(dw.load(model))
    message = str(gridlock.value)
    assert "8 robots wait for each other in a ring (robot " in message
    assert message.count(" on edge ") == 6
    assert message.endswith("; and 2 more); traffic.gridlock: rotate lets such rings turn")


def test_a_ring_that_is_not_full_does_not_turn():
    """Three of the four: the free edge lets them on one by one."""
    run = dw.simulate(dw.load(SQUARE, {"fleet.size": 3, "tasks.goods": [0, 1, 2], "tasks.unload_at": ["C", "D", "A"]}))
    assert run.kpis["rotations"] == 0
    # all loaded at 7; robot 2 goes on to D>A, its commitment leaves room on C>D at 7, so robots 1 and 0 follow at once
    assert run.kpis["crossings"] == 0
    deliveries = [row[0] for row in run.record.rows if row[1] == "delivered"]
    assert deliveries == [near(14)] * 3
    assert not math.isnan(run.T)


CORNERS_OF_SIX = [(1.5, 0), (0.75, 1.299), (-0.75, 1.299), (-1.5, 0), (-0.75, -1.299), (0.75, -1.299)]
HEXAGON = {
    # six nodes round a ring and a chord; where the corners are rounded the edges are 1.49997 long, else 1.5
    "layout": {
        "nodes": {str(i): [x, y] for i, (x, y) in enumerate(CORNERS_OF_SIX)},
        "edges": [list(edge) for edge in ("01", "12", "23", "20", "34", "45", "50")],
        "storage": [{"edge": ["2", "3"], "offset": 0.75}, {"edge": ["0", "1"], "offset": 0.75}],
        "bays": {"home": {"at": ["0"]}},
    },
    "fleet": {"size": 7, "robot": {"radius": 0.5, "speed": 1}, "kinds": {"slow": {"count": 1, "speed": 0.5}}},
    "tasks": {"goods": [1, *[0] * 6], "unload_at": list("0120120"), "load_time": 0, "unload_time": 0},
    "traffic": {"collision_angle": 0},
}
SMALL = {
    # a single block: rows of 1.5, columns of 2.5
    "layout": {
        "blocks": {"columns": 1, "rows": 1, "block_width": 1, "block_depth": 2, "goods_size": 1.0, "aisle_width": 0.5},
        "bays": {"home": {"at": ["A"]}},
        "stations": {"s0": {"at": ["C"], "places": 2}},
    },
    "fleet": {
        "size": 5,
        "robot": {"radius": 0.5, "speed": 1},
        "kinds": {"slow": {"count": 1, "speed": 0.4}, "fast": {"count": 2, "speed": 2.5}},
    },
    "tasks": {"goods": [0] * 6, "unload_at": list("CABCA"), "load_time": 0, "unload_time": 0},
    "traffic": {"collision_angle": 0},
    "accept": ["ROBOT_WIDER_THAN_AISLE"],
}


@pytest.mark.parametrize("mapping", [HEXAGON, SMALL], ids=["hexagon", "small"])
def test_members_of_a_ring_set_off_together_although_a_slow_robot_was_there_before(mapping):
    """All of a ring sets off at one instant: one that set off later would be run into by the one behind it."""
    run = dw.simulate(dw.load(mapping))
    assert run.kpis["rotations"] >= 1
    assert audit(run) == []
