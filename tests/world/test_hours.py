"""Hours of stations, robots and flows, worked by hand: one robot on a square of 40 s, its good 15 s from its bay.

It takes 5 s to load and 30 s to unload, so it delivers at 65, 140 and 215 where nothing is ever closed.
"""

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import CheckError, StallError

SQUARE = {
    "calendars": {
        "day": {"between": [[0, 100], [200, 300], [400, 900]]},
        "late": {"between": [[100, 1000]]},
        "rounds": {"every": 100, "lasts": 50},
    },
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [10, 10], "E": [0, 10]},
        "edges": [["A", "B"], ["B", "C"], ["C", "E"], ["E", "A"]],
        "storage": [{"edge": ["B", "C"], "offset": 5}],
        "bays": {"home": {"at": ["A"]}},
        "stations": {"desk": {"at": ["E"], "places": 2}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.3, "speed": 1}},
    "tasks": {"goods": [0, 0, 0], "unload_at": ["desk"], "load_time": 5, "unload_time": 30},
}
TIMES = {"load_time": 5, "unload_time": 30}


def simulated(over, seed=0, **more):
    return dw.simulate(dw.load(SQUARE, {**over, **more}), seed)


def times(run, kind):
    return [row.time for row in run.history.rows(kind)]


def rows(run, *kinds):
    return [(row.kind, row.time) for row in run.history.rows(*kinds)]


# Stations


def test_a_task_is_held_back_so_that_the_robot_comes_as_the_station_opens():
    """The second would get there at 110, in a closed station: it is given out at 165, 35 s before the station opens."""
    run = simulated({"layout.stations.desk.hours": "day"})
    assert times(run, "assigned") == [0, 165, 230]
    assert times(run, "docked") == [35, 200, 275]
    assert times(run, "delivered") == [65, 230, 305]  # the third began at 275, and is finished
    assert run.kpis["share_closed"] == 0


def test_a_robot_that_finds_no_slot_at_the_opening_is_not_let_go_when_it_is_closed_again():
    """Robot 0 has the only slot from 32 to 322, so robot 1 cannot set out at 168: at 322 it has to wait for 400."""
    schedule = {"schedule": [{"at": 0, "tasks": 1}, {"at": 70, "tasks": 1}]}
    desk = {"at": ["E"], "places": 1, "hours": "day", "unload_time": 290}
    run = simulated(
        {
            "fleet": {"size": 2, "robot": {"radius": 0.3, "speed": 1.1}},
            "layout.bays.home.places": 2,
            "layout.stations.desk": desk,
            "tasks": {**TIMES, "flows": {"work": {"from": "storage", "to": "desk", "arrivals": schedule}}},
        }
    )
    assert times(run, "docked") == [pytest.approx(5 + 30 / 1.1), pytest.approx(400)]


def test_before_its_first_opening_too():
    run = simulated({"layout.stations.desk.hours": "late"})
    assert times(run, "docked") == [100, 175, 250]


def test_what_has_begun_pauses_where_the_station_says_so():
    over = {"layout.stations.desk.hours": "day", "layout.stations.desk.at_close": "pause", "tasks.unload_time": 80}
    run = simulated(over, **{"tasks.goods": [0]})
    assert rows(run, "unloading", "closed", "delivered") == [
        ("unloading", 35),
        ("closed", 100),
        ("unloading", 200),
        ("delivered", 215),
    ]
    assert run.robots["unloading"].sum() == 80
    assert run.robots["closed"].sum() == 100


def test_who_is_inside_and_not_yet_served_waits_until_it_opens():
    """Three robots come together and one is served at a time, 30 s each: at 100 the third has not begun."""
    over = {"fleet.size": 3, "layout.stations.desk.places": 3, "layout.stations.desk.hours": "day"}
    run = simulated(over)
    third = run.history.states[2]
    spans = [(span.state, span.start, span.end) for span in third if span.state in ("queueing", "closed", "unloading")]
    assert spans == [
        ("queueing", pytest.approx(46.2), pytest.approx(95)),
        ("unloading", pytest.approx(95), pytest.approx(125)),
    ]
    run = simulated({**over, "tasks.unload_time": 40})
    third = run.history.states[2]
    spans = [(span.state, span.start, span.end) for span in third if span.state in ("queueing", "closed", "unloading")]
    assert spans == [("queueing", pytest.approx(46.2), 100), ("closed", 100, 200), ("unloading", 200, 240)]
    assert run.account("robot").loc[2, "closed"] == 100


