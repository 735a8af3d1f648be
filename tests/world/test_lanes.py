"""Lanes: robots queue in order, D apart, and count one collision for each time they wait. D = 2, speed 1."""

import pytest

from tests.world.floor import PARK, line

near = pytest.approx


def test_a_robot_alone_spends_length_over_speed_and_the_node_time_at_every_node():
    floor = line("A B C", 10, 6, node_time=1.5)
    robot = floor.robot("A B C")
    floor.run()
    # B at 10, on at 10 + 1.5; C at 11.5 + 6 = 17.5, ready there at 17.5 + 1.5
    assert floor.enters(robot) == {"A>B": 0, "B>C": near(11.5)}
    assert floor.there(robot) == [near(19)]
    assert (robot.moves, robot.distance(floor.env.now), floor.S) == (2, near(16), 0)


def test_stops_within_d_of_a_node_are_moved_clear_of_it():
    floor = line("A B", 10)
    early, late = floor.robot(("A B", 0.5), 1, "B", PARK), floor.robot(("A B", 9.9), start=20)
    floor.run()
    # 0.5 is moved to D = 2, reached at 2; 9.9 to L - D = 8, reached at 20 + 8
    assert floor.there(early)[0] == near(2)
    assert floor.there(late) == [near(28)]


def test_a_straight_platoon_flows_d_apart_without_waiting():
    floor = line("A B C D", 10, 10, 10)
    # every robot leaves when the one before it is D beyond A: 2 time units later; 4 can stand on an edge of 5 D
    robots = [floor.robot("A B C D", PARK, start=2 * i) for i in range(4)]
    floor.run()
    assert [floor.there(robot) for robot in robots] == [[near(30 + 2 * i)] for i in range(4)]
    assert floor.S == 0


def test_a_lane_is_given_to_no_more_robots_than_can_stand_on_it():
    floor = line("A B C", 10, 10)
    robots = [floor.robot("A B C", PARK, start=2 * i) for i in range(5)]
    floor.run()
    # the first four are sure of the places 8, 6, 4 and 2 beyond B when the fifth is at the stop line, at 8 + 8 = 16;
    # the first is at its place at 10 + 8 = 18 and sure of C: then all move up
    assert [floor.waits(robot) for robot in robots] == [[], [], [], [], [("B", near(16), near(18), 3)]]
    assert floor.enters(robots[4])["B>C"] == near(20)


def test_the_one_waited_for_is_named_when_it_has_gone_over_the_node():
    floor = line("A B C", 10, 10)
    floor.robot("A B", 20, "B C", PARK)
    leader = floor.robot("A B C", PARK, start=3)
    follower = floor.robot("A B C", PARK, start=6)
    floor.run()
    # the leader is at the stop line from 3 + 8 = 11, the follower 2 behind it from 6 + 6 = 12, until B is free at 30
    assert floor.waits(leader) == [("B", near(11), near(30), 0)]
    assert floor.waits(follower) == [("A>B", near(12), near(30), leader.number)]


def test_a_platoon_leaves_a_bay_one_robot_every_d():
    floor = line("A B", 30)
    robots = [floor.robot("A B", PARK) for _ in range(4)]
    floor.run()
    # all want to leave A at 0; robot i sets off at 2 i, when the one before it is D = 2 away
    assert [floor.enters(robot)["A>B"] for robot in robots] == [near(2 * i) for i in range(4)]
    assert [robot.waited for robot in robots] == [near(2 * i) for i in range(4)]
    assert floor.S == 3  # one episode each but for the first


def test_a_queue_behind_a_robot_that_loads_in_mid_edge():
    floor = line("A B C", 20, 10)
    leader = floor.robot(("A B", 6), 10, "B C", PARK)
    second = floor.robot("A B C", PARK, start=3)
    third = floor.robot("A B C", PARK, start=5)
    fourth = floor.robot("A B C", PARK, start=8)
    floor.run()
    # the leader is at 6 from time 6 to 16, C is 24 farther on: 40
    assert floor.there(leader) == [near(6), near(40)]
    # the second stops at 6 - 2 = 4 at 3 + 4 = 7 and goes on at 16 with the leader, 2 behind it
    assert floor.waits(second) == [("A>B", near(7), near(16), 0)]
    # the third stops at 4 - 2 = 2 at 5 + 2 = 7
    assert floor.waits(third) == [("A>B", near(7), near(16), 1)]
    # for the fourth there is no room D beyond A (the third stands at 2 < 2 D): it waits in the bay from 8 to 16
    assert [wait[:3] for wait in floor.waits(fourth)] == [("A", near(8), near(16))]
    assert [floor.there(robot)[-1] for robot in (second, third, fourth)] == [near(42), near(44), near(46)]
    assert (second.rear_ends, third.rear_ends, fourth.crossings, floor.S) == (1, 1, 1, 3)


