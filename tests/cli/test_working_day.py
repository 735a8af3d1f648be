"""Drafts with a working day: shifts, a peak, packers and goods in."""

import shlex
from dataclasses import replace

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.draft import Draft, draft, read_orders
from desim_warehouse.draft.text import in_full
from desim_warehouse.feasibility.asked import orders_a_day
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.questions.check import check
from desim_warehouse.working_day import Peak, WorkingDay, read_peak, read_shifts
from tests.docs import pages

pytestmark = pytest.mark.usefixtures("brief_probes")

HALL = "--size 70x45 --orders 420/h --due 15min --shifts 06-22 --peak 11:30-13x1.6 --packers auto --inbound 60/h"


@pytest.fixture(scope="module")
def drafted(tmp_path_factory):
    file = str(tmp_path_factory.mktemp("new") / "w.yaml")
    done = CliRunner().invoke(desim, ("new", file, *shlex.split(HALL)), catch_exceptions=False)
    return done.stdout, dw.load(file)


def test_the_sentence_repeats_everything_that_it_took(drafted):
    sentence, model = drafted
    station = model.layout.stations["packing"]
    people = station.servers * len(station.at)
    counted = f"13 aisles, {len(station.at)} packing stations, {people} packers, {model.fleet.size} robots"
    assert sentence.startswith(f"70 x 45 m, {counted}, ")
    day = "420 orders an hour from 06:00 to 22:00 with 1.6 times as many from 11:30 to 13:00 = 7,098 orders a day"
    assert f"{day}, due in 15 min, 60 loads an hour = 960 a day put away." in sentence


def test_orders_come_by_the_clock_and_as_many_as_were_said(drafted):
    _, model = drafted
    orders, inbound = (model.tasks.flows[name].arrivals.profile for name in ("orders", "inbound"))
    by_hour = [sum(orders.per_hour[2 * hour : 2 * hour + 2]) / 2 for hour in range(24)]
    assert by_hour == [0] * 6 + [420] * 5 + [546, 672] + [420] * 9 + [0, 0]
    assert sum(inbound.per_hour) == 16 * 60
    assert (model.run.start, model.run.length) == ("06:00", 16 * 3600)
    assert model.tasks.unload_time.mean == pytest.approx(20 * 480 / 450, rel=0.01)  # 30 min of break in 8 h


@pytest.mark.parametrize(
    ("orders", "shifts", "peak", "hourly"),
    [
        ("1600/d", "06-22", None, 100),
        ("1600 / d", None, None, 1600 / 24),
        ("1600/d", "06-22", "11:30-13x1.6", 1600 / (16 + 1.5 * 0.6)),
        ("1600/d", "06-14,15-22", None, 1600 / 15),
        ("100/h", "06-22", "11:30-13x1.6", 100),
        ("2/min", "06-22", None, 120),
        ("1600/d", None, "23-01x2", 1600 / 26),  # an hour of the peak before midnight, and one after
        ("1600/d", "20-04", "23-01x2", 1600 / 10),
    ],
)
def test_orders_of_a_day_come_in_its_hours(orders, shifts, peak, hourly):
    open_from_to = read_shifts(shifts) if shifts else ()
    day = WorkingDay(open_from_to, read_peak(peak, open_from_to) if peak else None)
    assert read_orders(orders, day=day) == pytest.approx(hourly)
    every, rates = day.rates(read_orders(orders, day=day))
    if orders.endswith("d"):
        assert sum(rates) * every / 60 == pytest.approx(1600)


def test_a_draft_and_its_check_say_how_many_orders_a_day_has(tmp_path):
    words = "--size 40x30 --orders 1600/d --shifts 06-22 --inbound 400/d --robots 12 --chargers 4"
    output = CliRunner().invoke(desim, ("new", str(tmp_path / "w.yaml"), *words.split()), catch_exceptions=False).output
    assert "100 orders an hour from 06:00 to 22:00 = 1,600 orders a day" in output
    assert "25 loads an hour = 400 a day put away." in output
    model = dw.load(tmp_path / "w.yaml")
    assert list(orders_a_day(model)) == ["demand: orders 1,600, inbound 400 = 2,000 orders a day"]
    around = model.replace({"tasks.flows": dw.UNSET, "tasks.goods": {"poisson": 50}, "tasks.unload_at": ["packing"]})
    assert list(orders_a_day(around)) == ["demand: 50 an hour = 1,200 orders a day"]


@pytest.mark.parametrize("words", ["--shifts 00-24", "--shifts 04-02", "--shifts 22-06", "--peak 23-01x2"])
def test_check_has_no_remarks_on_a_draft(words, tmp_path):
    """Neither on batteries that are full though no night fills them, nor on hours of the clock that the draft wrote."""
    words += " --size 24x20 --orders 60/h --robots 6 --chargers 6"
    CliRunner().invoke(desim, ("new", str(tmp_path / "w.yaml"), *words.split()), catch_exceptions=False)
    assert not check(dw.load(tmp_path / "w.yaml")).findings


def test_fleet_and_packers_are_for_the_busiest_hour(drafted):
    _, model = drafted
    assert not check(model).findings
    bays = model.layout.bays["charging"]
    assert bays.total_chargers * 0.02 * 8 * 3600 >= 100 * model.fleet.size  # a night of eight hours fills them all
    station = model.layout.stations["packing"]
    assert 672 * 20 / 3600 / (station.servers * len(station.at)) <= 0.75


@pytest.mark.parametrize("length", [2400, pytest.param(6300, marks=pytest.mark.long)])
def test_in_the_busiest_hour_orders_are_on_time(drafted, length):
    """From a quarter of an hour before the peak to its first or its last order."""
    _, model = drafted
    peak = {"run.start": "11:15", "run.length": length}
    assert dw.simulate(model.replace(peak), 3).kpis["on_time"] > 0.97


