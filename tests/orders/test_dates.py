"""Dates as people and programs write them: one reader for orders and trips; instants worked out by hand."""

import datetime as dt

import pytest

import desim_warehouse as dw
from desim_warehouse.fleet_log import read_log
from desim_warehouse.orders.day import order_day
from desim_warehouse.values.dates import are_days_of_excel, of_excel, read_date, settled


def one(text, slashes=None):
    date = read_date(text, slashes)
    return None if date is None else f"{date:%Y-%m-%d %H:%M:%S}"


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
        ("2026-03-02 6 am", None, "2026-03-02 06:00:00"),
        ("02.03.2026 22 Uhr", None, "2026-03-02 22:00:00"),
        ("March 2, 2026 6:15:30 PM", None, "2026-03-02 18:15:30"),
        ("20260302 081500", None, "2026-03-02 08:15:00"),
        ("20260302 81500", None, "2026-03-02 08:15:00"),
        ("2026-03-02 06:15 UTC", None, "2026-03-02 06:15:00"),
        ("2026-03-02 13 PM", None, None),
        ("2 Mar 2026 06:15", None, "2026-03-02 06:15:00"),
        ("Mo, 2. März 2026, 06:15 Uhr", None, "2026-03-02 06:15:00"),
        ("", None, None),
    ],
)
def test_dates_are_read_in_many_forms(text, slashes, meant):
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
    days = ["46083.3402", "46083,3611", "46083.340278", "46083.341", "46083", "46083.34037"]
    times = [f"{of_excel(day):%H:%M:%S}" for day in days]
    assert times == ["08:10:00", "08:40:00", "08:10:00", "08:11:00", "00:00:00", "08:10:08"]
    assert f"{of_excel(days[0]):%Y-%m-%d}" == "2026-03-02"


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
    assert are_days_of_excel(numbers) is are


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


def test_whole_numbers_are_seconds_in_our_words_and_days_in_those_of_others(tmp_path):
    day = orders(tmp_path, ["46083", "46084"])
    assert [line.release for line in day.lines] == [46083, 46084]
    day = orders(tmp_path, ["46083", "46084"], heading="created")
    assert clock_of(day) == ["0:00:00", "1 day, 0:00:00"]
    assert f"{day.midnight:%Y-%m-%d}" == "2026-03-02"
    assert {"'created' counts days, as Excel does"} < set(day.assumed)
    assert "dates in 'created' have no time of day: all orders of a day come at 00:00" in day.assumed
    assert [line.release for line in orders(tmp_path, ["60", "46084"], heading="created").lines] == [60, 46084]


@pytest.mark.parametrize(
    ("releases", "clock"),
    [
        (["20260302081500", "20260302091530"], ["8:15:00", "9:15:30"]),
        (["20260302", "20260303"], ["0:00:00", "1 day, 0:00:00"]),
        (["8:15 AM", "1:30:30 pm"], ["8:15:00", "13:30:30"]),
        (["6 am", "22 Uhr"], ["6:00:00", "22:00:00"]),
        (["23:30", "25:10"], ["23:30:00", "1 day, 1:10:00"]),
        (["20260302", "20261399"], []),  # no dates, so seconds: beyond ten years they are none
    ],
)
def test_dates_without_marks_and_times_of_day_in_words(tmp_path, releases, clock):
    day = orders(tmp_path, releases)
    assert clock_of(day) == clock or not clock
    assert (day.midnight is None) == (not clock or not releases[0].startswith("2026"))


def test_dates_and_times_of_cells_of_excel(tmp_path):
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, the extra excel, is not installed")
    columns = {
        "dates": [dt.datetime.fromisoformat(f"2026-03-02 0{hour}:30") for hour in (6, 7)],
        "numbers": [46083.2708333333, 46083.3125],
        "times": [dt.time(6, 30), dt.time(7, 30)],
        "hours": [dt.timedelta(hours=6.5), dt.timedelta(hours=7.5)],
        "texts": ["02.03.2026 06:30", "2 March 2026 7:30 am"],
    }
    for name, cells in columns.items():
        book = openpyxl.Workbook()
        for row in (["Erstellt"], *([cell] for cell in cells)):
            book.active.append(row)
        book.save(tmp_path / f"{name}.xlsx")
        day = order_day(tmp_path / f"{name}.xlsx", dw.load(HALL))
        assert (day.problems, clock_of(day)) == ((), ["6:30:00", "7:30:00"]), name


@pytest.mark.parametrize(
    ("start", "meant"),
    [
        ("06:00", "06:00"),
        ("6:00", "6:00"),
        ("6 am", "06:00"),
        ("22 Uhr", "22:00"),
        ("2026-03-02T06:00", "2026-03-02T06:00"),
        ("2026-03-02 06:00:00", "2026-03-02T06:00"),
        ("02.03.2026 06:00:30", "2026-03-02T06:00:30"),
        ("2 March 2026 6 am", "2026-03-02T06:00"),
        ("3/13/2026 6:00 PM", "2026-03-13T18:00"),
        ("2026-03-01T24:00", "2026-03-02T00:00"),
        ("46083.25", "2026-03-02T06:00"),
        *(
            (text, None)
            for text in ("3/2/2026 06:00", "2026-03-02", "2026-03-02T06:00Z", "24:00", "6", "25:10", "46083")
        ),
    ],
)
def test_the_start_of_a_run_is_read_as_orders_are(start, meant):
    if meant:
        assert dw.load(HALL, {"run.start": start}).run.start == meant
    else:
        with pytest.raises(dw.ModelError, match="not a time"):
            dw.load(HALL, {"run.start": start})


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        (["10am"], ("10:00",)),
        (["10:30 AM", "18 Uhr"], ("10:30", "18:00")),
        (["9 a.m.", "17:30"], ("09:00", "17:30")),
        ({"times": ["9am", "5pm"], "cut_off": "30 min"}, ("09:00", "17:00")),
    ],
)
def test_departures_by_the_clock_may_have_am_and_pm(written, meant):
    due_at = dw.load(HALL, {"tasks.flows.day.due_at": written}).tasks.flows["day"].due_at
    assert getattr(due_at, "times", due_at) == meant


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


