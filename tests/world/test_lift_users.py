"""Lifts that robots share with people, or that fail, worked out by hand. For distances and times see `test_lifts`."""

import math

import pytest

import desim_warehouse as dw
from desim_warehouse.layout.layout import Lift
from desim_warehouse.layout.riders import RidersSpec
from desim_warehouse.model.facts.lifts import left_for_robots, with_people
from desim_warehouse.run.quick import left_out
from desim_warehouse.study.suspects import suspects
from desim_warehouse.values.calendars import ALWAYS, Hours
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.traffic.lift_users import LiftUsers, PersonRide, _times
from tests.world.floor import PARK
from tests.world.test_lifts import ALONE, TWO, UP, building, house

near = pytest.approx
SHARED = {"per_hour": 20, "transfer": 3}


class Visitors:
    """People who call at told times for told rides, each 3 to get in and 3 to get out; nothing fails."""

    fails_at = math.inf

    def __init__(self, *calls):
        self.calls = list(calls)

    @property
    def due(self):
        return self.calls[0][0] if self.calls else math.inf

    def ride(self):
        _, begin, end = self.calls.pop(0)
        return PersonRide(begin, end, 3, 3)


def with_visitors(*calls, **lift):
    floor = house(**lift)
    floor.traffic.nodes["lift0"].users = Visitors(*calls)
    return floor


def test_a_person_who_has_called_rides_first_and_leaves_the_cabin_upstairs():
    floor = with_visitors((5, 0, 1))
    robot = floor.robot(UP)
    floor.run()
    # from 5: doors 4, in 3, doors 4, up 12, doors 4, out 3, doors 4: free at 39. Then down 12, doors 4, in at 57
    assert floor.enters(robot)["lift0>lift1"] == 39 + 12 + 4 + 2
    assert floor.there(robot) == [39 + 12 + ALONE - 8]
    assert robot.waited_apart == {"in_lift": (39 + 12 + 4 - 8) + 20}
    rides = [row for row in floor.log.rows if row[1] == "person_rides"]
    assert rides == [(5, "person_rides", -1, -1, "lift0", ("lift0", "lift1"), 0, 39, -1)]


def test_a_person_who_calls_after_the_robot_rides_after_it():
    floor = with_visitors((8.5, 1, 0))
    first, second = floor.robot(UP, PARK), floor.robot(UP, start=100)
    floor.run()
    # the first leaves the cabin at 34, and its doors have closed at 40: on the floor of the person, who waited 31.5
    assert floor.there(first) == [ALONE]
    rides = [row[0] for row in floor.log.rows if row[1] == "person_rides"]
    assert rides == [40]
    # down for it: the second finds the cabin on the ground at 108
    assert floor.there(second) == [100 + ALONE]


def test_people_ride_one_after_the_other_and_the_cabin_comes_from_where_the_last_got_out():
    floor = with_visitors((0, 0, 2), (1, 1, 0))
    robot = floor.robot(UP)
    floor.run()
    # the first: 4 + 3 + 4 + 24 + 4 + 3 + 4 = 46; the second: down to it 12, 4 + 3 + 4 + 12 + 4 + 3 + 4 = 34: 92
    assert floor.there(robot) == [92 + ALONE - 8]


def test_the_cabin_goes_to_rest_after_people_too():
    floor = with_visitors((0, 0, 2), rests="lift1")
    robot = floor.robot(UP, start=100)
    floor.run()
    # it rests upstairs, comes down 12, and takes them to the roof: 12 + 46; rests again at 70, and is called at 108
    assert floor.there(robot) == [100 + ALONE + 12]


def test_a_robot_in_a_ring_finds_the_cabin_that_came_for_it():
    """People who call while it stands open before a robot of the ring ride after the ring has turned."""
    floor = with_visitors()
    node = floor.traffic.nodes["lift0"]
    robot = floor.robot(UP)
    node.ready_for, node.free_at, node.users = robot, 0.0, Visitors((3, 1, 0))
    assert node._call(robot, "lift0", 8.0) == 8.0
    assert node.users.due == 3
    assert node._call(robot, "lift0", 100.0) > 100.0 - 1
    assert node.users.due == math.inf


