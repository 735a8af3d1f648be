"""Dates as people and programs write them: one reader for orders and trips; instants worked out by hand."""

import datetime as dt

import pandas as pd
import pytest

import desim_warehouse as dw
from desim_warehouse.fleet_log import read_log
from desim_warehouse.orders.day import order_day
from desim_warehouse.values.dates import are_days_of_excel, of_excel, read_dates, settled


def one(text, slashes=None):
    date = read_dates(pd.Series([text], dtype=object), slashes).iloc[0]
    return None if pd.isna(date) else f"{date:%Y-%m-%d %H:%M:%S}"


@pytest.mark.parametrize(
    ("text", "slashes", "meant"),
    [
        ("2026-03-02 8:00 AM", None, "2026-03-02 08:00:00"),
        ("2026-03-02 12:05 am", None, "2026-03-02 00:05:00"),
        ("2026-03-02 12:05 p.m.", None, "2026-03-02 12:05:00"),
        ("2026-03-02T11:59:30 PM", None, "2026-03-02 23:59:30"),
        ("2026/03/02", None, "2026-03-02 00:00:00"),
        ("2026/3/2 7:05", None, "2026-03-02 07:05:00"),
        ("2026.03.02 07:05:09", None, "2026-03-02 07:05:09"),
        ("2026-03-02 24:00", None, "2026-03-03 00:00:00"),
        ("2026-12-31T24:00:00", None, "2027-01-01 00:00:00"),
        ("28.02.2028 24:00", None, "2028-02-29 00:00:00"),
        ("2026-03-02 24:01", None, None),
        ("2026-03-02 13:00:61", None, None),
        ("3/2/2026 2:00 PM", "us", "2026-03-02 14:00:00"),
        ("3/2/2026 2:00 PM", "uk", "2026-02-03 14:00:00"),
        ("3/2/2026 2:00 PM", None, None),
        ("13/2/2026", "us", None),
        ("2026-13-02", None, None),
        ("2 Mar 2026 06:15", None, "2026-03-02 06:15:00"),
        ("Mo, 2. März 2026, 06:15 Uhr", None, "2026-03-02 06:15:00"),
        ("", None, None),
    ],
)
def test_dates_in_many_forms(text, slashes, meant):
    assert one(text, slashes) == meant


@pytest.mark.parametrize(
    ("texts", "meant"),
    [
        (["12/11/2018", "12/13/2018"], "us"),
        (["12/11/2018", "13/12/2018"], "uk"),
        (["12/11/2018", "11/12/2018"], None),
        (["12/13/2018", "13/12/2018"], None),
        (["12-13-18 08:00"], "us"),
        (["2018-12-13", "6:15"], None),
    ],
)
def test_one_date_with_one_reading_settles_a_column(texts, meant):
    assert settled(texts) == meant


def test_days_of_excel_are_dates_to_the_minute_where_their_digits_say_no_more():
    days = pd.Series(["46083.3402", "46083.3611", "46083.340278", "46083.341", "46083", "46083.34037"])
    times = [f"{date:%H:%M:%S}" for date in of_excel(days)]
    assert times == ["08:10:00", "08:40:00", "08:10:00", "08:11:00", "00:00:00", "08:10:08"]
    assert f"{of_excel(days)[0]:%Y-%m-%d}" == "2026-03-02"


@pytest.mark.parametrize(
    ("numbers", "are"),
    [
        ([46083.34, 46084.5], True),
        ([46083.0, 46084.0], False),  # seconds, as far as anybody can tell
        ([60.5, 46083.3], False),
        ([46083.3, 46183.3], False),
        ([], False),
    ],
)
def test_what_is_taken_for_days_of_excel(numbers, are):
    assert are_days_of_excel(pd.Series(numbers, dtype=float).to_numpy()) is are


HALL = {
    "layout": {
        "blocks": {"columns": 3, "rows": 2, "block_depth": 6, "goods_size": 1.2, "aisle_width": 1.8},
        "bays": {"parking": {"along": "north"}},
        "stations": {"packing": {"at": ["L"]}},
    },
    "fleet": {"size": 2, "robot": {"radius": 0.35, "speed": 1.2}},
    "tasks": {
        "load_time": 8,
        "unload_time": 5,
        "flows": {"day": {"from": "storage", "to": "packing", "arrivals": {"schedule": [{"at": 0}]}}},
    },
}


def orders(folder, releases, start="00:00", heading="release", **options):
    path = folder / "day.csv"
    path.write_text("\n".join([f"order;{heading}", *(f"{rank};{text}" for rank, text in enumerate(releases))]))
    return order_day(path, dw.load(HALL, {"run.start": start}), **options)


