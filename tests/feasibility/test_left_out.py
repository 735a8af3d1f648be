"""What keeps robots from work at times, and what of it the quick estimate leaves out: `desim check` says so."""

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.check import check
from tests.world.test_hours import SQUARE

pytestmark = pytest.mark.usefixtures("brief_probes")

LIFELONG = {**SQUARE, "tasks": {**SQUARE["tasks"], "goods": {"poisson": 20}}, "run": {"length": 40_000}}
CALENDARS = {"cleaning": {"every": 1000, "lasts": 250}, "sunday": {"open": ["08:00-12:00"], "days": ["sun"]}}
GATE = {"members": [["A", "B"]]}


def said(over, model=LIFELONG):
    text = "; estimates leave this out"
    facts = check(dw.load(model, {"calendars": CALENDARS, **over})).facts
    ours = ("robots lose", "people (", "the lanes of")
    return [fact.removesuffix(text) for fact in facts if fact.endswith(text) or fact.startswith(ours)]


def test_nothing_is_said_where_nothing_is_left_out():
    assert said({}) == []
    assert said({"traffic.slow": {"ramp": {**GATE, "speed": 0.5}}}) == []  # which estimates know


def test_delays_closures_slow_zones_and_people_are_said():
    assert said({"fleet.robot.delays": {"share": "5 %", "time": {"exponential": 4}}}) == [
        "robots lose 4 s at 5 % of the nodes"
    ]
    assert said({"traffic.closures": {"gate": {**GATE, "hours": "cleaning"}}}) == [
        "the lanes of gate are closed for 25 % of the time"
    ]
    assert said({"traffic.slow": {"ramp": {**GATE, "hours": "cleaning", "speed": 0.5}}}) == [
        "the lanes of ramp are slow for 25 % of the time"
    ]
    assert said({"people": {"pickers": {"per_hour": 60, "stay": 30}, "boss": {"times": [9, 99], "stay": 60}}}) == [
        "people (pickers): an aisle has somebody in it for 39.3 % of the time on average",  # 1 - exp(-0.5)
        "people (boss): 2 visits",
    ]
    hours = {"people": {"pickers": {"per_hour": 60, "stay": 30, "hours": "cleaning"}}}
    assert said(hours) == ["people (pickers): an aisle has somebody in it for 9.84 % of the time on average"]


def test_work_that_a_station_finishes_after_its_hours_is_said_to_be_left_out():
    """Ten minutes an hour are open, and unloading takes 20: half a load an hour by the open time, one as runs show."""
    tasks = {"goods": {"saturated": 2}, "unload_at": ["desk"], "load_time": 0, "unload_time": 1200}
    over = {"calendars.day": {"every": 3600, "lasts": 600}, "layout.stations.desk.hours": "day", "run.length": 72_000}
    model = dw.load({**LIFELONG, "tasks": tasks, "calendars": {}}, over)
    report = check(model)
    assert report.calculation.stations[0].capacity * 3600 == pytest.approx(0.5)
    assert dw.simulate(model).kpis["tasks"] == 20
    assert (
        "robots and stations finish after their hours what they began in them, up to one task more for each in each "
        "opening; estimates leave this out"
    ) in report.facts
    pause = check(model.replace({"layout.stations.desk.at_close": "pause"}))
    assert any(fact.startswith("robots finish after their hours") for fact in pause.facts)


def test_a_closure_that_never_comes_is_a_slip():
    """A run starts on a Monday unless it says otherwise."""
    over = {"traffic.closures": {"gate": {**GATE, "hours": "sunday"}}}
    assert said(over) == []
    model = dw.load(LIFELONG, {"calendars": CALENDARS, **over})
    [slip] = [item for item in check(model).findings if item.code == "NEVER_IN_RUN"]
    assert slip.text == "never closed in this run: calendar 'sunday' does not open in it"
    assert said({**over, "run.start": "2026-03-01T08:00"}) == ["the lanes of gate are closed for 36 % of the time"]


def test_a_run_without_an_end_is_closed_at_times():
    over = {"calendars.once": {"between": [[10, 20]]}, "traffic.closures": {"gate": {**GATE, "hours": "once"}}}
    assert said(over, SQUARE) == ["the lanes of gate are closed at times"]


def test_a_stop_on_the_way_takes_time_to_brake_and_to_gather_speed():
    over = {"fleet.robot.acceleration": 0.5}
    assert "a stop on the way costs up to 2 s of braking and acceleration" in check(dw.load(LIFELONG, over)).facts


def test_what_a_choice_among_waiting_tasks_saves_has_a_line():
    """A shop with 9 robots: of twenty waiting tasks the nearest begins close to where the last one ended."""
    shop = dw.load("models/gallery/e-commerce.yaml")
    [line] = [fact for fact in check(shop).facts if "to choose from" in fact]
    assert line.startswith("with 20 tasks to choose from, nearest drives ")
    in_order = shop.replace({"policies.allocation": "in-order"})
    assert not [fact for fact in check(in_order).facts if "to choose from" in fact]
