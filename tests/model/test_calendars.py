"""Calendars: by the clock, as patterns, as stretches; and as times of a run."""

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.errors import ModelError
from desim_warehouse.model import load
from desim_warehouse.values.calendars import ALWAYS, Hours, Pattern, Shifts, Stretches, repeat_together

TUTORIAL = Path(__file__).parents[2] / "models" / "tutorial.yaml"
HOUR = 3600.0


def opens(hours, count):
    """The first stretches of a run, in hours."""
    stretches, time = [], 0.0
    for _ in range(count):
        begin, time = hours.following(time)
        stretches.append((begin / HOUR, time / HOUR))
    return stretches


def test_a_shift_with_a_break_on_a_run_that_starts_within_it():
    day = Shifts(open=("06:00-14:00",), breaks=("10:00-10:15",))
    assert opens(day.hours("08:00", 1.0), 3) == [(-2, 2), (2.25, 6), (22, 26)]


def test_a_night_shift_goes_past_midnight_and_past_the_week():
    night = Shifts(open=("22:00-06:00",), days=("sun",))
    assert opens(night.hours("2026-03-01T20:00", 1.0), 2) == [(2, 10), (170, 178)]  # a Sunday
    assert opens(night.hours("2026-03-02T00:00", 1.0), 2) == [(0, 6), (166, 174)]  # the Monday after it


def test_open_all_day_has_no_change_at_midnight():
    assert Shifts(open=("00:00-24:00",)).hours("12:00", 1.0).changes(0.0) == math.inf


def test_a_pattern_begins_with_its_first():
    cleaning = Pattern(every=8.0, lasts=0.5, first=2.0).hours("00:00", 1.0)
    assert [cleaning.following(time) for time in (0.0, 2.0, 2.5, 9.0)] == [(2, 2.5), (2, 2.5), (10, 10.5), (10, 10.5)]
    assert not cleaning.is_open(1.9)


def test_stretches_are_over_after_the_last():
    hours = Stretches(between=((5.0, 6.0), (2.0, 3.0), (2.5, 4.0))).hours("00:00", 1.0)
    assert hours.stretches == [(2, 4), (5, 6)]
    assert hours.following(6.0) == (math.inf, math.inf)
    assert hours.when_open(3.0) == 6
    assert hours.when_open(3.1) == math.inf


def test_the_share_that_is_open_without_an_end_is_of_a_period_or_until_it_closes_for_good():
    assert Pattern(every=8.0, lasts=2.0, first=3.0).hours("00:00", 1.0).share(0.0, math.inf) == 0.25
    assert Stretches(between=((0.0, 3.0), (6.0, 8.0))).hours("00:00", 1.0).share(0.0, math.inf) == 5 / 8
    assert ALWAYS.share(0.0, math.inf) == 1.0


MANY = st.one_of(
    st.builds(
        lambda lasts, more, first: Pattern(every=lasts + more, lasts=lasts, first=first).hours("00:00", 1.0),
        st.integers(1, 9).map(float),
        st.integers(0, 9).map(float),
        st.integers(0, 30).map(float),
    ),
    st.lists(st.tuples(st.integers(0, 40), st.integers(1, 9)), min_size=1, max_size=4).map(
        lambda pairs: Stretches(between=tuple((float(a), float(a + b)) for a, b in pairs)).hours("00:00", 1.0)
    ),
    st.tuples(st.integers(0, 11), st.integers(12, 23), st.integers(0, 23)).map(
        lambda times: Shifts(open=(f"{times[0]:02}:00-{times[1]:02}:00",), days=("mon", "thu")).hours(
            f"{times[2]:02}:00", 1 / 3600
        )
    ),
)


def test_times_of_day_are_written_as_people_do():
    assert Shifts(open=("6:00 - 14:30",)).hours("00:00", 1 / HOUR).following(0.0) == (6, 14.5)
    assert Shifts(open=("22:00-24:00",)).hours("00:00", 1 / HOUR).following(0.0) == (22, 24)
    assert Shifts(open=("6am - 2:30 PM",), breaks=("10 a.m.-10:15am",)) == Shifts(
        open=("06:00-14:30",), breaks=("10:00-10:15",)
    )
    assert Shifts(open=("12am-12pm",)).open == ("00:00-12:00",)
    assert load(TUTORIAL, {"run.start": "6:30 pm"}).run.start == "18:30"


