"""The paper's battery rule to the instant: what a robot does at the moment at which it reaches the threshold.

A > B > C > D > A, 20 apart, speed 1, 1 drawn per time unit from time 0 on, battery 200: at time t the level is 200 - t.
The first robot is at A at 10 and at B at 30; good 0 is 10 beyond B, so loaded (5) at 45, at C at 55, unloaded (10) at
65, and A is 40 farther: 105. Later robots need 1 instead of 10 to come out.
"""

import pytest

from desim_warehouse import BatteryError, load, simulate

near = pytest.approx
RING = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 20], "D": [0, 20]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"edge": ["B", "C"], "offset": 10}, {"edge": ["D", "A"], "offset": 10}],
        "bays": {"home": {"at": ["A", "C", "D"]}},
    },
    "fleet": {"size": 1, "start": ["A"], "robot": {"radius": 0.5, "speed": 1}, "first_exit_time": 10, "exit_time": 1},
    "tasks": {"goods": [0], "unload_at": ["C"], "load_time": 5, "unload_time": 10},
    "battery": {"capacity": 200, "threshold": 20, "consumption": 1, "charge_rate": 10},
}


def play(**changes):
    return simulate(load(RING, {key.replace("__", "."): value for key, value in changes.items()}))


def events(run, *kinds):
    return [(row[0], row[1], row[2], row[3]) for row in run.record.rows if row[1] in kinds]


def test_without_a_threshold_the_run_is_as_worked_by_hand():
    run = play()
    # the last charge, at the end of the work, does not count
    assert (near(105), 0, 0) == (run.T, run.S, run.C)


@pytest.mark.parametrize("instant", [22, 25, 29.75, 30])
def test_before_the_node_where_its_good_s_edge_begins_a_robot_gives_its_good_back_at_that_instant(instant):
    """On the way, and at the very instant of reaching B. The next time it is at B with 1 + 20 used, and goes on."""
    run = play(battery__threshold=200 - instant)
    assert events(run, "returned") == [(near(instant), "returned", 0, 0)]
    assert (near(195), 1) == (run.T, run.C)


def test_a_robot_may_give_its_good_back_before_it_is_out_of_the_zone():
    """Threshold at 25, at A at 30 only: it goes in again, charges 30 and comes out at 33 + 1 with its good."""
    run = play(battery__threshold=175, fleet__first_exit_time=30)
    assert events(run, "returned") == [(near(25), "returned", 0, 0)]
    assert (near(33 + 96), 1) == (run.T, run.C)


def test_a_robot_called_back_as_it_waits_to_come_out_leaves_the_node_to_others():
    """Robot 0, out at 1, has loaded at 36 and unloads standing on D from 66 to 186; robot 1 wants to come out there.

    Robot 1 gets its good at 64.5, is at the threshold 90 later, at 154.5, and in again as soon as it could come out:
    at 187, when robot 0 is D beyond. Robot 2, at C, gets the good at 154.5 and is at its stop line before D at 174.5.
    From 187 on it drives: D at 188, B at 228, loaded at 243, D at 273, unloaded at 393, and C is 60 farther.
    """
    run = play(
        fleet__size=3,
        fleet__start=["A", "D", "C"],
        fleet__first_exit_time=1,
        battery__capacity=400,
        battery__threshold=310,
        tasks__goods=[0, {"good": 0, "release": 64.5}],
        tasks__unload_at=["D"],
        tasks__unload_time=120,
    )
    assert events(run, "returned", "delivered") == [
        (near(154.5), "returned", 1, 1),
        (near(186), "delivered", 0, 0),
        (near(393), "delivered", 2, 1),
    ]
    assert events(run, "returning")[:2] == [(near(186), "returning", 0, -1), (near(187), "returning", 1, -1)]
    assert [event[0] for event in events(run, "parked")] == [near(187), near(206), near(453)]
    assert [(row[2], row[6]) for row in run.record.rows if row[1] == "collision"] == [(1, near(121.5)), (2, near(12.5))]


