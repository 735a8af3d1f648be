"""Intersections: claimed at the stop line with the room beyond, closed until the robot that passed is far enough.

D = 2, speed 1. Two roads cross or meet at X, 10 from the start of each; the stop line is 10 - D = 8. The one that comes
second may set off over X when the other is c beyond it: at right angles c = D (cos a + sin a - 1) for an angle of
collision theta up to 45 degrees (a = theta), (sqrt 2 - 1) D above.
"""

import math

import pytest

from tests.world.floor import PARK, Floor, crossing, line

near = pytest.approx
ROOT = math.sqrt(2)

# c for D = 2: 2 (1 + 0 - 1) = 0; 2 (0.8660 + 0.5 - 1) = sqrt 3 - 1; 2 (0.7071 + 0.7071 - 1) = 2 (sqrt 2 - 1); so above
RIGHT_ANGLE = [(0, 0.0), (30, math.sqrt(3) - 1), (45, 2 * (ROOT - 1)), (60, 2 * (ROOT - 1)), (90, 2 * (ROOT - 1))]
THETAS = pytest.mark.parametrize(("theta", "c"), RIGHT_ANGLE)


def angled(degrees, **settings):
    """A road straight east over X, and one that comes to X at an angle to it; all edges are 10 long."""
    angle = math.radians(degrees)
    start = (-10 * math.cos(angle), -10 * math.sin(angle))
    return Floor({"W": (-10, 0), "X": (0, 0), "E": (10, 0), "N": start}, ["W>X", "X>E", "N>X"], **settings)


@THETAS
def test_two_robots_cross_at_right_angles(theta, c):
    floor = crossing(theta=theta)
    first, second = floor.robot("W X E", PARK), floor.robot("N X S", PARK)
    floor.run()
    # both are at their stop lines at 8; the lower number goes, is on X at 10 and c beyond at 10 + c
    assert floor.waits(first) == []
    assert floor.waits(second) == [("X", near(8), near(10 + c), 0)]
    # from the stop line 2 to X and 10 to S
    assert (floor.there(first), floor.there(second)) == ([near(20)], [near(10 + c + 12)])
    assert (floor.S, second.crossings, second.rear_ends) == (1, 1, 0)


@THETAS
def test_the_passages_of_the_node_are_d_times_cos_plus_sin_apart(theta, c):
    """The rule itself: two robots at right angles meet iff the gap of their passages is less than D + c."""
    gap = 2 + c
    before, after = crossing(theta=theta), crossing(theta=theta)
    for floor, start in ((before, gap - 0.25), (after, gap + 0.25)):
        floor.robot("W X E", PARK)
        floor.robot("N X S", PARK, start=start)
        floor.run()
    # too early by 0.25: it waits for so long and passes X at 10 + gap; late enough: it drives through
    assert (before.S, before.robots[1].waited) == (1, near(0.25))
    assert before.enters(before.robots[1])["X>S"] == near(10 + gap)
    assert (after.S, after.robots[1].waited) == (0, 0)
    assert after.enters(after.robots[1])["X>S"] == near(10 + gap + 0.25)


def test_the_node_time_is_spent_on_the_node():
    floor = crossing(theta=30, node_time=1.5)
    floor.robot("W X E", PARK)
    second = floor.robot("N X S", PARK)
    floor.run()
    # the first leaves X at 10 + 1.5, is c = 0.732 beyond at 12.232
    assert floor.waits(second) == [("X", near(8), near(10.5 + math.sqrt(3)), 0)]
    # 2 to X, 1.5 there, 10 to S, 1.5 there
    assert floor.there(second) == [near(10.5 + math.sqrt(3) + 15)]


@pytest.mark.parametrize(
    ("angle", "theta", "c"),
    [
        # g = D cos(half - a) / cos(half), half = angle / 2, a = min(theta, half); c = g - D, 0 <= c <= D
        (60, 0, 0.0),  # half 30, a 0: g = D
        (60, 30, 4 / math.sqrt(3) - 2),  # a 30: g = D / cos 30 = 1.1547 D
        (60, 45, 4 / math.sqrt(3) - 2),  # a is at most 30: the same
        (120, 0, 0.0),
        (120, 30, 2 * math.sqrt(3) - 2),  # half 60: g = D cos 30 / cos 60 = 1.732 D
        (120, 45, 4 * math.cos(math.radians(15)) - 2),  # g = D cos 15 / 0.5 = 1.932 D
        (120, 60, 2.0),  # g = D / 0.5 = 2 D
        (120, 90, 2.0),
        (150, 90, 2.0),  # g = D / cos 75 = 3.86 D, but a robot D beyond the node is clear of it
    ],
)
def test_two_roads_merge_at_an_angle(angle, theta, c):
    floor = angled(angle, theta=theta)
    first, second = floor.robot("W X E", PARK), floor.robot("N X E", PARK)
    floor.run()
    # at the stop line at 8; the first is c beyond X at 10 + c
    assert floor.waits(second) == [("X", near(8), near(10 + c), 0)]
    assert (floor.there(first), floor.there(second)) == ([near(20)], [near(22 + c)])