def test_a_lift_that_failed_is_repaired_first_and_a_ride_under_way_comes_to_its_end():
    lift = {"nodes": ["lift0", "lift1"], "ride": 12, "doors": 4, "outages": {"every": 20, "repair": 100}}
    run = dw.simulate(dw.load(TWO, {"layout.lifts.main": lift}))
    # called at 24 when it has failed at 20: works at 120, so 96 late. It fails next at 140 with the robot in it, which
    # leaves at 145; in repair from 150, when the doors have closed, to 250. Called at 287 - 96 = 191: 59 late
    assert run.kpis["T"] == 140 + 96 + 59
    assert run.kpis["in_lift"] == 48 + 96 + 59
    fails = [(row[0], row[4], row[7]) for row in run.record.rows if row[1] == "lift_fails"]
    assert fails == [(20, "lift0", 120), (150, "lift1", 250)]


def test_people_call_after_so_much_time_in_their_hours():
    """Open for 4 of every 10 s, called after 2, 5, 9 and 14 s of that; open for 6 s in all, after 2 and 5."""
    gaps = [2.0, 3.0, 4.0, 5.0]
    assert list(_times(iter(gaps), Hours([(0.0, 4.0)], 10.0))) == [2, 11, 21, 32]
    assert list(_times(iter(gaps), Hours([(0.0, 4.0), (7.0, 9.0)]))) == [2, 8]


@pytest.mark.slow
def test_rides_of_people_come_at_their_rate_in_their_hours_and_from_all_floors():
    lift = Lift("main", ("a", "b", "c"), 12, 4, people=RidersSpec(per_hour=60, transfer=3))
    every = 2 * 3600.0
    for hours in (ALWAYS, Hours([(0.0, 3600.0)], every)):
        users, times, ways = LiftUsers(lift, Streams(1), hours, 3600.0), [], []
        while users.due < 40 * every:
            times.append(users.due)
            ways.append(users.ride()[:2])
        assert all(map(hours.is_open, times))
        assert len(times) == near(60 * (80 if hours is ALWAYS else 40), rel=0.05)
        assert {way: ways.count(way) for way in ways} == {
            (a, b): near(len(ways) / 6, rel=0.15) for a in range(3) for b in range(3) if a != b
        }


def test_check_knows_what_people_and_repairs_leave_to_robots():
    model = dw.load(building(1, "fastest"), {"layout.lifts.lift0.people": SHARED})
    (lift,) = model.floor.lifts
    # call 6 + 4, in 3, doors 4, up 12, doors 4, out 3, doors 4 are 40 s, 20 times an hour
    assert with_people(model, lift) == near(20 * 40 / 3600)
    failing = model.replace({"layout.lifts.lift0.outages": {"every": "3 h", "repair": "1 h"}})
    assert left_for_robots(failing, failing.floor.lifts[0]) == near(0.75 * (1 - 20 * 40 / 3600))
    rides = [one for one in dw.check(failing).findings if one.code == "DEMAND_ABOVE_LIFT"]
    # alone it can do 120 rides an hour
    assert "it can do 70 rides an hour, but 300 are needed" in str(rides[0])
    fails, rides = left_out(failing, failing.floor)
    assert fails.startswith(
        "lift lift0 fails every 3 h and takes 1 h to repair: 75 % of its time is left, and robots wait"
    )
    assert rides == "people use lift lift0 for 22.2 % of the time on average, and robots wait for them"  # no batteries


