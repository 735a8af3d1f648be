"""Robots that rest where they put their load down: where, until when, and who makes them go. By hand."""

import pytest

import desim_warehouse as dw

RING = {
    "name": "ring",
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 20], "D": [0, 20]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "bays": {"home": {"at": ["A"], "places": 4}},
        "stations": {"dock": {"at": ["B"], "places": 2}, "pack": {"at": ["D"], "places": 2}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {"load_time": 4, "unload_time": 6},
    "policies": {"parking": "where-it-is"},
}
"""One way round, 20 to a side; a robot at A drives at speed 1, and keeps D = 1."""
GAP = (3**0.5 - 1) / 2
"""How far beyond a corner of 90 degrees a robot must be before the next may come, as a part of D."""


def ring(*times, to="pack", **changes):
    flow = {**one_at(*times), "to": to}
    changes = {key.replace("__", "."): value for key, value in changes.items()}
    return dw.simulate(dw.load(RING, {"tasks.flows": {"flow": flow}, **changes}))


def states(run, robot=0):
    return [(span.state, span.start) for span in run.history.states[robot]]


def test_it_rests_in_the_station_where_it_unloaded_and_the_run_ends_when_all_rest():
    run = ring(0, 100)
    # A to B 20, loads to 24; B to D 40: 64, unloads to 70 and rests there; from D to B 40: 140, loads to 144, 184, 190
    assert states(run)[:5] == [("empty", 0), ("loading", 20), ("loaded", 24), ("unloading", 64), ("idle", 70)]
    assert states(run)[5:] == [("empty", 100), ("loading", 140), ("loaded", 144), ("unloading", 184)]
    assert run.T == 190


def test_what_others_wait_for_it_leaves_at_once():
    run = ring(0, 10, to="C", fleet__size=2, tasks__unload_time=16)
    # Robot 0 unloads on C from 44 to 60. Robot 1 loads from 30 to 34 and waits from 53 on, at the stop line before C:
    # so robot 0 goes to its bay, C to A 40: 100.
    assert states(run, 0)[3:] == [("unloading", 44), ("returning", 60)]
    # Robot 1 sets out behind it, unloads from 61 on, and rests there: nobody comes.
    assert states(run, 1)[4:] == [("unloading", pytest.approx(61 + GAP)), ("idle", pytest.approx(77 + GAP))]
    assert run.T == 100


def test_one_that_rests_in_the_lane_gives_way_when_another_comes():
    run = ring(0, 100, to="C", fleet__size=2, policies__allocation="nearest")
    # Robot 0 rests on C from 50 on. At 100 the nearest to B is robot 1, in the bay at A: there at 120, loaded at 124,
    # at the stop line before C at 143. Then robot 0 goes, and robot 1 behind it.
    assert states(run, 0)[4:] == [("idle", 50), ("returning", 143)]
    assert states(run, 1)[1:4] == [("empty", 100), ("loading", 120), ("loaded", 124)]
    assert states(run, 1)[4:] == [("unloading", pytest.approx(144 + GAP)), ("idle", pytest.approx(150 + GAP))]
    assert run.T == 183


def test_so_does_one_in_the_only_slot_of_a_station_that_a_task_needs():
    fleet = {"robot": RING["fleet"]["robot"], "size": 2, "kinds": {"red": {"count": 1}, "blue": {"count": 1}}}
    flows = {
        name: {"from": "dock", "to": "pack", "kinds": [name], "arrivals": {"schedule": [{"at": at}]}}
        for name, at in (("red", 0), ("blue", 100))
    }
    run = dw.simulate(dw.load({**RING, "fleet": fleet}, {"tasks.flows": flows, "layout.stations.pack.places": 1}))
    # Red rests in the only slot from 70 on. The task at 100 is for blue, which waits until red is out: at once.
    assert states(run, 0)[4:] == [("idle", 70), ("returning", 100), ("idle", 120)]
    assert states(run, 1)[1:3] == [("empty", 100), ("loading", 120)]
    assert run.T == 170


def test_it_leaves_for_a_charger_when_its_battery_is_as_low_as_that_of_one_that_leaves_its_work():
    battery = {"capacity": 200, "consumption": 1, "charge_rate": 10, "threshold": 100}
    changes = {"battery": battery, "layout.bays.home.chargers": 1, "policies.charging": "threshold"}
    run = dw.simulate(dw.load(RING, {"tasks.flows": {"flow": one_at(0, 500)}, **changes}))
    # It draws 1 a second: 130 left when it rests at 70, 100 at 100. Then D to A 20, and 120 more in 12 s.
    assert states(run)[4:8] == [("idle", 70), ("returning", 100), ("charging", 120), ("idle", 132)]


def test_it_leaves_when_its_hours_end():
    shift = {"open": ["00:00-00:02"]}
    changes = {"calendars": {"shift": shift}, "fleet.hours": "shift", "units": {"time": "s"}}
    run = dw.simulate(dw.load(RING, {"tasks.flows": {"flow": one_at(0, 200)}, "run.length": "5 min", **changes}))
    assert states(run)[4:] == [("idle", 70), ("returning", 120), ("on_break", 140)]


def one_at(*times):
    return {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": time} for time in times]}}