@THETAS
def test_straight_on_behind_one_that_turned_in(theta, c):
    """What counts is the way of the one that left: a robot straight on behind it needs D and no more."""
    floor = crossing(theta=theta)
    turning = floor.robot("N X E", PARK)
    straight = floor.robot("W X E", PARK)
    floor.run()
    # both at the stop lines at 8; X>E leads on straight from W>X: the second sets off when the first is on X, at 10
    assert floor.waits(straight) == [("X", near(8), near(10), turning.number)]
    assert floor.there(straight) == [near(22)]


def test_at_another_node_of_the_intersection_what_counts_is_where_the_two_ways_come_close():
    """X and Y, 1 apart, are one intersection. Headings 45 degrees apart want c = D / cos 22.5 - D = 0.165 at one node.

    From X to the south-east the first comes nearer to the road from N to Y: with x to go before Y and y beyond X they
    are apart by y / sqrt 2 - 1 across that road and y / sqrt 2 + x along it. When the first is D beyond, y = 2, they
    are D apart for x = 0.5425: so c = 0.5425 + 2 - D, which steps of D / 40 round to 0.6.
    """
    nodes = {"W": (-10, 0), "X": (0, 0), "F": (10, 10), "N": (1, -10), "Y": (1, 0), "E": (11, 0)}
    floor = Floor(nodes, ["W>X", "X>Y", "X>F", "N>Y", "Y>E"], theta=60)
    first, second = floor.robot("W X F", PARK), floor.robot("N Y E", PARK)
    floor.run()
    assert floor.waits(second) == [("X", near(8), near(10.6), first.number)]
    assert floor.there(second) == [near(22.6)]


def test_side_by_side_over_two_nodes_of_an_intersection_nobody_comes_close():
    """The first goes on from Y to the east; the road from N crosses at X, 1 before: c is 0, not sqrt 3 - 1."""
    nodes = {"W": (-10, 0), "X": (0, 0), "Y": (1, 0), "E": (11, 0), "N": (0, -10), "S": (0, 10)}
    floor = Floor(nodes, ["W>X", "X>Y", "Y>E", "N>X", "X>S"], theta=30)
    floor.robot("W X Y E", PARK)
    second = floor.robot("N X S", PARK)
    floor.run()
    # the first leaves Y at 11; the second, at its stop line at 8, is 2 before X and farther than D from it
    assert floor.waits(second) == [("X", near(8), near(11), 0)]


def test_who_comes_first_goes_first():
    floor = crossing()
    late, early = floor.robot("W X E", PARK, start=0.5), floor.robot("N X S", PARK)
    floor.run()
    assert floor.waits(early) == []
    # at the stop line at 8.5; the other is on X at 10, c = sqrt 3 - 1 beyond it at 9 + sqrt 3
    assert floor.waits(late) == [("X", near(8.5), near(9 + math.sqrt(3)), early.number)]


def test_a_claim_for_the_node_is_served_before_a_later_one_from_the_same_road():
    """Three from the west 2.5 apart and one from the north: it is let through before the third."""
    floor = crossing()
    west = [floor.robot("W X E", PARK, start=2.5 * i) for i in range(3)]
    north = floor.robot("N X S", PARK, start=1)
    floor.run()
    # claims: west 0 at 8, north at 9, west 1 at 10.5, west 2 at 13. West 0 is c = 0.732 beyond X at 10.732:
    # north sets off, is on X at 12.732; west 1 sets off 0.732 later and is on X at 13.464 + 2; west 2 follows 2 behind
    c = math.sqrt(3) - 1
    assert floor.enters(west[0])["X>E"] == near(10)
    assert floor.enters(north)["X>S"] == near(12 + c)
    assert floor.enters(west[1])["X>E"] == near(14 + 2 * c)
    assert floor.enters(west[2])["X>E"] == near(16 + 2 * c)


def test_no_robot_enters_an_intersection_that_it_could_not_leave():
    """Node and room beyond are claimed together: with no room to the east the road from north to south stays free."""
    nodes = {"W": (0, 10), "X": (10, 10), "E": (14.5, 10), "N": (10, 0), "S": (10, 20)}
    floor = Floor(nodes, ["W>X", "X>E", "N>X", "X>S"])
    loading = floor.robot(("X E", 2.5), 40, "E", PARK)
    blocked = floor.robot("W X E", PARK)
    free = floor.robot("N X S", PARK, start=5)
    floor.run()
    # one stands 2.5 beyond X (less than 2 D) from 2.5 to 42.5: the robot from the west waits from 8 until then
    assert floor.there(loading)[0] == near(2.5)
    assert floor.waits(blocked) == [("X", near(8), near(42.5), 0)]
    # the one from the north drives through meanwhile
    assert (floor.waits(free), floor.there(free)) == ([], [near(25)])