def clock_of(day):
    return [f"{dt.timedelta(seconds=day.time_of(line.release))}" for line in day.lines]


@pytest.mark.parametrize("heading", ["release", "created"])
def test_orders_of_excel_come_on_their_day(tmp_path, heading):
    day = orders(tmp_path, ["46083,3402", "46083,3611"], heading=heading)
    assert (day.problems, clock_of(day)) == ((), ["8:10:00", "8:40:00"])
    assert f"{day.midnight:%Y-%m-%d}" == "2026-03-02"
    assert f"'{heading}' counts days, as Excel does" in day.assumed


def test_seconds_beside_whole_numbers_stay_seconds(tmp_path):
    day = orders(tmp_path, ["46083", "46084"])
    assert [line.release for line in day.lines] == [46083, 46084]


def test_dates_alone_are_said(tmp_path):
    day = orders(tmp_path, ["2026-03-02", "2026-03-02", "2026-03-03"])
    assert "dates in 'release' have no time of day: all orders of a day come at 00:00" in day.assumed
    assert not orders(tmp_path, ["2026-03-02", "2026-03-02 08:00"]).assumed[1:]


def test_a_column_with_one_reading_is_read_so_and_said(tmp_path):
    day = orders(tmp_path, ["12/11/2018 06:00", "12/13/2018 06:00"])
    assert f"{day.midnight:%Y-%m-%d}" == "2018-12-11"
    assert "'release' has the month first, as some of its dates can be read in no other way" in day.assumed
    (problem,) = orders(tmp_path, ["12/11/2018 06:00", "11/12/2018 06:00"]).problems
    assert "a date that may be meant in two ways" in problem
    assert orders(tmp_path, ["12/11/2018 06:00", "11/12/2018 06:00"], dates="uk").problems == ()


@pytest.mark.parametrize(
    ("releases", "clock"),
    [
        (["2026-03-29T01:30:00+01:00", "2026-03-29T03:30:00+02:00"], ["1:30:00", "2:30:00"]),
        (["2026-10-25T02:30:00+02:00", "2026-10-25T02:30:00+01:00"], ["2:30:00", "3:30:00"]),
        (["2026-03-08T01:30-05:00", "2026-03-08T03:30-04:00"], ["1:30:00", "2:30:00"]),
    ],
)
def test_offsets_of_a_night_of_a_clock_change_are_instants(tmp_path, releases, clock):
    day = orders(tmp_path, releases)
    assert (day.problems, clock_of(day)) == ((), clock)
    assert any("times are instants, on the clock of" in one for one in day.assumed)


def test_other_offsets_are_refused(tmp_path):
    (problem,) = orders(tmp_path, ["2026-03-29T01:30Z", "2026-03-29T03:30+05:00"]).problems
    assert "a time of another zone than Z" in problem


def test_a_date_of_nothing_moves_no_start(tmp_path):
    day = orders(tmp_path, ["1900-01-01 00:00", *(f"2026-03-02 0{hour}:00" for hour in range(6, 9))])
    assert f"{day.midnight:%Y-%m-%d}" == "2026-03-02"
    assert clock_of(day) == ["6:00:00", "7:00:00", "8:00:00"]
    (problem,) = day.problems
    assert "before the start of the run (got '1900-01-01 00:00')" in problem


TRIPS = {
    "iso": ["2026-03-02 22:00:00", "2026-03-02 22:01:28"],
    "german": ["02.03.2026 22:00:00", "02.03.2026 22:01:28"],
    "words": ["2 March 2026 22:00:00", "2 March 2026 22:01:28"],
    "zone": ["2026-03-02T23:00:00+01:00", "2026-03-02T23:01:28+01:00"],
    "seconds": ["1772488800", "1772488888"],
    "excel": ["46083.916667", "46083.917685"],
}


def trips(folder, start, end):
    path = folder / "trips.csv"
    path.write_text(f"robot,pick,drop,start,end\nr0,A,F,{start},{end}\n")
    return path


@pytest.mark.parametrize("written", TRIPS)
def test_trips_are_read_as_orders_are(tmp_path, written):
    log = read_log(trips(tmp_path, *TRIPS[written]))
    assert log.begin == pytest.approx(1_772_488_800, abs=0.1)
    assert log.length == pytest.approx(88, abs=0.1)