def test_one_episode_for_each_time_that_the_leader_stops():
    floor = line("A B C", 20, 20)
    leader = floor.robot(("A B", 10), 5, ("B C", 10), 7, "C", PARK)
    follower = floor.robot("A B C", PARK, start=2)
    floor.run()
    # the leader stands 10 beyond A from 10 to 15 and 10 beyond B from 15 + 20 = 35 to 42; the follower is 2 behind it,
    # at 8 from 2 + 8 = 10, and again from 15 + 20 = 35
    assert floor.waits(follower) == [
        ("A>B", near(10), near(15), leader.number),
        ("B>C", near(35), near(42), leader.number),
    ]
    # from 8 beyond B it is 12 to C
    assert floor.there(follower) == [near(54)]


def test_a_wait_of_no_length_does_not_count():
    floor = line("A B", 20)
    floor.robot(("A B", 6), 10, "B", PARK)
    follower = floor.robot("A B", PARK, start=12)
    floor.run()
    # it comes to 4 at 12 + 4 = 16, the instant at which the leader sets off
    assert floor.there(follower) == [near(32)]
    assert floor.S == 0


def test_a_robot_that_unloads_on_a_node_keeps_the_next_one_at_the_stop_line():
    floor = line("A B C", 10, 10)
    first = floor.robot("A B", 20, "B C", PARK)
    second = floor.robot("A B C", PARK, start=3)
    floor.run()
    # the first stands on B from 10 to 30; the second is at the stop line, 10 - 2 = 8, from 3 + 8 = 11
    assert floor.there(first) == [near(10), near(40)]
    assert floor.waits(second) == [("B", near(11), near(30), 0)]
    # straight on it may follow at once: 2 to B, 10 to C
    assert floor.there(second) == [near(42)]


def test_a_robot_that_enters_a_bay_is_off_the_node_at_once():
    floor = line("A B", 10, node_time=1.5)
    first, second = floor.robot("A B", PARK), floor.robot("A B", PARK, start=2)
    floor.run()
    # the first is on B from 10, in the bay from 11.5; the second at the stop line from 2 + 8 = 10
    assert floor.waits(second) == [("B", near(10), near(11.5), 0)]
    # the stop line is D = 2 before B: 11.5 + 2 + 1.5
    assert floor.there(second) == [near(15)]
    assert first.waited == 0


def test_a_robot_leaves_its_bay_when_the_one_that_passes_is_d_beyond():
    floor = line("A B C", 10, 10)
    passing = floor.robot("A B C", PARK)
    leaving = floor.robot("B C", PARK, start=9)
    floor.run()
    # B is granted to the passing robot at its stop line at 8; it is at B at 10 and D = 2 beyond it at 12
    assert floor.waits(leaving) == [("B", near(9), near(12), 0)]
    assert (floor.there(passing), floor.there(leaving)) == ([near(20)], [near(22)])


def test_a_robot_leaves_its_bay_before_one_that_is_not_yet_at_the_stop_line():
    floor = line("A B C", 10, 10)
    passing = floor.robot("A B C", PARK)
    leaving = floor.robot("B C", PARK, start=7.5)
    floor.run()
    # the other is at the stop line at 8 and follows straight on, 2.5 behind: nobody waits
    assert (floor.there(leaving), floor.there(passing)) == ([near(17.5)], [near(20)])
    assert floor.S == 0


def test_robots_that_come_out_of_a_bay_let_a_robot_turn_in_between():
    """First come, first served: the passing robot claims B at 8, before the second of the bay (at 9)."""
    floor = line("A B C", 10, 10)
    one = floor.robot("B C", PARK, start=7.5)
    passing = floor.robot("A B C", PARK)
    two = floor.robot("B C", PARK, start=9)
    floor.run()
    # the passing robot leaves B at 10, is D beyond it at 12
    assert [floor.enters(robot)["B>C"] for robot in (one, passing, two)] == [near(7.5), near(10), near(12)]


@pytest.mark.parametrize("times", [1, 2])
@pytest.mark.parametrize("off", [0.0, 1e-9, 1e-7, 1e-6, 1e-5])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_length_at_d_or_2_d_give_or_take_the_tolerance_is_driven_with_a_stop_on_it(times, off, sign):
    """Once a lane of 2 D - 1e-6 had its stop line before the place where robots stop on it: they never got there."""
    length = 0.44 * times + sign * off
    floor = line("A B C D", 5, length, 5, D=0.44)
    robots = [floor.robot(("A B C", length / 2), 1.0, "C D", PARK, start=i) for i in range(3)]
    floor.run()
    assert all(len(floor.there(robot)) == 2 for robot in robots)