def test_a_draft_without_people_is_as_it_was():
    model = dw.Model.model_validate(read_yaml(draft(Draft(orders=60, due=15)), "draft").data)
    assert model.tasks.unload_time == 20
    assert model.tasks.goods.poisson == 60


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("--shifts 22-22", "--shifts 22-22: not from one time to another"),
        ("--shifts 06-22 --peak 23-01x2", "--peak 23-01x2: outside the shifts"),
        ("--shifts 22-06,5-10", "they overlap"),
        ("--shifts 13pm-10pm", "not from one time to another"),
        ("--peak 13-11:30x1.6", "--peak 13-11:30: not from one time to another"),
        ("--shifts 22-06 --peak 05-07x2", "outside the shifts"),
        ("--shifts 06-14,13-22", "they overlap"),
        ("--peak noon", "--peak noon: no peak, expected from-to and times as many"),
        ("--shifts 06-12 --peak 11:30-13x2", "outside the shifts"),
        ("--peak 11-12x100", "no peak"),
        ("--packers few", "--packers few: not a number of people"),
        ("--packers 5 --stations 3", "expected a multiple of 3"),
        ("--inbound some", "--inbound some: not a rate, expected inbound an hour"),
        ("--inbound 20/h --stations 4 --aisles 4", "no aisle is left for goods in"),
    ],
)
def test_words_that_make_no_day_are_refused_with_the_option(tmp_path, words, expected):
    status, _, message = pages.run_desim(f"desim new {tmp_path / 'w.yaml'} {words}")
    assert status == 2
    assert expected in message


def test_packers_that_are_given_are_spread_evenly():
    words = Draft(size=(40, 30), orders=300, day=WorkingDay(()), people=True, packers=6)
    station = dw.Model.model_validate(read_yaml(draft(words), "draft").data).layout.stations["packing"]
    assert station.servers * len(station.at) == 6


def test_packers_that_are_too_few_for_the_peak_are_told_how_many_it_needs():
    """165 orders of 20 s in the busiest hour take 55 min, and a packer is busy for 45 min of an hour at most."""
    day = WorkingDay(((360, 840),), Peak((660, 780), 1.1))
    words = Draft(orders=150, aisles=5, stations=1, robots=8, chargers=1, day=day, people=True)
    assert "1 packing station, 1 packer (the busiest hour needs 2), 8 robots, " in in_full(replace(words, packers=1))
    assert "1 packing station, 2 packers, 8 robots, " in in_full(replace(words, packers=2))


@given(
    st.lists(st.integers(0, 47), min_size=2, max_size=6, unique=True).map(sorted), st.integers(1, 4), st.floats(0.5, 5)
)
def test_rates_add_up_to_the_shifts_and_the_peak(ends, part, times):
    halves = list(zip(ends[::2], ends[1::2], strict=False))
    text = ",".join(f"{a // 2}:{a % 2 * 30:02}-{b // 2}:{b % 2 * 30:02}" for a, b in halves)
    shifts = read_shifts(text)
    begin, end = shifts[0]
    peak = Peak((begin, begin + (end - begin) * part // 4 // 30 * 30 or end), times)
    every, rates = WorkingDay(shifts, peak if peak.stretch[1] > begin else None).rates(100)
    open_for = sum(b - a for a, b in shifts)
    more = (times - 1) * (peak.stretch[1] - peak.stretch[0]) if peak.stretch[1] > begin else 0
    assert sum(rates) * every == pytest.approx(100 * (open_for + more))


def test_times_of_day_are_read_as_people_write_them():
    assert read_shifts("06-14,14-22") == ((360, 1320),)
    assert read_shifts("6-14,15:30-22") == ((360, 840), (930, 1320))
    assert read_shifts("6am-10pm") == read_shifts("6:00 AM - 10 p.m.") == ((360, 1320),)
    assert read_shifts("12am-12pm") == ((0, 720),)
    assert read_peak("11:30am-1pmx1.6", ()) == read_peak("11:30-13x1.6", ()) == Peak((690, 780), 1.6)
    assert read_peak("11:30-13*2", ((360, 1320),)).times == 2


@pytest.mark.parametrize(
    ("text", "shifts"),
    [
        ("22-06", ((1320, 1800),)),
        ("10pm-6am", ((1320, 1800),)),
        ("14-22,22-06", ((840, 1800),)),
        ("22-06,06-14", ((1320, 2280),)),  # begins in the evening, not with what is left in the morning
        ("06-14,14-22,22-06", ((360, 1800),)),
        ("08-12,23-02", ((480, 720), (1380, 1560))),
    ],
)
def test_a_night_shift_ends_on_the_next_day(text, shifts):
    assert read_shifts(text) == shifts
    day = WorkingDay(shifts)
    every, rates = day.rates(60)
    assert sum(rates) * every == 60 * sum(end - begin for begin, end in shifts)
    assert day.length == shifts[-1][1] - shifts[0][0]


def test_a_night_shift_has_its_orders_in_the_night(tmp_path):
    output = pages.run_desim(f"desim new {tmp_path / 'n.yaml'} --shifts 10pm-6am --peak 01-03x2 --orders 800/d")[1]
    assert "80 orders an hour from 22:00 to 06:00 with 2 times as many from 01:00 to 03:00 = 800 orders a day" in output
    model = dw.load(str(tmp_path / "n.yaml"))
    assert (model.run.start, model.run.length) == ("22:00", 8 * 3600)
    assert model.tasks.flows["orders"].arrivals.profile.per_hour == (80, 160, 160, 80, 80, 80, *[0] * 16, 80, 80)
    assert sum(model.tasks.flows["orders"].arrivals.profile.per_hour) == 800