def test_robots_go_to_the_station_that_is_open_although_another_is_nearer():
    layout = {
        **SQUARE["layout"],
        "stations": {"near": {"at": ["C"], "hours": "late"}, "far": {"at": ["E"], "places": 2}},
    }
    model = {**SQUARE, "layout": layout}
    model["tasks"] = {**SQUARE["tasks"], "unload_at": ["C", "E"], "station_choice": "nearest"}
    run = dw.simulate(dw.load(model))
    assert [(row.node, row.time) for row in run.history.rows("docked")] == [("E", 35), ("E", 110), ("C", 175)]


def test_a_task_for_a_closed_station_holds_up_no_other():
    """By in-order the first task of the list is for a station that is closed; the second is done at once."""
    layout = {**SQUARE["layout"], "stations": {"early": {"at": ["E"]}, "late": {"at": ["C"], "hours": "late"}}}
    goods = [{"good": 0, "to": "late"}, {"good": 0, "to": "early"}]
    run = dw.simulate(
        dw.load({**SQUARE, "layout": layout, "tasks": {**SQUARE["tasks"], "unload_at": ["E"], "goods": goods}})
    )
    assert [row.task for row in run.history.rows("delivered")] == [1, 0]


def test_stations_have_handling_times_of_their_own():
    run = simulated({"layout.stations.desk.unload_time": 10})
    assert times(run, "delivered") == [45, 100, 155]
    assert run.model.content()["layout"]["stations"]["desk"]["unload_time"] == 10


# Robots


def test_a_robot_finishes_what_it_has_in_hand_and_rests_until_its_hours_begin():
    run = simulated({"fleet.hours": "day"})
    assert times(run, "delivered") == [65, 140, 265]
    assert rows(run, "parked", "on_break", "idle") == [
        ("parked", 150),
        ("on_break", 150),
        ("idle", 200),
        ("parked", 275),
        ("idle", 275),
    ]
    assert run.kpis["share_on_break"] == pytest.approx(50 / 275)


def test_a_robot_at_rest_begins_its_break_when_its_hours_end():
    goods = [0, {"good": 0, "release": 120}]
    run = simulated({"fleet.hours": "day", "tasks.goods": goods})
    assert rows(run, "idle", "on_break") == [("idle", 75), ("on_break", 100), ("idle", 200), ("idle", 275)]
    assert times(run, "assigned") == [0, 200]


def test_kinds_of_robots_have_hours_of_their_own():
    kinds = {"night": {"count": 1, "hours": "late"}}
    run = simulated({"fleet.size": 2, "fleet.kinds": kinds, "fleet.hours": "day"})
    assert [(row.robot, row.time) for row in run.history.rows("assigned")] == [(1, 0), (1, 65), (0, 100)]


def test_the_queue_of_a_robot_goes_back_to_the_list_when_its_hours_end():
    """Robot 0 has been promised two more; when its hours end at 50 robot 1, whose hours begin, is given them."""
    run = simulated(
        {
            "fleet.size": 2,
            "fleet.hours": "rounds",
            "fleet.kinds": {"early": {"count": 1}, "other": {"count": 1, "hours": "after"}},
            "calendars.after": {"between": [[50, 500]]},
            "policies.allocation": "tests.world.test_hours:AllToTheFirst",
        }
    )
    assert [(row.robot, row.task, row.time) for row in run.history.rows("assigned")] == [
        (0, 0, 0),
        (1, 1, 50),
        (1, 2, 115),
    ]


class AllToTheFirst:
    """Gives all tasks to the first free robot: the second and third into its queue."""

    def assign(self, situation):
        return [(situation.robots[0].number, task.number) for task in situation.tasks]


def test_charging_goes_on_in_a_break():
    battery = {"capacity": 200, "threshold": 100, "consumption": 1, "charge_rate": 2}
    run = simulated({"fleet.hours": "day", "battery": battery})
    assert rows(run, "charging", "on_break", "idle") == [
        ("on_break", 150),
        ("charging", 150),
        ("idle", 225),
        ("on_break", 300),
    ]


# Flows