@pytest.mark.usefixtures("brief_probes")
def test_cabins_that_are_alike_are_spoken_of_in_one_line():
    """Three share 60 rides of people an hour; each takes 40 s, as in the test before."""
    lift = {"cabins": 3, "people": {"per_hour": 60, "transfer": 3}, "outages": {"every": "3 h", "repair": "1 h"}}
    model = dw.load(building(1, "fastest"), {f"layout.lifts.lift0.{key}": value for key, value in lift.items()})
    fails, rides = left_out(model, model.floor)
    names = "lifts lift0, lift0 2 and lift0 3"
    assert fails.startswith(f"{names} fail every 3 h and take 1 h to repair: 75 % of the time of each is left")
    assert rides.startswith(f"people use each of {names} for 22.2 % of the time on average, and robots wait for them")
    unused, short = (
        [str(one) for one in dw.check(model.replace({"policies.routing": routing})).findings if one.code == code]
        for routing, code in (("fastest", "LIFT_UNUSED"), ("congestion-aware", "DEMAND_ABOVE_LIFT"))
    )
    # 70 rides an hour for one of them, and 300 are asked for
    (text,) = unused
    assert "which can do 70 rides an hour, and none takes lifts " in text
    assert "congestion-aware takes all 3, which can do about 210; or fastest with spread: 3" in text
    (text,) = short
    assert "layout.lifts.lift0: its 3 cabins can do 210 rides an hour, but 300 are needed: their queues grow" in text


@pytest.mark.parametrize(
    ("night", "members", "code", "text"),
    [
        ("05:00-06:00", None, "NEVER_IN_RUN", "nobody rides in this run: calendar 'riding' does not open in it"),
        ("00:10-00:20", ["lift0"], "CHANGES_NOTHING", "they ride only while traffic.closures.shut keeps robots out"),
        ("00:10-00:50", ["lift0"], None, ""),  # after 00:30 robots wait for them
        ("00:10-00:20", ["home"], None, ""),
    ],
)
def test_people_who_ride_when_no_robot_could_are_said(night, members, code, text):
    changes = {
        "calendars": {"riding": {"open": [night]}, "shut": {"open": ["00:00-00:30"]}},
        "layout.lifts.main.people": {"per_hour": 10, "transfer": 3, "hours": "riding"},
        "run": {"length": 3600},
        "tasks": {"goods": {"poisson": 20}, "unload_at": ["wards"], "load_time": 5, "unload_time": 7},
    }
    if members:
        changes["traffic.closures"] = {"shut": {"members": members, "hours": "shut"}}
    findings = dw.check(dw.load(TWO, changes)).findings
    heard = [one for one in findings if one.place == "layout.lifts.main.people.hours"]
    assert [one.code for one in heard] == ([code] if code else [])
    assert all(text in str(one) for one in heard)


def test_a_lift_that_people_never_leave_to_robots_is_refused():
    with pytest.raises(dw.WarehouseError, match="people would have it for 111 % of the time"):
        dw.simulate(dw.load(TWO, {"layout.lifts.main.people": {"per_hour": 100, "transfer": 3}}))


def test_people_take_their_part_of_a_lift():
    """Robots always want it: a ride of theirs takes 30 s, as in `test_lifts`, and one of a person 40 s."""
    alone, shared = (
        dw.simulate(dw.load(building(1, "fastest"), {"layout.lifts.lift0.people": people, "log": "tasks"}), 1)
        for people in (None, {"per_hour": 20, "transfer": 3})
    )
    assert alone.kpis["throughput_per_hour"] == near(60, abs=0.5)
    # 20 rides of 40 s leave 0.78 of the time, and half of the time a person leaves the cabin on the other floor
    assert shared.kpis["throughput_per_hour"] == near(60 * (1 - 20 * 40 / 3600), abs=3)
    assert shared.kpis["lift_utilisation"] == near(1, abs=0.01)


def test_why_tries_a_lift_that_never_fails():
    outages = {"layout.lifts.lift0.outages": {"every": {"exponential": 1800}, "repair": 300}}
    run = dw.simulate(dw.load(building(1, "fastest"), outages), 1)
    (relief,) = [one for one in suspects(run) if one.name == "outages of lifts"]
    assert (relief.relief, relief.overrides) == ("lifts never fail", {"layout.lifts.lift0.outages": None})


def test_the_node_of_a_lift_closes_the_lanes_to_its_doors():
    hours = {"calendars": {"night": {"open": ["00:00-00:02"]}}}
    doors = {"night": {"members": ["lift0", "lift1"], "hours": "night", "tasks": "go"}}
    run = dw.simulate(dw.load(TWO, {**hours, "traffic.closures": doors}))
    # loaded at 15; it enters the lane to the doors when that opens, at 120
    assert run.kpis["waiting_closed"] == 105