def test_a_summer_is_on_the_clock_of_the_hall(tmp_path):
    """An export of half a year: orders of eight o'clock come at eight, before and after clocks change."""
    releases = ["2026-03-02T08:00+01:00", "2026-07-02T08:00+02:00", "2026-11-02T08:00+01:00"]
    day = orders(tmp_path, releases)
    assert (day.problems, [time[-7:] for time in clock_of(day)]) == ((), ["8:00:00"] * 3)
    assert "'release' is as on the clock of the hall, which changes: +01:00 and +02:00 are left out" in day.assumed


@pytest.mark.parametrize(
    ("time", "is_said"),
    [
        ("2026-10-25 02:30", True),
        ("29.03.2026 03:10", True),
        ("2026-03-08 01:59", True),
        ("2026-11-01 01:30", True),
        ("2026-10-18 02:30", False),
        ("2026-03-15 02:30", False),
        ("2026-10-25 08:30", False),
        ("2026-10-25T02:30+01:00", False),
    ],
)
def test_a_night_in_which_clocks_change_is_named_where_no_offset_tells_the_hour(tmp_path, time, is_said):
    note = "in which clocks change, and its times have no offset from UTC: an hour may be missing, or there twice"
    assert any(note in line for line in orders(tmp_path, [time]).assumed) is is_said
    (path := tmp_path / "trips.csv").write_text(f"robot,pick,drop,start,end\nR1,A,B,{time},{time}\n")
    assert any(note in line for line in read_log(path).notes.lines()) is is_said


def test_two_zones_on_one_day_are_no_clock_change(tmp_path):
    releases = ["2026-07-02T08:00+01:00", "2026-07-02T09:30+02:00", "2026-07-02T09:00+01:00", "2026-07-02T22:00+02:00"]
    (problem,) = orders(tmp_path, releases).problems
    assert "a time of another zone than +01:00 (2 rows from row 2 on" in problem


def test_numbers_of_another_program_are_said_to_count_from_the_start(tmp_path):
    day = orders(tmp_path, ["830", "0915"], heading="created")
    assert [line.release for line in day.lines] == [830, 915]
    assert "'created' counts the time from the start of the run" in day.assumed


@pytest.mark.parametrize("number", ["46083.35", "830"])
def test_a_number_among_dates_is_no_second(tmp_path, number):
    day = orders(tmp_path, ["2026-03-02 08:00", number], heading="created")
    (problem,) = day.problems
    assert f"row 2, created: a number among dates or times of day (got '{number}'), expected" in problem
    assert len(day.lines) == 1


def test_dates_that_a_spreadsheet_turned_round_are_refused(tmp_path):
    """British dates opened in an American Excel: 03/02/2026 became March 2, and 13/02/2026 stayed text."""
    day = orders(tmp_path, ["2026-03-02 08:00:00", "13/02/2026 08:10", "14/02/2026 08:10"])
    (problem,) = day.problems
    assert "row 1, release: a date whose day and month a spreadsheet may have exchanged, as those above" in problem
    assert orders(tmp_path, ["2026-02-13 08:00:00", "14/02/2026 08:10"]).problems == ()
    assert orders(tmp_path, ["2026-02-12 08:00:00", "14/02/2026 08:10", "11/02/2026 08:10"]).problems == ()


def test_blanks_at_which_no_line_breaks_are_blanks(tmp_path):
    day = orders(tmp_path, ["2026-03-02\u00a08:05\u202fAM", "2026-03-02 8:10\u00a0AM"])
    assert (day.problems, clock_of(day)) == ((), ["8:05:00", "8:10:00"])
    assert clock_of(orders(tmp_path, ["8:05\u202fPM"])) == ["20:05:00"]


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
    "am and pm": ["2026-03-02 10:00:00 PM", "2026-03-02 10:01:28 PM"],
    "no marks": ["20260302220000", "20260302220128"],
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


def test_trips_with_times_of_day_cross_midnight(tmp_path):
    path = tmp_path / "trips.csv"
    path.write_text("robot,pick,drop,start,end\nr0,A,F,22:10,22:20\nr0,F,A,23:55,00:05\nr0,A,F,00:30,12:40 AM\n")
    assert read_log(path).table["time"].tolist() == [0, 600, 6300, 6900, 8400, 9000]


def test_how_times_of_trips_are_read_is_said(tmp_path):
    lines = read_log(trips(tmp_path, *TRIPS["excel"])).notes.lines()
    assert lines == ["times: each column counts days, as Excel does"]
    lines = read_log(trips(tmp_path, "02/25/2026 10:00 PM", "02/25/2026 10:02 PM")).notes.lines()
    assert lines == ["times: each column has the month first, as some of its dates can be read in no other way"]


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


def test_a_due_date_of_excel_with_a_fraction_has_a_time(tmp_path):
    times, assumed = due_of(tmp_path, ["46083,3402;46083,75", "46083,3402;46084,5"])
    assert times == ["18:00:00", "1 day, 12:00:00"]
    assert not any("end of the day" in text for text in assumed)


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