def test_arrivals_at_random_come_within_the_hours_as_they_would_without():
    flow = {"from": "storage", "to": "desk", "arrivals": {"poisson": 36}}
    tasks = {"flows": {"in": flow}, "load_time": 5, "unload_time": 3}
    model = {**SQUARE, "tasks": tasks, "run": {"length": 5000}}
    plain = dw.simulate(dw.load(model))
    hours = dw.simulate(dw.load(model, {"tasks.flows.in.hours": "rounds"}))
    within = [time for time in times(plain, "released") if time % 100 < 50]
    assert times(hours, "released") == within
    assert len(within) > 10


def test_a_poisson_list_has_hours_too():
    model = {**SQUARE, "run": {"length": 5000}}
    model["tasks"] = {**SQUARE["tasks"], "goods": {"poisson": 36, "hours": "rounds"}}
    run = dw.simulate(dw.load(model))
    assert times(run, "released")
    assert all(time % 100 < 50 for time in times(run, "released"))


def test_what_a_schedule_asks_for_outside_the_hours_is_released_when_they_begin():
    flow = {
        "from": "storage",
        "to": "desk",
        "arrivals": {"schedule": [{"at": 10}, {"at": 120, "tasks": 2}]},
        "hours": "day",
    }
    run = dw.simulate(dw.load({**SQUARE, "tasks": {"flows": {"in": flow}, "load_time": 5, "unload_time": 3}}))
    assert times(run, "released") == [10, 200, 200]


def test_work_that_is_always_open_has_no_hours():
    flow = {"from": "storage", "to": "desk", "arrivals": {"saturated": 3}, "hours": "day"}
    model = {**SQUARE, "tasks": {"flows": {"in": flow}, "load_time": 5, "unload_time": 3}, "run": {"length": 500}}
    with pytest.raises(dw.ModelError, match=r"tasks.flows.in.hours.*expected hours of the fleet or of stations"):
        dw.load(model)


# Buffers


def test_a_full_buffer_keeps_the_robot_at_the_server():
    """One place, 100 s of work: the second robot comes at 110 and waits until 165, when the first load is done."""
    run = simulated({"layout.stations.desk.work_time": 100, "layout.stations.desk.buffer": 1})
    assert times(run, "worked") == [165, 295, 425]
    assert rows(run, "queueing", "unloading") == [
        ("unloading", 35),
        ("queueing", 110),
        ("unloading", 165),
        ("queueing", 240),
        ("unloading", 295),
    ]


def test_without_a_limit_loads_wait_and_robots_do_not():
    run = simulated({"layout.stations.desk.work_time": 70})
    assert times(run, "delivered") == [65, 140, 215]
    assert times(run, "worked") == [135, 210, 285]


def test_workers_keep_the_hours_of_the_station():
    """Put down at 65, 230 and 305, when it is closed: worked on until 105, 270 and, from 400 on, 440."""
    run = simulated({"layout.stations.desk.work_time": 40, "layout.stations.desk.hours": "day"})
    assert times(run, "worked") == [105, 270, 440]
    pausing = {"layout.stations.desk.work_time": 40, "layout.stations.desk.at_close": "pause"}
    run = simulated({**pausing, "layout.stations.desk.hours": "day"})
    assert times(run, "worked")[0] == 205  # 35 s before 100, and 5 s from 200 on


def test_a_buffer_holds_what_is_worked_on():
    with pytest.raises(dw.ModelError, match="workers: too many"):
        simulated(
            {"layout.stations.desk.work_time": 9, "layout.stations.desk.buffer": 1, "layout.stations.desk.workers": 2}
        )
    with pytest.raises(dw.ModelError, match="buffer: without work"):
        simulated({"layout.stations.desk.buffer": 1})


# Nothing to wait for


def test_hours_that_came_and_went_while_a_robot_worked_are_not_in_vain():
    """It unloads from 35 to 3,035, while its hours change 3,000 times, and again once the station opens at 3,500."""
    changes = {
        "calendars": {"seconds": {"every": 2, "lasts": 1}, "doors": {"between": [[0, 100], [3500, 9000]]}},
        "fleet.hours": "seconds",
        "layout.stations.desk.hours": "doors",
        "tasks.goods": [0, 0],
        "tasks.unload_time": 3000,
    }
    assert times(simulated(changes), "delivered") == [35 + 3000, 3501 + 3000]


