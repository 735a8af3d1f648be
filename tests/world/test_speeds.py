"""Robots and edges of different speed: nobody comes closer than D on the way. D = 2."""

import pytest

import desim_warehouse as dw
from tests.auditor import audit
from tests.world.floor import PARK, Floor, line

near = pytest.approx


def test_an_edge_with_a_speed_limit_takes_as_long_as_its_limit_says():
    floor = line("A B C D", 10, 10, 10, limits=[None, 0.5, 3])
    robot = floor.robot("A B C D", PARK)
    floor.run()
    # 10 at its own speed 1, 10 / 0.5 = 20, 10 at 1 again: its own speed is below the limit of 3
    assert floor.enters(robot) == {"A>B": 0, "B>C": near(10), "C>D": near(30)}
    assert floor.there(robot) == [near(40)]


def test_each_robot_drives_at_its_own_speed():
    floor = line("A B", 10)
    slow = floor.robot("A B", PARK, speed=0.5)
    fast = floor.robot("A B", PARK, speed=4, start=30)
    floor.run()
    assert (floor.there(slow), floor.there(fast)) == ([near(20)], [near(32.5)])


def slow_and_fast():
    floor = line("A B C", 22, 22)
    slow = floor.robot("A B C", PARK, speed=0.5)
    fast = floor.robot("A B C", PARK, speed=2, start=4)
    return floor.run(), slow, fast


def test_a_fast_robot_follows_a_slow_one_and_does_not_pass_it():
    """The slow one leaves A at 0, B at 44 and is at C at 88. The fast one sets off late enough to be D behind always.

    To be at 18 when the slow one is at 20, at 40, it leaves A at 40 - 18 / 2 = 31. The slow one is at B at 44: it is
    at 20 then, from 43 on. It may be on B when the slow one is D beyond it, at 48, so sets off for B at 47. In the
    same way on B>C: at 18 at 84, at 20 at 88, when the slow one enters the bay, and at C at 89.
    """
    floor, slow, fast = slow_and_fast()
    assert floor.enters(slow) == {"A>B": 0, "B>C": near(44)}
    assert floor.there(slow) == [near(88)]
    assert floor.enters(fast)["A>B"] == near(31)
    assert floor.enters(fast)["B>C"] == near(84 - 18 / 2)
    assert floor.there(fast) == [near(89)]
    # 44 at speed 2 are 22: the rest of the 85 from 4 to 89 it waited
    assert fast.waited == near(63)
    assert slow.waited == 0


def test_a_wait_behind_a_slower_robot_lasts_from_when_it_could_have_set_off_until_it_does():
    floor, _, fast = slow_and_fast()
    # from 4 to 31 in the bay; at 18 from 40 to 43; at the stop line from 44 to 47; on B from 48 to 84 - 18 / 2 = 75;
    # at 18 from 84 to 87
    assert [wait[:3] for wait in floor.waits(fast)] == [
        ("A>B", near(4), near(31)),
        ("A>B", near(40), near(43)),
        ("B", near(44), near(47)),
        ("B>C", near(48), near(75)),
        ("B>C", near(84), near(87)),
    ]


@pytest.mark.parametrize(("end", "waited", "waits"), [(20, 20 - 4, 1), (35, 31 - 4, 1), (41, 31 - 4 + 1, 2)])
def test_of_a_wait_behind_a_slower_robot_what_is_after_the_end_of_the_run_does_not_count(end, waited, waits):
    """It waits from 4 to 31 and, as is known from then on, from 40 to 43."""
    floor = line("A B C", 22, 22)
    floor.robot("A B C", PARK, speed=0.5)
    fast = floor.robot("A B C", PARK, speed=2, start=4)
    floor.env.run(end)
    fast.end_waits(end)
    assert (fast.waited, fast.rear_ends) == (near(waited), waits)


def test_a_slow_robot_behind_a_fast_one_never_waits():
    floor = line("A B C", 22, 22)
    fast = floor.robot("A B C", PARK, speed=2)
    slow = floor.robot("A B C", PARK, speed=0.5, start=1)
    floor.run()
    # the fast one is D = 2 beyond A at 1
    assert (floor.there(fast), floor.there(slow)) == ([near(22)], [near(89)])
    assert floor.S == 0


def test_a_node_stays_closed_longer_behind_a_slower_robot():
    """At right angles: c = D (cos 30 + sin 30 - 1) = 0.732 at the pace of the one that leaves, 0.5, are 1.464.

    The one that comes, at speed 1, drives 2 to the node while the other drives 1: so it may set off when the other is
    g - 2 * 0.5 = 2.732 - 1 = 1.732 beyond, at 20 + 1.732 / 0.5.
    """
    nodes = {"W": (0, 10), "X": (10, 10), "E": (20, 10), "N": (10, 0), "S": (10, 20)}
    floor = Floor(nodes, ["W>X", "X>E", "N>X", "X>S"])
    floor.robot("W X E", PARK, speed=0.5)
    second = floor.robot("N X S", PARK, start=9)
    floor.run()
    # the slow one claims X at 8 / 0.5 = 16, is on X at 20; the other is at its stop line at 9 + 8 = 17
    assert floor.waits(second) == [("X", near(17), near(20 + 3**0.5 / 0.5), 0)]
    assert floor.there(second) == [near(20 + 2 * 3**0.5 + 12)]


