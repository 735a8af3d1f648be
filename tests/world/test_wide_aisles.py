"""Wide aisles: a robot that loads stands beside its lane, and comes back when there is room. D = 2, speed 1."""

import copy

import pytest

import desim_warehouse as dw
from desim_warehouse.outcome.positions import Positions
from tests.auditor import audit
from tests.world.floor import PARK, Aside, Floor, line
from tests.world.ring import RING

near = pytest.approx
WIDE = {("A", "B")}


def street():
    """A > B of 20 in a wide aisle, B > C of 10."""
    return line("A B C", 20, 10, wide=WIDE)


def beside(floor, robot):
    """When a robot left the lane, and when it was back."""
    return [row[0] for row in floor.log.rows if row[1] in {"aside", "back"} and row[2] == robot.number]


def test_others_drive_past_a_robot_that_loads():
    floor = street()
    loads = floor.robot(("A B", 6), Aside(10), "B C", PARK)
    passes = floor.robot("A B C", PARK, start=5)
    floor.run()
    # it is at 6 from 6 to 16, C is 24 farther on; the other would have waited behind it from 5 + 4 = 9 on
    assert (beside(floor, loads), floor.there(loads)) == ([near(6), near(16)], [near(6), near(40)])
    assert floor.there(passes) == [near(5 + 30)]
    assert floor.S == 0


def test_a_robot_that_finds_the_room_taken_waits_in_the_lane_and_takes_its_turn_at_once():
    floor = street()
    first = floor.robot(("A B", 6), Aside(10), "B C", PARK)
    second = floor.robot(("A B", 6), Aside(10), "B C", PARK, start=3)
    third = floor.robot("A B C", PARK, start=5)
    floor.run()
    # the second is there at 3 + 6 = 9, where the first stands beside the lane until 16: then they change places
    assert (beside(floor, first), beside(floor, second)) == ([near(6), near(16)], [near(16), near(26)])
    assert floor.waits(second) == [("A>B", near(9), near(16), 0)]
    # the third stands 2 behind the second from 5 + 4 = 9 on, and follows the first 2 behind: C at 40 + 2
    assert floor.waits(third) == [("A>B", near(9), near(16), 1)]
    assert [floor.there(robot)[-1] for robot in (first, second, third)] == [near(40), near(50), near(42)]


def test_at_two_places_of_a_lane_the_one_that_is_ready_goes_before_one_that_has_not_come_near():
    floor = street()
    ahead = floor.robot(("A B", 12), Aside(10), "B C", PARK)
    behind = floor.robot(("A B", 6), Aside(10), "B C", PARK, start=2.5)
    floor.run()
    # at 18.5 the one behind is ready; at 22 it is at 9.5, and decides at 12 - 2 = 10 whether it goes on
    assert (beside(floor, ahead), beside(floor, behind)) == ([near(12), near(22)], [near(8.5), near(18.5)])
    assert [floor.there(robot)[-1] for robot in (ahead, behind)] == [near(22 + 18), near(18.5 + 24)]
    assert floor.S == 0


def test_at_two_places_of_a_lane_the_one_that_drives_past_goes_first():
    floor = street()
    ahead = floor.robot(("A B", 12), Aside(10), "B C", PARK)
    behind = floor.robot(("A B", 6), Aside(9), "B C", PARK, start=2)
    floor.run()
    # ready at 17, it is at 11 at 22, past 12 - 2, and at 12 + 2 at 25
    assert (beside(floor, ahead), beside(floor, behind)) == ([near(12), near(25)], [near(8), near(17)])
    assert floor.waits(ahead) == [("A>B", near(22), near(25), 1)]
    assert [floor.there(robot)[-1] for robot in (ahead, behind)] == [near(25 + 18), near(17 + 24)]


def test_a_robot_comes_back_behind_the_platoon_that_is_on_the_lane_and_before_those_that_are_not():
    floor = street()
    loads = floor.robot(("A B", 10), Aside(5), "B C", PARK)
    platoon = [floor.robot("A B C", PARK, start=start) for start in (3, 5, 7)]
    late = floor.robot("A B C", PARK, start=16)
    floor.run()
    # ready at 15; the last of the platoon is at 10 + 2 at 7 + 12 = 19, and till then nobody is let in at A
    assert beside(floor, loads) == [near(10), near(19)]
    assert [floor.there(robot) for robot in platoon] == [[near(30 + start)] for start in (3, 5, 7)]
    assert floor.enters(late)["A>B"] == near(19)
    assert floor.waits(late) == [("A", near(16), near(19), 3)]
    assert [floor.there(robot)[-1] for robot in (loads, late)] == [near(19 + 20), near(19 + 30)]