def test_a_station_that_opens_after_a_thousand_openings_of_another_is_waited_for():
    """C opens for 1 s at 99, 199, ... 100,099, and E at 100,150, when C has opened 1,001 times.

    The robot is on duty up to 50, 150, ... and at C 25 s after it is sent, so it is never sent there. To E it takes 35
    s: it is sent at 100,115.
    """
    rare = {"every": 100, "lasts": 1, "first": 99}
    over = {
        "calendars.rare": rare,
        "calendars.once": {"between": [[100_150, 101_000]]},
        "fleet.hours": "rounds",
        "layout.stations.gate": {"at": ["C"], "places": 1, "hours": "rare"},
        "layout.stations.desk.hours": "once",
        "tasks.goods": [{"good": 0, "to": "C"}, {"good": 0, "to": "E"}],
        "tasks.unload_at": ["gate", "desk"],
        "tasks.station_choice": "nearest",
        "run.length": 100_300,
    }
    run = simulated(over)
    assert rows(run, "assigned", "docked") == [("assigned", 100_115), ("docked", 100_150)]
    assert run.kpis["backlog"] == 1


def test_hours_that_meet_after_a_thousand_changes_are_not_refused():
    """The robot is on duty every other second: it would be there at 3,000 if sent at 2,965, and is sent at 2,966."""
    calendars = {"seconds": {"every": 2, "lasts": 1}, "seldom": {"every": 20_000, "lasts": 100, "first": 3000}}
    run = simulated(
        {"calendars": calendars, "fleet.hours": "seconds", "layout.stations.desk.hours": "seldom", "tasks.goods": [0]}
    )
    assert times(run, "docked") == [3001]


def test_a_run_without_an_end_waits_for_the_opening_but_not_for_ever():
    """A robot in a station that does not open again: the run is stalled, and says where."""
    over = {"calendars.once": {"between": [[0, 60]]}, "layout.stations.desk.hours": "once"}
    with pytest.raises(StallError, match="stations that do not open again: robot 0 at E"):
        simulated({**over, "layout.stations.desk.at_close": "pause"})


def test_a_run_whose_robots_are_off_for_good_is_stalled():
    over = {"calendars.once": {"between": [[0, 60]]}, "fleet.hours": "once"}
    with pytest.raises(StallError, match=r"1 of 3 tasks .*; robots whose hours are over for good: 0$"):
        simulated(over)


def test_robots_that_are_switched_off_for_good_keep_no_run_going():
    """Away from chargers, and drawing nothing while they stand: no battery is ever low, and nothing else comes."""
    battery = {"capacity": 1000, "threshold": 100, "charge_rate": 10}
    battery["consumption"] = {"standing": 0, "empty": 1, "loaded": 1, "handling": 1}
    over = {"calendars.once": {"between": [[0, 60]]}, "fleet.hours": "once", "layout.bays.home.chargers": 0}
    with pytest.raises(StallError, match="robots whose hours are over for good: 0"):
        simulated({**over, "battery": battery})


def test_shifts_go_on_for_ever_but_keep_no_stalled_run_alive():
    """The station opens for a second, a minute after the shift: who sets out in time for that has no hours any more."""
    calendars = {
        "shift": {"every": "24 h", "lasts": "8 h"},
        "opening": {"every": "24 h", "lasts": "1 s", "first": "28860 s"},
    }
    over = {f"calendars.{name}": value for name, value in calendars.items()}
    with pytest.raises(StallError, match="hours of robots and stations do not meet"):
        simulated({**over, "fleet.hours": "shift", "layout.stations.desk.hours": "opening", "tasks.goods": [0]})


def test_hours_that_never_come_are_an_error_with_the_place():
    over = {"calendars.later": {"between": [[2000, 3000]]}, "run.length": 1000}
    with pytest.raises(CheckError, match=r"layout.stations.desk.hours: calendar 'later' does not open in the run"):
        simulated({**over, "layout.stations.desk.hours": "later"})
    with pytest.raises(CheckError, match=r"fleet.hours: calendar 'later' does not open in the run"):
        simulated({**over, "fleet.hours": "later"})


def test_hours_that_do_not_meet_are_an_error():
    over = {
        "calendars.shift": {"every": "24 h", "lasts": "8 h"},
        "calendars.opening": {"every": "24 h", "lasts": "8 h", "first": "12 h"},
    }
    with pytest.raises(CheckError, match=r"layout.stations.desk.hours: no robot is at work when the station is open"):
        simulated({**over, "fleet.hours": "shift", "layout.stations.desk.hours": "opening"})