def test_robots_of_different_size_all_keep_the_distance_of_the_largest():
    """D = 2 max r + margin = 2 * 1.5 + 0.5, so that every robot can take any other's place in a ring."""
    model = dw.load(
        {
            "layout": {
                "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 20], "D": [0, 20]},
                "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
                "storage": [{"edge": ["A", "B"], "offset": 15}],
                "bays": {"home": {"at": ["A"], "places": 3}},
            },
            "fleet": {
                "size": 3,
                "robot": {"radius": 0.5, "speed": 1, "margin": 0.5},
                "kinds": {"big": {"count": 1, "radius": 1.5, "speed": 0.5}},
            },
            "tasks": {"goods": [0, 0, 0], "unload_at": ["C"], "load_time": 5, "unload_time": 5},
        }
    )
    assert model.fleet.contact == 3.5
    run = dw.simulate(model)
    # robot 0, the big one, is at the good at 15 / 0.5 = 30 and loads until 35; the next drives up to 15 - 3.5 = 11.5
    stops = [(row[2], row[6], row[7]) for row in run.record.rows if row[1] == "drive" and row[5] == ("A", "B")]
    assert stops[0] == (0, 15, 30)
    assert stops[1][:2] == (1, 11.5)
    assert run.kpis["tasks"] == 3
    assert audit(run) == []


def there_and_back(**edge):
    """One robot on a two-way lane of 20: the good is 10 beyond A, and unloaded at A."""
    lane = {"from": "A", "to": "B", "two_way": True, **edge}
    return {
        "layout": {
            "nodes": {"A": [0, 0], "B": [20, 0]},
            "edges": [lane],
            "storage": [{"edge": ["A", "B"], "offset": 10.0}],
            "bays": {"home": {"at": ["A"], "places": 1}},
        },
        "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}},
        "tasks": {"goods": [0], "unload_at": ["A"], "load_time": 0, "unload_time": 0},
    }


@pytest.mark.parametrize(
    ("edge", "lasts"),
    [({}, 40), ({"speed": 0.5}, 80), ({"speed_back": 0.5}, 20 + 40), ({"speed": 0.8, "speed_back": 0.4}, 25 + 50)],
)
def test_a_two_way_lane_has_a_speed_for_each_direction(edge, lasts):
    run = dw.simulate(dw.load(there_and_back(**edge)))
    assert pytest.approx(lasts) == run.T
    assert audit(run) == []


def test_two_edges_are_one_lane_with_the_speed_of_each():
    apart = there_and_back()
    apart["layout"]["edges"] = [{"from": "A", "to": "B", "speed": 0.8}, {"from": "B", "to": "A", "speed": 0.4}]
    together = dw.load(there_and_back(speed=0.8, speed_back=0.4))
    assert dw.simulate(dw.load(apart)).record.rows == dw.simulate(together).record.rows


def test_a_speed_back_of_a_one_way_edge_is_refused():
    mapping = there_and_back(two_way=False, speed_back=0.5)
    mapping["layout"]["edges"].append(["B", "A"])
    with pytest.raises(dw.LayoutError, match=r"edges\[0\].speed_back: A>B is not two-way; say two_way: true, or give"):
        dw.load(mapping).floor  # noqa: B018 - it is built as it is asked for


@pytest.mark.parametrize(("kept", "speed"), [(("A", "B"), 0.8), (("B", "A"), 0.4)])
def test_made_one_way_it_keeps_the_speed_of_its_direction(kept, speed):
    from desim_warehouse.model.oriented import _turn

    content = there_and_back(speed=0.8, speed_back=0.4)
    _turn(content["layout"], dw.load(content).floor, {kept: "along"}, 2.0)
    assert content["layout"]["edges"] == [{"from": kept[0], "to": kept[1], "speed": speed}]


@pytest.mark.parametrize(
    ("length", "speed", "into", "out_of"),
    [(10, 1, 1, 0.5), (10, 0.6, 0.6, 0.5)],  # 10 s to B, 8 s in, 16 s out; and numbers that rounding sets apart
)
def test_a_good_in_a_dead_end_is_loaded_on_the_way_in_where_robots_drive_slower_on_the_way_out(
    length, speed, into, out_of
):
    """Either way it is 8 m in and 8 m out: at the good after 4 of these, not 4 before it is at B again."""
    run = dw.simulate(
        dw.load(
            {
                "layout": {
                    "nodes": {"A": [0, 0], "B": [length, 0], "C": [length + 8, 0]},
                    "edges": [
                        {"from": "A", "to": "B", "two_way": True, "speed": speed},
                        {"from": "B", "to": "C", "speed": into},
                        {"from": "C", "to": "B", "speed": out_of},
                    ],
                    "storage": [{"edge": ["B", "C"], "offset": 4}],
                    "bays": {"home": {"at": ["A"]}},
                },
                "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}},
                "tasks": {"goods": [0], "unload_at": ["A"], "load_time": 2, "unload_time": 3},
            }
        )
    )
    times = {row[1]: row[0] for row in run.record.rows}
    assert times["loading"] == near(length / speed + 4 / into)
    assert times["delivered"] == near(length / speed + 8 / into + 2 + 8 / out_of + length / speed + 3)