def test_claims_that_can_be_granted_are_served_before_one_without_room():
    """As before, but the robot from the north claims X while it is closed behind another: it is served when X opens."""
    nodes = {"W": (0, 10), "X": (10, 10), "E": (14.5, 10), "N": (10, 0), "S": (10, 20)}
    floor = Floor(nodes, ["W>X", "X>E", "N>X", "X>S"])
    floor.robot(("X E", 2.5), 40, "E", PARK)
    first, blocked, north = floor.robot("W X S", PARK), floor.robot("W X E", PARK, start=2), floor.robot("N X S", PARK)
    floor.run()
    # the first turns south at 10; the second has no room from 10 to 42.5; the one from the north waits from 8 and
    # follows straight on when the first is on X, at 10
    assert floor.waits(first) == []
    assert floor.waits(north) == [("X", near(8), near(10), first.number)]
    assert [wait[:3] for wait in floor.waits(blocked)] == [("X", near(10), near(42.5))]


# Short edges


def test_on_edges_shorter_than_two_d_robots_stand_on_nodes_and_a_platoon_flows():
    floor = line("A B C D E", 3, 3, 3, 3)
    robots = [floor.robot("A B C D E", PARK, start=start) for start in (0, 3, 6)]
    floor.run()
    # D = 2 <= 3 < 4. Each sets off for the next node at the instant at which the one ahead leaves it: 3 apart
    assert [floor.there(robot) for robot in robots] == [[near(12)], [near(15)], [near(18)]]
    assert floor.S == 0


def test_on_edges_as_long_as_d_a_platoon_flows_at_speed_over_d():
    floor = line("A B C D", 2, 2, 2)
    robots = [floor.robot("A B C D", PARK) for _ in range(3)]
    floor.run()
    # all want to leave the bay at 0 and do so 2 apart: 6 to D
    assert [floor.there(robot) for robot in robots] == [[near(6 + 2 * i)] for i in range(3)]
    assert [robot.waited for robot in robots] == [0, near(2), near(4)]


def test_a_robot_on_a_short_edge_waits_on_its_node():
    floor = line("A B C", 3, 3)
    first, second = floor.robot("A B", 10, "B C", PARK), floor.robot("A B C", PARK)
    floor.run()
    # the first stands on B from 3 to 13; the second leaves its bay when the first is D beyond A, at 2, and waits on A
    assert [wait[:3] for wait in floor.waits(second)] == [("A", near(0), near(2)), ("B", near(2), near(13))]
    assert (floor.there(first)[-1], floor.there(second)) == (near(16), [near(19)])


def test_a_good_on_a_short_edge_keeps_the_node_beyond_it():
    floor = line("A B C", 3, 10)
    loading, behind = floor.robot(("A B", 2.5), 8, "B C", PARK), floor.robot("A B C", PARK, start=1)
    floor.run()
    # the stop is at 2.5, so from 2.5 to 10.5; 0.5 to B, on it from 11; the next leaves A then
    assert floor.there(loading) == [near(2.5), near(21)]
    assert floor.enters(behind)["A>B"] == near(11)


def test_nodes_nearer_than_d_are_one_intersection():
    """W > A > B > E with A and B 1 apart; a road N > B > S crosses at B."""
    nodes = {"W": (0, 10), "A": (10, 10), "B": (11, 10), "E": (21, 10), "N": (11, 0), "S": (11, 20)}
    floor = Floor(nodes, ["W>A", "A>B", "B>E", "N>B", "B>S"])
    assert floor.traffic.nodes["A"] is floor.traffic.nodes["B"]
    first, second = floor.robot("W A B E", PARK), floor.robot("N B S", PARK)
    floor.run()
    # the first claims A and B at 8, is on A at 10, on B at 11, c = sqrt 3 - 1 beyond B at 10 + sqrt 3
    assert floor.enters(first) == {"W>A": 0, "A>B": near(10), "B>E": near(11)}
    assert floor.waits(second) == [("A", near(8), near(10 + math.sqrt(3)), 0)]
    assert floor.there(second) == [near(22 + math.sqrt(3))]


def test_a_robot_waits_before_joined_nodes_until_there_is_room_beyond_them():
    floor = line("W A B E", 10, 1, 4.5)
    floor.robot(("B E", 2.5), 40, "E", PARK)
    follower = floor.robot("W A B E", PARK)
    floor.run()
    # one stands 2.5 beyond B until 42.5: no room for another beyond B, so nobody stands on A or B meanwhile
    assert floor.waits(follower) == [("A", near(8), near(42.5), 0)]


def test_room_on_a_two_way_lane_that_a_recalled_robot_gives_back_goes_to_one_that_waits_at_the_other_end():
    nodes = {"W": (0, 0), "X": (10, 0), "Y": (20, 0), "V": (10, 10)}
    floor = Floor(nodes, ["W>X", "X>Y", "Y>X", "X>V"], node_time=3)
    recalled, other = floor.robot("W X Y", PARK), floor.robot("Y X V", PARK, start=9)
    recalled.recall_from(12)
    floor.run()
    # the first is let onto X, with room beyond, at 8, is there at 10, and stays there at 10 + 3, as it is recalled;
    # until then there is no room for the other, which comes out at 9, is on X at 13 + 10 and leaves it at 23 + 3
    assert floor.there(recalled) == [near(13)]
    assert floor.waits(other)[0] == ("Y", near(9), near(13), -1)
    assert floor.enters(other) == {"Y>X": near(13), "X>V": near(26)}
