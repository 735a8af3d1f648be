"""Estimates, verdicts, costs and the use of stations count open hours."""

import math

import pytest

import desim_warehouse as dw
from desim_warehouse.feasibility.hours import on_duty
from desim_warehouse.feasibility.mistakes import clashes
from desim_warehouse.model.facts.hours import longest_closed
from desim_warehouse.outcome.resources import resources
from desim_warehouse.questions.check import check
from desim_warehouse.questions.check.details import of_estimate
from desim_warehouse.run.quick import estimate
from tests.world.test_hours import SQUARE
from tests.world.test_zones import LOOP

pytestmark = pytest.mark.usefixtures("brief_probes")

HALF = {"calendars": {"half": {"every": 1000, "lasts": 500}, "eighth": {"every": 800, "lasts": 100}}}
LIFELONG = {
    **SQUARE,
    **HALF,
    "tasks": {**SQUARE["tasks"], "goods": {"poisson": 60}},
    "run": {"length": 80_000},
    "prices": {"hours": 1000, "station_hour": 30},
}


def by_hand(over):
    model = dw.load(LIFELONG, over)
    return estimate(model)


def test_a_station_open_half_of_the_day_has_half_the_capacity():
    always, half = by_hand({}), by_hand({"layout.stations.desk.hours": "half"})
    assert always.stations[0].capacity == 1 / 30
    assert half.stations[0].capacity == pytest.approx(1 / 60)
    assert half.stations[0].busy == pytest.approx(1.0)  # 60 an hour, 30 s each, in half of the time
    assert "busy 100 % of the time in which it is open (50 % of all time)" in "\n".join(
        of_estimate(half, dw.load(LIFELONG).units)
    )


def test_a_run_that_ends_with_its_work_is_measured_by_the_hours_in_which_its_tasks_come():
    """30 tasks come in the first half hour, and the desk is open in it; that it then closes for a day changes nothing.

    If it opens only after 1,800, it serves the 30 until 3,600: in half of the time.
    """
    flow = {"from": "storage", "to": "desk", "arrivals": {"schedule": [{"at": at} for at in range(60, 1860, 60)]}}
    calendars = {"shift": {"every": 86_400, "lasts": 1800}, "next": {"every": 86_400, "lasts": 9000, "first": 1800}}
    tasks = {"load_time": 5, "unload_time": 30, "flows": {"orders": flow}}
    ends = {**SQUARE, "calendars": calendars, "tasks": tasks}
    always, shift, later = (
        estimate(dw.load(ends, {"layout.stations.desk.hours": hours})) for hours in (None, "shift", "next")
    )
    assert always.stations[0].busy == shift.stations[0].busy == pytest.approx(0.5)
    assert shift.rate == pytest.approx(30 / 1800)
    assert (shift.rate, shift.fleet_capacity) == (always.rate, always.fleet_capacity)
    assert (later.stations[0].open, later.rate) == (0.5, pytest.approx(30 / 3600))


def test_robots_at_work_half_of_the_day_do_half_as_much():
    always, half = by_hand({}), by_hand({"fleet.hours": "half"})
    assert half.fleet_capacity == pytest.approx(always.fleet_capacity / 2)
    assert half.robots_busy == pytest.approx(2 * always.robots_busy)
    kinds = {"fleet.size": 4, "fleet.kinds": {"early": {"count": 1, "hours": "half"}}}
    assert on_duty(dw.load(LIFELONG, kinds)) == pytest.approx(0.875)


def test_robots_can_work_only_while_a_station_is_open():
    """Tasks for a station that is closed are held back: a lone robot does as much as the hours of both let it."""
    over = {"layout.stations.desk.hours": "long", "tasks.goods": {"saturated": 2}, "calendars": dict(HALF["calendars"])}
    over["calendars"] |= {
        "long": {"every": 40_000, "lasts": 20_000},
        "after": {"every": 40_000, "lasts": 30_000, "first": 10_000},
    }
    model = dw.load(LIFELONG, over)
    assert on_duty(model) == pytest.approx(0.5)
    by_hand = estimate(model).fleet_capacity * 3600
    assert dw.simulate(model).kpis["throughput_per_hour"] == pytest.approx(by_hand, rel=0.01)
    assert "1 robot, able to work 50 % of the time, can do 24 tasks an hour" in " ".join(check(model).lines)
    both = dw.load(LIFELONG, {**over, "fleet.hours": "after"})
    assert on_duty(both) == pytest.approx(0.25)
    by_hand = estimate(both).fleet_capacity * 3600
    assert dw.simulate(both).kpis["throughput_per_hour"] == pytest.approx(by_hand, rel=0.01)


def test_work_in_the_station_limits_it():
    work = {"layout.stations.desk.work_time": 100, "layout.stations.desk.workers": 2}
    assert by_hand(work).stations[0].capacity == pytest.approx(1 / 50)