def test_a_robot_behind_the_place_does_not_keep_another_from_coming_back():
    floor = street()
    loads = floor.robot(("A B", 10), Aside(5), "B C", PARK)
    stands = floor.robot(("A B", 4), 30, "B C", PARK, start=2)
    floor.run()
    # at 4 it is farther than D from 10
    assert (beside(floor, loads), floor.there(loads)[-1]) == ([near(10), near(15)], near(35))
    assert floor.there(stands)[-1] == near(36 + 26)


def test_a_robot_comes_back_where_another_has_just_left_the_lane_by_its_end():
    floor = line("A B C", 20, 10, wide=WIDE)
    loads = floor.robot(("A B", 18), Aside(5), "B C", PARK)
    passes = floor.robot("A B C", PARK, start=4)
    floor.run()
    # ready at 23, when the other, past its stop line at 18, is at 19: it is D beyond 18 when it passes B, at 24
    assert beside(floor, loads) == [near(18), near(24)]
    assert floor.there(passes) == [near(34)]


def test_where_nobody_stops_a_wide_aisle_is_as_any_lane():
    """Twelve robots go round a ring of 16 D: they queue, and rings of them turn, at the same times."""
    nodes = {"A": (0, 0), "B": (8, 0), "C": (8, 8), "D": (0, 8)}
    edges = ["A>B", "B>C", "C>D", "D>A"]
    wide, narrow = (Floor(nodes, edges, wide=some) for some in ([tuple(edge.split(">")) for edge in edges], []))
    for floor in (wide, narrow):
        for way in ("A B C D A B C", "B C D A B C D", "C D A B C D A", "D A B C D A B"):
            for _ in range(3):
                floor.robot(way, PARK)
        floor.run()
    assert wide.log.rows == narrow.log.rows
    assert len(wide.log.rings) > 0


# Models


def ring(**changes):
    """The ring with one place 5 along B > C, in a wide aisle; the station is at D, the bay at A. D = 1."""
    mapping = copy.deepcopy(RING)
    mapping["layout"]["storage"] = [{"edge": ["B", "C"], "offset": 5}]
    mapping["layout"]["aisles"] = "wide"
    mapping["tasks"]["goods"] = [0, 0]
    return {**mapping, **changes}


def rows(run, *kinds):
    return [(row[0], row[1], row[2]) for row in run.record.rows if row[1] in kinds]


def test_two_robots_at_one_place_of_a_model():
    run = dw.simulate(dw.load(ring()))
    # 15 to the place, 5 to load; the other is there at 16.37 and loads from 20 to 25; 15 on to D, 3 to unload, 10 home
    assert rows(run, "aside", "back") == [(15, "aside", 0), (20, "aside", 1), (20, "back", 0), (25, "back", 1)]
    assert near(25 + 15 + 3 + 10) == run.T
    assert audit(run) == []


def test_all_loads_at_one_place_are_taken_up_beside_the_lane():
    mapping = ring()
    mapping["fleet"] = {"size": 1, "robot": {**mapping["fleet"]["robot"], "capacity": 2}}
    mapping["policies"] = {"batching": {"name": "fixed-size", "size": 2}}
    run = dw.simulate(dw.load(mapping))
    assert rows(run, "aside", "back") == [(15, "aside", 0), (25, "back", 0)]
    assert near(25 + 15 + 6 + 10) == run.T


def test_a_robot_beside_a_lane_that_closes_comes_back_and_drives_out():
    mapping = ring(calendars={"day": {"open": ["00:00:18-00:05"]}})
    mapping["traffic"] = {"closures": {"shut": {"members": [["B", "C"]], "hours": "day"}}}
    mapping["tasks"] = {**mapping["tasks"], "load_time": 10, "goods": [0, {"good": 0, "release": 9}]}
    run = dw.simulate(dw.load(mapping))
    # it loads from 15 to 25; the other is at the stop line before B from 9 + 9 = 18, when it closes, to 300
    assert rows(run, "aside", "back") == [(15, "aside", 0), (25, "back", 0), (306, "aside", 1), (316, "back", 1)]
    assert near(316 + 15 + 3 + 10) == run.T
    assert audit(run) == []


def test_a_robot_that_breaks_down_beside_the_lane_is_in_nobody_s_way():
    mapping = ring()
    mapping["fleet"]["robot"] |= {"breakdowns": {"every": 17, "repair": 100}}
    mapping["tasks"]["goods"] = [0]
    mapping["fleet"]["size"] = 1
    run = dw.simulate(dw.load(mapping))
    # 17 in operation are over while it loads; it is broken from 20, when it would come back, to 120
    assert rows(run, "aside", "broken", "back")[:3] == [(15, "aside", 0), (20, "broken", 0), (120, "back", 0)]
    assert audit(run) == []