def test_it_goes_on_to_the_next_node_and_home_from_there_and_out_again_when_charged():
    run = play(battery__threshold=175)
    # given back at 25, 15 beyond A; B at 30, home by C and D at 90: 90 used, 9 to charge; out at 99 with the good
    assert events(run, "assigned", "returned", "recharged", "delivered") == [
        (0, "assigned", 0, 0),
        (near(25), "returned", 0, 0),
        (near(99), "assigned", 0, 0),
        (near(99), "recharged", 0, 0),
        (near(99 + 1 + 20 + 10 + 5 + 10 + 10), "delivered", 0, 0),
    ]
    # at B 21 are used, less than 25; and once on the good's edge it finishes: 40 from C to A
    assert (near(195), 1) == (run.T, run.C)


def test_on_its_good_s_edge_a_robot_finishes_the_delivery():
    run = play(battery__threshold=169.75)
    # reached at 30.25, just beyond B
    assert events(run, "returned") == []
    assert (near(105), 0) == (run.T, run.C)


def test_at_the_node_it_has_not_begun_the_edge_until_the_node_time_is_over():
    """With 1.5 spent at B, from 30 to 31.5: reached at 31 it gives back, reached at 31.75 it goes on."""
    early, late = (play(traffic__node_time=1.5, battery__threshold=level) for level in (169, 168.25))
    assert events(early, "returned") == [(near(31), "returned", 0, 0)]
    # from B, where it turns until 31.5, home: 60 and three node times
    assert events(early, "parked")[0][0] == near(31.5 + 60 + 3 * 1.5)
    assert events(late, "returned") == []


@pytest.mark.parametrize("at", [35, 50, 60])
def test_a_robot_that_loads_drives_loaded_or_unloads_finishes_and_goes_home(at):
    run = play(battery__threshold=200 - at, tasks__goods=[0, 0])
    # delivered at 65, home at 105 and not given the second: 105 used, 10.5 to charge, then 1 + 20 + 10 + 5 + 10 + 10
    assert events(run, "returned") == []
    assert [event[0] for event in events(run, "delivered")] == [near(65), near(105 + 10.5 + 56)]
    assert (1, near(105 + 10.5 + 96)) == (run.C, run.T)


def test_above_the_threshold_a_robot_that_has_unloaded_gets_the_next_good():
    run = play(battery__threshold=40, tasks__goods=[0, 0], battery__reserve=1)
    # delivered at 65 with 135 left; C D A B are 60, the good 10 beyond: loaded at 140, C at 150, delivered at 160
    assert [event[0] for event in events(run, "delivered")] == [near(65), near(160)]
    assert (0, near(200)) == (run.C, run.T)


def test_the_good_goes_back_to_the_front_of_the_list():
    run = play(battery__threshold=175, tasks__goods=[0, 0, 0])
    # task 0 is given out again before tasks 1 and 2; each of these needs a charge before it
    assert [task for _, _, _, task in events(run, "assigned")] == [0, 0, 1, 2]
    assert [task for *_, task in events(run, "delivered")] == [0, 1, 2]


def test_two_robots_in_the_same_instant_give_back_in_order_of_number():
    """Robots 0 (from A) and 1 (from C) reach the threshold at 25. Robot 2, at D with nothing to do, gets the front one.

    Robot 0 is first to put its task 0 at the front, then robot 1 its task 1: so task 1 is in front.
    """
    run = play(
        fleet__size=3, fleet__start=["A", "C", "D"], tasks__goods=[0, 1], tasks__unload_at=["C"], battery__threshold=175
    )
    assert events(run, "returned") == [(near(25), "returned", 0, 0), (near(25), "returned", 1, 1)]
    assert events(run, "assigned")[2] == (near(25), "assigned", 2, 1)


def test_a_robot_that_is_still_charging_when_a_good_comes_goes_out_when_it_is_full():
    run = play(tasks__goods=[0, {"good": 0, "release": 110}])
    # home at 105 with 95: full at 105 + 10.5
    assert events(run, "recharged") == [(near(115.5), "recharged", 0, 1)]
    assert (1, near(115.5 + 96)) == (run.C, run.T)