def test_a_flow_asks_for_its_rate_in_its_hours_only():
    assert by_hand({"tasks.goods": {"poisson": 60, "hours": "half"}}).rate == pytest.approx(1 / 120)
    flows = {
        "random": {"from": "storage", "to": "desk", "arrivals": {"poisson": 60}, "hours": "half"},
        "profile": {
            "from": "storage",
            "to": "desk",
            "arrivals": {"profile": {"per_hour": [60, 0], "every": 500}},
            "hours": "half",
        },
    }
    model = dw.load({**LIFELONG, "tasks": {"flows": flows, "load_time": 5, "unload_time": 30}})
    assert estimate(model).rate * 3600 == pytest.approx(60)  # both 60 in half of the time


def test_hours_that_end_where_work_ends_by_itself_count_until_they_end():
    """An hour in which station and robots work, and ten tasks at once."""
    changes = {"tasks.goods": {"random": 10}, "run": {}, "calendars.once": {"between": [[0, 3600]]}}
    calculation = by_hand({**changes, "layout.stations.desk.hours": "once", "fleet.hours": "once"})
    assert (calculation.stations[0].open, calculation.on_duty) == (1, 1)
    flow = {"from": "storage", "to": "desk", "arrivals": {"schedule": [{"at": 0, "tasks": 10}]}}
    flows = {"load_time": 5, "unload_time": 30, "flows": {"some": flow}}
    calculation = by_hand({**changes, "tasks": flows, "tasks.goods": None, "layout.stations.desk.hours": "once"})
    assert calculation.stations[0].busy == pytest.approx(10 * 30 / 3600)


@pytest.mark.parametrize("place", ["layout.stations.desk.hours", "fleet.hours", "tasks.goods.hours"])
def test_nothing_is_worked_out_for_hours_that_never_come(place):
    changes = {"tasks.goods": {"poisson": 60}, "calendars.late": {"between": [[90_000, 91_000]]}}
    report = check(dw.load(LIFELONG, {**changes, place: "late"}))
    assert (report.findings[0].code, report.calculation, report.lines) == ("NEVER_OPEN", None, [])
    assert report.findings[0].text == "calendar 'late' does not open in the run, which lasts 22.22 h"


def test_the_busiest_hour_of_a_flow_with_hours_is_that_of_a_profile_with_the_same_rates():
    """60 an hour in two of eight hours, 15 on average: one robot does 48 an hour, however seldom it has to."""
    calendar = {"calendars": {**LIFELONG["calendars"], "evening": {"every": 28_800, "lasts": 7200, "first": 1800}}}
    ends = {"from": "storage", "to": "desk"}
    rates = [0, *[60] * 4, *[0] * 11]
    flows = {
        "hours": {**ends, "arrivals": {"poisson": 60}, "hours": "evening"},
        "profile": {**ends, "arrivals": {"profile": {"per_hour": rates, "every": 1800}}},
    }
    tasks = {"load_time": 5, "unload_time": 30}
    over = {**calendar, "run.length": 86_400}
    models = [dw.load({**LIFELONG, "tasks": {**tasks, "flows": {name: flow}}}, over) for name, flow in flows.items()]
    models.append(dw.load(LIFELONG, {**over, "tasks.goods": {"poisson": 60, "hours": "evening"}}))
    reports = [check(model) for model in models]
    assert [one.calculation.rate * 3600 for one in reports] == [pytest.approx(15)] * 3
    assert [one.calculation.peak * 3600 for one in reports] == [pytest.approx(60)] * 3
    for one in reports:
        assert "the 15 demanded need 0.3125 robots; the 60 of the busiest hour need 1.345 robots" in " ".join(one.lines)
        assert "PEAK_ABOVE_FLEET" in {item.code for item in one.findings}


def test_in_the_busiest_hour_all_robots_are_taken_to_be_at_work():
    """Robots work when orders come, and do 96 an hour then, 48 on average: they keep up with 60 in the busiest hour."""
    over = {"calendars.half": {"every": 28_800, "lasts": 14_400}, "run.length": 86_400, "fleet.hours": "half"}
    report = check(dw.load(LIFELONG, {**over, "fleet.size": 2, "tasks.goods": {"poisson": 60, "hours": "half"}}))
    assert report.calculation.fleet_capacity * 3600 == pytest.approx(48)
    estimate = report.calculation
    # 75 s for a task each are 1.25 robots, which never wait; with queues as of robots that come at random, 1.345
    assert estimate.robots_needed == pytest.approx(1.3, abs=0.06)
    assert estimate.busiest_hour.robots_needed == pytest.approx(estimate.robots_needed)
    assert "PEAK_ABOVE_FLEET" not in {item.code for item in report.findings}


def test_check_says_that_opening_hours_are_too_short():
    report = check(dw.load(LIFELONG, {"layout.stations.desk.hours": "eighth", "fleet.size": 9}))
    texts = {item.code: item.text for item in report.findings}
    assert "% of the opening time of its 1 server" in texts["DEMAND_ABOVE_STATIONS"]