@pytest.mark.parametrize(
    "start", ["24:00", "06:00Z", "2026-03-02T06:00+01:00", "0600", "6", "2026-03-02", "13pm", "0am"]
)
def test_a_run_starts_at_a_time_of_day_without_a_zone(start):
    with pytest.raises(ModelError, match=r"run\.start: not a time"):
        load(TUTORIAL, {"run.start": start})


@given(MANY, st.integers(1, 400))
def test_open_time_adds_up_and_is_turned_round_by_when_open(hours, until):
    by_hand = sum(hours.is_open(hour + 0.5) for hour in range(until))
    assert hours.open_time(float(until)) == pytest.approx(by_hand)
    if by_hand:
        when = hours.when_open(by_hand / 2)
        assert hours.open_time(when) == pytest.approx(by_hand / 2)


@given(MANY, st.floats(0, 400))
def test_a_change_is_where_it_opens_or_closes(hours, time):
    change = hours.changes(time)
    if math.isfinite(change):
        assert change > time
        assert hours.is_open(change) is not hours.is_open(time)
        assert hours.is_open((time + change) / 2) is hours.is_open(time)


@pytest.mark.parametrize(
    ("calendar", "message"),
    [
        ({"open": []}, "calendars.day.open: "),
        ({"open": ["6-14"]}, "no stretch of a day (got '6-14'), expected one such as '06:00-14:00'"),
        ({"open": ["06:00-06:00"]}, "it ends when it begins (got '06:00-06:00'), expected"),
        ({"open": ["06:00-14:00-15:00"]}, "no stretch of a day"),
        ({"open": ["06:00+02:00-14:00"]}, "no stretch of a day"),
        ({"open": ["06:00-24:01"]}, "no stretch of a day"),
        ({"open": ["06:00-14:00"], "breaks": ["05:00-15:00"]}, "its breaks leave nothing of it"),
        ({"every": "1 h", "lasts": "2 h"}, "longer than from one to the next"),
        ({"between": [[3, 2]]}, "it ends before it begins"),
        ({"between": [[3, 3]]}, "it ends when it begins"),
        ({"open": ["06:00-14:00"], "every": "8 h"}, "every: not in this form, expected only in a section with every"),
        ({"shift": 1}, "should be {open: "),
    ],
)
def test_an_empty_schedule_is_an_error(calendar, message):
    with pytest.raises(ModelError) as error:
        load(TUTORIAL).replace({"calendars.day": calendar})
    assert message in str(error.value)


def test_a_calendar_in_the_place_of_its_name_is_told_where_it_belongs():
    with pytest.raises(ModelError, match=r"fleet\.hours: a calendar itself .* expected the name of one of"):
        load(TUTORIAL, {"fleet.hours": {"every": "1 h", "lasts": "30 min"}})


@pytest.mark.parametrize(
    ("periods", "together"),
    [
        ((), 0),
        ((math.inf,), 0),
        ((60, 3600, math.inf), 3600),
        ((7, 24), 168),
        ((0.1, 0.25), 0.5),
        ((1, math.sqrt(2)), 100 * math.sqrt(2)),  # never: a hundred of the longest
    ],
)
def test_calendars_repeat_together_after_the_least_common_multiple_of_their_periods(periods, together):
    assert repeat_together([Hours([(0.0, 0.1)], period) for period in periods], 100) == pytest.approx(together)


def test_a_calendar_repeats_from_its_first_period_on_or_once_all_is_over():
    assert Pattern(every=10, lasts=1, first=25).hours("00:00", 1.0).repeats_from == 25
    assert Shifts(open=("06:00-14:00",)).hours("08:00", 1.0).repeats_from == 0
    assert Stretches(between=((5, 6), (8, 9))).hours("00:00", 1.0).repeats_from == 9
    assert Hours([(7.0, math.inf)]).repeats_from == 7