def test_a_full_robot_goes_out_at_the_instant_at_which_a_good_comes():
    run = play(tasks__goods=[0, {"good": 0, "release": 150}])
    assert events(run, "recharged") == [(near(150), "recharged", 0, 1)]
    assert (1, near(150 + 96)) == (run.C, run.T)


def test_a_robot_that_was_never_out_is_not_recharged():
    run = play(tasks__goods=[{"good": 0, "release": 50}])
    # nothing is drawn in the zone; 10 to come out the first time: 105 after 50
    assert (0, near(155)) == (run.C, run.T)


def test_a_robot_without_charge_stops_the_run_and_is_named():
    with pytest.raises(BatteryError) as flat:
        play(battery__capacity=50, battery__threshold=5, accept=["BATTERY_TOO_SMALL"])
    # loaded at 45, 10 beyond B; 5 farther at 50
    assert str(flat.value).startswith(
        "robot 0 ran flat at time 50, on edge B>C at 15, loaded: good 0 draws at least 56: the drive there, to the "
        "station and to a charger or home; a battery gives 50;"
    )


def test_the_reserve_lets_a_robot_go_on_below_zero():
    run = play(battery__capacity=50, battery__threshold=5, battery__reserve=56)
    # at home at 105 with 50 - 105 = -55, 1 above the end of the reserve
    assert near(105) == run.T
    [level] = [row[6] for row in run.record.rows if row[1] == "parked"]
    assert level == near(-55)


# A two-way lane of 20 and a dead end of 4 beyond it, with the good half way: one robot at a time goes there and back.
DEAD_END = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [24, 0]},
        "edges": [{"from": "A", "to": "B", "two_way": True}, {"from": "B", "to": "C", "two_way": True}],
        "storage": [{"edge": ["B", "C"], "offset": 2}],
        "bays": {"home": {"at": ["A"], "places": 2}},
    },
    "fleet": {"size": 2, "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {"goods": [0, 0], "unload_at": ["A"], "load_time": 20, "unload_time": 3},
    "battery": {"capacity": 100, "threshold": 70, "consumption": 1, "charge_rate": 10},
}


def test_called_back_before_it_is_let_out_onto_a_two_way_lane_a_robot_charges_without_having_driven_there_and_back():
    """Robot 0 is at the good at 22, has loaded at 42, and is at A by C at 68 and unloaded at 71.

    Robot 1 waits to come out, at 1 a second: it gives its good back at 30, charges for 3 s, and so again from 63 to 66.
    At 71 it comes out, with 95. At the good, 22 later, it has 73.
    """
    run = simulate(load(DEAD_END))
    assert events(run, "returned") == [(near(30), "returned", 1, 1), (near(63), "returned", 1, 1)]
    assert [row[:3] for row in run.record.rows if row[1] == "enter" and row[5] == ("A", "B")] == [
        (0, "enter", 0),
        (near(71), "enter", 1),
    ]
    assert events(run, "delivered") == [(near(71), "delivered", 0, 0), (near(71 + 71), "delivered", 1, 1)]


@pytest.mark.parametrize("edge", [["B", "C"], ["C", "B"]])  # or it drives to C first, past the good, in as much time
def test_called_back_on_the_way_to_the_node_where_its_good_s_two_way_lane_begins_a_robot_finishes_the_delivery(edge):
    """Robot 1 has its good at 60 and comes out at 71. It is at the threshold at 90, and at B, where it asks, at 91."""
    goods = [0, {"good": 0, "release": 60}]
    run = simulate(load(DEAD_END, {"tasks.goods": goods, "layout.storage": [{"edge": edge, "offset": 2}]}))
    assert events(run, "returned") == []
    assert events(run, "delivered") == [(near(71), "delivered", 0, 0), (near(142), "delivered", 1, 1)]