def test_handling_times_of_a_station_are_in_the_cycle():
    assert by_hand({"layout.stations.desk.unload_time": 10}).cycle.unload == pytest.approx(10)
    flow = {"from": "desk", "to": "storage", "arrivals": {"poisson": 6}}
    model = dw.load(
        {**LIFELONG, "tasks": {"flows": {"in": flow}, "load_time": 5, "unload_time": 30}},
        {"layout.stations.desk.load_time": 12},
    )
    cycle = estimate(model).cycle
    assert (cycle.load, cycle.unload) == pytest.approx((12, 30))


def test_the_longest_time_outside_the_hours():
    assert longest_closed(dw.load(LIFELONG)) == 0
    assert longest_closed(dw.load(LIFELONG, {"layout.stations.desk.hours": "half"})) == 500
    assert longest_closed(dw.load(LIFELONG, {"layout.stations.desk.hours": "half", "fleet.hours": "eighth"})) == 700


def test_what_waits_for_the_next_opening_is_no_overload_and_overload_is():
    """15 tasks an hour, and the run ends after a long night; then with hours in which only a third can be done."""
    calendars = {"day": {"every": 40_000, "lasts": 20_000}, "short": {"every": 1000, "lasts": 100}}
    model = {**LIFELONG, "calendars": calendars, "tasks": {**SQUARE["tasks"], "goods": {"poisson": 30}}}
    night = dw.simulate(dw.load(model, {"layout.stations.desk.hours": "day"}))
    assert night.kpis["backlog"] > 100
    assert [one.code for one in night.verdicts if one.code == "CANNOT_KEEP_UP"] == []
    short = dw.simulate(dw.load(model, {"layout.stations.desk.hours": "short"}))
    assert "CANNOT_KEEP_UP" in {one.code for one in short.verdicts}


def test_one_robot_that_leaves_early_is_no_excuse_for_the_others():
    """Four robots do 192 an hour, and 400 are asked for; the fifth is there for a quarter of the run."""
    calendars = {"morning": {"between": [[0, 9000]]}}
    over = {
        "calendars": calendars,
        "tasks.goods": {"poisson": 400},
        "run.length": 36_000,
        "layout.stations.desk.servers": 5,
    }
    places = {"layout.stations.desk.places": 5, "layout.bays.home.places": 5, "fleet.size": 5}
    kinds = {"fleet.kinds": {"temporary": {"count": 1, "hours": "morning"}}}
    model = dw.load(LIFELONG, {**over, **places, **kinds})
    assert longest_closed(model) == pytest.approx(27_000 / 5)
    assert "CANNOT_KEEP_UP" in {one.code for one in dw.simulate(model).verdicts}


def test_only_open_hours_of_servers_are_paid():
    always = dw.simulate(dw.load(LIFELONG, {"tasks.goods": {"poisson": 6}}))
    half = dw.simulate(dw.load(LIFELONG, {"tasks.goods": {"poisson": 6}, "layout.stations.desk.hours": "half"}))
    assert always.kpis["annual_cost"] == pytest.approx(30_000)
    assert half.kpis["annual_cost"] == pytest.approx(15_000)


def test_a_station_is_in_use_for_a_part_of_its_open_time():
    run = dw.simulate(dw.load(LIFELONG, {"layout.stations.desk.hours": "half", "tasks.goods": {"saturated": 5}}))
    desk = next(one for one in resources(run.history) if one.kind == "station")
    used = run.robots["unloading"].sum() / 40_000
    assert desk.utilisation(0, run.T) == pytest.approx(used)
    assert math.isnan(desk.utilisation(600, 900))  # it is closed


def test_a_break_of_one_station_is_named_though_other_flows_go_on():
    """Packing rests from 7 to 13 h; of the 8 h all orders of 5 h 50 min are late, while loads are put away."""
    packing = {"at": ["D"], "places": 3, "hours": "pack"}
    flows = {
        "in": {"from": "dock", "to": "storage", "arrivals": {"poisson": 20}},
        "picks": {"from": "storage", "to": "packing", "arrivals": {"poisson": 20}, "due_within": "10 min"},
    }
    changes = {
        "calendars.pack": {"open": ["06:00-07:00", "13:00-14:00"]},
        "layout.stations": {"packing": packing, "dock": {"at": ["C"], "places": 3}},
        "tasks": {"flows": flows, "load_time": 1, "unload_time": 1},
        "run": {"start": "06:00", "length": "8 h"},
    }
    model = dw.load(LOOP, changes)
    warned = {one.place: one.text for one in clashes.warnings(model, model.floor) if one.code == "BREAK_BEYOND_DUE"}
    assert list(warned) == ["tasks.flows.picks.due_within"]
    assert "(72.92 % of the time)" in warned["tasks.flows.picks.due_within"]