def test_trips_with_two_readings_are_asked_about(tmp_path):
    path = trips(tmp_path, "03/02/2026 10:00:00 PM", "03/02/2026 10:01:28 PM")
    with pytest.raises(dw.ReportError, match=r"a date that may be meant in two ways .* expected --dates us or uk"):
        read_log(path)
    assert read_log(path, dates="us").begin == 1_772_488_800
    assert read_log(trips(tmp_path, "02/25/2026 10:00 PM", "02/25/2026 10:02 PM")).length == 120


def due_of(folder, rows, start="06:00", **options):
    """When lines are due, by the clock of the day of the run, and what was assumed."""
    path = folder / "due.csv"
    path.write_text("\n".join(["release;due", *rows]))
    day = order_day(path, dw.load(HALL, {"run.start": start}), **options)
    assert day.problems == ()
    return [f"{dt.timedelta(seconds=day.time_of(line.due))}" for line in day.lines], day.assumed


@pytest.mark.parametrize(
    ("rows", "due"),
    [
        (["2026-03-02 08:00;2026-03-02"], ["1 day, 0:00:00"]),
        (["02.03.2026 08:00;03.03.2026"], ["2 days, 0:00:00"]),
        (["2026-03-02 08:00;2026-03-02", "2026-03-02 09:00;2026-03-02 18:00"], ["1 day, 0:00:00", "18:00:00"]),
        (["2026-03-02 08:00;2026-03-02 00:00:00"], ["1 day, 0:00:00"]),  # as Excel has a day
        (["46083,3402;46083", "46083,3611;46084"], ["1 day, 0:00:00", "2 days, 0:00:00"]),
    ],
)
def test_a_due_date_without_a_time_is_the_end_of_that_day(tmp_path, rows, due):
    times, assumed = due_of(tmp_path, rows)
    assert times == due
    assert "dates in 'due' have no time of day: due at the end of the day" in assumed


def test_due_dates_of_which_some_are_at_midnight_are_read_as_they_are(tmp_path):
    rows = ["2026-03-02 08:00;2026-03-03 00:00", "2026-03-02 08:00;2026-03-02 18:00"]
    times, assumed = due_of(tmp_path, rows)
    assert times == ["1 day, 0:00:00", "18:00:00"]
    assert not any("end of the day" in text for text in assumed)


@pytest.mark.parametrize(
    ("releases", "start", "clock"),
    [
        (["22:10", "23:50", "00:10", "05:30"], "22:00", ["22:10:00", "23:50:00", "1 day, 0:10:00", "1 day, 5:30:00"]),
        (["22:10", "23:50", "00:10", "05:30"], "00:00", ["22:10:00", "23:50:00", "1 day, 0:10:00", "1 day, 5:30:00"]),
        (["00:10", "23:50", "05:30", "22:10"], "22:00", ["22:10:00", "23:50:00", "1 day, 0:10:00", "1 day, 5:30:00"]),
    ],
)
def test_times_of_day_of_a_night_shift_cross_midnight(tmp_path, releases, start, clock):
    day = orders(tmp_path, releases, start)
    assert (day.problems, clock_of(day)) == ((), clock)
    assert "'release' crosses midnight: 00:10 is on the next day" in day.assumed


@pytest.mark.parametrize("releases", [["06:00", "20:00", "06:30"], ["08:00", "07:00", "09:00"], ["00:10", "22:10"]])
def test_times_of_one_day_in_no_order_stay_on_it(tmp_path, releases):
    day = orders(tmp_path, releases, "00:00")
    assert [f"{clock:0>8}"[:5] for clock in clock_of(day)] == sorted(releases)
    assert not any("midnight" in text for text in day.assumed)


def test_an_order_just_before_the_start_is_no_night_shift(tmp_path):
    (problem,) = orders(tmp_path, ["05:50", "07:00"], "06:00").problems
    assert "before the start of the run (got '05:50')" in problem


def test_an_order_of_the_night_is_due_after_midnight(tmp_path):
    assert due_of(tmp_path, ["23:40;00:20", "00:10;00:40"], "22:00")[0] == ["1 day, 0:20:00", "1 day, 0:40:00"]


@pytest.mark.parametrize("nothing", ["1900-01-01 00:00", "1970-01-01 00:00", "9999-12-31 00:00", "31.12.9999"])
def test_dates_of_nothing_move_no_start_and_are_named(tmp_path, nothing):
    day = orders(tmp_path, ["2026-03-02 06:00", nothing, "2026-03-02 07:00"])
    assert clock_of(day) == ["6:00:00", "7:00:00"]
    (problem,) = day.problems
    assert f"row 2, release: {'later' if '9999' in nothing else 'before'}" in problem