def test_a_robot_that_breaks_down_between_two_loads_stays_beside_the_lane():
    mapping = ring()
    mapping["fleet"] = {"size": 1, "robot": {**mapping["fleet"]["robot"], "capacity": 2}}
    mapping["fleet"]["robot"]["breakdowns"] = {"every": 17, "repair": 100, "clear": 10}
    mapping["policies"] = {"batching": {"name": "fixed-size", "size": 2}}
    run = dw.simulate(dw.load(mapping))
    # due at 17, while it loads, and again after 34 in operation, 9 after it has driven on with both
    assert rows(run, "aside", "broken", "back", "cleared")[:3] == [
        (15, "aside", 0),
        (20, "broken", 0),
        (125, "back", 0),
    ]
    assert audit(run) == []


@pytest.mark.parametrize(
    ("release", "loads"),
    # the other stands behind it from 16 on, and loads at 20 as that one breaks down; or it comes at 9 + 15 = 24
    [(0, (20, 25)), (9, (24, 29))],
)
def test_a_robot_loads_in_the_lane_where_another_is_repaired_beside_it(release, loads):
    mapping = ring()
    old, new = {"count": 1, "breakdowns": {"every": 17, "repair": 100}}, {"count": 1}
    mapping["fleet"] = {"size": 2, "kinds": {"old": old, "new": new}, "robot": mapping["fleet"]["robot"]}
    mapping["tasks"]["goods"] = [0, {"good": 0, "release": release}]
    run = dw.simulate(dw.load(mapping))
    first, second = (
        [row for row in rows(run, "aside", "broken", "loading", "loaded", "back") if row[2] == n] for n in (0, 1)
    )
    assert first[:5] == [(15, "aside", 0), (15, "loading", 0), (20, "loaded", 0), (20, "broken", 0), (120, "loaded", 0)]
    assert second == [(loads[0], "loading", 1), (loads[1], "loaded", 1)]
    assert (120, "back", 0) in first
    assert audit(run) == []


def test_a_load_that_is_put_down_where_it_was_picked_goes_round():
    mapping = ring()
    place = {"edge": ["B", "C"], "offset": 5}
    mapping["layout"]["storage"] = [place]
    mapping["tasks"] = {"load_time": 5, "unload_time": 3, "flows": {"moves": {"from": "storage", "to": "storage"}}}
    mapping["tasks"]["flows"]["moves"]["arrivals"] = {"saturated": 1}
    mapping["run"] = {"length": 100}
    mapping["fleet"]["size"] = 1
    run = dw.simulate(dw.load(mapping))
    # 15 to the place, 5 to load, and 40 round to it again
    assert rows(run, "aside", "back")[:4] == [(15, "aside", 0), (20, "back", 0), (60, "aside", 0), (63, "back", 0)]
    assert audit(run) == []


def test_a_robot_that_loads_is_drawn_beside_the_lane():
    positions = Positions(dw.simulate(dw.load(ring())).history)
    # B > C leads from (10, 0) down to (10, 10); its right is towards x = 0, D = 1 away
    assert [positions.points(time)[0].tolist() for time in (14.9, 15.1, 19.9, 20.1)] == [
        near([10, 4.9]),
        near([9, 5]),
        near([9, 5]),
        near([10, 5.1]),
    ]
    assert positions.points(20.1)[1].tolist() == near([9, 5])
    assert positions.points(25.1)[1].tolist() == near([10, 5.1])


def without(*rows_to_drop):
    """The faults that the auditor finds in the log of two robots at one place, without some rows."""
    run = dw.simulate(dw.load(ring()))
    run.record.rows[:] = [row for row in run.record.rows if (row[1], row[2]) not in rows_to_drop]
    return " ".join(audit(run))


def test_the_auditor_knows_who_is_on_the_lane():
    assert without() == ""
    assert "robots 0 and 1 are 0 apart" in without(("aside", 0), ("back", 0))  # it stands in the lane
    assert "robots 0 and 1 stand beside ('B', 'C') at 5.0, where one has room" in without(("back", 0))
    assert "comes back onto ('B', 'C'), beside which it does not stand" in without(("aside", 1))
    assert "robot 1 leaves ('B', 'C') and does not load there" in without(("loading", 1))


def test_the_nodes_of_one_aisle_are_not_taken_for_a_list_of_aisles():
    with pytest.raises(dw.ModelError, match=r"nodes of one line \(got \[A, B\]\), .* write \[\[A, B\]\]"):
        dw.load(ring(), {"layout.aisles": {"north": {"along": ["A", "B"]}}})
